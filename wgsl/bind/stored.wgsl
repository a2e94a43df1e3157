// Storage textures that are written. A name has one number in the whole project.

@group(0) @binding(32) var air: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(35) var clusters: texture_storage_2d<r32uint, write>;
@group(0) @binding(36) var colored: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(37) var curves: texture_storage_2d_array<rgba32uint, write>;
@group(0) @binding(38) var filters: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(39) var footprints: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(42) var lit: texture_storage_2d<rgba16float, write>;
@group(0) @binding(43) var masks: texture_storage_2d<r32uint, write>;
@group(0) @binding(44) var nearests: texture_storage_2d_array<r32float, write>;
@group(0) @binding(45) var opaques: texture_storage_2d_array<r32float, write>;
@group(0) @binding(46) var pairs: texture_storage_2d<rg32uint, write>;
@group(0) @binding(48) var rects: texture_storage_2d<rg32uint, write>;
@group(0) @binding(49) var rows: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(50) var setups: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(51) var sources: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(52) var surfaces: texture_storage_2d<rgba32float, write>;
@group(0) @binding(53) var tiles: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(55) var histograms: texture_storage_2d<r32uint, write>;
@group(0) @binding(57) var keys: texture_storage_2d<rg32uint, write>;
@group(0) @binding(58) var soft_filters: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(59) var soft_nearests: texture_storage_2d_array<r32float, write>;
@group(0) @binding(60) var soft_opaques: texture_storage_2d_array<r32float, write>;
@group(0) @binding(61) var sorted_pairs: texture_storage_2d<rg32uint, write>;
