//! Runs independent solves in parallel.
//!
//! Each worker has a small thread pool of its own, so that no solve waits for another worker's and
//! at most `jobs` solves hold memory at a time. Results depend neither on the worker nor on the
//! number of threads.

use super::watch::{RunError, RunWatch};
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::io;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Workers with their thread pools.
#[derive(Debug)]
pub struct Crew {
    pools: Vec<ThreadPool>,
    /// Number of parallel solves per worker.
    pub jobs_each: usize,
}

impl Crew {
    /// Starts `jobs` workers (default: one per thread), but at most one per task; fewer if the
    /// system refuses threads.
    ///
    /// # Errors
    /// The system refuses every thread.
    pub fn new(jobs: Option<usize>, tasks: usize) -> Result<Self, ThreadPoolBuildError> {
        let jobs = jobs.unwrap_or_else(rayon::current_num_threads).max(1);
        let workers = jobs.min(tasks.max(1));
        let threads_each = (rayon::current_num_threads() / workers).max(1);
        let pool = |_| ThreadPoolBuilder::new().num_threads(threads_each).build();
        let pools = as_many_as_granted((0..workers).map(pool))?;
        Ok(Self { jobs_each: jobs / pools.len(), pools })
    }

    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.pools.len()
    }

    /// Each worker runs `work` on what `take` returns, until that is `None`.
    pub fn work_off(&self, take: impl Fn() -> Option<usize> + Sync, work: impl Fn(usize) + Sync) {
        in_each(&self.pools, &|| std::iter::from_fn(&take).for_each(&work));
    }
}

/// Runs `work` in every pool at once. It uses the pools' existing threads, because the system could
/// refuse new ones.
fn in_each(pools: &[ThreadPool], work: &(impl Fn() + Sync)) {
    let Some((first, others)) = pools.split_first() else { return };
    first.in_place_scope(|scope| {
        scope.spawn(|_| work());
        in_each(others, work);
    });
}

/// All items made before the first refusal; after a refusal only half of them, because the work
/// itself needs memory too.
fn as_many_as_granted<T, E>(made: impl Iterator<Item = Result<T, E>>) -> Result<Vec<T>, E> {
    let mut granted = Vec::new();
    for one in made {
        match one {
            Ok(one) => granted.push(one),
            Err(refusal) if granted.is_empty() => return Err(refusal),
            Err(_) => {
                granted.truncate(granted.len().div_ceil(2));
                break;
            }
        }
    }
    Ok(granted)
}

/// Runs `work` for every index below `count`, `jobs` at a time, starting them in order; ends early
/// if the watch stops it or a result cannot be stored.
///
/// # Errors
/// The system refuses threads (then nothing has been done), or the first error of `work`.
pub fn work_through(
    count: usize,
    jobs: usize,
    watch: &dyn RunWatch,
    work: impl Fn(usize) -> io::Result<()> + Sync,
) -> Result<(), RunError> {
    let next = AtomicUsize::new(0);
    let trouble = OnceLock::new();
    let is_wanted = |i: &usize| *i < count && !watch.stop() && trouble.get().is_none();
    let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(is_wanted);
    Crew::new(Some(jobs), count)?.work_off(take, |i| work(i).unwrap_or_else(|error| _ = trouble.set(error)));
    trouble.into_inner().map_or(Ok(()), |error| Err(RunError::Store(error)))
}

/// Processor time of this process so far, user plus system, s; `None` if the system does not report
/// it.
pub fn processor_seconds() -> Option<f64> {
    cpu_time::ProcessTime::try_now().ok().map(|time| time.as_duration().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn every_index_is_done_once() {
        for jobs in [1, 2, 7, 100] {
            let done: Vec<AtomicUsize> = (0..31).map(|_| AtomicUsize::new(0)).collect();
            let work = |i: usize| Ok(_ = done[i].fetch_add(1, Ordering::SeqCst));
            work_through(31, jobs, &(), work).unwrap();
            assert!(done.iter().all(|n| n.load(Ordering::SeqCst) == 1));
        }
        work_through(0, 3, &(), |_| panic!("there is nothing to do")).unwrap();
    }

    #[test]
    fn refused_threads_leave_fewer_workers() {
        let granted = |most: usize| (0..9).map(move |i| if i < most { Ok(i) } else { Err("refused") });
        assert_eq!(as_many_as_granted(granted(9)).unwrap().len(), 9);
        assert_eq!(as_many_as_granted(granted(5)).unwrap(), [0, 1, 2]);
        assert_eq!(as_many_as_granted(granted(1)).unwrap(), [0]);
        assert_eq!(as_many_as_granted(granted(0)), Err("refused"));
    }

    /// The threads wait for each other: each pool needs its own.
    #[test]
    fn all_workers_are_at_work_at_a_time() {
        let crew = Crew::new(Some(3), 3).unwrap();
        let meeting = std::sync::Barrier::new(3);
        let left = AtomicUsize::new(3);
        let take = || left.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |n| n.checked_sub(1)).ok();
        crew.work_off(take, |_| {
            let _ = meeting.wait();
        });
    }

    struct Called(AtomicBool);

    impl RunWatch for Called {
        fn stop(&self) -> bool {
            self.0.load(Ordering::SeqCst)
        }
    }

    #[test]
    fn a_stop_ends_the_work() {
        let watch = Called(AtomicBool::new(false));
        let done = AtomicUsize::new(0);
        let work = |i| {
            done.fetch_add(1, Ordering::SeqCst);
            Ok(watch.0.store(i >= 3, Ordering::SeqCst))
        };
        work_through(1000, 1, &watch, work).unwrap();
        assert_eq!(done.load(Ordering::SeqCst), 4);
    }
}
