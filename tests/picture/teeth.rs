//! Edges of shadows match rays: no teeth of texels.
use crate::common::{
    TIERS,
    edge_truth::{CLEAR, Edge, Truth},
    files::read,
    gpu,
};
use gobo::{
    Light, LightKind, Receiver, View,
    glam::{DVec3, Vec3},
    model::{ReceiverPoint, ShadowFilter, Source},
    view::{atlas::AtlasLimits, picture_views, shadow_views},
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_reference::light_points;
use gobo_scene as scene;
use gobo_scene::Scene;

/// Points on each side of an edge at which light is looked up.
const PLACES: i32 = 16;

/// Distances between edges in the shadow maps and edges by rays [pixels], sorted.
fn deviations(scene: &Scene, stride: u32) -> Vec<f64> {
    let truth = Truth::new(scene);
    let edges = truth.edges(stride);
    let options = RenderOptions { maps: true, maps_only: true, ..RenderOptions::default() };
    let maps = Renderer::on(gpu(TIERS[1])).unwrap().render(scene, &options).unwrap().maps;
    let views: Vec<_> = maps.iter().map(|maps| maps.view.clone()).collect();
    let place = |i: i32| CLEAR * f64::from(i) / f64::from(PLACES);
    let across = |edge: &Edge| {
        let points = (-PLACES..=PLACES).map(|i| {
            let position = truth.point(edge.plane, edge.at + edge.across * place(i)).as_vec3();
            ReceiverPoint { position, normal: edge.plane.normal.as_vec3() }
        });
        points.collect::<Vec<_>>()
    };
    let points: Vec<_> = edges.iter().flat_map(across).collect();
    let shares = light_points(scene, &views, &maps, &shadow_views, &points);
    let shares: Vec<_> = shares.iter().map(|&share| DVec3::from(share.map(f64::from))).collect();
    let deviation = |(edge, shares): (&Edge, &[DVec3])| {
        let change = edge.behind - edge.before;
        let level =
            |share: &DVec3| (*share - edge.before).dot(change) / change.length_squared() - 0.5;
        let levels: Vec<f64> = shares.iter().map(level).collect();
        let pairs = levels.windows(2).zip(-PLACES..);
        let crossings = pairs.filter(|(pair, _)| pair[0] < 0.0 && pair[1] >= 0.0);
        let places = crossings.map(|(pair, i)| place(i) + place(1) * pair[0] / (pair[0] - pair[1]));
        places.map(f64::abs).fold(CLEAR, f64::min)
    };
    let per_edge = 2 * PLACES as usize + 1;
    let mut all: Vec<f64> =
        edges.iter().zip(shares.chunks_exact(per_edge)).map(deviation).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Limit of the deviations' 99th percentile [pixels]: for spots with windows of 2,048 texels, and for low
/// suns over wide scenes.
#[test]
fn edges_have_no_teeth() {
    for (name, stride, most) in
        [("glass", 3, 0.4), ("gallery/nave", 5, 0.5), ("gallery/convoy", 1, 0.5)]
    {
        let path = crate::common::root().join(format!("data/{name}.toml"));
        let mut scene = scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        // Edges are measured on solids and panes.
        scene.particles.clear();
        scene.shadow.receiver = Receiver::Nearest;
        scene.lights.truncate(1);
        let p99 = |scene: &Scene| {
            let all = deviations(scene, stride);
            assert!(all.len() > 500, "{name}: {}", all.len());
            let [half, p99] =
                [0.5, 0.99].map(|share| all[((all.len() - 1) as f64 * share) as usize]);
            println!("{name}: {} edges, median {half:.2}, p99 {p99:.2} pixels", all.len());
            p99
        };
        assert!(p99(&scene) < most, "{name}");
        if name == "glass" {
            // Windows of half the edge.
            scene.shadow.receiver = Receiver::Curve;
            assert!(p99(&scene) < most, "{name}, by curves");
            scene.shadow.detail = false;
            assert!(p99(&scene) > 2.0 * most, "{name}, without windows");
        }
    }
}

/// A pane over a floor, under a sun or a lamp.
fn pane(light: &str) -> Scene {
    let scene = "
[camera]
eye = [0, 1.5, 3]
target = [0, 0.3, 0]
size = [320, 180]
[shadow]
size = 64
[[light]]
LIGHT
[[material]]
name = 'ground'
transfer = 'opaque'
[[material]]
name = 'red'
tint = [1, 0.2, 0.2, 1]
[[shape]]
kind = 'plane'
material = 'ground'
scale = [20, 1, 20]
[[shape]]
kind = 'pane'
material = 'red'
translation = [0, 0.6, 0]
rotation = [0, 20, 0]
";
    read(&scene.replace("LIGHT", light)).unwrap()
}

const SUN: &str = "kind = 'directional'\ndirection = [0.3, -1, 0.5]";
const LAMP: &str = "kind = 'spot'\nposition = [0, 3, -2]\ndirection = [0, -1, 0.8]\nangle = 90";

fn windows(scene: &Scene) -> Vec<View> {
    let (views, _) = picture_views(scene, &AtlasLimits::CORE);
    let windows: Vec<_> = views.iter().filter(|view| view.is_detail()).cloned().collect();
    let bases: Vec<_> = views.into_iter().filter(|view| !view.is_detail()).collect();
    assert_eq!(bases, shadow_views(scene), "a light's own views stay");
    windows
}

#[test]
fn windows_are_for_pictures_of_coarse_edges() {
    for light in [SUN, LAMP] {
        let scene = pane(light);
        let found = windows(&scene);
        assert!((1..=3).contains(&found.len()), "{light}: {}", found.len());
        assert!(found.windows(2).all(|pair| pair[0].scale > pair[1].scale), "{light}");
        let own = &shadow_views(&scene)[0];
        assert!(found.iter().all(|window| window.scale > 1.1 * own.scale), "{light}");
        // The pane's middle is in a window.
        let clip = found.last().unwrap().clip_from_world();
        let middle = clip.project_point3(Vec3::new(0.0, 0.6, 0.0));
        assert!(middle.truncate().abs().max_element() < 1.0, "{light}: {middle}");
        // Shadows without edges, or with edges of a width chosen by the user, have no windows.
        let without = |change: fn(&mut Scene)| {
            let mut scene = scene.clone();
            change(&mut scene);
            assert_eq!(windows(&scene), [], "{light}");
        };
        without(|scene| scene.shadow.detail = false);
        without(|scene| scene.shadow.blur = 2);
        without(|scene| scene.shadow.filter = ShadowFilter::Pcf { taps: 5 });
        without(|scene| scene.triangles.truncate(2));
        without(|scene| scene.camera.size /= 16);
        without(|scene| {
            let source = match scene.lights[0].kind {
                LightKind::Directional { .. } => Source::Sun { angle: 0.01 },
                _ => Source::Sphere { radius: 0.1 },
            };
            scene.lights[0] = Light { source: Some(source), ..scene.lights[0].clone() };
            scene.shadow.soft_detail = false;
        });
    }
}

/// A pane's shadow through windows, on devices and in the reference.
#[test]
fn windows_are_read_as_the_reference_says() {
    for light in [SUN, LAMP] {
        let scene = pane(light);
        let options = RenderOptions { light: true, ..RenderOptions::default() };
        let expected = Renderer::on_cpu().render(&scene, &options).unwrap().picture;
        for tier in TIERS {
            let picture =
                Renderer::on(gpu(tier)).unwrap().render(&scene, &options).unwrap().picture;
            let pixels = picture.rgb.iter().flatten().zip(expected.rgb.iter().flatten());
            let apart = pixels.filter(|(a, b)| a.abs_diff(**b) > 4).count();
            assert!(apart < 3 * picture.rgb.len() / 1000, "{light}, {tier}: {apart}");
        }
    }
}
