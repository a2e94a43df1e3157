// After gobo's text, which declares `gobo_light_through` and `gobo_light_at` in group 1.

struct Frame {
    clip_from_world: mat4x4<f32>,
    world_from_clip: mat4x4<f32>,
    right: vec4<f32>, // of the camera, world space
    up: vec4<f32>,
    sun: vec4<f32>,   // the direction of its rays; w: how much brighter than light from everywhere it is
}
@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var depths: texture_depth_2d;
@group(0) @binding(3) var normals: texture_2d<f32>;
@group(0) @binding(4) var<storage, read> smoke: array<Smoke>;

@vertex
fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

/// Bevy's picture knows light from everywhere, which a matt surface sends back as it does the sun's.
@fragment
fn add_sun(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let texel = vec2<i32>(at.xy);
    let color = textureLoad(picture, texel, 0);
    let depth = textureLoad(depths, texel, 0);
    if depth == 0.0 { return color; }
    let ndc = at.xy / vec2<f32>(textureDimensions(picture)) * vec2(2.0, -2.0) + vec2(-1.0, 1.0);
    let world = frame.world_from_clip * vec4(ndc, depth, 1.0);
    let normal = normalize(textureLoad(normals, texel, 0).xyz * 2.0 - 1.0);
    let light = gobo_light_through(0u, world.xyz / world.w, normal);
    let cosine = max(dot(normal, -frame.sun.xyz), 0.0);
    return vec4(color.rgb * (1.0 + frame.sun.w * cosine * light), color.a);
}

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
