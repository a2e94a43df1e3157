//! Filters and biases of look-ups: against closed forms and against the CPU reference.
use crate::common::{
    TIERS, gpu,
    scenes::{Chance, empty, light, material, random_discs, triangle},
};
use gobo::{
    Error, Light, LightKind, Material, Receiver, Transfer,
    glam::{Vec2, Vec3, Vec4},
    model::{LookUp, ReceiverPoint, ShadowFilter},
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;
use std::f64::consts::PI;

const GLASS: Vec3 = Vec3::new(0.9, 0.25, 0.5);
/// Rounding of a map's storage.
const ROUNDING: f64 = 1e-3;

const DISC: ShadowFilter = ShadowFilter::Vogel { taps: 64, radius: 4.0 };
const FILTERS: [ShadowFilter; 6] = [
    ShadowFilter::None,
    ShadowFilter::Bilinear,
    ShadowFilter::Spline,
    ShadowFilter::Pcf { taps: 2 },
    ShadowFilter::Pcf { taps: 5 },
    DISC,
];

/// A parallelogram of two triangles, by a corner and two edges.
fn rectangle(corner: Vec3, right: Vec3, up: Vec3, material: u32) -> [gobo::Triangle; 2] {
    let far = corner + right + up;
    [[corner, corner + right, far], [corner, far, corner + up]].map(|p| triangle(p, material))
}

/// A pane at y = 1 that ends at x = 0, under a sun: opaque, or of glass.
fn edge(transfer: Transfer, filter: ShadowFilter, receiver: Receiver) -> Scene {
    let mut scene = empty(vec![Material { tint: GLASS.extend(1.0), ..material(transfer) }]);
    scene.triangles =
        rectangle(Vec3::new(-2.0, 1.0, -2.0), Vec3::X * 2.0, Vec3::Z * 4.0, 0).to_vec();
    // Fixes the extent of the map.
    scene.triangles.push(triangle([Vec3::new(2.0, 1.0, 2.0); 3], 0));
    let down = LightKind::Directional { direction: Vec3::NEG_Y };
    scene.lights = vec![Light { size: Some(64), ..light(down) }];
    (scene.shadow.filter, scene.shadow.receiver) = (filter, receiver);
    scene
}

fn renderers() -> [Renderer; 2] {
    [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on_cpu()]
}

/// Points across the edge, their positions in the map [texels], and the position of the edge.
fn across(scene: &Scene) -> (Vec<ReceiverPoint>, Vec<f64>, f64) {
    let view = &shadow_views(scene)[0];
    let place = |point: Vec3| {
        let p = view.view_from_world.transform_point3(point);
        let middle = view.size.as_dvec2() * 0.5;
        // The map's axis across the edge.
        let axis = view.view_from_world.transform_vector3(Vec3::X);
        let along = p.dot(axis);
        f64::from(along) * f64::from(view.scale) + middle.x
    };
    let xs = (0..160).map(|i| (i as f32 - 80.0) * 0.01);
    let points: Vec<_> =
        xs.map(|x| ReceiverPoint { position: Vec3::X * x, normal: Vec3::ZERO }).collect();
    let places = points.iter().map(|point| place(point.position)).collect();
    // Texels with their centre under the pane are dark.
    let end = (place(Vec3::ZERO) - 0.5).ceil();
    (points, places, end)
}

/// Light at `off` texels beyond the last dark one: the mean of bilinear taps, and of a spline.
fn expected(filter: ShadowFilter, off: f64) -> f64 {
    let ramp = |off: f64| (off + 0.5).clamp(0.0, 1.0);
    match filter {
        ShadowFilter::None => f64::from(u8::from(off >= 0.0)),
        ShadowFilter::Bilinear => ramp(off),
        ShadowFilter::Pcf { taps } => {
            let tap = |i: u32| ramp(off + f64::from(i) - f64::from(taps - 1) * 0.5);
            (0..taps).map(tap).sum::<f64>() / f64::from(taps)
        }
        // A mean of ramps over a texel.
        ShadowFilter::Spline => {
            let tap = |i: i32| ramp(off + (f64::from(i) + 0.5) / 256.0 - 0.5);
            (0..256).map(tap).sum::<f64>() / 256.0
        }
        // Share of the disc beyond the edge.
        ShadowFilter::Vogel { radius, .. } => {
            let t = (off / f64::from(radius)).clamp(-1.0, 1.0);
            1.0 - (t.acos() - t * (1.0 - t * t).sqrt()) / PI
        }
    }
}

#[test]
fn edges_are_as_paper_says_in_black_and_in_colour() {
    for mut renderer in renderers() {
        for filter in FILTERS {
            for receiver in [Receiver::Nearest, Receiver::Curve] {
                let shares = [Transfer::Opaque, Transfer::Filter].map(|transfer| {
                    let scene = edge(transfer, filter, receiver);
                    let (points, ..) = across(&scene);
                    renderer.light_points(&scene, &points).unwrap()
                });
                let (_, places, end) = across(&edge(Transfer::Opaque, filter, receiver));
                // A disc's texels count entirely, and none is in two places.
                let slack = if filter == DISC { 0.09 } else { ROUNDING };
                for (i, place) in places.iter().enumerate() {
                    let black = f64::from(shares[0][i][0]);
                    let expected = expected(filter, place - end);
                    let device = renderer.device();
                    let apart = (black - expected).abs();
                    let is_border = filter == ShadowFilter::None && (place - end).abs() < 1e-3;
                    assert!(
                        apart <= slack || is_border,
                        "{filter:?} {place} {black} {expected} {device}"
                    );
                    // The same texels have the same weights for the colour.
                    let tinted = GLASS + (Vec3::ONE - GLASS) * shares[0][i][0];
                    let apart = (Vec3::from(shares[1][i]) - tinted).abs().max_element();
                    assert!(
                        apart < 2e-3,
                        "{filter:?} {receiver:?} {tinted} {:?} {device}",
                        shares[1][i]
                    );
                }
            }
        }
    }
}

/// Lights of all kinds, one for each filter.
fn crowd(receiver: Receiver) -> Scene {
    let glass = Material { tint: Vec4::new(0.9, 0.5, 0.7, 0.3), ..material(Transfer::Filter) };
    let mut scene = empty(vec![glass, material(Transfer::Opaque)]);
    scene.particles = random_discs(300, 5);
    scene.triangles =
        rectangle(Vec3::new(-2.0, -0.5, -2.0), Vec3::X * 4.0, Vec3::Z * 4.0, 1).to_vec();
    scene.shadow.receiver = receiver;
    let kinds = [
        LightKind::Directional { direction: Vec3::new(0.3, -1.0, 0.2) },
        LightKind::Point { position: Vec3::new(0.2, 0.8, 0.1) },
        LightKind::Spot {
            position: Vec3::new(1.0, 4.0, 0.5),
            direction: Vec3::new(-1.0, -4.0, 0.0),
            angle: 1.0,
        },
    ];
    let of = |(i, filter)| {
        let look_up = LookUp { filter: Some(filter), ..LookUp::default() };
        Light { look_up, ..light(kinds[i % 3]) }
    };
    scene.lights = FILTERS.into_iter().enumerate().map(of).collect();
    scene.lights[3].cascades = Some(gobo::model::Cascades::default());
    scene.lights[1].look_up.slope_bias = Some(1.0);
    scene.lights[4].look_up.bias = Some(0.05);
    scene
}

#[test]
fn kernels_ask_the_texels_of_the_reference() {
    let mut chance = Chance::new(9);
    let point = |i| {
        let normal = if i % 3 == 0 { Vec3::ZERO } else { chance.vec3(-1.0, 1.0).normalize() };
        ReceiverPoint { position: chance.vec3(-1.4, 1.4), normal }
    };
    let points: Vec<_> = (0..1500).map(point).collect();
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        let scene = crowd(receiver);
        let shares = renderers().map(|mut own| own.light_points(&scene, &points).unwrap());
        let count = scene.lights.len();
        for (i, filter) in FILTERS.iter().enumerate() {
            let of_light = |shares: &[[f32; 3]], p: usize| Vec3::from(shares[p * count + i]);
            let apart = |p| (of_light(&shares[0], p) - of_light(&shares[1], p)).abs().max_element();
            let far = (0..points.len()).filter(|&p| apart(p) > 0.02).count();
            let mean = (0..points.len()).map(apart).sum::<f32>() / points.len() as f32;
            assert!(far <= 8 && mean < 5e-4, "{filter:?} {receiver:?}: {far} {mean}");
        }
        // A light with the default filter has the same bits as without the others.
        let mut alone = scene.clone();
        alone.lights.iter_mut().for_each(|light| light.look_up = LookUp::default());
        let plain = renderers()[0].light_points(&alone, &points).unwrap();
        let spline = |p: usize| p * count + 2;
        assert!((0..points.len()).all(|p| plain[spline(p)] == shares[0][spline(p)]));
        assert!((0..points.len()).any(|p| plain[spline(p) + 2] != shares[0][spline(p) + 2]));
    }
}

/// Discs are rotated from pixel to pixel, in the same way in every frame.
#[test]
fn pictures_turn_discs_as_the_reference_does() {
    let mut scene = crowd(Receiver::Nearest);
    scene.lights.truncate(3);
    for light in &mut scene.lights {
        light.look_up = LookUp::default();
        light.intensity = 2.0;
    }
    scene.shadow.filter = ShadowFilter::Vogel { taps: 5, radius: 3.0 };
    let [first, again] = [0, 1].map(|_| {
        let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
        renderer.render(&scene, &RenderOptions::default()).unwrap().picture
    });
    assert_eq!(first.rgb, again.rgb);
    let cpu = Renderer::on_cpu().render(&scene, &RenderOptions::default()).unwrap().picture;
    let apart = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).any(|i| a[i].abs_diff(b[i]) > 6);
    let far = first.rgb.iter().zip(&cpu.rgb).filter(|&pair| apart(pair)).count();
    assert!(far <= cpu.rgb.len() / 200, "{far}");
}

/// A slope of 60 degrees does not shadow itself once one of the biases covers the filter.
#[test]
fn biases_cover_what_the_slope_hides() {
    let down = LightKind::Directional { direction: Vec3::NEG_Y };
    let mut scene = empty(vec![material(Transfer::Opaque)]);
    let up = Vec3::new(0.0, 3f32.sqrt(), 1.0);
    let low = Vec3::new(-1.0, -(3f32.sqrt()), -1.0);
    scene.triangles = rectangle(low, Vec3::X * 2.0, up * 2.0, 0).to_vec();
    scene.lights = vec![Light { size: Some(32), ..light(down) }];
    let normal = up.cross(Vec3::X).normalize();
    let normal = if normal.y > 0.0 { normal } else { -normal };
    let along = |i: usize| (i as f32 / 40.0 - 0.5) * 1.5;
    let on_slope = |i: usize| {
        let place = Vec2::new(along(i % 40), along(i / 40));
        ReceiverPoint { position: Vec3::X * place.x + up * place.y, normal }
    };
    let points: Vec<_> = (0..1600).map(on_slope).collect();
    let wide = ShadowFilter::Pcf { taps: 7 };
    for mut renderer in renderers() {
        let mut darkest = |filter, bias: f32, slope_bias: f32, normal_bias: f32| {
            scene.shadow.filter = ShadowFilter::Spline;
            let [bias, slope_bias, normal_bias] = [bias, slope_bias, normal_bias].map(Some);
            scene.lights[0].look_up =
                LookUp { filter: Some(filter), bias, slope_bias, normal_bias };
            let shares = renderer.light_points(&scene, &points).unwrap();
            shares.iter().fold(1.0_f32, |least, share| least.min(share[0]))
        };
        for filter in [ShadowFilter::Spline, wide] {
            assert!(darkest(filter, 1e-4, 0.0, 0.0) < 0.9, "{filter:?}: nothing to cover");
            // Weights sum up to 1, up to rounding.
            assert!(darkest(filter, 1e-4, 0.0, 1.5) > 0.9999, "{filter:?}: normal");
            assert!(darkest(filter, 1e-4, 1.5, 0.0) > 0.9999, "{filter:?}: slope");
            assert!(darkest(filter, 0.4, 0.0, 0.0) > 0.9999, "{filter:?}: constant");
        }
        // In a map of 32 texels over 2 m: 0.9 texels of a slope of the root of 3 are not enough.
        assert!(darkest(ShadowFilter::Spline, 1e-4, 0.5, 0.0) < 0.99);
    }
}

/// A plane has no shadow of its own, however wide the filter, where a lamp is off the view's axis and where
/// the slope is along the corners of a box.
#[test]
fn wide_filters_let_no_plane_shade_itself() {
    let lamp = LightKind::Point { position: Vec3::ZERO };
    let sun = LightKind::Directional { direction: Vec3::new(-1.0, -1.0, -1.0) };
    let middle = Vec3::new(1.1, -1.6, 0.9);
    let planes = [
        (lamp, 512, -middle.normalize()), // it faces the lamp
        (lamp, 512, Vec3::new(-0.8, 0.5, 0.3).normalize()),
        (lamp, 512, Vec3::Y),
        (sun, 256, Vec3::new(0.9, 0.2, 0.3).normalize()),
        (sun, 256, Vec3::Y),
    ];
    let wide = [
        ShadowFilter::Pcf { taps: 5 },
        ShadowFilter::Pcf { taps: 11 },
        ShadowFilter::Vogel { taps: 64, radius: 6.0 },
    ];
    for mut renderer in renderers() {
        for (kind, size, normal) in planes {
            let (right, up) = normal.any_orthonormal_pair();
            let mut scene = empty(vec![material(Transfer::Opaque)]);
            scene.triangles =
                rectangle(middle - 3.0 * (right + up), right * 6.0, up * 6.0, 0).to_vec();
            scene.lights = vec![Light { size: Some(size), far: Some(16.0), ..light(kind) }];
            let along = |i: usize| i as f32 / 20.0 - 0.5;
            let on_plane = |i: usize| {
                let position = middle + right * along(i % 20) + up * along(i / 20);
                ReceiverPoint { position, normal }
            };
            let points: Vec<_> = (0..400).map(on_plane).collect();
            for filter in wide {
                let look_up = LookUp { filter: Some(filter), ..LookUp::default() };
                scene.lights[0].look_up = look_up;
                let shares = renderer.light_points(&scene, &points).unwrap();
                let least = shares.iter().fold(1.0_f32, |least, share| least.min(share[0]));
                assert!(least > 0.995, "{kind:?}, {normal}, {filter:?}: {least}");
                // Behind it there is no light.
                let behind = |point: &ReceiverPoint| ReceiverPoint {
                    position: point.position - normal * 0.6,
                    ..*point
                };
                let behind: Vec<_> = points.iter().map(behind).collect();
                let shares = renderer.light_points(&scene, &behind).unwrap();
                let most = shares.iter().fold(0.0_f32, |most, share| most.max(share[0]));
                assert!(most < 0.005, "{kind:?}, {normal}, {filter:?}: {most}");
            }
        }
    }
}

#[test]
fn more_texels_than_a_point_may_ask_are_refused() {
    let mut scene = crowd(Receiver::Nearest);
    let lamp = LightKind::Spot { position: Vec3::Y * 3.0, direction: Vec3::NEG_Y, angle: 0.5 };
    let look_up = LookUp { filter: Some(ShadowFilter::Pcf { taps: 11 }), ..LookUp::default() };
    scene.lights = vec![Light { size: Some(16), look_up, ..light(lamp) }; 300];
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let error = renderer.render(&scene, &RenderOptions::default()).unwrap_err();
    assert!(matches!(error, Error::Limit { need: 43_200, .. }), "{error}");
    scene.lights[0].look_up.filter = Some(ShadowFilter::Pcf { taps: 12 });
    let error = renderer.render(&scene, &RenderOptions::default()).unwrap_err();
    assert!(error.to_string().contains("filter"), "{error}");
}
