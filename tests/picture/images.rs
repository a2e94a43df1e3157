//! Images smaller than a pixel: pictures show their means, and kernels agree with the CPU reference. Vertex
//! colours, in pictures and maps.
use crate::common::{
    TIERS, gpu, map_frame, reference_picture,
    scenes::{empty, light as lamp, material, triangle},
};
use gobo::{
    Camera, Material, Transfer,
    glam::{UVec2, Vec2, Vec3, Vec4},
    model::{LightKind, Texture, Triangle, VertexColor},
    view::shadow_views,
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_reference::render_maps;
use gobo_scene::Scene;

const SIZE: u32 = 48;

/// A chart of alternating white and transparent black texels; `alpha`: of the black ones.
fn chart(edge: u32, alpha: u8) -> Texture {
    let texel = |i: u32| {
        let is_white = (i % edge + i / edge).is_multiple_of(2);
        if is_white { [255; 4] } else { [0, 0, 0, alpha] }
    };
    let rgba = (0..edge * edge).flat_map(texel).collect();
    Texture { name: "chart".to_owned(), width: edge, height: edge, rgba }
}

/// A square of 6 m in the dark that fills the middle of the picture, also from the side; the chart repeats
/// `times` times per 2 m; seen from `eye`.
fn scene(of: Material, alpha: u8, times: f32, eye: Vec3) -> Scene {
    let mut scene = empty(vec![of]);
    scene.textures = vec![chart(64, alpha)];
    scene.camera =
        Camera { eye, target: Vec3::ZERO, up: Vec3::Y, fov_y: 0.5, size: UVec2::splat(SIZE) };
    (scene.ambient, scene.background) = (Vec3::ZERO, Vec3::ZERO);
    scene.lights.clear();
    let corner = |x: f32, y: f32| (Vec3::new(x, y, 0.0), Vec2::new(x, y) * 0.5 * times);
    let (a, b, c, d) = (corner(-3.0, -3.0), corner(3.0, -3.0), corner(3.0, 3.0), corner(-3.0, 3.0));
    scene.triangles = [[a, b, c], [a, c, d]]
        .map(|corners| Triangle {
            uvs: corners.map(|(_, uv)| uv),
            ..triangle(corners.map(|(position, _)| position), 0)
        })
        .to_vec();
    scene
}

/// A material that shines by its chart alone.
fn shining(transfer: Transfer) -> Material {
    let (emission, texture) = (Vec3::ONE, Some(0));
    Material { emission, texture, emissive_texture: Some(0), ..material(transfer) }
}

/// Linear light of the kernels, which is that of the CPU reference.
fn light(scene: &Scene) -> Vec<f32> {
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    let expected = reference_picture(scene).light;
    for tier in TIERS {
        let picture = Renderer::on(gpu(tier)).unwrap().render(scene, &options).unwrap().picture;
        let pairs = picture.light.iter().flatten().zip(expected.iter().flatten());
        let off = pairs.filter(|(a, b)| a.is_nan() || (*a - *b).abs() > 4e-3).count();
        assert!(off <= 6, "{tier:?}: {off} of {} channels", 3 * expected.len());
    }
    expected.iter().map(|rgb| rgb[0]).collect()
}

fn middle(light: &[f32]) -> impl Iterator<Item = f32> + '_ {
    let inner = SIZE / 4..SIZE - SIZE / 4;
    inner.clone().flat_map(move |y| inner.clone().map(move |x| light[(y * SIZE + x) as usize]))
}

fn assert_even(light: &[f32], mean: f32, apart: f32) {
    for value in middle(light) {
        assert!((value - mean).abs() < apart, "{value}, not {mean}");
    }
}

#[test]
fn small_texels_are_their_mean() {
    // Twenty texels per pixel, head-on and from the side.
    for eye in [Vec3::Z * 8.0, Vec3::new(5.0, 4.0, 4.0)] {
        assert_even(&light(&scene(shining(Transfer::Opaque), 255, 8.0, eye)), 0.5, 0.02);
    }
    // With a few texels per pixel, the samples together find the mean.
    let mut many = scene(shining(Transfer::Opaque), 255, 1.0, Vec3::Z * 8.0);
    many.samples = 4;
    assert_even(&light(&many), 0.5, 0.1);
}

#[test]
fn large_texels_are_as_sharp_as_they_are() {
    let near = scene(shining(Transfer::Opaque), 255, 0.05, Vec3::Z * 4.0);
    let light = light(&near);
    // Light is bilinear between the texels' middles, and a pixel is a fifteenth of a texel.
    assert!(middle(&light).any(|v| v > 0.93) && middle(&light).any(|v| v < 0.07));
}

/// Panes filter by the mean of their opacity, and cutouts cover the share of their texels.
#[test]
fn small_holes_let_their_share_pass() {
    let behind = |of: Material| {
        let mut scene = scene(of, 0, 8.0, Vec3::Z * 8.0);
        let wall = Material { emission: Vec3::ONE, ..material(Transfer::Opaque) };
        scene.materials.push(wall);
        let wall = scene.triangles.iter().map(|t| Triangle {
            positions: t.positions.map(|p| p * 2.0 - Vec3::Z),
            material: 1,
            ..*t
        });
        let wall: Vec<_> = wall.collect();
        scene.triangles.extend(wall);
        scene
    };
    let dark = |transfer| Material {
        tint: Vec4::new(0.0, 0.0, 0.0, 1.0),
        texture: Some(0),
        transmission: 1.0,
        roughness: 1.0,
        ..material(transfer)
    };
    // Schlick's reflectance of the pane's two faces is subtracted from the transmitted light.
    assert_even(&light(&behind(dark(Transfer::Filter))), 0.49, 0.03);
    let mut leaves = behind(dark(Transfer::Cutout));
    for samples in [4, 16] {
        leaves.samples = samples;
        assert_even(&light(&leaves), 0.5, 0.13);
    }
}

/// Vertex colours multiply the tint and are interpolated linearly: in the picture, and in filters of light.
#[test]
fn colours_of_corners_multiply() {
    let tint = Vec4::new(0.5, 1.0, 1.0, 1.0);
    let mut scene = scene(Material { tint, ..material(Transfer::Opaque) }, 255, 1.0, Vec3::Z * 8.0);
    let colors = [Vec4::new(1.0, 0.0, 0.0, 1.0), Vec4::new(0.0, 1.0, 0.0, 1.0), Vec4::ONE];
    for triangle in &mut scene.triangles {
        // All of it is visible.
        triangle.positions = triangle.positions.map(|position| position / 3.0);
        triangle.colors = colors.map(VertexColor::new);
    }
    scene.ambient = Vec3::ONE;
    // The first corner is the lower left one, the second the lower right one of the lower half.
    let expected = |pixel: usize| {
        let metre = SIZE as f32 * 0.5 / 0.25f32.tan() / 8.0;
        let x = ((pixel as u32 % SIZE) as f32 + 0.5 - SIZE as f32 * 0.5) / metre;
        let y = (SIZE as f32 * 0.5 - (pixel as u32 / SIZE) as f32 - 0.5) / metre;
        let third = (y + 1.0) * 0.5;
        let second = (x + 1.0) * 0.5 - third;
        let color = colors[0] * (1.0 - second - third) + colors[1] * second + colors[2] * third;
        (second > 0.02 && second + third < 0.98 && third > 0.02)
            .then_some((color * tint).truncate())
    };
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    let mut pictures = vec![reference_picture(&scene)];
    for tier in TIERS {
        let picture = Renderer::on(gpu(tier)).unwrap().render(&scene, &options).unwrap().picture;
        pictures.push(picture);
    }
    for picture in pictures {
        let whole = picture.light.iter().map(|rgb| rgb[1]).fold(0.0, f32::max);
        let mut seen = 0;
        for (i, light) in picture.light.iter().enumerate() {
            let Some(expected) = expected(i) else { continue };
            seen += 1;
            // A surface that faces the side has less ambient light than one that faces up.
            let found = Vec3::from_array(*light) / whole;
            assert!((found - expected).abs().max_element() < 0.03, "{i}: {found}, not {expected}");
        }
        assert!(seen > 200, "{seen}");
    }
    scene.materials[0] = Material { tint, ..material(Transfer::Filter) };
    scene.lights = vec![lamp(LightKind::Directional { direction: Vec3::NEG_Z })];
    scene.shadow.size = 64;
    let (twin, _) = render_maps(&scene, &shadow_views(&scene));
    for tier in TIERS {
        let maps = map_frame(tier, &scene).maps;
        let (mut red, mut green) = (0, 0);
        for (found, expected) in maps[0].filter.iter().zip(&twin[0].filter) {
            let [found, expected] = [*found, *expected].map(Vec3::from_array);
            assert!((found - expected).abs().max_element() < 2e-3, "{found} {expected}");
            red += u32::from(found.x > 0.4 && found.y < 0.1);
            green += u32::from(found.y > 0.9 && found.x < 0.1);
        }
        assert!(red > 0 && green > 0, "{tier:?}");
    }
}
