//! Textured shadows: a projector's slide and caustics under water, against closed forms.
use crate::common::{
    TIERS, Tier, brute_force,
    compare::{Tolerance, assert_maps_agree, compare_maps},
    gpu, map_frame,
    scenes::{empty, light, material, pane},
    tiers,
};
use gobo::{
    Error,
    glam::{DVec2, Vec2, Vec3, Vec4},
    model::{LightKind, Material, Texture, Transfer},
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_reference as reference;
use gobo_scene as scene;
use gobo_scene::Scene;

/// 16 bits of light up to 4, and a texture whose edges are as wide as a texel of the map.
const TOLERANCE: Tolerance = Tolerance { filter: 8e-3, depth: 1e-5, undecided: 0.05 };

/// `size` of a map [texels].
fn small(name: &str, size: &str) -> Scene {
    let mut set =
        vec![("camera.size", "[64, 36]"), ("shadow.size", size), ("shadow.detail", "false")];
    if name == "projector" {
        // Its slide has edges finer than a texel of a small map.
        let checks = r#"{ generate = "checks", cells = 8, size = 256 }"#;
        set.extend([("light.projector.size", size), ("material.slide.texture", checks)]);
    }
    let set: Vec<_> =
        set.into_iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
    let path = format!("{}/data/{name}.toml", crate::common::root().display());
    scene::load_with(path.as_ref(), &set).unwrap()
}

/// Seventeen small images, one of them wide and one high, would take 4.2 GiB as layers.
#[test]
fn images_that_are_small_but_not_together_are_refused() {
    let texture = |width: u32, height: u32| Texture {
        name: String::new(),
        width,
        height,
        rgba: vec![255; (width * height * 4) as usize],
    };
    let mut scene = empty(vec![material(Transfer::Filter)]);
    scene.lights = vec![light(LightKind::Directional { direction: Vec3::NEG_Y })];
    scene.textures = vec![texture(1, 1); 15];
    scene.textures.extend([texture(8192, 1), texture(1, 8192)]);
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let error = renderer.render(&scene, &RenderOptions::default()).unwrap_err();
    assert!(matches!(error, Error::Limit { need: 1_140_850_688, .. }), "{error}");
    assert!(error.to_string().contains("alike in size"), "{error}");
    scene.textures.truncate(15);
    assert!(renderer.render(&scene, &RenderOptions::default()).is_ok());
}

/// Every texel of the map has the texture's colour where its ray meets the pane.
#[test]
fn maps_are_the_textures_where_rays_meet_them() {
    for (name, size) in [("projector", "128"), ("caustics", "64")] {
        let scene = small(name, size);
        let views = shadow_views(&scene);
        let cpu = reference::render_maps(&scene, &views).0;
        let gpu = TIERS.map(|tier| map_frame(tier, &scene).maps);
        for (i, view) in views.iter().enumerate() {
            let expected = brute_force::render(&scene, view);
            assert_maps_agree(&expected, &cpu[i], TOLERANCE);
            for maps in &gpu {
                assert_maps_agree(&expected, &maps[i], TOLERANCE);
            }
            // The check can fail; 64-bit rays are tried once.
            if i > 0 {
                continue;
            }
            let mut turned = scene.clone();
            for face in &mut turned.triangles {
                face.uvs = face.uvs.map(|uv| Vec2::new(uv.y, uv.x));
            }
            let expected = brute_force::render(&turned, view);
            assert!(compare_maps(&expected, &cpu[i], TOLERANCE).is_err(), "{name}");
        }
    }
}

/// A lamp 1 m in front of a pane of 1 m, four checks wide: the centre of each check's image has its colour,
/// at any distance of the wall.
#[test]
fn a_projector_throws_its_slide() {
    let colors: [[u8; 4]; 4] =
        [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];
    let mut scene = empty(vec![Material { texture: Some(0), ..Material::default() }]);
    // 2x2 checks of 4x4 texels each.
    let texel = |i: usize| colors[i % 8 / 4 + i / 8 / 4 * 2];
    scene.textures = vec![Texture {
        name: "checks".into(),
        width: 8,
        height: 8,
        rgba: (0..64).flat_map(texel).collect(),
    }];
    scene.triangles = pane(0.1, 0.5, 0).to_vec();
    let corners = [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::X, Vec2::ZERO];
    scene.triangles[0].uvs = [corners[0], corners[1], corners[2]];
    scene.triangles[1].uvs = [corners[0], corners[2], corners[3]];
    let angle = 2.0 * 0.6_f32.atan();
    let position = Vec3::ZERO;
    scene.lights = vec![light(LightKind::Spot { position, direction: Vec3::NEG_Z, angle })];
    (scene.lights[0].near, scene.lights[0].far) = (Some(0.1), Some(5.0));
    let views = shadow_views(&scene);
    let size = views[0].size.as_dvec2();
    for tier in tiers(Tier::Core) {
        let maps = map_frame(tier, &scene).maps.remove(0);
        for (i, color) in colors.iter().enumerate() {
            // Middle of the check on the pane [m] to the map.
            let on_pane = DVec2::new((i % 2) as f64 * 0.5 - 0.25, (i / 2) as f64 * 0.5 - 0.25);
            let at = (size * 0.5 + on_pane / 0.6 * size * 0.5).as_uvec2();
            let filter = maps.filter[(at.y * maps.view.size.x + at.x) as usize];
            let exact = [0, 1, 2].map(|c| f32::from(color[c]) / 255.0);
            assert!(filter.iter().zip(exact).all(|(f, e)| (f - e).abs() < 2e-3), "{i} {filter:?}");
        }
    }
}

/// Water focuses light: brighter lines, darker cells, and about the same sum.
#[test]
fn caustics_move_light_and_keep_it() {
    let mut scene = small("caustics", "96");
    let water = scene.materials.iter().position(|m| m.transfer == Transfer::Gain).expect("water");
    scene.materials[water].tint = Vec4::new(4.0, 4.0, 4.0, 0.25);
    for tier in tiers(Tier::Core) {
        let maps = map_frame(tier, &scene).maps.remove(0);
        let under: Vec<f32> = (0..maps.filter.len())
            .filter(|&i| maps.nearest[i] < 1.0)
            .map(|i| maps.filter[i][0])
            .collect();
        assert!(under.len() > 300);
        let mean = under.iter().sum::<f32>() / under.len() as f32;
        let most = under.iter().copied().fold(0.0, f32::max);
        let least = under.iter().copied().fold(f32::MAX, f32::min);
        assert!((mean - 1.0).abs() < 0.08, "{tier:?}: {mean}");
        assert!(most > 2.0 && least < 0.6, "{tier:?}: {least} to {most}");
    }
}
