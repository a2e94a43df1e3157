// Light that the surroundings send to a surface. CPU reference: src/model/environment.rs.

import package::bind::uniform::picture_params;

// Irradiance of a surface of normal `n`, divided by pi: spherical harmonics up to order 2 (Ramamoorthi and
// Hanrahan 2001).
fn irradiance(n: vec3<f32>) -> vec3<f32> {
    let linear = coefficient(0u) + coefficient(1u) * n.y + coefficient(2u) * n.z + coefficient(3u) * n.x;
    let mixed = coefficient(4u) * (n.x * n.y) + coefficient(5u) * (n.y * n.z) + coefficient(7u) * (n.x * n.z);
    let squares = coefficient(6u) * (3.0 * n.z * n.z - 1.0) + coefficient(8u) * (n.x * n.x - n.y * n.y);
    return max(linear + mixed + squares, vec3(0.0));
}

fn coefficient(i: u32) -> vec3<f32> {
    return picture_params.irradiance[i].rgb;
}
