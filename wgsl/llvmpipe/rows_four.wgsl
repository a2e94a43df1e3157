// Texels of an invocation: four in a column, a component each. They share the costs of a visit that don't
// depend on the texel.

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
