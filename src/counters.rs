//! What a frame counted: nothing is dropped silently.
use std::collections::BTreeMap;

/// Inputs that were left out, by reason. A skipped particle changes nothing else.
pub type Skipped = BTreeMap<&'static str, u64>;

/// Counts of one frame, over all shadow views.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counters {
    /// Particles and triangles in the scene.
    pub casters: u64,
    /// (caster, view) that touch a texel.
    pub visible: u64,
    /// (caster, tile) that were binned.
    pub pairs: u64,
    /// Runs of pairs that `accumulate` walked.
    pub segments: u64,
    /// (caster, view) that took the scatter path.
    pub scattered: u64,
    /// Of those, for lack of room in the pair budget.
    pub overflowed: u64,
    /// Of those, what filters in a view where the order counts: an `over` caster is among them or
    /// beside them, and they were applied last.
    pub unordered: u64,
    /// Maps that are smaller than they should be, for lack of room in the atlas.
    pub shrunk: u64,
    /// Particles and triangles left out, by reason.
    pub skipped: Skipped,
}
