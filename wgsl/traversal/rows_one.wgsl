// Texels of an invocation: one, as registers are scarce on GPUs, and a subgroup with a small block of texels
// visits fewer casters.

import package::hit::disc::{Disc, column_rest, disc_profile, rest_profile};
import package::records::view::GpuView;
import package::features::PERSPECTIVE;

const ROW_COUNT: u32 = 1u;

alias Rows = f32;
alias RowBits = u32;
alias RowIs = bool;

fn row(v: Rows, i: u32) -> f32 {
    return v;
}

fn row_bits(v: RowBits, i: u32) -> u32 {
    return v;
}

// `v` with row `i` replaced.
fn with_row(v: Rows, i: u32, value: f32) -> Rows {
    return value;
}

fn with_bits(v: RowBits, i: u32, value: u32) -> RowBits {
    return value;
}

fn any_row(is: RowIs) -> bool {
    return is;
}

fn count_rows(is: RowIs) -> u32 {
    return u32(is);
}

// A disc's profile and its light depth at the texels.
struct DiscRows {
    profile: Rows,
    depth: Rows,
}

// `corner`: the texel. The column of four texels is the unit of rounding.
fn disc_rows(view: GpuView, disc: Disc, corner: vec2<f32>, opaque: Rows) -> DiscRows {
    let dx = corner.x + 0.5 - disc.center.x;
    let in_column = u32(corner.y) & 3u;
    let dy = corner.y - f32(in_column) + 0.5 - disc.center.y;
    if PERSPECTIVE {
        let met = disc_profile(view, disc, dx, vec4(dy + f32(in_column)), vec4(opaque));
        return DiscRows(met.profile.x, met.depth.x);
    }
    let rest = column_rest(disc, dx, dy);
    let low = select(rest.x, rest.y, in_column == 1u);
    let high = select(rest.z, rest.w, in_column == 3u);
    let met = rest_profile(disc, vec4(select(low, high, in_column > 1u)), vec4(opaque));
    return DiscRows(met.profile.x, met.depth.x);
}
