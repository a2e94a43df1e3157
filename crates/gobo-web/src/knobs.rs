//! Camera and sun that a visitor turns.
use gobo::{
    Camera, Light, LightKind, Receiver,
    glam::{Quat, Vec3},
};

/// Steepest view from above or below [radians].
const STEEPEST: f32 = 1.55;
/// Range of [`Knobs::zoom`].
const ZOOMS: (f32, f32) = (0.05, 20.0);
/// Lowest sun over the horizon [radians].
const LOWEST: f32 = 0.06;

/// Changes by a visitor, relative to the first picture of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knobs {
    /// Angle by which the camera is turned about its target \[radians\].
    pub turn: f32,
    /// Angle by which it is lifted \[radians\].
    pub lift: f32,
    /// Its distance, as a multiple of the first picture's.
    pub zoom: f32,
    /// Angle by which the first light is turned about the vertical \[radians\].
    pub sun_turn: f32,
    /// Angle by which it is lifted \[radians\].
    pub sun_lift: f32,
    /// Receiver: the curve or the nearest depth.
    pub receiver: Receiver,
}

impl Default for Knobs {
    fn default() -> Self {
        Self {
            turn: 0.0,
            lift: 0.0,
            zoom: 1.0,
            sun_turn: 0.0,
            sun_lift: 0.0,
            receiver: Receiver::Curve,
        }
    }
}

/// The vector turned about `up` and lifted; its angle over the horizon stays within a range [radians].
fn turned(vector: Vec3, up: Vec3, turn: f32, lift: f32, within: (f32, f32)) -> Vec3 {
    let length = vector.length();
    let height = (vector.dot(up) / length.max(f32::MIN_POSITIVE)).clamp(-1.0, 1.0).asin();
    let flat = (vector - vector.dot(up) * up).normalize_or(up.any_orthonormal_vector());
    let (low, high) = (within.0.min(height), within.1.max(height));
    let (sine, cosine) = (height + lift).clamp(low, high).sin_cos();
    (Quat::from_axis_angle(up, turn) * flat * cosine + up * sine) * length
}

impl Knobs {
    /// The camera; `first`: that of the first picture.
    pub fn camera(&self, first: &Camera, size: [u32; 2]) -> Camera {
        let up = first.up.normalize_or(Vec3::Y);
        let away = first.eye - first.target;
        let range = (-STEEPEST, STEEPEST);
        let away = turned(away, up, self.turn, self.lift, range);
        let zoom = self.zoom.clamp(ZOOMS.0, ZOOMS.1);
        let aspect = first.size.x as f32 / first.size.y as f32;
        let own = size[0] as f32 / size[1] as f32;
        // A narrow picture shows the same width.
        let widened = (aspect / own).max(1.0);
        let fov_y = 2.0 * ((first.fov_y * 0.5).tan() * widened).atan();
        Camera {
            eye: first.target + away * zoom,
            fov_y: fov_y.min(2.6),
            size: size.into(),
            ..*first
        }
    }

    /// The light; `first`: that of the first picture; lamps turn about `middle`.
    pub fn light(&self, first: &Light, middle: Vec3) -> Light {
        if self.sun_turn == 0.0 && self.sun_lift == 0.0 {
            return first.clone();
        }
        let up = Vec3::Y;
        let of_sun =
            |toward: Vec3| turned(toward, up, self.sun_turn, self.sun_lift, (LOWEST, STEEPEST));
        let of_lamp = |position: Vec3| {
            let range = (-STEEPEST, STEEPEST);
            middle + turned(position - middle, up, self.sun_turn, self.sun_lift, range)
        };
        let kind = match first.kind {
            LightKind::Directional { direction } => {
                LightKind::Directional { direction: -of_sun(-direction) }
            }
            LightKind::Spot { position, direction, angle } => {
                let place = of_lamp(position);
                let aimed = Quat::from_rotation_arc(
                    (middle - position).normalize_or(Vec3::NEG_Y),
                    (middle - place).normalize_or(Vec3::NEG_Y),
                );
                LightKind::Spot { position: place, direction: aimed * direction, angle }
            }
            LightKind::Point { position } => LightKind::Point { position: of_lamp(position) },
        };
        Light { kind, ..first.clone() }
    }
}
