// Dither patterns: the threshold that a caster's opacity must exceed at a texel to block its light. CPU
// reference, with the reasons: crates/gobo-reference/src/dither.rs.

import package::hit::hash::pcg;
import package::records::view::GpuView;
import choice::records::caster_record;

const PATTERN_CHECKERBOARD: u32 = 0u;
const PATTERN_BAYER2: u32 = 1u;
const PATTERN_BAYER4: u32 = 2u;
const PATTERN_BAYER8: u32 = 3u;
const PATTERN_BAYER16: u32 = 4u;
const PATTERN_IGN: u32 = 5u;
const PATTERN_BLUE: u32 = 6u;
const PATTERN_HASHED: u32 = 7u;

const BLOCK_BITS: u32 = 4u;
const BLUE_SIZE: u32 = 64u;
const FARTHEST: f32 = 524288.0;

// Cell of the pattern at a texel of a view's map.
fn pattern_cell(view: GpuView, scale: u32, texel: vec2<f32>) -> vec2<u32> {
    let origin = view.view_from_world[3] * view.scale;
    let anchor = round(clamp(vec2(origin.x, -origin.y), vec2(-FARTHEST), vec2(FARTHEST)));
    let still = select(vec2<i32>(anchor), vec2(0), view.perspective > 0.0);
    let ahead = vec2<i32>(i32(scale << 20u));
    return vec2<u32>(vec2<i32>(floor(texel)) - still + ahead) / scale;
}

fn pcg_cell(cell: vec2<u32>, id: u32) -> u32 {
    return pcg(cell.x + pcg(cell.y + pcg(id)));
}

// Threshold of every pattern except `hashed`, over 65536.
fn cell_threshold(pattern: u32, blue_first: u32, cell: vec2<u32>, id: u32) -> f32 {
    var bits: u32;
    switch pattern {
        case PATTERN_IGN: { bits = gradient_noise(cell, id); }
        case PATTERN_BLUE: { bits = blue(blue_first, cell, id); }
        default: {
            let is_checkerboard = pattern == PATTERN_CHECKERBOARD;
            let order = select(pattern, 2u, is_checkerboard);
            let chance = select(pcg_cell(cell >> vec2(order), id), pcg(id), is_checkerboard);
            bits = ordered(cell, order, id, chance);
        }
    }
    return f32(bits) * (1.0 / 65536.0);
}

fn parity(word: u32) -> u32 {
    return countOneBits(word) & 1u;
}

fn interleaved_bits(cell: vec2<u32>, shift: u32) -> u32 {
    let h = cell >> vec2(shift);
    return (h.x & 1u) | ((h.y & 1u) << 1u) | ((h.x & 2u) << 1u) | ((h.y & 2u) << 2u)
        | ((h.x & 4u) << 2u) | ((h.y & 4u) << 3u);
}

fn next_walsh(walsh: u32) -> u32 {
    return ((walsh << 1u) & 63u) ^ ((walsh >> 5u) * 3u);
}

// Digit `i` of the rank, and the Walsh function of the next digit.
fn digit(cell: vec2<u32>, i: u32, walsh: u32) -> vec2<u32> {
    let at = (cell >> vec2(i)) & vec2(1u);
    let higher = interleaved_bits(cell, i + 1u);
    let second = next_walsh(walsh);
    let high = at.x ^ at.y ^ parity(higher & walsh);
    let low = at.y ^ parity(higher & second);
    return vec2((high << 1u) | low, next_walsh(second));
}

// All four digits for every order, without a loop: with a loop per texel, the walk of a segment would exceed
// the turns that llvmpipe allows an invocation.
fn ordered(cell: vec2<u32>, order: u32, id: u32, chance: u32) -> u32 {
    let first = digit(cell, 0u, id & 63u);
    let second = digit(cell, 1u, first.y);
    let third = digit(cell, 2u, second.y);
    let fourth = digit(cell, 3u, third.y);
    let whole = (first.x << 6u) | (second.x << 4u) | (third.x << 2u) | fourth.x;
    let level_bits = 2u * order;
    var rank = whole >> (8u - level_bits);
    if id >= 64u {
        rank ^= pcg_cell(cell >> vec2(BLOCK_BITS), id >> 6u) & ((1u << level_bits) - 1u);
    }
    return ((rank << 16u) | (chance >> 16u)) >> level_bits;
}

fn turned(cell: vec2<u32>, turn: u32) -> vec2<u32> {
    let at = select(cell.yx, cell, (turn & 1u) == 0u);
    return vec2(select(~at.x, at.x, (turn & 2u) == 0u), at.y);
}

fn gradient_noise(cell: vec2<u32>, id: u32) -> u32 {
    let turn = pcg(id);
    let shift = pcg_cell(cell >> vec2(BLOCK_BITS), id);
    let at = turned(cell, turn);
    let x = at.x + at.y * ((turn >> 1u) & 2u) + (shift & 0xffffu);
    let y = at.y + (shift >> 16u);
    let inner = x * 288237660u + y * 25070368u; // 0.06711056 and 0.00583715
    return (inner * 52u + (inner >> 16u) * 64417u) >> 16u; // 52.9829189
}

// Ranks are 16 bits each, eight in the last four words of each of the `casters` from `first` on.
fn blue(first: u32, cell: vec2<u32>, id: u32) -> u32 {
    let offset = (id * 2654435769u) >> 20u;
    let at = turned(cell, pcg(id));
    let x = (at.x + offset) % BLUE_SIZE;
    let y = (at.y + (offset >> 6u)) % BLUE_SIZE;
    let index = y * BLUE_SIZE + x;
    let eight = caster_record(first + index / 8u);
    let four = select(
        vec2(eight.red_green, eight.blue_alpha),
        vec2(eight.material_rotation, eight.id),
        (index & 4u) != 0u,
    );
    let two = select(four.x, four.y, (index & 2u) != 0u);
    return (((two >> ((index % 2u) * 16u)) & 0xffffu) << 4u) | 8u;
}

fn exponent(v: f32) -> i32 {
    return i32((bitcast<u32>(v) >> 23u) & 255u) - 127;
}

fn power(e: i32) -> f32 {
    return bitcast<f32>(u32(e + 127) << 23u);
}

// `on_caster`: coordinates in the caster's own space; `one_step`: their change from one texel to the next.
fn hashed_threshold(on_caster: vec2<f32>, one_step: vec2<f32>, scale: u32, id: u32) -> f32 {
    let step = max(one_step * f32(scale), vec2(1e-9));
    let per_unit = 0.70710678 / step.x;
    let between = bitcast<f32>((bitcast<u32>(per_unit) & 0x007fffffu) | 0x3f800000u) - 1.0;
    let x = clamp(exponent(per_unit), -20, 20);
    let y = clamp(x + exponent(step.x / step.y * 1.41421356), -24, 24);
    let coarse = caster_hash(on_caster, x, y, id);
    let fine = caster_hash(on_caster, x + 1, y + 1, id);
    return uniform_share(coarse * (1.0 - between) + fine * between, min(between, 1.0 - between));
}

fn caster_hash(on_caster: vec2<f32>, x: i32, y: i32, id: u32) -> f32 {
    let cell = bitcast<vec2<u32>>(vec2<i32>(floor(on_caster * vec2(power(x), power(y)))));
    return (f32(pcg_cell(cell, id ^ (u32(x + 127) << 24u)) >> 16u) + 0.5) * (1.0 / 65536.0);
}

fn uniform_share(x: f32, a: f32) -> f32 {
    let b = 1.0 - a;
    let tails = 2.0 * max(a * b, 1e-6);
    let middle = (x - 0.5 * a) / b;
    let upper = 1.0 - (1.0 - x) * (1.0 - x) / tails;
    let share = select(select(upper, middle, x < b), x * x / tails, x < a);
    return clamp(share, 0.0, 65535.0 / 65536.0);
}
