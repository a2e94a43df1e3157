// Textures that kernels read by `textureLoad`, without a sampler. A name has one number in the whole
// project.

@group(0) @binding(33) var casters: texture_2d<u32>;
@group(0) @binding(130) var bricks: texture_2d<u32>;
@group(0) @binding(35) var clusters: texture_2d<u32>;
@group(0) @binding(36) var colored: texture_2d_array<f32>;
@group(0) @binding(37) var curves: texture_2d_array<u32>;
@group(0) @binding(38) var filters: texture_2d_array<f32>;
@group(0) @binding(39) var footprints: texture_2d<u32>;
@group(0) @binding(40) var images: texture_2d_array<f32>;
@group(0) @binding(41) var lights: texture_2d<u32>;
@group(0) @binding(44) var nearests: texture_2d_array<f32>;
@group(0) @binding(45) var opaques: texture_2d_array<f32>;
@group(0) @binding(46) var pairs: texture_2d<u32>;
@group(0) @binding(56) var sorted: texture_2d<u32>;
@group(0) @binding(57) var keys: texture_2d<u32>;
@group(0) @binding(48) var rects: texture_2d<u32>;
@group(0) @binding(49) var rows: texture_2d_array<f32>;
@group(0) @binding(50) var setups: texture_2d<u32>;
@group(0) @binding(53) var tiles: texture_2d<u32>;
@group(0) @binding(54) var triangles: texture_2d<u32>;
@group(0) @binding(131) var voxels: texture_3d<f32>;
@group(0) @binding(132) var brick_lights: texture_2d<f32>;
@group(0) @binding(83) var host_depths: texture_2d<f32>;
@group(0) @binding(175) var host_voxels: texture_3d<f32>;
@group(0) @binding(114) var host_normals: texture_2d<f32>;
@group(0) @binding(70) var raw_curves: texture_2d_array<u32>;
@group(0) @binding(190) var curve_pages: texture_2d_array<u32>;
@group(0) @binding(107) var near_rows: texture_2d_array<f32>;
@group(0) @binding(108) var near_around: texture_2d_array<f32>;
@group(0) @binding(89) var levels: texture_2d<u32>;
@group(0) @binding(100) var mask_surfaces: texture_2d<u32>;
@group(0) @binding(101) var half_surfaces: texture_2d<u32>;
@group(0) @binding(102) var light_masks: texture_2d_array<f32>;
@group(0) @binding(105) var mask_slots: texture_2d<u32>;
@group(0) @binding(106) var mask_points: texture_2d<u32>;
