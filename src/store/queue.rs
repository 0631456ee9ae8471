//! Tasks that the workers of one folder take in turn, the costliest first.
//!
//! The queue is an SQLite file that all workers share. A claim holds as long as its worker lives ([`Slot`]): what a
//! killed worker had taken, the others take up at once. What the queue says of finished tasks holds for one session only,
//! from the first worker's start to the last one's end; the records themselves tell what is really there.

use super::slot::Slot;
use rusqlite::{Connection, ErrorCode, OptionalExtension, Transaction, TransactionBehavior, params};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// The queue's file among the records.
const FILE: &str = "queue";
/// Turns at the queue are short.
const PATIENCE: Duration = Duration::from_secs(60);

const TABLES: &str = "
    create table if not exists work (name text not null, publisher integer);
    create table if not exists workers (number integer primary key, holder text not null);
    create table if not exists tasks (id integer primary key, cost real not null, after integer,
        worker integer, done integer not null default 0,
        solves integer not null default 0, failed integer not null default 0);
    create index if not exists by_cost on tasks (done, worker, cost desc, id)";

/// One piece of work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// In any unit: the costliest is taken first.
    pub cost: f64,
    /// The task that must be finished before.
    pub after: Option<usize>,
}

/// What a worker finds when it asks for work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Claim {
    /// This task is its own now.
    Task(usize),
    /// Others hold what is left, or what it waits for: ask again soon.
    Wait,
    /// Everything is finished.
    Finished,
}

/// How far all workers are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    /// Workers at work.
    pub workers: usize,
    /// Tasks finished.
    pub tasks: usize,
    /// Solves ended, also of tasks under way.
    pub solves: usize,
    /// Solves among them that have no result, of finished tasks.
    pub failed: usize,
}

/// Why there is no queue.
#[derive(Debug, thiserror::Error)]
pub enum QueueError {
    /// Another sweep, or another version of it, is under way.
    #[error("other processes work on another sweep in {}", folder.display())]
    OtherWork {
        /// Folder of the records.
        folder: PathBuf,
    },
    /// The queue's file.
    #[error("cannot share the work in {}: {source}", folder.display())]
    File {
        /// Folder of the records.
        folder: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
    /// No place among the workers.
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
    /// Joins the work called `name` in `folder`, or begins it, without a task, when nobody is at it.
    ///
    /// # Errors
    /// Others work on something else there, or the queue's file cannot be used.
    pub fn join(folder: &Path, slot: &Slot, name: &str) -> Result<Self, QueueError> {
        let failed = |source| QueueError::File { folder: folder.to_owned(), source };
        let mut connection =
            open(&folder.join(FILE)).or_else(|error| reopen(folder, slot, error)).map_err(failed)?;
        let transaction =
            Transaction::new(&mut connection, TransactionBehavior::Immediate).map_err(failed)?;
        match under_way(&transaction, folder).map_err(failed)? {
            Some(other) if other != name => return Err(QueueError::OtherWork { folder: folder.to_owned() }),
            Some(_) => {}
            None => begin(&transaction, name).map_err(failed)?,
        }
        enter(&transaction, slot).map_err(failed)?;
        transaction.commit().map_err(failed)?;
        Ok(Self { folder: folder.to_owned(), worker: slot.number(), connection: Mutex::new(connection) })
    }

    /// Puts tasks into the queue under the numbers from `first` on; those that another worker has put there stay as they
    /// are. Tasks wait for tasks of the same call ([`Task::after`] counts from 0).
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn enlist(&self, first: usize, tasks: &[Task]) -> Result<(), QueueError> {
        let sql = "insert or ignore into tasks (id, cost, after) values (?1, ?2, ?3)";
        self.turn(|transaction| {
            let mut insert = transaction.prepare_cached(sql)?;
            for (i, task) in tasks.iter().enumerate() {
                insert.execute(params![first + i, task.cost, task.after.map(|after| first + after)])?;
            }
            Ok(())
        })
    }

    /// Asks for work.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn claim(&self) -> Result<Claim, QueueError> {
        self.turn(|transaction| {
            if let Some(task) = next(transaction)? {
                take(transaction, task, self.worker)?;
                return Ok(Claim::Task(task));
            }
            let left: usize =
                transaction.query_row("select count(*) from tasks where not done", [], |row| row.get(0))?;
            if left == 0 {
                return Ok(Claim::Finished);
            }
            free_claims_of_the_dead(transaction, &self.folder)?;
            let Some(task) = next(transaction)? else { return Ok(Claim::Wait) };
            take(transaction, task, self.worker)?;
            Ok(Claim::Task(task))
        })
    }

    /// A task is finished, with so many solves, of which some have no result.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn finish(&self, task: usize, solves: usize, failed: usize) -> Result<(), QueueError> {
        let sql = "update tasks set done = 1, solves = ?2, failed = ?3 where id = ?1";
        self.turn(|transaction| transaction.execute(sql, params![task, solves, failed]).map(drop))
    }

    /// So many solves of a task are there.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn advance(&self, task: usize, solves: usize) -> Result<(), QueueError> {
        let sql = "update tasks set solves = ?2 where id = ?1 and not done";
        self.turn(|transaction| transaction.execute(sql, params![task, solves]).map(drop))
    }

    /// Tells what the tasks that wait for this one cost, now that it is known.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn reckon(&self, after: usize, cost: f64) -> Result<(), QueueError> {
        let sql = "update tasks set cost = ?2 where after = ?1";
        self.turn(|transaction| transaction.execute(sql, params![after, cost]).map(drop))
    }

    /// Gives a task back unfinished.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn give_back(&self, task: usize) -> Result<(), QueueError> {
        let sql = "update tasks set worker = null, solves = 0 where id = ?1 and not done";
        self.turn(|transaction| transaction.execute(sql, [task]).map(drop))
    }

    /// How far all workers are.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn standing(&self) -> Result<Standing, QueueError> {
        self.turn(|transaction| {
            let sql = "select coalesce(sum(done), 0), coalesce(sum(solves), 0), coalesce(sum(failed), 0) from tasks";
            let (tasks, solves, failed) =
                transaction.query_row(sql, [], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)))?;
            Ok(Standing { workers: living(transaction, &self.folder)?.len(), tasks, solves, failed })
        })
    }

    /// True for the one worker that shall write the report.
    ///
    /// # Errors
    /// The queue's file cannot be used.
    pub fn publishes(&self) -> Result<bool, QueueError> {
        self.turn(|transaction| {
            let publisher: Option<u32> =
                transaction.query_row("select publisher from work", [], |row| row.get(0))?;
            let taken = publisher.is_some_and(|number| {
                number != self.worker
                    && living(transaction, &self.folder).is_ok_and(|all| all.contains(&number))
            });
            if !taken {
                transaction.execute("update work set publisher = ?1", [self.worker])?;
            }
            Ok(!taken)
        })
    }

    fn turn<T>(&self, work: impl FnOnce(&Transaction) -> rusqlite::Result<T>) -> Result<T, QueueError> {
        let mut connection = self.connection.lock().unwrap_or_else(PoisonError::into_inner);
        let at_it = || {
            let transaction = Transaction::new(&mut connection, TransactionBehavior::Immediate)?;
            let done = work(&transaction)?;
            transaction.commit()?;
            Ok(done)
        };
        at_it().map_err(|source| QueueError::File { folder: self.folder.clone(), source })
    }
}

fn open(path: &Path) -> rusqlite::Result<Connection> {
    let connection = Connection::open(path)?;
    connection.busy_timeout(PATIENCE)?;
    let logged = connection.pragma_update(None, "journal_mode", "wal");
    logged.or_else(|_| connection.pragma_update(None, "journal_mode", "truncate"))?;
    // The queue is made anew after a crash of the machine.
    connection.pragma_update(None, "synchronous", "off")?;
    connection.execute_batch(TABLES)?;
    Ok(connection)
}

/// A damaged queue is made anew unless others are at it.
fn reopen(folder: &Path, slot: &Slot, error: rusqlite::Error) -> rusqlite::Result<Connection> {
    let damaged =
        matches!(error.sqlite_error_code(), Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase));
    let others = (1..slot.number() + 64).any(|n| n != slot.number() && Slot::is_held(folder, n));
    if others || !damaged {
        return Err(error);
    }
    for suffix in ["", "-wal", "-shm"] {
        // What cannot be removed shows when the file is opened.
        let _ = std::fs::remove_file(folder.join(format!("{FILE}{suffix}")));
    }
    open(&folder.join(FILE))
}

/// The name of the work that a living worker is at.
fn under_way(transaction: &Transaction, folder: &Path) -> rusqlite::Result<Option<String>> {
    if living(transaction, folder)?.is_empty() {
        return Ok(None);
    }
    transaction.query_row("select name from work", [], |row| row.get(0)).optional()
}

/// Workers of this session that live.
fn living(transaction: &Transaction, folder: &Path) -> rusqlite::Result<Vec<u32>> {
    let mut statement = transaction.prepare_cached("select number, holder from workers")?;
    let all = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
    let all = all.collect::<rusqlite::Result<Vec<(u32, String)>>>()?;
    let lives = |(number, holder): &(u32, String)| Slot::is_held_by(folder, *number, holder);
    Ok(all.into_iter().filter(lives).map(|(number, _)| number).collect())
}

fn begin(transaction: &Transaction, name: &str) -> rusqlite::Result<()> {
    transaction.execute_batch("delete from work; delete from workers; delete from tasks")?;
    transaction.execute("insert into work (name) values (?1)", [name]).map(drop)
}

/// Signs a worker in; an earlier one at the same place is dead, and its tasks are free.
fn enter(transaction: &Transaction, slot: &Slot) -> rusqlite::Result<()> {
    let free = "update tasks set worker = null, solves = 0 where worker = ?1 and not done";
    transaction.execute(free, [slot.number()])?;
    let sign_in = "insert or replace into workers values (?1, ?2)";
    transaction.execute(sign_in, params![slot.number(), slot.holder()]).map(drop)
}

/// The costliest task that nobody holds and that waits for none.
fn next(transaction: &Transaction) -> rusqlite::Result<Option<usize>> {
    let sql = "select id from tasks where not done and worker is null
        and (after is null or exists (select 1 from tasks as first where first.id = tasks.after and first.done))
        order by cost desc, id limit 1";
    transaction.prepare_cached(sql)?.query_row([], |row| row.get(0)).optional()
}

fn take(transaction: &Transaction, task: usize, worker: u32) -> rusqlite::Result<()> {
    transaction.execute("update tasks set worker = ?2 where id = ?1", params![task, worker]).map(drop)
}

fn free_claims_of_the_dead(transaction: &Transaction, folder: &Path) -> rusqlite::Result<()> {
    let living = living(transaction, folder)?;
    let mut statement =
        transaction.prepare("select distinct worker from tasks where worker is not null and not done")?;
    let holding = statement.query_map([], |row| row.get(0))?.collect::<rusqlite::Result<Vec<u32>>>()?;
    for dead in holding.into_iter().filter(|worker| !living.contains(worker)) {
        let sql = "update tasks set worker = null, solves = 0 where worker = ?1 and not done";
        transaction.execute(sql, [dead])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tasks() -> Vec<Task> {
        [(9.0, None), (1.0, Some(0)), (2.0, Some(0)), (5.0, None)]
            .map(|(cost, after)| Task { cost, after })
            .to_vec()
    }

    #[test]
    fn the_costliest_comes_first_and_what_waits_later() {
        let folder = tempfile::tempdir().unwrap();
        let slot = Slot::first_free(folder.path()).unwrap();
        let queue = Queue::join(folder.path(), &slot, "work").unwrap();
        queue.enlist(0, &tasks()).unwrap();
        assert_eq!(queue.claim().unwrap(), Claim::Task(0));
        assert_eq!(queue.claim().unwrap(), Claim::Task(3));
        assert_eq!(queue.claim().unwrap(), Claim::Wait);
        queue.advance(3, 4).unwrap();
        queue.finish(0, 3, 1).unwrap();
        assert_eq!(queue.standing().unwrap(), Standing { workers: 1, tasks: 1, solves: 7, failed: 1 });
        queue.give_back(3).unwrap();
        assert_eq!(queue.claim().unwrap(), Claim::Task(3));
        assert_eq!(queue.claim().unwrap(), Claim::Task(2));
        assert_eq!(queue.claim().unwrap(), Claim::Task(1));
        [1, 2, 3].iter().for_each(|&task| queue.finish(task, 1, 0).unwrap());
        assert_eq!(queue.claim().unwrap(), Claim::Finished);
        // What is there already stays finished; what is new waits for its own.
        queue.enlist(0, &tasks()).unwrap();
        assert_eq!(queue.claim().unwrap(), Claim::Finished);
        queue.enlist(100, &tasks()[..2]).unwrap();
        assert_eq!(queue.claim().unwrap(), Claim::Task(100));
        assert_eq!(queue.claim().unwrap(), Claim::Wait);
        queue.finish(100, 1, 0).unwrap();
        assert_eq!(queue.claim().unwrap(), Claim::Task(101));
    }

    #[test]
    fn a_dead_workers_tasks_are_taken_up_and_a_new_session_begins_anew() {
        let folder = tempfile::tempdir().unwrap();
        let (one, two) = (Slot::first_free(folder.path()).unwrap(), Slot::first_free(folder.path()).unwrap());
        let first = Queue::join(folder.path(), &one, "work").unwrap();
        first.enlist(0, &tasks()).unwrap();
        let second = Queue::join(folder.path(), &two, "work").unwrap();
        let other = Queue::join(folder.path(), &two, "other work");
        assert!(matches!(other, Err(QueueError::OtherWork { .. })));
        assert_eq!(first.claim().unwrap(), Claim::Task(0));
        assert_eq!(second.claim().unwrap(), Claim::Task(3));
        assert_eq!(second.claim().unwrap(), Claim::Wait);
        drop((first, one));
        assert_eq!(second.claim().unwrap(), Claim::Task(0));
        assert!(second.publishes().unwrap());
        drop((second, two));
        let slot = Slot::first_free(folder.path()).unwrap();
        let anew = Queue::join(folder.path(), &slot, "other work").unwrap();
        anew.enlist(0, &tasks()[3..]).unwrap();
        assert_eq!(anew.claim().unwrap(), Claim::Task(0));
        assert_eq!(anew.standing().unwrap().tasks, 0);
    }
}
