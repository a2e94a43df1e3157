// Follows `splat_point`: the point at which the light of each packed splat is looked up, in the order of the
// host's own buffer.

@group(0) @binding(0) var<storage, read> splats: array<array<u32, 8>>;
@group(0) @binding(1) var<storage, read_write> places: array<f32>;
@group(0) @binding(2) var<uniform> light: SplatLight;

@compute @workgroup_size(64)
fn place_splats(@builtin(global_invocation_id) thread: vec3<u32>) {
    let id = thread.x;
    if id >= arrayLength(&splats) {
        return;
    }
    let own = splats[id];
    let center = bitcast<vec3<f32>>(vec3(own[0], own[1], own[2]));
    let sigma = bitcast<vec3<f32>>(vec3(own[3], own[4], own[5]));
    let bytes = vec4(own[7]) >> vec4(0u, 8u, 16u, 24u);
    let turn = normalize((vec4<f32>(bytes & vec4(255u)) - 128.0) / 128.0);
    let at = splat_point(light, center, turn.yzwx, sigma, unpack4x8unorm(own[6]).a);
    places[3u * id] = at.x;
    places[3u * id + 1u] = at.y;
    places[3u * id + 2u] = at.z;
}
