// Accumulator: nearest opaque depth of some texels in a column, for opaque triangles, the usual casters of
// ground and walls. CPU reference: crates/gobo-reference/src/occlude.rs.

import package::features::unrolled;
import package::hit::triangle::{edge_products, is_inside};
import package::records::footprint::{Footprint, setup_of, setup_texel};
import package::records::texel::opaque_bits;
import package::records::view::GpuView;
import choice::column::COLUMN_TEXELS;

const ROWS: u32 = COLUMN_TEXELS; // texels that an invocation holds, in a column

struct TriangleSetup {
    a: vec4<f32>, // edges
    b: vec4<f32>,
    c: vec4<f32>,
    weights: vec3<f32>,
    ties: u32,
    depths: vec3<f32>,
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> nearest: array<f32, ROWS>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        nearest[i] = 1.0;
    }
}

fn load_triangle(setup: u32) -> TriangleSetup {
    let weights_ties = setup_texel(setup, 3u);
    return TriangleSetup(
        bitcast<vec4<f32>>(setup_texel(setup, 0u)),
        bitcast<vec4<f32>>(setup_texel(setup, 1u)),
        bitcast<vec4<f32>>(setup_texel(setup, 2u)),
        bitcast<vec3<f32>>(weights_ties.xyz),
        weights_ties.w,
        bitcast<vec3<f32>>(setup_texel(setup, 4u).xyz),
    );
}

// Light depth of the triangle at a texel, 1 where it is not.
fn triangle_depth(triangle: TriangleSetup, texel: vec2<f32>) -> f32 {
    let a = edge_products(triangle.a, texel);
    let b = edge_products(triangle.b, texel);
    let c = edge_products(triangle.c, texel);
    let e = vec3(a.x - a.y, b.x - b.y, c.x - c.y);
    let inside = is_inside(a, b, c, (vec3(triangle.ties) & vec3(1u, 2u, 4u)) != vec3(0u));
    let weighted = e * triangle.weights;
    let sum = weighted.x + weighted.y + weighted.z;
    let depth = dot(e, triangle.weights * triangle.depths) / sum;
    let counts = inside && sum > 0.0 && depth >= 0.0 && depth <= 1.0;
    return select(1.0, bitcast<f32>(opaque_bits(depth, false)), counts);
}

fn visit_triangle(triangle: TriangleSetup) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        nearest[i] = min(nearest[i], triangle_depth(triangle, corner + vec2(0.5, f32(i) + 0.5)));
    }
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    var last = 0.0;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        last = max(last, nearest[i]);
    }
    return last <= front;
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

// Whether part of the block lo..hi is on the inner side of an edge.
fn edge_touches(edge: vec4<f32>, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let far = select(lo, hi, vec2((edge.w < 0.0), (edge.z > 0.0)));
    let slack = EDGE_SLACK * (abs(edge.z) + abs(edge.w));
    return edge.z * (far.y - edge.y) - edge.w * (far.x - edge.x) >= -slack;
}

// Whether the triangle may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let box = caster.box;
    let outside = abs(box.xy - clamp(box.xy, lo, hi));
    let triangle = caster.triangle;
    return max(outside.x, outside.y) <= box.z && edge_touches(triangle.a, lo, hi)
        && edge_touches(triangle.b, lo, hi) && edge_touches(triangle.c, lo, hi);
}

// Payload that the lane broadcasts; `front`: lower bound of the triangle's depth.
fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    return caster.triangle;
}

// Visits the caster of lane `lane`.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) {
    visit_triangle(broadcast_triangle(payload, lane));
}

fn broadcast_triangle(triangle: TriangleSetup, lane: u32) -> TriangleSetup {
    return TriangleSetup(
        subgroupShuffle(triangle.a, lane),
        subgroupShuffle(triangle.b, lane),
        subgroupShuffle(triangle.c, lane),
        subgroupShuffle(triangle.weights, lane),
        subgroupShuffle(triangle.ties, lane),
        subgroupShuffle(triangle.depths, lane),
    );
}
