//! Parallel division of the work of one application: fixed, so that sums do not depend on the
//! number of threads.

use crate::numerics::exponential::exponentials;
use ndarray::{Array2, ArrayViewMut1, ArrayViewMut2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Number of unknowns above which work is divided among threads: below, waking them takes longer
/// than a plane.
const SHARED: usize = 40_000;

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

/// Tables of cells × harmonics from the `entries` of all of them at a cell and a harmonic, given
/// the exponentials of the `exponents` there, in parallel over cells.
pub(in crate::wave) fn tabulated<const E: usize, const N: usize>(
    shape: (usize, usize),
    tables: usize,
    exponents: impl Fn(usize, usize) -> [Complex64; E] + Sync,
    entries: impl Fn(usize, usize, [Complex64; E]) -> [Complex64; N] + Sync,
) -> Vec<Array2<Complex64>> {
    let mut tables = vec![Array2::zeros(shape); tables];
    by_row(&mut tables, shape.0).into_par_iter().enumerate().for_each(|(cell, mut rows)| {
        let mut waves: Vec<_> = (0..shape.1).flat_map(|i| exponents(cell, i)).collect();
        exponentials(&mut waves);
        for (i, waves) in waves.chunks_exact(E).enumerate() {
            let entries = entries(cell, i, std::array::from_fn(|k| waves[k]));
            rows.iter_mut().zip(entries).for_each(|(row, entry)| row[i] = entry);
        }
    });
    tables
}

/// The rows of tables with `count` rows each: of each row, those of all tables.
pub(in crate::wave) fn by_row<T>(tables: &mut [Array2<T>], count: usize) -> Vec<Vec<ArrayViewMut1<'_, T>>> {
    let mut rows: Vec<Vec<_>> = (0..count).map(|_| Vec::new()).collect();
    for table in tables {
        rows.iter_mut().zip(table.outer_iter_mut()).for_each(|(row, part)| row.push(part));
    }
    rows
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
        let mut buffer = self.lock().pop().unwrap_or_else(new);
        work(&mut buffer);
        self.lock().push(buffer);
    }

    fn lock(&self) -> MutexGuard<'_, Vec<B>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
