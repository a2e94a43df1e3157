//! What a frame counted: nothing is dropped silently.
use std::collections::BTreeMap;

/// Inputs that were left out, by reason. A skipped particle changes nothing else.
pub type Skipped = BTreeMap<&'static str, u64>;

/// Counts of one frame, over all shadow views that were rendered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(serde::Serialize))]
pub struct Counters {
    /// Particles and triangles in the scene.
    pub casters: u64,
    /// Shadow views whose maps were rendered.
    pub views_rendered: u64,
    /// Shadow views whose maps stay from an earlier frame, because nothing that they see changed.
    pub views_kept: u64,
    /// (caster, view) that were not projected, because their group is outside the view or behind
    /// an opaque surface.
    pub culled: u64,
    /// Those of them that are behind an opaque surface.
    pub hidden: u64,
    /// (caster, view) that touch a texel.
    pub visible: u64,
    /// (caster, tile) that were binned.
    pub pairs: u64,
    /// Runs of pairs that `accumulate` walked.
    pub segments: u64,
    /// (caster, view) that took the scatter path.
    pub scattered: u64,
    /// Those of them that did not fit the pair budget.
    pub overflowed: u64,
    /// Hits that came too late for their place: inside a merged ramp of a curve, or, where an `over`
    /// caster makes the order count, when what is behind them had been composed.
    pub disordered: u64,
    /// (light, cluster of the camera) that the picture's lists have.
    pub cluster_lights: u64,
    /// Clusters whose list did not fit, so that their pixels ask all lights.
    pub clusters_overflowed: u64,
    /// Shadow masks of the picture.
    pub masks: u64,
    /// Lights that cast shadows into the picture and found no mask: they were shaded without one.
    pub unmasked_lights: u64,
    /// Those of them that filter in a view where the order counts: an `over` caster is among them or
    /// beside them, and they were applied last.
    pub unordered: u64,
    /// Maps that are smaller than they should be, for lack of room in the atlas.
    pub shrunk: u64,
    /// Pairs of the batch that has the most.
    #[cfg_attr(feature = "scene", serde(skip))]
    pub pairs_needed: u32,
    /// Pairs that a batch had room for: casters past that were scattered. `Shadows::grow_from` makes
    /// room for them.
    #[cfg_attr(feature = "scene", serde(skip))]
    pub pair_room: u32,
    /// Particles and triangles left out, by reason.
    pub skipped: Skipped,
}
