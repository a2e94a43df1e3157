//! Tolerances of GPUs, whose compilers contract `a*b + c` to one rounding and whose samplers decode bytes
//! with fewer bits; software adapters do neither. Where a test compares with the CPU reference, or one kernel
//! with another, it has a tolerance for each, [on software adapters, on GPUs], beside the reason for the
//! second. An H100 ran the suite with those for software adapters: tests that it failed have a wider one.
use gobo::{gpu::Gpu, records::ViewMaps, wgpu::DeviceType};

/// Most by which an image changes light: samplers may decode sRGB bytes within half a step of 8 bits. (One
/// channel of one texel below images was off by .0013, where discs without images were within .001.)
pub(crate) const DECODED: [f64; 2] = [0.0, 1.0 / 510.0];
/// Share of a mixture's texels that rounding decides, at edges and opacities of 1/255: .00107 with 12
/// triangles.
pub(crate) const MIXED: [f64; 2] = [5e-5, 2e-3];
/// Share in maps of an atlas: 4 texels of a cube's face of 40 x 40, of which .002 are three.
pub(crate) const IN_ATLAS: [f64; 2] = [2e-3, 5e-3];
/// Share of texels of dithered casters, whose pattern a rounded opacity passes or not.
pub(crate) const DITHERED: [f64; 2] = [1e-4, 1e-3];
/// Share of texels that two kernels of one map may draw otherwise on GPUs: each is contracted in its own way,
/// and depths of the same disc had other last bits. None on software adapters.
pub(crate) const FORMS: f64 = 1e-3;
/// Share of texels that may differ on GPUs below particles whose radii a kernel calculated in one case and
/// the CPU in the other: discs differ by a millionth, and few edges cross a texel's middle. None on software
/// adapters.
pub(crate) const LOADED: f64 = 1e-2;

/// Light of a texel that kernels contract in two ways: two steps of halves below 1.
const LIGHT: f32 = 1.0 / 1024.0;
/// Depths of a texel: a few roundings of 32 bits.
const DEPTH: f32 = 2e-6;

/// Whether kernels round as the CPU reference does.
pub(crate) fn rounds_as_the_cpu(gpu: &Gpu) -> bool {
    gpu.adapter.device_type == DeviceType::Cpu
}

/// A tolerance on a device.
pub(crate) fn on(gpu: &Gpu, [software, hardware]: [f64; 2]) -> f64 {
    if rounds_as_the_cpu(gpu) { software } else { hardware }
}

/// Compares maps, curves left out, that two kernels have rounded in two ways; `share`: of texels that may
/// differ by more.
pub(crate) fn nearly_same(
    found: &[ViewMaps],
    expected: &[ViewMaps],
    share: f64,
) -> Result<(), String> {
    let (mut apart, mut texels) = (0, 0);
    for (a, b) in found.iter().zip(expected) {
        let counts = [a, b].map(|maps| [maps.filter.len(), maps.nearest.len(), maps.opaque.len()]);
        if counts[0] != counts[1] {
            return Err(format!("{counts:?} texels"));
        }
        let near = |a: f32, b: f32, most: f32| (a - b).abs() <= most;
        let is_near = |i: &usize| {
            (0..3).all(|c| near(a.filter[*i][c], b.filter[*i][c], LIGHT))
                && near(a.nearest[*i], b.nearest[*i], DEPTH)
                && near(a.opaque[*i], b.opaque[*i], DEPTH)
        };
        texels += a.filter.len();
        apart += (0..a.filter.len()).filter(|i| !is_near(i)).count();
    }
    if found.len() != expected.len() || apart as f64 > share * texels as f64 {
        return Err(format!("{apart} of {texels} texels in {} maps", found.len()));
    }
    Ok(())
}
