// Runs: each invocation owns one, in order, so a private counter per digit keeps the sort stable.
const WORKGROUP_SIZE: u32 = 8u; // a subgroup of llvmpipe; more would only lengthen the tail
const RUN_ALIGNMENT: u32 = 4u;  // pairs per loop step
const RUN_MIN: u32 = 256u;      // below it the counters of a run cost more than its pairs
const RUN_USUAL: u32 = 2048u;   // beyond it longer runs gain nothing
const RUN_TARGET: u32 = 512u;   // runs that keep the cores busy
const RUN_LIMIT: u32 = 8192u;   // the histogram texture's width

// Rust: `run_length` in src/stage/sort.rs.
fn run_length(count: u32) -> u32 {
    let usual = clamp(ceil_div(count, RUN_TARGET), RUN_MIN, RUN_USUAL);
    let length = max(usual, ceil_div(count, RUN_LIMIT));
    return ceil_div(length, RUN_ALIGNMENT) * RUN_ALIGNMENT;
}

fn ceil_div(a: u32, b: u32) -> u32 {
    return (a + b - 1u) / b;
}
