// Splats of 32 bytes, as in antimatter15's and three.js viewers: position, deviations, rgba and a quaternion,
// scalar first, in bytes. `order`: the renderer's own, back to front; the one in use is sorted anew as the
// camera moves.

@group(1) @binding(0) var<storage, read> splats: array<array<u32, 8>>;
@group(1) @binding(1) var<storage, read> order: array<u32>;

fn load_gaussian(index: u32) -> Gaussian {
    let id = order[index];
    let own = splats[id];
    let bytes = vec4(own[7]) >> vec4(0u, 8u, 16u, 24u);
    let turn = (vec4<f32>(bytes & vec4(255u)) - 128.0) / 128.0;
    let rgba = unpack4x8unorm(own[6]);
    var gaussian: Gaussian;
    gaussian.center = bitcast<vec3<f32>>(vec3(own[0], own[1], own[2]));
    gaussian.sigma = bitcast<vec3<f32>>(vec3(own[3], own[4], own[5]));
    gaussian.rotation = normalize(turn.yzwx);
    gaussian.color = rgba.rgb;
    gaussian.opacity = rgba.a;
    gaussian.material = 0u;
    gaussian.id = id;
    return gaussian;
}
