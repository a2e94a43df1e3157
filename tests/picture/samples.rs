//! `camera.samples`: edges against the exact coverage of each pixel.
use crate::common::{
    TIERS, gpu,
    scenes::{empty, material, triangle},
};
use gobo::{
    Camera, Material, Transfer,
    glam::{UVec2, Vec3},
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

const SIZE: u32 = 32;
/// Shift of the edge to the right per metre up.
const SLANT: f64 = 0.37;

/// A scene that shines on the left of a slanted edge.
fn edge(samples: u32, emission: f32) -> Scene {
    let emission = Vec3::splat(emission);
    let mut scene = empty(vec![Material { emission, ..material(Transfer::Opaque) }]);
    scene.camera = Camera {
        eye: Vec3::Z * 5.0,
        target: Vec3::ZERO,
        up: Vec3::Y,
        fov_y: 0.4,
        size: UVec2::splat(SIZE),
    };
    let far = 40.0;
    let on_edge = |y: f32| Vec3::new(y * SLANT as f32, y, 0.0);
    let corners = [on_edge(-far), on_edge(far), Vec3::new(-2.0 * far, 0.0, 0.0)];
    scene.triangles = vec![triangle(corners, 0)];
    scene.samples = samples;
    scene
}

/// Share of a pixel that the edge covers.
fn covered(pixel: usize) -> f64 {
    const PLACES: usize = 64;
    let metre = f64::from(SIZE) * 0.5 / f64::from(0.2_f32.tan()) / 5.0;
    let (x, y) = (pixel % SIZE as usize, pixel / SIZE as usize);
    let place = |i: usize| (i as f64 + 0.5) / PLACES as f64;
    let middle = f64::from(SIZE) * 0.5;
    let is_left = |i: usize| {
        let right = (x as f64 + place(i % PLACES) - middle) / metre;
        let up = (middle - y as f64 - place(i / PLACES)) / metre;
        right < up * SLANT
    };
    (0..PLACES * PLACES).filter(|&i| is_left(i)).count() as f64 / (PLACES * PLACES) as f64
}

#[test]
fn edges_are_as_wide_as_they_cover() {
    let options = RenderOptions { light: true, ..RenderOptions::default() };
    let renderers = [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on_cpu()];
    let mut lights = Vec::new();
    for mut renderer in renderers {
        let mut error_of = |samples: u32| {
            let picture = renderer.render(&edge(samples, 1.0), &options).unwrap().picture;
            let apart = |(i, light): (usize, &[f32; 3])| (f64::from(light[0]) - covered(i)).abs();
            let error: f64 = picture.light.iter().enumerate().map(apart).sum();
            lights.push(picture.light);
            error / f64::from(SIZE)
        };
        // Per row of pixels.
        let [one, four, sixteen] = [1, 4, 16].map(&mut error_of);
        assert!(one > 0.2 && four < 0.5 * one && sixteen < 0.2 * one, "{one} {four} {sixteen}");
    }
    let is_hard = |light: &[f32; 3]| light[0] == 0.0 || light[0] == 1.0;
    assert!(lights[0].iter().all(is_hard));
    assert!(!lights[2].iter().all(is_hard));
    // The kernels agree with the CPU reference, up to rounding.
    for i in 0..3 {
        let pairs = lights[i].iter().zip(&lights[3 + i]);
        assert!(pairs.filter(|(a, b)| a != b).count() <= 2, "{i}");
    }
}

/// The edge of a surface far brighter than the screen is as wide as that of a dimmer one.
#[test]
fn edges_of_glare_are_as_wide_on_the_screen() {
    for mut renderer in [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on_cpu()] {
        let mut error_of = |samples: u32| {
            let scene = edge(samples, 40.0);
            let picture = renderer.render(&scene, &RenderOptions::default()).unwrap().picture;
            let linear = |byte: u8| {
                let v = f64::from(byte) / 255.0;
                if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
            };
            let white = picture.rgb.iter().map(|rgb| linear(rgb[0])).fold(0.0, f64::max);
            let apart = |(i, rgb): (usize, &[u8; 3])| (linear(rgb[0]) / white - covered(i)).abs();
            picture.rgb.iter().enumerate().map(apart).sum::<f64>() / f64::from(SIZE)
        };
        let [one, sixteen] = [1, 16].map(&mut error_of);
        assert!(one > 0.2 && sixteen < 0.2 * one, "{one} {sixteen}");
    }
}
