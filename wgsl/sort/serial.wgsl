// Runs: each invocation owns one, in order, so a private counter per digit keeps the sort stable.

override WORKGROUP_SIZE: u32;
override RUN_MIN: u32;    // pairs; below it a run's counters cost more than its pairs
override RUN_USUAL: u32;  // pairs; longer runs gain nothing
override RUN_TARGET: u32; // runs that keep the cores busy
override RUN_LIMIT: u32;  // runs in a row of the histograms

const STEP: u32 = 4u; // pairs per loop step: spreads the loop's own cost

fn run_length(count: u32) -> u32 {
    let usual = clamp(ceil_div(count, RUN_TARGET), RUN_MIN, RUN_USUAL);
    let length = max(usual, ceil_div(count, RUN_LIMIT));
    return ceil_div(length, STEP) * STEP;
}

fn ceil_div(a: u32, b: u32) -> u32 {
    return (a + b - 1u) / b;
}
