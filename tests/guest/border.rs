//! More records than a binding of 128 MiB holds, on a device with WebGPU's default limits: they are in
//! textures.
use super::{Casters, Material, Particle, Vec3, Vec4, View, submit};
use crate::common::{Tier, gpu, scenes::nearest_depth, shadows};
use gobo::{
    glam::{Mat4, UVec2},
    model::{Profile, Projection, ViewRole},
};
use half::f16;

/// Largest binding of WebGPU's default limits \[bytes\].
const BINDING: u64 = 128 << 20;
/// Texels along an edge: layers of a disc for each texel have as many casters as a binding has records of 32
/// bytes after 16.
const SIZE: u32 = 512;
const LAYERS: u32 = 16;
/// Opacity of each disc.
const ALPHA: f32 = 0.05;
/// Most by which light is rounded: a step of halves below .5 is 2^-12, and the opacity of each of 17 discs, a
/// half too, is off by 2^-12 of itself, which changes their light by 1e-4.
const ROUNDED: f32 = 1e-3;

fn view() -> View {
    View {
        role: ViewRole::Whole,
        light: Some(0),
        name: "0",
        projection: Projection::Orthographic,
        size: UVec2::splat(SIZE),
        near: 0.5,
        far: 4.0,
        view_from_world: Mat4::IDENTITY,
        scale: SIZE as f32 / 2.0,
    }
}

/// Discs that cover the middle of one texel each: of all texels in whole layers, then of those where x < 0.
fn particles() -> Vec<Particle> {
    let texel = 2.0 / SIZE as f32;
    let whole = LAYERS * SIZE * SIZE;
    let disc = |id: u32| {
        let (layer, width) =
            if id < whole { (id / (SIZE * SIZE), SIZE) } else { (LAYERS, SIZE / 2) };
        let place = if id < whole { id % (SIZE * SIZE) } else { id - whole };
        let [x, y] = [place % width, place / width].map(|i| (i as f32 + 0.5) * texel - 1.0);
        let center = Vec3::new(x, y, -1.0 - 0.1 * layer as f32);
        let color = Vec4::new(0.0, 0.0, 0.0, ALPHA);
        Particle { id, color, ..Particle::new(center.to_array(), 0.75 * texel) }
    };
    (0..whole + SIZE * SIZE / 2).map(disc).collect()
}

#[test]
#[ignore = "four million casters: make test-all"]
fn records_past_the_border_of_a_binding_are_drawn() {
    let gpu = gpu(Tier::Core);
    assert_eq!(gpu.device.limits().max_storage_buffer_binding_size, BINDING);
    let (particles, mut shadows) = (particles(), shadows(&gpu));
    assert!(particles.len() as u64 * 32 > BINDING);
    let materials = [Material { profile: Profile::Flat, ..Material::default() }];
    let casters = Casters {
        particles: &particles,
        materials: &materials,
        in_order: true,
        ..Casters::default()
    };
    let prepared = shadows.prepare(&casters, &[view()], &nearest_depth()).unwrap();
    let memory = &prepared.memory().0;
    for name in ["casters", "footprints"] {
        let of_name = memory.iter().find(|(known, _)| *known == name);
        assert!(of_name.is_some_and(|&(_, bytes)| bytes > BINDING), "{name}: {memory:?}");
    }
    let found = submit(&gpu, &prepared).filters;
    let through = |layers: u32| (1.0 - ALPHA).powi(layers as i32);
    let width = found.len() as u32 / SIZE;
    for (i, texel) in (0..).zip(&found) {
        let (x, y) = (i % width, i / width);
        if x >= SIZE || y >= SIZE {
            continue;
        }
        let expected = through(LAYERS + u32::from(x < SIZE / 2));
        let light = f16::from_bits(texel[1]).to_f32();
        assert!((light - expected).abs() <= ROUNDED, "({x}, {y}): {light}, not {expected}");
    }
}
