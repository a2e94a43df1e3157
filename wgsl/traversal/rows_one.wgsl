// Texels of an invocation: one, because registers are scarce on GPUs, and fewer casters touch a subgroup's
// small block of texels.

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
