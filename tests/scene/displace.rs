//! Spheres displaced by noise: closed at every time, within their amplitude, animated.
use crate::common::files::read;
use gobo::{
    glam::Vec3,
    model::{Triangle, is_closed, turn_outwards},
};
use gobo_scene::Scene;

fn dust(displace: &str) -> Scene {
    let toml = format!(
        "[[material]]\nname = \"dust\"\nattenuation_distance = 1\nattenuation_color = [0.5, 0.4, 0.3]\n\
         [[shape]]\nkind = \"plane\"\nmaterial = \"ground\"\n[[material]]\nname = \"ground\"\n\
         transfer = \"opaque\"\n[[shape]]\nkind = \"sphere\"\nmaterial = \"dust\"\nlevel = 4\n\
         scale = [4, -4, 4]\ntranslation = [1, 2, 3]\ndisplace = {displace}\n"
    );
    read(&toml).unwrap()
}

fn body(scene: &Scene) -> &[Triangle] {
    &scene.triangles[2..]
}

fn radii(scene: &Scene) -> Vec<f32> {
    let corners = body(scene).iter().flat_map(|triangle| triangle.positions);
    corners.map(|corner| corner.distance(Vec3::new(1.0, 2.0, 3.0))).collect()
}

#[test]
fn displaced_spheres_stay_closed_bodies() {
    let mut scene = dust("{ amplitude = 0.5, frequency = 1.5, speed = 0.4, seed = 2 }");
    let start = radii(&scene);
    for seconds in [0.0, 0.1, 1.0, 1e5] {
        scene.set_time(seconds);
        assert_eq!(body(&scene).len(), 20 * 4usize.pow(4));
        assert!(is_closed(body(&scene)), "at {seconds} s");
        let mut outwards = body(&scene).to_vec();
        turn_outwards(&mut outwards);
        assert_eq!(outwards, body(&scene));
        let radii = radii(&scene);
        assert!(radii.iter().all(|r| (1.0 - 1e-4..=3.0 + 1e-4).contains(r)));
        let (least, most) =
            radii.iter().fold((3.0_f32, 0.0_f32), |(a, b), &r| (a.min(r), b.max(r)));
        assert!(least < 1.8 && most > 2.2, "{least} {most}");
        for triangle in body(&scene) {
            let [a, b, c] = triangle.positions;
            let face = (b - a).cross(c - a).normalize();
            assert!(triangle.normals.iter().all(|n| n.is_normalized()));
            assert!(triangle.normals.iter().any(|n| n.dot(face) > 0.3), "outwards");
        }
    }
    scene.set_time(0.0);
    assert_eq!(radii(&scene), start);
}

#[test]
fn lumps_come_and_go_without_a_jump() {
    let apart = |displace: &str, seconds: f64| {
        let mut scene = dust(displace);
        let start = radii(&scene);
        scene.set_time(seconds);
        let steps = start.iter().zip(radii(&scene)).map(|(a, b)| (a - b).abs());
        steps.fold(0.0, f32::max)
    };
    let evolving = "{ amplitude = 0.5, speed = 0.4 }";
    assert!(apart(evolving, 1.0 / 240.0) < 0.1 && apart(evolving, 0.8) > 0.3);
    let drifting = "{ amplitude = 0.5, drift = [0, 0.5, 0] }";
    assert!(apart(drifting, 1.0 / 240.0) < 0.1 && apart(drifting, 1.0) > 0.3);
    assert_eq!(apart("{ amplitude = 0.5, seed = 7 }", 1.0), 0.0);
    assert_eq!(apart("{ amplitude = 0, speed = 1 }", 1.0), 0.0);
}

#[test]
fn wrong_displacements_are_named() {
    let error = |kind: &str, level: u32, displace: &str| {
        let toml = format!(
            "[[material]]\nname = \"a\"\n[[shape]]\nkind = \"{kind}\"\nmaterial = \"a\"\n\
             level = {level}\ndisplace = {displace}\n"
        );
        let error = read(&toml).unwrap_err();
        format!("{error}; {}", error.help().unwrap_or_default())
    };
    let good = "{ amplitude = 0.5 }";
    assert!(error("box", 3, good).contains("only spheres"));
    assert!(error("sphere", 8, good).contains("level is 8"));
    for wrong in [
        "amplitude = 1",
        "amplitude = nan",
        "amplitude = 0, frequency = 0",
        "amplitude = 0, speed = inf",
        "amplitude = 0, drift = [0, 1e4, 0]",
    ] {
        let key = wrong.rsplit_once(" =").unwrap().0.rsplit(' ').next().unwrap();
        let message = error("sphere", 3, &format!("{{ {wrong} }}"));
        assert!(message.contains(if key == "drift" { "speed" } else { key }), "{message}");
    }
    assert!(error("sphere", 3, "{ amplitude = 0, sped = 1 }").contains("speed"));
}
