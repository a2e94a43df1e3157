// Edge functions of a triangle in the map. CPU reference: crates/gobo-reference/src/project.rs.

fn precedes(a: vec2<f32>, b: vec2<f32>) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// Line of the edge from `a` to `b`: a point and its direction. Both triangles of a shared edge must start
// from the same corner, so that their edge functions are each other's negative to the last bit. `area`: its
// sign is the triangle's orientation.
fn edge_line(a: vec2<f32>, b: vec2<f32>, area: f32) -> vec4<f32> {
    let forward = precedes(a, b);
    let start = select(b, a, forward);
    let end = select(a, b, forward);
    return vec4(start, (end - start) * select(-1.0, 1.0, owns_edge(a, b, area)));
}

// Whether texel centres exactly on the edge from `a` to `b` belong to the triangle.
fn owns_edge(a: vec2<f32>, b: vec2<f32>, area: f32) -> bool {
    return precedes(a, b) == (area > 0.0);
}

// Distance of an edge whose line is farther away [texels]: beside it, the place of a texel makes no
// difference in 32 bits.
const FAR_EDGE: f32 = 1099511627776.0;

// Line of an edge with a corner that has no position in the map: a plane through the eye (Olano and Greer
// 1997, section 3). `a` and `b`: homogeneous corners; `turn`: its sign is the triangle's orientation.
fn edge_plane(a: vec3<f32>, b: vec3<f32>, turn: f32) -> vec4<f32> {
    let forward = precedes(a.xy, b.xy);
    let sign = select(-1.0, 1.0, forward == (turn > 0.0));
    let plane = select(cross(b, a), cross(a, b), forward) * sign;
    let along = vec2(plane.y, -plane.x);
    let constant = plane.z / FAR_EDGE;
    let foot = plane.xy * (-plane.z / dot(along, along));
    // In the plane through the eye across the axis, an edge is at infinity: its function is constant.
    let is_far = max(abs(along.x), abs(along.y)) <= abs(constant);
    return select(vec4(foot, along), vec4(0.0, -FAR_EDGE, constant, 0.0), is_far);
}

// The two products whose difference is an edge's function.
fn edge_products(line: vec4<f32>, texel: vec2<f32>) -> vec2<f32> {
    return vec2(line.z * (texel.y - line.y), line.w * (texel.x - line.x));
}

// Whether a texel is inside of all edges, by their products. These are compared, not subtracted: of a
// difference a compiler may round one product only, another one in the triangle on the other side
// (tests/stages/edges.rs).
fn is_inside(a: vec2<f32>, b: vec2<f32>, c: vec2<f32>, ties: vec3<bool>) -> bool {
    let first = vec3(a.x, b.x, c.x);
    let second = vec3(a.y, b.y, c.y);
    return all((first > second) | ((first == second) & ties));
}
