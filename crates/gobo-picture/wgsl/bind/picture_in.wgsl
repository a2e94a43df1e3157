// Resources that kernels of the picture read. A name has one number in the whole project.

import package::records::picture::{AirParams, ClusterParams};
import package::shade::band::Band;

@group(0) @binding(117) var<storage, read> point_lists: array<u32>;
@group(0) @binding(118) var<storage, read> layered_tiles: array<u32>;
@group(0) @binding(182) var<storage, read> air_ends: array<u32>;
@group(0) @binding(183) var<storage, read> air_items: array<u32>;

@group(0) @binding(32) var air: texture_2d_array<f32>;
@group(0) @binding(34) var cells: texture_2d<f32>;
@group(0) @binding(42) var lit: texture_2d<f32>;
@group(0) @binding(43) var masks: texture_2d<u32>;
@group(0) @binding(47) var reaches: texture_2d<u32>;
@group(0) @binding(51) var sources: texture_2d_array<f32>;
@group(0) @binding(65) var layers: texture_2d<u32>;
@group(0) @binding(67) var seen_pixels: texture_2d<u32>;
@group(0) @binding(96) var environment: texture_2d<f32>;
@group(0) @binding(66) var points: texture_2d<u32>;
@group(0) @binding(140) var ambients: texture_2d<u32>;
@group(0) @binding(141) var occlusions: texture_2d<u32>;
@group(0) @binding(142) var composited: texture_2d<f32>;
@group(0) @binding(143) var bloom_from: texture_2d<f32>;
@group(0) @binding(145) var bloom_level: texture_2d<f32>;
@group(0) @binding(146) var behinds: texture_2d<f32>;
@group(0) @binding(147) var bends: texture_2d<u32>;
@group(0) @binding(192) var first_surfaces: texture_2d_array<u32>;

@group(0) @binding(0) var<uniform> air_params: AirParams;
@group(0) @binding(2) var<uniform> cluster_params: ClusterParams;
@group(0) @binding(62) var<uniform> band: Band;
