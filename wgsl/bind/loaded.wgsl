// Storage textures that kernels read: on software adapters far cheaper than buffers or sampled textures.
// There they replace the textures of the same name in `sampled.wgsl` (`llvmpipe::LOADED`). A name has one
// number in the whole project. Where a tier has room for few, the first here are replaced.

@group(0) @binding(131) var voxels: texture_storage_3d<rgba16float, read>;
@group(0) @binding(132) var brick_lights: texture_storage_2d<rgba32float, read>;
@group(0) @binding(33) var casters: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(130) var bricks: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(35) var clusters: texture_storage_2d<r32uint, read>;
@group(0) @binding(38) var filters: texture_storage_2d_array<rgba16float, read>;
@group(0) @binding(39) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(46) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(41) var lights: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(42) var lit: texture_storage_2d<rgba32float, read>;
@group(0) @binding(44) var nearests: texture_storage_2d_array<r32float, read>;
@group(0) @binding(48) var rects: texture_storage_2d<rg32uint, read>;
@group(0) @binding(56) var sorted: texture_storage_2d<rg32uint, read>;
@group(0) @binding(57) var keys: texture_storage_2d<rg32uint, read>;
@group(0) @binding(50) var setups: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(53) var tiles: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(54) var triangles: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(55) var histograms: texture_storage_2d<r32uint, read>;
@group(0) @binding(65) var layers: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(67) var seen_pixels: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(66) var points: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(89) var levels: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(100) var mask_surfaces: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(101) var half_surfaces: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(102) var light_masks: texture_storage_2d_array<rgba8unorm, read>;
@group(0) @binding(140) var ambients: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(141) var occlusions: texture_storage_2d<rg32uint, read>;
@group(0) @binding(142) var composited: texture_storage_2d<rgba32float, read>;
@group(0) @binding(105) var mask_slots: texture_storage_2d<r32uint, read>;
@group(0) @binding(106) var mask_points: texture_storage_2d<rgba32uint, read>;
