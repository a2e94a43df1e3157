// Outlines: the tiles that a Gaussian touches, row by row, in integers, so that all kernels decide with the
// same bits. At height v above its middle, as a share of its half height downwards, an ellipse spans middle +
// lean v -+ width sqrt(1 - v^2). A unit is a tile's edge halved `shift` times. Rust: src/records/outline.rs.

import package::records::caster::{GAUSSIAN_TEXELS, OUTLINE_TEXEL};
import package::records::tile::WHOLE;
import choice::records::setup_words;

// Rounding of the stored and evaluated numbers, besides the slack of a texel [units].
const OUTLINE_ROUNDING: i32 = 4;
const MIDDLE_HEIGHT: i32 = 0x1000000; // 1 in heights of 24 bits behind the point

struct Outline {
    first: i32,      // height of the first texels of row `row` [2^-24]
    step_shift: u32, // height of a tile [2^-24], 27 bits, and shift
    lean_width: u32, // lean, signed, and width [units]
    row_middle: u32, // row [tiles], 8 bits, and middle, signed [units]
}

// Outline of a Gaussian; its footprint has the index of its setup.
fn load_outline(footprint: u32) -> Outline {
    let record = setup_words(footprint * GAUSSIAN_TEXELS + OUTLINE_TEXEL);
    return Outline(bitcast<i32>(record.x), record.y, record.z, record.w);
}

// Whether an outline chooses the tiles of a rectangle.
fn is_outlined(rect: vec2<u32>) -> bool {
    let first = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
    let last = vec2((rect.x >> 16u) & 255u, rect.x >> 24u);
    let mask = rect.y & 0xffffu;
    return any(last - first >= vec2(4u)) && mask != 0u && mask != WHOLE;
}

// Largest integer whose square is at most n, of up to 30 bits, whatever the device's root is off by: its
// rounded root is that integer or the next.
fn integer_root(n: i32) -> i32 {
    let root = i32(sqrt(f32(n)) + 0.5);
    return root - select(0, 1, root * root > n);
}

// Integer part of n / divisor, of up to 16 bits, in the same way. (Integer divisions are scalar on llvmpipe.)
fn quotient(n: i32, divisor: i32) -> i32 {
    let near = i32(f32(n) / f32(divisor) + 0.5);
    return near - select(0, 1, near * divisor > n);
}

// Offset of the middle and half width at a height [units].
fn outline_at(lean: i32, width: i32, height: i32) -> vec2<i32> {
    let v = clamp(height, -MIDDLE_HEIGHT, MIDDLE_HEIGHT) >> 9u;
    let inner = max(abs(v) - 1, 0);
    let across = integer_root(0x40000000 - inner * inner) + 1;
    return vec2((lean * v) >> 15u, (width * across) >> 15u);
}

// Height at which the ellipse reaches farthest to the right [2^-24].
fn outline_farthest(outline: Outline) -> i32 {
    let lean = extractBits(bitcast<i32>(outline.lean_width), 0u, 16u);
    let width = i32(outline.lean_width >> 16u);
    let share = quotient(abs(lean) << 15u, max(integer_root(lean * lean + width * width), 1)) << 9u;
    return select(share, -share, lean < 0);
}

// First column of tiles that the ellipse touches in a row, and the column behind its last, clamped to a
// rectangle's `corners`; equal for none. `farthest`: height at which it reaches farthest to the right.
fn outlined_columns(outline: Outline, farthest: i32, row: u32, corners: u32) -> vec2<u32> {
    let step = i32(outline.step_shift & 0x7ffffffu);
    let shift = outline.step_shift >> 27u;
    let lean = extractBits(bitcast<i32>(outline.lean_width), 0u, 16u);
    let width = i32(outline.lean_width >> 16u);
    let below = i32(row) - i32(outline.row_middle & 255u);
    let high = outline.first + below * step;
    // The texel centres of a tile span 15/16 of it, with slack of a 64th of a texel on both sides.
    let low = high + step - (step >> 4u) + (step >> 9u) + 512;
    let left = outline_at(lean, width, min(max(-farthest, high), low));
    let right = outline_at(lean, width, min(max(farthest, high), low));
    let middle = bitcast<i32>(outline.row_middle) >> 8u;
    let unit = 1 << shift;
    let inset = (unit >> 5u) - (unit >> 10u) - OUTLINE_ROUNDING;
    let first = max((middle + left.x - left.y + inset - 1) >> shift, i32(corners & 255u));
    let end = min((middle + right.x + right.y - inset) >> shift, i32((corners >> 16u) & 255u)) + 1;
    return vec2<u32>(vec2(first, max(end, first)));
}

// Whether a tile of a rectangle is within its outline.
fn is_within(outline: Outline, rect: vec2<u32>, tile: vec2<u32>) -> bool {
    let columns = outlined_columns(outline, outline_farthest(outline), tile.y, rect.x);
    return tile.x >= columns.x && tile.x < columns.y;
}

// The tiles of a rectangle that are within an outline, as a mask if they are at most 4x4, else their number;
// (0, 0) for none. Rows without a tile are left out.
fn outlined_tiles(outline: Outline, rect: vec2<u32>) -> vec2<u32> {
    let left = rect.x & 255u;
    let farthest = outline_farthest(outline);
    var top = 255u;
    var bottom = 0u;
    var count = 0u;
    var mask = 0u;
    for (var row = (rect.x >> 8u) & 255u; row <= (rect.x >> 24u); row += 1u) {
        let columns = outlined_columns(outline, farthest, row, rect.x);
        let wide = columns.y - columns.x;
        if wide > 0u {
            top = min(top, row);
            bottom = row;
            count += wide;
            let bits = ((1u << min(wide, 4u)) - 1u) << min(columns.x - left, 4u);
            mask |= select(0u, (bits & 15u) << (4u * min(row - top, 3u)), row - top < 4u);
        }
    }
    if count == 0u {
        return vec2(0u);
    }
    let is_small = ((rect.x >> 16u) & 255u) < left + 4u && bottom - top < 4u;
    let corners = (rect.x & 0x00ff00ffu) | (top << 8u) | (bottom << 24u);
    return vec2(corners, (rect.y & 0xffff0000u) | select(min(count, WHOLE), mask, is_small));
}
