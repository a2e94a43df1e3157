// An ellipse's outline in a view's tiles. CPU reference: crates/gobo-reference/src/outline.rs.

import package::records::outline::Outline;
import package::records::tile_rect::SLACK;
import package::records::view::TILE_SIZE;

const OUTLINE_GROWTH: f32 = 1.0002;  // for the rounding of the ellipse
const WIDEST_OUTLINE: f32 = 32000.0; // half width [units]
const FINEST_UNIT: i32 = -8;         // edge of a unit, its logarithm to base 2 [texels]
const COARSEST_UNIT: i32 = 4;
const LEAST_OPEN: f32 = 1e-3;        // below, the ellipse is known too roughly

// Texels with (x, y) - middle = (lean v -+ width sqrt(1 - v^2), half.y v).
struct Ellipse {
    middle: vec2<f32>, // [texels]
    half: vec2<f32>,
    lean: f32,
    width: f32,
    open: f32, // 1 for a Gaussian far from the eye's plane, less near it
}

// Logarithm to base 2 of the edge of the least unit in which half the width is within WIDEST_OUTLINE
// [texels].
fn unit_log(ellipse: Ellipse) -> i32 {
    let edge = bitcast<u32>(ellipse.half.x * (OUTLINE_GROWTH / WIDEST_OUTLINE));
    return max(i32(edge >> 23u) - 126, FINEST_UNIT);
}

// Whether the ellipse has an outline; else it counts as touching all tiles of its rectangle.
fn has_outline(ellipse: Ellipse) -> bool {
    return ellipse.open >= LEAST_OPEN && unit_log(ellipse) <= COARSEST_UNIT;
}

// `row`: the first row of tiles.
fn outline_of(ellipse: Ellipse, row: u32) -> Outline {
    let log = unit_log(ellipse);
    let per_texel = bitcast<f32>(u32(127 - log) << 23u);
    let high = ellipse.half.y * OUTLINE_GROWTH;
    let top = f32(row * TILE_SIZE) + 0.5 - SLACK;
    let first = i32(floor((top - ellipse.middle.y) / high * 16777216.0)) - 256;
    let step = u32(ceil(f32(TILE_SIZE) / high * 16777216.0));
    let lean = i32(round(ellipse.lean * OUTLINE_GROWTH * per_texel));
    let width = u32(ceil(ellipse.width * OUTLINE_GROWTH * per_texel));
    let middle = i32(round(ellipse.middle.x * per_texel));
    return Outline(
        first,
        step | (u32(COARSEST_UNIT - log) << 27u),
        (bitcast<u32>(lean) & 0xffffu) | (width << 16u),
        row | (bitcast<u32>(middle) << 8u),
    );
}
