//! The results store: one small JSON file per finished record, named by its content hash.
//!
//! Every record is written the moment it is finished, whole or not at all, so an interrupted run keeps what
//! it finished and several processes may share a store. Any tool reads it; `jq -s . points/*.json` is a table.

use super::safely;
use serde::{Serialize, de::DeserializeOwned};
use std::io;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

/// Records of one kind in one folder.
#[derive(Debug)]
pub struct Store<R> {
    folder: PathBuf,
    kind: PhantomData<fn() -> R>,
}

impl<R: Serialize + DeserializeOwned> Store<R> {
    /// Opens the store in `folder`, making it when it is not there.
    pub fn open(folder: impl Into<PathBuf>) -> io::Result<Self> {
        let folder = folder.into();
        std::fs::create_dir_all(&folder)?;
        Ok(Self { folder, kind: PhantomData })
    }

    /// The record of this key; `None` when there is none, or none that can be read.
    pub fn get(&self, key: &str) -> Option<R> {
        let text = std::fs::read(self.path(key)).ok()?;
        serde_json::from_slice(&text).ok()
    }

    /// True when there is a record of this key, readable or not.
    pub fn has(&self, key: &str) -> bool {
        self.path(key).exists()
    }

    /// Keeps a record for good.
    pub fn put(&self, key: &str, record: &R) -> io::Result<()> {
        safely::write(&self.path(key), &serde_json::to_vec(record)?)
    }

    /// Forgets a record, if it is there.
    pub fn remove(&self, key: &str) -> io::Result<()> {
        match std::fs::remove_file(self.path(key)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(key).with_extension("json")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_is_got_and_damage_counts_as_absence() {
        let folder = tempfile::tempdir().unwrap();
        let store: Store<Vec<f64>> = Store::open(folder.path().join("points")).unwrap();
        assert_eq!(store.get("a"), None);
        store.put("a", &vec![0.1, 1.0 / 3.0]).unwrap();
        assert_eq!(store.get("a"), Some(vec![0.1, 1.0 / 3.0]));
        std::fs::write(store.folder().join("a.json"), b"[0.1, 0.3").unwrap();
        assert_eq!(store.get("a"), None);
    }
}
