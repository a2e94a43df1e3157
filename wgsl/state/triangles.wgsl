// Eight texels in a column of an invocation, and opaque triangles that lower their depth: what most
// ground and walls are made of, with all else compiled away. CPU twin: src/reference/occlude.rs.

import package::records::opaque_depth::whole_depths;
import package::records::setup::setup_texel;
import package::records::view::GpuView;

const ROWS: u32 = 8u; // texels that an invocation holds, in a column

struct Sheet {
    edges: array<vec4<f32>, 3>,
    weights: vec3<f32>,
    ties: u32,
    depths: vec3<f32>,
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> nearest: array<vec4<f32>, 2>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest[0] = vec4(1.0);
    nearest[1] = vec4(1.0);
}

fn load_sheet(setup: u32) -> Sheet {
    var sheet: Sheet;
    for (var i = 0u; i < 3u; i += 1u) {
        sheet.edges[i] = bitcast<vec4<f32>>(setup_texel(setup, i));
    }
    let weights_ties = setup_texel(setup, 3u);
    sheet.weights = bitcast<vec3<f32>>(weights_ties.xyz);
    sheet.ties = weights_ties.w;
    sheet.depths = bitcast<vec3<f32>>(setup_texel(setup, 4u).xyz);
    return sheet;
}

fn visit_sheet(sheet: Sheet) {
    visit_rows(sheet, 0u);
    visit_rows(sheet, 1u);
}

fn edge_rows(edge: vec4<f32>, ys: vec4<f32>) -> vec4<f32> {
    return edge.z * (ys - edge.y) - edge.w * (corner.x + 0.5 - edge.x);
}

fn within(e: vec4<f32>, tie: bool) -> vec4<bool> {
    return (e > vec4(0.0)) | ((e == vec4(0.0)) & vec4(tie));
}

fn visit_rows(sheet: Sheet, i: u32) {
    let ys = corner.y + f32(4u * i) + vec4(0.5, 1.5, 2.5, 3.5);
    let a = edge_rows(sheet.edges[0], ys);
    let b = edge_rows(sheet.edges[1], ys);
    let c = edge_rows(sheet.edges[2], ys);
    let inside = within(a, (sheet.ties & 1u) != 0u) & within(b, (sheet.ties & 2u) != 0u)
        & within(c, (sheet.ties & 4u) != 0u);
    let weighted = sheet.weights * sheet.depths;
    let sum = a * sheet.weights.x + b * sheet.weights.y + c * sheet.weights.z;
    let depth = (a * weighted.x + b * weighted.y + c * weighted.z) / sum;
    let stored = whole_depths(depth);
    let counts = inside & (sum > vec4(0.0)) & (depth >= vec4(0.0)) & (depth <= vec4(1.0));
    nearest[i] = select(nearest[i], min(nearest[i], stored), counts);
}

fn nearest_texel(i: u32) -> f32 {
    return nearest[i / 4u][i % 4u];
}

// Nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    return all(nearest[0] <= vec4(front)) && all(nearest[1] <= vec4(front));
}

fn visit(view: GpuView, footprint: u32, place: vec4<u32>, look: vec4<u32>) {
    visit_sheet(load_sheet(look.x));
}

struct Candidate {
    sheet: Sheet,
    box: vec3<f32>, // centre and half edge
}

fn candidate(footprint: u32, place: vec4<u32>, look: vec4<u32>) -> Candidate {
    return Candidate(load_sheet(look.x), bitcast<vec3<f32>>(place.xyz));
}

const EDGE_SLACK: f32 = 0.001; // [texels], for rounding

// Whether an edge has some of the block lo..hi on its inner side.
fn edge_touches(edge: vec4<f32>, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let far = select(lo, hi, vec2((edge.w < 0.0), (edge.z > 0.0)));
    let slack = EDGE_SLACK * (abs(edge.z) + abs(edge.w));
    return edge.z * (far.y - edge.y) - edge.w * (far.x - edge.x) >= -slack;
}

// Whether the triangle may touch texel centres in the box lo..hi.
fn touches(view: GpuView, own: Candidate, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let outside = abs(own.box.xy - clamp(own.box.xy, lo, hi));
    return max(outside.x, outside.y) <= own.box.z && edge_touches(own.sheet.edges[0], lo, hi)
        && edge_touches(own.sheet.edges[1], lo, hi) && edge_touches(own.sheet.edges[2], lo, hi);
}

// What another lane holds.
fn visit_lane(view: GpuView, own: Candidate, lane: u32) {
    visit_sheet(broadcast_sheet(own.sheet, lane));
}

fn broadcast_sheet(sheet: Sheet, j: u32) -> Sheet {
    var other: Sheet;
    for (var i = 0u; i < 3u; i += 1u) {
        other.edges[i] = subgroupShuffle(sheet.edges[i], j);
    }
    other.weights = subgroupShuffle(sheet.weights, j);
    other.ties = subgroupShuffle(sheet.ties, j);
    other.depths = subgroupShuffle(sheet.depths, j);
    return other;
}
