// simulate, start: particles that start in some time steps of an emitter. Particle n goes to slot n modulo
// `capacity`, whose former particle ends before n starts. One invocation per particle. CPU reference:
// src/model/emitter.rs. Rust: src/stage/simulate.rs.

import package::bind::changed::emitted;
import package::bind::uniform::emitter_params;
import package::hit::hash::{pcg, unit_float};
import package::records::emitter::{
    EMITTER_BOX, EMITTER_DISC, EMITTER_SPHERE, GpuEmitted, STEPS_PER_SECOND,
};
import package::simulate::started_before::started_before;

const TRIES: u32 = 8u; // random points in a cube until one is in the ball

fn draw(number: u32, index: u32) -> f32 {
    return unit_float(pcg(number ^ pcg(index ^ pcg(emitter_params.seed))));
}

// A random point in the unit ball, or in its section where `axes` has zeros: the first of several that is
// inside.
fn in_ball(number: u32, index: u32, axes: vec3<f32>) -> vec3<f32> {
    for (var i = 0u; i < TRIES; i += 1u) {
        let first = index + 3u * i;
        let drawn = vec3(draw(number, first), draw(number, first + 1u), draw(number, first + 2u));
        let point = (drawn * 2.0 - 1.0) * axes;
        if dot(point, point) <= 1.0 {
            return point;
        }
    }
    return vec3(0.0);
}

// Here and below no uniform alone decides a branch: llvmpipe would recompile the kernel for its value.
fn aside(number: u32) -> vec3<f32> {
    switch select(0u, emitter_params.shape, number < 0xffffffffu) {
        case EMITTER_BOX: { return vec3(draw(number, 1u), draw(number, 2u), draw(number, 3u)) - 0.5; }
        case EMITTER_SPHERE: { return in_ball(number, 8u, vec3(1.0)) * 0.5; }
        case EMITTER_DISC: { return in_ball(number, 8u, vec3(1.0, 0.0, 1.0)) * 0.5; }
        default: { return vec3(0.0); }
    }
}

// Offset of the emitter along its path.
fn gone(seconds: f32) -> vec3<f32> {
    let count = select(1u, emitter_params.path_count, seconds > -1e9);
    var last = 0u;
    for (var i = 1u; i < count; i += 1u) {
        last = select(last, i, emitter_params.path[i].x <= seconds);
    }
    let before = emitter_params.path[last];
    let behind = emitter_params.path[min(last + 1u, count - 1u)];
    let share = (seconds - before.x) / max(behind.x - before.x, 1e-9);
    return mix(before.yzw, behind.yzw, clamp(share, 0.0, 1.0));
}

// `index`: among the particles that start in the step.
fn started_particle(number: u32, index: u32) -> GpuEmitted {
    let seconds = emitter_params.first_birth + f32(index) * emitter_params.period;
    let position = emitter_params.position + gone(seconds) + aside(number) * emitter_params.extent;
    let velocity = emitter_params.velocity + in_ball(number, 40u, vec3(1.0)) * emitter_params.spread;
    let range = emitter_params.life_most - emitter_params.life_least;
    let duration = emitter_params.life_least + range * draw(number, 0u);
    let life = clamp(u32(duration * STEPS_PER_SECOND), 1u, 0xffffu);
    return GpuEmitted(position, number, velocity, life << 16u);
}

@compute @workgroup_size(64)
fn start_particles(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let first = started_before(0u);
    let end = started_before(emitter_params.step_count);
    // All particles that share a slot, but the last, have ended by the end of the steps.
    let count = min(end - first, emitter_params.capacity);
    let index = id.y * workgroups.x * 64u + id.x;
    if index >= count {
        return;
    }
    let number = end - count + index;
    emitted[number % emitter_params.capacity] = started_particle(number, number - first);
}
