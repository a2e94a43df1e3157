// Storage textures that kernels read: on software adapters far cheaper than buffers. A name has one number
// in the whole project.

@group(0) @binding(39) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(46) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(48) var rects: texture_storage_2d<rg32uint, read>;
@group(0) @binding(54) var triangles: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(55) var histograms: texture_storage_2d<r32uint, read>;
@group(0) @binding(56) var sorted: texture_storage_2d<rg32uint, read>;
@group(0) @binding(57) var keys: texture_storage_2d<rg32uint, read>;
@group(0) @binding(66) var points: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(89) var levels: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(100) var mask_surfaces: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(101) var half_surfaces: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(102) var light_masks: texture_storage_2d_array<rgba8unorm, read>;
@group(0) @binding(105) var mask_slots: texture_storage_2d<r32uint, read>;
@group(0) @binding(106) var mask_points: texture_storage_2d<rgba32uint, read>;
