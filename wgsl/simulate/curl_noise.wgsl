// Velocity of turbulent air (curl noise). CPU reference: src/model/emitter.rs.

import package::hit::hash::pcg;

// Velocity of divergence-free turbulence: the cross product of two noise gradients (DeWolf 2005), of
// magnitude about 1.
fn curl_noise(at: vec3<f32>, seed: u32) -> vec3<f32> {
    return cross(noise_gradient(at, seed), noise_gradient(at, seed ^ 0x9e3779b9u)) * 0.875;
}

fn corner_value(cell: vec3<i32>, seed: u32) -> f32 {
    let corner = bitcast<vec3<u32>>(cell);
    return f32(pcg(corner.x ^ pcg(corner.y ^ pcg(corner.z ^ seed))) >> 8u) / 8388608.0 - 1.0;
}

// Gradient of value noise with values -1..1 at the lattice points (Perlin's fade of 2002).
fn noise_gradient(at: vec3<f32>, seed: u32) -> vec3<f32> {
    let low = floor(at);
    let t = at - low;
    let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let slope = t * t * (t * (t * 30.0 - 60.0) + 30.0);
    let cell = vec3<i32>(low);
    // Values at both ends of the four edges along x.
    let starts = vec4(
        corner_value(cell, seed),
        corner_value(cell + vec3(0, 1, 0), seed),
        corner_value(cell + vec3(0, 0, 1), seed),
        corner_value(cell + vec3(0, 1, 1), seed),
    );
    let ends = vec4(
        corner_value(cell + vec3(1, 0, 0), seed),
        corner_value(cell + vec3(1, 1, 0), seed),
        corner_value(cell + vec3(1, 0, 1), seed),
        corner_value(cell + vec3(1, 1, 1), seed),
    );
    let edges = starts + (ends - starts) * fade.x;
    let rise = ends - starts;
    let along_x = mix(mix(rise.x, rise.y, fade.y), mix(rise.z, rise.w, fade.y), fade.z);
    let along_y = mix(edges.y - edges.x, edges.w - edges.z, fade.z);
    let along_z = mix(edges.z, edges.w, fade.y) - mix(edges.x, edges.y, fade.y);
    return vec3(along_x, along_y, along_z) * slope;
}
