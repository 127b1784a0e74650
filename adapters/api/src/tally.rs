//! What is counted over a run, or over a part of it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// What is counted, by all threads.
#[derive(Debug, Default)]
pub struct Tally {
    calls: AtomicU64,
    frames: AtomicU64,
    cpu_ns: AtomicU64,
    /// What counts the same, and more.
    whole: Option<Arc<Tally>>,
}

impl Tally {
    /// A part of what another one counts.
    pub fn within(whole: &Arc<Self>) -> Self {
        Self {
            whole: Some(Arc::clone(whole)),
            ..Self::default()
        }
    }

    /// One call of a renderer that draws so many frames.
    pub fn add_call(&self, frames: usize) {
        self.calls.fetch_add(1, Ordering::Relaxed);
        self.frames.fetch_add(frames as u64, Ordering::Relaxed);
        if let Some(whole) = &self.whole {
            whole.add_call(frames);
        }
    }

    /// CPU time of a renderer's process, which may still run.
    pub fn add_cpu(&self, time: Duration) {
        let ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        self.cpu_ns.fetch_add(ns, Ordering::Relaxed);
        if let Some(whole) = &self.whole {
            whole.add_cpu(time);
        }
    }

    /// CPU time of the renderer's processes; none where it draws in-process, or
    /// where the system does not tell.
    pub fn cpu(&self) -> Duration {
        Duration::from_nanos(self.cpu_ns.load(Ordering::Relaxed))
    }

    /// Calls, and frames in them.
    pub fn read(&self) -> (u64, u64) {
        (
            self.calls.load(Ordering::Relaxed),
            self.frames.load(Ordering::Relaxed),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_counted_in_the_whole_at_once() {
        let whole = Arc::new(Tally::default());
        let parts = [Tally::within(&whole), Tally::within(&whole)];
        whole.add_call(1);
        parts[0].add_call(3);
        parts[1].add_cpu(Duration::from_millis(20));
        let inner = Tally::within(&Arc::new(Tally::within(&whole)));
        inner.add_cpu(Duration::from_millis(5));
        assert_eq!((parts[0].read(), parts[1].read()), ((1, 3), (0, 0)));
        assert_eq!(
            (parts[0].cpu(), inner.cpu()),
            (Duration::ZERO, Duration::from_millis(5))
        );
        assert_eq!(
            (whole.read(), whole.cpu()),
            ((2, 4), Duration::from_millis(25))
        );
    }
}
