// Resources that kernels of the picture write. A name has one number in the whole project.

import package::records::picture::ClusterCounters;

@group(0) @binding(18) var<storage, read_write> cluster_counters: ClusterCounters;
@group(0) @binding(21) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(22) var<storage, read_write> pixels: array<u32>;
@group(0) @binding(64) var<storage, read_write> carried: array<vec4<u32>>;
@group(0) @binding(117) var<storage, read_write> point_lists: array<atomic<u32>>;
@group(0) @binding(118) var<storage, read_write> layered_tiles: array<atomic<u32>>;
// Slices of each column of air that are needed; in the upper 16 bits, those that earlier bands needed.
@group(0) @binding(182) var<storage, read_write> air_ends: array<u32>;
@group(0) @binding(183) var<storage, read_write> air_items: array<atomic<u32>>;

@group(0) @binding(32) var air: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(35) var clusters: texture_storage_2d<r32uint, write>;
@group(0) @binding(42) var lit: texture_storage_2d<rgba32float, write>;
@group(0) @binding(43) var masks: texture_storage_2d<r32uint, write>;
@group(0) @binding(51) var sources: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(65) var layers: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(66) var points: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(67) var seen_pixels: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(68) var radiance: texture_storage_2d<rgba32float, write>;
@group(0) @binding(140) var ambients: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(141) var occlusions: texture_storage_2d<rg32uint, write>;
@group(0) @binding(144) var bloom_to: texture_storage_2d<rgba16float, write>;
@group(0) @binding(146) var behinds: texture_storage_2d<rgba16float, write>;
@group(0) @binding(147) var bends: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(192) var first_surfaces: texture_storage_2d<rgba32uint, write>;
