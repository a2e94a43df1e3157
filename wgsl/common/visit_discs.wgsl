// A soft disc of the `filter` transfer meets the four texels; hits wait for the end of their slab.
// CPU twin: src/cpu/curve/tile.rs. Needs common/gather_curve.wgsl.

// The batch's views are perspective ones.
override PERSPECTIVE: bool;
// The views have opaque casters.
override HAS_OPAQUE: bool;

const HAS_TRIANGLES: bool = false;
const HAS_PUFFS: bool = false;

// Seen from afar a disc's depth is the same everywhere.
fn ordered() -> bool {
    return !PERSPECTIVE;
}

fn blocked() -> bool {
    return HAS_OPAQUE;
}

fn slabbed() -> bool {
    return true;
}

struct Disc {
    center: vec2<f32>,   // [texels]
    bend: f32,           // 1 / radius^2 [1 / texels^2]
    depth: f32,          // light depth; of a perspective view distance along the axis [m]
    tilt: vec2<f32>,     // how the plane's distance changes [1 / texels]
    tilt_bend: f32,
    slope: f32,          // opacity at the centre
    absorbed: vec3<f32>, // slope (1 - c)
}

// As in common/gather_discs.wgsl.
fn prepare_disc(view: GpuView, place: vec4<u32>, look: vec4<u32>) -> Disc {
    var disc: Disc;
    let radius = bitcast<f32>(place.z);
    disc.center = bitcast<vec2<f32>>(place.xy);
    disc.depth = bitcast<f32>(place.w);
    disc.slope = unpack2x16float(look.y).y;
    disc.absorbed = disc.slope * (1.0 - vec3(unpack2x16unorm(look.x), unpack2x16unorm(look.y).x));
    disc.bend = 1.0 / (radius * radius);
    if PERSPECTIVE {
        let aside = (disc.center - view.size * 0.5) / view.scale;
        let len2 = 1.0 + dot(aside, aside);
        disc.tilt = aside / (len2 * view.scale);
        disc.bend = 1.0 / (radius * radius * len2 * view.scale * view.scale);
        disc.tilt_bend = 1.0 / (radius * radius);
        disc.depth = view.near + disc.depth * (view.far - view.near);
    }
    return disc;
}

fn visit_disc(view: GpuView, disc: Disc) -> vec4<bool> {
    let dx = corner.x + 0.5 - disc.center.x;
    let dy = corner.y + vec4(0.5, 1.5, 2.5, 3.5) - disc.center.y;
    var depth = vec4(disc.depth);
    var rest: vec4<f32>;
    if PERSPECTIVE {
        let turn = dx * disc.tilt.x + dy * disc.tilt.y;
        let t = 1.0 + turn;
        rest = 1.0 - ((dx * dx + dy * dy) * disc.bend - turn * turn * disc.tilt_bend) / (t * t);
        rest = select(vec4(0.0), max(rest, vec4(0.0)), t > vec4(0.0));
        depth = (disc.depth / t - view.near) / (view.far - view.near);
        rest = select(vec4(0.0), rest, (depth >= vec4(0.0)) & (depth <= vec4(1.0)));
    } else {
        rest = max(1.0 - (dx * dx + dy * dy) * disc.bend, vec4(0.0));
    }
    var profile = rest * rest;
    if HAS_OPAQUE {
        profile = select(vec4(0.0), profile, depth < opaque_depth);
    }
    let light = Light4(
        1.0 - profile * disc.absorbed.r,
        1.0 - profile * disc.absorbed.g,
        1.0 - profile * disc.absorbed.b,
    );
    return meet(light, depth, profile * disc.slope);
}

// True where the hits cannot wait.
fn visit(view: GpuView, place: vec4<u32>, look: vec4<u32>) -> bool {
    return must_flush(visit_disc(view, prepare_disc(view, place, look)));
}
