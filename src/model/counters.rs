//! Counters of a frame: nothing is dropped silently.
use std::collections::BTreeMap;

/// Inputs that were left out, by reason. Skipping one changes nothing else.
pub type Skipped = BTreeMap<&'static str, u64>;

/// Counts of one frame, over all shadow views that were rendered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Counters {
    /// Particles, triangles and bricks in the scene.
    pub casters: u64,
    /// Shadow views whose maps were rendered.
    pub views_rendered: u64,
    /// Shadow views whose maps stay from an earlier frame, because nothing that they see changed.
    pub views_kept: u64,
    /// Views whose casters were searched for on the CPU; none in still frames.
    pub views_searched: u64,
    /// Combinations (caster, view) that were not projected, because their group is outside the view or behind
    /// an opaque surface.
    pub culled: u64,
    /// Those counted in `culled` that are behind an opaque surface.
    pub hidden: u64,
    /// Combinations (caster, view) that touch a texel.
    pub visible: u64,
    /// Pairs (caster, tile) that were binned.
    pub pairs: u64,
    /// Runs of pairs that `accumulate` walked.
    pub segments: u64,
    /// Combinations (caster, view) that took the scatter path, or did not fit the pair budget.
    pub scattered: u64,
    /// Those counted in `scattered` that did not fit the pair budget.
    pub overflowed: u64,
    /// Hits out of order: inside a merged ramp of a curve, or, where an `over` caster makes blending
    /// order-dependent, in front of hits that had already been composed.
    pub disordered: u64,
    /// Combinations (light, cluster of the camera) in the picture's light lists.
    pub cluster_lights: u64,
    /// Clusters whose list did not fit, so that their pixels evaluate all lights.
    pub clusters_overflowed: u64,
    /// Shadow masks of the picture.
    pub masks: u64,
    /// Lights that cast shadows into the picture but got no mask, and were shaded without one.
    pub unmasked_lights: u64,
    /// Casters counted in `overflowed` that filter in a view with order-dependent blending (an `over` caster
    /// is among them or in the same view), and were scattered, and so applied last. 0 where the parts of the
    /// tiles suffice.
    pub unordered: u64,
    /// Maps that are smaller than they should be, because the atlas is full.
    pub shrunk: u64,
    /// Nodes that the curves of all views lack of those that were asked for, because they did not fit
    /// [`ShadowSettings::curve_budget`](super::ShadowSettings::curve_budget): where that is all of them,
    /// receivers read nearest depths.
    pub nodes_dropped: u64,
    /// Tiles whose curves have a single node, because there was no page for them
    /// ([`CurveMemory::Counted`](super::CurveMemory::Counted)).
    pub short_tiles: u64,
    /// Maps of lights with a size whose levels were made.
    pub levels_made: u64,
    /// Drawings of pictures: one per sample, and another where pairs did not fit at first.
    pub pictures_drawn: u64,
    /// Times that the pairs of the maps or of a picture did not fit at first.
    pub capacities_grown: u64,
    /// Pairs of the largest batch.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub pairs_needed: u32,
    /// Pair capacity of a batch: past it, tiles are walked in parts. `Shadows::grow_from` raises it.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub pair_capacity: u32,
    /// Pages of curves; 0 without. `Shadows::grow_from` raises it.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub page_capacity: u32,
    /// Particles and triangles left out, by reason.
    pub skipped: Skipped,
}
