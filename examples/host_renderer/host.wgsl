// The host's own passes: depth of each light's view, then the camera's picture. `gobo_light_through` and
// `gobo_light_at` are gobo's.

struct HostLight {
    place: vec4<f32>, // w 1: a spot that looks down; w 0: towards the sun
    color: vec4<f32>,
}

struct Camera {
    clip_from_world: mat4x4<f32>,
    right: vec4<f32>,
    up: vec4<f32>,
    lights: array<HostLight, 4>,
    light_count: u32,
}

struct Smoke {
    place: vec3<f32>,
    radius: f32,
    color: vec4<f32>,
}

@group(0) @binding(0) var<uniform> camera: Camera;
@group(2) @binding(0) var<storage, read> smoke: array<Smoke>;

struct Solid {
    @builtin(position) at: vec4<f32>,
    @location(0) place: vec3<f32>,
    @location(1) normal: vec3<f32>,
    @location(2) color: vec3<f32>,
}

@vertex
fn solid(@location(0) place: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) color: vec3<f32>) -> Solid {
    return Solid(camera.clip_from_world * vec4(place, 1.0), place, normal, color);
}

// Unshadowed light: falloff and cone are the host's.
fn arriving(light: HostLight, place: vec3<f32>) -> vec3<f32> {
    let way = light.place.xyz - place;
    let cosine = way.y / length(way);
    let cone = smoothstep(0.8, 0.9, cosine) / dot(way, way);
    return light.color.rgb * select(1.0, cone, light.place.w == 1.0);
}

fn towards(light: HostLight, place: vec3<f32>) -> vec3<f32> {
    return normalize(light.place.xyz - place * light.place.w);
}

@fragment
fn lit(seen: Solid) -> @location(0) vec4<f32> {
    var color = 0.05 * seen.color;
    for (var i = 0u; i < camera.light_count; i += 1u) {
        let light = camera.lights[i];
        let cosine = max(dot(seen.normal, towards(light, seen.place)), 0.0);
        color += seen.color * cosine * arriving(light, seen.place) * gobo_light_through(i, seen.place, seen.normal);
    }
    return vec4(color, 1.0);
}

struct Puff {
    @builtin(position) at: vec4<f32>,
    @location(0) corner: vec2<f32>,
    @location(1) color: vec4<f32>,
}

@vertex
fn puff(@builtin(vertex_index) vertex: u32, @builtin(instance_index) index: u32) -> Puff {
    let one = smoke[index];
    let corner = vec2(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
    let reach = one.radius * (corner.x * camera.right.xyz + corner.y * camera.up.xyz);
    var color = vec3(0.05);
    for (var i = 0u; i < camera.light_count; i += 1u) {
        color += 0.3 * arriving(camera.lights[i], one.place) * gobo_light_at(i, one.place);
    }
    return Puff(camera.clip_from_world * vec4(one.place + reach, 1.0), corner, vec4(color, one.color.a));
}

@fragment
fn veil(seen: Puff) -> @location(0) vec4<f32> {
    let inside = max(1.0 - dot(seen.corner, seen.corner), 0.0);
    return vec4(seen.color.rgb, seen.color.a * inside * inside);
}
