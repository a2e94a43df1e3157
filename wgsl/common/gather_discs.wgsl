// Eight texels in a column of an invocation, and soft discs of the `filter` transfer that multiply
// them. CPU twin: src/cpu/accumulate.rs. Needs common/view.wgsl, sums.wgsl, tile_rect.wgsl, rows_8.wgsl; the
// kernel binds `opaques`.

// The batch's views are perspective ones.
override PERSPECTIVE: bool;
// The views have opaque casters.
override HAS_OPAQUE: bool;

struct Disc {
    center: vec2<f32>,   // [texels]
    reach: f32,          // [texels]
    bend: f32,           // 1 / radius^2 [1 / texels^2]
    tilt: vec2<f32>,     // how the plane's distance changes [1 / texels]
    tilt_bend: f32,
    depth: f32,          // light depth; of a perspective view distance along the axis [m]
    slope: f32,          // opacity at the centre
    absorbed: vec3<f32>, // slope (1 - c)
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> x: f32;            // texel centres
var<private> ys: array<vec4<f32>, 2>;
var<private> red: array<vec4<f32>, 2>; // transmittance so far
var<private> green: array<vec4<f32>, 2>;
var<private> blue: array<vec4<f32>, 2>;
var<private> nearest: array<vec4<f32>, 2>;
var<private> opaque_depth: array<vec4<f32>, 2>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    x = corner.x + 0.5;
    start_rows(view, texel, 0u);
    start_rows(view, texel, 1u);
}

fn start_rows(view: GpuView, texel: vec2<u32>, i: u32) {
    ys[i] = corner.y + f32(4u * i) + vec4(0.5, 1.5, 2.5, 3.5);
    red[i] = vec4(1.0);
    green[i] = vec4(1.0);
    blue[i] = vec4(1.0);
    nearest[i] = vec4(1.0);
    opaque_depth[i] = vec4(1.0);
    if HAS_OPAQUE {
        let at = view.origin + texel + vec2(0u, 4u * i);
        opaque_depth[i] = vec4(
            textureLoad(opaques, at, view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 1u), view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 2u), view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 3u), view.layer, 0).r,
        );
    }
}

fn prepare_disc(view: GpuView, place: vec4<u32>, look: vec4<u32>) -> Disc {
    var disc: Disc;
    let radius = bitcast<f32>(place.z);
    disc.center = bitcast<vec2<f32>>(place.xy);
    disc.depth = bitcast<f32>(place.w);
    disc.slope = unpack2x16float(look.y).y;
    let color = vec3(unpack2x16unorm(look.x), unpack2x16unorm(look.y).x);
    disc.absorbed = disc.slope * (1.0 - color);
    disc.reach = radius + SLACK;
    disc.bend = 1.0 / (radius * radius);
    if PERSPECTIVE {
        // q^2 = (|delta|^2 / scale^2 - (n . delta)^2) / (radius len t)^2, where n is the ray to
        // the centre, len its length at depth 1, t = 1 + tilt . delta.
        let slope = (disc.center - view.size * 0.5) / view.scale;
        let len2 = 1.0 + dot(slope, slope);
        disc.tilt = slope / (len2 * view.scale);
        disc.bend = 1.0 / (radius * radius * len2 * view.scale * view.scale);
        disc.tilt_bend = 1.0 / (radius * radius);
        disc.depth = view.near + disc.depth * (view.far - view.near);
        // tan(axis + cone) - tan(axis), outwards from the view's middle.
        let rest = 1.0 - sqrt(len2 - 1.0) * radius;
        disc.reach = select(1e18, view.scale * radius * len2 / rest + SLACK, rest > 0.0);
    }
    return disc;
}

fn visit_disc(view: GpuView, disc: Disc) {
    visit_rows(view, disc, 0u);
    visit_rows(view, disc, 1u);
}

fn visit_rows(view: GpuView, disc: Disc, i: u32) {
    let dx = x - disc.center.x;
    let dy = ys[i] - disc.center.y;
    var rest: vec4<f32>;
    var depth = vec4(disc.depth);
    if PERSPECTIVE {
        let turn = dx * disc.tilt.x + dy * disc.tilt.y;
        let t = 1.0 + turn;
        rest = 1.0 - ((dx * dx + dy * dy) * disc.bend - turn * turn * disc.tilt_bend) / (t * t);
        rest = select(vec4(0.0), max(rest, vec4(0.0)), t > vec4(0.0));
        depth = (disc.depth / t - view.near) / (view.far - view.near);
        rest = select(vec4(0.0), rest, depth >= vec4(0.0) & depth <= vec4(1.0));
    } else {
        rest = max(1.0 - (dx * dx + dy * dy) * disc.bend, vec4(0.0));
    }
    let profile = select(vec4(0.0), rest * rest, depth < opaque_depth[i]);
    red[i] *= 1.0 - profile * disc.absorbed.r;
    green[i] *= 1.0 - profile * disc.absorbed.g;
    blue[i] *= 1.0 - profile * disc.absorbed.b;
    let seen = profile * disc.slope >= vec4(VISIBLE_OPACITY);
    nearest[i] = select(nearest[i], min(nearest[i], depth), seen);
}

fn passed_texel(i: u32) -> vec3<f32> {
    return vec3(red[i / 4u][i % 4u], green[i / 4u][i % 4u], blue[i / 4u][i % 4u]);
}

fn nearest_texel(i: u32) -> f32 {
    return nearest[i / 4u][i % 4u];
}

// Nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    return settled_rows(front, 0u) && settled_rows(front, 1u);
}

fn settled_rows(front: f32, i: u32) -> bool {
    let light = max(max(red[i], green[i]), blue[i]);
    let open = (light >= vec4(BLACK) | nearest[i] > vec4(front)) & opaque_depth[i] > vec4(front);
    return !any(open);
}

// Batches of plain discs are not asked for it.
fn owner_texel(i: u32) -> u32 {
    return NO_OWNER;
}
