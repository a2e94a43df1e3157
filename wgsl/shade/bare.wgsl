// First look at the texels of a look-up: their depths, without filters and without the receiver's plane. It
// suffices where no translucent caster is. For devices where a branch costs what it skips.

import package::bind::sampled::{nearests, opaques};
import package::bind::uniform::picture_params;
import package::records::view::GpuView;
import package::shade::taps::{Filter, Taps, filter_tap, next_rotation, pixel_rotation};

// Nearest depth of a texel without translucent casters.
const NO_CASTER: f32 = 1.0;

// Opaque depth of a texel, per channel.
fn solid_depths(view: GpuView, at: vec2<u32>) -> vec3<f32> {
    let depths = textureLoad(opaques, at, view.layer, 0).rgb;
    return select(depths.rrr, depths, picture_params.colored != 0u);
}

// What opaque casters alone let through.
struct Bare {
    light: vec3<f32>,
    is_all: bool, // no lit texel has a translucent caster
}

// Reads a texel's filter and the receiver's plane for none of `count` texels.
fn receive_bare(kernel: Filter, taps: Taps, count: u32, view: GpuView, bias: f32) -> Bare {
    var light = vec3(0.0);
    var is_all = true;
    var rotation = pixel_rotation;
    var i = 0u;
    if count > 0u {
        loop {
            let tap = filter_tap(kernel, taps, i, rotation);
            let at = view.origin + vec2<u32>(clamp(tap.texel, vec2(0.0), view.size - 1.0));
            let is_dark = vec3(taps.z) > solid_depths(view, at) + bias;
            light += select(vec3(1.0), vec3(0.0), is_dark) * tap.weight;
            is_all = is_all && (all(is_dark) || textureLoad(nearests, at, view.layer, 0).r >= NO_CASTER);
            rotation = next_rotation(rotation);
            i += 1u;
            if i >= count {
                break;
            }
        }
    }
    return Bare(light, is_all);
}
