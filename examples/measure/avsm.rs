//! Adaptive volumetric shadow maps (Salvi et al. 2010, section 3), as for heterogeneous volumes: hits come
//! front to back.
use gobo::glam::DVec3;

/// Light of one texel: points and linear interpolation, per channel.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Adaptive {
    /// Depth and light of each point, ascending.
    points: [Vec<(f64, f64)>; 3],
    count: usize,
}

impl Adaptive {
    /// `count`: points of a texel, at least 3.
    pub(crate) fn new(count: usize) -> Self {
        Self { points: <[Vec<_>; 3]>::default(), count }
    }

    /// Appends a stretch of transmittance `light` behind those before it.
    pub(crate) fn append(&mut self, [start, end]: [f64; 2], light: DVec3) {
        for (points, light) in self.points.iter_mut().zip(light.to_array()) {
            let (last, before) = points.last().copied().unwrap_or((f64::NEG_INFINITY, 1.0));
            if last < start {
                points.push((start, before));
            }
            points.push((end, before * light));
            while points.len() > self.count {
                points.remove(least(points));
            }
        }
    }

    pub(crate) fn light_at(&self, z: f64) -> DVec3 {
        let light = |points: &Vec<(f64, f64)>| {
            let after = points.partition_point(|point| point.0 < z);
            match (after.checked_sub(1).map(|i| points[i]), points.get(after)) {
                (None, _) => 1.0,
                (Some((_, light)), None) => light,
                (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (z - a.0) / (b.0 - a.0),
            }
        };
        DVec3::from_array([0, 1, 2].map(|i| light(&self.points[i])))
    }
}

/// The inner point whose removal changes the integral of light least.
fn least(points: &[(f64, f64)]) -> usize {
    let area = |i: usize| {
        let [a, b, c] = [points[i - 1], points[i], points[i + 1]];
        ((b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1)).abs()
    };
    (1..points.len() - 1).min_by(|&i, &j| area(i).total_cmp(&area(j))).unwrap_or(1)
}
