// Share of a light that reaches a point, for shaders of the host and for `light_points`: 1 if nothing is in
// between, without falloff and cosine. CPU reference: `share` of crates/gobo-reference/src/shading/mod.rs.
// Rust: src/shadows/look_ups/host_shader.rs.

import package::records::light::light_record;
import package::records::material::RECEIVES_CURVE;
import package::records::owner::NO_OWNER;
import package::shade::incoming::incoming;
import package::shade::receiver::set_receiver;
import package::shade::shadow::shadow;

const LOCAL_ASIDES: u32 = 0u;

// `light`: index among the bound lights; `position` [m] and unit `normal` in world space. The normal
// offsets the point towards the light, off its own surface's shadow; zero for a point on no surface.
fn light_through(light: u32, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let source = light_record(light);
    let toward = incoming(source, position).toward;
    let face = normal * select(-1.0, 1.0, dot(normal, toward) > 0.0);
    set_receiver(RECEIVES_CURVE, NO_OWNER, false);
    return shadow(source, light, position, face, toward, 0.0);
}

// For a point without a normal: smoke, fog.
fn light_at(light: u32, position: vec3<f32>) -> vec3<f32> {
    return light_through(light, position, vec3(0.0));
}
