//! As many calls of the renderer at once as are allowed.

use std::sync::{Condvar, Mutex, PoisonError};

/// A counting semaphore.
pub struct Slots {
    free: Mutex<usize>,
    changed: Condvar,
}

/// The right to run one call; given back when dropped.
pub struct Slot<'a>(&'a Slots);

impl Slots {
    /// So many calls at once.
    pub fn new(count: usize) -> Self {
        Self {
            free: Mutex::new(count.max(1)),
            changed: Condvar::new(),
        }
    }

    /// Waits for a free slot.
    pub fn take(&self) -> Slot<'_> {
        // A count is whole at every moment: a panic elsewhere did not spoil it.
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        while *free == 0 {
            free = self
                .changed
                .wait(free)
                .unwrap_or_else(PoisonError::into_inner);
        }
        *free -= 1;
        Slot(self)
    }
}

impl Drop for Slot<'_> {
    fn drop(&mut self) {
        *self.0.free.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.0.changed.notify_one();
    }
}
