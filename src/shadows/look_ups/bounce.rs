//! Light that lit surfaces send on: points of the maps as sources.
use super::caustics::{LABEL, face_buffer, grid, of_faces};
use crate::{
    error::Error,
    frame::Commands,
    gpu::Allocator,
    model::{Casters, Light, MAX_BOUNCES, View, ViewRole},
    records::{BOUNCE_LENGTH, BOUNCE_SAMPLES, BounceParams, GpuLight, GpuView, solid_faces},
    shadows::{Prepared, batch::context::view_uniform},
    stage::{
        caustics::{BOUNCE, CausticParams, SOLID_DEPTHS, SOLID_OWNERS, TEXEL_LANES},
        features::Features,
    },
};
use glam::{Vec2, Vec4};
use wgpu::{Buffer, BufferUsages};

/// Points that send light on.
pub(super) struct Bounces {
    /// Their vectors, after the head.
    pub buffer: Buffer,
}

impl View {
    /// Whether points of its map send light on, if those of its light do: of cascades only the last does.
    pub fn sends_light_on(&self, light: &Light) -> bool {
        let is_own = self.shadow_index(light) == 0;
        is_own && !matches!(self.role, ViewRole::Window { index, count, .. } if index + 1 < count)
    }
}

impl GpuView {
    /// The view with a map of `edge` texels a side.
    #[must_use]
    pub fn with_edge(&self, edge: u32) -> Self {
        let size = Vec2::splat(edge as f32);
        Self { scale: self.scale * size.x / self.size.x, size, ..*self }
    }
}

impl Bounces {
    pub(super) fn new(
        prepared: &Prepared,
        allocator: &mut Allocator<'_>,
        commands: &mut Commands,
        lights: &[Light],
        casters: &Casters<'_>,
    ) -> Result<Self, Error> {
        let bounce = |view: &View| {
            let light = &lights[view.light.filter(|&index| index < lights.len())?];
            (light.bounce > 0 && view.sends_light_on(light)).then_some(light)
        };
        let gpu_views = prepared.gpu_views();
        let sending: Vec<(&Light, &GpuView)> = prepared
            .views()
            .iter()
            .zip(&gpu_views)
            .filter_map(|(view, gpu_view)| Some((bounce(view)?, gpu_view)))
            .collect();
        let count: u32 = sending.iter().map(|(light, _)| light.bounce.pow(2)).sum();
        let remedy = "lower the bounce of some lights";
        let most = u64::from(MAX_BOUNCES);
        Error::check_limit("points that send light on", most, count.into(), remedy)?;
        let usage = BufferUsages::UNIFORM;
        let buffer = allocator.storage::<Vec4>("bounces", BOUNCE_LENGTH.into(), usage)?;
        let head = [Vec4::new(f32::from_bits(count), 0.0, 0.0, 0.0)];
        let head = allocator.filled("bounce_count", &head, BufferUsages::COPY_SRC);
        commands.copy_buffer(LABEL, (&head, 0), (&buffer, 0), head.size());
        if count == 0 {
            return Ok(Self { buffer });
        }
        let faces = solid_faces(casters);
        let (_, queue) = prepared.device();
        let kernels = prepared.kernels_on(None);
        let samples = BOUNCE_SAMPLES * BOUNCE_SAMPLES * MAX_BOUNCES;
        let pairs = 2 * u64::from(samples);
        let depths = allocator.storage::<u32>("solid_depths", pairs, BufferUsages::COPY_SRC)?;
        let owners = allocator.storage::<u32>("solid_owners", pairs, BufferUsages::COPY_SRC)?;
        let resources = prepared
            .maps()
            .resources()
            .with("glass", &face_buffer(allocator, queue, &faces)?)
            .with("glass_depths", &depths)
            .with("glass_owners", &owners)
            .with("bounced", &buffer);
        let face_count = faces.len() as u32;
        let (slices, of_faces) = of_faces(face_count);
        let mut first = 0;
        for (light, view) in sending {
            let params =
                CausticParams { first: 0, base: 0, number: 0, face_count, rays: 0, slices };
            let params = allocator.uniform("caustic_params", &params);
            let light_record = GpuLight::new(light, 0..0, &prepared.settings);
            let edge = light.bounce;
            let of_bounce = BounceParams { light: light_record, first, edge, pad_0: 0, pad_1: 0 };
            let of_bounce = allocator.uniform("bounce_params", &of_bounce);
            let views = view_uniform(allocator, &[view.with_edge(BOUNCE_SAMPLES * edge), *view]);
            let resources = resources
                .clone()
                .with("caustic_params", &params)
                .with("bounce_params", &of_bounce)
                .with("views", &views);
            let of_points = grid(edge.pow(2).div_ceil(TEXEL_LANES), 1);
            commands.clear(LABEL, &depths);
            commands.clear(LABEL, &owners);
            let none = Features::NONE;
            let searches = [
                kernels.dispatch(&SOLID_DEPTHS, none, &resources, of_faces)?,
                kernels.dispatch(&SOLID_OWNERS, none, &resources, of_faces)?,
                kernels.dispatch(&BOUNCE, none, &resources, of_points)?,
            ];
            commands.pass(LABEL, searches);
            first += edge.pow(2);
        }
        Ok(Self { buffer })
    }
}
