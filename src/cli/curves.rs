//! Curves as `NumPy` arrays and preview images.
use gobo::{glam::Vec3, internals::records::CurveMap};

/// Numbers of a node: start, end, red, green, blue.
pub(super) const FIELDS: usize = 5;

/// Start of an unused node: behind the far plane.
const UNUSED: f32 = 2.0;

/// Depths over which a preview averages the light.
const STEPS: usize = 16;

/// Values of all nodes of all texels: in each texel used nodes first, in their order; unused ones have the
/// light behind the last one.
pub(super) fn values(curve: &CurveMap) -> impl ExactSizeIterator<Item = f32> {
    let mut values = Vec::with_capacity(curve.packed.len() * FIELDS);
    for texel in 0..curve.texel_count() {
        let mut behind = Vec3::ONE;
        let mut unused = curve.nodes;
        for (start, end, light) in curve.ramps(texel) {
            values.extend([start, end, light.x, light.y, light.z]);
            (behind, unused) = (light, unused - 1);
        }
        for _ in 0..unused {
            values.extend([UNUSED, UNUSED, behind.x, behind.y, behind.z]);
        }
    }
    values.into_iter()
}

/// Mean light of each texel from the first start of all nodes to their last end.
pub(super) fn preview(curve: &CurveMap) -> Vec<[f32; 3]> {
    let texels = 0..curve.texel_count();
    let ramps = texels.clone().flat_map(|texel| curve.ramps(texel));
    let (first, last) = ramps.fold((1.0, 0.0), |(first, last): (f32, f32), (start, end, _)| {
        (first.min(start), last.max(end))
    });
    let depths = (0..STEPS).map(|i| first + (last - first) * (i as f32 + 0.5) / STEPS as f32);
    let mean = |texel| {
        let sum: Vec3 = depths.clone().map(|z| curve.light_at(texel, z)).sum();
        (sum / STEPS as f32).to_array()
    };
    texels.map(mean).collect()
}
