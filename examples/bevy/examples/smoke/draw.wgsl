// Follows gobo's text, which declares `gobo_light_at` in group 1.

struct Frame {
    clip_from_world: mat4x4<f32>,
    right: vec4<f32>, // of the camera, world space
    up: vec4<f32>,
}
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var depths: texture_depth_2d;
@group(0) @binding(2) var<storage, read> smoke: array<Smoke>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) place: vec2<f32>,
    @location(1) @interpolate(flat) particle: u32,
}

@vertex
fn particle_corner(
    @builtin(vertex_index) i: u32, @builtin(instance_index) particle: u32,
) -> Corner {
    let one = smoke[particle];
    let place = vec2(f32(i & 1u), f32(i >> 1u)) * 2.0 - 1.0;
    let world = one.place + one.radius * (place.x * frame.right.xyz + place.y * frame.up.xyz);
    return Corner(frame.clip_from_world * vec4(world, 1.0), place, particle);
}

@fragment
fn shade_particle(in: Corner) -> @location(0) vec4<f32> {
    let one = smoke[in.particle];
    let profile = max(1.0 - dot(in.place, in.place), 0.0);
    let alpha = one.color.a * profile * profile;
    let is_hidden = in.position.z < textureLoad(depths, vec2<i32>(in.position.xy), 0);
    if alpha < 0.002 || is_hidden { discard; }
    let light = 0.35 + 0.9 * gobo_light_at(0u, one.place);
    return vec4(one.color.rgb * light * 0.5, alpha);
}
