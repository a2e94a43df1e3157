//! Parallel loop over the machine's cores for independent work items.
use std::{
    sync::atomic::{AtomicUsize, Ordering},
    thread::ScopedJoinHandle,
};

/// Results of `work(0)..work(count - 1)`, in that order, computed on all cores.
pub(super) fn each<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    /// Runs that many small items are cut into: enough to share them out, few enough to take no memory.
    const RUNS: usize = 4096;
    let cores = std::thread::available_parallelism().map_or(2, usize::from).min(count);
    if cores <= 1 {
        return (0..count).map(work).collect();
    }
    let length = count.div_ceil(RUNS);
    let next = AtomicUsize::new(0);
    let take = || {
        let firsts = std::iter::repeat_with(|| next.fetch_add(length, Ordering::Relaxed));
        let run = |first: usize| (first..count.min(first + length)).map(&work).collect::<Vec<_>>();
        firsts.take_while(|&i| i < count).map(|i| (i, run(i))).collect::<Vec<_>>()
    };
    let mut done: Vec<(usize, Vec<T>)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(take)).collect();
        let results = workers.into_iter().map(ScopedJoinHandle::join);
        results.flat_map(|result| result.unwrap_or_else(|e| std::panic::resume_unwind(e))).collect()
    });
    done.sort_by_key(|&(first, _)| first);
    let mut all = Vec::with_capacity(count);
    done.into_iter().for_each(|(_, run)| all.extend(run));
    all
}
