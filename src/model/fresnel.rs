//! What the faces of glass reflect.

/// What a triangle's surface reflects of the light that meets it, and so takes from its beam: Fresnel's
/// formulas for light that is not polarised, at the angle between the straight ray and the triangle's plane.
/// The colour `c` of a hit is multiplied by what is left. Indices of refraction are 1 to 3; 1 reflects
/// nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Fresnel {
    /// Nothing: the table of transfers alone.
    #[default]
    None,
    /// A face between air and a body: 4 % head-on at an index of 1.5.
    Face {
        /// Index of refraction of the body.
        ior: f32,
    },
    /// A thin pane, both its faces and all that is reflected between them: 7.7 % head-on at an index of 1.5.
    Pane {
        /// Index of refraction of the pane.
        ior: f32,
    },
}

impl Fresnel {
    /// The index of refraction, 1 without.
    pub(crate) fn ior(self) -> f32 {
        match self {
            Self::None => 1.0,
            Self::Face { ior } | Self::Pane { ior } => ior,
        }
    }

    /// The index of refraction of a face, minus that of a pane; 0 where nothing is reflected.
    pub fn index(self) -> f32 {
        match self {
            Self::Face { ior } if ior > 1.0 => ior,
            Self::Pane { ior } if ior > 1.0 => -ior,
            _ => 0.0,
        }
    }
}
