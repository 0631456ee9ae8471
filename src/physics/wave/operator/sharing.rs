//! How the work of one application is shared among threads, in a fixed division: sums do not depend on their number.

use ndarray::{Array2, ArrayViewMut2, Axis};
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Unknowns from which the work is shared among threads: below, waking them takes longer than a plane.
pub(in crate::wave) const SHARED: usize = 40_000;

/// Hands `field` to `work` in numbered chunks of `size` along an axis.
pub(in crate::wave) fn in_chunks<T: Send + Sync>(
    field: &mut Array2<T>,
    axis: Axis,
    size: usize,
    work: impl Fn(usize, ArrayViewMut2<T>) + Send + Sync,
) {
    let shared = field.len() >= SHARED;
    let chunks = field.axis_chunks_iter_mut(axis, size);
    if shared {
        return chunks.into_par_iter().enumerate().for_each(|(k, chunk)| work(k, chunk));
    }
    chunks.into_iter().enumerate().for_each(|(k, chunk)| work(k, chunk));
}

/// Buffers that wait for their next use.
pub(in crate::wave) struct Idle<B>(Mutex<Vec<B>>);

impl<B> Default for Idle<B> {
    fn default() -> Idle<B> {
        Idle(Mutex::default())
    }
}

impl<B: Send> Idle<B> {
    /// [`in_chunks`] with a buffer for `work`.
    pub fn in_chunks<T: Send + Sync>(
        &self,
        field: &mut Array2<T>,
        axis: Axis,
        size: usize,
        new: impl Fn() -> B + Sync,
        work: impl Fn(usize, ArrayViewMut2<T>, &mut B) + Send + Sync,
    ) {
        if field.len() >= SHARED {
            let lent = |k, chunk: ArrayViewMut2<T>| self.lend(&new, |buffer| work(k, chunk, buffer));
            return in_chunks(field, axis, size, lent);
        }
        let chunks = field.axis_chunks_iter_mut(axis, size).enumerate();
        self.lend(new, |buffer| chunks.for_each(|(k, chunk)| work(k, chunk, buffer)));
    }

    /// Lends `work` a buffer: one that waits, or a new one.
    fn lend(&self, new: impl FnOnce() -> B, work: impl FnOnce(&mut B)) {
        let waiting = self.lock().pop();
        let mut buffer = waiting.unwrap_or_else(new);
        work(&mut buffer);
        self.lock().push(buffer);
    }

    fn lock(&self) -> MutexGuard<'_, Vec<B>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
