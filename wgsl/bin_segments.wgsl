// bin, segments: cuts the pairs of long tiles into segments. One invocation per tile.
// CPU twin: src/cpu/bin.rs. Host: src/stage/bin.rs. Needs common/view.wgsl, bin.wgsl, tile.wgsl.
@group(0) @binding(0) var<uniform> params: BinParams;
@group(0) @binding(1) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(2) var<storage, read_write> counters: BatchCounters;
@group(0) @binding(3) var<storage, read_write> scattered_tiles: array<u32>;
@group(0) @binding(4) var<storage, read_write> tiles: array<Tile>;
@group(0) @binding(5) var<storage, read_write> segments: array<Segment>;
@group(0) @binding(6) var<storage, read_write> merged_tiles: array<u32>;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_segments(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile = id.x;
    if tile >= params.tile_count {
        return;
    }
    var view = 0u;
    for (var i = 1u; i < params.view_count; i += 1u) {
        view = select(view, i, views[i].first_tile <= tile);
    }
    let count = tiles[tile].end - tiles[tile].first;
    let needed = (count + params.segment_length - 1u) / params.segment_length;
    let merged = needed > 1u || scattered_tiles[tile] != 0u;
    tiles[tile].view = view;
    tiles[tile].merged = 0u;
    if !merged {
        return;
    }
    merged_tiles[atomicAdd(&counters.merged_count, 1u)] = tile;
    let slot = atomicAdd(&counters.segment_count, needed);
    tiles[tile].merged = slot + 1u;
    for (var i = 0u; i < needed; i += 1u) {
        let first = tiles[tile].first + i * params.segment_length;
        let end = min(first + params.segment_length, tiles[tile].end);
        segments[slot + i] = Segment(tile, first, end, view);
    }
}
