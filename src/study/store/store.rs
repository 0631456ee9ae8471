//! Records of one kind in a [`Database`].

use super::database::Database;
use super::seal::{Damage, RecordFault};
use serde::{Serialize, de::DeserializeOwned};
use std::io;
use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;

/// A type that can be stored.
pub trait Record: Serialize + DeserializeOwned {
    /// Name of the kind in the store and in messages, such as `point`.
    const KIND: &'static str;

    /// The record without times and builds: what two computations of the same inputs must agree on.
    fn numbers(self) -> Self {
        self
    }
}

/// Whether two stored records contain the same numbers.
pub fn same<R: Record + PartialEq>(one: &[u8], other: &[u8]) -> bool {
    let read = |content| rmp_serde::from_slice::<R>(content).map(R::numbers);
    matches!((read(one), read(other)), (Ok(one), Ok(other)) if one == other)
}

/// Records of one kind. A stored record is returned unchanged, or not at all.
#[derive(Debug)]
pub struct Store<R> {
    database: Arc<Database>,
    kind: PhantomData<fn() -> R>,
}

impl<R: Record> Store<R> {
    /// The records of this kind in `database`.
    pub fn of(database: &Arc<Database>) -> Self {
        Self { database: database.clone(), kind: PhantomData }
    }

    /// The records of this kind below `folder`.
    ///
    /// # Errors
    /// The folder cannot be read.
    pub fn open(folder: impl AsRef<Path>) -> io::Result<Self> {
        Ok(Self::of(&Arc::new(Database::open(folder.as_ref())?)))
    }

    /// Opens a store in memory.
    ///
    /// # Errors
    /// SQLite cannot be started.
    pub fn in_memory() -> io::Result<Self> {
        Ok(Self::of(&Arc::new(Database::in_memory()?)))
    }

    /// The record with this key; `None` if it is missing or damaged, which is noted.
    pub fn get(&self, key: &str) -> Option<R> {
        let fault = match rmp_serde::from_slice(&self.database.get(R::KIND, key)?) {
            Ok(record) => return Some(record),
            Err(error) => RecordFault::Form(error.to_string()),
        };
        self.database.note(Damage::Record { kind: R::KIND.to_owned(), key: key.to_owned(), fault });
        None
    }

    /// Whether there is an intact record with this key.
    pub fn has(&self, key: &str) -> bool {
        self.database.get(R::KIND, key).is_some()
    }

    /// Stores a record permanently.
    ///
    /// # Errors
    /// The record cannot be written.
    pub fn put(&self, key: &str, record: &R) -> io::Result<()> {
        self.database.put(R::KIND, key, rmp_serde::to_vec_named(record).map_err(io::Error::other)?)
    }

    /// Deletes a record if it exists.
    ///
    /// # Errors
    /// The store cannot be written.
    pub fn remove(&self, key: &str) -> io::Result<()> {
        self.database.remove(R::KIND, Some(key))
    }

    /// Deletes all records of this kind.
    ///
    /// # Errors
    /// The store cannot be written.
    pub fn remove_all(&self) -> io::Result<()> {
        self.database.remove(R::KIND, None)
    }

    /// The database that holds these records.
    pub fn database(&self) -> &Arc<Database> {
        &self.database
    }
}
