//! gobo in Bevy: smoke of a compute kernel throws coloured shadows in Bevy's picture.
//!
//! `cargo run -- 40 bevy.png` (in this folder, or `make bevy`) renders 40 frames without a window and writes the last.
mod passes;
mod plugin;
mod smoke;

use bevy::{
    camera::{Hdr, RenderTarget},
    core_pipeline::{
        prepass::{DepthPrepass, NormalPrepass},
        tonemapping::Tonemapping,
    },
    light::GlobalAmbientLight,
    prelude::*,
    render::{
        RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::TextureFormat,
        view::screenshot::{Screenshot, ScreenshotCaptured},
    },
    window::ExitCondition,
};
use plugin::{BlocksLight, GoboPlugin, Sun};
use std::{
    collections::BTreeSet,
    path::PathBuf,
    process::ExitCode,
    sync::mpsc::{Sender, channel},
};

const SIZE: [u32; 2] = [960, 600];
/// Of a picture that shows something.
const FEWEST_COLORS: usize = 256;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let frames: u32 = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(60);
    let path = PathBuf::from(arguments.next().unwrap_or_else(|| "bevy.png".to_owned()));
    match run(frames.max(1), path) {
        Ok(done) => {
            println!("{frames} frames, {done}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("bevy: {error}");
            ExitCode::FAILURE
        }
    }
}

#[derive(Resource)]
struct Target(Handle<Image>);

fn run(frames: u32, path: PathBuf) -> Result<String, String> {
    let mut app = App::new();
    let window =
        WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let render = RenderPlugin { synchronous_pipeline_compilation: true, ..default() };
    let plugins = DefaultPlugins.set(window).set(render).disable::<PipelinedRenderingPlugin>();
    app.add_plugins((plugins, GoboPlugin))
        .insert_resource(ClearColor(Color::srgb(0.30, 0.38, 0.50)))
        .insert_resource(GlobalAmbientLight { brightness: 250.0, ..default() })
        .add_systems(Startup, set_the_scene)
        .add_systems(Update, turn_the_sun);
    app.finish();
    app.cleanup();
    (1..frames).for_each(|_| app.update());

    let (sender, received) = channel();
    let target = app.world().resource::<Target>().0.clone();
    app.world_mut().spawn(Screenshot::image(target)).observe(save_to(path, sender));
    // The picture comes some frames later.
    for _ in 0..10 {
        app.update();
        if let Ok(outcome) = received.try_recv() {
            return outcome;
        }
    }
    Err("no picture came back".to_owned())
}

fn set_the_scene(
    mut commands: Commands,
    mut images: ResMut<Assets<Image>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let [width, height] = SIZE;
    let target = Image::new_target_texture(width, height, TextureFormat::Rgba8UnormSrgb, None);
    let target = images.add(target);
    commands.insert_resource(Target(target.clone()));
    commands.spawn((
        Camera3d::default(),
        RenderTarget::from(target),
        Hdr,
        Msaa::Off,
        // What the light pass reads.
        (DepthPrepass, NormalPrepass),
        Tonemapping::Reinhard,
        Transform::from_xyz(2.6, 2.1, 4.2).looking_at(Vec3::new(0.0, 0.6, 0.0), Vec3::Y),
    ));
    let mut matt = |color: StandardMaterial| {
        let rough = StandardMaterial { perceptual_roughness: 1.0, reflectance: 0.0, ..color };
        MeshMaterial3d(materials.add(rough))
    };
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(12.0, 12.0))),
        matt(Color::srgb(0.82, 0.80, 0.78).into()),
        BlocksLight,
    ));
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.35))),
        matt(Color::srgb(0.85, 0.85, 0.85).into()),
        Transform::from_xyz(-1.1, 0.35, 0.9),
        BlocksLight,
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cuboid::new(0.5, 1.1, 0.5))),
        matt(Color::srgb(0.75, 0.78, 0.85).into()),
        Transform::from_xyz(1.9, 0.55, -1.5).with_rotation(Quat::from_rotation_y(0.5)),
        BlocksLight,
    ));
}

/// Slowly, by the number of the frame: each run is the same.
fn turn_the_sun(mut sun: ResMut<Sun>, mut number: Local<u32>) {
    *number += 1;
    let (sine, cosine) = (-0.85 + *number as f32 * 0.004).sin_cos();
    sun.direction = Vec3::new(0.9 * sine, -1.0, 0.9 * cosine);
}

fn save_to(
    path: PathBuf,
    done: Sender<Result<String, String>>,
) -> impl FnMut(On<ScreenshotCaptured>) {
    move |captured| {
        let outcome = (|| {
            let picture = captured.image.clone().try_into_dynamic().map_err(|e| e.to_string())?;
            let picture = picture.to_rgb8();
            let colors: BTreeSet<_> = picture.pixels().map(|pixel| pixel.0).collect();
            picture.save(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            match colors.len() {
                0..FEWEST_COLORS => Err(format!("the picture has {} colours only", colors.len())),
                count => Ok(format!("the last in {} with {count} colours", path.display())),
            }
        })();
        // Who does not wait any more need not know.
        let _ = done.send(outcome);
    }
}
