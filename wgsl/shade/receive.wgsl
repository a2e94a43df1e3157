// Light that arrives at a point through a shadow map. CPU reference:
// crates/gobo-reference/src/shading/receive.rs.

import package::bind::sampled::{filters, nearests};
import package::curve::pages::curve_light;
import package::features::NODES;
import package::records::light::GpuLight;
import package::records::material::{RECEIVES_CURVE, RECEIVES_OPAQUE, RECEIVES_OTHERS};
import package::records::view::GpuView;
import package::shade::lifted::{Lifted, Receiver, set_own_plane};
import package::shade::receiver::{is_tinted, receives, solid_depths, tint_depth};
import package::shade::taps::{filter_of, filter_tap, map_taps, next_rotation, pixel_rotation};

// Light through one texel at light depth z, by the rules of the receiver. Texels outside the view's map are
// clamped to its border. `biases`: for opaque surfaces and for translucent casters [light depth].
fn receive_texel(view: GpuView, texel: vec2<f32>, z: f32, biases: vec2<f32>) -> vec3<f32> {
    let inside = clamp(texel, vec2(0.0), view.size - 1.0);
    let tint_z = tint_depth(view, inside + 0.5, z, biases.y);
    let at = view.origin + vec2<u32>(inside);
    let solid = solid_depths(view, at);
    // Curves have no owner tags.
    if NODES > 0u && ((receives == RECEIVES_CURVE) | (receives == RECEIVES_OTHERS)) {
        return select(curve_light(view, at, tint_z), vec3(0.0), vec3(z) > solid + biases.x);
    }
    let nearest = textureLoad(nearests, at, view.layer, 0).r;
    let filtered = textureLoad(filters, at, view.layer, 0);
    let whose = select(is_tinted(filtered, nearest), receives != RECEIVES_OPAQUE, NODES > 0u);
    let tinted = (tint_z > nearest) & (nearest < 1.0) & whose;
    let passed = select(vec3(1.0), filtered.rgb, tinted);
    return select(passed, vec3(0.0), vec3(z) > solid + biases.x);
}

// Percentage-closer filter (Reeves et al. 1987): each texel is compared on its own, then weighted.
fn receive(light: GpuLight, view: GpuView, receiver: Receiver, lifted: Lifted) -> vec3<f32> {
    set_own_plane(view, receiver);
    let taps = map_taps(view, lifted.point);
    let kernel = filter_of(light);
    let biases = vec2(lifted.bias, lifted.tint_bias) / (view.far - view.near);
    var sum = vec3(0.0);
    var rotation = pixel_rotation;
    let count = select(0u, kernel.count, taps.reaches);
    var i = 0u;
    // Tested at its end: llvmpipe executes a body once more where the test comes first.
    if count > 0u {
        loop {
            let tap = filter_tap(kernel, taps, i, rotation);
            sum += receive_texel(view, tap.texel, taps.z, biases) * tap.weight;
            rotation = next_rotation(rotation);
            i += 1u;
            if i >= count {
                break;
            }
        }
    }
    return select(vec3(1.0), sum, taps.reaches);
}

// Look-up for point lights only: area lights give no penumbrae.
fn receive_light(
    light: GpuLight,
    index: u32,
    view: GpuView,
    receiver: Receiver,
    lifted: Lifted,
) -> vec3<f32> {
    return receive(light, view, receiver, lifted);
}
