//! An SQLite file of sealed records.
//!
//! It uses write-ahead logging without a flush at every commit: a killed process loses nothing that
//! it has written, a power failure only the last moments, and thousands of small records per second
//! are cheap. Any SQLite client can read it: `select kind, key, program, length(content) from
//! records`.

use super::seal::Sealed;
use rusqlite::{Connection, OpenFlags, OptionalExtension, params};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// SQLite application number of our files ("inkw").
const APPLICATION: i32 = 0x696e_6b77;
/// Timeout: other processes read a file, checkpoint its log or change a few rows, which is quick.
const PATIENCE: Duration = Duration::from_secs(60);
/// Pages of the log before it is merged into the file.
const LOG_PAGES: i32 = 4000;

const COLUMNS: &str =
    "(kind text not null, key text not null, method integer not null, program text not null,
    seal blob not null, content blob not null, primary key (kind, key))";

/// An open record file.
#[derive(Debug)]
pub struct Rows {
    /// Path of the file; empty if in memory.
    pub(super) path: PathBuf,
    connection: Connection,
}

impl Rows {
    /// Opens the file for writing; creates it if necessary.
    pub fn create(path: &Path) -> rusqlite::Result<Self> {
        Self::to_write(path.to_owned(), Connection::open(path)?)
    }

    /// Opens a file in memory.
    pub fn in_memory() -> rusqlite::Result<Self> {
        Self::to_write(PathBuf::new(), Connection::open_in_memory()?)
    }

    fn to_write(path: PathBuf, connection: Connection) -> rusqlite::Result<Self> {
        to_share(&connection)?;
        connection.pragma_update(None, "synchronous", "normal")?;
        connection.pragma_update(None, "wal_autocheckpoint", LOG_PAGES)?;
        connection.pragma_update(None, "application_id", APPLICATION)?;
        connection.execute(&format!("create table if not exists records {COLUMNS}"), [])?;
        Ok(Self { path, connection })
    }

    /// Opens the file for reading, even while another process writes it.
    pub fn read(path: &Path) -> rusqlite::Result<Self> {
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags)?;
        connection.busy_timeout(PATIENCE)?;
        let readable = connection.query_row("select count(*) from sqlite_master", [], |_| Ok(()));
        let connection = if readable.is_ok() { connection } else { Self::as_it_is(path)? };
        Ok(Self { path: path.to_owned(), connection })
    }

    /// Whether the file has its table: between its creation and that of the table it has none.
    pub fn is_begun(&self) -> bool {
        let sql = "select 1 from sqlite_master where type = 'table' and name = 'records'";
        self.connection.query_row(sql, [], |_| Ok(())).optional().is_ok_and(|found| found.is_some())
    }

    /// Opens a file in a read-only folder, where the log's shared memory cannot be created; such a
    /// file has no writers.
    fn as_it_is(path: &Path) -> rusqlite::Result<Connection> {
        let name = path.display().to_string().replace('%', "%25").replace('?', "%3f").replace('#', "%23");
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI;
        let flags = flags | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        Connection::open_with_flags(format!("file:{name}?immutable=1"), flags)
    }

    /// The record with this key, damaged or not.
    pub fn get(&self, kind: &str, key: &str) -> rusqlite::Result<Option<Sealed>> {
        let sql = "select * from records where kind = ?1 and key = ?2";
        self.connection.prepare_cached(sql)?.query_row([kind, key], sealed).optional()
    }

    /// The seal of the record with this key, damaged or not.
    pub fn seal(&self, kind: &str, key: &str) -> rusqlite::Result<Option<Vec<u8>>> {
        let sql = "select seal from records where kind = ?1 and key = ?2";
        self.connection.prepare_cached(sql)?.query_row([kind, key], |row| row.get(0)).optional()
    }

    /// Stores a record, replacing one with the same key.
    pub fn put(&self, record: &Sealed) -> rusqlite::Result<()> {
        let sql = "insert or replace into records values (?1, ?2, ?3, ?4, ?5, ?6)";
        let Sealed { kind, key, method, program, seal, content } = record;
        let mut statement = self.connection.prepare_cached(sql)?;
        statement.execute(params![kind, key, method, program, seal, content]).map(drop)
    }

    /// Deletes a record if it exists, or all records of a kind.
    pub fn remove(&self, kind: &str, key: Option<&str>) -> rusqlite::Result<()> {
        let sql = "delete from records where kind = ?1 and (?2 is null or key = ?2)";
        self.connection.execute(sql, params![kind, key]).map(drop)
    }

    /// Passes all records to `each`, starting with the oldest or the newest, until it fails. What
    /// lies behind a damaged page is only reached from the other end.
    ///
    /// # Errors
    /// The reason why the file cannot be read further.
    pub fn scan<E>(
        &self,
        newest_first: bool,
        mut each: impl FnMut(Sealed) -> Result<(), E>,
    ) -> rusqlite::Result<Result<(), E>> {
        let order = if newest_first { "desc" } else { "asc" };
        let mut statement =
            self.connection.prepare(&format!("select * from records order by rowid {order}"))?;
        for record in statement.query_map([], sealed)? {
            if let Err(end) = each(record?) {
                return Ok(Err(end));
            }
        }
        Ok(Ok(()))
    }

    /// Keys of all records of a kind.
    pub fn keys(&self, kind: &str) -> rusqlite::Result<Vec<String>> {
        let mut statement = self.connection.prepare_cached("select key from records where kind = ?1")?;
        statement.query_map([kind], |row| row.get(0))?.collect()
    }

    /// True if there are no readable records.
    pub fn is_empty(&self) -> bool {
        self.connection.query_row("select 1 from records limit 1", [], |_| Ok(())).is_err()
    }

    /// What is wrong with the file's layout or pages; `None` if they are intact.
    pub fn trouble(&self) -> Option<String> {
        let layout =
            "select sql, (select encoding from pragma_encoding) from sqlite_schema where name = 'records'";
        let texts = |row: &rusqlite::Row| Ok((row.get::<_, String>(0)?, row.get::<_, String>(1)?));
        match self.connection.query_row(layout, [], texts) {
            Ok((table, encoding)) if table.ends_with(COLUMNS) && encoding == "UTF-8" => {}
            Ok(_) => return Some("the table of records has another structure".into()),
            Err(error) => return Some(error.to_string()),
        }
        if self.connection.is_readonly("main").unwrap_or(true) {
            return Some("the file cannot be written to".into());
        }
        let checked = self.connection.query_row("pragma integrity_check(1)", [], |row| row.get(0));
        Some(checked.unwrap_or_else(|error| error.to_string())).filter(|told| told != "ok")
    }

    /// Runs `work` in one transaction.
    ///
    /// # Errors
    /// Errors of `work`, or of SQLite at the commit.
    pub fn at_once<T, E: From<rusqlite::Error>>(&self, work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
        let transaction = self.connection.unchecked_transaction()?;
        let done = work()?;
        transaction.commit()?;
        Ok(done)
    }
}

fn sealed(row: &rusqlite::Row) -> rusqlite::Result<Sealed> {
    Ok(Sealed {
        kind: row.get(0)?,
        key: row.get(1)?,
        method: row.get(2)?,
        program: row.get(3)?,
        seal: row.get(4)?,
        content: row.get(5)?,
    })
}

/// Lets a connection wait for others, and logs what it writes. File systems without shared memory
/// do not support the log; a rollback journal works, more slowly.
pub(super) fn to_share(connection: &Connection) -> rusqlite::Result<()> {
    connection.busy_timeout(PATIENCE)?;
    let logged = connection.pragma_update(None, "journal_mode", "wal");
    logged.or_else(|_| connection.pragma_update(None, "journal_mode", "truncate"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_kept_replaced_scanned_and_forgotten() {
        let rows = Rows::in_memory().unwrap();
        let row = |kind: &str, key: &str, content: u8| Sealed::new(kind, key, vec![content]);
        let all = [row("point", "a", 1), row("point", "b", 2), row("grid", "a", 3)];
        rows.at_once::<(), rusqlite::Error>(|| all.iter().try_for_each(|row| rows.put(row))).unwrap();
        rows.put(&row("point", "a", 9)).unwrap();
        assert_eq!(rows.get("point", "a").unwrap().unwrap().content, [9]);
        assert_eq!(rows.get("grid", "b").unwrap(), None);
        for (newest_first, first) in [(false, "b"), (true, "a")] {
            let mut keys = Vec::new();
            rows.scan::<()>(newest_first, |row| Ok(keys.push(row.key))).unwrap().unwrap();
            assert!(keys.len() == 3 && keys[0] == first, "{keys:?}");
        }
        rows.remove("point", Some("a")).unwrap();
        assert_eq!(rows.get("point", "a").unwrap(), None);
        rows.remove("point", None).unwrap();
        assert_eq!(rows.get("point", "b").unwrap(), None);
        assert_eq!(rows.trouble(), None);
    }
}
