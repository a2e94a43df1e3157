//! Framing of files alone: models of the kinds that are hard to frame.
use crate::common::files::Folder;
use gobo::{
    LightKind,
    glam::{Vec2, Vec3},
    model::{Triangle, View},
};
use gobo_scene::{Scene, load};
use std::f32::consts::TAU;

type Quad = [[f32; 3]; 4];

/// A box; its faces look outward, or inward.
fn block(low: [f32; 3], high: [f32; 3], outward: bool) -> Vec<Quad> {
    let at = |x: usize, y: usize, z: usize| {
        let of = |axis: usize, side: usize| [low, high][side][axis];
        [of(0, x), of(1, y), of(2, z)]
    };
    let mut faces = vec![
        [at(1, 0, 1), at(1, 0, 0), at(1, 1, 0), at(1, 1, 1)],
        [at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)],
        [at(0, 1, 1), at(1, 1, 1), at(1, 1, 0), at(0, 1, 0)],
        [at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)],
        [at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)],
        [at(1, 0, 0), at(0, 0, 0), at(0, 1, 0), at(1, 1, 0)],
    ];
    if !outward {
        faces.iter_mut().for_each(|face| face.reverse());
    }
    faces
}

/// A level rectangle that looks up.
fn level(low: [f32; 2], high: [f32; 2], y: f32) -> Quad {
    [[low[0], y, high[1]], [high[0], y, high[1]], [high[0], y, low[1]], [low[0], y, low[1]]]
}

/// The scene of an OBJ file of objects.
fn scene(objects: &[Vec<Quad>]) -> Scene {
    let mut text = String::new();
    let mut count = 0;
    for (number, faces) in objects.iter().enumerate() {
        text += &format!("o part{number}\n");
        for face in faces {
            for [x, y, z] in face {
                text += &format!("v {x} {y} {z}\n");
            }
            let [a, b, c, d] = [1, 2, 3, 4].map(|i| count + i);
            text += &format!("f {a} {b} {c} {d}\n");
            count += 4;
        }
    }
    load(&Folder::new().write("model.obj", text)).unwrap()
}

/// Places of corners in the picture, -1 to 1.
fn places(scene: &Scene, of: impl Fn(&Triangle) -> bool) -> Vec<Vec2> {
    let clip = View::from_camera(&scene.camera, &scene.bounds()).clip_from_world();
    let corners = scene.triangles.iter().filter(|it| of(it)).flat_map(|it| it.positions);
    let place = |corner: Vec3| {
        let at = clip * corner.extend(1.0);
        if at.w > 0.0 { at.truncate().truncate() / at.w } else { Vec2::splat(9.0) }
    };
    corners.map(place).collect()
}

/// Largest share of the picture's width or height that corners fill; 0 if some are outside.
fn filled(places: &[Vec2]) -> f32 {
    let (low, high) =
        places.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), at| {
            (low.min(*at), high.max(*at))
        });
    let is_inside = low.min_element() >= -1.0 && high.max_element() <= 1.0;
    if is_inside { (high - low).max_element() / 2.0 } else { 0.0 }
}

/// A ground in one object with what stands on it, one of many tiles, and one of strips.
#[test]
fn grounds_of_one_mesh_and_of_tiles_are_left_out() {
    let chair = |at: f32| {
        let mut faces = block([at, 0.0, 0.0], [at + 0.05, 0.5, 0.05], true);
        faces.extend(block([at + 0.4, 0.0, 0.4], [at + 0.45, 0.5, 0.45], true));
        faces.extend(block([at, 0.5, 0.0], [at + 0.45, 0.55, 0.45], true));
        faces
    };
    let field = vec![level([-50.0, -50.0], [50.0, 50.0], 0.0)];
    let tiles = (0..400).map(|i| {
        let [x, z] = [i % 20, i / 20].map(|i| i as f32 * 3.0 - 30.0);
        vec![level([x, z], [x + 3.0, z + 3.0], 0.0)]
    });
    let strips = (0..5).map(|i| {
        let x = i as f32 * 16.0 - 40.0;
        vec![level([x, -40.0], [x + 15.0, 40.0], 0.0)]
    });
    for (name, objects) in [
        ("one object", vec![[field, chair(1.0)].concat()]),
        ("tiles", tiles.chain([chair(7.0)]).collect()),
        ("strips", strips.chain([chair(3.0)]).collect()),
    ] {
        let scene = scene(&objects);
        let stands = |it: &Triangle| {
            let bounds = it.positions.map(|corner| corner.y + scene.origin.y);
            bounds.iter().any(|y| *y > 0.1)
        };
        let share = filled(&places(&scene, stands));
        assert!((0.6..0.8).contains(&share), "{name}: {share}");
    }
}

/// A board that leans back is seen from its front; a ramp is not a board.
#[test]
fn leaning_boards_are_seen_from_their_front() {
    let board = |tilt: f32, turned: f32| {
        let (rise, level) = tilt.to_radians().sin_cos();
        let (sine, cosine) = turned.to_radians().sin_cos();
        let lean = |[x, y, z]: [f32; 3]| {
            let (y, z) = (y * level + z * rise, z * level - y * rise);
            [x * cosine + z * sine, y, z * cosine - x * sine]
        };
        let faces = block([-0.7, 0.0, -0.02], [0.7, 1.6, 0.02], true);
        let scene = scene(&[faces.into_iter().map(|face| face.map(lean)).collect()]);
        let away = (scene.camera.eye - scene.camera.target).with_y(0.0).normalize();
        away.dot(Vec3::new(sine, 0.0, cosine)).abs()
    };
    for turned in [45.0, 110.0, -30.0] {
        assert!(board(15.0, turned) > 0.9, "{turned}: {}", board(15.0, turned));
    }
    // Seen as all else, 34.5 degrees off z.
    assert!((board(65.0, 0.0) - 34.5_f32.to_radians().cos()).abs() < 0.01);
}

/// A round room, one of the shape of an L, one under a roof, one with a door, and walls that are blocks.
#[test]
fn rooms_of_all_shapes_are_seen_from_within() {
    let chest = block([-0.4, 0.0, -0.4], [0.4, 0.8, 0.2], true);
    let around = |i: usize| {
        let (sine, cosine) = (TAU * i as f32 / 24.0).sin_cos();
        [2.5 * sine, 2.5 * cosine]
    };
    let mut round = Vec::new();
    let mut dome = Vec::new();
    for i in 0..24 {
        let ([ax, az], [bx, bz]) = (around(i), around(i + 1));
        let middle = [0.0, 2.6, 0.0];
        let floor = [[0.0; 3], [ax, 0.0, az], [bx, 0.0, bz], [0.0; 3]];
        round.push([[bx, 0.0, bz], [ax, 0.0, az], [ax, 2.6, az], [bx, 2.6, bz]]);
        round.push([middle, [bx, 2.6, bz], [ax, 2.6, az], middle]);
        let half = |[x, z]: [f32; 2]| [0.7 * x, 1.8, 0.7 * z];
        let (a, b) = (half([ax, az]), half([bx, bz]));
        dome.push([[bx, 0.0, bz], [ax, 0.0, az], a, b]);
        dome.push([middle, b, a, middle]);
        round.push(floor);
        dome.push(floor);
    }
    let mut l_shaped =
        vec![level([-3.0, -3.0], [3.0, 0.0], 0.0), level([-3.0, 0.0], [0.0, 3.0], 0.0)];
    for [x, z, to_x, to_z] in [
        [-3.0, -3.0, 3.0, -3.0],
        [3.0, -3.0, 3.0, 0.0],
        [3.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 3.0],
        [0.0, 3.0, -3.0, 3.0],
        [-3.0, 3.0, -3.0, -3.0],
    ] {
        l_shaped.push([[x, 2.5, z], [x, 0.0, z], [to_x, 0.0, to_z], [to_x, 2.5, to_z]]);
    }
    for face in [level([-3.0, -3.0], [3.0, 0.0], 2.5), level([-3.0, 0.0], [0.0, 3.0], 2.5)] {
        let [a, b, c, d] = face;
        l_shaped.push([d, c, b, a]);
    }
    let mut door = block([-2.0, 0.0, -3.0], [2.0, 2.5, 3.0], false);
    door.remove(4);
    for [x, y, to_x, to_y] in [[-2.0, 0.0, -0.4, 2.5], [0.4, 0.0, 2.0, 2.5], [-0.4, 2.0, 0.4, 2.5]]
    {
        door.push([[x, to_y, 3.0], [to_x, to_y, 3.0], [to_x, y, 3.0], [x, y, 3.0]]);
    }
    let walls = [
        [[-2.1, 0.0, -3.0], [-2.0, 2.5, 3.0]],
        [[2.0, 0.0, -3.0], [2.1, 2.5, 3.0]],
        [[-2.1, 0.0, -3.1], [2.1, 2.5, -3.0]],
        [[-2.1, 0.0, 3.0], [2.1, 2.5, 3.1]],
        [[-2.1, -0.1, -3.1], [2.1, 0.0, 3.1]],
        [[-2.1, 2.5, -3.1], [2.1, 2.6, 3.1]],
    ];
    let walls: Vec<_> = walls.map(|[low, high]| block(low, high, true)).into();
    for (name, objects, is_room) in [
        ("round", vec![round, chest.clone()], true),
        ("dome", vec![dome, chest.clone()], true),
        ("l", vec![l_shaped], true),
        ("door", vec![door, chest.clone()], true),
        ("walls", [walls.clone(), vec![chest.clone()]].concat(), true),
        // Nothing is in it, and it looks like a crate.
        ("crate", walls, false),
        ("chest", vec![chest], false),
    ] {
        let scene = scene(&objects);
        let bounds = scene.bounds();
        let eye = scene.camera.eye;
        let is_inside = eye.cmpgt(bounds.min).all() && eye.cmplt(bounds.max).all();
        let is_lamp = matches!(scene.lights[0].kind, LightKind::Point { .. });
        assert_eq!((is_inside, is_lamp), (is_room, is_room), "{name}: {}", eye + scene.origin);
        // The missing quarter.
        let eye = eye + scene.origin;
        assert!(name != "l" || eye.x < 0.0 || eye.z < 0.0, "{eye}");
        assert!(name != "round" || Vec2::new(eye.x, eye.z).length() < 2.4, "{eye}");
    }
}

/// A corridor is seen along its middle, from either end: no wall hides half of it.
#[test]
fn corridors_are_seen_along_their_middle() {
    let chest = block([-0.3, 0.0, -0.4], [0.5, 0.8, 0.4], true);
    for [half_x, half_z] in [[1.0, 8.0], [12.0, 1.2]] {
        let walls = block([-half_x, 0.0, -half_z], [half_x, 2.5, half_z], false);
        let scene = scene(&[walls, chest.clone()]);
        let eye = scene.camera.eye + scene.origin;
        let [along, aside] = if half_x > half_z { [eye.x, eye.z] } else { [eye.z, eye.x] };
        let [long, narrow] = [half_x.max(half_z), half_x.min(half_z)];
        assert!(along.abs() > 0.6 * long && along.abs() < long, "{eye}");
        assert!(aside.abs() < 0.5 * narrow, "{eye}");
    }
}

/// A cloth that lies flat for the most part has a ground of its own; a slab with a post has its floor.
#[test]
fn cloths_are_no_floors() {
    let has_ground = |objects: &[Vec<Quad>]| {
        scene(objects).materials.iter().any(|material| material.name == "ground")
    };
    let carpet = [[-1.5, 0.6, 0.0, 0.0], [0.6, 0.8, 0.0, 0.2], [0.8, 1.0, 0.2, 0.5]];
    let carpet = carpet.map(|[from, to, low, high]| {
        [[from, low, 0.7], [to, high, 0.7], [to, high, -0.7], [from, low, -0.7]]
    });
    assert!(has_ground(&[carpet.to_vec()]));
    let slab = block([-2.0, -0.05, -2.0], [2.0, 0.0, 2.0], true);
    let post = block([-0.2, 0.0, -0.2], [0.2, 2.0, 0.2], true);
    assert!(!has_ground(&[slab.clone(), post.clone()]));
    assert!(!has_ground(&[[slab, post].concat()]));
}
