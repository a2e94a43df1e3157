//! Figures of the patterns: those in `docs/dither.md`, checked by the tests.
use gobo::{
    glam::{Mat4, UVec2, Vec2, Vec3, Vec4},
    model::{Material, Particle, Pattern, Profile, Projection, Scene, Transfer, View, ViewRole},
    records::ViewMaps,
};
use gobo_reference::{
    MapTexel,
    dither::{PatternPoint, threshold},
    light_by_channel, receive, render_maps,
};

/// Edge of the measured maps [texels]; a texel is a metre wide.
const SIZE: u32 = 128;
/// Radius of the caster [texels].
const RADIUS: f32 = 40.0;
/// Light depth of the receiver.
const RECEIVER: f32 = 0.9;
/// Frames of a moving caster.
const FRAMES: u32 = 60;

/// Error of the covered share over 64x64 cells, for 41 opacities and 8 casters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CoverageError {
    pub(crate) rms: f32,
    pub(crate) max: f32,
}

pub(crate) fn coverage_error(pattern: Pattern) -> CoverageError {
    const EDGE: u32 = 64;
    let step = Vec2::new(0.031, 0.017);
    let place = |i: u32| {
        let cell = UVec2::new(i % EDGE, i / EDGE);
        PatternPoint { cell: cell + EDGE * 1000, on_caster: cell.as_vec2() * step, step }
    };
    let (mut squares, mut max, mut count) = (0.0, 0.0_f32, 0);
    for id in 0..8 {
        let thresholds: Vec<f32> =
            (0..EDGE * EDGE).map(|i| threshold(pattern, 1, &place(i), id * 77)).collect();
        for level in 0..=40 {
            let a = level as f32 / 40.0;
            let covered = thresholds.iter().filter(|t| a > **t).count() as f32;
            let error = covered / thresholds.len() as f32 - a;
            squares += error * error;
            max = max.max(error.abs());
            count += 1;
        }
    }
    CoverageError { rms: (squares / count as f32).sqrt(), max }
}

/// A soft disc of opacity 0.8 over the map's centre, moved by `moved` texels.
fn disc(material: Material, moved: Vec2) -> Scene {
    let mut scene = gobo_scene::empty_scene();
    scene.materials =
        vec![Material { profile: Profile::Soft, tint: Vec4::new(0.0, 0.0, 0.0, 0.8), ..material }];
    scene.particles = vec![Particle {
        center: Vec3::new(0.3 + moved.x, 0.1 + moved.y, -5.0),
        radius: RADIUS,
        color: Vec4::ONE,
        rotation: 0.0,
        material: 0,
        id: 5,
    }];
    scene
}

fn dithered(pattern: Pattern) -> Material {
    Material { transfer: Transfer::Dither, pattern, ..Material::default() }
}

/// A view along -z, moved by `moved` texels.
fn view(moved: Vec2) -> View {
    View {
        role: ViewRole::Whole,
        light: Some(0),
        name: "0",
        projection: Projection::Orthographic,
        size: UVec2::splat(SIZE),
        near: 0.0,
        far: 10.0,
        view_from_world: Mat4::from_translation(-moved.extend(0.0)),
        scale: 1.0,
    }
}

fn maps(scene: &Scene, moved: Vec2) -> ViewMaps {
    render_maps(scene, &[view(moved)]).0.remove(0)
}

/// Red light at the receiver.
fn light(maps: &ViewMaps) -> Vec<f32> {
    const BIAS: f32 = 1e-3;
    let texels = maps.filter.iter().zip(&maps.nearest).zip(&maps.opaque).enumerate();
    texels
        .map(|(at, ((&filter, &nearest), &opaque))| {
            let texel = MapTexel { filter: filter.into(), nearest, opaque };
            let light = receive(RECEIVER, &texel, BIAS);
            let depths = maps.colored.get(at);
            depths.map_or(light, |d| light_by_channel(light, *d, RECEIVER, BIAS)).x
        })
        .collect()
}

/// Light of the texels under the caster.
fn under(light: &[f32]) -> impl Iterator<Item = f32> {
    let inside = |i: usize| {
        let at = Vec2::new((i as u32 % SIZE) as f32, (i as u32 / SIZE) as f32) + 0.5;
        (at - SIZE as f32 * 0.5).length() < RADIUS
    };
    light.iter().enumerate().filter(move |&(i, _)| inside(i)).map(|(_, &l)| l)
}

fn rms(a: &[f32], b: &[f32]) -> f32 {
    let (count, sum) = under(a)
        .zip(under(b))
        .fold((0, 0.0), |(count, sum), (a, b)| (count + 1, sum + (a - b) * (a - b)));
    (sum / count as f32).sqrt()
}

fn mean_difference(a: &[f32], b: &[f32]) -> f32 {
    let (count, sum) = under(a)
        .zip(under(b))
        .fold((0, 0.0), |(count, sum), (a, b)| (count + 1, sum + (a - b).abs()));
    sum / count as f32
}

/// Root mean square error of the light under a soft disc, against its exact filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ShadowError {
    pub(crate) dithered: f32,
    pub(crate) softened: f32,
}

pub(crate) fn shadow_error(pattern: Pattern) -> ShadowError {
    let exact = light(&maps(&disc(Material::default(), Vec2::ZERO), Vec2::ZERO));
    let mut scene = disc(dithered(pattern), Vec2::ZERO);
    let hard = light(&maps(&scene, Vec2::ZERO));
    scene.shadow.soften = true;
    let soft = light(&maps(&scene, Vec2::ZERO));
    ShadowError { dithered: rms(&hard, &exact), softened: rms(&soft, &exact) }
}

/// Mean |difference| of the light under a caster from one frame to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flicker {
    /// Dithered, while the caster moves by 1/8 texel per frame.
    pub(crate) dithered: f32,
    /// The same, softened.
    pub(crate) softened: f32,
    /// Share of the texels under a caster whose opaque depth changes in one such step.
    pub(crate) changed: f32,
    /// Softened, while the view moves by a whole texel per frame; at a fixed point in the world.
    pub(crate) snapping: f32,
}

/// Flicker of a pattern; `None`: of the exact filter.
pub(crate) fn flicker(pattern: Option<Pattern>) -> Flicker {
    let material = pattern.map_or_else(Material::default, dithered);
    let step = Vec2::new(0.1, 0.075);
    let mut sum = Flicker { dithered: 0.0, softened: 0.0, changed: 0.0, snapping: 0.0 };
    let frame = |moved: Vec2, of_view: Vec2, soften: bool| {
        let mut scene = disc(material.clone(), moved);
        scene.shadow.soften = soften;
        maps(&scene, of_view)
    };
    let frames = |soften: bool| {
        (0..=FRAMES).map(move |i| light(&frame(step * i as f32, Vec2::ZERO, soften))).collect()
    };
    let (hard, soft): (Vec<Vec<f32>>, Vec<Vec<f32>>) = (frames(false), frames(true));
    for i in 0..FRAMES as usize {
        let share = 1.0 / FRAMES as f32;
        sum.dithered += share * mean_difference(&hard[i], &hard[i + 1]);
        sum.softened += share * mean_difference(&soft[i], &soft[i + 1]);
        let changed = under(&hard[i]).zip(under(&hard[i + 1])).filter(|(a, b)| a != b).count();
        sum.changed += share * changed as f32 / under(&hard[i]).count() as f32;
    }
    let still = light(&frame(Vec2::ZERO, Vec2::ZERO, true));
    for i in 1..=8_usize {
        let snapped = light(&frame(Vec2::ZERO, Vec2::new(i as f32, 0.0), true));
        let mut back = still.clone();
        for y in 0..SIZE as usize {
            let row = y * SIZE as usize..(y + 1) * SIZE as usize;
            let whole = SIZE as usize - i;
            back[row.clone()][i..].copy_from_slice(&snapped[row][..whole]);
        }
        sum.snapping += mean_difference(&still, &back) / 8.0;
    }
    sum
}

/// Error of coloured dithering against the exact filter, over three coloured discs.
pub(crate) fn colored_error(pattern: Pattern) -> ShadowError {
    let mut scene = disc(Material { pattern, ..Material::default() }, Vec2::ZERO);
    scene.materials[0].tint = Vec4::new(0.9, 0.5, 0.2, 0.8);
    for (i, shift) in
        [Vec3::new(12.0, 4.0, 1.0), Vec3::new(-8.0, 10.0, 2.0)].into_iter().enumerate()
    {
        let first = scene.particles[0];
        let color = Vec4::new(0.3 + 0.6 * i as f32, 0.9 - 0.5 * i as f32, 0.8, 1.0);
        let id = 6 + i as u32;
        scene.particles.push(Particle { center: first.center + shift, color, id, ..first });
    }
    let exact = light(&maps(&scene, Vec2::ZERO));
    scene.materials[0].transfer = Transfer::Dither;
    scene.shadow.colored = true;
    let hard = light(&maps(&scene, Vec2::ZERO));
    scene.shadow.soften = true;
    let soft = light(&maps(&scene, Vec2::ZERO));
    ShadowError { dithered: rms(&hard, &exact), softened: rms(&soft, &exact) }
}

/// Edge of the map of the cost table [texels]; a texel is a metre wide.
pub(crate) const COST_SIZE: u32 = 512;

/// Material of the duplicated disc: so faint that no texel saturates, and every caster is walked.
pub(crate) fn duplicated() -> Material {
    Material {
        profile: Profile::Flat,
        tint: Vec4::new(1.0, 1.0, 1.0, 1.0 / 512.0),
        ..dithered(Pattern::default())
    }
}

/// Copies of one disc of 80 texels radius, one behind the other. All are in the same tiles: the first caster
/// of a tile costs more than the next ones.
pub(crate) fn duplicates(count: u32) -> Vec<Particle> {
    (0..count)
        .map(|id| Particle {
            center: Vec3::new(0.3, 0.1, -1.0 - 8.0 * id as f32 / count as f32),
            radius: 80.0,
            color: Vec4::ONE,
            rotation: 0.0,
            material: 0,
            id,
        })
        .collect()
}
