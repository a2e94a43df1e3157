//! `camera.occlusion`: the share of the ambient light against closed forms.
use crate::common::{TIERS, Tier, files::read, reference_picture, render};
use gobo::{glam::Vec3, model::Occlusion};
use gobo_scene::Scene;

const SIZE: u32 = 240;

/// Ambient light alone on a floor at y = 0 with some shapes.
fn scene(eye: [f32; 3], radius: f32, shapes: &str) -> Scene {
    read(&format!(
        "[camera]\neye = {eye:?}\ntarget = [0, 0, 0]\nfov_y = 40\nsize = [{SIZE}, {SIZE}]\nsamples = 1\n\
         occlusion = {radius:?}\n[environment]\nambient = [0.5, 0.5, 0.5]\n\
         [[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\nintensity = 0\n\
         [[material]]\nname = \"m\"\ntransfer = \"opaque\"\n\
         [[shape]]\nkind = \"plane\"\nmaterial = \"m\"\nscale = [40, 1, 40]\n{shapes}"
    ))
    .unwrap_or_else(|error| panic!("{error}"))
}

/// Share of the ambient light at each pixel whose middle shows the floor, and its point there.
fn shares(scene: &Scene, light: &[[f32; 3]], whole: &[[f32; 3]]) -> Vec<(Vec3, f32)> {
    let camera = gobo::model::View::from_camera(&scene.camera, &scene.bounds());
    let world_from_clip = camera.clip_from_world().inverse();
    let eye = scene.camera.eye;
    let on_floor = whole[whole.len() - 1][0];
    let share = |i: usize| {
        let (x, y) = (i as u32 % SIZE, i as u32 / SIZE);
        let place = |v: u32| (v as f32 + 0.5) * 2.0 / SIZE as f32 - 1.0;
        let ray = world_from_clip.project_point3(Vec3::new(place(x), -place(y), 0.5)) - eye;
        // By the colour of the floor's normal: walls and spheres have less light from above.
        let is_floor = ray.y < 0.0 && (whole[i][0] - on_floor).abs() < 1e-6;
        is_floor.then(|| (eye + ray * (eye.y / -ray.y), light[i][0] / whole[i][0]))
    };
    (0..light.len()).filter_map(share).collect()
}

/// The shares on the floor of a scene, by the kernels of a tier.
fn shares_of(tier: Tier, scene: &Scene) -> Vec<(Vec3, f32)> {
    let light = render(tier, scene).picture.light;
    let bare = Scene { occlusion: Occlusion::None, ..scene.clone() };
    shares(scene, &light, &render(tier, &bare).picture.light)
}

/// In front of an endless wall of height h, at distance x, the share is (1 + x / sqrt(x^2 + h^2)) / 2.
#[test]
fn a_wall_takes_its_part_of_the_sky() {
    /// Worst and mean error: the highest of six samples in a direction is below the wall's edge.
    const WORST: f64 = 0.08;
    const MEAN: f64 = 0.055;
    const HEIGHT: f64 = 0.5;
    let wall = "[[shape]]\nkind = \"box\"\nmaterial = \"m\"\nscale = [40, 0.5, 0.4]\n\
        translation = [0, 0.25, -0.2]\n";
    let scene = scene([0.0, 4.0, 4.0], 4.0, wall);
    for tier in TIERS {
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
        for (point, share) in shares_of(tier, &scene) {
            let x = f64::from(point.z);
            // Two pixels off the corner, where the wall's foot is half in a pixel; farther away, the wall's
            // edge is beyond the search.
            if !(0.06..0.6).contains(&x) || point.x.abs() > 1.0 {
                continue;
            }
            let truth = 0.5 * (1.0 + x / x.hypot(HEIGHT));
            let error = (f64::from(share) - truth).abs();
            (sum, worst, count) = (sum + error, worst.max(error), count + 1.0);
        }
        assert!(count > 1000.0 && sum / count < MEAN && worst < WORST, "{} {worst}", sum / count);
    }
}

/// Beside a sphere of radius r on the floor, at distance d from its foot, the share is 1 - (r / sqrt(d^2 +
/// r^2))^3.
#[test]
fn a_sphere_shades_its_foot() {
    /// The search misses light that comes in under the sphere.
    const MEAN: f64 = 0.03;
    let ball = "[[shape]]\nkind = \"sphere\"\nmaterial = \"m\"\nscale = [1, 1, 1]\n\
        translation = [0, 0.5, 0]\n";
    let scene = scene([0.0, 4.0, 4.0], 4.0, ball);
    let (mut sum, mut count) = (0.0, 0.0);
    for (point, share) in shares_of(Tier::Core, &scene) {
        let d = f64::from(point.x.hypot(point.z));
        // In front and beside: the floor behind is hidden.
        if (0.3..1.2).contains(&d) && point.z > 0.0 {
            let truth = 1.0 - (0.5 / d.hypot(0.5)).powi(3);
            (sum, count) = (sum + (f64::from(share) - truth).abs(), count + 1.0);
        }
    }
    assert!(count > 1000.0 && sum / count < MEAN, "{}", sum / count);
}

/// Under a sphere the floor gets ever lighter outwards, without scale-like patches. Measured: the share of
/// the differences between neighbours that have the wrong sign.
#[test]
fn contact_has_no_scales() {
    const MOST: f32 = 0.09;
    let ball = "[[shape]]\nkind = \"sphere\"\nlevel = 5\nmaterial = \"m\"\nscale = [0.4, 0.4, 0.4]\n\
        translation = [0, 0.2, 0]\n";
    let scene = scene([0.0, 0.45, 0.9], 0.127, ball);
    for tier in TIERS {
        let shares = shares_of(tier, &scene);
        let (mut wrong, mut all, mut count) = (0.0, 0.0, 0);
        for pair in shares.windows(2) {
            let [(a, share_a), (b, share_b)] = [pair[0], pair[1]];
            let [near, far] = [a, b].map(|p| p.x.hypot(p.z));
            if a.distance(b) < 0.01 && near.max(far) < 0.25 {
                let falls = (share_a - share_b) * (far - near).signum();
                (wrong, all, count) = (wrong + falls.max(0.0), all + falls.abs(), count + 1);
            }
        }
        assert!(count > 5000 && all > 20.0, "{count} {all}");
        assert!(wrong < MOST * all, "{tier}: {}", wrong / all);
    }
}

/// Along an endless wall the share at the picture's border is as close to the truth as in its middle.
#[test]
fn occlusion_does_not_fade_at_the_border() {
    const MOST: f32 = 0.04;
    const HEIGHT: f32 = 0.5;
    let wall = "[[shape]]\nkind = \"box\"\nmaterial = \"m\"\nscale = [40, 0.5, 0.4]\n\
        translation = [0, 0.25, -0.2]\n";
    let scene = scene([0.0, 4.0, 4.0], 1.0, wall);
    for tier in TIERS {
        let shares = shares_of(tier, &scene);
        // The floor's points just before the wall, by their distance across.
        let before = shares.iter().filter(|(point, _)| (0.1..0.3).contains(&point.z));
        let widest = before.clone().map(|(point, _)| point.x.abs()).fold(0.0, f32::max);
        let mean = |from: f32, to: f32| {
            let there = before.clone().filter(|(point, _)| (from..to).contains(&point.x.abs()));
            let error = |(p, share): &(Vec3, f32)| share - 0.5 * (1.0 + p.z / p.z.hypot(HEIGHT));
            let (sum, count) = there.fold((0.0, 0.0), |(sum, n), it| (sum + error(it), n + 1.0));
            assert!(count > 20.0, "{count}");
            sum / count
        };
        let (middle, border) = (mean(0.0, 0.5 * widest), mean(widest * 0.98, widest * 1.01));
        assert!((middle - border).abs() < MOST, "{tier}: {middle} {border}");
    }
}

/// Nothing farther away than the radius gets darker, and a floor does not occlude itself, even at a grazing
/// angle.
#[test]
fn there_is_no_halo() {
    const RADIUS: f32 = 0.4;
    /// Angles come from cosines of 24 bits.
    const ROUNDED: f32 = 0.999;
    let post = "[[shape]]\nkind = \"box\"\nmaterial = \"m\"\nscale = [0.5, 1, 0.5]\n\
        translation = [0, 0.5, 0]\n";
    for eye in [[0.0, 4.0, 4.0], [0.0, 0.6, 6.0]] {
        let scene = scene(eye, RADIUS, post);
        let (mut near, mut far) = (0, 0);
        // Five pixels are filtered with their neighbours [m].
        let across = 5.0 * 8.0 / SIZE as f32;
        let filtered = Vec3::new(across, 0.0, across / Vec3::from(eye).normalize().y);
        for (point, share) in shares_of(Tier::Core, &scene) {
            let beside = (point.abs() - 0.25).max(Vec3::ZERO);
            let apart = beside.x.hypot(beside.z);
            if (beside - filtered).max(Vec3::ZERO).length() > RADIUS {
                far += 1;
                assert!(share > ROUNDED, "{eye:?}: {share} at {point}");
            } else if apart > 0.03 && apart < 0.1 && share < 0.95 {
                near += 1;
            }
        }
        assert!(near > 20 && far > 5000, "{eye:?}: {near} {far}");
    }
}

/// The kernels agree with the CPU reference, with opaque spheres, panes and air in the picture; maps stay.
#[test]
fn kernels_match_the_reference_and_maps_stay() {
    let shapes = "[[shape]]\nkind = \"box\"\nmaterial = \"m\"\nscale = [0.5, 1, 0.5]\n\
        translation = [0, 0.5, 0]\n\
        [[shape]]\nkind = \"pane\"\nmaterial = \"g\"\ntranslation = [0.3, 0.5, 0.6]\n\
        [[material]]\nname = \"g\"\ntint = [1, 0.4, 0.2, 0.5]\n[air]\nextinction = 0.1\n";
    for radius in ["true", "0.3"] {
        let mut scene = scene([1.0, 2.0, 3.0], 1.0, shapes);
        if radius == "true" {
            scene.occlusion = Occlusion::Usual;
        }
        let expected = reference_picture(&scene).light;
        for tier in TIERS {
            let frame = render(tier, &scene);
            let apart = |(a, b): (&[f32; 3], &[f32; 3])| (a[0] - b[0]).abs() > 2e-3;
            let count = frame.picture.light.iter().zip(&expected).filter(|&it| apart(it)).count();
            // Pixels for which a search's position is rounded differently.
            assert!(count < expected.len() / 500, "{tier:?}, {radius}: {count} pixels");
            let bare = render(tier, &Scene { occlusion: Occlusion::None, ..scene.clone() });
            assert_ne!(bare.picture.light, frame.picture.light);
            for (maps, without) in frame.maps.iter().zip(&bare.maps) {
                assert_eq!((&maps.filter, &maps.opaque), (&without.filter, &without.opaque));
            }
        }
    }
}

#[test]
fn occlusion_is_a_switch_or_a_radius() {
    let of = |value: &str| read(&format!("[camera]\nocclusion = {value}\n"));
    assert_eq!(of("false").unwrap().occlusion, Occlusion::None);
    assert_eq!(of("true").unwrap().occlusion, Occlusion::Usual);
    assert_eq!(of("2").unwrap().occlusion, Occlusion::Radius(2.0));
    assert_eq!(read("").unwrap().occlusion, Occlusion::Usual);
    for wrong in ["0", "-1.0", "nan", "\"much\"", "1e9"] {
        let error = of(wrong).unwrap_err().to_string();
        assert!(error.contains("occlusion"), "{wrong}: {error}");
    }
}
