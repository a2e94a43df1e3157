//! Deep opacity maps (Yuksel and Keyser 2008, section 3): layers of equal thickness from a ray's first hair
//! on.
use gobo::glam::DVec3;

/// Optical depth of one texel behind each of its layers, per channel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Layers {
    first: f64,
    /// Thickness of a layer [light depth].
    thickness: f64,
    behind: Vec<DVec3>,
}

impl Layers {
    /// `stretches`: disjoint, front to back, with their optical depths; `span`: of all layers.
    pub(crate) fn new(stretches: &[([f64; 2], DVec3)], span: f64, count: usize) -> Self {
        let first = stretches.first().map_or(0.0, |(stretch, _)| stretch[0]);
        let thickness = span / count as f64;
        let behind = |layer: usize| {
            let z = first + thickness * (layer + 1) as f64;
            // The last layer holds the rest.
            let z = if layer + 1 == count { f64::INFINITY } else { z };
            let part = |[start, end]: [f64; 2]| ((z - start) / (end - start)).clamp(0.0, 1.0);
            stretches.iter().map(|&(stretch, tau)| tau * part(stretch)).sum()
        };
        Self { first, thickness, behind: (0..count).map(behind).collect() }
    }

    pub(crate) fn light_at(&self, z: f64) -> DVec3 {
        let place = ((z - self.first) / self.thickness).clamp(0.0, self.behind.len() as f64);
        let layer = (place as usize).min(self.behind.len() - 1);
        let before = if layer == 0 { DVec3::ZERO } else { self.behind[layer - 1] };
        let tau = before.lerp(self.behind[layer], place - layer as f64);
        (-tau).map(f64::exp)
    }
}
