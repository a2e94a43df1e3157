// bin, ranges: where each tile's pairs begin and end in the pairs sorted by tile. Tiles are
// cleared before. Invocations stride over the pairs.
// CPU twin: src/cpu/bin.rs. Host: src/stage/bin.rs. Needs common/record.wgsl, bin.wgsl, tile.wgsl.
@group(0) @binding(0) var<storage, read_write> counters: BatchCounters;
@group(0) @binding(1) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(2) var<storage, read_write> tiles: array<Tile>;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_ranges(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let count = atomicLoad(&counters.pair_count);
    for (var i = id.x; i < count; i += workgroups.x * WORKGROUP_SIZE) {
        let tile = textureLoad(pairs, record_texel(i)).r;
        let before = textureLoad(pairs, record_texel(max(i, 1u) - 1u)).r;
        let after = textureLoad(pairs, record_texel(min(i + 1u, count - 1u))).r;
        if i == 0u || before != tile {
            tiles[tile].first = i;
        }
        if i == count - 1u || after != tile {
            tiles[tile].end = i + 1u;
        }
    }
}
