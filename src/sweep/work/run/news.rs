//! Progress of a unit, for the screen and for other processes.

use super::{BETWEEN_NEWS, Worker};
use crate::run::watch::{Event, RunWatch};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Forwards the events of a unit and reports its progress to the queue.
pub(super) struct News<'a> {
    worker: &'a Worker<'a>,
    task: usize,
    /// Number of solves, and when it was last told.
    told: Mutex<(usize, Instant)>,
}

impl<'a> News<'a> {
    pub fn new(worker: &'a Worker<'a>, task: usize) -> Self {
        Self { worker, task, told: Mutex::new((0, Instant::now())) }
    }

    fn advance(&self, solves: usize) {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        told.0 += solves;
        if told.1.elapsed() < BETWEEN_NEWS {
            return;
        }
        told.1 = Instant::now();
        let Worker { queue, watch, .. } = self.worker;
        match queue.advance(self.task, told.0).and_then(|()| queue.standing()) {
            Ok(standing) => watch.hear(Event::Standing(&standing)),
            Err(error) => self.worker.note(error),
        }
    }
}

impl RunWatch for News<'_> {
    fn stop(&self) -> bool {
        self.worker.watch.stop()
    }

    fn hear(&self, event: Event) {
        if matches!(event, Event::Solving(..)) {
            self.worker.begin();
        }
        self.worker.watch.hear(event);
        match event {
            Event::Kept(solves) | Event::Dropped(solves) => self.advance(solves),
            Event::Solved(..) => self.advance(1),
            _ => {}
        }
    }
}
