//! Cache of maps from frame to frame: a view is rendered again if its inputs have changed.
mod relocation;

pub(in crate::shadows) use relocation::Relocation;

use crate::model::View;
use crate::shadows::cull::Occluders;
use crate::shadows::{casters::CasterSet, views::host_depths::DepthInput};
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Inputs of each view's cached map.
#[derive(Debug, Default)]
pub(in crate::shadows) struct MapCache {
    views: Vec<CachedView>,
    /// [`CasterSet::id`] of the casters.
    set: u64,
    /// Views to render or rendered last, in order.
    pub pending: Vec<usize>,
    /// Whether the other maps are in their places only after this is recorded.
    moving: bool,
    recorded: Arc<AtomicBool>,
}

/// An input from the host.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Input {
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
    inputs: Vec<(Input, Option<u64>)>,
    /// Occluders of the view, and the number of casters that they hid.
    occluders: Arc<Occluders>,
    hidden: u64,
    /// Generation of the inputs; no later change is in the map. 0 for never rendered.
    at: u64,
}

impl MapCache {
    /// The cache after `earlier`, or an empty one. A view is pending if its own parameters, its groups or a
    /// caster within a group changed, opaque or filtering, before a move or after it. The view's matrix is
    /// compared, not its camera: a camera's move that leaves the matrix unchanged keeps the map. `hides`:
    /// nodes of a curve, if groups behind opaque surfaces are culled.
    pub(in crate::shadows) fn after(
        earlier: Self,
        casters: &CasterSet,
        views: &[View],
        hides: Option<u32>,
        depths: &[Option<DepthInput>],
    ) -> Self {
        let same_set = earlier.set == casters.id();
        let was_recorded = earlier.recorded.load(Ordering::Relaxed);
        let moving = !earlier.fits(views);
        let lost = |index| {
            !was_recorded && (earlier.moving || earlier.pending.binary_search(&index).is_ok())
        };
        let mut before = earlier.views.into_iter();
        let mut pending = Vec::new();
        let views = views.iter().enumerate().map(|(index, view)| {
            let gpu_view = view.to_gpu(0, glam::UVec2::ZERO, 0);
            let mut groups = casters.visible(&gpu_view);
            let depth = depths.get(index).and_then(Option::as_ref);
            let of_casters = casters.host().into_iter().flat_map(|sets| sets.versions(&gpu_view));
            let of_depth =
                depth.map(|depth| (Input::Depth { instead: depth.instead }, depth.version));
            let inputs: Vec<_> = of_casters
                .map(|(set, version)| (Input::Casters(set), version))
                .chain(of_depth)
                .collect();
            // The host's depth map that replaces them has unknown occluders.
            let hides = hides.filter(|_| depth.is_none_or(|depth| !depth.instead));
            let before = before.next();
            let same = before.as_ref().filter(|before| {
                same_set && before.view == *view && before.at >= casters.occluders_at()
            });
            let occluders = same.map_or_else(
                || Arc::new(casters.occluders(&gpu_view)),
                |before| Arc::clone(&before.occluders),
            );
            let hide = |nodes| casters.hide(&mut groups, &gpu_view, &occluders, nodes);
            let hidden = hides.map_or(0, hide);
            let is_kept = before.is_some_and(|before| {
                let changed =
                    |&group: &u32| casters.groups()[group as usize].changed_at > before.at;
                same_set
                    && !lost(index)
                    && before.view == *view
                    && before.groups == groups
                    && before.inputs == inputs
                    && inputs.iter().all(|(_, version)| version.is_some())
                    && !groups.iter().any(changed)
            });
            if !is_kept {
                pending.push(index);
            }
            CachedView {
                view: view.clone(),
                groups,
                inputs,
                occluders,
                hidden,
                at: casters.changed_at(),
            }
        });
        let views = views.collect();
        Self { views, set: casters.id(), pending, moving, recorded: Arc::default() }
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

    /// Whether the pending views are recorded in the host's encoder, which the frame's [`Prepared`] sets.
    ///
    /// [`Prepared`]: crate::shadows::Prepared
    pub(in crate::shadows) fn recorded(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.recorded)
    }

    /// Marks the pending views to be rendered again.
    pub(in crate::shadows) fn forget(&self) {
        self.recorded.store(false, Ordering::Relaxed);
    }
}
