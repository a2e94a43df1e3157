// Order of tiles for drivers that give each of two cores one half of the dispatch: runs of neighbours
// alternate between the cores. (Runs, because consecutive stores to memory are many times faster.)

import package::records::dispatch::workgroup_number;

const RUN: u32 = 64u; // tiles

fn tile_number(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    let i = workgroup_number(workgroup, workgroups);
    let count = workgroups.x * workgroups.y;
    let half_count = count / 2u;
    let second = i >= half_count;
    let index = select(i, i - half_count, second);
    let whole = count / (2u * RUN) * RUN; // tiles of each half, in whole runs
    let run = 2u * (index - index % RUN) + index % RUN + select(0u, RUN, second);
    return select(select(i + whole, i, second), run, index < whole);
}
