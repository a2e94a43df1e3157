//! How a picture looks.

/// Occlusion of ambient light by what is seen around a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Occlusion {
    /// None: ambient light comes from everywhere.
    #[default]
    None,
    /// By what is nearer than a tenth of the picture's height at the surface's distance.
    Usual,
    /// By what is nearer than this, above 0 [m].
    Radius(f32),
}
