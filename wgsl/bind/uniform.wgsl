// Uniform buffers. A name has one number in the whole project.

import package::blur::window::BlurParams;
import package::import::import::{ConvertParams, ImportParams};
import package::levels::level_blocks::LevelParams;
import package::records::batch::{BinParams, PartParams, ProjectParams};
import package::records::bounce::{BOUNCE_LENGTH, BounceParams};
import package::records::emitter::{EmissionParams, EmitterParams};
import package::records::glass::CausticParams;
import package::records::host::{CullParams, GaussianLook, HostGridParams, LoadParams};
import package::records::light::{PictureParams, PointBatch};
import package::records::mask::{HostView, MaskParams};
import package::records::material::{MAX_MATERIALS, GpuMaterial};
import package::records::view::{MAX_VIEWS, GpuView};
import package::soften::run::SoftenParams;
import package::sort::sort::SortPass;

@group(0) @binding(1) var<uniform> bin_params: BinParams;
@group(0) @binding(3) var<uniform> soften_params: SoftenParams;
@group(0) @binding(4) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(5) var<uniform> picture_params: PictureParams;
@group(0) @binding(6) var<uniform> project_params: ProjectParams;
@group(0) @binding(7) var<uniform> sort_pass: SortPass;
@group(0) @binding(8) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(63) var<uniform> point_batch: PointBatch;
@group(0) @binding(80) var<uniform> cull_params: CullParams;
@group(0) @binding(81) var<uniform> cull_planes: array<vec4<f32>, 384>; // six per view
@group(0) @binding(82) var<uniform> load_params: LoadParams;
@group(0) @binding(170) var<uniform> gaussian_looks: array<GaussianLook, MAX_MATERIALS>;
@group(0) @binding(172) var<uniform> host_grid: HostGridParams;
@group(0) @binding(84) var<uniform> import_params: ImportParams;
@group(0) @binding(88) var<uniform> level_params: LevelParams;
@group(0) @binding(104) var<uniform> mask_params: MaskParams;
@group(0) @binding(115) var<uniform> host_view: HostView;
@group(0) @binding(86) var<uniform> convert_params: ConvertParams;
@group(0) @binding(110) var<uniform> blur_params: BlurParams;
@group(0) @binding(98) var<uniform> emitter_params: EmitterParams;
@group(0) @binding(120) var<uniform> emission_params: EmissionParams;
@group(0) @binding(180) var<uniform> caustic_params: CausticParams;
@group(0) @binding(186) var<uniform> bounces: array<vec4<f32>, BOUNCE_LENGTH>;
@group(0) @binding(187) var<uniform> bounce_params: BounceParams;
@group(0) @binding(122) var<uniform> part_params: PartParams;
