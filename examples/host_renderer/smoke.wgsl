// The host's simulation: smoke that rises and spreads. A particle is reborn after its time.

struct Smoke {
    place: vec3<f32>,
    radius: f32,
    color: vec4<f32>,
}

@group(0) @binding(0) var<storage, read_write> smoke: array<Smoke>;
@group(0) @binding(1) var<storage, read_write> alive: array<u32>;
@group(0) @binding(2) var<uniform> frame: vec4<u32>; // number, born in a frame, capacity

@compute @workgroup_size(64)
fn move_smoke(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    let before = min(frame.x * frame.y, frame.z);
    let after = min(before + frame.y, frame.z);
    if i == 0u {
        alive[0] = after;
    }
    let is_young = i >= before && i < after;
    if is_young || (i < before && smoke[i].color.a < 0.05) {
        let turn = chance(3u * i + frame.x) * 6.2831853;
        let place = vec3(cos(turn), 0.2, sin(turn)) * 0.35 * sqrt(chance(3u * i + 1u));
        smoke[i] = Smoke(place, 0.05, vec4(0.55, 0.75, 0.95, 0.3));
    } else if i < before {
        var one = smoke[i];
        let swirl = vec3(-one.place.z, 0.0, one.place.x) * 0.05;
        one.place += swirl + vec3(0.006, 0.03 + 0.02 * chance(3u * i + 2u), 0.0);
        one.radius *= 1.015;
        one.color.a *= 0.975;
        smoke[i] = one;
    }
}
