//! gobo as a plugin: it borrows Bevy's device, queue and encoders, and submits nothing.
use crate::{passes::Passes, smoke::Smoke};
use bevy::{
    core_pipeline::{
        Core3dSystems,
        prepass::ViewPrepassTextures,
        schedule::{Core3d, camera_driver},
    },
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        extract_resource::{ExtractResource, ExtractResourcePlugin},
        renderer::{
            RenderAdapterInfo, RenderContext, RenderDevice, RenderGraph, RenderQueue, ViewQuery,
        },
        view::{ExtractedView, ViewTarget},
    },
};
use gobo::{Bounds, Casters, HostInputs, Light, Material, Prepared, Receiver, ShadowSettings, Shadows, Support, Tier, Transfer, Triangle, host::LightBindings};
use std::sync::Arc;

/// What casts and receives, world space [m].
const BOUNDS: [[f32; 3]; 2] = [[-6.0, 0.0, -6.0], [6.0, 3.5, 6.0]];

/// Adds what Bevy's own lights leave out: a sun whose light goes through smoke.
pub struct GoboPlugin;

/// The light.
#[derive(Resource, Clone, ExtractResource)]
#[extract_app(RenderApp)]
pub struct Sun {
    /// Of travel, of any length: world space.
    pub direction: Vec3,
}

impl Default for Sun {
    fn default() -> Self {
        Self { direction: Vec3::NEG_Y }
    }
}

/// A mesh that no light goes through.
#[derive(Component)]
pub struct BlocksLight;

/// Corners of the triangles of all meshes that block light, world space [m].
#[derive(Resource, Clone, Default, ExtractResource)]
#[extract_app(RenderApp)]
struct Blockers(Arc<Vec<[[f32; 3]; 3]>>);

impl Plugin for GoboPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Sun>()
            .init_resource::<Blockers>()
            .add_plugins((
                ExtractResourcePlugin::<Sun>::default(),
                ExtractResourcePlugin::<Blockers>::default(),
            ))
            .add_systems(PostUpdate, gather.after(TransformSystems::Propagate));
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
        render_app
            .add_systems(RenderStartup, open)
            .add_systems(Render, prepare.in_set(RenderSystems::PrepareResources))
            .add_systems(RenderGraph, record.before(camera_driver))
            .add_systems(
                Core3d,
                light.after(Core3dSystems::MainPass).before(Core3dSystems::EarlyPostProcess),
            );
    }
}

/// Meshes that have moved, to triangles.
fn gather(
    moved: Query<(), (With<BlocksLight>, Changed<GlobalTransform>)>,
    all: Query<(&Mesh3d, &GlobalTransform), With<BlocksLight>>,
    meshes: Res<Assets<Mesh>>,
    mut blockers: ResMut<Blockers>,
) {
    if moved.is_empty() {
        return;
    }
    let mut corners = Vec::new();
    for (mesh, place) in &all {
        let Some(Ok(triangles)) = meshes.get(&mesh.0).map(Mesh::triangles) else { continue };
        let world = |corner| place.transform_point(corner).to_array();
        corners.extend(triangles.map(|triangle| triangle.vertices.map(world)));
    }
    blockers.0 = Arc::new(corners);
}

/// gobo, and the passes around it.
#[derive(Resource)]
struct Guest {
    shadows: Shadows,
    smoke: Smoke,
    frame: Option<Frame>,
    passes: Option<Passes>,
}

/// Holds as long as sun and blockers stay.
struct Frame {
    prepared: Prepared,
    bound: LightBindings,
}

fn settings() -> ShadowSettings {
    ShadowSettings { size: 512, receiver: Receiver::Curve, nodes: 8, ..Default::default() }
}

fn open(
    mut commands: Commands,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    adapter: Res<RenderAdapterInfo>,
) {
    // Bevy has opened the device: what it lacks nobody can add.
    let support = Support::of(device.wgpu_device(), &adapter, &settings());
    for missing in &support.missing {
        info!("gobo does without {missing}");
    }
    let opened = support.check(Tier::Core).and_then(|_| {
        let mut shadows = Shadows::new(device.wgpu_device(), &queue, &adapter)?;
        let smoke = Smoke::new(device.wgpu_device(), &mut shadows)?;
        Ok(Guest { shadows, smoke, frame: None, passes: None })
    });
    match opened {
        Ok(guest) => commands.insert_resource(guest),
        Err(error) => error!("no coloured shadows: {error}"),
    }
}

/// Uploads blockers and fits the view where something has changed. The smoke is on the device already.
fn prepare(
    guest: Option<ResMut<Guest>>,
    sun: Res<Sun>,
    blockers: Res<Blockers>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let Some(mut guest) = guest else { return };
    guest.smoke.next_frame(&queue);
    if guest.frame.is_some() && !sun.is_changed() && !blockers.is_changed() {
        return;
    }
    if let Err(error) = guest.prepare(&sun, &blockers, device.wgpu_device()) {
        error!("no coloured shadows: {error}");
        guest.frame = None;
    }
}

impl Guest {
    fn prepare(
        &mut self,
        sun: &Sun,
        blockers: &Blockers,
        device: &gobo::wgpu::Device,
    ) -> Result<(), gobo::Error> {
        // glam's types are not the same in both: arrays are.
        let lights = [Light::directional(sun.direction.to_array())];
        let [min, max] = BOUNDS;
        let bounds = Bounds::new(min, max);
        let views = gobo::light_views(0, &lights[0], settings().size, None, &bounds)?;
        let materials =
            [Material::default(), Material { transfer: Transfer::Opaque, ..Default::default() }];
        let triangles: Vec<_> = blockers.0.iter().map(|&c| Triangle::flat(c, 1)).collect();
        let casters =
            Casters { triangles: &triangles, materials: &materials, ..Casters::default() };
        let sets = [self.smoke.casters()];
        let inputs = HostInputs::new().casters(&sets);
        let prepared = self.shadows.prepare_with(&casters, &views, &settings(), &inputs)?;
        let bound = prepared.bind_lights(&lights, &[0])?;
        if self.passes.is_none() {
            let text = prepared.maps().wgsl(1, "gobo_")?;
            self.passes = Some(Passes::new(device, &text, &bound.layout, &self.smoke));
        }
        self.frame = Some(Frame { prepared, bound });
        Ok(())
    }
}

/// Once a frame, before all cameras: the smoke moves, and the maps see it.
fn record(guest: Option<Res<Guest>>, mut context: RenderContext) {
    let Some(guest) = guest else { return };
    if let Some(frame) = &guest.frame {
        let encoder = context.command_encoder();
        guest.smoke.record(encoder);
        if let Err(error) = frame.prepared.record(encoder) {
            error!("{error}");
        }
    }
}

/// Once a camera, before its post processing: the sun's light, and the smoke.
fn light(
    view: ViewQuery<(&ViewTarget, &ViewPrepassTextures, &ExtractedView)>,
    guest: Option<Res<Guest>>,
    sun: Res<Sun>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    mut context: RenderContext,
) {
    let (target, prepass, view) = view.into_inner();
    let Some(guest) = guest else { return };
    let (Some(frame), Some(passes)) = (&guest.frame, &guest.passes) else { return };
    let (Some(depths), Some(normals)) = (prepass.depth_only_view(), prepass.normal_view()) else {
        return;
    };
    let world_from_view = view.world_from_view.to_matrix();
    let clip_from_world =
        view.clip_from_world.unwrap_or_else(|| view.clip_from_view * world_from_view.inverse());
    let right = world_from_view.x_axis.truncate();
    let up = world_from_view.y_axis.truncate();
    passes.write(&queue, clip_from_world, [right, up], sun.direction.normalize_or(Vec3::NEG_Y));
    let picture = target.post_process_write();
    let inputs = [picture.source, depths, normals].map(|view| &**view);
    let encoder = context.command_encoder();
    passes.record(device.wgpu_device(), encoder, inputs, picture.destination, &frame.bound.group);
}
