//! Parallel loop over the machine's cores for independent work items.
use rayon::prelude::*;

/// Results of `work(0)..work(count - 1)`, in that order, computed on all cores.
pub(super) fn each<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().map(work).collect()
}
