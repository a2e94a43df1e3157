//! Radius of discs that close the gaps between points.
use glam::Vec3;
use gobo::model::Particle;
use rayon::prelude::*;

/// Points in the sample.
const SAMPLES: usize = 4096;

/// Neighbours before and after a point along the curve that are searched.
const WINDOW: usize = 48;

/// The neighbour whose distance is the spacing: for a square grid in a plane and for random points alike, the
/// mean distance of the fourth is about the edge of the square per point (1 and 1.09 times).
const NEIGHBOR: usize = 4;

/// Radius of points that all coincide \[m\].
const LONE: f32 = 0.05;

/// Median over a sample of the distance to the fourth neighbour \[m\]. Neighbours are searched along a curve
/// through all points (Morton 1966), on which most are close.
pub(super) fn radius(particles: &[Particle]) -> f32 {
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for particle in particles {
        (min, max) = (min.min(particle.center), max.max(particle.center));
    }
    let extent = (max - min).max_element();
    if !extent.is_finite() || extent <= 0.0 {
        return LONE;
    }
    let cells = f64::from((1_u32 << 21) - 1) / f64::from(extent);
    let key = |particle: &Particle| {
        let cell = (particle.center - min).as_dvec3() * cells;
        spread(cell.x as u64) | spread(cell.y as u64) << 1 | spread(cell.z as u64) << 2
    };
    let mut order: Vec<(u64, u32)> =
        particles.par_iter().enumerate().map(|(i, particle)| (key(particle), i as u32)).collect();
    order.par_sort_unstable();
    let step = order.len().div_ceil(SAMPLES).max(1);
    let center = |at: usize| particles[order[at].1 as usize].center;
    let mut distances: Vec<f32> = (0..order.len())
        .step_by(step)
        .filter_map(|at| {
            let window = at.saturating_sub(WINDOW)..(at + WINDOW + 1).min(order.len());
            let mut near: Vec<f32> = window
                .map(|other| center(at).distance_squared(center(other)))
                // Duplicates of the point do not count.
                .filter(|squared| *squared > 0.0)
                .collect();
            near.sort_unstable_by(f32::total_cmp);
            near.get(NEIGHBOR - 1).or(near.last()).map(|squared| squared.sqrt())
        })
        .collect();
    if distances.is_empty() {
        return LONE;
    }
    let middle = distances.len() / 2;
    *distances.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// Bits of a 21-bit number, spread to every third place.
fn spread(number: u64) -> u64 {
    let mut bits = number & 0x1f_ffff;
    bits = (bits | bits << 32) & 0x001f_0000_0000_ffff;
    bits = (bits | bits << 16) & 0x001f_0000_ff00_00ff;
    bits = (bits | bits << 8) & 0x100f_00f0_0f00_f00f;
    bits = (bits | bits << 4) & 0x10c3_0c30_c30c_30c3;
    (bits | bits << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    fn particles(place: impl Fn(usize) -> Vec3, count: usize) -> Vec<Particle> {
        (0..count).map(|i| Particle { center: place(i), ..Particle::default() }).collect()
    }

    /// The spacing of a square grid is its edge, in spite of far points and duplicates beside it.
    #[test]
    fn a_grid_has_its_own_spacing() {
        let grid = |i: usize| Vec3::new((i % 100) as f32 * 0.25, 3.0, (i / 100) as f32 * 0.25);
        assert!((radius(&particles(grid, 10_000)) - 0.25).abs() < 1e-4);
        let with_far = |i: usize| if i < 50 { Vec3::splat(1e5 + i as f32 * 1e3) } else { grid(i) };
        assert!((radius(&particles(with_far, 10_000)) - 0.25).abs() < 1e-4);
        let doubled = |i: usize| grid(i / 2);
        assert!((radius(&particles(doubled, 20_000)) - 0.25).abs() < 1e-4);
    }

    #[test]
    fn few_points_have_a_radius() {
        for count in 0..6 {
            let line = particles(|i| Vec3::X * i as f32, count);
            let radius = radius(&line);
            assert!(radius > 0.0 && radius < 5.0, "{count}: {radius}");
        }
        assert_eq!(radius(&particles(|_| Vec3::ONE, 9)), LONE);
    }
}
