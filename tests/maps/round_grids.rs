//! Grids at round positions: lamps in corners, on edges and faces, and in the middle.
use super::{gaussians::assert_agrees, round::Round, round_gaussians::quarter_turn};
use crate::common::{
    compare::Tolerance,
    scenes::{empty, material},
};
use gobo::{
    glam::{Affine3A, IVec3, UVec3, Vec3},
    model::{Brick, Density, Grid, Material, Shape, Transfer},
};

/// 16-bit filters; many rays pass along the edge of a box.
const EDGED: Tolerance = Tolerance { filter: 2e-3, depth: 1e-5, undecided: 0.4 };

/// A box of constant density, with a lamp in a corner, on an edge, on a face and in its middle.
#[test]
fn boxes_at_round_places() {
    for seed in 0..3 {
        let mut round = Round::new(seed);
        let mut scene = empty(vec![Material { shape: Shape::Brick, ..material(Transfer::Filter) }]);
        let [size, edge] = [2, 4].map(|edge| UVec3::new(edge, 2, 4));
        let brick = |x: i32, size| {
            Brick::new(IVec3::new(x, 0, 0), Density::Constant { size, density: 1.0 })
        };
        let world_from_index = Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.5),
            quarter_turn(&mut round),
            round.place(1.0),
        );
        let bricks = vec![brick(-2, size), brick(0, edge)];
        scene.grids.push(Grid { world_from_index, bricks, ..Grid::default() });
        let places = [0; 4].map(|_| {
            let place = round.on_box(Vec3::new(2.0, 1.0, 2.0), Vec3::new(2.0, 1.0, 2.0));
            world_from_index.transform_point3(place)
        });
        let size = round.one_of(&[32, 33]);
        scene.lights = round.lights(&places, size).into();
        assert_agrees(&scene, EDGED);
    }
}
