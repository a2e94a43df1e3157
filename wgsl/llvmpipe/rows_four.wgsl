// Texels of an invocation: four in a column, a component each. What a visit costs beside its texels is shared
// by them.

import package::features::PERSPECTIVE;
import package::hit::disc::{Disc, Profile4, column_rest, disc_profile, rest_profile};
import package::records::view::GpuView;

const ROW_COUNT: u32 = 4u;

alias Rows = vec4<f32>;
alias RowBits = vec4<u32>;
alias RowIs = vec4<bool>;

fn row(v: Rows, i: u32) -> f32 {
    return v[i];
}

fn row_bits(v: RowBits, i: u32) -> u32 {
    return v[i];
}

// `v` with row `i` replaced.
fn with_row(v: Rows, i: u32, value: f32) -> Rows {
    return select(v, vec4(value), vec4(0u, 1u, 2u, 3u) == vec4(i));
}

fn with_bits(v: RowBits, i: u32, value: u32) -> RowBits {
    return select(v, vec4(value), vec4(0u, 1u, 2u, 3u) == vec4(i));
}

fn any_row(is: RowIs) -> bool {
    return any(is);
}

fn count_rows(is: RowIs) -> u32 {
    return dot(vec4<u32>(is), vec4(1u));
}

// A disc's profile and its light depth at the texels.
struct DiscRows {
    profile: Rows,
    depth: Rows,
}

// `corner`: first of the texels.
fn disc_rows(view: GpuView, disc: Disc, corner: vec2<f32>, opaque: Rows) -> DiscRows {
    let dx = corner.x + 0.5 - disc.center.x;
    let dy = corner.y + 0.5 - disc.center.y;
    var met: Profile4;
    if PERSPECTIVE {
        met = disc_profile(view, disc, dx, dy + vec4(0.0, 1.0, 2.0, 3.0), opaque);
    } else {
        met = rest_profile(disc, column_rest(disc, dx, dy), opaque);
    }
    return DiscRows(met.profile, met.depth);
}
