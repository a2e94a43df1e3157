//! Casters smaller than a texel absorb as much light as in a finer map, whatever their transfer.
use super::brute_force::assert_agrees;
use crate::common::{
    Tier,
    compare::Tolerance,
    map_frame_tiny,
    scenes::{Chance, empty, hold_view, light, material, particle, random_discs},
    tiers,
};
use gobo::{
    glam::{Vec2, Vec3},
    model::{Gaussian, LightKind, Material, Particle, Profile, Shape, Transfer},
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;
use std::f64::consts::PI;

const TRANSFERS: [Transfer; 4] =
    [Transfer::Filter, Transfer::Stain, Transfer::Smoke, Transfer::Gain];
const SHAPES: [Shape; 4] = [Shape::Disc, Shape::Quad, Shape::Puff, Shape::Gaussian];
const ALPHA: f64 = 0.8;
const COLOR: f64 = 0.5;
/// Amplification by `gain`.
const GAIN: f64 = 3.0;
/// Edge of the map, of a caster's square in it, and of the remaining border [texels].
const SIZE: usize = 640;
const AROUND: usize = 64;
const CELL: usize = 8;
/// Positions of a kind of caster within a texel; cells in a row.
const SHIFTS: usize = 256;
const CELLS: usize = (SIZE - 2 * AROUND) / CELL;

fn color(transfer: Transfer) -> f64 {
    if transfer == Transfer::Gain { GAIN } else { COLOR }
}

/// One material for each transfer and shape.
fn materials() -> Vec<Material> {
    let of = |transfer| {
        SHAPES.map(|shape| Material { shape, profile: Profile::Flat, ..material(transfer) })
    };
    TRANSFERS.iter().flat_map(|&transfer| of(transfer)).collect()
}

/// Kind of the caster in a cell, and its position within its texel.
fn of_cell(cell: usize) -> (usize, Vec2) {
    // Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": R2.
    let shift = (cell % SHIFTS + 1) as f64;
    let place = [0.754_877_666_246_693, 0.569_840_290_998_053]
        .map(|step| (0.5 + step * shift).fract() as f32);
    (cell / SHIFTS, place.into())
}

/// One caster in each cell of the map of a sun.
fn specks(radius: f32) -> Scene {
    let mut scene = empty([materials(), vec![material(Transfer::Opaque)]].concat());
    scene.lights.push(light(LightKind::Directional { direction: Vec3::NEG_Z }));
    scene.lights[0].size = Some(SIZE as u32);
    hold_view(&mut scene, 16);
    let texel = 1.0 / shadow_views(&scene)[0].scale;
    for cell in 0..CELLS * CELLS {
        let (kind, within) = of_cell(cell);
        let corner = Vec2::new((cell % CELLS) as f32, (cell / CELLS) as f32) * CELL as f32;
        let at = corner + (CELL / 2 + AROUND) as f32 + within - SIZE as f32 * 0.5;
        let center = (Vec2::new(at.x, -at.y) * texel).extend(-5.0);
        let rgb = Vec3::splat(color(TRANSFERS[kind / SHAPES.len()]) as f32);
        let material = kind as u32;
        if SHAPES[kind % SHAPES.len()] == Shape::Gaussian {
            let sigma = Vec3::splat(radius * texel);
            let opacity = ALPHA as f32;
            let gaussian =
                Gaussian { center, sigma, opacity, material, color: rgb, ..Gaussian::default() };
            scene.gaussians.push(gaussian);
        } else {
            let caster = particle(center, radius * texel, rgb.extend(ALPHA as f32));
            scene.particles.push(Particle { material, ..caster });
        }
    }
    scene
}

/// Sum of 1 - T over the plane [radii²]: of a shape at its own size, and of the enlarged one.
fn shadow(kind: usize, thin: f64) -> f64 {
    let (transfer, shape) = (TRANSFERS[kind / SHAPES.len()], SHAPES[kind % SHAPES.len()]);
    let c = color(transfer);
    let passed = |a: f64| match transfer {
        Transfer::Filter => 1.0 - a * (1.0 - c),
        Transfer::Stain => c * (1.0 - a),
        Transfer::Smoke => (1.0 - a) * (1.0 - a * (1.0 - c)),
        _ => c,
    };
    let taken = |a: f64| thin * (1.0 - passed(a));
    // By rings of equal area.
    const RINGS: u32 = 4000;
    let rings = |area: f64, taken: &dyn Fn(f64) -> f64| {
        let ring = |i: u32| taken((f64::from(i) + 0.5) / f64::from(RINGS));
        area * (0..RINGS).map(ring).sum::<f64>() / f64::from(RINGS)
    };
    match shape {
        Shape::Disc => PI * taken(ALPHA),
        Shape::Quad => 4.0 * taken(ALPHA),
        // The chord at the share x of the disc's area.
        Shape::Puff => rings(PI, &|x| 1.0 - (1.0 - taken(ALPHA)).powf((1.0 - x).sqrt())),
        _ => {
            let squared = f64::from(gobo::model::reach_squared(ALPHA as f32));
            rings(PI * squared, &|x| taken(ALPHA * (-0.5 * x * squared).exp()))
        }
    }
}

/// Tolerance [share of the shadow]: 256 positions measure a disc's area within 1.3 hundredths.
const TOLERANCE: f64 = 0.015;
/// Steps of stored values around 1; some adapters truncate them.
const STEP: f64 = 1.0 / 1024.0;

#[test]
fn specks_take_the_light_of_their_area() {
    for radius in [0.2_f32, 0.5] {
        let scene = specks(radius);
        let mut all = vec![render_maps(&scene, &shadow_views(&scene)).0];
        for scatter in [true, false] {
            let tiers = tiers(Tier::Native).into_iter();
            all.extend(tiers.map(|tier| map_frame_tiny(tier, &scene, scatter).maps));
        }
        for maps in all {
            let mut sums = vec![0.0; materials().len()];
            for (texel, filter) in maps[0].filter.iter().enumerate() {
                let place = [texel % SIZE, texel / SIZE].map(|at| at.wrapping_sub(AROUND) / CELL);
                if place.iter().any(|at| *at >= CELLS) {
                    continue;
                }
                let cell = place[1] * CELLS + place[0];
                sums[of_cell(cell).0] += (1.0 - f64::from(filter[0])) / SHIFTS as f64;
            }
            for (kind, sum) in sums.into_iter().enumerate() {
                let grow = std::f64::consts::FRAC_1_SQRT_2 / f64::from(radius);
                let expected = shadow(kind, 1.0 / (grow * grow)) * 0.5;
                let what = (TRANSFERS[kind / SHAPES.len()], SHAPES[kind % SHAPES.len()]);
                let texels = if what.1 == Shape::Gaussian { 28.0 } else { 2.0 };
                let stored = texels * if what.0 == Transfer::Gain { STEP } else { STEP * 0.5 };
                let apart = (sum - expected).abs();
                assert!(
                    apart < TOLERANCE * expected.abs() + stored,
                    "{what:?} {radius}: {sum}, {expected}"
                );
            }
        }
    }
}

/// Edges are left out, and enlarged casters have many: a seventh of a flat disc is next to one.
const EDGED: Tolerance = Tolerance { filter: 1e-3, depth: 1e-5, undecided: 0.4 };

#[test]
fn small_casters_of_every_transfer_agree_with_the_formulas() {
    let kinds = [
        LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3) },
        LightKind::Spot {
            position: Vec3::new(3.0, 4.0, 2.5),
            direction: Vec3::new(-3.0, -4.0, -2.5),
            angle: 0.9,
        },
        LightKind::Point { position: Vec3::new(0.1, 0.2, -0.1) },
    ];
    let shapes = [Shape::Disc, Shape::Quad, Shape::Puff];
    for kind in kinds {
        let mut scene = empty(materials());
        scene.materials.iter_mut().for_each(|material| material.reflectivity = 0.25);
        scene.lights.push(light(kind));
        scene.shadow.size = 32;
        let mut chance = Chance::new(3);
        scene.particles = random_discs(120, 4);
        for particle in &mut scene.particles {
            // Up to a texel.
            particle.radius = chance.within(0.004, 0.12);
            let (transfer, shape) = (chance.below(TRANSFERS.len()), chance.below(shapes.len()));
            particle.material = (transfer * SHAPES.len() + shape) as u32;
            if TRANSFERS[transfer] == Transfer::Gain {
                particle.color = (particle.color.truncate() * 1.5).extend(particle.color.w);
            }
            if let LightKind::Point { position } = kind {
                let way = particle.center - position;
                particle.center = position + way.normalize() * way.length().max(0.5);
            }
        }
        assert_agrees(&scene, EDGED);
    }
}

#[test]
fn small_casters_of_over_agree_with_the_formulas() {
    let over = Material { profile: Profile::Flat, ..material(Transfer::Over) };
    let mut scene = empty(vec![over]);
    scene.lights.push(light(LightKind::Directional { direction: Vec3::NEG_Y }));
    scene.shadow.size = 32;
    let mut chance = Chance::new(5);
    for id in 0..40 {
        let color = chance.vec3(0.0, 1.0).extend(chance.within(0.2, 1.0));
        let center = chance.vec3(-2.0, 2.0);
        scene
            .particles
            .push(Particle { id, ..particle(center, chance.within(0.004, 0.12), color) });
    }
    assert_agrees(&scene, EDGED);
}
