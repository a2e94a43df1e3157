//! Compares a sample of texels with all casters in 64-bit arithmetic, before a time is printed.
use super::raster::agree::Map;
use gobo::{
    glam::DVec2,
    model::{Particle, View},
    scene::generate::Chance,
};

/// Samples of each kind: texels anywhere in the map, and under a caster's centre.
const SAMPLES: usize = 100;
/// Rounding of fp16 in F, fp16 opacities, and the dark end that is written as 0.
const FILTER_TOLERANCE: f64 = 2e-3;
const DEPTH_TOLERANCE: f64 = 1e-5;
const DARK: f64 = 1.0 / 1024.0;
/// Least opacity of a hit that sets D, and the margin within which rounding decides.
const SEEN: f64 = 1.0 / 255.0;
const SEEN_MARGIN: f64 = 1e-5;

struct Sample {
    x: u32,
    y: u32,
    filter: [f64; 3],
    /// Least and largest D that rounding allows.
    nearest: [f64; 2],
}

/// Error of the first wrong texel.
pub(super) fn check(map: &Map, particles: &[Particle], view: &View) -> Result<(), String> {
    let center = |particle: &Particle| {
        let p = view.view_from_world.as_dmat4().transform_point3(particle.center.as_dvec3());
        let texel = DVec2::new(p.x, -p.y) * f64::from(view.scale) + view.size.as_dvec2() * 0.5;
        (texel, (-p.z - f64::from(view.near)) / f64::from(view.far - view.near))
    };
    let mut chance = Chance::new(11);
    let mut places: Vec<(u32, u32)> = (0..SAMPLES)
        .map(|_| {
            (chance.below(view.size.x as usize) as u32, chance.below(view.size.y as usize) as u32)
        })
        .collect();
    places.extend((0..SAMPLES).map(|_| {
        let texel = center(&particles[chance.below(particles.len())]).0;
        let last = view.size.as_dvec2() - 1.0;
        let texel = texel.clamp(DVec2::ZERO, last);
        (texel.x as u32, texel.y as u32)
    }));
    places.sort_unstable();
    places.dedup();
    let mut samples: Vec<Sample> = places
        .into_iter()
        .map(|(x, y)| Sample { x, y, filter: [1.0; 3], nearest: [1.0; 2] })
        .collect();
    for particle in particles {
        let (texel, depth) = center(particle);
        let projected = f64::from(particle.radius) * f64::from(view.scale);
        let grow = (std::f64::consts::FRAC_1_SQRT_2 / projected).max(1.0);
        let radius = projected * grow;
        let first = samples.partition_point(|s| f64::from(s.x) + 0.5 < texel.x - radius);
        for sample in &mut samples[first..] {
            let offset = DVec2::new(f64::from(sample.x), f64::from(sample.y)) + 0.5 - texel;
            if offset.x > radius {
                break;
            }
            let inside = 1.0 - offset.length_squared() / (radius * radius);
            if inside <= 0.0 || !(0.0..=1.0).contains(&depth) {
                continue;
            }
            let a = f64::from(particle.color.w) / (grow * grow) * inside * inside;
            for (filter, c) in sample.filter.iter_mut().zip(particle.color.to_array()) {
                *filter *= 1.0 - a * (1.0 - f64::from(c));
            }
            for (nearest, margin) in sample.nearest.iter_mut().zip([-SEEN_MARGIN, SEEN_MARGIN]) {
                if a >= SEEN + margin {
                    *nearest = nearest.min(depth);
                }
            }
        }
    }
    for Sample { x, y, filter, nearest } in samples {
        let at = (y * map.width + x) as usize;
        let (ours, depth) = (map.filter[at].map(f64::from), f64::from(map.nearest[at]));
        // Written so that a NaN is wrong.
        let light = (0..3).all(|c| {
            (ours[c] - filter[c]).abs() <= FILTER_TOLERANCE || ours[c].max(filter[c]) < DARK
        });
        let inside = depth >= nearest[0] - DEPTH_TOLERANCE && depth <= nearest[1] + DEPTH_TOLERANCE;
        if !(light && inside) {
            return Err(format!(
                "texel ({x}, {y}): F {ours:?}, D {depth} instead of F {filter:?}, D {nearest:?}"
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::bench::{arguments::Layout, case::Case};

    #[test]
    fn wrong_texels_are_refused() {
        let case = Case {
            casters: 50,
            footprint: 8.0,
            opacity: 0.5,
            layout: Layout::Spread,
            lights: 1,
            size: 32,
        };
        let (mut particles, view) = (case.particles(0..case.casters), &case.views()[0]);
        let empty = Map { width: 32, filter: vec![[1.0; 3]; 1024], nearest: vec![1.0; 1024] };
        assert!(check(&empty, &particles, view).is_err());
        for particle in &mut particles {
            particle.color.w = 0.0;
        }
        assert_eq!(check(&empty, &particles, view), Ok(()));
        let unsound = Map { filter: vec![[1.0, f32::NAN, 1.0]; 1024], ..empty.clone() };
        assert!(check(&unsound, &particles, view).is_err());
        let shallow = Map { nearest: vec![0.5; 1024], ..empty };
        assert!(check(&shallow, &particles, view).is_err());
    }
}
