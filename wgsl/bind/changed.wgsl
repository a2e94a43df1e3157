// Storage buffers that kernels write. A name has one number in the whole project.

import package::records::batch::{BatchCounters, BinParams, Chunk, ProjectParams};
import package::records::emitter::GpuEmitted;
import package::records::host::LoadedGroups;
import package::records::record::{CasterRecord, FootprintRecord};
import package::records::texel::TexelSums;
import package::records::tile::{CountedSegments, TileRecord};

@group(0) @binding(33) var<storage, read_write> casters: array<CasterRecord>;
@group(0) @binding(39) var<storage, read_write> footprints: array<FootprintRecord>;
@group(0) @binding(46) var<storage, read_write> pairs: array<vec2<u32>>;
@group(0) @binding(48) var<storage, read_write> rects: array<vec2<u32>>;
@group(0) @binding(50) var<storage, read_write> setups: array<vec4<u32>>;
@group(0) @binding(53) var<storage, read_write> tiles: array<TileRecord>;
@group(0) @binding(55) var<storage, read_write> histograms: array<u32>;
@group(0) @binding(57) var<storage, read_write> keys: array<vec2<u32>>;
@group(0) @binding(61) var<storage, read_write> sorted_pairs: array<vec2<u32>>;
@group(0) @binding(69) var<storage, read_write> clipped_rects: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read_write> chunks: array<Chunk>;
@group(0) @binding(11) var<storage, read_write> dispatches: array<atomic<u32>>;
@group(0) @binding(12) var<storage, read_write> merged_tiles: array<u32>;
@group(0) @binding(13) var<storage, read_write> overflow: array<u32>;
@group(0) @binding(14) var<storage, read_write> partials: array<vec4<u32>>;
@group(0) @binding(15) var<storage, read_write> scattered_tiles: array<u32>;
@group(0) @binding(16) var<storage, read_write> segments: CountedSegments;
@group(0) @binding(17) var<storage, read_write> small_depths: array<atomic<u32>>;
@group(0) @binding(19) var<storage, read_write> counters: BatchCounters;
@group(0) @binding(20) var<storage, read_write> nearness: array<atomic<u32>>;
@group(0) @binding(23) var<storage, read_write> run_offsets: array<u32>;
@group(0) @binding(193) var<storage, read_write> sums: array<TexelSums>;
@group(0) @binding(24) var<storage, read_write> sum_blue: array<atomic<u32>>;
@group(0) @binding(25) var<storage, read_write> sum_green: array<atomic<u32>>;
@group(0) @binding(26) var<storage, read_write> sum_red: array<atomic<u32>>;
@group(0) @binding(72) var<storage, read_write> point_shares: array<f32>;
@group(0) @binding(85) var<storage, read_write> converted: array<u32>;
@group(0) @binding(174) var<storage, read_write> brick_states: array<u32>;
@group(0) @binding(76) var<storage, read_write> host_groups: LoadedGroups;
@group(0) @binding(78) var<storage, read_write> listed_counts: array<u32>;
// The uniform buffers of a list that has the host's casters.
@group(0) @binding(77) var<storage, read_write> listed_bin_params: BinParams;
@group(0) @binding(181) var<storage, read_write> listed_project_params: ProjectParams;
@group(0) @binding(97) var<storage, read_write> emitted: array<GpuEmitted>;
@group(0) @binding(121) var<storage, read_write> tile_pairs: array<atomic<u32>>;
@group(0) @binding(184) var<storage, read_write> tile_cursors: array<atomic<u32>>; // number, then place
@group(0) @binding(185) var<storage, read_write> bucketed: array<vec2<u32>>; // depth key and footprint
@group(0) @binding(123) var<storage, read_write> part_turn: vec4<u32>;
@group(0) @binding(189) var<storage, read_write> drawn_tiles: array<u32>;
@group(0) @binding(191) var<storage, read_write> free_pages: array<atomic<u32>>; // their number, then they
@group(0) @binding(176) var<storage, read_write> glass_depths: array<atomic<u32>>;
@group(0) @binding(177) var<storage, read_write> glass_owners: array<atomic<u32>>;
@group(0) @binding(178) var<storage, read_write> caustics: array<atomic<u32>>;
@group(0) @binding(188) var<storage, read_write> bounced: array<vec4<f32>>; // the buffer of `bounces`
