//! Tasks shared by the workers of one folder, most expensive first.
//!
//! The queue is an SQLite file. A claim is valid as long as its worker lives ([`Slot`]); the tasks
//! of a killed worker are released at once. Task states are valid for one session only, from the
//! start of the first worker to the end of the last; the records show what is actually stored.

mod tables;

use super::slot::Slot;
use rusqlite::{Connection, Params, Transaction, TransactionBehavior, params};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tables::{enlist, free_claims_of_the_dead, join, living, open, take_next};

/// A task of the queue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueuedTask {
    /// Cost in arbitrary units.
    pub cost: f64,
    /// Task that has to be finished first.
    pub after: Option<usize>,
}

/// Answer to a worker that asks for work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assignment {
    /// This task is now assigned to the worker.
    Task(usize),
    /// The remaining tasks are assigned to others or wait for theirs: ask again soon.
    Wait,
    /// Everything is finished.
    Finished,
}

/// Progress of all workers together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct QueueStanding {
    /// Number of active workers.
    pub workers: usize,
    /// Number of finished tasks.
    pub tasks: usize,
    /// Number of processed solves, including those of unfinished tasks.
    pub solves: usize,
    /// Number of solves without a result, in finished tasks.
    pub failed: usize,
}

/// Why the queue cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum QueueError {
    /// Another sweep, or another version of it, is running.
    #[error("other processes are running another study or sweep in {}", folder.display())]
    OtherWork {
        /// Folder of the records.
        folder: PathBuf,
        /// Name of that work.
        name: String,
    },
    /// The queue's file cannot be used.
    #[error("cannot share the work in {}: {source}", folder.display())]
    File {
        /// Folder of the records.
        folder: PathBuf,
        /// SQLite's error.
        source: rusqlite::Error,
    },
    /// No slot is available.
    #[error("cannot join the work: {0}")]
    Place(#[from] std::io::Error),
}

/// A worker's access to the queue; its threads may share it.
#[derive(Debug)]
pub struct Queue {
    folder: PathBuf,
    worker: u32,
    connection: Mutex<Connection>,
}

impl Queue {
    /// Joins the work called `name` in `folder`; starts it, without tasks, if no worker is active.
    ///
    /// # Errors
    /// Other work is in progress there, or the queue's file cannot be used.
    pub fn join(folder: &Path, slot: &Slot, name: &str) -> Result<Self, QueueError> {
        let failed = |source| QueueError::File { folder: folder.to_owned(), source };
        let connection = Mutex::new(open(folder, slot).map_err(failed)?);
        let queue = Self { folder: folder.to_owned(), worker: slot.number, connection };
        match queue.turn(|transaction| join(transaction, folder, slot, name))? {
            None => Ok(queue),
            Some(name) => Err(QueueError::OtherWork { folder: folder.to_owned(), name }),
        }
    }

    /// Adds tasks numbered from `first`; tasks that another worker has already added are left
    /// unchanged. [`QueuedTask::after`] refers to tasks of the same call, counted from 0.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn enlist(&self, first: usize, tasks: &[QueuedTask]) -> Result<(), QueueError> {
        self.turn(|transaction| enlist(transaction, first, tasks))
    }

    /// Claims the next task.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn claim(&self) -> Result<Assignment, QueueError> {
        self.turn(|transaction| self.claim_in(transaction))
    }

    /// Claims a task that is free or was held by a dead worker.
    fn claim_in(&self, transaction: &Transaction) -> rusqlite::Result<Assignment> {
        let mut task = take_next(transaction, self.worker)?;
        if task.is_none() {
            free_claims_of_the_dead(transaction, &self.folder)?;
            task = take_next(transaction, self.worker)?;
        }
        let left = "select exists (select 1 from tasks where not done)";
        Ok(match task {
            Some(task) => Assignment::Task(task),
            None if transaction.query_row(left, [], |row| row.get(0))? => Assignment::Wait,
            None => Assignment::Finished,
        })
    }

    /// Marks a task as finished, with its number of solves and how many of them have no result.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn finish(&self, task: usize, solves: usize, failed: usize) -> Result<(), QueueError> {
        let sql = "update tasks set done = 1, solves = ?2, failed = ?3 where id = ?1";
        self.change(sql, params![task, solves, failed])
    }

    /// Sets the number of processed solves of a task.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn advance(&self, task: usize, solves: usize) -> Result<(), QueueError> {
        self.change("update tasks set solves = ?2 where id = ?1 and not done", params![task, solves])
    }

    /// Sets the cost of the tasks that wait for this one, once it is known.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn reckon(&self, after: usize, cost: f64) -> Result<(), QueueError> {
        self.change("update tasks set cost = ?2 where after = ?1", params![after, cost])
    }

    /// Releases an unfinished task.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn give_back(&self, task: usize) -> Result<(), QueueError> {
        self.change("update tasks set worker = null, solves = 0 where id = ?1 and not done", [task])
    }

    /// Progress of all workers together.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn standing(&self) -> Result<QueueStanding, QueueError> {
        self.turn(|transaction| self.standing_in(transaction))
    }

    /// Sums over all tasks, and the number of living workers.
    fn standing_in(&self, transaction: &Transaction) -> rusqlite::Result<QueueStanding> {
        let sql =
            "select coalesce(sum(done), 0), coalesce(sum(solves), 0), coalesce(sum(failed), 0) from tasks";
        let (tasks, solves, failed) =
            transaction.query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?;
        Ok(QueueStanding { workers: living(transaction, &self.folder)?.len(), tasks, solves, failed })
    }

    /// True for exactly one worker: the one that writes the report.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn publishes(&self) -> Result<bool, QueueError> {
        self.turn(|transaction| self.publishes_in(transaction))
    }

    /// Registers this worker as the publisher unless another living one is.
    fn publishes_in(&self, transaction: &Transaction) -> rusqlite::Result<bool> {
        let publisher: Option<u32> =
            transaction.query_row("select publisher from work", [], |row| row.get(0))?;
        let lives = |number| living(transaction, &self.folder).is_ok_and(|all| all.contains(&number));
        let taken = publisher.is_some_and(|number| number != self.worker && lives(number));
        if !taken {
            transaction.execute("update work set publisher = ?1", [self.worker])?;
        }
        Ok(!taken)
    }

    fn change(&self, sql: &str, values: impl Params) -> Result<(), QueueError> {
        self.turn(|transaction| transaction.execute(sql, values).map(drop))
    }

    /// Runs `work` in a transaction; other processes wait meanwhile.
    fn turn<T>(&self, work: impl FnOnce(&Transaction) -> rusqlite::Result<T>) -> Result<T, QueueError> {
        let failed = |source| QueueError::File { folder: self.folder.clone(), source };
        let mut connection = self.connection.lock().unwrap_or_else(PoisonError::into_inner);
        let transaction =
            Transaction::new(&mut connection, TransactionBehavior::Immediate).map_err(failed)?;
        let done = work(&transaction).map_err(failed)?;
        transaction.commit().map_err(failed)?;
        Ok(done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tasks() -> Vec<QueuedTask> {
        [(9.0, None), (1.0, Some(0)), (2.0, Some(0)), (5.0, None)]
            .map(|(cost, after)| QueuedTask { cost, after })
            .to_vec()
    }

    #[test]
    fn the_costliest_comes_first_and_what_waits_later() {
        let folder = tempfile::tempdir().unwrap();
        let slot = Slot::first_free(folder.path()).unwrap();
        let queue = Queue::join(folder.path(), &slot, "work").unwrap();
        queue.enlist(0, &tasks()).unwrap();
        assert_eq!(queue.claim().unwrap(), Assignment::Task(0));
        assert_eq!(queue.claim().unwrap(), Assignment::Task(3));
        assert_eq!(queue.claim().unwrap(), Assignment::Wait);
        queue.advance(3, 4).unwrap();
        queue.finish(0, 3, 1).unwrap();
        assert_eq!(queue.standing().unwrap(), QueueStanding { workers: 1, tasks: 1, solves: 7, failed: 1 });
        queue.give_back(3).unwrap();
        assert_eq!(queue.claim().unwrap(), Assignment::Task(3));
        assert_eq!(queue.claim().unwrap(), Assignment::Task(2));
        assert_eq!(queue.claim().unwrap(), Assignment::Task(1));
        [1, 2, 3].iter().for_each(|&task| queue.finish(task, 1, 0).unwrap());
        assert_eq!(queue.claim().unwrap(), Assignment::Finished);
        // Existing tasks stay finished; new ones wait for the tasks of their own call.
        queue.enlist(0, &tasks()).unwrap();
        assert_eq!(queue.claim().unwrap(), Assignment::Finished);
        queue.enlist(100, &tasks()[..2]).unwrap();
        assert_eq!(queue.claim().unwrap(), Assignment::Task(100));
        assert_eq!(queue.claim().unwrap(), Assignment::Wait);
        queue.finish(100, 1, 0).unwrap();
        assert_eq!(queue.claim().unwrap(), Assignment::Task(101));
    }

    #[test]
    fn one_worker_publishes_and_another_only_when_that_one_is_dead() {
        let folder = tempfile::tempdir().unwrap();
        let one = Slot::first_free(folder.path()).unwrap();
        let two = Slot::first_free(folder.path()).unwrap();
        let first = Queue::join(folder.path(), &one, "work").unwrap();
        let second = Queue::join(folder.path(), &two, "work").unwrap();
        assert!(first.publishes().unwrap() && !second.publishes().unwrap());
        assert!(first.publishes().unwrap() && !second.publishes().unwrap(), "asked again");
        drop((first, one));
        assert!(second.publishes().unwrap());
    }

    #[test]
    fn a_dead_workers_tasks_are_taken_up_and_a_new_session_begins_anew() {
        let folder = tempfile::tempdir().unwrap();
        let one = Slot::first_free(folder.path()).unwrap();
        let two = Slot::first_free(folder.path()).unwrap();
        let first = Queue::join(folder.path(), &one, "work").unwrap();
        first.enlist(0, &tasks()).unwrap();
        let second = Queue::join(folder.path(), &two, "work").unwrap();
        let other = Queue::join(folder.path(), &two, "other work");
        assert!(matches!(other, Err(QueueError::OtherWork { .. })));
        assert_eq!(first.claim().unwrap(), Assignment::Task(0));
        assert_eq!(second.claim().unwrap(), Assignment::Task(3));
        assert_eq!(second.claim().unwrap(), Assignment::Wait);
        drop((first, one));
        assert_eq!(second.claim().unwrap(), Assignment::Task(0));
        assert!(second.publishes().unwrap());
        drop((second, two));
        let slot = Slot::first_free(folder.path()).unwrap();
        let anew = Queue::join(folder.path(), &slot, "other work").unwrap();
        anew.enlist(0, &tasks()[3..]).unwrap();
        assert_eq!(anew.claim().unwrap(), Assignment::Task(0));
        assert_eq!(anew.standing().unwrap().tasks, 0);
    }
}
