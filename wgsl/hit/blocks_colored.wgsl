// Channels of the light that an opaque material's hit blocks at a texel; a `dither` caster has a threshold
// per channel. CPU reference: crates/gobo-reference/src/occlude.rs.

import package::bind::uniform::materials;
import package::hit::blocks::{threshold_at, pattern_point};
import package::hit::hit::Hit;
import package::hit::object::object_of;
import package::hit::solid::is_solid;
import package::records::footprint::Footprint;
import package::records::material::TRANSFER_DITHER;
import package::records::view::GpuView;
import package::sums::sums::depth_to_nearness;

fn blocked_channels(view: GpuView, footprint: Footprint, texel: vec2<f32>, hit: Hit) -> vec3<bool> {
    if hit.depth >= 0.0 && materials[hit.material].transfer == TRANSFER_DITHER {
        let id = object_of(footprint) * 3u;
        let point = pattern_point(view, footprint, texel, hit.material);
        let thresholds = vec3(
            threshold_at(point, hit.material, id),
            threshold_at(point, hit.material, id + 1u),
            threshold_at(point, hit.material, id + 2u),
        );
        return 1.0 - hit.light > thresholds;
    }
    return vec3(is_solid(hit));
}

// Depth behind which all channels are blocked.
fn last_depth(depths: vec3<f32>) -> f32 {
    return max(max(depths.r, depths.g), depths.b);
}

fn nearnesses(depths: vec3<f32>) -> vec3<u32> {
    return vec3(depth_to_nearness(depths.r), depth_to_nearness(depths.g), depth_to_nearness(depths.b));
}
