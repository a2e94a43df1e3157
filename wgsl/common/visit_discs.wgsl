// A soft disc of the `filter` transfer meets the four texels; hits wait for the end of their slab.
// CPU twin: src/cpu/curve/tile.rs. Needs common/gather_curve.wgsl.

// The batch's views are perspective ones.
override PERSPECTIVE: bool;

const HAS_TRIANGLES: bool = false;
const HAS_PUFFS: bool = false;

// Seen from afar a disc's depth is the same everywhere.
fn ordered() -> bool {
    return !PERSPECTIVE;
}

fn slabbed() -> bool {
    return true;
}

// True where the hits cannot wait.
fn visit(view: GpuView, place: vec4<u32>, look: vec4<u32>) -> bool {
    let center = bitcast<vec2<f32>>(place.xy);
    let radius = bitcast<f32>(place.z);
    let slope = unpack2x16float(look.y).y;
    let absorbed = slope * (1.0 - vec3(unpack2x16unorm(look.x), unpack2x16unorm(look.y).x));
    let dx = corner.x + 0.5 - center.x;
    let dy = corner.y + vec4(0.5, 1.5, 2.5, 3.5) - center.y;
    var depth = vec4(bitcast<f32>(place.w));
    var rest: vec4<f32>;
    if PERSPECTIVE {
        // As in common/gather_discs.wgsl.
        let aside = (center - view.size * 0.5) / view.scale;
        let len2 = 1.0 + dot(aside, aside);
        let tilt = aside / (len2 * view.scale);
        let turn = dx * tilt.x + dy * tilt.y;
        let t = 1.0 + turn;
        let bend = 1.0 / (radius * radius * len2 * view.scale * view.scale);
        rest = 1.0 - ((dx * dx + dy * dy) * bend - turn * turn / (radius * radius)) / (t * t);
        rest = select(vec4(0.0), max(rest, vec4(0.0)), t > vec4(0.0));
        let range = view.far - view.near;
        depth = ((view.near + depth * range) / t - view.near) / range;
        rest = select(vec4(0.0), rest, depth >= vec4(0.0) & depth <= vec4(1.0));
    } else {
        rest = max(1.0 - (dx * dx + dy * dy) / (radius * radius), vec4(0.0));
    }
    let profile = select(vec4(0.0), rest * rest, depth < opaque_depth);
    let light = Light4(
        1.0 - profile * absorbed.r,
        1.0 - profile * absorbed.g,
        1.0 - profile * absorbed.b,
    );
    return must_flush(meet(light, depth, profile * slope));
}
