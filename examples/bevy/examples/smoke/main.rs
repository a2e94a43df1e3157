//! Smoke from a compute kernel and panes of glass cast coloured shadows on Bevy's meshes.
//!
//! `cargo run --example smoke -- 40 bevy.png` (in the crate's folder, or `make bevy`) renders 40 frames
//! without a window and writes the last. It fails if the light behind a pane lacks the pane's colour.
mod draw;
mod smoke;

use bevy::{
    camera::{Hdr, RenderTarget},
    core_pipeline::tonemapping::Tonemapping,
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
use bevy_gobo::{ColoredShadows, GoboCaster, GoboMaterial, GoboPlugin, lit};
use draw::SmokePlugin;
use std::{
    collections::BTreeSet,
    path::PathBuf,
    process::ExitCode,
    sync::mpsc::{Sender, channel},
};

const SIZE: [u32; 2] = [960, 600];
/// Fewest colours of a picture that is not blank.
const FEWEST_COLORS: usize = 256;
/// Positions of the panes [m], red, green and blue.
const PANES: [[f32; 3]; 3] = [[-0.8, 0.9, 0.5], [0.2, 0.9, -0.2], [1.2, 0.9, -0.9]];
/// Least ratio of a pane's channel to the others behind it.
const LEAST_COLORED: f32 = 1.4;

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
    let gobo = GoboPlugin { bounds: [[-6.0, 0.0, -6.0], [6.0, 3.5, 6.0]], ..default() };
    app.add_plugins((plugins, gobo, SmokePlugin))
        .insert_resource(ClearColor(Color::srgb(0.30, 0.38, 0.50)))
        .insert_resource(GlobalAmbientLight { brightness: 250.0, ..default() })
        .add_systems(Startup, set_the_scene)
        .add_systems(Update, turn_the_sun);
    app.finish();
    app.cleanup();
    (1..frames).for_each(|_| app.update());
    let behind = pixels_behind_panes(&mut app)?;

    let (sender, received) = channel();
    let target = app.world().resource::<Target>().0.clone();
    app.world_mut().spawn(Screenshot::image(target)).observe(save_to(path, behind, sender));
    // The picture comes some frames later, in which the sun hardly turns.
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
    mut materials: ResMut<Assets<GoboMaterial>>,
    mut plain: ResMut<Assets<StandardMaterial>>,
) {
    let [width, height] = SIZE;
    let target = Image::new_target_texture(width, height, TextureFormat::Rgba8UnormSrgb, None);
    let target = images.add(target);
    commands.insert_resource(Target(target.clone()));
    commands.spawn((
        Camera3d::default(),
        ColoredShadows,
        Msaa::Off,
        RenderTarget::from(target),
        Hdr,
        Tonemapping::Reinhard,
        Transform::from_xyz(2.6, 2.1, 4.2).looking_at(Vec3::new(0.0, 0.6, 0.0), Vec3::Y),
    ));
    commands.spawn((DirectionalLight { illuminance: 9000.0, ..default() }, Transform::default()));
    let mut matt = |color: Color| {
        let (perceptual_roughness, reflectance) = (0.9, 0.2);
        let base =
            StandardMaterial { base_color: color, perceptual_roughness, reflectance, ..default() };
        MeshMaterial3d(materials.add(lit(base)))
    };
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(12.0, 12.0))),
        matt(Color::srgb(0.82, 0.80, 0.78)),
        GoboCaster::Blocks,
    ));
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.35))),
        matt(Color::srgb(0.85, 0.85, 0.85)),
        Transform::from_xyz(-2.3, 0.35, -0.4),
        GoboCaster::Blocks,
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cuboid::new(0.5, 1.1, 0.5))),
        matt(Color::srgb(0.75, 0.78, 0.85)),
        Transform::from_xyz(1.9, 0.55, -1.5).with_rotation(Quat::from_rotation_y(0.5)),
        GoboCaster::Blocks,
    ));
    let glass = meshes.add(Plane3d::default().mesh().size(0.9, 0.9));
    for (place, channel) in PANES.into_iter().zip(0..) {
        let mut rgb = [0.08; 3];
        rgb[channel] = 0.95;
        let color = LinearRgba::from_f32_array_no_alpha(rgb);
        commands.spawn((
            Mesh3d(glass.clone()),
            MeshMaterial3d(plain.add(StandardMaterial {
                base_color: color.with_alpha(0.35).into(),
                alpha_mode: AlphaMode::Blend,
                cull_mode: None,
                ..default()
            })),
            Transform::from_translation(place.into()),
            GoboCaster::Tints(color),
        ));
    }
}

/// Turns the sun slowly, by the number of the frame: each run is the same.
fn turn_the_sun(mut sun: Query<&mut Transform, With<DirectionalLight>>, mut number: Local<u32>) {
    *number += 1;
    let (sine, cosine) = (-0.85 + *number as f32 * 0.004).sin_cos();
    for mut place in &mut sun {
        place.look_to(Vec3::new(0.9 * sine, -1.0, 0.9 * cosine), Vec3::Y);
    }
}

/// Pixels of the ground in sunlight through the middle of a pane.
fn pixels_behind_panes(app: &mut App) -> Result<[UVec2; 3], String> {
    let mut suns = app.world_mut().query_filtered::<&Transform, With<DirectionalLight>>();
    let sun = suns.single(app.world()).map_err(|error| error.to_string())?.forward();
    let mut cameras = app.world_mut().query::<(&Camera, &GlobalTransform)>();
    let (camera, place) = cameras.single(app.world()).map_err(|error| error.to_string())?;
    let mut pixels = [UVec2::ZERO; 3];
    for (pixel, pane) in pixels.iter_mut().zip(PANES.map(Vec3::from)) {
        let ground = pane + sun * (pane.y / -sun.y);
        let at = camera.world_to_viewport(place, ground).map_err(|error| format!("{error:?}"))?;
        *pixel = at.as_uvec2();
    }
    Ok(pixels)
}

fn save_to(
    path: PathBuf,
    behind: [UVec2; 3],
    done: Sender<Result<String, String>>,
) -> impl FnMut(On<ScreenshotCaptured>) {
    move |captured| {
        let outcome = (|| {
            let picture = captured.image.clone().try_into_dynamic().map_err(|e| e.to_string())?;
            let picture = picture.to_rgb8();
            let colors: BTreeSet<_> = picture.pixels().map(|pixel| pixel.0).collect();
            picture.save(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            if colors.len() < FEWEST_COLORS {
                return Err(format!("the picture has {} colours only", colors.len()));
            }
            for (channel, at) in behind.into_iter().enumerate() {
                let color = picture.get_pixel(at.x, at.y).0.map(f32::from);
                let others = (0..3).filter(|&other| other != channel).map(|other| color[other]);
                if color[channel] < LEAST_COLORED * others.fold(0.0, f32::max) {
                    return Err(format!("behind pane {channel}, at {at}, light is {color:?}"));
                }
            }
            Ok(format!("the last in {} with {} colours", path.display(), colors.len()))
        })();
        // A receiver that no longer waits need not know.
        let _ = done.send(outcome);
    }
}
