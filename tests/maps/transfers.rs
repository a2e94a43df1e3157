//! Transfer functions of all forms of casters, textured or not: CPU reference and both tiers.
use crate::common::{
    Tier, map_frame_scattered,
    scenes::{Chance, empty, hold_view, light, material, particle, triangle},
    tiers,
};
use gobo::{
    glam::{DVec3, Vec2, Vec3, Vec4},
    model::{Counters, LightKind, Material, Particle, Profile, Receiver, Shape, Texture, Transfer},
    records::ViewMaps,
    view::shadow_views,
};
use gobo_reference::render_maps;
use gobo_scene::Scene;

/// Rounding of the filter's storage, 11 bits, and of 16-bit opacities and colours; relative above 1.
const ROUNDING: f64 = 1e-3;
/// Relative error of software adapters, which decode sRGB by a polynomial.
const DECODING: f64 = 2e-3;
/// 176 in sRGB is linear 0.4342 (IEC 61966-2-1).
const TEXEL: Vec4 = Vec4::new(0.434_154, 1.0, 0.434_154, 0.8);

/// A light from above over 20 x 20 m in 128 x 128 texels, for any contents.
fn stage(materials: Vec<Material>) -> Scene {
    let mut scene = empty(materials);
    let wall = scene.materials.len() as u32;
    scene.materials.push(material(Transfer::Opaque));
    hold_view(&mut scene, wall);
    scene.lights.push(light(LightKind::Directional { direction: Vec3::NEG_Z }));
    scene.shadow.size = 128;
    let rgba = [176, 255, 176, 204].repeat(4);
    scene.textures.push(Texture { name: "even".into(), width: 2, height: 2, rgba });
    scene
}

/// Maps and counters of CPU reference and tiers.
fn all_maps(scene: &Scene) -> Vec<(ViewMaps, Counters)> {
    let (mut maps, counters) = render_maps(scene, &shadow_views(scene));
    let mut all = vec![(maps.remove(0), counters)];
    for tier in tiers(Tier::Native) {
        let mut frame = crate::common::map_frame(tier, scene);
        all.push((frame.maps.remove(0), frame.counters));
    }
    all
}

/// Index of the texel under a point, and the distance of its centre from the point [m].
fn texel_at(maps: &ViewMaps, x: f32, y: f32) -> (usize, f32) {
    let p = maps.view.view_from_world.transform_point3(Vec3::new(x, y, 0.0));
    let at = Vec2::new(p.x, -p.y) * maps.view.scale + maps.view.size.as_vec2() * 0.5;
    let texel = at.floor();
    let apart = (texel + 0.5 - at).length() / maps.view.scale;
    ((texel.y as u32 * maps.view.size.x + texel.x as u32) as usize, apart)
}

fn square(scene: &mut Scene, center: Vec3, half: f32, material: u32) {
    let corner = |x: f32, y: f32| center + Vec3::new(x * half, y * half, 0.0);
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    scene.triangles.extend([[a, b, c], [a, c, d]].map(|positions| triangle(positions, material)));
}

fn formula(transfer: Transfer, a: f64, c: DVec3) -> DVec3 {
    let filter = DVec3::ONE - a * (DVec3::ONE - c);
    match transfer {
        Transfer::Filter => filter,
        Transfer::Stain => c * (1.0 - a),
        Transfer::Smoke => (1.0 - a) * filter,
        // White light behind it.
        Transfer::Over => DVec3::splat(1.0 - a) + c * a,
        Transfer::Gain => c,
        _ => DVec3::ONE,
    }
}

#[derive(Clone, Copy, Debug)]
enum Form {
    Pane,
    TexturedPane,
    Disc,
    Quad,
    Puff,
}

const FORMS: [Form; 5] = [Form::Pane, Form::TexturedPane, Form::Disc, Form::Quad, Form::Puff];

/// One caster of each form and transfer, side by side.
fn check_forms(transfers: &[Transfer], tint: Vec4) {
    let mut scene = stage(Vec::new());
    let mut cells = Vec::new();
    for (row, &transfer) in transfers.iter().enumerate() {
        for (column, form) in FORMS.into_iter().enumerate() {
            let center = Vec3::new(column as f32 * 3.0 - 6.0, row as f32 * 3.0 - 6.0, 1.0);
            let (shape, texture) = match form {
                Form::Pane | Form::Disc => (Shape::Disc, None),
                Form::TexturedPane => (Shape::Disc, Some(0)),
                Form::Quad => (Shape::Quad, Some(0)),
                Form::Puff => (Shape::Puff, None),
            };
            let id = scene.materials.len() as u32;
            let profile = Profile::Flat;
            let own = Material { shape, texture, profile, tint, ..material(transfer) };
            scene.materials.push(own);
            if let Form::Pane | Form::TexturedPane = form {
                square(&mut scene, center, 1.0, id);
            } else {
                let white = Particle { material: id, ..particle(center, 1.0, Vec4::ONE) };
                scene.particles.push(white);
            }
            cells.push((transfer, form, center));
        }
    }
    for (maps, _) in all_maps(&scene) {
        for &(transfer, form, center) in &cells {
            let (at, apart) = texel_at(&maps, center.x, center.y);
            let texture =
                if let Form::TexturedPane | Form::Quad = form { TEXEL } else { Vec4::ONE };
            let look = (tint * texture).as_dvec4();
            let (a, c) = (look.w, look.truncate());
            let share = (1.0 - f64::from(apart).powi(2)).sqrt();
            let expected = match (form, transfer) {
                (Form::Puff, Transfer::Over) => formula(transfer, 1.0 - (1.0 - a).powf(share), c),
                (Form::Puff, _) => formula(transfer, a, c).powf(share),
                _ => formula(transfer, a, c),
            };
            let found = Vec3::from_array(maps.filter[at]).as_dvec3();
            let wrong = ((found - expected) / expected.max(DVec3::ONE)).abs().max_element();
            let rounding = if texture == Vec4::ONE { ROUNDING } else { DECODING };
            assert!(wrong <= rounding, "{transfer:?} {form:?}: {found} instead of {expected}");
            let none = transfer == Transfer::None;
            assert_eq!(maps.nearest[at] == 1.0, none, "{transfer:?} {form:?}");
        }
    }
}

#[test]
fn presets_have_their_formulas() {
    let tint = Vec4::new(0.9, 0.5, 0.1, 0.4);
    check_forms(&[Transfer::Filter, Transfer::Stain, Transfer::Smoke, Transfer::None], tint);
    check_forms(&[Transfer::Over], tint);
}

/// Pure coloured glass: with opacity 0 and below 1/255 only `c` changes the light, and no light is gained.
#[test]
fn what_stains_or_gains_without_opacity_sets_depths() {
    let tint = |alpha: f32| Vec4::new(0.2, 0.4, 0.8, alpha);
    let clear = Material { tint: tint(0.0), ..material(Transfer::Stain) };
    let rim = Material {
        tint: tint(0.5),
        shape: Shape::Disc,
        profile: Profile::Soft,
        ..material(Transfer::Stain)
    };
    let gain = Material { tint: Vec4::new(2.0, 1.5, 1.0, 0.0), ..material(Transfer::Gain) };
    for (material, light) in [(clear, Vec3::new(0.2, 0.4, 0.8)), (gain, Vec3::new(2.0, 1.5, 1.0))] {
        let mut scene = stage(vec![material]);
        square(&mut scene, Vec3::ZERO, 2.0, 0);
        for nodes in [0, 4] {
            if nodes > 0 {
                scene.shadow.receiver = Receiver::Curve;
                scene.shadow.nodes = nodes;
            }
            for (maps, _) in all_maps(&scene) {
                let texel = texel_at(&maps, 0.3, 0.2).0;
                let depth = maps.nearest[texel];
                assert!(depth > 0.1 && depth < 0.9, "{depth}");
                if let Some(curve) = &maps.curve {
                    let (before, behind) =
                        (curve.light_at(texel, depth - 0.01), curve.light_at(texel, depth + 0.01));
                    assert!((before - Vec3::ONE).abs().max_element() < 1e-3, "{before}");
                    assert!((behind - light).abs().max_element() < 2e-3, "{behind}");
                }
            }
        }
    }
    // The rim of a soft disc stains like its middle.
    let mut scene = stage(vec![rim]);
    scene.particles.push(particle(Vec3::ZERO, 1.5, Vec4::ONE));
    for (maps, _) in all_maps(&scene) {
        let stained = maps.filter.iter().zip(&maps.nearest).filter(|(f, _)| f[0] < 0.5);
        let (all, lost) =
            stained.fold((0, 0), |(all, lost), (_, d)| (all + 1, lost + u32::from(*d == 1.0)));
        assert!(all > 100 && lost == 0, "{lost} of {all}");
    }
}

#[test]
fn gain_brightens_up_to_sixteen() {
    check_forms(&[Transfer::Gain], Vec4::new(16.0, 1.5, 0.25, 0.7));
}

#[test]
fn gains_multiply_with_filters() {
    let gain = |r, g, b| Material { tint: Vec4::new(r, g, b, 1.0), ..material(Transfer::Gain) };
    let gel = Material { tint: Vec4::new(0.5, 0.25, 0.0, 1.0), ..material(Transfer::Filter) };
    let mut scene = stage(vec![gain(16.0, 4.0, 1.0), gel, gain(16.0, 0.5, 2.0)]);
    for material in 0..3 {
        square(&mut scene, Vec3::new(0.0, 0.0, 3.0 - material as f32), 2.0, material);
    }
    for (maps, _) in all_maps(&scene) {
        let found = maps.filter[texel_at(&maps, 0.4, 0.3).0];
        let expected = [128.0, 0.5, 0.0];
        for channel in 0..3 {
            let wrong = (found[channel] - expected[channel]).abs() / expected[channel].max(1.0);
            assert!(f64::from(wrong) <= ROUNDING, "{found:?}");
        }
    }
}

fn over(tint: Vec4) -> Material {
    Material { tint, profile: Profile::Flat, ..material(Transfer::Over) }
}

/// Light behind casters that it hits in this order.
fn chain(casters: impl IntoIterator<Item = (Transfer, Vec4)>) -> DVec3 {
    casters.into_iter().fold(DVec3::ONE, |light, (transfer, look)| {
        let (a, c) = (f64::from(look.w), look.truncate().as_dvec3());
        match transfer {
            Transfer::Over => light * (1.0 - a) + c * a,
            _ => light * formula(transfer, a, c),
        }
    })
}

#[track_caller]
fn assert_light(maps: &ViewMaps, at: usize, expected: DVec3, tolerance: f64) {
    let found = Vec3::from_array(maps.filter[at]).as_dvec3();
    assert!((found - expected).abs().max_element() <= tolerance, "{found} instead of {expected}");
}

#[test]
fn over_beside_what_commutes_is_a_chain_in_depth_order() {
    let looks = [
        (Transfer::Over, Vec4::new(1.0, 0.0, 0.0, 0.6)),
        (Transfer::Filter, Vec4::new(0.5, 0.9, 0.2, 0.8)),
        (Transfer::Over, Vec4::new(0.0, 0.2, 1.0, 0.5)),
        (Transfer::Stain, Vec4::new(0.9, 0.8, 0.9, 0.1)),
    ];
    let materials = |tint: (Transfer, Vec4)| Material { tint: tint.1, ..material(tint.0) };
    // The order of hits is by depth, for any order of the upload.
    for order in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1]] {
        let mut scene = stage(looks.map(materials).to_vec());
        for (place, look) in order.into_iter().enumerate() {
            square(&mut scene, Vec3::new(0.0, 0.0, 4.0 - place as f32), 2.0, look);
        }
        scene.triangles.reverse();
        scene.triangles.rotate_left(3);
        let expected = chain(order.map(|look| looks[look as usize]));
        for (maps, _) in all_maps(&scene) {
            assert_light(&maps, texel_at(&maps, 0.4, 0.3).0, expected, ROUNDING);
        }
    }
}

/// Many discs over one tile, and their transfers in depth order from the light.
fn stack(count: usize, radius: f32, alpha: f32) -> (Scene, Vec<(Transfer, Vec4)>) {
    let gel = Material { profile: Profile::Flat, ..material(Transfer::Filter) };
    let mut scene = stage(vec![over(Vec4::ONE), gel]);
    let mut chance = Chance::new(3);
    for i in 0..count {
        let z = 9.0 - 18.0 * i as f32 / count as f32;
        let color = chance.vec3(0.0, 1.0);
        // Long runs of red and blue in turn, so that not only the last segment counts.
        let color =
            if (i * 8 / count).is_multiple_of(2) { color * Vec3::X } else { color * Vec3::Z };
        let which = u32::from(i % 16 == 5);
        // A few are opaque enough for the nearest depth.
        let alpha = if i % 500 == 250 { alpha.max(0.005) } else { alpha };
        let alpha = if which == 0 { alpha } else { alpha * 0.1 };
        let center = Vec3::new(0.31, 0.29, z);
        let disc = particle(center, radius, color.extend(alpha));
        scene.particles.push(Particle { material: which, id: i as u32, ..disc });
    }
    let looks = scene
        .particles
        .iter()
        .map(|p| (if p.material == 0 { Transfer::Over } else { Transfer::Filter }, p.color));
    let looks = looks.collect();
    chance.shuffle(&mut scene.particles);
    (scene, looks)
}

/// Rounding of 16-bit opacities after thousands of products.
const LONG: f64 = 3e-3;

#[test]
fn over_is_composed_across_segments() {
    let (scene, looks) = stack(9000, 1.0, 3e-4);
    let expected = chain(looks.iter().copied());
    let reversed = chain(looks.iter().rev().copied());
    assert!((expected - reversed).abs().max_element() > 20.0 * LONG, "the order counts");
    for (maps, counters) in all_maps(&scene) {
        assert!(counters.segments > 4 && counters.unordered == 0, "{counters:?}");
        let (at, _) = texel_at(&maps, 0.31, 0.29);
        assert_light(&maps, at, expected, LONG);
        let p = maps.view.view_from_world.transform_point3(Vec3::Z * 8.5);
        let first = (-p.z - maps.view.near) / (maps.view.far - maps.view.near);
        assert!((maps.nearest[at] - first).abs() < 1e-5, "{} {first}", maps.nearest[at]);
    }
}

#[test]
fn tiny_discs_of_over_keep_their_order() {
    let (mut scene, looks) = stack(40, 0.4, 0.2);
    // Texels of 1.3 m.
    scene.lights[0].size = Some(16);
    for (maps, counters) in all_maps(&scene) {
        assert_eq!(counters.scattered, 0);
        let texel = 1.0 / maps.view.scale;
        let thin = (0.4 / (texel * std::f32::consts::FRAC_1_SQRT_2)).powi(2);
        let thinned =
            looks.iter().map(|&(transfer, look)| (transfer, look.truncate().extend(look.w * thin)));
        assert_light(&maps, texel_at(&maps, 0.31, 0.29).0, chain(thinned), ROUNDING * 2.0);
    }
}

#[test]
fn over_ends_at_the_opaque_surface() {
    let wall = material(Transfer::Opaque);
    let (red, blue) = (Vec4::new(1.0, 0.0, 0.0, 0.6), Vec4::new(0.0, 0.0, 1.0, 0.6));
    let mut scene = stage(vec![over(red), over(blue), wall]);
    for material in [0, 2, 1] {
        square(&mut scene, Vec3::new(0.0, 0.0, [3.0, 1.0, 2.0][material as usize]), 2.0, material);
    }
    for (maps, _) in all_maps(&scene) {
        let at = texel_at(&maps, 0.4, 0.3).0;
        assert_light(&maps, at, chain([(Transfer::Over, red)]), ROUNDING);
        assert!(maps.opaque[at] < 1.0);
    }
}

#[test]
fn what_is_scattered_is_counted_as_unordered() {
    let (mut scene, looks) = stack(3000, 1.0, 1e-3);
    scene.shadow.pair_budget = 2500;
    // The rest is applied last, each as if light behind it were white.
    let product = |look: &(Transfer, Vec4)| chain([*look]);
    for mut frame in tiers(Tier::Native).into_iter().map(|tier| map_frame_scattered(tier, &scene)) {
        let (maps, counters) = (frame.maps.remove(0), frame.counters);
        assert!(
            counters.unordered > 0 && counters.unordered == counters.overflowed,
            "{counters:?}"
        );
        let at = texel_at(&maps, 0.31, 0.29).0;
        let least = looks.iter().map(product).fold(DVec3::ONE, |a, b| a * b);
        let found = Vec3::from_array(maps.filter[at]).as_dvec3();
        assert!(found.min_element() >= least.min_element() - LONG && found.max_element() <= 1.0);
    }
}
