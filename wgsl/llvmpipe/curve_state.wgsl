// State of a walk of wgsl/llvmpipe/curve_queue.wgsl in an invocation's texels.

import package::features::{NODES, unrolled};
import package::llvmpipe::curve_texels::{ROWS, light_of, texels};
import package::sums::sums::BLACK;

// Whether light can still change at or behind `front`.
fn changes(front: f32) -> bool {
    var most = vec3(0.0);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        most = max(most, select(vec3(0.0), texels[i].light, texels[i].opaque > front));
    }
    return any(most >= vec3(BLACK));
}

// Whether a nearest depth may still change.
fn seeks(front: f32) -> bool {
    var some = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        some = some | ((texels[i].nearest > front) & (texels[i].opaque > front));
    }
    return some;
}

// Whether some texel may have few hits, by the count so far.
fn counts_on(front: f32) -> bool {
    var some = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let is_open = any(texels[i].light >= vec3(BLACK)) & (texels[i].opaque > front);
        some = some | ((texels[i].count < f32(NODES + 1u)) & is_open);
    }
    return some;
}

// The same as `changes`, for the rows of `sample`.
fn sample_changes() -> bool {
    return any(max(texels[2].light, texels[5].light) >= vec3(BLACK));
}

fn sample_lost() -> f32 {
    return 6.0 - dot(light_of(2u) + light_of(5u), vec3(1.0));
}

// Light that the texels have lost.
fn lost_light() -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        sum += 3.0 - dot(light_of(i), vec3(1.0));
    }
    return sum;
}

// The same in the second walk, which keeps the sums of channels.
fn lost_so_far() -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        sum += 3.0 - texels[i].sum;
    }
    return sum;
}

fn sample_lost_so_far() -> f32 {
    return 6.0 - (texels[2].sum + texels[5].sum);
}

fn is_few(i: u32) -> bool {
    return (texels[i].count > 0.0) & (texels[i].count < f32(NODES + 1u));
}

// Rows that hold texels with few hits, as bits.
fn few_rows() -> u32 {
    var rows = 0u;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        rows |= select(0u, 1u << i, is_few(i));
    }
    return rows;
}

fn has_many() -> bool {
    var some = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        some = some | (texels[i].count >= f32(NODES + 1u));
    }
    return some;
}
