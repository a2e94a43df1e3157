// Accumulator: nearest opaque depth of four or eight texels in a column, for opaque triangles, the usual casters of
// ground and walls. CPU reference: src/reference/occlude.rs.

import package::records::footprint::{Footprint, setup_of};
import package::records::opaque_depth::whole_depths;
import package::records::setup::setup_texel;
import package::records::view::GpuView;
import choice::column::{COLUMN_TEXELS, FOURS};

const ROWS: u32 = COLUMN_TEXELS; // texels that an invocation holds, in a column
const LAST: u32 = FOURS - 1u; // of its fours

struct TriangleSetup {
    edges: array<vec4<f32>, 3>,
    weights: vec3<f32>,
    ties: u32,
    depths: vec3<f32>,
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> nearest: array<vec4<f32>, FOURS>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest[0] = vec4(1.0);
    nearest[LAST] = vec4(1.0);
}

fn load_triangle(setup: u32) -> TriangleSetup {
    var triangle: TriangleSetup;
    for (var i = 0u; i < 3u; i += 1u) {
        triangle.edges[i] = bitcast<vec4<f32>>(setup_texel(setup, i));
    }
    let weights_ties = setup_texel(setup, 3u);
    triangle.weights = bitcast<vec3<f32>>(weights_ties.xyz);
    triangle.ties = weights_ties.w;
    triangle.depths = bitcast<vec3<f32>>(setup_texel(setup, 4u).xyz);
    return triangle;
}

fn visit_triangle(triangle: TriangleSetup) {
    visit_rows(triangle, 0u);
    if FOURS > 1u {
        visit_rows(triangle, LAST);
    }
}

fn edge_rows(edge: vec4<f32>, ys: vec4<f32>) -> vec4<f32> {
    return edge.z * (ys - edge.y) - edge.w * (corner.x + 0.5 - edge.x);
}

fn within(e: vec4<f32>, tie: bool) -> vec4<bool> {
    return (e > vec4(0.0)) | ((e == vec4(0.0)) & vec4(tie));
}

fn visit_rows(triangle: TriangleSetup, i: u32) {
    let ys = corner.y + f32(4u * i) + vec4(0.5, 1.5, 2.5, 3.5);
    let a = edge_rows(triangle.edges[0], ys);
    let b = edge_rows(triangle.edges[1], ys);
    let c = edge_rows(triangle.edges[2], ys);
    let inside = within(a, (triangle.ties & 1u) != 0u) & within(b, (triangle.ties & 2u) != 0u)
        & within(c, (triangle.ties & 4u) != 0u);
    let weighted = triangle.weights * triangle.depths;
    let sum = a * triangle.weights.x + b * triangle.weights.y + c * triangle.weights.z;
    let depth = (a * weighted.x + b * weighted.y + c * weighted.z) / sum;
    let stored = whole_depths(depth);
    let counts = inside & (sum > vec4(0.0)) & (depth >= vec4(0.0)) & (depth <= vec4(1.0));
    nearest[i] = select(nearest[i], min(nearest[i], stored), counts);
}

fn nearest_texel(i: u32) -> f32 {
    return nearest[i / 4u][i % 4u];
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    return all(nearest[0] <= vec4(front)) && all(nearest[LAST] <= vec4(front));
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    visit_triangle(load_triangle(setup_of(footprint)));
}

struct LaneCaster {
    triangle: TriangleSetup,
    box: vec3<f32>, // centre and half edge
}

alias Payload = TriangleSetup;

fn lane_caster_of(id: u32, footprint: Footprint) -> LaneCaster {
    return LaneCaster(load_triangle(setup_of(footprint)), footprint.bounds.xyz);
}

const EDGE_SLACK: f32 = 0.001; // [texels], for rounding

// Whether some of the block lo..hi is on the inner side of an edge.
fn edge_touches(edge: vec4<f32>, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let far = select(lo, hi, vec2((edge.w < 0.0), (edge.z > 0.0)));
    let slack = EDGE_SLACK * (abs(edge.z) + abs(edge.w));
    return edge.z * (far.y - edge.y) - edge.w * (far.x - edge.x) >= -slack;
}

// Whether the triangle may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let box = caster.box;
    let outside = abs(box.xy - clamp(box.xy, lo, hi));
    let edges = caster.triangle.edges;
    return max(outside.x, outside.y) <= box.z && edge_touches(edges[0], lo, hi)
        && edge_touches(edges[1], lo, hi) && edge_touches(edges[2], lo, hi);
}

// Payload that the lane broadcasts; `front` bounds its depth from below.
fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    return caster.triangle;
}

// Visits the caster of lane `lane`.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) {
    visit_triangle(broadcast_triangle(payload, lane));
}

fn broadcast_triangle(triangle: TriangleSetup, j: u32) -> TriangleSetup {
    var other: TriangleSetup;
    for (var i = 0u; i < 3u; i += 1u) {
        other.edges[i] = subgroupShuffle(triangle.edges[i], j);
    }
    other.weights = subgroupShuffle(triangle.weights, j);
    other.ties = subgroupShuffle(triangle.ties, j);
    other.depths = subgroupShuffle(triangle.depths, j);
    return other;
}
