// Storage buffers that kernels read. A name has one number in the whole project.

import package::records::batch::Chunk;
import package::records::emitter::GpuEmitted;
import package::records::host::{Caster, Gaussian, HostGroup};
import package::records::record::{CasterRecord, FootprintRecord};
import package::records::tile::{Segments, TileRecord};

@group(0) @binding(33) var<storage, read> casters: array<CasterRecord>;
@group(0) @binding(39) var<storage, read> footprints: array<FootprintRecord>;
@group(0) @binding(46) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(48) var<storage, read> rects: array<vec2<u32>>;
@group(0) @binding(50) var<storage, read> setups: array<vec4<u32>>;
@group(0) @binding(55) var<storage, read> histograms: array<u32>;
@group(0) @binding(56) var<storage, read> sorted: array<vec2<u32>>;
@group(0) @binding(53) var<storage, read> tiles: array<TileRecord>;
@group(0) @binding(57) var<storage, read> keys: array<vec2<u32>>;
@group(0) @binding(9) var<storage, read> chunks: array<Chunk>;
@group(0) @binding(10) var<storage, read> counts: array<u32>;
@group(0) @binding(11) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(12) var<storage, read> merged_tiles: array<u32>;
@group(0) @binding(13) var<storage, read> overflow: array<u32>;
@group(0) @binding(14) var<storage, read> partials: array<vec4<u32>>;
@group(0) @binding(16) var<storage, read> segments: Segments;
@group(0) @binding(17) var<storage, read> small_depths: array<u32>;
@group(0) @binding(73) var<storage, read> point_positions: array<f32>;
@group(0) @binding(71) var<storage, read> point_normals: array<f32>;
@group(0) @binding(74) var<storage, read> host_casters: array<Caster>;
@group(0) @binding(171) var<storage, read> host_gaussians: array<Gaussian>;
@group(0) @binding(173) var<storage, read> brick_spheres: array<vec4<f32>>; // centre and radius [m]
@group(0) @binding(174) var<storage, read> brick_states: array<u32>; // 1: it has density
@group(0) @binding(79) var<storage, read> host_counts: array<u32>;
@group(0) @binding(76) var<storage, read> host_groups: array<HostGroup>; // after their counters
@group(0) @binding(97) var<storage, read> emitted: array<GpuEmitted>;
@group(0) @binding(121) var<storage, read> tile_pairs: array<u32>;
@group(0) @binding(176) var<storage, read> glass_depths: array<u32>;
@group(0) @binding(177) var<storage, read> glass_owners: array<u32>;
@group(0) @binding(178) var<storage, read> caustics: array<vec4<u32>>;
@group(0) @binding(179) var<storage, read> glass: array<vec4<f32>>;
