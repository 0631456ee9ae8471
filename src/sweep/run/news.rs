//! Progress of a unit, for the screen and for the other workers.

use super::{BETWEEN_NEWS, Worker};
use crate::input::study::{Point, Study};
use crate::run::watch::RunWatch;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Passes on what a unit does, and tells the other workers how far it is.
pub(super) struct News<'a> {
    worker: &'a Worker<'a>,
    task: usize,
    solves: AtomicUsize,
    told: Mutex<Instant>,
}

impl<'a> News<'a> {
    pub fn new(worker: &'a Worker<'a>, task: usize) -> Self {
        Self { worker, task, solves: AtomicUsize::new(0), told: Mutex::new(Instant::now()) }
    }

    fn advance(&self, solves: usize) {
        let solves = self.solves.fetch_add(solves, Ordering::Relaxed) + solves;
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.elapsed() < BETWEEN_NEWS {
            return;
        }
        *told = Instant::now();
        let Worker { queue, watch, .. } = self.worker;
        match queue.advance(self.task, solves).and_then(|()| queue.standing()) {
            Ok(standing) => watch.standing(&standing),
            Err(error) => self.worker.note(Err(error.into())),
        }
    }
}

impl RunWatch for News<'_> {
    fn stop(&self) -> bool {
        self.worker.watch.stop()
    }

    fn stage(&self, what: &str) {
        self.worker.watch.stage(what);
    }

    fn solving(&self, study: &Study, point: &Point) {
        self.worker.watch.solving(study, point);
    }

    fn kept(&self, study: &Study, solves: usize) {
        self.worker.watch.kept(study, solves);
        self.advance(solves);
    }

    fn ended(&self) {
        self.worker.watch.ended();
    }

    fn solved(&self, study: &Study, point: &Point, failure: Option<&str>) {
        self.worker.watch.solved(study, point, failure);
        self.advance(1);
    }
}
