//! The queue's SQLite tables: the work in progress, its workers and its tasks.

use super::QueuedTask;
use crate::store::aside::remove;
use crate::store::rows::to_share;
use crate::store::slot::Slot;
use rusqlite::{Connection, ErrorCode, OptionalExtension, Transaction, params};
use std::path::Path;

/// Name of the queue's file.
const FILE: &str = "queue";

const TABLES: &str = "
    create table if not exists work (name text not null, publisher integer);
    create table if not exists workers (number integer primary key, holder text not null);
    create table if not exists tasks (id integer primary key, cost real not null, after integer,
        worker integer, done integer not null default 0,
        solves integer not null default 0, failed integer not null default 0);
    create index if not exists by_cost on tasks (done, worker, cost desc, id)";

/// Opens the queue of a folder.
pub(super) fn open(folder: &Path, slot: &Slot) -> rusqlite::Result<Connection> {
    connect(&folder.join(FILE)).or_else(|error| reopen(folder, slot, error))
}

fn connect(path: &Path) -> rusqlite::Result<Connection> {
    let connection = Connection::open(path)?;
    to_share(&connection)?;
    // No flush is needed: after a system crash the queue is rebuilt.
    connection.pragma_update(None, "synchronous", "off")?;
    connection.execute_batch(TABLES)?;
    Ok(connection)
}

/// Replaces a damaged queue unless other workers are using it.
fn reopen(folder: &Path, slot: &Slot, error: rusqlite::Error) -> rusqlite::Result<Connection> {
    let damaged =
        matches!(error.sqlite_error_code(), Some(ErrorCode::DatabaseCorrupt | ErrorCode::NotADatabase));
    let others = (1..slot.number + 64).any(|n| n != slot.number && Slot::is_held(folder, n));
    if others || !damaged {
        return Err(error);
    }
    // If removal fails, opening the file reports it.
    let _ = remove(&folder.join(FILE));
    connect(&folder.join(FILE))
}

/// Registers a worker of the work called `name`, unless other work is in progress: its name. A new
/// session begins, without tasks, if no worker is alive. A previous worker in the same slot is
/// dead, and its tasks are released.
pub(super) fn join(
    transaction: &Transaction,
    folder: &Path,
    slot: &Slot,
    name: &str,
) -> rusqlite::Result<Option<String>> {
    let under_way: Option<String> = match living(transaction, folder)?[..] {
        [] => None,
        _ => transaction.query_row("select name from work", [], |row| row.get(0)).optional()?,
    };
    if under_way.is_none() {
        transaction.execute_batch("delete from work; delete from workers; delete from tasks")?;
        transaction.execute("insert into work (name) values (?1)", [name])?;
    }
    if let Some(other) = under_way.filter(|other| other != name) {
        return Ok(Some(other));
    }
    free(transaction, slot.number)?;
    let sign_in = "insert or replace into workers values (?1, ?2)";
    transaction.execute(sign_in, params![slot.number, slot.holder])?;
    Ok(None)
}

/// Living workers of this session.
pub(super) fn living(transaction: &Transaction, folder: &Path) -> rusqlite::Result<Vec<u32>> {
    let mut statement = transaction.prepare_cached("select number, holder from workers")?;
    let all = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
    let all = all.collect::<rusqlite::Result<Vec<(u32, String)>>>()?;
    let lives = |(number, holder): &(u32, String)| Slot::is_held_by(folder, *number, holder);
    Ok(all.into_iter().filter(lives).map(|(number, _)| number).collect())
}

/// Adds tasks; those that exist already are left unchanged.
pub(super) fn enlist(transaction: &Transaction, first: usize, tasks: &[QueuedTask]) -> rusqlite::Result<()> {
    let sql = "insert or ignore into tasks (id, cost, after) values (?1, ?2, ?3)";
    let mut insert = transaction.prepare_cached(sql)?;
    for (i, task) in tasks.iter().enumerate() {
        insert.execute(params![first + i, task.cost, task.after.map(|after| first + after)])?;
    }
    Ok(())
}

/// Assigns to a worker the most expensive free task whose prerequisite is finished.
pub(super) fn take_next(transaction: &Transaction, worker: u32) -> rusqlite::Result<Option<usize>> {
    let sql = "update tasks set worker = ?1 where id = (select id from tasks where not done and worker is null
        and (after is null or exists (select 1 from tasks as first where first.id = tasks.after and first.done))
        order by cost desc, id limit 1) returning id";
    transaction.prepare_cached(sql)?.query_row([worker], |row| row.get(0)).optional()
}

/// Releases the unfinished tasks of a dead worker.
fn free(transaction: &Transaction, worker: u32) -> rusqlite::Result<()> {
    let sql = "update tasks set worker = null, solves = 0 where worker = ?1 and not done";
    transaction.execute(sql, [worker]).map(drop)
}

/// Releases the unfinished tasks of dead workers.
pub(super) fn free_claims_of_the_dead(transaction: &Transaction, folder: &Path) -> rusqlite::Result<()> {
    let living = living(transaction, folder)?;
    let mut statement =
        transaction.prepare("select distinct worker from tasks where worker is not null and not done")?;
    let holding = statement.query_map([], |row| row.get(0))?.collect::<rusqlite::Result<Vec<u32>>>()?;
    holding.into_iter().filter(|worker| !living.contains(worker)).try_for_each(|dead| free(transaction, dead))
}
