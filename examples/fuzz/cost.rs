//! CPU time and memory of this process, as Linux counts them.
use std::{fs, time::Duration, time::Instant};

/// Most memory of the process for a file of at most a megabyte: the largest image within the limits
/// \[bytes\].
pub(super) const LARGE: u64 = 2 << 30;
/// Ticks of the kernel's clock [1/s].
const TICKS: u64 = 100;

/// CPU time of this process and of the programs that it waited for; where it is unknown, time.
pub(super) struct Clock {
    start: Instant,
    ticks: Option<u64>,
}

impl Clock {
    pub(super) fn start() -> Self {
        Self { start: Instant::now(), ticks: ticks() }
    }

    pub(super) fn elapsed(&self) -> Duration {
        match (self.ticks, ticks()) {
            (Some(first), Some(last)) => Duration::from_millis((last - first) * 1000 / TICKS),
            _ => self.start.elapsed(),
        }
    }
}

/// User and system time, own and of ended programs: fields 14 to 17 of `proc_pid_stat(5)`.
fn ticks() -> Option<u64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    let fields = stat.rsplit_once(')')?.1.split_ascii_whitespace();
    fields.skip(11).take(4).map(|field| field.parse::<u64>().ok()).sum()
}

/// Largest resident memory since [`forget_peak`] \[bytes\]; 0 where it is unknown.
pub(super) fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.split_ascii_whitespace().next()?.parse::<u64>().ok());
    kilobytes.unwrap_or(0) << 10
}

/// Lets [`peak`] begin anew: `/proc/PID/clear_refs` of `proc(5)`. Without it the peak is that of all inputs.
pub(super) fn forget_peak() {
    drop(fs::write("/proc/self/clear_refs", "5"));
}
