//! Independent solves side by side.
//!
//! Each worker owns a small thread pool, so that a solve never waits for a neighbour's work and at most
//! `jobs` solves hold memory at a time. What a solve computes does not depend on its worker, so the results
//! do not depend on the number of threads.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Workers with their threads.
#[derive(Debug)]
pub struct Crew {
    pools: Vec<ThreadPool>,
    /// Solves at a time that each worker is allowed.
    pub jobs_each: usize,
}

impl Crew {
    /// As many workers as `jobs` (by default one for each thread), but no more than there are `tasks`.
    ///
    /// # Errors
    /// The system refuses threads.
    pub fn new(jobs: Option<usize>, tasks: usize) -> Result<Self, ThreadPoolBuildError> {
        let jobs = jobs.unwrap_or_else(rayon::current_num_threads).max(1);
        let workers = jobs.min(tasks.max(1));
        let threads_each = (rayon::current_num_threads() / workers).max(1);
        let pool = |_| ThreadPoolBuilder::new().num_threads(threads_each).build();
        Ok(Self { pools: (0..workers).map(pool).collect::<Result<_, _>>()?, jobs_each: jobs / workers })
    }

    /// Their number.
    pub fn workers(&self) -> usize {
        self.pools.len()
    }

    /// Every worker does what `take` gives it until that is nothing.
    pub fn work_off(&self, take: impl Fn() -> Option<usize> + Sync, work: impl Fn(usize) + Sync) {
        let (take, work) = (&take, &work);
        std::thread::scope(|scope| {
            for pool in &self.pools {
                scope.spawn(move || work_off_in(pool, take, work));
            }
        });
    }
}

/// One worker's part: what `take` gives it, one task after the other.
fn work_off_in(pool: &ThreadPool, take: &impl Fn() -> Option<usize>, work: &(impl Fn(usize) + Sync)) {
    while let Some(task) = take() {
        pool.install(|| work(task));
    }
}

/// Does `work` for every index below `count`, `jobs` at a time, in rising order of their beginnings; ends
/// early once `stop` says so.
///
/// # Errors
/// The system refuses threads; nothing has been done then.
pub fn work_through(
    count: usize,
    jobs: usize,
    stop: impl Fn() -> bool + Sync,
    work: impl Fn(usize) + Sync,
) -> Result<(), ThreadPoolBuildError> {
    let next = AtomicUsize::new(0);
    let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&i| i < count && !stop());
    Crew::new(Some(jobs), count)?.work_off(take, work);
    Ok(())
}

/// Processor time of this process so far, user and system, where the system tells it: other programs do not count.
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
            work_through(31, jobs, || false, |i| _ = done[i].fetch_add(1, Ordering::SeqCst)).unwrap();
            assert!(done.iter().all(|n| n.load(Ordering::SeqCst) == 1));
        }
        work_through(0, 3, || false, |_| panic!("there is nothing to do")).unwrap();
    }

    #[test]
    fn a_stop_ends_the_work() {
        let (stop, done) = (AtomicBool::new(false), AtomicUsize::new(0));
        let work = |i| {
            done.fetch_add(1, Ordering::SeqCst);
            stop.store(i >= 3, Ordering::SeqCst);
        };
        work_through(1000, 1, || stop.load(Ordering::SeqCst), work).unwrap();
        assert_eq!(done.load(Ordering::SeqCst), 4);
    }
}
