// Splats as 3DGS trains and stores them, an array per property: logarithms of deviations; quaternions, scalar
// first and of any length; the first coefficient of spherical harmonics; the logit of the opacity.

struct Three { x: f32, y: f32, z: f32 }
@group(1) @binding(0) var<storage, read> means: array<Three>;
@group(1) @binding(1) var<storage, read> log_scales: array<Three>;
@group(1) @binding(2) var<storage, read> quaternions: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read> f_dc: array<Three>;
@group(1) @binding(4) var<storage, read> logits: array<f32>;

fn vector(own: Three) -> vec3<f32> {
    return vec3(own.x, own.y, own.z);
}

fn load_gaussian(index: u32) -> Gaussian {
    return Gaussian(
        vector(means[index]),
        1.0 / (1.0 + exp(-logits[index])),
        normalize(quaternions[index].yzwx),
        exp(vector(log_scales[index])),
        0u,
        clamp(0.5 + 0.28209479 * vector(f_dc[index]), vec3(0.0), vec3(1.0)),
        index,
    );
}
