//! Soft particles fade before surfaces that are close behind them.
use crate::common::{Tier, files::read, reference_picture, render, scenes::particle, tiers};
use gobo::{
    glam::{Vec3, Vec4},
    model::Particle,
};
use gobo_scene::Scene;

const RADIUS: f32 = 0.3;
/// Opacity of the middle of a disc, and of a puff's diameter.
const ALPHA: f32 = 0.7;
const SIZE: usize = 33;

/// A black wall at z = 0, seen from 5 m before it, and a particle that glows white, its middle `distance`
/// before the wall.
fn scene(look: &str, distance: f32) -> Scene {
    let mut scene = read(&format!(
        "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nfov_y = 20\nsize = [{SIZE}, {SIZE}]\nsamples = 1\n\
         [environment]\nambient = [0, 0, 0]\nbackground = [0, 0, 0]\n\
         [[light]]\nkind = 'directional'\ndirection = [0, 0, -1]\nintensity = 0\n\
         [[material]]\nname = 'black'\ntransfer = 'opaque'\ntint = [0, 0, 0, 1]\n\
         [[material]]\nname = 'glow'\ntint = [0, 0, 0, {ALPHA}]\nemission = [1, 1, 1]\n{look}\
         [[shape]]\nkind = 'box'\nmaterial = 'black'\nscale = [20, 20, 1]\ntranslation = [0, 0, -0.5]\n"
    ))
    .unwrap_or_else(|error| panic!("{error}"));
    let center = Vec3::Z * distance - scene.origin;
    scene.particles.push(Particle { material: 1, ..particle(center, RADIUS, Vec4::ONE) });
    scene
}

fn smooth(part: f32) -> f32 {
    let part = part.clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

/// The middle of a particle: its opacity times a smoothstep from the wall to a diameter before it; of what
/// has an edge, its opacity.
#[test]
fn soft_particles_fade_towards_a_wall() {
    for distance in [0.02_f32, 0.06, 0.15, 0.3, 0.45, 0.6, 1.0] {
        let share = smooth(distance / (2.0 * RADIUS));
        // The ray enters a puff a radius before its middle, and ends at the wall.
        let chord = ((distance + RADIUS) / (2.0 * RADIUS)).min(1.0);
        let of_puff = (1.0 - (1.0 - ALPHA).powf(chord)) * smooth(chord);
        for (look, expected) in [
            ("", ALPHA * share),
            ("shape = 'puff'\n", of_puff),
            ("profile = 'flat'\n", ALPHA),
            ("shape = 'quad'\n", ALPHA),
        ] {
            let scene = scene(look, distance);
            let mut pictures = vec![reference_picture(&scene)];
            let on_gpu = |tier| render(tier, &scene).picture;
            pictures.extend(tiers(Tier::Native).into_iter().map(on_gpu));
            for picture in pictures {
                let found = picture.light[SIZE / 2 * SIZE + SIZE / 2][0];
                let apart = (found - expected).abs();
                assert!(apart < 3e-3, "{look:?} at {distance}: {found}, not {expected}");
            }
        }
    }
}
