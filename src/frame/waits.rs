//! How often the dispatches of a frame wait for one another.
use super::{Command, Commands, Dispatch, Work};
use crate::gpu::{Access, BindingKind, Resource};

/// Resources that dispatches use at the same time, and whether one of them writes each.
#[derive(Default)]
struct Together(Vec<(Resource, bool)>);

impl Together {
    /// Whether a dispatch may run beside the others, which it then joins.
    fn takes(&mut self, dispatch: &Dispatch) -> bool {
        let uses = uses(dispatch);
        let hinders = |(resource, writes): &(Resource, bool)| {
            self.0.iter().any(|(other, written)| other == resource && (*writes || *written))
        };
        let is_free = !uses.iter().any(hinders);
        if !is_free {
            self.0.clear();
        }
        self.0.extend(uses);
        is_free
    }
}

/// Resources of a dispatch, and whether it writes them.
fn uses(dispatch: &Dispatch) -> Vec<(Resource, bool)> {
    let kinds = dispatch.kernel.bindings();
    let is_written = |name: &str| {
        let kind = kinds.iter().find(|binding| binding.name == name).map(|binding| binding.kind);
        matches!(
            kind,
            Some(BindingKind::Storage { access } | BindingKind::StorageTexture { access, .. })
                if access != Access::Read
        )
    };
    let bound = dispatch.bound.resources().iter();
    let mut uses: Vec<_> =
        bound.map(|(name, resource)| (resource.clone(), is_written(name))).collect();
    if let Work::Indirect(counts, _) = &dispatch.work {
        uses.push((Resource::Buffer(counts.clone()), false));
    }
    uses
}

impl Commands {
    /// Dispatches and copies that wait for what is before them: they use what that writes, or write what it
    /// uses. A device runs the others beside it. Resources of a host's own group are not looked at.
    pub fn wait_count(&self) -> usize {
        let (mut together, mut waits) = (Together::default(), 0);
        for command in self.iter() {
            match command {
                Command::Pass { dispatches, .. } => {
                    let has_to_wait = |dispatch: &&Dispatch| !together.takes(dispatch);
                    waits += dispatches.iter().filter(has_to_wait).count();
                }
                _ => {
                    together.0.clear();
                    waits += 1;
                }
            }
        }
        waits
    }
}
