//! Environments: light and reflections against closed forms, kernels against the CPU reference.
use crate::common::{
    TIERS, Tier,
    files::{Folder, read},
    reference_picture, render,
    scenes::{empty, light, pane, particle},
    tiers,
};
use gobo::{
    glam::{DVec3, UVec2, Vec3, Vec4},
    model::{Environment, LightKind, Material, Sky, SunDisc, Transfer, irradiance_at},
    records::Picture,
};
use gobo_reference::shading::Lighting;
use gobo_scene as scene;
use gobo_scene::Scene;
use std::sync::Arc;

/// An environment of a radiance by direction, from an image of 256 x 128 texels.
fn around(radiance: impl Fn(DVec3) -> Vec3) -> Environment {
    let size = UVec2::new(256, 128);
    let texel = |i: u32| {
        let turn = (f64::from(i % size.x) + 0.5) / f64::from(size.x) * std::f64::consts::TAU;
        let down = (f64::from(i / size.x) + 0.5) / f64::from(size.y) * std::f64::consts::PI;
        // The middle column looks along -z, and the next to its right towards +x.
        let (sine, y) = (down.sin(), down.cos());
        radiance(DVec3::new(-sine * turn.sin(), y, sine * turn.cos())).to_array()
    };
    let texels: Vec<_> = (0..size.x * size.y).map(texel).collect();
    Environment::of_image(size, &texels, 0.0, 1.0)
}

fn within(environment: Environment) -> Scene {
    Scene { environment: Some(Arc::new(environment)), ..empty(Vec::new()) }
}

fn seen(scene: &Scene, direction: Vec3, roughness: f32) -> Vec3 {
    Lighting::new(scene, &[], &[]).radiance_around(direction.normalize(), roughness)
}

fn directions() -> impl Iterator<Item = Vec3> {
    (0..200).map(|i| {
        let y = (i as f32 + 0.5) / 100.0 - 1.0;
        let (sin, cos) = (i as f32 * 2.4).sin_cos();
        Vec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + Vec3::Y * y
    })
}

/// The cosine lobe scales spherical harmonics of order 0, 1 and 2 by `1`, `2/3` and `1/4`.
#[test]
fn diffuse_light_is_that_of_the_closed_form() {
    let environment = around(|d| {
        let linear = 1.0 + 0.5 * d.y - 0.2 * d.x + 0.1 * d.z;
        let of_second_order = d.x * d.z + 0.5 * d.x * d.y - d.y * d.z + (d.x * d.x - d.y * d.y);
        Vec3::new(linear as f32, (1.0 + 0.3 * of_second_order) as f32, (d.z * d.z) as f32)
    });
    for n in directions() {
        let mixed = n.x * n.z + 0.5 * n.x * n.y - n.y * n.z + (n.x * n.x - n.y * n.y);
        let exact = Vec3::new(
            1.0 + (0.5 * n.y - 0.2 * n.x + 0.1 * n.z) * 2.0 / 3.0,
            1.0 + 0.3 * mixed / 4.0,
            1.0 / 3.0 + (n.z * n.z - 1.0 / 3.0) / 4.0,
        );
        let found = irradiance_at(environment.irradiance(), n);
        assert!((found - exact).abs().max_element() < 2e-3, "{n}: {found} {exact}");
    }
    assert!((environment.mean() - Vec3::new(1.0, 1.0, 1.0 / 3.0)).abs().max_element() < 1e-3);
}

#[test]
fn images_look_where_they_say() {
    let scene = within(around(|d| d.as_vec3() * 0.5 + 0.5));
    for direction in directions() {
        let found = seen(&scene, direction, 0.0);
        assert!(
            (found - (direction * 0.5 + 0.5)).abs().max_element() < 0.01,
            "{direction} {found}"
        );
    }
    // Turned by a quarter, the centre of the image is on the left.
    let size = UVec2::new(8, 4);
    let mut texels = vec![[0.0; 3]; 32];
    for row in 0..4 {
        (texels[row * 8 + 3], texels[row * 8 + 4]) = ([1.0; 3], [1.0; 3]);
    }
    let turned = within(Environment::of_image(size, &texels, 90f32.to_radians(), 2.0));
    assert_eq!(seen(&turned, Vec3::NEG_X, 0.0), Vec3::splat(2.0));
    assert_eq!(seen(&turned, Vec3::NEG_Z, 0.0), Vec3::ZERO);
}

/// An image with a sun of 2 degrees around `toward`, of radiance 800, in an even sky.
fn with_sun(toward: DVec3) -> (UVec2, Vec<[f32; 3]>) {
    const PLACES: u32 = 8;
    let size = UVec2::new(256, 128);
    let texel = |i: u32| {
        let shines = |place: u32| {
            let at = UVec2::new(place % PLACES, place / PLACES).as_dvec2() + 0.5;
            let at = UVec2::new(i % size.x, i / size.x).as_dvec2() + at / f64::from(PLACES);
            let turn = at.x / f64::from(size.x) * std::f64::consts::TAU;
            let down = at.y / f64::from(size.y) * std::f64::consts::PI;
            let (sine, y) = (down.sin(), down.cos());
            let d = DVec3::new(-sine * turn.sin(), y, sine * turn.cos());
            d.dot(toward) > 1f64.to_radians().cos()
        };
        let share = (0..PLACES * PLACES).filter(|&place| shines(place)).count() as f32;
        let share = share / (PLACES * PLACES) as f32;
        [0.3 + 800.0 * share, 0.5 + 720.0 * share, 0.9 + 600.0 * share]
    };
    (size, (0..size.x * size.y).map(texel).collect())
}

#[test]
fn an_image_gives_its_sun_as_a_light() {
    let toward = DVec3::new(0.6, 0.5, -0.4).normalize();
    let (size, texels) = with_sun(toward);
    let (environment, sun) = Environment::of_image_without_sun(size, &texels, 0.0, 2.0);
    let sun = sun.expect("a sun");
    assert!(sun.direction.as_dvec3().dot(-toward) > 0.5f64.to_radians().cos());
    // Irradiance of a disc with half angle `a` and radiance L: pi L sin(a)^2.
    let full = std::f32::consts::PI * 2.0 * 1f32.to_radians().sin().powi(2);
    let exact = Vec3::new(800.0, 720.0, 600.0) * full;
    assert!(((sun.irradiance - exact) / exact).abs().max_element() < 0.1, "{sun:?} {exact}");
    let degrees = sun.angle.to_degrees();
    assert!(degrees > 1.9 && degrees < 5.0, "{degrees}");
    let sky = Vec3::new(0.6, 1.0, 1.8);
    for n in directions() {
        let found = irradiance_at(environment.irradiance(), n);
        assert!((found - sky).abs().max_element() < 0.02, "{n}: {found}");
    }
    // It is still visible, unchanged.
    let scene = within(environment);
    assert!(seen(&scene, toward.as_vec3(), 0.0).x > 200.0);
    let rough = seen(&scene, toward.as_vec3(), 0.6);
    assert!((rough - sky).abs().max_element() < 0.02, "{rough}");
    // Clouds have no sun, however uneven they are.
    let cloudy: Vec<[f32; 3]> = (0..size.x * size.y).map(|i| [0.2 + (i % 7) as f32; 3]).collect();
    assert_eq!(Environment::of_image_without_sun(size, &cloudy, 0.0, 1.0).1, None);
}

#[test]
fn the_sun_of_an_image_takes_the_place_of_the_default_one() {
    let folder = Folder::new();
    let (size, texels) = with_sun(DVec3::new(0.0, 0.8, 0.6));
    let mut bytes = Vec::new();
    let pixels: Vec<_> = texels.into_iter().map(image::Rgb).collect();
    let encoder = image::codecs::hdr::HdrEncoder::new(&mut bytes);
    encoder.encode(&pixels, size.x as usize, size.y as usize).unwrap();
    folder.write("day.hdr", bytes);
    let sky = "[environment]\nfile = 'day.hdr'\n";
    let scene = scene::load(&folder.write("a.toml", sky)).unwrap();
    let [sun] = &scene.lights[..] else { panic!("one light") };
    let LightKind::Directional { direction } = sun.kind else { panic!("a sun") };
    assert!((direction - Vec3::new(0.0, -0.8, -0.6)).length() < 0.02, "{direction}");
    assert!(sun.source.is_some() && sun.color.max_element() == 1.0);
    // A scene with lights keeps them, and the image is all around.
    let lamp = "[[light]]\nkind = 'point'\nposition = [0, 1, 0]\n";
    let lit = scene::load(&folder.write("b.toml", format!("{sky}{lamp}"))).unwrap();
    assert_eq!(lit.lights.len(), 1);
    assert!(lit.mean_ambient().x > 1.05 * scene.mean_ambient().x);
}

/// Reflection by half vectors of GGX (Walter et al. 2007) about `n`, weighted as in Karis 2013: `n` is
/// `height` above the border between black below and white above.
fn mirrored_of_halves(height: f64, roughness: f64) -> f64 {
    const STEPS: u32 = 600;
    let square = roughness.powi(4);
    let n = DVec3::new((1.0 - height * height).sqrt(), height, 0.0);
    let (x, y) = n.any_orthonormal_pair();
    let (mut light, mut all) = (0.0, 0.0);
    for i in 0..STEPS {
        let u = (f64::from(i) + 0.5) / f64::from(STEPS);
        let cosine = ((1.0 - u) / (1.0 + (square - 1.0) * u)).sqrt();
        let sine = (1.0 - cosine * cosine).sqrt();
        for j in 0..STEPS {
            let (sin, cos) = (f64::from(j) / f64::from(STEPS) * std::f64::consts::TAU).sin_cos();
            let middle = (x * cos + y * sin) * sine + n * cosine;
            let ray = middle * (2.0 * cosine) - n;
            let weight = ray.dot(n).max(0.0);
            all += weight;
            light += if ray.y > 0.0 { weight } else { 0.0 };
        }
    }
    light / all
}

#[test]
fn roughness_blurs_as_ggx_does() {
    let scene = within(around(|d| Vec3::splat(if d.y > 0.0 { 1.0 } else { 0.0 })));
    for (roughness, height) in [(0.4, 0.1), (0.4, -0.2), (0.6, 0.3), (0.8, -0.3), (1.0, 0.5)] {
        let exact = mirrored_of_halves(height, roughness);
        for turn in [0.3f32, 2.0, 4.4] {
            let flat = (1.0 - height * height).sqrt() as f32;
            let n = Vec3::new(flat * turn.cos(), height as f32, flat * turn.sin());
            let found = f64::from(seen(&scene, n, roughness as f32).x);
            assert!((found - exact).abs() < 0.04, "{roughness} {height}: {found} {exact}");
        }
    }
    assert_eq!(seen(&scene, Vec3::new(1.0, 0.2, 0.0), 0.0), Vec3::ONE);
}

/// A white metal in uniform light is invisible at any roughness.
#[test]
fn metal_in_even_light_is_invisible() {
    let mut scene = within(around(|_| Vec3::new(0.5, 0.25, 1.0)));
    let metal = Material { transfer: Transfer::Opaque, metallic: 1.0, ..Material::default() };
    let rough = |roughness| Material { roughness, ..metal.clone() };
    scene.materials = vec![rough(0.0), rough(0.5), rough(1.0)];
    scene.camera.eye = Vec3::new(0.0, 0.0, 4.0);
    for i in 0..3 {
        let ball = particle(Vec3::new(i as f32 - 1.0, 0.0, 0.0), 0.4, Vec4::ONE);
        scene.particles.push(gobo::model::Particle { material: i, ..ball });
    }
    scene.triangles = pane(0.1, 2.0, 1).to_vec();
    let mut dark = scene.clone();
    dark.materials.iter_mut().for_each(|material| material.tint *= 0.5);
    for picture in [reference_picture(&scene), render(TIERS[0], &scene).picture] {
        for light in &picture.light {
            let off = (Vec3::from_array(*light) - Vec3::new(0.5, 0.25, 1.0)).abs().max_element();
            assert!(off < 2e-3, "{light:?}");
        }
    }
    assert!(reference_picture(&dark).light.iter().any(|light| light[1] < 0.2), "nothing is seen");
}

fn share_apart(a: &Picture, b: &Picture) -> f64 {
    let channels = a.rgb.iter().flatten().zip(b.rgb.iter().flatten());
    let apart = channels.filter(|(a, b)| a.abs_diff(**b) > 4).count();
    apart as f64 / (3 * a.rgb.len()) as f64
}

/// Share of pixels that rounding may decide, where a ray grazes an edge, or the sun's.
const GRAZED: f64 = 3e-3;

/// Metallic and rough objects, particles and panes of several roughnesses under a sky with a sun.
fn stage() -> Scene {
    let sun =
        SunDisc { direction: Vec3::new(0.3, -0.5, -1.0), color: Vec3::splat(9.0), angle: 0.1 };
    let sky = Sky { sun: Some(sun), ..Sky::default() };
    let mut scene = within(Environment::of_sky(&sky, 1.5));
    let opaque = Material { transfer: Transfer::Opaque, ..Material::default() };
    let gold = Material { tint: Vec4::new(0.9, 0.6, 0.2, 1.0), metallic: 1.0, ..opaque.clone() };
    let glass = Material { transmission: 1.0, roughness: 0.0, ..Material::default() };
    scene.materials = vec![
        opaque.clone(),
        Material { roughness: 0.05, ..gold.clone() },
        Material { roughness: 0.5, metallic: 0.7, ..gold },
        Material { reflectivity: 0.3, ..glass.clone() },
        Material { roughness: 0.7, tint: Vec4::new(0.9, 0.2, 0.2, 1.0), ..glass },
        Material { name: "smoke".into(), ..Material::default() },
    ];
    scene.camera.size = UVec2::new(150, 101);
    scene.camera.eye = Vec3::new(0.5, 0.4, 5.0);
    scene.triangles = pane(0.3, 3.0, 0).to_vec();
    for (x, material) in [(-1.0, 3), (1.0, 4)] {
        let mut glass = pane(-0.1, 0.7, material);
        glass.iter_mut().flat_map(|t| &mut t.positions).for_each(|p| p.x += x);
        scene.triangles.extend(glass);
    }
    for (i, x) in [-1.2f32, 0.0, 1.2].into_iter().enumerate() {
        let material = [1, 2, 0][i];
        let ball = particle(Vec3::new(x, -0.2, 0.0), 0.5, Vec4::ONE);
        scene.particles.push(gobo::model::Particle { material, ..ball });
        let smoke = particle(Vec3::new(x, 0.8, 0.5), 0.5, Vec4::new(0.9, 0.9, 1.0, 0.4));
        scene.particles.push(gobo::model::Particle { material: 5, ..smoke });
    }
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.6) })];
    scene
}

#[test]
fn pictures_match_the_reference() {
    let scene = stage();
    let expected = reference_picture(&scene);
    for tier in TIERS {
        let apart = share_apart(&render(tier, &scene).picture, &expected);
        assert!(apart <= GRAZED, "{tier:?}: {apart}");
    }
    // With surroundings of two colours, metal mirrors them.
    let plain = Scene { environment: None, background: Vec3::splat(0.4), ..scene.clone() };
    let mut dull = plain.clone();
    dull.materials.iter_mut().for_each(|material| material.metallic = 0.0);
    let expected_plain = reference_picture(&plain);
    for tier in tiers(Tier::Core) {
        let picture = render(tier, &plain).picture;
        assert!(share_apart(&picture, &expected_plain) <= GRAZED, "{tier:?}");
        assert!(share_apart(&render(tier, &dull).picture, &expected_plain) > GRAZED);
        assert!(share_apart(&picture, &expected) > GRAZED);
    }
}

/// Nothing but the background, up, down and aside.
#[test]
fn the_background_is_the_same_all_around() {
    let background = Vec3::new(0.5, 0.25, 1.0);
    let mut scene = Scene { environment: None, background, ..stage() };
    (scene.camera.fov_y, scene.camera.eye) = (2.4, Vec3::new(0.0, 0.0, -90.0));
    scene.camera.target = scene.camera.eye + Vec3::NEG_Z;
    let mut pictures = vec![reference_picture(&scene)];
    pictures.extend(tiers(Tier::Native).into_iter().map(|tier| render(tier, &scene).picture));
    for light in pictures.iter().flat_map(|picture| &picture.light) {
        assert_eq!(Vec3::from(*light), background);
    }
}

/// The sun's power follows from its angle, even if it is smaller than a texel or two.
#[test]
fn the_sun_is_as_bright_as_it_is_large() {
    let dark = Sky { zenith: Vec3::ZERO, horizon: Vec3::ZERO, ground: Vec3::ZERO, sun: None };
    for angle in [0.01f32, 0.05, 0.4] {
        for direction in [Vec3::new(0.2, -1.0, 0.4), Vec3::new(0.0, -0.1, 1.0), Vec3::NEG_Y] {
            let sun = SunDisc { direction, color: Vec3::splat(10.0), angle };
            let scene = within(Environment::of_sky(&Sky { sun: Some(sun), ..dark }, 1.0));
            let toward = -direction.normalize();
            let (x, y) = toward.any_orthonormal_pair();
            const STEPS: i32 = 200;
            let reach = angle + 0.06;
            let step = 2.0 * reach / STEPS as f32;
            let mut sum = 0.0;
            for i in 0..STEPS * STEPS {
                let u = ((i % STEPS) as f32 + 0.5) * step - reach;
                let v = ((i / STEPS) as f32 + 0.5) * step - reach;
                let way = toward + x * u + y * v;
                sum += seen(&scene, way, 0.0).x * step * step / way.length().powi(3);
            }
            let exact = 10.0 * std::f32::consts::TAU * (1.0 - (0.5 * angle).cos());
            assert!((sum / exact - 1.0).abs() < 0.06, "{angle} {direction}: {sum} {exact}");
            assert_eq!(scene.environment.unwrap().mean(), Vec3::ZERO);
        }
    }
}

#[test]
fn tables_say_two_colours_a_sky_or_an_image() {
    let environment = |keys: &str| read(&format!("[environment]\n{keys}\n"));
    let two = environment("ambient = [1, 2, 3]\nbackground = [3, 2, 1]").unwrap();
    assert!(two.environment.is_none());
    assert_eq!(
        (two.mean_ambient(), two.background),
        (Vec3::new(1.0, 2.0, 3.0), Vec3::new(3.0, 2.0, 1.0))
    );
    let sky =
        environment("zenith = [0, 0, 1]\nhorizon = [0, 1, 0]\nground = [1, 0, 0]\nintensity = 2");
    let sky = sky.unwrap();
    assert!((seen(&sky, Vec3::Y, 0.0) - Vec3::Z * 2.0).abs().max_element() < 0.05);
    assert_eq!(seen(&sky, Vec3::NEG_Y, 0.0), Vec3::X * 2.0);
    for (keys, line, word) in [
        ("zenith = [0, -1, 0]", 2, "zenith"),
        ("intensity = -1", 2, "intensity"),
        ("zenith = [0, 0, 0]\nambient = [0, 0, 0]", 3, "ambient"),
        ("file = 'x.hdr'\nbackground = [0, 0, 0]", 3, "background"),
        ("file = 'x.hdr'\nground = [0, 0, 0]", 3, "ground"),
        ("file = 'x.hdr'", 2, "x.hdr"),
        ("rotation = 3", 2, "rotation"),
        ("sun = { color = [1, 1, 1] }", 2, "direction"),
        ("sun = { direction = [0, 0, 0] }", 2, "direction"),
        ("sun = { direction = [0, -1, 0], angle = 90 }", 2, "angle"),
        ("sun = 3", 2, "sun"),
    ] {
        let error = environment(keys).unwrap_err().to_string();
        assert!(error.contains(&format!(":{line}:")) && error.contains(word), "{keys}: {error}");
    }
}

#[test]
fn radiance_files_are_read_and_damaged_ones_refused() {
    let texels = vec![image::Rgb([2.0f32, 0.5, 8.0]); 64 * 32];
    let mut bytes = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut bytes).encode(&texels, 64, 32).unwrap();
    let folder = Folder::new();
    folder.write("room.hdr", &bytes);
    folder.write("cut.hdr", &bytes[..bytes.len() / 2]);
    folder.write("text.hdr", "nothing");
    folder.write("large.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n");
    let load = |name: &str| {
        let toml = format!("[environment]\nfile = '{name}.hdr'\nintensity = 0.5\n");
        scene::load(&folder.write("scene.toml", toml))
    };
    let room = load("room").unwrap();
    assert!((seen(&room, Vec3::X, 0.0) - Vec3::new(1.0, 0.25, 4.0)).abs().max_element() < 0.05);
    for name in ["cut", "text", "large"] {
        let error = load(name).unwrap_err().to_string();
        assert!(error.contains(&format!("{name}.hdr")), "{error}");
    }
}

/// Single files have a sky, unless two colours are given.
#[test]
fn files_alone_have_a_sky() {
    let folder = Folder::new();
    let path = folder.write("dots.csv", "x,y,z\n0,0,0\n1,1,1\n");
    assert!(scene::load(&path).unwrap().environment.is_some());
    let set = [("environment.ambient".to_owned(), "[0, 0, 0]".to_owned())];
    assert!(scene::load_with(&path, &set).unwrap().environment.is_none());
    assert!(read("[camera]\n").unwrap().environment.is_none());
}
