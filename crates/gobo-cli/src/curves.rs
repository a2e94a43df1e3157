//! Curves as `NumPy` arrays and preview images.
use super::npy;
use gobo::{
    glam::Vec3,
    model::{Scene, ShadowSettings},
    records::{
        CurveMap,
        curve::{DEPTHS, unpack},
    },
    view::shadow_views,
};
use rayon::prelude::*;
use std::io;

/// Numbers of a node: start, end, red, green, blue.
const FIELDS: usize = 5;

/// Start of an unused node: beyond the far plane.
const UNUSED: f32 = 2.0;

/// Depths over which a preview averages the light.
const STEPS: usize = 16;

/// Texels that one thread encodes, and number of such runs in memory at once: an array is five times its map.
const RUN: usize = 1 << 12;
const RUNS: usize = 16;

/// Warning of nodes that do not fit the budget of the curves, if there are any. `dropped`: their number.
pub fn nodes_warning(shadow: &ShadowSettings, dropped: u64) -> Option<String> {
    const REMEDY: &str = "use a smaller size, fewer lights or a larger curve_budget of [shadow]";
    let asked = u64::from(shadow.curve_nodes());
    if dropped == 0 {
        None
    } else if dropped >= asked {
        Some(format!("receivers read nearest depths: curves do not fit; {REMEDY}"))
    } else {
        let fitting = asked - dropped;
        Some(format!("curves have {fitting} nodes instead of {asked}: more do not fit; {REMEDY}"))
    }
}

/// The same before maps are made that no counter tells of.
pub fn nodes_warning_before(scene: &Scene) -> Option<String> {
    let shadow = &scene.shadow;
    let fitting = shadow.within_curve_budget(&shadow_views(scene));
    nodes_warning(shadow, u64::from(shadow.curve_nodes() - fitting.curve_nodes()))
}

/// Prints [`nodes_warning_before`].
pub(super) fn warn_before(scene: &Scene) {
    if let Some(warning) = nodes_warning_before(scene) {
        tracing::warn!("{warning}");
    }
}

/// Reason why curves are not written.
#[derive(Debug, thiserror::Error)]
pub(super) enum Fault {
    #[error(transparent)]
    Write(#[from] io::Error),
    #[error(transparent)]
    Device(#[from] gobo::Error),
}

/// Takes some texels of a view.
pub(super) type Take<'a> = &'a mut dyn FnMut(&CurveMap) -> Result<(), Fault>;

/// Curves of a view, which are not in memory at once.
#[derive(Clone, Copy)]
pub(super) struct Curves<'a> {
    /// Nodes of a texel.
    pub nodes: usize,
    /// Gives all texels in turn, as often as it is asked.
    pub give: &'a dyn Fn(Take<'_>) -> Result<(), Fault>,
}

/// Depths of the first start of all nodes and of their last end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    first: f32,
    last: f32,
}

impl Span {
    /// The span of no node.
    pub(super) const NONE: Self = Self { first: 1.0, last: 0.0 };

    fn and(self, Self { first, last }: Self) -> Self {
        Self { first: self.first.min(first), last: self.last.max(last) }
    }
}

/// Some texels as they are written.
#[derive(Default)]
struct Run {
    nodes: Vec<[[u8; 4]; FIELDS]>,
    /// Ramps of a texel.
    ramps: Vec<(f32, f32, Vec3)>,
}

impl Run {
    /// Encodes a run of texels.
    fn encode(&mut self, curve: &CurveMap, first: usize) -> Span {
        let node = |start: f32, end: f32, Vec3 { x, y, z }: Vec3| {
            [start, end, x, y, z].map(f32::to_le_bytes)
        };
        let Self { nodes, ramps } = self;
        let mut span = Span::NONE;
        nodes.clear();
        for texel in first..curve.texel_count().min(first + RUN) {
            let mut behind = Vec3::ONE;
            let end = nodes.len() + curve.nodes;
            if is_used(curve, texel) {
                curve.ramps_to(texel, ramps);
                for &(start, end, light) in &*ramps {
                    nodes.push(node(start, end, light));
                    span = span.and(Span { first: start, last: end });
                    behind = light;
                }
            }
            nodes.resize(end, node(UNUSED, UNUSED, behind));
        }
        span
    }
}

/// Whether a texel has nodes; most have none.
fn is_used(curve: &CurveMap, texel: usize) -> bool {
    curve.nodes_of(texel).iter().any(|node| node[0] >> 16 > 0)
}

impl Curves<'_> {
    /// Writes the values of all nodes of all texels: in each texel used nodes first, in their order; unused
    /// ones have the light behind the last one.
    pub(super) fn write(
        &self,
        out: &mut dyn io::Write,
        [rows, columns]: [usize; 2],
    ) -> Result<Span, Fault> {
        out.write_all(&npy::header(&[rows, columns, self.nodes, FIELDS]))?;
        let mut runs: Vec<_> = (0..RUNS).map(|_| Run::default()).collect();
        let mut span = Span::NONE;
        (self.give)(&mut |curve| {
            let firsts: Vec<usize> = (0..curve.texel_count()).step_by(RUN).collect();
            for firsts in firsts.chunks(RUNS) {
                let runs = &mut runs[..firsts.len()];
                let encode = |(run, &first): (&mut Run, _)| run.encode(curve, first);
                let spans = runs.par_iter_mut().zip(firsts).map(encode);
                span = span.and(spans.reduce(|| Span::NONE, Span::and));
                let bytes = |run: &Run| out.write_all(run.nodes.as_flattened().as_flattened());
                runs.iter().try_for_each(bytes)?;
            }
            Ok(())
        })?;
        Ok(span)
    }

    /// Mean light of each texel over the depths of all nodes, as it is shown.
    pub(super) fn preview<T: Send>(
        &self,
        Span { first, last }: Span,
        show: impl Fn([f32; 3]) -> T + Sync,
    ) -> Result<Vec<T>, Fault> {
        let depth = |i| first + (last - first) * (i as f32 + 0.5) / STEPS as f32;
        let depths: [f32; STEPS] = std::array::from_fn(|i| depth(i) * DEPTHS);
        let mut shown = Vec::new();
        (self.give)(&mut |curve| {
            let texels = (0..curve.texel_count()).into_par_iter().with_min_len(RUN);
            shown.par_extend(texels.map(|texel| show(mean(curve, texel, &depths))));
            Ok(())
        })?;
        Ok(shown)
    }
}

/// Mean light of a texel at depths in fixed point.
fn mean(curve: &CurveMap, texel: usize, depths: &[f32; STEPS]) -> [f32; 3] {
    if !is_used(curve, texel) {
        return [1.0; 3];
    }
    // As `gobo::records::curve::light_at` has it, with each node unpacked once.
    let mut lights = [[1.0; STEPS]; 3];
    for &node in curve.nodes_of(texel) {
        let (start, length, passed) = unpack(node, curve.gain);
        if start > 0.0 {
            let length = length.max(1e-6);
            for (light, passed) in lights.iter_mut().zip(passed.to_array()) {
                for (light, z) in light.iter_mut().zip(depths) {
                    let share = ((z - start) / length).clamp(0.0, 1.0);
                    *light *= (1.0 - share) + passed * share;
                }
            }
        }
    }
    lights.map(|light| light.iter().sum::<f32>() / STEPS as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use gobo::records::curve::packed;

    /// Sizes of the pieces that are written [bytes].
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

    /// An array is five halves of its map's bytes: it is never in memory as a whole.
    #[test]
    fn arrays_are_written_in_pieces_whose_size_is_that_of_no_map() {
        const MOST: usize = 1 << 20;
        let (edge, nodes) = (300, 8);
        let curve = CurveMap { nodes, gain: false, packed: vec![[0; 2]; edge * edge * nodes] };
        let mut pieces = Pieces::default();
        let curves = Curves { nodes, give: &|take| take(&curve) };
        curves.write(&mut pieces, [edge, edge]).unwrap();
        let header = npy::header(&[edge, edge, nodes, FIELDS]).len();
        let whole = edge * edge * nodes * FIELDS * size_of::<f32>();
        assert_eq!(pieces.0.iter().sum::<usize>(), header + whole);
        assert!(pieces.0.iter().all(|&bytes| bytes <= MOST) && whole > 10 * MOST, "{:?}", pieces.0);
    }

    /// In pieces of any size: the mean of the look-ups at the middles of sixteen parts of what the nodes
    /// span.
    #[test]
    fn previews_are_means_of_look_ups() {
        let texels = 1000_u32;
        for (nodes, gain) in [(4, false), (8, true)] {
            let node = |i: u32| {
                let texel = i / nodes as u32;
                let number = i % nodes as u32;
                // A third has none, others have some, in no order.
                let is_used = !texel.is_multiple_of(3) && number < texel % (nodes as u32 + 1);
                let start = if is_used { 9000 + (i * 7919) % 40_000 } else { 0 };
                let passed = Vec3::new(0.9, 0.5, 0.1) * (1.0 - (i % 7) as f32 * 0.1);
                packed(start, (i % 5 * 1000) as f32, passed, gain)
            };
            let packed: Vec<_> = (0..texels * nodes as u32).map(node).collect();
            let whole = CurveMap { nodes, gain, packed };
            let (mut first, mut last) = (1.0_f32, 0.0_f32);
            for (start, end, _) in (0..texels as usize).flat_map(|texel| whole.ramps(texel)) {
                (first, last) = (first.min(start), last.max(end));
            }
            let depths = (0..16).map(|i| first + (last - first) * (i as f32 + 0.5) / 16.0);
            let look_up = |texel| {
                let sum: Vec3 = depths.clone().map(|z| whole.light_at(texel, z)).sum();
                (sum / 16.0).to_array()
            };
            let wanted: Vec<_> = (0..texels as usize).map(look_up).collect();
            assert!(first > 0.1 && last < 0.9 && wanted.iter().any(|light| light[0] < 0.9));
            let mut arrays = Vec::new();
            for size in [texels as usize, 7] {
                let give = |take: Take<'_>| {
                    let some = |packed: &[_]| CurveMap { nodes, gain, packed: packed.to_vec() };
                    whole.packed.chunks(size * nodes).try_for_each(|packed| take(&some(packed)))
                };
                let curves = Curves { nodes, give: &give };
                let mut array = Vec::new();
                let span = curves.write(&mut array, [texels as usize, 1]).unwrap();
                let preview = curves.preview(span, |light| light).unwrap();
                assert!(preview == wanted, "{nodes} nodes, {size} at a time");
                arrays.push(array);
            }
            assert!(arrays[0] == arrays[1], "{nodes} nodes");
        }
    }

    /// A device that is lost is no fault of the file.
    #[test]
    fn faults_of_the_device_are_not_those_of_files() {
        let lost = || gobo::Error::Lost("gone".to_owned());
        let curves = Curves { nodes: 4, give: &|_| Err(lost().into()) };
        let written = curves.write(&mut Pieces::default(), [1, 1]);
        assert!(matches!(written, Err(Fault::Device(_))), "{written:?}");
    }
}
