//! Parallel division of the work of one application: fixed, so that sums do not depend on the
//! number of threads.

use ndarray::{Array2, ArrayViewMut2, Axis};
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Number of unknowns above which work is divided among threads: below, waking them takes longer
/// than a plane.
pub(in crate::wave) const SHARED: usize = 40_000;

/// Passes `field` to `work` in numbered chunks of `size` along an axis.
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

/// A pool of work arrays.
pub(in crate::wave) struct Idle<B>(Mutex<Vec<B>>);

impl<B> Default for Idle<B> {
    fn default() -> Idle<B> {
        Idle(Mutex::default())
    }
}

impl<B: Send> Idle<B> {
    /// [`in_chunks`] with a work array from the pool.
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

    /// Lends `work` an array from the pool, or a new one.
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
