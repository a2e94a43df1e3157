//! Comparison of two renderers' maps: no time is printed if they differ.
use gobo::{
    glam::Vec2,
    model::{Particle, View},
    records::MIN_RADIUS,
};

/// One view's maps, row by row.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub(crate) width: u32,
    pub(crate) filter: Vec<[f32; 3]>,
    pub(crate) nearest: Vec<f32>,
}

/// Difference of two maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub(crate) struct Difference {
    /// Mean of `|F - F'|` over texels and channels.
    pub(crate) mean: f64,
    /// Share of the texels where a channel of F is off by more than [`FILTER_OFF`] and rounding.
    pub(crate) filter_share: f64,
    /// Share of the texels where D is off by more than rounding.
    pub(crate) depth_share: f64,
}

impl Difference {
    /// Largest value of each figure.
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            mean: self.mean.max(other.mean),
            filter_share: self.filter_share.max(other.filter_share),
            depth_share: self.depth_share.max(other.depth_share),
        }
    }
}

/// Rounding of the other renderer, a possible cause of differences.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rounding<'a> {
    /// The product to 11 bits at every blend, the depth to fp16; with the layers of each texel.
    Half(&'a [u32]),
    /// The product to 24 bits.
    Float,
}

/// Error of F above which a texel is wrong.
const FILTER_OFF: f32 = 0.02;
/// The compute path writes products below this as 0: they are invisible.
const DARK: f32 = 1.0 / 1024.0;
/// Limits of the mean: both paths hold colours and opacities in 11 to 16 bits, and F in 11.
const MEAN_LIMIT: f64 = 0.002;
const FILTER_LIMIT: f64 = 0.002;
/// Limit of the share of wrong depths. At a = 1/255, on the rim of every disc, rounding decides whether a hit
/// counts. If that hit is the nearest, D is that of another disc.
const DEPTH_LIMIT: f64 = 0.01;

impl Rounding<'_> {
    /// Error of `filter` at texel `i` that blending may cause. Rounding toward zero (as in llvmpipe) loses
    /// half of the last bit per layer on average: at most 2^-11 of the product.
    fn allowance(self, i: usize, filter: f32) -> f32 {
        match self {
            Self::Half(layers) => layers[i] as f32 * filter / 2048.0,
            Self::Float => 0.0,
        }
    }

    /// Error of D above which a texel is wrong.
    fn depth_off(self) -> f32 {
        match self {
            // An fp16 below 1 is off by at most 2^-11; the rest is margin.
            Self::Half(_) => 1.0 / 1024.0,
            Self::Float => 1e-5,
        }
    }
}

/// Fails if the maps of a view differ.
pub(crate) fn agree(
    ours: &Map,
    theirs: &Map,
    rounding: Rounding<'_>,
) -> Result<Difference, String> {
    let lengths =
        [ours.filter.len(), theirs.filter.len(), ours.nearest.len(), theirs.nearest.len()];
    if lengths.iter().any(|&len| len != lengths[0] || len == 0) {
        return Err(format!("the maps have {lengths:?} texels"));
    }
    if ours.filter.iter().all(|texel| *texel == [1.0; 3]) {
        return Err("the compute map is empty: nothing was compared".to_owned());
    }
    let texel_count = ours.filter.len() as f64;
    let (mut difference, mut allowed) = (Difference::default(), 0.0);
    let mut worst = (f32::NEG_INFINITY, 0);
    for (i, (a, b)) in ours.filter.iter().zip(&theirs.filter).enumerate() {
        let mut most = f32::NEG_INFINITY;
        for c in 0..3 {
            let [a, b] = [a[c], b[c]].map(|v| if v < DARK { 0.0 } else { v });
            let apart = (a - b).abs();
            // A NaN counts as wrong.
            let apart = if apart.is_nan() { f32::INFINITY } else { apart };
            let allowance = rounding.allowance(i, a.max(b));
            difference.mean += f64::from(apart) / (3.0 * texel_count);
            allowed += f64::from(allowance) / (3.0 * texel_count);
            most = most.max(apart - allowance);
        }
        difference.filter_share += f64::from(most > FILTER_OFF) / texel_count;
        if most > worst.0 {
            worst = (most, i);
        }
    }
    for (a, b) in ours.nearest.iter().zip(&theirs.nearest) {
        let off = (a - b).abs();
        let is_off = off.is_nan() || off > rounding.depth_off();
        difference.depth_share += f64::from(is_off) / texel_count;
    }
    let Difference { mean, filter_share, depth_share } = difference;
    let mean_limit = MEAN_LIMIT + allowed;
    if mean <= mean_limit && filter_share <= FILTER_LIMIT && depth_share <= DEPTH_LIMIT {
        return Ok(difference);
    }
    let (x, y) = (worst.1 as u32 % ours.width, worst.1 as u32 / ours.width);
    Err(format!(
        "mean |dF| {mean:.5} (limit {mean_limit:.5}), F off at {:.3}% of the texels (limit {}%), D \
         at {:.3}% (limit {}%); worst F at texel ({x}, {y}): {:?} by compute, {:?} by raster",
        filter_share * 100.0,
        FILTER_LIMIT * 100.0,
        depth_share * 100.0,
        DEPTH_LIMIT * 100.0,
        ours.filter[worst.1],
        theirs.filter[worst.1],
    ))
}

/// Number of quads over each texel of a view's map: the number of its blends.
pub(crate) fn layers(particles: &[Particle], view: &View) -> Vec<u32> {
    let (width, height) = (view.size.x as usize, view.size.y as usize);
    // Corners of the rectangles; their sums over all texels above and to the left are the layers.
    let mut sums = vec![0_i32; (width + 1) * (height + 1)];
    for particle in particles {
        let center = view.view_from_world.transform_point3(particle.center);
        let radius = (particle.radius * view.scale).max(MIN_RADIUS);
        let texel = Vec2::new(center.x, -center.y) * view.scale + view.size.as_vec2() * 0.5;
        let last = view.size.as_vec2();
        let low = (texel - radius + 0.5).floor().clamp(Vec2::ZERO, last).as_usizevec2();
        let high = (texel + radius + 0.5).floor().clamp(Vec2::ZERO, last).as_usizevec2();
        for (x, y, sign) in
            [(low.x, low.y, 1), (high.x, low.y, -1), (low.x, high.y, -1), (high.x, high.y, 1)]
        {
            sums[y * (width + 1) + x] += sign;
        }
    }
    for y in 0..=height {
        for x in 0..=width {
            let at = y * (width + 1) + x;
            let left = if x > 0 { sums[at - 1] } else { 0 };
            let above = if y > 0 { sums[at - width - 1] } else { 0 };
            let corner = if x > 0 && y > 0 { sums[at - width - 2] } else { 0 };
            sums[at] += left + above - corner;
        }
    }
    let rows = sums.chunks_exact(width + 1).take(height);
    rows.flat_map(|row| &row[..width]).map(|&count| count.max(0) as u32).collect()
}

/// Share of the texels whose opaque depths differ; fails where it is above `limit`.
pub(crate) fn agree_on_depth(ours: &[f32], theirs: &[f32], limit: f64) -> Result<f64, String> {
    // Depth tolerance, a share of the view's range: the slope of a triangle over the 1/256 texel that
    // rasterizers snap to.
    const OFF: f32 = 1e-4;
    if ours.len() != theirs.len() || ours.is_empty() {
        return Err(format!("{} texels by compute, {} by raster", ours.len(), theirs.len()));
    }
    if ours.iter().all(|&depth| depth == 1.0) {
        return Err("the compute map is empty: nothing was compared".to_owned());
    }
    let is_off = |(a, b): &(&f32, &f32)| {
        let off = (*a - *b).abs();
        off.is_nan() || off > OFF
    };
    let share = ours.iter().zip(theirs).filter(is_off).count() as f64 / ours.len() as f64;
    if share <= limit {
        return Ok(share);
    }
    Err(format!("Z is off at {:.3}% of the texels (limit {:.3}%)", share * 100.0, limit * 100.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> Map {
        let filter = (0..100).map(|i| [0.2 + 0.005 * i as f32, 0.9, 0.5]).collect();
        Map { width: 10, filter, nearest: vec![0.25; 100] }
    }

    const HALF: Rounding<'_> = Rounding::Half(&[2; 100]);

    #[test]
    fn rounding_is_forgiven() {
        let mut other = map();
        for texel in &mut other.filter {
            texel[0] += 0.002;
        }
        other.nearest[0] += 0.0004;
        assert!(agree(&map(), &other, HALF).is_ok());
        let mut dark = [map(), map()];
        dark[0].filter[5] = [0.0; 3];
        dark[1].filter[5] = [0.0009; 3];
        assert_eq!(agree(&dark[0], &dark[1], HALF).unwrap().mean, 0.0);
        // The error allowed for 400 layers is not allowed for two.
        for texel in other.filter.as_flattened_mut() {
            *texel *= 0.9;
        }
        assert!(agree(&map(), &other, Rounding::Half(&[400; 100])).is_ok());
        assert!(agree(&map(), &other, HALF).is_err());
    }

    #[test]
    fn wrong_maps_are_refused() {
        let wrong: [fn(&mut Map); 8] = [
            |map| map.filter[42][1] = 0.85,
            |map| map.filter[7][2] = f32::NAN,
            |map| map.filter.iter_mut().for_each(|texel| texel[0] += 0.015),
            |map| map.nearest[3..5].fill(1.0),
            |map| map.nearest[3..5].fill(f32::NAN),
            |map| map.nearest.iter_mut().for_each(|depth| *depth += 0.002),
            |map| map.filter.reverse(),
            |map| map.filter.truncate(99),
        ];
        for (i, spoil) in wrong.into_iter().enumerate() {
            let mut other = map();
            spoil(&mut other);
            assert!(agree(&map(), &other, HALF).is_err(), "{i}");
            assert!(agree(&map(), &other, Rounding::Float).is_err(), "{i}");
        }
        let empty = Map { filter: vec![[1.0; 3]; 100], ..map() };
        assert!(agree(&empty, &empty, HALF).is_err());
    }

    #[test]
    fn wrong_depths_are_refused() {
        let ours = [0.5; 100];
        let mut theirs = ours;
        theirs[7] = 0.6;
        assert_eq!(agree_on_depth(&ours, &theirs, 0.011), Ok(0.01));
        assert!(agree_on_depth(&ours, &theirs, 0.005).is_err());
        assert!(agree_on_depth(&ours, &[f32::NAN; 100], 0.5).is_err());
        assert!(agree_on_depth(&ours, &theirs[1..], 1.0).is_err());
        assert!(agree_on_depth(&[1.0; 100], &[1.0; 100], 1.0).is_err());
    }
}
