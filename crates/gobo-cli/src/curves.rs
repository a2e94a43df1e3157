//! Curves as `NumPy` arrays and preview images.
use super::npy;
use gobo::{
    glam::Vec3,
    model::{Scene, ShadowSettings},
    records::CurveMap,
    view::shadow_views,
};
use rayon::prelude::*;
use std::io;

/// Numbers of a node: start, end, red, green, blue.
const FIELDS: usize = 5;

/// Start of an unused node: behind the far plane.
const UNUSED: f32 = 2.0;

/// Depths over which a preview averages the light.
const STEPS: usize = 16;

/// Texels that are encoded by one thread, and runs of them that are in memory at once: an array is five times its map.
const RUN: usize = 1 << 12;
const RUNS: usize = 16;

/// Warns of nodes that did not fit the budget of the curves.
pub(super) fn warn_of_nodes(shadow: &ShadowSettings, dropped: u64) {
    const REMEDY: &str = "use a smaller size, fewer lights or a larger curve_budget of [shadow]";
    let asked = u64::from(shadow.curve_nodes());
    if dropped >= asked.max(1) {
        tracing::warn!("receivers read nearest depths: curves do not fit; {REMEDY}");
    } else if dropped > 0 {
        tracing::warn!(
            "curves have {} nodes instead of {asked}: more do not fit; {REMEDY}",
            asked - dropped
        );
    }
}

/// The same before maps are made that no counter tells of.
pub(super) fn warn_before(scene: &Scene) {
    let fitting = scene.shadow.within_curve_budget(&shadow_views(scene));
    warn_of_nodes(&scene.shadow, u64::from(scene.shadow.curve_nodes() - fitting.curve_nodes()));
}

/// Writes the values of all nodes of all texels: in each texel used nodes first, in their order; unused ones have the
/// light behind the last one.
pub(super) fn write(
    out: &mut dyn io::Write,
    [rows, columns]: [usize; 2],
    curve: &CurveMap,
) -> io::Result<()> {
    out.write_all(&npy::header(&[rows, columns, curve.nodes, FIELDS]))?;
    let firsts: Vec<usize> = (0..curve.texel_count()).step_by(RUN).collect();
    for some in firsts.chunks(RUNS) {
        let encoded: Vec<_> = some.par_iter().map(|&first| encoded(curve, first)).collect();
        encoded.iter().try_for_each(|nodes| out.write_all(nodes.as_flattened().as_flattened()))?;
    }
    Ok(())
}

/// A run of texels, as it is written.
fn encoded(curve: &CurveMap, first: usize) -> Vec<[[u8; 4]; FIELDS]> {
    let texels = first..curve.texel_count().min(first + RUN);
    let mut encoded = Vec::with_capacity(texels.len() * curve.nodes);
    let node =
        |start: f32, end: f32, Vec3 { x, y, z }: Vec3| [start, end, x, y, z].map(f32::to_le_bytes);
    for texel in texels {
        let mut behind = Vec3::ONE;
        let end = encoded.len() + curve.nodes;
        for (start, end, light) in curve.ramps(texel) {
            encoded.push(node(start, end, light));
            behind = light;
        }
        encoded.resize(end, node(UNUSED, UNUSED, behind));
    }
    encoded
}

/// Mean light of each texel from the first start of all nodes to their last end.
pub(super) fn preview(curve: &CurveMap) -> Vec<[f32; 3]> {
    let texels = (0..curve.texel_count()).into_par_iter();
    let of_texel = |texel| {
        curve.ramps(texel).fold((1.0, 0.0), |(first, last): (f32, f32), (start, end, _)| {
            (first.min(start), last.max(end))
        })
    };
    let (first, last) = texels
        .clone()
        .map(of_texel)
        .reduce(|| (1.0, 0.0), |(a, b), (first, last)| (a.min(first), b.max(last)));
    let depths = (0..STEPS).map(|i| first + (last - first) * (i as f32 + 0.5) / STEPS as f32);
    let mean = |texel| {
        // Most texels.
        if curve.ramps(texel).next().is_none() {
            return [1.0; 3];
        }
        let sum: Vec3 = depths.clone().map(|z| curve.light_at(texel, z)).sum();
        (sum / STEPS as f32).to_array()
    };
    texels.map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes of what is written at once [bytes].
    #[derive(Default)]
    struct Pieces(Vec<usize>);

    impl io::Write for Pieces {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.push(bytes.len());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// An array is five halves of its map's bytes: it is never in memory whole.
    #[test]
    fn arrays_are_written_in_pieces_whose_size_is_that_of_no_map() {
        const MOST: usize = 1 << 20;
        let (edge, nodes) = (300, 8);
        let curve = CurveMap { nodes, gain: false, packed: vec![[0; 2]; edge * edge * nodes] };
        let mut pieces = Pieces::default();
        write(&mut pieces, [edge, edge], &curve).unwrap();
        let header = npy::header(&[edge, edge, nodes, FIELDS]).len();
        let whole = edge * edge * nodes * FIELDS * size_of::<f32>();
        assert_eq!(pieces.0.iter().sum::<usize>(), header + whole);
        assert!(pieces.0.iter().all(|&bytes| bytes <= MOST) && whole > 10 * MOST, "{:?}", pieces.0);
    }
}
