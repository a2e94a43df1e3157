// simulate, particles: some time steps of an emitter's particles, each from the step in which it starts. One
// invocation per slot of the ring. CPU reference: src/model/emitter.rs. Rust: src/stage/simulate.rs.

import package::bind::changed::emitted;
import package::bind::uniform::emitter_params;
import package::records::emitter::{GpuEmitted, STEPS_AT_ONCE, STEP_SECONDS};
import package::simulate::curl_noise::curl_noise;
import package::simulate::started_before::started_before;

// Velocity after a collision with a surface of normal `out`.
fn collided(velocity: vec3<f32>, out: vec3<f32>) -> vec3<f32> {
    let into = dot(velocity, out);
    let along = velocity - out * into;
    let kept = along * emitter_params.slide - out * (into * emitter_params.bounce);
    return select(velocity, kept, into < 0.0);
}

// Way out of a box through its nearest side (the first of equals): xyz is that side's normal, w its distance.
fn way_out(position: vec3<f32>, low: vec3<f32>, high: vec3<f32>) -> vec4<f32> {
    var nearest = vec4(0.0, 0.0, 0.0, 1e30);
    for (var axis = 0u; axis < 3u; axis += 1u) {
        let down = position[axis] - low[axis];
        let up = high[axis] - position[axis];
        let unit = select(vec3(0.0), vec3(1.0), vec3(0u, 1u, 2u) == vec3(axis));
        nearest = select(nearest, vec4(-unit, down), down < nearest.w);
        nearest = select(nearest, vec4(unit, up), up < nearest.w);
    }
    return nearest;
}

// Here and below no uniform alone decides a branch: llvmpipe would recompile the kernel for its value.
fn advanced(particle: GpuEmitted, step: u32) -> GpuEmitted {
    let age = particle.age_life & 0xffffu;
    let share = f32(age) / f32(particle.age_life >> 16u);
    let lift = emitter_params.buoyancy * (1.0 - share) - emitter_params.gravity;
    var air = emitter_params.wind;
    let turbulence = select(0.0, emitter_params.turbulence, particle.age_life > 0u);
    if turbulence > 0.0 {
        let rise = vec3(0.0, emitter_params.evolve * STEP_SECONDS * f32(step), 0.0);
        let at = (particle.position + emitter_params.origin - rise) * emitter_params.frequency;
        air += curl_noise(at, emitter_params.seed) * turbulence;
    }
    // Implicit drag: it never overshoots.
    let pushed = particle.velocity + (vec3(0.0, lift, 0.0) + air * emitter_params.drag) * STEP_SECONDS;
    var velocity = pushed / (1.0 + emitter_params.drag * STEP_SECONDS);
    var position = particle.position + velocity * STEP_SECONDS;
    if position.y < emitter_params.ground {
        position.y = emitter_params.ground;
        velocity = collided(velocity, vec3(0.0, 1.0, 0.0));
    }
    let box_count = select(0u, emitter_params.box_count, particle.age_life > 0u);
    for (var i = 0u; i < box_count; i += 1u) {
        let low = emitter_params.boxes[2u * i].xyz;
        let high = emitter_params.boxes[2u * i + 1u].xyz;
        if all(position > low) && all(position < high) {
            let out = way_out(position, low, high);
            position = select(position, select(low, high, out.xyz > vec3(0.0)), out.xyz != vec3(0.0));
            velocity = collided(velocity, out.xyz);
        }
    }
    return GpuEmitted(position, particle.number, velocity, particle.age_life + 1u);
}

@compute @workgroup_size(64)
fn simulate_particles(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * 64u + id.x;
    let capacity = emitter_params.capacity;
    if index >= capacity {
        return;
    }
    var particle = emitted[index];
    let steps = select(0u, min(emitter_params.step_count, STEPS_AT_ONCE), index < capacity);
    for (var i = 0u; i < steps; i += 1u) {
        let has_started = particle.number < started_before(i + 1u);
        if has_started && (particle.age_life & 0xffffu) < (particle.age_life >> 16u) {
            particle = advanced(particle, emitter_params.step + i);
        }
    }
    emitted[index] = particle;
}
