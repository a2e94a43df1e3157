//! Compares a sample of texels with all casters in 64-bit arithmetic, before a time is printed.
use super::raster::{Inputs, agree::Map, ellipse::Ellipse};
use gobo::{
    glam::{DVec2, Vec3},
    model::{Gaussian, Particle, View},
};
use gobo_scene::generate::Chance;

/// Samples of each kind: texels anywhere in the map, and under a caster's centre.
const SAMPLES: usize = 100;
/// Rounding of fp16 in F, of fp16 opacities, and of the dark end that is written as 0.
const FILTER_TOLERANCE: f64 = 2e-3;
const DEPTH_TOLERANCE: f64 = 1e-5;
const DARK: f64 = 1.0 / 1024.0;
/// Least opacity of a hit that sets D, and the margin in which rounding decides.
const SEEN: f64 = 1.0 / 255.0;
const SEEN_MARGIN: f64 = 1e-5;

struct Sample {
    x: u32,
    y: u32,
    filter: [f64; 3],
    /// Least and largest D that rounding allows.
    nearest: [f64; 2],
}

impl Sample {
    /// Adds a hit of opacity `a` at a light depth.
    fn meet(&mut self, a: f64, color: Vec3, depth: f64) {
        for (filter, c) in self.filter.iter_mut().zip(color.to_array()) {
            *filter *= 1.0 - a * (1.0 - f64::from(c));
        }
        for (nearest, margin) in self.nearest.iter_mut().zip([-SEEN_MARGIN, SEEN_MARGIN]) {
            if a >= SEEN + margin {
                *nearest = nearest.min(depth);
            }
        }
    }
}

/// Position of a disc's centre in the map [texels], and its light depth.
fn center(particle: &Particle, view: &View) -> (DVec2, f64) {
    let p = view.view_from_world.as_dmat4().transform_point3(particle.center.as_dvec3());
    let texel = DVec2::new(p.x, -p.y) * f64::from(view.scale) + view.size.as_dvec2() * 0.5;
    (texel, (-p.z - f64::from(view.near)) / f64::from(view.far - view.near))
}

/// Error of the first wrong texel.
pub(super) fn check(map: &Map, inputs: &Inputs, view: &View) -> Result<(), String> {
    let center_of = |index: usize| match inputs {
        Inputs::Discs(discs) => center(&discs[index], view).0,
        Inputs::Splats(splats) => Ellipse::new(&splats[index], view).center,
    };
    let mut chance = Chance::new(11);
    let mut places: Vec<(u32, u32)> = (0..SAMPLES)
        .map(|_| {
            (chance.below(view.size.x as usize) as u32, chance.below(view.size.y as usize) as u32)
        })
        .collect();
    places.extend((0..SAMPLES).map(|_| {
        let texel = center_of(chance.below(inputs.len()));
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
    match inputs {
        Inputs::Discs(discs) => discs.iter().for_each(|disc| meet_disc(&mut samples, disc, view)),
        Inputs::Splats(splats) => {
            splats.iter().for_each(|splat| meet_splat(&mut samples, splat, view));
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

/// Samples within `low..=high` along x; `samples` are sorted along it.
fn between(samples: &mut [Sample], low: f64, high: f64) -> impl Iterator<Item = &mut Sample> {
    let first = samples.partition_point(|sample| f64::from(sample.x) + 0.5 < low);
    samples[first..].iter_mut().take_while(move |sample| f64::from(sample.x) + 0.5 <= high)
}

fn meet_disc(samples: &mut [Sample], particle: &Particle, view: &View) {
    let (texel, depth) = center(particle, view);
    let projected = f64::from(particle.radius) * f64::from(view.scale);
    let grow = (std::f64::consts::FRAC_1_SQRT_2 / projected).max(1.0);
    let radius = projected * grow;
    for sample in between(samples, texel.x - radius, texel.x + radius) {
        let offset = DVec2::new(f64::from(sample.x), f64::from(sample.y)) + 0.5 - texel;
        let inside = 1.0 - offset.length_squared() / (radius * radius);
        if inside <= 0.0 || !(0.0..=1.0).contains(&depth) {
            continue;
        }
        let a = f64::from(particle.color.w) / (grow * grow) * inside * inside;
        sample.meet(a, particle.color.truncate(), depth);
    }
}

/// Distance beyond which a splat's alpha is below 2e-8 [deviations].
const FARTHEST: f64 = 6.0;

fn meet_splat(samples: &mut [Sample], gaussian: &Gaussian, view: &View) {
    let ellipse = Ellipse::new(gaussian, view);
    let half = ellipse.half_box(FARTHEST).x;
    for sample in between(samples, ellipse.center.x - half, ellipse.center.x + half) {
        let place = ellipse.place(DVec2::new(f64::from(sample.x), f64::from(sample.y)) + 0.5);
        let depth = ellipse.depth + ellipse.tilt.dot(place);
        if (0.0..1.0).contains(&depth) {
            let a = ellipse.opacity * (-0.5 * place.length_squared()).exp();
            sample.meet(a, gaussian.color, depth);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::{
        arguments::{Layout, ShapeName},
        case::Case,
    };

    #[test]
    fn wrong_texels_are_refused() {
        let case = Case {
            shape: ShapeName::Disc,
            casters: 50,
            footprint: 8.0,
            opacity: 0.5,
            layout: Layout::Spread,
            lights: 1,
            size: 32,
        };
        let mut particles = case.particles(0..case.casters);
        let view = &case.views()[0];
        let check =
            |map: &Map, discs: &[Particle]| check(map, &Inputs::Discs(discs.to_vec()), view);
        let empty = Map { width: 32, filter: vec![[1.0; 3]; 1024], nearest: vec![1.0; 1024] };
        assert!(check(&empty, &particles).is_err());
        for particle in &mut particles {
            particle.color.w = 0.0;
        }
        assert_eq!(check(&empty, &particles), Ok(()));
        let unsound = Map { filter: vec![[1.0, f32::NAN, 1.0]; 1024], ..empty.clone() };
        assert!(check(&unsound, &particles).is_err());
        let shallow = Map { nearest: vec![0.5; 1024], ..empty };
        assert!(check(&shallow, &particles).is_err());
    }
}
