//! `gobo bench --stage mask`: shadows through masks, compared with PCF of 5 x 5 in shading.
use super::{arguments::BenchArguments, clock::Times};
use crate::{failure::Failure, files, output};
use gobo::{
    Camera, Light, LightKind, Material, Receiver, ShadowSettings, Transfer, Triangle,
    glam::{UVec2, Vec2, Vec3},
    model::{MaskSettings, ShadowFilter},
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;
use serde::Serialize;

/// Sizes of the pictures [pixels].
const SIZES: [UVec2; 2] = [UVec2::new(1280, 720), UVec2::new(1920, 1080)];
const LIGHTS: [u32; 4] = [1, 4, 16, 64];
const TAPS: u32 = 11;
/// Half the edge of the ground [m].
const HALF: f32 = 8.0;

/// Time of a picture's shadows [ms]: the difference to the same picture without shadows.
#[derive(Clone, Copy, Debug, Serialize)]
struct MaskRow {
    width: u32,
    height: u32,
    lights: u32,
    /// Time of the picture without shadows.
    base_ms: f64,
    /// PCF of 5 x 5 bilinear taps in shading.
    pcf_ms: f64,
    /// Masks at the picture's size, with 2 x 2 taps and a blur of 11 taps.
    full_ms: f64,
    /// Time with masks of half the size.
    half_ms: f64,
    masks: u64,
}

/// Prints the results, and writes them as JSON with `--json`.
pub(super) fn run(arguments: &BenchArguments) -> Result<(), Failure> {
    let mut renderer = arguments.device.renderer()?;
    files::print(&format!("{}, ms of shadows in the picture", renderer.device()))?;
    let columns = ["lights", "picture", "pcf 5x5", "full", "half", "pcf/full", "pcf/half", "masks"];
    let columns: Vec<_> = columns.iter().map(|name| format!("{name:>9}")).collect();
    files::print(&format!("{:>10}{}", "size", columns.join(" ")))?;
    let counts = if arguments.lights == [1] { LIGHTS.to_vec() } else { arguments.lights.clone() };
    let mut rows = Vec::new();
    for size in SIZES {
        for &lights in &counts {
            let row = measure(&mut renderer, arguments.runs, size, lights)?;
            files::print(&line(&row))?;
            rows.push(row);
        }
    }
    if let Some(path) = &arguments.json {
        let text = serde_json::to_string_pretty(&rows).expect("plain data is JSON");
        output::write(path, (text + "\n").as_bytes())?;
    }
    Ok(())
}

fn line(row: &MaskRow) -> String {
    let MaskRow { width, height, lights, base_ms, pcf_ms, full_ms, half_ms, masks } = *row;
    let times = [base_ms, pcf_ms, full_ms, half_ms].map(|ms| format!("{ms:>9.1}")).join(" ");
    let size = format!("{width}x{height}");
    let (full, half) = (pcf_ms / full_ms, pcf_ms / half_ms);
    format!("{size:>10}{lights:>9} {times} {full:>9.2} {half:>9.2} {masks:>9}")
}

/// Median over `runs`; the variants are rendered in turns.
fn measure(
    renderer: &mut Renderer,
    runs: u32,
    size: UVec2,
    lights: u32,
) -> Result<MaskRow, Failure> {
    let masks = |half| Some(MaskSettings { half, taps: TAPS, ..MaskSettings::default() });
    let pcf = ShadowFilter::Pcf { taps: 5 };
    let ways = [
        scene(size, lights, false, ShadowFilter::Bilinear, None),
        scene(size, lights, true, pcf, None),
        scene(size, lights, true, ShadowFilter::Bilinear, masks(false)),
        scene(size, lights, true, ShadowFilter::Bilinear, masks(true)),
    ];
    let mut times = [const { Vec::new() }; 4];
    let mut used = 0;
    for run in 0..=runs {
        for (scene, times) in ways.iter().zip(&mut times) {
            let frame = renderer.render(scene, &RenderOptions::default())?;
            let picture = frame.stages.iter().find(|(name, _)| *name == "picture");
            used = used.max(frame.counters.masks);
            // The first frame creates the kernels.
            if run > 0 {
                times.push(picture.map_or(0.0, |(_, ms)| *ms));
            }
        }
    }
    let [base, pcf, full, half] = times.map(|times| Times::new(times).median);
    Ok(MaskRow {
        width: size.x,
        height: size.y,
        lights,
        base_ms: base,
        pcf_ms: pcf - base,
        full_ms: full - base,
        half_ms: half - base,
        masks: used,
    })
}

/// Columns on a ground, under a square grid of lamps: up to four reach all of it, more reach a part each.
fn scene(
    size: UVec2,
    lights: u32,
    casts: bool,
    filter: ShadowFilter,
    mask: Option<MaskSettings>,
) -> Scene {
    let mut scene = Scene {
        camera: Camera {
            eye: Vec3::new(0.0, 7.0, 11.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov_y: 0.8,
            size,
        },
        shadow: ShadowSettings {
            size: 512,
            filter,
            receiver: Receiver::Nearest,
            ..ShadowSettings::default()
        },
        materials: vec![Material { transfer: Transfer::Opaque, ..Material::default() }],
        mask,
        ..Scene::default()
    };
    let ground = [Vec3::new(-HALF, 0.0, HALF), Vec3::X * 2.0 * HALF, Vec3::NEG_Z * 2.0 * HALF];
    scene.triangles.extend(rectangle(ground));
    for i in 0..64_u8 {
        let at = Vec2::new(f32::from(i % 8), f32::from(i / 8)) * 2.0 - 7.0;
        for (x, z) in [(1.0, 0.0), (0.0, 1.0)] {
            let right = Vec3::new(x, 0.0, z) * 0.4;
            let corner = Vec3::new(at.x, 0.0, at.y) - right * 0.5;
            scene.triangles.extend(rectangle([corner, right, Vec3::Y * 1.2]));
        }
    }
    let side = f64::from(lights).sqrt().ceil() as u32;
    let spacing = 2.0 * HALF / side as f32;
    // Neighbouring lamps overlap.
    let far = if side <= 2 { 4.0 * HALF } else { spacing * 1.5 + 1.0 };
    let lamp = |i: u32| {
        let at = (Vec2::new((i % side) as f32, (i / side) as f32) + 0.5) * spacing - HALF;
        let position = Vec3::new(at.x, 2.2, at.y);
        let direction = Vec3::NEG_Y;
        Light {
            name: format!("lamp{i}"),
            intensity: 4.0,
            far: Some(far),
            size: Some(512),
            casts,
            ..Light {
                kind: LightKind::Spot { position, direction, angle: 2.2 },
                ..Light::default()
            }
        }
    };
    scene.lights = (0..lights).map(lamp).collect();
    scene
}

/// Rectangle with a corner and two edges.
fn rectangle([corner, right, up]: [Vec3; 3]) -> [Triangle; 2] {
    let (far, normal) = (corner + right + up, right.cross(up).normalize());
    let half =
        |positions: [Vec3; 3]| Triangle { normals: [normal; 3], ..Triangle::flat(positions, 0) };
    [half([corner, corner + right, far]), half([corner, far, corner + up])]
}
