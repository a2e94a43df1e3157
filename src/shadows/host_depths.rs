//! Depth maps of the host's, and how they get into ours.
use super::{Maps, context::Context, host_inputs::HostDepth, kernels::Kernels};
use crate::{
    error::Error,
    gpu::Resources,
    model::{Projection, View},
    records::{GpuView, ImportParams},
    stage::import,
};
use bytemuck::Zeroable as _;
use glam::{DVec2, DVec3, DVec4, UVec2};
use wgpu::{BindGroup, TextureFormat, TextureUsages, TextureView};

/// A view's depth map of the host's.
#[derive(Clone, Debug)]
pub(crate) struct DepthInput {
    texture: TextureView,
    /// But for where our map is.
    params: ImportParams,
    pub instead: bool,
    pub version: Option<u64>,
}

/// How far a ray of ours may wander in the host's map along its way [texels of the host's].
const ASTRAY: f64 = 0.25;

/// By view.
pub(super) fn depth_inputs(
    views: &[View],
    given: &[HostDepth<'_>],
) -> Result<Vec<Option<DepthInput>>, Error> {
    let mut inputs = vec![None; views.len()];
    for (index, depth) in given.iter().enumerate() {
        let invalid = |problem| Error::Invalid { what: "depth map of the host's", index, problem };
        let view = views.get(depth.view).ok_or(invalid("its view is not among the views"))?;
        let input = DepthInput::new(depth, view).map_err(invalid)?;
        if inputs[depth.view].replace(input).is_some() {
            return Err(invalid("its view has one already"));
        }
    }
    Ok(inputs)
}

impl DepthInput {
    fn new(depth: &HostDepth<'_>, view: &View) -> Result<Self, &'static str> {
        use TextureFormat::{
            Depth16Unorm, Depth24Plus, Depth24PlusStencil8, Depth32Float, Depth32FloatStencil8,
            R32Float,
        };
        let texture = depth.texture;
        let aspect = match texture.format() {
            R32Float => wgpu::TextureAspect::All,
            Depth16Unorm | Depth24Plus | Depth24PlusStencil8 | Depth32Float
            | Depth32FloatStencil8 => wgpu::TextureAspect::DepthOnly,
            _ => return Err("its format must be one of depth, or r32float"),
        };
        if texture.dimension() != wgpu::TextureDimension::D2 || texture.sample_count() != 1 {
            return Err("it must have two dimensions and one sample a texel");
        }
        if !texture.usage().contains(TextureUsages::TEXTURE_BINDING) {
            return Err("its usage lacks TEXTURE_BINDING");
        }
        if depth.layer >= texture.depth_or_array_layers() {
            return Err("it has no such layer");
        }
        let params = params(depth, view)?;
        let texture = texture.create_view(&wgpu::TextureViewDescriptor {
            label: Some("host_depths"),
            dimension: Some(wgpu::TextureViewDimension::D2),
            aspect,
            mip_level_count: Some(1),
            base_array_layer: depth.layer,
            array_layer_count: Some(1),
            ..Default::default()
        });
        Ok(Self { texture, params, instead: depth.instead, version: depth.version })
    }
}

/// But for where our map is. In `f64`, because far from the origin matrices cancel.
fn params(depth: &HostDepth<'_>, view: &View) -> Result<ImportParams, &'static str> {
    let clip_from_world = depth.clip_from_world.unwrap_or_else(|| view.clip_from_world());
    let world_from_view = view.view_from_world.as_dmat4().inverse();
    let clip_from_view = clip_from_world.as_dmat4() * world_from_view;
    if !clip_from_view.is_finite() {
        return Err("its matrix must be finite");
    }
    let host_size = UVec2::new(depth.texture.width(), depth.texture.height());
    let is_perspective = view.projection == Projection::Perspective;
    let (near, far) = (f64::from(view.near), f64::from(view.far));
    let half = (view.size.as_dvec2() - 1.0) * 0.5 / f64::from(view.scale);
    let clip = |corner: DVec2, distance: f64| -> DVec4 {
        let across = corner * half * if is_perspective { distance } else { 1.0 };
        clip_from_view * DVec3::new(across.x, across.y, -distance).extend(1.0)
    };
    let middle = near + 0.25 * (far - near);
    for corner in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(DVec2::from_array) {
        let [first, last] = [middle, far].map(|distance| clip(corner, distance));
        if !(first.w > 0.0 && last.w > 0.0) {
            return Err("its camera does not see all of the view");
        }
        let [first, last] = [first, last].map(|at| at.truncate().truncate() / at.w);
        let astray = (first - last).abs() * host_size.as_dvec2() * 0.5;
        if astray.is_nan() || astray.max_element() > ASTRAY {
            return Err("its camera must see along the view's own rays");
        }
        if last.abs().max_element() > 1.0 + 1e-5 {
            return Err("it does not cover the view");
        }
    }
    let depth_at = |distance: f64| clip(DVec2::ZERO, distance).z / clip(DVec2::ZERO, distance).w;
    Ok(ImportParams {
        clip_from_view: clip_from_view.as_mat4(),
        size: view.size.as_vec2(),
        host_size: host_size.as_vec2(),
        scale: view.scale,
        perspective: f32::from(u8::from(is_perspective)),
        near: view.near,
        far: view.far,
        // Reversed, it falls.
        empty: if depth_at(far) < depth_at(middle) { 0.0 } else { 1.0 },
        ..ImportParams::zeroed()
    })
}

/// Depth maps of a batch's views, bound.
#[derive(Debug)]
pub(super) struct Imports(Vec<(BindGroup, UVec2)>);

impl Imports {
    /// `depths`: with indices into `views`. `is_rendered`: our own opaque casters render the batch's
    /// depths in each frame.
    pub(super) fn new(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        views: &[GpuView],
        depths: &[(usize, DepthInput)],
        is_rendered: bool,
    ) -> Result<Self, Error> {
        let mut bind = |(view, input): &(usize, DepthInput)| {
            let view = &views[*view];
            let values = ImportParams {
                origin: view.origin,
                layer: view.layer,
                replaces: u32::from(input.instead || !is_rendered),
                ..input.params
            };
            let params = context.uniform("import_params", &values);
            let resources = Resources::new()
                .with("import_params", &params)
                .with("host_depths", &input.texture)
                .with("opaques", &maps.opaques);
            let kernel = &context.kernels.import_depths;
            let bindings = kernel.bind(context.allocator.device, &resources)?;
            Ok((bindings, view.size.as_uvec2()))
        };
        depths.iter().map(&mut bind).collect::<Result<_, Error>>().map(Self)
    }

    pub(super) fn record(&self, kernels: &Kernels, pass: &mut wgpu::ComputePass<'_>) {
        for (bindings, size) in &self.0 {
            kernels.import_depths.record(pass, bindings, import::grid(*size));
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
