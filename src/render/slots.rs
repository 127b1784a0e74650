//! As many calls of the renderer at once as are allowed.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// A counting semaphore, whose limit may change.
pub struct Slots {
    counts: Mutex<Counts>,
    changed: Condvar,
}

struct Counts {
    limit: usize,
    taken: usize,
}

/// The right to run one call; given back when dropped.
pub struct Slot<'a>(&'a Slots);

impl Slots {
    /// So many calls at once.
    pub fn new(limit: usize) -> Self {
        Self {
            counts: Mutex::new(Counts {
                limit: limit.max(1),
                taken: 0,
            }),
            changed: Condvar::new(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Counts> {
        // A count is whole at every moment: a panic elsewhere did not spoil it.
        self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for a free slot.
    pub fn take(&self) -> Slot<'_> {
        let mut counts = self.lock();
        while counts.taken >= counts.limit {
            counts = self
                .changed
                .wait(counts)
                .unwrap_or_else(PoisonError::into_inner);
        }
        counts.taken += 1;
        Slot(self)
    }

    /// How many calls are allowed at once, and how many run.
    pub fn counts(&self) -> (usize, usize) {
        let counts = self.lock();
        (counts.limit, counts.taken)
    }

    /// Allows so many from now on; those that run go on.
    pub fn allow(&self, limit: usize) {
        self.lock().limit = limit.max(1);
        self.changed.notify_all();
    }
}

impl Drop for Slot<'_> {
    fn drop(&mut self) {
        self.0.lock().taken -= 1;
        self.0.changed.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_that_sinks_lets_those_who_have_a_slot_end() {
        let slots = Slots::new(3);
        let (first, second) = (slots.take(), slots.take());
        slots.allow(1);
        assert_eq!(slots.counts(), (1, 2));
        std::thread::scope(|scope| {
            let third = scope.spawn(|| drop(slots.take()));
            drop(first);
            std::thread::sleep(std::time::Duration::from_millis(30));
            assert!(!third.is_finished(), "one runs, and one may");
            drop(second);
            third.join().expect("it has its turn");
        });
        slots.allow(0);
        drop(slots.take());
    }
}
