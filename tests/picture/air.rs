//! Light scattered by the air: closed forms, and kernels against the CPU reference.
use crate::common::{
    TIERS, Tier,
    files::read,
    reference_picture, render,
    scenes::{empty, light, pane},
    tiers,
};
use gobo::{
    glam::{UVec2, Vec2, Vec3, Vec4},
    model::{Air, LightKind, Material, Transfer, View},
    records::Picture,
    view::shadow_views,
};
use gobo_reference as reference;
use gobo_reference::records::AirParams;
use gobo_reference::{
    air::{AirVolume, phase},
    shading::Lighting,
};
use gobo_scene as scene;
use gobo_scene::Scene;

/// Red is scattered without extinction, blue has more extinction than scattering.
pub(super) const AIR: Air = Air {
    scattering: Vec3::new(0.18, 0.14, 0.1),
    extinction: Vec3::new(0.0, 0.14, 0.3),
    ambient: 0.5,
    anisotropy: 0.4,
    steps: 48,
};

/// A sun, a wall far behind, air.
fn sunny() -> Scene {
    let mut scene = empty(vec![Material { transfer: Transfer::Opaque, ..Material::default() }]);
    scene.triangles = pane(2.0, 100.0, 0).to_vec();
    scene.camera.eye = Vec3::new(0.5, 0.2, -1.0);
    scene.camera.target = Vec3::new(-0.3, 0.0, -15.0);
    scene.lights =
        vec![light(LightKind::Directional { direction: Vec3::new(0.3, -1.0, 0.2).normalize() })];
    scene.lights[0].intensity = 2.0;
    scene.lights[0].casts = false;
    scene.air = Some(AIR);
    scene
}

fn volume(scene: &Scene) -> (AirVolume, View) {
    volume_through(scene, Vec2::ZERO)
}

/// The air of a sample whose offset in its pixels is `offset`.
fn volume_through(scene: &Scene, offset: Vec2) -> (AirVolume, View) {
    let camera = View::from_camera(&scene.camera, &scene.bounds()).through(offset);
    let views = shadow_views(scene);
    let maps = reference::render_maps(scene, &views).0;
    let lighting = Lighting::new(scene, &views, &maps);
    let view = camera.to_gpu(0, UVec2::ZERO, 0);
    let params = AirParams::new(&scene.air.expect("air"), scene.ambient, scene.samples);
    (AirVolume::new(&view, &camera.view_from_world.inverse(), &lighting, &params), camera)
}

/// Rounding of 48 sums in 32 bits, and the offset of the columns' rays from the pixel's.
const ROUNDED: f64 = 2e-3;

/// Uniform light: `scattering (ambient + p E) (1 - exp(-extinction s)) / extinction`.
#[test]
fn even_light_scatters_as_in_the_closed_form() {
    let mut scene = sunny();
    scene.ambient = Vec3::new(0.1, 0.2, 0.3);
    let (volume, camera) = volume(&scene);
    let world_from_view = camera.view_from_world.inverse();
    let LightKind::Directional { direction } = scene.lights[0].kind else { unreachable!() };
    for pixel in [Vec2::new(2.0, 2.0), Vec2::new(34.0, 30.0), Vec2::new(58.0, 10.0)] {
        for depth in [1.0 / 48.0, 0.25, 0.5, 1.0] {
            let slope = (pixel - camera.size.as_vec2() * 0.5) / camera.scale;
            let way = Vec3::new(slope.x, -slope.y, -1.0);
            let ray = world_from_view.transform_vector3(way).normalize();
            let s = depth * (camera.far - camera.near) * way.length();
            let back = phase(direction.dot(-ray), AIR.anisotropy);
            let before = volume.at(pixel, depth);
            for i in 0..3 {
                let taken = f64::from(AIR.extinction[i]);
                let left = (-taken * f64::from(s)).exp();
                let way = if taken > 0.0 { (1.0 - left) / taken } else { f64::from(s) };
                let exact =
                    f64::from(AIR.scattering[i] * (0.5 * scene.ambient[i] + 2.0 * back)) * way;
                assert!((f64::from(before.light[i]) - exact).abs() < ROUNDED, "{before:?} {exact}");
                assert!((f64::from(before.left[i]) - left).abs() < ROUNDED, "{before:?} {left}");
            }
        }
    }
}

#[test]
fn the_phase_function_scatters_all_there_is() {
    for g in [-0.9, -0.3, 0.0, 0.4, 0.9] {
        const STEPS: i32 = 20_000;
        let width = 2.0 / f64::from(STEPS);
        let cosine = |i: i32| (f64::from(i) + 0.5) * width - 1.0;
        let of = |i: i32| f64::from(phase(cosine(i) as f32, g)) * width;
        let whole: f64 = (0..STEPS).map(of).sum::<f64>() * std::f64::consts::TAU;
        let mean: f64 = (0..STEPS).map(|i| of(i) * cosine(i)).sum::<f64>() * std::f64::consts::TAU;
        assert!((whole - 1.0).abs() < 1e-3, "{g}: {whole}");
        assert!((mean - f64::from(g)).abs() < 2e-3, "{g}: mean cosine {mean}");
    }
}

/// The air behind a pane has the pane's colour, the air in front of it the light's.
#[test]
fn air_behind_glass_is_coloured_and_before_it_is_not() {
    let tint = Vec3::new(0.9, 0.3, 0.1);
    let mut scene = empty(vec![
        Material { tint: tint.extend(1.0), ..Material::default() },
        Material { transfer: Transfer::Opaque, ..Material::default() },
    ]);
    scene.triangles = pane(0.5, 5.0, 0).to_vec();
    scene.triangles.extend(pane(1.0, 5.0, 1));
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Z })];
    scene.lights[0].near = Some(-20.0);
    scene.lights[0].far = Some(20.0);
    let views = shadow_views(&scene);
    let maps = reference::render_maps(&scene, &views).0;
    let seen = |scene: &Scene, z: f32| {
        let lighting = Lighting::new(scene, &views, &maps);
        lighting.scattered(0, Vec3::new(0.3, 0.2, z), Vec3::X, 0.0) * (4.0 * std::f32::consts::PI)
    };
    assert!((seen(&scene, -3.0) - Vec3::ONE).abs().max_element() < 1e-5);
    assert!((seen(&scene, -7.0) - tint).abs().max_element() < 2e-3);
    assert!(seen(&scene, -12.0).max_element() < 1e-6);
}

/// Light of a lamp without shadows that clear air scatters along a ray from `eye`, between distances `ends`
/// [m]: a march of 20,000 steps by the formulas, in 64 bits.
fn fine_march(lamp: &LightKind, eye: Vec3, ray: Vec3, ends: [f64; 2]) -> f64 {
    const STEPS: u32 = 20_000;
    let (position, cone) = match *lamp {
        LightKind::Spot { position, direction, angle } => (position, Some((direction, angle))),
        LightKind::Point { position } => (position, None),
        LightKind::Directional { .. } => unreachable!("a lamp"),
    };
    let [near, far] = ends;
    let step = (far - near) / f64::from(STEPS);
    let at = |i: u32| {
        let point = eye.as_dvec3() + ray.as_dvec3() * (near + (f64::from(i) + 0.5) * step);
        let away = point - position.as_dvec3();
        let toward = away.normalize();
        let share = cone.map_or(1.0, |(direction, angle)| {
            let [outer, inner] = [1.0, 0.85].map(|part| (f64::from(angle) * 0.5 * part).cos());
            let t = (toward.dot(direction.as_dvec3().normalize()) - outer) / (inner - outer);
            t.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * t.clamp(0.0, 1.0))
        });
        let g = f64::from(AIR.anisotropy);
        let spread = 1.0 + g * g + 2.0 * g * toward.dot(ray.as_dvec3());
        share * (1.0 - g * g) / spread.powf(1.5) / away.length_squared()
    };
    (0..STEPS).map(at).sum::<f64>() * step / (4.0 * std::f64::consts::PI)
}

/// Slices of a metre, and lamps whose beams are at first a tenth of that wide: no sample may miss them.
#[test]
fn beams_are_as_bright_as_a_fine_march() {
    let spot = |position: [f32; 3], direction: [f32; 3], degrees: f32| LightKind::Spot {
        position: position.into(),
        direction: Vec3::from(direction).normalize(),
        angle: degrees.to_radians(),
    };
    let mut scene = sunny();
    scene.lights[0].intensity = 1.0;
    let even = Vec3::ONE;
    scene.air = Some(Air { scattering: even, extinction: Vec3::ZERO, steps: 20, ..AIR });
    for lamp in [
        // Across the view, from its left border; towards the eye; with the eye in its cone; wide.
        spot([-2.2, 0.1, -6.0], [1.0, 0.02, -0.1], 16.0),
        spot([0.4, 0.3, -14.0], [0.05, -0.02, 1.0], 20.0),
        spot([0.6, 0.5, 0.5], [-0.1, -0.05, -1.0], 40.0),
        spot([-1.0, 0.5, -5.0], [0.3, -1.0, -0.4], 150.0),
        LightKind::Point { position: Vec3::new(0.3, 0.1, -6.3) },
    ] {
        scene.lights[0].kind = lamp;
        let (volume, camera) = volume(&scene);
        let world_from_view = camera.view_from_world.inverse();
        let pixels = (0..256).map(|i| Vec2::new((i % 16) as f32, (i / 16) as f32) * 4.0 + 2.0);
        let columns: Vec<[f64; 2]> = pixels
            .map(|pixel| {
                let slope = (pixel - camera.size.as_vec2() * 0.5) / camera.scale;
                let way = Vec3::new(slope.x, -slope.y, -1.0);
                let ray = world_from_view.transform_vector3(way).normalize();
                let ends = [camera.near, camera.far].map(|end| f64::from(end * way.length()));
                let exact = fine_march(&lamp, scene.camera.eye, ray, ends);
                [f64::from(volume.at(pixel, 1.0).light.x), exact]
            })
            .collect();
        let brightest = columns.iter().fold(0.0, |most: f64, of| most.max(of[1]));
        assert!(brightest > 0.0, "{lamp:?}");
        for (i, [light, exact]) in columns.iter().enumerate() {
            let error = (light - exact).abs();
            assert!(error < MARCHED * exact + 1e-3 * brightest, "{lamp:?} {i}: {light} {exact}");
        }
    }
}

/// Error of a beam's light: at least two samples in its cone, whose edge is soft.
const MARCHED: f64 = 0.04;

fn small(name: &str) -> Scene {
    let size = [("camera.size", "[160, 90]"), ("shadow.size", "256"), ("air.steps", "24")];
    let set = [&size[..], &[("camera.samples", "2")]].concat();
    let set: Vec<_> =
        set.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
    let path = format!("{}/data/{name}.toml", crate::common::root().display());
    scene::load_with(path.as_ref(), &set).unwrap()
}

fn shafts() -> Scene {
    small("shafts")
}

/// A sun, and lamps that shine through slides.
#[test]
fn beams_match_the_reference() {
    let mut scene = small("projector");
    let sun = LightKind::Directional { direction: Vec3::new(0.4, -1.0, -0.2).normalize() };
    scene.lights.push(light(sun));
    scene.lights[2].intensity = 0.2;
    let lamp = light(LightKind::Point { position: Vec3::new(0.5, 1.0, 0.4) });
    scene.lights.push(lamp);
    let expected = reference_picture(&scene);
    scene.lights[3].shafts = false;
    let without = reference_picture(&scene);
    scene.lights[3].shafts = true;
    for tier in TIERS {
        let picture = render(tier, &scene).picture;
        let apart = share_apart(&picture, &expected);
        assert!(apart <= GRAZED, "{tier:?}: {apart}");
        assert!(share_apart(&picture, &without) > GRAZED);
    }
}

fn share_apart(a: &Picture, b: &Picture) -> f64 {
    let channels = a.rgb.iter().flatten().zip(b.rgb.iter().flatten());
    let apart = channels.filter(|(a, b)| a.abs_diff(**b) > 4).count();
    apart as f64 / (3 * a.rgb.len()) as f64
}

/// Share of pixels that rounding may decide, where a ray grazes an edge.
const GRAZED: f64 = 3e-3;

/// Columns and slices of samples lie between each other's: the mean of four is closer to air with sixteen
/// times the columns and four times the slices than a single one.
#[test]
fn the_mean_of_samples_is_finer() {
    let mut scene = shafts();
    scene.samples = 4;
    let mut fine = scene.clone();
    fine.camera.size *= 4;
    fine.air.as_mut().expect("air").steps *= 4;
    let (truth, _) = volume(&fine);
    let volumes: Vec<_> =
        scene.sample_offsets().map(|offset| (volume_through(&scene, offset).0, offset)).collect();
    let one = [(volume(&scene).0, Vec2::ZERO)];
    // Pixels in the middle; the truth is the mean over the samples' positions in each.
    let error = |samples: &[(AirVolume, Vec2)]| {
        let pixels =
            (20..70).flat_map(|y| (20..140).map(move |x| Vec2::new(x as f32, y as f32) + 0.5));
        let of = |pixel: Vec2| {
            let apart = samples.iter().map(|(volume, offset)| {
                volume.at(pixel, 1.0).light - truth.at((pixel + *offset) * 4.0, 1.0).light
            });
            f64::from((apart.sum::<Vec3>() / samples.len() as f32).abs().max_element())
        };
        pixels.map(of).sum::<f64>()
    };
    let (single, mean) = (error(&one), error(&volumes));
    assert!(single > 0.0 && mean < 0.8 * single, "{mean} of {single}");
}

/// Panes, particles and additive fire in the air.
#[test]
fn pictures_match_the_reference() {
    let mut scene = shafts();
    scene.particles = crate::common::scenes::random_discs(60, 4);
    scene.materials.push(Material { name: "smoke".into(), ..Material::default() });
    let tint = Vec4::new(0.9, 0.5, 0.2, 0.3);
    scene.materials.push(Material { transfer: Transfer::None, tint, ..Material::default() });
    for (i, particle) in scene.particles.iter_mut().enumerate() {
        particle.material = (scene.materials.len() - 1 - i % 2) as u32;
        particle.center.y += 2.0;
    }
    scene.ambient = Vec3::new(0.1, 0.2, 0.3);
    scene.air = Some(Air { steps: 24, ..AIR });
    let expected = reference_picture(&scene);
    let mut clear = scene.clone();
    clear.air = None;
    for tier in tiers(Tier::Core) {
        let picture = render(tier, &scene).picture;
        let apart = share_apart(&picture, &expected);
        assert!(apart <= GRAZED, "{tier:?}: {apart}");
        assert!(share_apart(&render(tier, &clear).picture, &expected) > GRAZED);
    }
}

/// As the density goes to 0, the picture goes to that without air.
#[test]
fn thin_air_is_clear_air() {
    let mut scene = shafts();
    scene.air = None;
    let clear = reference_picture(&scene);
    let thin = Vec3::splat(1e-5);
    scene.air = Some(Air { scattering: thin, extinction: thin, steps: 24, ..AIR });
    assert_eq!(share_apart(&reference_picture(&scene), &clear), 0.0);
}

/// Air that scatters without extinction: pixels without lit air equal those of clear air to the last bit;
/// others only get brighter.
#[test]
fn shafts_need_no_veil() {
    let mut scene = shafts();
    let scattering = Vec3::splat(0.3);
    scene.air = Some(Air { scattering, extinction: Vec3::ZERO, ambient: 0.0, steps: 24, ..AIR });
    for tier in [None, Some(TIERS[1])] {
        let picture = |scene: &Scene| match tier {
            Some(tier) => render(tier, scene).picture.light,
            None => reference_picture(scene).light,
        };
        let clear = picture(&Scene { air: None, ..scene.clone() });
        let lit = picture(&scene);
        let mut dark = scene.clone();
        dark.lights.iter_mut().for_each(|light| light.shafts = false);
        assert!(picture(&dark) == clear, "{tier:?}");
        let channels = || lit.iter().flatten().zip(clear.iter().flatten());
        assert!(channels().all(|(lit, clear)| lit >= clear), "{tier:?}");
        let brighter = channels().filter(|(lit, clear)| **lit > **clear + 0.01).count();
        assert!(brighter > lit.len() / 10, "{tier:?}: {brighter}");
    }
}

#[test]
fn tables_of_air_say_both_or_derive_one_from_the_other() {
    let air = |keys: &str| read(&format!("[air]\n{keys}\n")).map(|scene| scene.air);
    let rgb = Vec3::new;
    for (keys, scattering, extinction) in [
        ("density = 0.5\nalbedo = [1, 0.5, 0]", rgb(0.5, 0.25, 0.0), Vec3::splat(0.5)),
        ("scattering = 0.3", Vec3::splat(0.3), Vec3::splat(0.3)),
        ("scattering = 0.3\nextinction = 0", Vec3::splat(0.3), Vec3::ZERO),
        ("scattering = [0, 0, 1]\nextinction = [1, 2, 3]", Vec3::Z, rgb(1.0, 2.0, 3.0)),
        ("extinction = 2\nalbedo = [1, 0.5, 0]", rgb(2.0, 1.0, 0.0), Vec3::splat(2.0)),
    ] {
        let air = air(keys).unwrap().expect(keys);
        assert_eq!((air.scattering, air.extinction), (scattering, extinction), "{keys}");
    }
    assert_eq!(air("density = 0").unwrap(), None);
    assert_eq!(air("scattering = [0, 0, 0]").unwrap(), None);
    for (keys, line) in [
        ("scattering = 1\ndensity = 1", 3),
        ("extinction = 1\ndensity = 1", 3),
        ("albedo = [1, 1, 1]\nscattering = 1", 2),
        ("scattering = -1", 2),
        ("extinction = [0, 2000, 0]", 2),
        ("scattering = [1, 2]", 2),
        ("scattering = \"much\"", 2),
        ("ambient = 2", 2),
    ] {
        let error = air(keys).unwrap_err().to_string();
        assert!(error.contains(&format!(":{line}:")), "{keys}: {error}");
    }
}
