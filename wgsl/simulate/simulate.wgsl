// simulate: particles of emitters, on the device. CPU reference: src/model/emitter.rs. Rust:
// src/stage/simulate.rs.

import package::bind::changed::emitted;
import package::bind::uniform::emitter_params;
import package::hit::hash::{pcg, unit_float};
import package::records::emitter::{
    EMITTER_BOX, EMITTER_DISC, EMITTER_SPHERE, GpuEmitted, STEPS_AT_ONCE, STEPS_PER_SECOND, STEP_SECONDS,
    started_before,
};

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

// simulate, start: particles that start in some time steps of an emitter. Particle n goes to slot n modulo
// `capacity`, whose former particle ends before n starts. One invocation per particle.
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

// Velocity of divergence-free turbulence: the cross product of two noise gradients (DeWolf 2005), of
// magnitude about 1.
fn curl_noise(at: vec3<f32>, seed: u32) -> vec3<f32> {
    return cross(noise_gradient(at, seed), noise_gradient(at, seed ^ 0x9e3779b9u)) * 0.875;
}

fn corner_value(cell: vec3<i32>, seed: u32) -> f32 {
    let corner = bitcast<vec3<u32>>(cell);
    return f32(pcg(corner.x ^ pcg(corner.y ^ pcg(corner.z ^ seed))) >> 8u) / 8388608.0 - 1.0;
}

// Gradient of value noise with values -1..1 at the lattice points (Perlin's fade of 2002).
fn noise_gradient(at: vec3<f32>, seed: u32) -> vec3<f32> {
    let low = floor(at);
    let t = at - low;
    let fade = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let slope = t * t * (t * (t * 30.0 - 60.0) + 30.0);
    let cell = vec3<i32>(low);
    // Values at both ends of the four edges along x.
    let starts = vec4(
        corner_value(cell, seed),
        corner_value(cell + vec3(0, 1, 0), seed),
        corner_value(cell + vec3(0, 0, 1), seed),
        corner_value(cell + vec3(0, 1, 1), seed),
    );
    let ends = vec4(
        corner_value(cell + vec3(1, 0, 0), seed),
        corner_value(cell + vec3(1, 1, 0), seed),
        corner_value(cell + vec3(1, 0, 1), seed),
        corner_value(cell + vec3(1, 1, 1), seed),
    );
    let edges = starts + (ends - starts) * fade.x;
    let rise = ends - starts;
    let along_x = mix(mix(rise.x, rise.y, fade.y), mix(rise.z, rise.w, fade.y), fade.z);
    let along_y = mix(edges.y - edges.x, edges.w - edges.z, fade.z);
    let along_z = mix(edges.z, edges.w, fade.y) - mix(edges.x, edges.y, fade.y);
    return vec3(along_x, along_y, along_z) * slope;
}

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

// simulate, particles: some time steps of an emitter's particles, each from the step in which it starts. One
// invocation per slot of the ring.
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
