//! Lights as a scene describes them.
use glam::Vec3;

/// Where a light is and where it shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel rays that travel along `direction` (unit, world space).
    Directional { direction: Vec3 },
    /// A cone: `angle` is the whole cone [radians].
    Spot { position: Vec3, direction: Vec3, angle: f32 },
    /// All around.
    Point { position: Vec3 },
}

#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    pub name: String,
    pub kind: LightKind,
    /// Linear rgb.
    pub color: Vec3,
    /// Irradiance of a directional light at normal incidence; intensity of the others, which falls
    /// off with the square of the distance [m].
    pub intensity: f32,
    /// First and last depth of the shadow views [m]; chosen from the bounds when `None`.
    pub near: Option<f32>,
    pub far: Option<f32>,
    /// Of each view's map [texels]; the scene's when `None`.
    pub size: Option<u32>,
    /// Whether the light has shadow views at all.
    pub casts: bool,
    /// Of a directional light, 1..=6.
    pub cascades: u32,
    /// Whether the air scatters its light, where the scene has any.
    pub shafts: bool,
}

impl Light {
    /// Shadow views that the light needs.
    pub fn view_count(&self) -> usize {
        match self.kind {
            _ if !self.casts => 0,
            LightKind::Directional { .. } | LightKind::Spot { .. } => 1,
            LightKind::Point { .. } => 6,
        }
    }
}
