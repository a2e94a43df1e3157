//! Lit slices of the air: none behind everything visible in a pixel, by counts.
use super::air::AIR;
use crate::common::{
    TIERS, gpu, renderer,
    scenes::{empty, light, pane},
    shadows,
};
use gobo::{
    LightKind, Transfer,
    glam::{UVec2, Vec2, Vec3},
    gpu::Timeline,
    model::{Air, Material, View},
};
use gobo_picture::picture::{PictureCapacity, PictureRequest, PreparedPicture};
use gobo_scene::Scene;

/// Pixels per column.
const CELL: u32 = 4;

/// A wall that hides two thirds of the sky, in a picture of two bands whose last columns are cut off.
fn walled() -> Scene {
    let mut scene = empty(vec![Material { transfer: Transfer::Opaque, ..Material::default() }]);
    scene.triangles = pane(0.3, 2.6, 0).to_vec();
    scene.triangles.extend(pane(2.0, 1.0, 0));
    scene.camera.size = UVec2::new(326, 274);
    scene.camera.eye = Vec3::new(0.5, 0.2, 4.0);
    scene.camera.target = Vec3::new(0.9, 0.1, 0.0);
    scene.lights =
        vec![light(LightKind::Directional { direction: Vec3::new(0.3, -1.0, -0.2).normalize() })];
    scene.samples = 1;
    scene.air = Some(Air { steps: 30, ..AIR });
    scene
}

/// Slices that each column needs, up to a surface, and up to a face in the same plane: by the depths of the
/// pixels between its neighbours.
fn needed(depths: &[f32], size: UVec2, offset: Vec2, steps: u32) -> Vec<[u16; 2]> {
    let columns = size.map(|pixels| pixels.div_ceil(CELL));
    let mut needed = vec![[0; 2]; columns.element_product() as usize];
    for (i, &depth) in depths.iter().enumerate() {
        let pixel = UVec2::new(i as u32 % size.x, i as u32 / size.x).as_vec2() + 0.5;
        let at = (pixel / CELL as f32 - offset - 0.5).clamp(Vec2::ZERO, (columns - 1).as_vec2());
        let low = at.floor().as_uvec2();
        let high = (low + 1).min(columns - 1);
        let [least, most] = [depth, (depth * (1.0 + 1e-4)).min(1.0)]
            .map(|depth| ((depth * steps as f32) as u32 + 1).min(steps) as u16);
        for column in [low, UVec2::new(high.x, low.y), UVec2::new(low.x, high.y), high] {
            let of_column = &mut needed[(column.y * columns.x + column.x) as usize];
            *of_column = [of_column[0].max(least), of_column[1].max(most)];
        }
    }
    needed
}

#[test]
fn air_behind_all_surfaces_is_not_lit() {
    let gpu = gpu(TIERS[0]);
    let scene = walled();
    let steps = scene.air.expect("air").steps;
    let whole = View::from_camera(&scene.camera, &scene.bounds());
    for offset in [Vec2::ZERO, Vec2::new(0.25, -0.375)] {
        let camera = &whole.clone().through(offset);
        let mut shadows = shadows(&gpu);
        let views = gobo::view::shadow_views(&scene);
        let prepared = &shadows.prepare(&scene.casters(), &views, &scene.shadow).unwrap();
        let capacity = PictureCapacity::default();
        let request = PictureRequest { scene: &scene, camera, prepared, capacity };
        let picture = PreparedPicture::new(&shadows, &request, &mut Default::default()).unwrap();
        // The next picture lights the same slices again.
        let lit = [0, 1].map(|_| {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            prepared.record(&mut encoder).unwrap();
            picture.record(&mut encoder, &mut Timeline::untimed());
            gpu.queue.submit([encoder.finish()]);
            picture.read_lit_air(&gpu).unwrap()
        });
        assert_eq!(lit[0], lit[1]);
        let depths: Vec<_> =
            picture.read_radiance(&gpu).unwrap().iter().map(|texel| texel[3]).collect();
        let needed = needed(&depths, camera.size, offset, steps);
        assert_eq!(lit[0].len(), needed.len());
        for (i, (&lit, &[least, most])) in lit[0].iter().zip(&needed).enumerate() {
            assert!(
                lit >= least && lit <= most,
                "{offset}, column {i}: {lit}, not {least}..={most}"
            );
        }
        let all = lit[0].len() * steps as usize;
        let lit: usize = lit[0].iter().map(|&lit| usize::from(lit)).sum();
        assert!(lit < all * 7 / 10 && lit > all / 10, "{lit} of {all}");
    }
}

/// The light of the air does not depend on the band that requests it.
#[test]
fn a_picture_of_two_bands_matches_the_reference() {
    let scene = walled();
    let expected = crate::common::reference_picture(&scene);
    let picture = renderer(TIERS[0]).render(&scene, &Default::default()).unwrap().picture;
    let channels = picture.rgb.iter().flatten().zip(expected.rgb.iter().flatten());
    let apart = channels.filter(|(a, b)| a.abs_diff(**b) > 4).count();
    assert!(apart * 300 < picture.rgb.len(), "{apart}");
}
