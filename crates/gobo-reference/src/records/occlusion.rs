//! Radius of ambient occlusion.
use gobo::model::Occlusion;

/// Radius around a surface in which others occlude, if the scene states none \[heights of the picture\].
const USUAL_RADIUS: f32 = 0.1;

/// Radius around a surface in which others occlude ambient light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcclusionRadius {
    /// Everywhere \[m\].
    pub metres: f32,
    /// Added to it, times the distance along the camera's axis.
    pub per_distance: f32,
}

impl OcclusionRadius {
    /// `fov_y`: of the camera \[radians\]; `None` without occlusion.
    pub fn new(occlusion: Occlusion, fov_y: f32) -> Option<Self> {
        match occlusion {
            Occlusion::None => None,
            Occlusion::Usual => {
                let height = 2.0 * (fov_y * 0.5).tan();
                Some(Self { metres: 0.0, per_distance: USUAL_RADIUS * height })
            }
            Occlusion::Radius(metres) => Some(Self { metres, per_distance: 0.0 }),
        }
    }
}
