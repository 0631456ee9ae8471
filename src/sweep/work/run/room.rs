//! Divides the memory of a process among its workers.

use crate::run::RunError;
use crate::solve::accuracy::AccuracyError;
use std::sync::{PoisonError, RwLock};

/// The memory of a process, bytes.
#[derive(Debug)]
pub(super) struct Room {
    whole: f64,
    workers: usize,
    alone: RwLock<()>,
}

impl Room {
    /// Divides `whole` bytes among `workers`.
    pub fn new(whole: f64, workers: usize) -> Self {
        Self { whole, workers: workers.max(1), alone: RwLock::new(()) }
    }

    /// Runs `work` with an equal share of the memory; if that is too little, runs it again with all
    /// of it while the other workers wait.
    pub fn within<T>(&self, mut work: impl FnMut(f64) -> Result<T, RunError>) -> Result<T, RunError> {
        let together = self.alone.read().unwrap_or_else(PoisonError::into_inner);
        let done = work(self.whole / self.workers as f64);
        drop(together);
        match done {
            Err(error) if self.workers > 1 && lacks_memory(&error) => {
                let _alone = self.alone.write().unwrap_or_else(PoisonError::into_inner);
                work(self.whole)
            }
            done => done,
        }
    }
}

fn lacks_memory(error: &RunError) -> bool {
    use AccuracyError::{Memory, NotReached, TooLarge};
    matches!(
        error,
        RunError::Memory(_) | RunError::Resolution(Memory(_) | TooLarge { .. } | NotReached { .. })
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::demand::TooLarge;
    use crate::wave::{Resolution, Scheme};

    #[test]
    fn what_needs_more_than_its_part_gets_everything_alone() {
        let room = Room::new(8e9, 4);
        let refuse = |memory: f64, need: f64| {
            let resolution = Resolution { nx: 1, ny: 1, cells: 1, scheme: Scheme::default() };
            let too_large = TooLarge { resolution, need_gb: 1e-9 * need, allowed_gb: 1e-9 * memory };
            if memory < need { Err(RunError::Memory(too_large)) } else { Ok(memory) }
        };
        assert_eq!(room.within(|memory| refuse(memory, 1e9)).unwrap(), 2e9);
        assert_eq!(room.within(|memory| refuse(memory, 5e9)).unwrap(), 8e9);
        assert!(room.within(|memory| refuse(memory, 9e9)).is_err());
    }
}
