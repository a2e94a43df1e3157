//! Cache of maps from frame to frame: a view is rendered again if its inputs have changed.
mod relocation;

pub(in crate::shadows) use relocation::Relocation;

use crate::model::View;
use crate::shadows::cull::Occluders;
use crate::shadows::{casters::CasterSet, views::host_depths::DepthInput};

/// Inputs of each view's cached map.
#[derive(Debug, Default)]
pub(in crate::shadows) struct MapCache {
    views: Vec<CachedView>,
    /// [`CasterSet::id`] of the casters.
    set: u64,
    /// Views that must be rendered, or were rendered last, in order.
    pub pending: Vec<usize>,
    /// Number of views whose groups were searched for last.
    pub searched: usize,
    /// Whether the other maps reach their places only when the frame runs.
    moving: bool,
    /// Whether the frame is not known to have run.
    lost: bool,
}

/// An input from the host.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CachedInput {
    /// Index of the set.
    Casters(usize),
    Depth {
        /// Whether it replaces the opaque depth of our own casters.
        instead: bool,
    },
}

#[derive(Debug)]
struct CachedView {
    view: View,
    /// Indices of the groups that the view may see.
    groups: Vec<u32>,
    /// The host's inputs that the view may see, each with its version.
    inputs: Vec<(CachedInput, Option<u64>)>,
    /// Occluders of the view, and the number of casters that they hid.
    occluders: Occluders,
    hidden: u64,
    /// Nodes of a curve, if groups were culled by the occluders.
    hides: Option<u32>,
    /// Generation of the inputs; no later change is in the map. 0 for never rendered.
    at: u64,
    /// Whether it is among the pending views.
    pending: bool,
}

impl CachedView {
    /// The view of a map that was never rendered.
    fn new(view: &View) -> Self {
        let (groups, inputs, occluders) = (Vec::new(), Vec::new(), Occluders::default());
        Self {
            view: view.clone(),
            groups,
            inputs,
            occluders,
            hidden: 0,
            hides: None,
            at: 0,
            pending: true,
        }
    }
}

impl MapCache {
    /// The cache after `self`, or after an empty one. A view is pending if its own parameters, its groups or
    /// a caster within a group changed, opaque or filtering, before a move or after it. The view's matrix is
    /// compared, not its camera: a move of the camera that leaves the matrix unchanged keeps the map.
    /// `hides`: nodes of a curve, if groups behind opaque surfaces are culled.
    #[must_use]
    pub(in crate::shadows) fn followed(
        mut self,
        casters: &CasterSet,
        views: &[View],
        hides: Option<u32>,
        depths: &[Option<DepthInput>],
    ) -> Self {
        let same_set = self.set == casters.id();
        let (was_moving, moving) = (self.moving, !self.fits(views));
        self.pending.clear();
        self.searched = 0;
        self.views.truncate(views.len());
        let (mut inputs, changed_at) = (Vec::new(), casters.changed_at());
        for (index, view) in views.iter().enumerate() {
            let gpu_view = view.to_gpu(0, glam::UVec2::ZERO, 0);
            let depth = depths.get(index).and_then(Option::as_ref);
            inputs.clear();
            inputs.extend(
                casters
                    .host_versions(&gpu_view)
                    .map(|(set, version)| (CachedInput::Casters(set), version)),
            );
            inputs.extend(
                depth.map(|depth| (CachedInput::Depth { instead: depth.instead }, depth.version)),
            );
            // A host's depth map that replaces them has unknown occluders.
            let hides = hides.filter(|_| depth.is_none_or(|depth| !depth.instead));
            let is_new = index == self.views.len();
            if is_new {
                self.views.push(CachedView::new(view));
            }
            let cached = &mut self.views[index];
            let same_view = same_set && !is_new && cached.view == *view;
            let same_occluders = same_view && cached.at >= casters.occluders_at();
            let at = cached.at;
            let changed = |&group: &u32| casters.groups()[group as usize].changed_at > at;
            let mut sees_change = false;
            // Where no caster has changed since, the groups are the same.
            let same_groups = same_occluders && cached.at == changed_at && cached.hides == hides;
            if !same_groups {
                self.searched += 1;
                if !same_occluders {
                    cached.occluders = casters.occluders(&gpu_view);
                }
                let mut groups = casters.visible(&gpu_view);
                let hide = |nodes| casters.hide(&mut groups, &gpu_view, &cached.occluders, nodes);
                cached.hidden = hides.map_or(0, hide);
                sees_change = cached.groups != groups || groups.iter().any(changed);
                cached.groups = groups;
            }
            let lost = self.lost && (was_moving || cached.pending);
            let is_kept = same_view
                && !lost
                && !sees_change
                && cached.inputs == inputs
                && inputs.iter().all(|(_, version)| version.is_some());
            if !is_kept {
                self.pending.push(index);
            }
            if !same_view {
                cached.view = view.clone();
            }
            (cached.hides, cached.pending) = (hides, !is_kept);
            cached.at = changed_at;
            std::mem::swap(&mut cached.inputs, &mut inputs);
        }
        (self.set, self.moving, self.lost) = (casters.id(), moving, false);
        self
    }

    /// Whether maps of these views have the same sizes.
    pub(in crate::shadows) fn fits(&self, views: &[View]) -> bool {
        self.views.iter().map(|cached| cached.view.size).eq(views.iter().map(|view| view.size))
    }

    /// Views whose maps are kept.
    pub(in crate::shadows) fn kept(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.views.len()).filter(|index| self.pending.binary_search(index).is_err())
    }

    pub(in crate::shadows) fn view_count(&self) -> usize {
        self.views.len()
    }

    /// Indices of the groups that a view may see.
    pub(in crate::shadows) fn groups(&self, view: usize) -> &[u32] {
        &self.views[view].groups
    }

    /// Casters of the pending views that are hidden by opaque surfaces.
    pub(in crate::shadows) fn hidden_count(&self) -> u64 {
        self.pending.iter().map(|&view| self.views[view].hidden).sum()
    }

    /// Marks the pending views to be rendered again.
    pub(in crate::shadows) fn forget(&mut self) {
        self.lost = true;
    }
}
