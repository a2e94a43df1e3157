// Light that the open hits of a slab take, and where: the ramp that they become has the mean depth and the variance of
// that light. CPU reference: src/reference/curve/taken.rs.

import choice::rows::{RowIs, Rows};
import choice::visit::slabbed;

var<private> anchor: Rows; // depth of the first hit
var<private> taken: Rows;  // light, the sum of the channels
var<private> taken_sum: Rows;    // first two moments of its depth from `anchor`
var<private> taken_square: Rows;

struct Span {
    start: Rows,
    end: Rows,
}

fn clear_taken(is: RowIs) {
    if slabbed() {
        taken = select(taken, Rows(0.0), is);
        taken_sum = select(taken_sum, Rows(0.0), is);
        taken_square = select(taken_square, Rows(0.0), is);
    }
}

// `first`: where no hit is open yet.
fn take(depth: Rows, light: Rows, placed: RowIs, first: RowIs) {
    if slabbed() {
        anchor = select(anchor, depth, placed & first);
        let added = select(Rows(0.0), light, placed);
        let off = select(Rows(0.0), depth - anchor, placed);
        taken += added;
        taken_sum += added * off;
        taken_square += added * off * off;
    }
}

// Span of the ramp, within start..end.
fn fitted_span(start: Rows, end: Rows) -> Span {
    if !slabbed() {
        return Span(start, end);
    }
    let some = taken > Rows(0.0);
    let share = 1.0 / select(Rows(1.0), taken, some);
    let off = taken_sum * share;
    let spread = max(taken_square * share - off * off, Rows(0.0));
    let mean = max(min(anchor + off, end), start);
    let half = min(sqrt(3.0 * spread), min(mean - start, end - mean));
    return Span(select(start, mean - half, some), select(end, mean + half, some));
}
