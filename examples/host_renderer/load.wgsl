// Loader of the host's smoke for gobo.

struct Smoke {
    place: vec3<f32>,
    radius: f32,
    color: vec4<f32>,
}

@group(1) @binding(0) var<storage, read> smoke: array<Smoke>;

fn load_caster(index: u32) -> Caster {
    let one = smoke[index];
    return Caster(one.place, one.radius, one.color, 0.0, 0u, index);
}
