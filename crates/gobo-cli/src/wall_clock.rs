//! Phases of a command on the wall clock, by the spans of its main thread.
use std::{
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    thread::{self, ThreadId},
    time::Instant,
};
use tracing::{Subscriber, span::Id};
use tracing_subscriber::{
    layer::{Context, Layer},
    registry::LookupSpan,
};

/// Phase outside all spans.
const OTHER: &str = "other";

/// Assigns each moment of the thread that starts it to the innermost span of that thread, so that the phases
/// add up to the elapsed time.
#[derive(Clone)]
pub(crate) struct WallClock {
    thread: ThreadId,
    state: Arc<Mutex<State>>,
}

struct State {
    /// Moment up to which time is assigned.
    until: Instant,
    /// Names of the spans that the thread is in.
    spans: Vec<&'static str>,
    /// Phase and its time [ms].
    spent: Vec<(&'static str, f64)>,
}

impl State {
    /// Assigns the time up to now to the innermost span.
    fn settle(&mut self) {
        let now = Instant::now();
        let ms = now.duration_since(self.until).as_secs_f64() * 1e3;
        self.until = now;
        let phase = *self.spans.last().unwrap_or(&OTHER);
        match self.spent.iter_mut().find(|(known, _)| *known == phase) {
            Some((_, sum)) => *sum += ms,
            None => self.spent.push((phase, ms)),
        }
    }
}

impl WallClock {
    pub(crate) fn start() -> Self {
        let (spans, spent) = Default::default();
        let state = State { until: Instant::now(), spans, spent };
        Self { thread: thread::current().id(), state: Arc::new(Mutex::new(state)) }
    }

    /// Phases since the start, or since the last call, and their times [ms].
    pub(super) fn take(&self) -> Vec<(&'static str, f64)> {
        let mut state = self.state();
        state.settle();
        std::mem::take(&mut state.spent)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_here(&self) -> bool {
        thread::current().id() == self.thread
    }
}

impl<S: Subscriber + for<'a> LookupSpan<'a>> Layer<S> for WallClock {
    fn on_enter(&self, id: &Id, context: Context<'_, S>) {
        if let Some(span) = context.span(id).filter(|_| self.is_here()) {
            let mut state = self.state();
            state.settle();
            state.spans.push(span.name());
        }
    }

    fn on_exit(&self, _: &Id, _: Context<'_, S>) {
        if self.is_here() {
            let mut state = self.state();
            state.settle();
            state.spans.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;
    use tracing_subscriber::prelude::*;

    fn wait(ms: u64) {
        thread::sleep(Duration::from_millis(ms));
    }

    fn of(spent: &[(&'static str, f64)], phase: &str) -> f64 {
        spent.iter().find(|(name, _)| *name == phase).map_or(0.0, |(_, ms)| *ms)
    }

    #[test]
    fn each_moment_belongs_to_the_innermost_span_of_the_thread() {
        let started = Instant::now();
        let clock = WallClock::start();
        let subscriber = tracing_subscriber::registry().with(clock.clone());
        tracing::subscriber::with_default(subscriber, || {
            wait(10);
            let outer = tracing::debug_span!("outer").entered();
            wait(20);
            tracing::debug_span!("inner").in_scope(|| wait(40));
            thread::scope(|scope| {
                let dispatch = tracing::dispatcher::get_default(Clone::clone);
                scope.spawn(move || {
                    tracing::dispatcher::with_default(&dispatch, || {
                        tracing::debug_span!("elsewhere").in_scope(|| wait(10));
                    });
                });
            });
            drop(outer);
        });
        let spent = clock.take();
        let all = started.elapsed().as_secs_f64() * 1e3;
        let sum: f64 = spent.iter().map(|(_, ms)| ms).sum();
        assert!(sum <= all && sum > all - 1.0, "{spent:?} of {all} ms");
        let [other, outer, inner] = [OTHER, "outer", "inner"].map(|phase| of(&spent, phase));
        assert!(other >= 10.0 && outer >= 30.0 && inner >= 40.0, "{spent:?}");
        assert_eq!(spent.len(), 3, "{spent:?}");
        assert!(of(&clock.take(), OTHER) < 10.0, "times are taken once");
    }
}
