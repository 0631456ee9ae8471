//! Independent solves side by side.
//!
//! Each worker owns a small thread pool, so that a solve never waits for a neighbour's work and at most
//! `jobs` solves hold memory at a time. What a solve computes does not depend on its worker, so the results
//! do not depend on the number of threads.

use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};
use std::sync::atomic::{AtomicUsize, Ordering};

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
    let jobs = jobs.clamp(1, count.max(1));
    let threads_each = (rayon::current_num_threads() / jobs).max(1);
    let pools = (0..jobs)
        .map(|_| ThreadPoolBuilder::new().num_threads(threads_each).build())
        .collect::<Result<Vec<_>, _>>()?;
    let next = AtomicUsize::new(0);
    let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&i| i < count && !stop());
    std::thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                while let Some(i) = take() {
                    pool.install(|| work(i));
                }
            });
        }
    });
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
