//! Import of the host's depth maps into the opaque depths of a batch.
use crate::shadows::{
    batch::context::Context,
    views::{host_depths::DepthInput, maps::Maps},
};
use crate::{
    error::Error,
    frame::Dispatch,
    gpu::Resources,
    records::{GpuView, ImportParams},
    stage::{features::Features, import},
};
use wgpu::Buffer;

/// The import of a batch's depth maps, each with the buffer of its parameters. `depths`: with indices into
/// `views`. `is_rendered`: our own opaque casters render the batch's depths in each frame.
pub(in crate::shadows) fn imports(
    context: &mut Context<'_, '_>,
    maps: &Maps,
    views: &[GpuView],
    depths: &[(usize, DepthInput)],
    is_rendered: bool,
) -> Result<Vec<(Dispatch, Buffer)>, Error> {
    let mut import = |(view, input): &(usize, DepthInput)| {
        let view = &views[*view];
        let params = context.allocator.uniform("import_params", &params(view, input, is_rendered));
        let resources = Resources::new()
            .with("import_params", &params)
            .with("host_depths", &input.texture)
            .with("opaques", &maps.opaques);
        let groups = import::grid(view.size.as_uvec2());
        let import =
            context.kernels.dispatch(&import::DEPTHS, Features::NONE, &resources, groups)?;
        Ok((import, params))
    };
    depths.iter().map(&mut import).collect()
}

pub(super) fn params(view: &GpuView, input: &DepthInput, is_rendered: bool) -> ImportParams {
    ImportParams {
        origin: view.origin,
        layer: view.layer,
        replaces: u32::from(input.instead || !is_rendered),
        ..input.params
    }
}
