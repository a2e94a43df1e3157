//! The plugin: systems of both worlds.
use crate::{
    casters::{SceneCasters, Sun, follow_sun, gather},
    guest::{Guest, Settings},
    material::{GoboMaterial, MASK, clear_mask, fit_mask},
};
use bevy::{
    asset::embedded_asset,
    core_pipeline::{
        Core3dSystems,
        prepass::{DepthPrepass, NormalPrepass, ViewPrepassTextures},
        schedule::{Core3d, camera_driver},
    },
    image::Image,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        extract_resource::ExtractResourcePlugin,
        render_asset::RenderAssets,
        renderer::{
            RenderAdapterInfo, RenderContext, RenderDevice, RenderGraph, RenderQueue, ViewQuery,
        },
        texture::GpuImage,
        view::ExtractedView,
    },
};
use gobo::{Bounds, ShadowSettings, model::MaskSettings};

/// Adds coloured shadows of the directional light to meshes of [`GoboMaterial`], in the picture of the camera
/// with [`ColoredShadows`].
#[derive(Clone, Copy, Debug)]
pub struct GoboPlugin {
    /// Map sizes, receivers and filters.
    pub shadow: ShadowSettings,
    /// Filters of the mask.
    pub mask: MaskSettings,
    /// Box around all casters and receivers, world space [m].
    pub bounds: [[f32; 3]; 2],
}

impl Default for GoboPlugin {
    fn default() -> Self {
        let mask = MaskSettings { half: false, ..MaskSettings::default() };
        Self {
            shadow: ShadowSettings::default(),
            mask,
            bounds: [[-10.0, -1.0, -10.0], [10.0, 6.0, 10.0]],
        }
    }
}

/// A camera with coloured shadows: one per app.
#[derive(Component, Clone, Copy, Debug, Default, ExtractComponent)]
#[extract_app(RenderApp)]
#[require(DepthPrepass, NormalPrepass)]
pub struct ColoredShadows;

/// Systems of the render world.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GoboSystems {
    /// In `RenderStartup`: makes [`Guest`].
    Open,
    /// In `Render`: makes the maps of the frame.
    Prepare,
}

impl Plugin for GoboPlugin {
    fn build(&self, app: &mut App) {
        embedded_asset!(app, "colored.wesl");
        let mut images = app.world_mut().resource_mut::<Assets<Image>>();
        if let Err(error) = images.insert(&MASK, clear_mask(UVec2::ONE)) {
            error!("no coloured shadows: {error}");
        }
        app.init_resource::<Sun>()
            .init_resource::<SceneCasters>()
            .add_plugins((
                MaterialPlugin::<GoboMaterial>::default(),
                ExtractResourcePlugin::<Sun>::default(),
                ExtractResourcePlugin::<SceneCasters>::default(),
                ExtractComponentPlugin::<ColoredShadows>::default(),
            ))
            .add_systems(
                PostUpdate,
                (gather, follow_sun, fit_mask).after(TransformSystems::Propagate),
            );
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
        let [min, max] = self.bounds;
        let bounds = Bounds::new(min, max);
        render_app
            .insert_resource(Settings { shadow: self.shadow, mask: self.mask, bounds })
            .add_systems(RenderStartup, open.in_set(GoboSystems::Open))
            .add_systems(
                Render,
                prepare.in_set(GoboSystems::Prepare).in_set(RenderSystems::PrepareResources),
            )
            .add_systems(RenderGraph, record.before(camera_driver))
            .add_systems(
                Core3d,
                mask.after(Core3dSystems::Prepass).before(Core3dSystems::MainPass),
            );
    }
}

fn open(
    mut commands: Commands,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    adapter: Res<RenderAdapterInfo>,
    settings: Res<Settings>,
) {
    match Guest::open(&device, &queue, &adapter, &settings) {
        Ok(guest) => commands.insert_resource(guest),
        Err(error) => error!("no coloured shadows: {error}"),
    }
}

fn prepare(
    guest: Option<ResMut<Guest>>,
    sun: Res<Sun>,
    scene: Res<SceneCasters>,
    settings: Res<Settings>,
    queue: Res<RenderQueue>,
) {
    let Some(mut guest) = guest else { return };
    let is_changed = sun.is_changed() || scene.is_changed();
    if let Err(error) = guest.prepare(*sun, &scene, &settings, is_changed, &queue) {
        error!("no coloured shadows: {error}");
        guest.forget();
    }
}

/// Records once a frame, before all cameras.
fn record(guest: Option<Res<Guest>>, mut context: RenderContext) {
    let Some(guest) = guest else { return };
    if let Err(error) = guest.record(context.command_encoder()) {
        error!("no coloured shadows: {error}");
    }
}

/// Records the camera's mask, between its prepass and its main pass.
fn mask(
    view: ViewQuery<(&ViewPrepassTextures, &ExtractedView), With<ColoredShadows>>,
    guest: Option<ResMut<Guest>>,
    images: Res<RenderAssets<GpuImage>>,
    settings: Res<Settings>,
    mut context: RenderContext,
) {
    let (prepass, view) = view.into_inner();
    let (Some(mut guest), Some(mask)) = (guest, images.get(&MASK)) else { return };
    let (Some(depths), Some(normals)) = (&prepass.depth, &prepass.normal) else { return };
    let world_from_view = view.world_from_view.to_matrix();
    let clip_from_world =
        view.clip_from_world.unwrap_or_else(|| view.clip_from_view * world_from_view.inverse());
    let inputs = [&*depths.texture.texture, &*normals.texture.texture];
    let encoder = context.command_encoder();
    if let Err(error) =
        guest.record_mask(encoder, clip_from_world, inputs, &mask.texture, &settings)
    {
        error!("no coloured shadows: {error}");
    }
}
