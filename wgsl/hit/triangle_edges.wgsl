// Edge functions of a triangle in the map. CPU reference: src/reference/project.rs.

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
