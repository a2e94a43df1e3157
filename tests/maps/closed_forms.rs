//! Closed forms of simple scenes.
use crate::common::scenes::{empty, flat_view, light, material, pane, particle, triangle};
use gobo::{
    glam::{Vec2, Vec3, Vec4},
    model::{LightKind, Material, Particle, Profile, Shape, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::{MapTexel, receive, render_maps};
use gobo_scene::Scene;

/// Rounding of the filter's storage, half a unit of f16 near 1, and of 16-bit opacities and colours.
const ROUNDING: f32 = 1e-3;

/// Map through a [`flat_view`] of `size` texels, one per metre.
fn flat_map(scene: &Scene, size: u32) -> ViewMaps {
    render_maps(scene, &[flat_view(size, 1.0)]).0.remove(0)
}

fn tinted(transfer: Transfer, tint: Vec4) -> Material {
    Material { profile: Profile::Flat, tint, ..material(transfer) }
}

#[track_caller]
fn assert_near(actual: [f32; 3], expected: Vec3) {
    let apart = (Vec3::from_array(actual) - expected).abs().max_element();
    assert!(apart <= ROUNDING, "{actual:?} instead of {expected}");
}

/// Panes at light depths 0.3, 0.5, ... of one material each, all over the map.
fn panes(materials: Vec<Material>) -> Scene {
    let depths = (0..materials.len() as u32).map(|i| (0.3 + 0.2 * i as f32, i));
    let triangles = depths.flat_map(|(depth, material)| pane(depth, 100.0, material)).collect();
    Scene { triangles, ..empty(materials) }
}

fn uniform(maps: &ViewMaps) -> MapTexel {
    let first = MapTexel {
        filter: Vec3::from_array(maps.filter[0]),
        nearest: maps.nearest[0],
        opaque: maps.opaque[0],
    };
    assert!(maps.filter.iter().all(|f| Vec3::from_array(*f) == first.filter));
    assert!(maps.nearest.iter().all(|d| (d - first.nearest).abs() < 1e-6));
    assert!(maps.opaque.iter().all(|z| (z - first.opaque).abs() < 1e-6));
    first
}

#[test]
fn overlapping_panes_multiply() {
    let (red, green) = (Vec4::new(1.0, 0.2, 0.1, 0.8), Vec4::new(0.3, 1.0, 0.5, 0.5));
    let scene = panes(vec![tinted(Transfer::Filter, red), tinted(Transfer::Filter, green)]);
    let texel = uniform(&flat_map(&scene, 32));
    let through = |tint: Vec4| Vec3::ONE - tint.w * (Vec3::ONE - tint.truncate());
    assert_near(texel.filter.to_array(), through(red) * through(green));
    assert!((texel.nearest - 0.3).abs() < 1e-6 && texel.opaque == 1.0);
}

#[test]
fn an_opaque_pane_hides_what_is_behind_it_only() {
    let tint = Vec4::new(0.5, 0.6, 0.7, 0.5);
    let glass = tinted(Transfer::Filter, tint);
    let wall = material(Transfer::Opaque);
    let before = uniform(&flat_map(&panes(vec![glass.clone(), wall.clone()]), 32));
    assert_near(before.filter.to_array(), Vec3::new(0.75, 0.8, 0.85));
    assert!((before.nearest - 0.3).abs() < 1e-6 && (before.opaque - 0.5).abs() < 1e-6);
    let behind = uniform(&flat_map(&panes(vec![wall, glass]), 32));
    assert!(behind.filter == Vec3::ONE && behind.nearest == 1.0);
    assert!((behind.opaque - 0.3).abs() < 1e-6);
}

#[test]
fn a_hit_on_the_opaque_surface_does_nothing() {
    let mut scene =
        panes(vec![material(Transfer::Opaque), tinted(Transfer::Filter, Vec4::splat(0.5))]);
    scene.triangles = [pane(0.3, 100.0, 0), pane(0.3, 100.0, 1)].concat();
    let texel = uniform(&flat_map(&scene, 32));
    assert!(texel.filter == Vec3::ONE && texel.nearest == 1.0);
}

#[test]
fn cutouts_block_from_their_cutoff() {
    for (alpha, solid) in [(0.49, false), (0.51, true)] {
        let scene = panes(vec![tinted(Transfer::Cutout, Vec4::new(1.0, 1.0, 1.0, alpha))]);
        let texel = uniform(&flat_map(&scene, 16));
        assert_eq!(texel.opaque < 1.0, solid);
        assert!(texel.filter == Vec3::ONE && texel.nearest == 1.0);
    }
}

#[test]
fn each_transfer_has_its_formula() {
    let (c, a) = (Vec3::new(0.9, 0.5, 0.1), 0.4);
    let filter = Vec3::ONE - a * (Vec3::ONE - c);
    let cases = [
        (Transfer::Filter, filter),
        (Transfer::Stain, c * (1.0 - a)),
        (Transfer::Smoke, (1.0 - a) * filter),
        (Transfer::Over, Vec3::splat(1.0 - a) + c * a),
        (Transfer::Gain, c),
        (Transfer::None, Vec3::ONE),
    ];
    for (transfer, expected) in cases {
        let scene = panes(vec![tinted(transfer, c.extend(a))]);
        assert_near(uniform(&flat_map(&scene, 16)).filter.to_array(), expected);
        let mut disc = empty(vec![tinted(transfer, Vec4::ONE)]);
        disc.particles.push(particle(Vec3::new(0.0, 0.0, -3.0), 100.0, c.extend(a)));
        assert_near(uniform(&flat_map(&disc, 16)).filter.to_array(), expected);
    }
    let bright = panes(vec![tinted(Transfer::Gain, Vec4::new(12.0, 1.0, 0.0, 1.0))]);
    let light = uniform(&flat_map(&bright, 16)).filter;
    assert!((light - Vec3::new(12.0, 1.0, 0.0)).abs().max_element() < 0.01);
}

#[test]
fn over_depends_on_the_order() {
    let (red, blue) = (Vec4::new(1.0, 0.0, 0.0, 0.6), Vec4::new(0.0, 0.0, 1.0, 0.6));
    for (first, second) in [(red, blue), (blue, red)] {
        let scene = panes(vec![tinted(Transfer::Over, first), tinted(Transfer::Over, second)]);
        let light = [first, second]
            .iter()
            .fold(Vec3::ONE, |light, tint| light * (1.0 - tint.w) + tint.truncate() * tint.w);
        assert_near(uniform(&flat_map(&scene, 16)).filter.to_array(), light);
    }
}

#[test]
fn the_receiver_obeys_rules_one_and_two() {
    let texel = MapTexel { filter: Vec3::new(0.5, 0.25, 0.0), nearest: 0.3, opaque: 0.7 };
    let bias = 0.01;
    assert_eq!(receive(0.72, &texel, bias), Vec3::ZERO);
    assert_eq!(receive(0.705, &texel, bias), texel.filter);
    assert_eq!(receive(0.32, &texel, bias), texel.filter);
    assert_eq!(receive(0.305, &texel, bias), Vec3::ONE);
    assert_eq!(receive(0.1, &texel, bias), Vec3::ONE);
}

#[test]
fn alpha_fades_to_no_shadow_without_a_step() {
    for radius in [0.3, 3.0] {
        let shadow_of = |alpha: f32| {
            let mut scene = empty(vec![tinted(Transfer::Filter, Vec4::ONE)]);
            let black = Vec4::new(0.0, 0.0, 0.0, alpha);
            scene.particles.push(particle(Vec3::new(0.5, 0.5, -3.0), radius, black));
            let maps = flat_map(&scene, 16);
            1.0 - maps.filter[7 * 16 + 8][0]
        };
        let full = shadow_of(1.0);
        let mut before = full;
        for i in (0..=400).rev() {
            let alpha = i as f32 / 400.0;
            let shadow = shadow_of(alpha);
            assert!((shadow - full * alpha).abs() <= ROUNDING, "{alpha}: {shadow}");
            assert!(shadow <= before);
            before = shadow;
        }
        assert_eq!(before, 0.0);
    }
}

#[test]
fn discs_below_a_texel_conserve_light() {
    // One disc in each cell of 8x8 texels, at all offsets from the texels' centres.
    let cells = 64;
    for radius in [0.1_f32, 0.4, 0.7] {
        let mut scene = empty(vec![tinted(Transfer::Filter, Vec4::ONE)]);
        for i in 0..cells * cells {
            let cell = Vec2::new((i % cells) as f32, (i / cells) as f32);
            let at = (cell - cells as f32 * 0.5) * 8.0 + 4.0 + (cell + 0.5) / cells as f32;
            let black = Vec4::new(0.0, 0.0, 0.0, 1.0);
            scene.particles.push(particle(at.extend(-3.0), radius, black));
        }
        let maps = flat_map(&scene, 512);
        let shadow: f64 = maps.filter.iter().map(|f| 1.0 - f64::from(f[0])).sum();
        let area = f64::from(cells * cells) * std::f64::consts::PI * f64::from(radius).powi(2);
        assert!((shadow / area - 1.0).abs() < 0.01, "{radius}: {shadow} instead of {area}");
    }
}

#[test]
fn a_disc_across_a_cube_seam_has_no_seam() {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights.push(light(LightKind::Point { position: Vec3::ZERO }));
    scene.particles.push(particle(Vec3::new(2.0, 0.3, 2.0), 1.5, Vec4::new(0.1, 0.5, 0.9, 0.9)));
    let views = shadow_views(&scene);
    let (maps, _) = render_maps(&scene, &views);
    let face = |name| maps.iter().find(|maps| maps.view.name == name).expect("a face");
    let (px, pz) = (face("px"), face("pz"));
    let size = px.view.size.x as usize;
    let mut shaded = 0;
    for y in 0..size {
        for k in 0..8 {
            let (a, b) = (y * size + size - 1 - k, y * size + k);
            assert_near(px.filter[a], Vec3::from_array(pz.filter[b]));
            assert!((px.nearest[a] - pz.nearest[b]).abs() < 1e-5);
            shaded += usize::from(px.filter[a][0] < 0.5);
        }
    }
    assert!(shaded > size);
}

#[test]
fn a_shared_edge_is_hit_exactly_once() {
    // A fan around a texel's centre, with edges through rows, columns and diagonals of centres.
    let middle = Vec3::new(0.5, 0.5, -3.0);
    let corner = |i: i32| {
        let (sin, cos) = (i as f32 * std::f32::consts::FRAC_PI_4).sin_cos();
        middle
            + Vec3::new(
                cos.signum() * f32::from(cos.abs() > 0.1) * 40.0,
                sin.signum() * f32::from(sin.abs() > 0.1) * 40.0,
                0.0,
            )
    };
    for turn in [1, -1] {
        let mut scene = empty(vec![tinted(Transfer::Filter, Vec4::new(0.0, 0.0, 0.0, 0.5))]);
        for i in 0..8 {
            scene.triangles.push(triangle([middle, corner(i * turn), corner((i + 1) * turn)], 0));
        }
        let maps = flat_map(&scene, 32);
        assert!(maps.filter.iter().all(|f| (f[0] - 0.5).abs() < ROUNDING), "hit once");
        scene.triangles.pop();
        let maps = flat_map(&scene, 32);
        assert!(maps.filter.iter().any(|f| f[0] == 1.0), "one left out is noticed");
    }
}

#[test]
fn a_hundred_thousand_casters_saturate() {
    for radius in [20.0, 0.4] {
        let mut scene = empty(vec![tinted(Transfer::Filter, Vec4::ONE)]);
        for id in 0..100_000_u32 {
            // In no order of depth; the nearest is at 0.1.
            let depth = 0.1 + (id.wrapping_mul(7919) % 100_000) as f32 * 8e-6;
            let center = Vec3::new(0.5, 0.5, -10.0 * depth);
            scene
                .particles
                .push(Particle { id, ..particle(center, radius, Vec4::new(0.2, 0.5, 0.9, 0.7)) });
        }
        let (maps, _) = render_maps(&scene, &[flat_view(16, 1.0)]);
        let middle = 7 * 16 + 8;
        assert_eq!(maps[0].filter[middle], [0.0; 3]);
        assert!((maps[0].nearest[middle] - 0.1).abs() < 1e-6);
    }
}

#[test]
fn a_puff_absorbs_along_the_chord() {
    let puff = Material { shape: Shape::Puff, ..material(Transfer::Filter) };
    let wall = material(Transfer::Opaque);
    let mut scene = empty(vec![puff, wall]);
    let color = Vec4::new(0.1, 0.5, 1.0, 0.8);
    scene.particles.push(particle(Vec3::new(0.5, 0.5, -5.0), 4.0, color));
    let whole = Vec3::ONE - color.w * (Vec3::ONE - color.truncate());
    let at = |maps: &ViewMaps, x: usize| (maps.filter[7 * 16 + x], maps.nearest[7 * 16 + x]);
    let free = flat_map(&scene, 16);
    assert_near(at(&free, 8).0, whole);
    assert!((at(&free, 8).1 - 0.1).abs() < 1e-5);
    // Two texels aside, the chord is shorter.
    let share = (1.0_f32 - 0.25).sqrt();
    assert_near(at(&free, 10).0, whole.powf(share));
    assert!((at(&free, 10).1 - (0.5 - 0.4 * share)).abs() < 1e-5);
    scene.triangles.extend(pane(0.5, 100.0, 1));
    assert_near(at(&flat_map(&scene, 16), 8).0, whole.powf(0.5));
}

#[test]
fn hits_outside_the_planes_do_nothing() {
    let glass = tinted(Transfer::Filter, Vec4::splat(0.5));
    for (depth, seen) in [(-0.01, false), (0.0, true), (0.999, true), (1.01, false)] {
        let mut scene = empty(vec![glass.clone()]);
        scene.triangles.extend(pane(depth, 100.0, 0));
        scene.particles.push(particle(Vec3::new(0.0, 0.0, -10.0 * depth), 30.0, Vec4::ONE));
        let texel = uniform(&flat_map(&scene, 16));
        assert_eq!(texel.filter != Vec3::ONE, seen, "{depth}");
    }
}
