//! Noise textures: tileable, seeded, animated.
use crate::common::scenes::empty;
use gobo_scene::{
    Scene,
    noise::{Animated, KindOfTexture, Noise},
};
use std::sync::Arc;

const NOISE: Noise = Noise {
    generate: KindOfTexture::Noise,
    seed: 3,
    size: 64,
    cells: 4,
    scroll: [0.25, 0.0],
    evolve: 0.0,
};

fn alpha(noise: Noise, seconds: f64) -> Vec<u8> {
    let texture = noise.texture(String::new(), seconds);
    assert_eq!((texture.width, texture.height), (64, 64));
    texture.rgba.chunks_exact(4).map(|texel| texel[3]).collect()
}

fn largest_step(values: impl Iterator<Item = (u8, u8)>) -> u8 {
    values.map(|(a, b)| a.abs_diff(b)).max().unwrap()
}

#[test]
fn noise_spans_its_range_and_repeats() {
    let alpha = alpha(NOISE, 0.0);
    assert!(alpha.contains(&0) && alpha.contains(&255));
    let mean = alpha.iter().map(|&a| f32::from(a)).sum::<f32>() / 64.0 / 64.0;
    assert!((100.0..155.0).contains(&mean), "{mean}");
    // The seam is no rougher than the rest.
    let inner = largest_step((0..64 * 63).map(|i| (alpha[i], alpha[i + 64])));
    let seam = largest_step((0..64).map(|x| (alpha[63 * 64 + x], alpha[x])));
    assert!(seam <= inner, "{seam} {inner}");
    assert_ne!(alpha, self::alpha(Noise { seed: 4, ..NOISE }, 0.0));
    assert_eq!(alpha, self::alpha(NOISE, 0.0));
}

#[test]
fn noise_scrolls_and_evolves() {
    let (start, moved) = (alpha(NOISE, 0.0), alpha(NOISE, 1.0));
    let apart =
        (0..64 * 64).map(|i| (start[i / 64 * 64 + i % 64], moved[i / 64 * 64 + (i + 16) % 64]));
    assert!(largest_step(apart) <= 1);
    let apart = largest_step(start.iter().copied().zip(alpha(NOISE, 4.0)));
    assert!(apart <= 1, "a whole texture further it is the same");
    let evolving = Noise { scroll: [0.0; 2], evolve: 1.0, ..NOISE };
    let step = |seconds| largest_step(start.iter().copied().zip(alpha(evolving, seconds)));
    assert!(step(0.4) > 60 && step(1.0 / 240.0) < 30, "{} {}", step(0.4), step(1.0 / 240.0));
}

#[test]
fn scenes_follow_the_time() {
    let mut scene: Scene = empty(Vec::new());
    scene.textures = vec![NOISE.texture("smoke".into(), 0.0)];
    scene.motions = vec![Arc::new(Animated { texture: 0, noise: NOISE })];
    let start = scene.textures.clone();
    scene.set_time(0.5);
    assert!(scene.textures[0].rgba != start[0].rgba && scene.textures[0].name == "smoke");
    scene.set_time(0.0);
    assert_eq!(scene.textures, start);
}
