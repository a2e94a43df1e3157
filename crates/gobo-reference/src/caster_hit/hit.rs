//! Result of a ray's test against a caster: a hit, or the face of a volume.
use glam::{IVec3, Vec2, Vec3};
use gobo::records::{FIXED_ONE, GpuView};

/// Hit of a ray: light `L` from the light's side becomes `L * light + added`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Transmittance, per channel.
    pub light: Vec3,
    /// 1 - transmittance, in full precision where the transmittance is close to 1.
    pub absorbed: Vec3,
    /// Light added by `over`, per channel.
    pub added: Vec3,
    /// Colour `c`; divided by 16 for `gain`.
    pub color: Vec3,
    /// Opacity `a`.
    pub opacity: f32,
    /// Strength by which the hit sets depths: the opacity, or the light that `stain` and `gain` change
    /// without opacity.
    pub presence: f32,
    /// Light depth, 0..=1.
    pub depth: f32,
    /// Ramp of the hit in a curve, in light depth: behind its end, the whole hit is in front.
    pub start: f32,
    /// Light depth from which on the whole hit is in front.
    pub end: f32,
}

/// Crossing of a ray with the surface of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceCrossing {
    /// Light depth, at most that of the ray's end.
    pub depth: f32,
    /// Length of the ray from light depth 0 to 1 \[m\].
    pub metres: f32,
    /// Absorption coefficient of the volume [1/m].
    pub absorption: Vec3,
    /// 1 if the ray leaves the volume, -1 if it enters.
    pub leaves: i32,
}

/// Contribution of a volume's face to a ray's sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Optical depth from the near plane to the face, in fixed point and modulo 2^32; negative for a face
    /// towards the light.
    pub tau: IVec3,
    /// 1 if the ray leaves the volume, -1 if it enters.
    pub leaves: i32,
}

impl SurfaceCrossing {
    /// The face's part in the sums of a ray.
    pub fn crossing(&self) -> Crossing {
        let tau = modular(self.depth * self.metres * self.absorption * FIXED_ONE) * self.leaves;
        Crossing { tau, leaves: self.leaves }
    }
}

/// Length of the ray through a texel from light depth 0 to 1 \[m\].
pub fn metres_per_depth(view: &GpuView, texel: Vec2) -> f32 {
    let slope = (texel - view.size * 0.5) / view.scale;
    let stretch = if view.perspective > 0.0 { (1.0 + slope.length_squared()).sqrt() } else { 1.0 };
    (view.far - view.near) * stretch
}

/// Nearest integers, modulo 2^32. Exact: the moduli are powers of two.
fn modular(v: Vec3) -> IVec3 {
    const WRAP: f32 = 4_294_967_296.0;
    let rounded = v.round();
    let rest = rounded - (rounded / WRAP).floor() * WRAP;
    IVec3::from_array(rest.to_array().map(|v| (v as u32).cast_signed()))
}
