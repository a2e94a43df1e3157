// Storage textures that kernels read and write, or update with atomics. A name has one number in the whole
// project.

@group(0) @binding(20) var nearness: texture_storage_2d<r32uint, atomic>;
@group(0) @binding(24) var sum_blue: texture_storage_2d<r32uint, atomic>;
@group(0) @binding(25) var sum_green: texture_storage_2d<r32uint, atomic>;
@group(0) @binding(26) var sum_red: texture_storage_2d<r32uint, atomic>;
@group(0) @binding(37) var curves: texture_storage_2d_array<rgba32uint, read_write>;
@group(0) @binding(190) var curve_pages: texture_storage_2d_array<r32uint, read_write>;
@group(0) @binding(38) var filters: texture_storage_2d_array<rgba16float, read_write>;
@group(0) @binding(44) var nearests: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(45) var opaques: texture_storage_2d_array<r32float, read_write>;
@group(0) @binding(55) var histograms: texture_storage_2d<r32uint, read_write>;
