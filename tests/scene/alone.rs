//! A single model or particle file as a scene: its light, its ground, and fitted maps.
use crate::common::{arrays::npy_of, files::Folder};
use gobo::{
    glam::{Mat4, UVec3, Vec3},
    model::{Density, LightKind, Particle, View},
    view,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene as scene;
use gobo_scene::{LoadOptions, Scene};

/// A column of particles, 1 m wide and 4 m high.
fn column() -> String {
    let mut csv = "x,y,z,radius\n".to_owned();
    for i in 0..400 {
        let (x, z) = (f64::from(i % 5) * 0.2, f64::from(i / 5 % 5) * 0.2);
        csv += &format!("{x},{},{z},0.1\n", f64::from(i / 25) * 0.25);
    }
    csv
}

fn load(name: &str, bytes: impl AsRef<[u8]>, set: &[(&str, &str)], ground: bool) -> Scene {
    let folder = Folder::new();
    let mut options = LoadOptions::default();
    options.set = set.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect();
    options.ground = ground;
    scene::load_as(&folder.write(name, bytes), &options).unwrap_or_else(|e| panic!("{e}"))
}

fn sun(scene: &Scene) -> Vec3 {
    let LightKind::Directional { direction } = scene.lights[0].kind else { panic!("no sun") };
    direction
}

/// Position of a point in the picture, -1 to 1 from left to right and from bottom to top.
fn seen(scene: &Scene, point: Vec3) -> (f32, f32) {
    let clip: Mat4 = View::from_camera(&scene.camera, &scene.bounds()).clip_from_world();
    let at = clip * point.extend(1.0);
    assert!(at.w > 0.0, "{point} is behind the camera");
    (at.x / at.w, at.y / at.w)
}

#[test]
fn the_shadow_falls_into_view_beside_what_casts_it() {
    let scene = load("dots.csv", column(), &[], true);
    let (direction, top) = (sun(&scene), Vec3::new(0.4, 3.75, 0.4));
    let ground = scene.triangles[0].positions[0].y;
    let shadow = top + direction * ((top.y - ground) / -direction.y);
    let foot = seen(&scene, Vec3::new(0.4, 0.0, 0.4));
    let (x, y) = seen(&scene, shadow);
    assert!(x.abs() < 1.0 && y.abs() < 1.0, "the shadow's tip is at {x}, {y}");
    // The column is about a tenth of the picture's half width to either side of its middle.
    assert!((x - foot.0).abs() > 0.3, "from {} to {x}", foot.0);
    // Light from the viewer's side: visible surfaces are lit.
    let forward = scene.camera.target - scene.camera.eye;
    assert!(direction.dot(forward) > 0.0 && direction.dot(Vec3::NEG_Y) > 0.5, "{direction}");
    // A direction given by the user stays; a new size leaves the direction.
    let set = load("dots.csv", column(), &[("light.sun.direction", "[0, -1, 0]")], true);
    assert_eq!(sun(&set), Vec3::NEG_Y);
    let set = load("dots.csv", column(), &[("light.sun.size", "64")], true);
    assert_eq!(sun(&set), direction);
}

/// Wide, tall and flat contents, in pictures of several shapes: they fill three quarters of the width or
/// height, in the middle, and flat contents are seen from higher above.
#[test]
fn contents_fill_the_picture() {
    let card = model(&[[Vec3::ZERO, Vec3::new(3.0, 0.0, 2.0)]], None);
    let tower = model(&[[Vec3::ZERO, Vec3::new(1.0, 6.0, 1.0)]], None);
    let mut heights = Vec::new();
    for (name, file) in [("dots.csv", &column()), ("card.gltf", &card), ("tower.gltf", &tower)] {
        for size in ["[960, 540]", "[300, 300]", "[200, 700]"] {
            let scene = load(name, file, &[("camera.size", size)], false);
            let corners = scene.triangles.iter().flat_map(|t| t.positions);
            let away = (scene.camera.eye - scene.camera.target).normalize();
            let right = Vec3::Y.cross(away).normalize();
            let rims = |p: &Particle| {
                let apart = [right, -right, away.cross(right), right.cross(away)];
                let (center, radius) = (p.center, p.radius);
                apart.map(|way| center + way * radius)
            };
            let rims = scene.particles.iter().flat_map(rims);
            let places = corners.chain(rims).map(|point| seen(&scene, point));
            let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
            for (x, y) in places {
                (low, high) = ([low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)]);
            }
            let filled = [0, 1].map(|axis| (high[axis] - low[axis]) * 0.5);
            // The outline of a sphere reaches a little beyond the rim across the view.
            let slack = if name == "dots.csv" { 0.02 } else { 0.001 };
            let most = filled[0].max(filled[1]);
            assert!(most > 0.75 - slack && most < 0.751, "{name} {size}: {filled:?}");
            let middle = [0, 1].map(|axis| (high[axis] + low[axis]).abs() * 0.5);
            // Perspective may move the other axis a little.
            let (filled, other) = if filled[0] > filled[1] { (0, 1) } else { (1, 0) };
            let is_centered = middle[filled] < 0.5 * slack && middle[other] < 0.1;
            assert!(is_centered, "{name} {size}: {middle:?}");
            heights.push(away.y.asin().to_degrees());
        }
    }
    assert!(heights[0] > 24.9 && heights[0] < 26.0 && heights[3] > 39.9, "{heights:?}");
    // Given values stay.
    let set = [("camera.target", "[1, 2, 3]"), ("camera.samples", "2")];
    let scene = load("tower.gltf", &tower, &set, false);
    assert_eq!((scene.camera.target, scene.samples), (Vec3::new(1.0, 2.0, 3.0), 2));
    let inside = |point: Vec3| {
        let (x, y) = seen(&scene, point);
        x.abs().max(y.abs()) < 0.751
    };
    assert!(scene.triangles.iter().flat_map(|t| t.positions).all(inside));
    assert_eq!(load("tower.gltf", tower, &[], false).samples, 4);
}

#[test]
fn the_ground_reaches_the_horizon() {
    let scene = load("dots.csv", column(), &[], true);
    let ground = scene.triangles.iter().flat_map(|t| t.positions);
    let (min, max) =
        ground.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let eye = scene.camera.eye;
    for step in 0..64 {
        let (sin, cos) = (step as f32 / 64.0 * std::f32::consts::TAU).sin_cos();
        // A degree below the horizon.
        let ray = Vec3::new(cos, -1f32.to_radians().tan(), sin);
        let hit = eye + ray * ((eye.y - max.y) / -ray.y);
        assert!(hit.x > min.x && hit.x < max.x && hit.z > min.z && hit.z < max.z, "{hit}");
    }
    assert!(load("dots.csv", column(), &[], false).triangles.is_empty());
}

/// Bricks reach up to eight voxels further than what is dense.
#[test]
fn volumes_stand_on_the_ground() {
    let dense = |i: usize| [i % 20, i / 20 % 20, i / 400].iter().all(|at| (5..12).contains(at));
    let bytes: Vec<u8> = (0..8000).map(|i| if dense(i) { 200 } else { 0 }).collect();
    let array = npy_of("|u1", false, "20, 20, 20", &bytes);
    let scene = load("block.npy", array, &[], true);
    let grid = &scene.grids[0];
    let mut lowest = f32::INFINITY;
    for brick in &grid.bricks {
        let Density::Voxels(voxels) = &brick.density else { panic!("no voxels") };
        for i in 0..729 {
            let at = UVec3::new(i % 9, i / 9 % 9, i / 81);
            if voxels.at(at) > 0.0 {
                let place = brick.origin.as_vec3() + at.as_vec3();
                lowest = lowest.min(grid.world_from_index.transform_point3(place).y);
            }
        }
    }
    let voxel = grid.world_from_index.matrix3.y_axis.length();
    let ground = scene.triangles.iter().flat_map(|t| t.positions).map(|p| p.y);
    let gap = (lowest - ground.fold(f32::NEG_INFINITY, f32::max)) / voxel;
    assert!((0.4..0.6).contains(&gap), "{gap} voxels between the lowest dense one and the ground");
}

#[test]
fn maps_fit_what_casts() {
    let scene = load("dots.csv", column(), &[], true);
    let [view] = &view::shadow_views(&scene)[..] else { panic!("one view") };
    let window = view.size.x as f32 / view.scale;
    // The column is 4.0 m high at most and 1 m wide, seen from the side.
    assert!(window < 5.0, "{window} m");
    for particle in &scene.particles {
        let at = view.view_from_world.transform_point3(particle.center);
        assert!(at.truncate().abs().max_element() + particle.radius <= window * 0.5, "{at}");
        assert!(-at.z - particle.radius >= view.near && -at.z + particle.radius <= view.far);
    }
    // The far plane includes the ground under the shadow, but not the whole ground.
    let tip = Vec3::new(0.4, 3.75, 0.4);
    let tip = tip + sun(&scene) * ((tip.y - scene.triangles[0].positions[0].y) / -sun(&scene).y);
    let depth = -view.view_from_world.transform_point3(tip).z;
    assert!(depth > view.near && depth < view.far, "{depth} of {}", view.far);
    assert!(view.far - view.near < 20.0, "{} m deep", view.far);
}

/// Near and far, outside the map and at its border, the ground has the same light, and less in the shadow.
#[test]
fn the_ground_is_lit_wherever_no_shadow_falls() {
    let set = [
        ("camera.size", "[128, 72]"),
        ("shadow.size", "128"),
        ("environment.ambient", "[0, 0, 0]"),
    ];
    let scene = load("dots.csv", column(), &set, true);
    let picture = Renderer::on_cpu().render(&scene, &RenderOptions::default()).unwrap().picture;
    let camera = View::from_camera(&scene.camera, &scene.bounds());
    let world_from_clip = camera.clip_from_world().inverse();
    let ground = scene.triangles[0].positions[0].y;
    let (mut lit, mut shadowed) = (0, 0);
    let full = 0.42 * 3.0 * -sun(&scene).y / std::f32::consts::PI;
    for (i, light) in picture.light.iter().enumerate() {
        let (x, y) = (i as u32 % 128, i as u32 / 128);
        let ndc = Vec3::new((x as f32 + 0.5) / 64.0 - 1.0, 1.0 - (y as f32 + 0.5) / 36.0, 0.5);
        let ray = world_from_clip.project_point3(ndc) - scene.camera.eye;
        let hit = scene.camera.eye + ray * ((scene.camera.eye.y - ground) / -ray.y);
        // Pixels of the ground away from the column and its shadow.
        let way = hit + sun(&scene) * (4.2 / sun(&scene).y);
        let far_from = |p: Vec3| (p - Vec3::new(0.4, p.y, 0.4)).length() > 1.2;
        let along = (0..=20).map(|s| hit.lerp(way, s as f32 / 20.0));
        let sees_column = (0..200).any(|s| {
            let p = scene.camera.eye.lerp(hit, s as f32 / 200.0);
            !far_from(p) && p.y < 4.5
        });
        if ray.y >= -1e-3 || sees_column || hit.length() > 200.0 {
            continue;
        }
        if along.into_iter().all(far_from) {
            lit += 1;
            assert!((light[0] / full - 1.0).abs() < 0.2, "{hit}: {light:?} of {full}");
        } else if light[0] < 0.8 * full {
            shadowed += 1;
        }
    }
    assert!(lit > 1000 && shadowed > 20, "{lit} lit, {shadowed} in the shadow");
}

/// Boxes [min, max] as a glTF document: flat ones are floors.
fn model(boxes: &[[Vec3; 2]], camera: Option<Vec3>) -> String {
    let mut floats: Vec<f32> = Vec::new();
    for [min, max] in boxes {
        let at = |x: usize, y: usize, z: usize| {
            let pick = |side: usize, axis: usize| if side == 0 { min[axis] } else { max[axis] };
            [pick(x, 0), pick(y, 1), pick(z, 2)]
        };
        let mut quad = |corners: [[f32; 3]; 4]| {
            for i in [0, 1, 2, 0, 2, 3] {
                floats.extend(corners[i]);
            }
        };
        quad([at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)]);
        quad([at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)]);
        quad([at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)]);
        quad([at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)]);
    }
    let count = floats.len() / 3;
    let bytes: Vec<u8> = floats.into_iter().flat_map(f32::to_le_bytes).collect();
    let uri: String = bytes.chunks(3).map(base64).collect();
    let (nodes, cameras) = match camera {
        None => (String::new(), String::new()),
        Some(eye) => (
            format!(r#",{{"camera":0,"translation":[{},{},{}]}}"#, eye.x, eye.y, eye.z),
            r#""cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],"#
                .to_owned(),
        ),
    };
    let names = if camera.is_some() { "0,1" } else { "0" };
    let length = bytes.len();
    format!(
        r#"{{"asset":{{"version":"2.0"}},{cameras}"scenes":[{{"nodes":[{names}]}}],
        "nodes":[{{"mesh":0}}{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{count},
        "type":"VEC3","min":[-9,-9,-9],"max":[9,9,9]}}],
        "bufferViews":[{{"buffer":0,"byteLength":{length}}}],
        "buffers":[{{"byteLength":{length},"uri":"data:application/octet-stream;base64,{uri}"}}]}}"#
    )
}

fn base64(three: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bits = three.iter().enumerate().fold(0u32, |b, (i, c)| b | u32::from(*c) << (16 - 8 * i));
    let digit = |i: usize| char::from(DIGITS[(bits >> (18 - 6 * i)) as usize & 63]);
    (0..4).map(|i| if i <= three.len() { digit(i) } else { '=' }).collect()
}

#[test]
fn no_ground_hides_a_model_or_doubles_its_floor() {
    let has_ground = |boxes: &[[Vec3; 2]], camera| {
        let scene = load("model.gltf", model(boxes, camera), &[], true);
        scene.materials.iter().any(|material| material.name == "ground")
    };
    let post = [Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 3.0, 0.5)];
    let floor = [Vec3::new(-3.0, -0.05, -3.0), Vec3::new(3.0, 0.0, 3.0)];
    assert!(has_ground(&[post], None));
    assert!(has_ground(&[post], Some(Vec3::new(0.0, 1.0, 6.0))));
    // From below, only the ground would be visible; from inside, it is not.
    assert!(!has_ground(&[post], Some(Vec3::new(0.0, -2.0, 6.0))));
    assert!(!has_ground(&[post], Some(Vec3::new(0.0, 1.0, 0.0))));
    assert!(!has_ground(&[post, floor], None), "a room has its floor");
    // A slab alone lies on the ground.
    assert!(has_ground(&[floor], None));
}
