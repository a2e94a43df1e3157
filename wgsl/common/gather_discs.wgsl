// Eight texels in a column of an invocation, and soft discs of the `filter` transfer that multiply
// them. CPU twin: src/cpu/accumulate.rs. Needs common/disc.wgsl, sums.wgsl, rows_8.wgsl;
// the kernel binds `opaques`.

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

fn visit_disc(view: GpuView, disc: Disc) {
    visit_rows(view, disc, 0u);
    visit_rows(view, disc, 1u);
}

fn visit_rows(view: GpuView, disc: Disc, i: u32) {
    let dx = x - disc.center.x;
    let dy = ys[i] - disc.center.y;
    let met = disc_profile(view, disc, dx, dy, opaque_depth[i]);
    let profile = met.profile;
    red[i] *= 1.0 - profile * disc.absorbed.r;
    green[i] *= 1.0 - profile * disc.absorbed.g;
    blue[i] *= 1.0 - profile * disc.absorbed.b;
    let seen = profile * disc.slope >= vec4(VISIBLE_OPACITY);
    nearest[i] = select(nearest[i], min(nearest[i], met.depth), seen);
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
