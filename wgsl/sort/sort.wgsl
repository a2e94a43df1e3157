// Code that all sort kernels share. Rust: src/stage/sort/mod.rs.

import package::bind::read::counts;
import package::bind::uniform::sort_pass;
import package::records::record::TOTAL_ROW;
import package::sort::serial::{WORKGROUP_SIZE, ceil_div, run_length};
import choice::writes::{counted, write_count};

struct SortPass {
    shift: u32,       // of the digit in the key [bits]
    digit_count: u32, // values of the digit, a power of two, at most 256
    capacity: u32,    // [pairs]
    count_index: u32, // of the pair count in `counts`
}

fn pair_count() -> u32 {
    return min(counts[sort_pass.count_index], sort_pass.capacity);
}

// sort_serial_scan: counts of runs -> pairs with the same digit in earlier runs, and the digit's total. One
// invocation per digit.
@compute @workgroup_size(WORKGROUP_SIZE)
fn sort_serial_scan(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = pair_count();
    let run_count = ceil_div(count, run_length(count));
    let digit = id.x;
    var total = 0u;
    for (var run = 0u; run < run_count; run += 1u) {
        let at = vec2(run, digit);
        let in_run = counted(at);
        write_count(at, total);
        total += in_run;
    }
    write_count(vec2(digit, TOTAL_ROW), total);
}
