//! Grids, and mixtures of all casters, at round positions: lamps and eyes in their middles, ends and corners.
use super::{
    gaussians::{assert_agrees, medium, splats},
    round::Round,
    round_gaussians::{around, quarter_turn, round_gaussian},
    round_strands::{lamps, round_strand},
    strands::hair,
};
use crate::common::{
    Tier,
    brute_force::render,
    compare::Tolerance,
    reference_picture,
    scenes::{empty, light, material, particle},
    tiers,
};
use gobo::{
    glam::{Affine3A, IVec3, UVec2, Vec3, Vec4},
    model::{Brick, Camera, Grid, LightKind, Material, Particle, Shape, Transfer, View},
};
use gobo_scene::Scene;

/// 16-bit filters, sums in fixed point; depths in 32 bits.
const TOLERANCE: Tolerance = Tolerance { filter: 2e-3, depth: 1e-5, undecided: 0.1 };
/// Among strands and discs many rays pass along an edge.
const EDGED: Tolerance = Tolerance { undecided: 0.4, ..TOLERANCE };

const STRAND: u32 = 2;
const BRICK: u32 = 4;
const DISC: u32 = 5;
const WALL: u32 = 6;

/// Splats, a medium, two kinds of strands, bricks, discs and a wall, all visibly black.
fn materials() -> Vec<Material> {
    let brick = Material {
        shape: Shape::Brick,
        tint: Vec4::new(0.0, 0.0, 0.0, 1.0),
        ..material(Transfer::Filter)
    };
    vec![
        splats(Transfer::Filter),
        medium(2.0),
        hair(Transfer::Filter),
        hair(Transfer::Smoke),
        brick,
        material(Transfer::Filter),
        material(Transfer::Opaque),
    ]
}

/// Voxels of a quarter or half a metre, of densities 0, 1/2 and 1, rotated by quarter turns.
fn round_grid(round: &mut Round) -> Grid {
    let edge = round.one_of(&[0.25, 0.5]);
    let (min, max) = (IVec3::splat(-2), IVec3::splat(1));
    let values: Vec<f32> = (0..64).map(|_| round.one_of(&[0.0, 0.5, 1.0])).collect();
    let density = |voxel: IVec3| {
        let place = voxel - min;
        values[(place.x + 4 * (place.y + 4 * place.z)) as usize]
    };
    Grid {
        world_from_index: Affine3A::from_scale_rotation_translation(
            Vec3::splat(edge),
            quarter_turn(round),
            round.place(1.0),
        ),
        bricks: Brick::of_voxels(min, max, density),
        extinction: Vec3::new(1.0, 0.5, 0.25),
        material: BRICK,
        ..Grid::default()
    }
}

/// Centres of voxels and middles of cells, faces and corners.
fn in_grid(round: &mut Round, grid: &Grid) -> Vec3 {
    grid.world_from_index.transform_point3(round.place(2.0))
}

#[test]
fn grids_at_round_places() {
    for seed in 0..4 {
        let mut round = Round::new(seed);
        let mut scene = empty(materials());
        let grid = round_grid(&mut round);
        let places = [0; 6].map(|_| in_grid(&mut round, &grid));
        scene.grids.push(grid);
        let size = round.one_of(&[32, 33]);
        scene.lights = round.lights(&places, size).into();
        assert_agrees(&scene, TOLERANCE);
    }
}

/// Some of each kind, with discs at equal depths, and positions for lamps or an eye.
fn mixture(round: &mut Round) -> (Scene, Vec<Vec3>) {
    let mut scene = empty(materials());
    let strands = (0..3).map(|id| round_strand(round, id)).collect::<Vec<_>>();
    let mut places = lamps(&strands);
    scene.strands = strands;
    scene.strands.iter_mut().for_each(|strand| strand.material += STRAND);
    scene.gaussians = (0..3).map(|id| round_gaussian(round, id)).collect();
    places.extend(scene.gaussians.clone().iter().map(|gaussian| around(round, gaussian)));
    scene.grids.push(round_grid(round));
    places.extend([0; 3].map(|_| in_grid(round, &scene.grids[0])));
    for _ in 0..4 {
        let center = round.place(1.0) - Vec3::Y * 3.0;
        let disc = particle(center, round.half(0.5, 1.0), round.color());
        scene.particles.push(Particle { material: DISC, ..disc });
    }
    let wall = particle(Vec3::NEG_Y * 4.5, 2.0, Vec4::ONE);
    scene.particles.push(Particle { material: WALL, ..wall });
    (scene, places)
}

#[test]
fn mixtures_at_round_places() {
    for seed in 0..4 {
        let mut round = Round::new(seed);
        let (mut scene, places) = mixture(&mut round);
        let size = round.one_of(&[32, 33]);
        scene.lights = round.lights(&places, size).into();
        assert_agrees(&scene, EDGED);
    }
}

/// Black casters in front of a white background: the light left is the filter of a lamp at the eye. For
/// `smoke` a picture shows the rest after its opacity's coverage, and a filter has the square of that: all
/// strands are of `filter`.
#[test]
fn pictures_from_round_places() {
    for seed in 0..4 {
        let mut round = Round::new(seed);
        let (mut scene, places) = mixture(&mut round);
        scene.particles.pop();
        scene.background = Vec3::ONE;
        for strand in &mut scene.strands {
            strand.material = STRAND;
            strand.vertices.iter_mut().for_each(|vertex| vertex.color *= Vec4::W);
        }
        scene.gaussians.iter_mut().for_each(|gaussian| gaussian.color = Vec3::ZERO);
        scene.particles.iter_mut().for_each(|disc| disc.color *= Vec4::W);
        scene.grids[0].extinction = Vec3::ONE;
        let (eye, direction) = (round.one_of(&places), round.direction());
        let angle = 90.0_f32.to_radians();
        scene.camera = Camera {
            eye,
            target: eye + direction,
            up: if direction.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y },
            fov_y: angle,
            size: UVec2::splat(round.one_of(&[32, 33])),
        };
        let view = View { light: Some(0), ..View::from_camera(&scene.camera, &scene.bounds()) };
        let lamp = light(LightKind::Spot { position: eye, direction, angle });
        let truth = render(&Scene { lights: vec![lamp], ..scene.clone() }, &view);
        let undecided = truth.iter().filter(|texel| texel.undecided).count();
        assert!((undecided as f64) < EDGED.undecided * truth.len() as f64, "{seed}: {undecided}");
        let shaded = truth.iter().filter(|texel| !texel.undecided && texel.filter[0] < 0.9);
        assert!(2 * shaded.count() > truth.len(), "{seed}: hardly anything is seen");
        let mut pictures = vec![reference_picture(&scene)];
        pictures.extend(
            tiers(Tier::Native).into_iter().map(|tier| crate::common::render(tier, &scene).picture),
        );
        let bare = Scene { camera: scene.camera, background: Vec3::ONE, ..empty(materials()) };
        let background = reference_picture(&bare);
        for picture in pictures {
            for (i, truth) in truth.iter().enumerate().filter(|(_, texel)| !texel.undecided) {
                let found = f64::from(picture.light[i][0] / background.light[i][0]);
                let expected = truth.filter[0];
                assert!(
                    (found - expected).abs() < 2e-3,
                    "{seed}, pixel {i}: {found} instead of {expected}"
                );
            }
        }
    }
}
