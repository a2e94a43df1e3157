//! import: the host's depth to light depth. WGSL: `wgsl/import/import.wgsl`.
use glam::{UVec2, Vec2, Vec4, Vec4Swizzles as _};
use gobo::records::ImportParams;

/// Ray of our map in the host's clip space: along the ray through a point of our map, the host's clip
/// coordinates are `slope * distance + start`; `distance` is along our axis \[m\].
#[derive(Clone, Copy, Debug)]
pub struct ClipRay {
    slope: Vec4,
    start: Vec4,
}

impl ClipRay {
    /// The ray through `texel`, a point of our map \[texels\].
    pub fn new(params: &ImportParams, texel: Vec2) -> Self {
        let across = (texel - params.size * 0.5) / params.scale * Vec2::new(1.0, -1.0);
        let clip = params.clip_from_view;
        if params.perspective > 0.0 {
            let slope = clip * across.extend(-1.0).extend(0.0);
            return Self { slope, start: clip.w_axis };
        }
        Self { slope: -clip.z_axis, start: clip * across.extend(0.0).extend(1.0) }
    }

    /// Texel of the ray in the host's map.
    pub fn host_texel(&self, params: &ImportParams) -> UVec2 {
        let seen = self.slope * params.far + self.start;
        let place =
            (seen.xy() / seen.w * Vec2::new(0.5, -0.5) + Vec2::splat(0.5)) * params.host_size;
        place.clamp(Vec2::ZERO, params.host_size - 1.0).as_uvec2()
    }

    /// Light depth of a host's depth: 1 without a surface, or for one beyond the far plane; a surface in
    /// front of the near plane blocks light, too.
    pub fn light_depth(&self, params: &ImportParams, depth: f32) -> f32 {
        let Self { slope, start } = self;
        let distance = (depth * start.w - start.z) / (slope.z - depth * slope.w);
        let light_depth = (distance - params.near) / (params.far - params.near);
        // A NaN is no surface.
        if depth != params.empty && light_depth <= 1.0 { light_depth.max(0.0) } else { 1.0 }
    }
}
