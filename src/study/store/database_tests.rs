//! Tests with several processes, damage and copies.

use super::*;
use crate::store::seal::RecordFault;

fn open(folder: &tempfile::TempDir) -> Database {
    Database::open(folder.path()).unwrap()
}

/// Changes rows of a worker's file directly in SQLite.
fn tamper(folder: &tempfile::TempDir, sql: &str) {
    let path = folder.path().join("records/1.sqlite");
    rusqlite::Connection::open(path).unwrap().execute_batch(sql).unwrap();
}

fn two_records(folder: &tempfile::TempDir) {
    let store = open(folder);
    store.put("point", "a", vec![1; 5000]).unwrap();
    store.put("point", "b", vec![2]).unwrap();
}

#[test]
fn workers_write_their_own_files_and_read_all() {
    let folder = tempfile::tempdir().unwrap();
    let one = open(&folder);
    let two = open(&folder);
    one.put("point", "a", vec![1]).unwrap();
    two.put("point", "b", vec![2]).unwrap();
    assert_eq!(one.get("point", "b"), None);
    one.refresh().unwrap();
    two.refresh().unwrap();
    assert_eq!((one.get("point", "b"), two.get("point", "a")), (Some(vec![2]), Some(vec![1])));
    assert!(folder.path().join("records/2.sqlite").exists() && one.keys("point").len() == 2);
}

/// A file that its process is creating is no damage, and is read once it has its table. *Planted*:
/// it counts as damaged.
#[test]
fn a_file_that_is_being_created_is_read_later() {
    let folder = tempfile::tempdir().unwrap();
    let reader = open(&folder);
    let records = folder.path().join("records");
    std::fs::create_dir_all(&records).unwrap();
    let slot = Slot::take(&records, 1).unwrap().expect("a free slot");
    rusqlite::Connection::open(records.join("1.sqlite"))
        .unwrap()
        .execute_batch("pragma user_version = 1")
        .unwrap();
    reader.refresh().unwrap();
    assert_eq!((reader.get("point", "a"), reader.damages()), (None, Vec::new()));
    drop(slot);
    open(&folder).put("point", "a", vec![1]).unwrap();
    reader.refresh().unwrap();
    assert_eq!((reader.get("point", "a"), reader.damages()), (Some(vec![1]), Vec::new()));
}

#[test]
fn damage_counts_as_absence_is_reported_once_and_heals() {
    let swap = "update records set content = (select content from records as o where o.key != records.key)";
    for (sql, fault) in [
        ("update records set content = x'03' where key = 'a'", RecordFault::Seal),
        ("update records set method = 0 where key = 'a'", RecordFault::Seal),
        ("update records set program = 'other' where key = 'a'", RecordFault::Seal),
        (swap, RecordFault::Seal),
    ] {
        let folder = tempfile::tempdir().unwrap();
        two_records(&folder);
        tamper(&folder, sql);
        let store = open(&folder);
        assert_eq!((store.get("point", "a"), store.get("point", "a")), (None, None));
        let expected = Damage::Record { kind: "point".into(), key: "a".into(), fault };
        assert_eq!(store.damages(), [expected], "{sql}");
        store.put("point", "a", vec![9]).unwrap();
        assert_eq!(open(&folder).get("point", "a"), Some(vec![9]));
        assert_eq!(open(&folder).damages(), []);
    }
}

#[test]
fn a_damaged_file_is_put_aside_and_what_is_sound_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    two_records(&folder);
    let path = folder.path().join("records/1.sqlite");
    let whole = std::fs::read(&path).unwrap();
    for place in (16..100).step_by(3).chain((100..whole.len()).step_by(499)) {
        let mut damaged = whole.clone();
        damaged[place] ^= 0x55;
        std::fs::write(&path, damaged).unwrap();
        let store = open(&folder);
        drop(store.queue("work").unwrap());
        for (key, content) in [("a", vec![1; 5000]), ("b", vec![2])] {
            assert!(store.get("point", key).is_none_or(|found| found == content), "byte {place}");
            store.put("point", key, content).unwrap();
        }
        drop(store);
        let healed = open(&folder);
        drop(healed.queue("work").unwrap());
        assert!(healed.get("point", "a").is_some() && healed.damages().is_empty(), "byte {place}");
    }
    for length in [0, 1, 100, whole.len() / 2] {
        std::fs::write(&path, &whole[..length]).unwrap();
        let store = open(&folder);
        drop(store.queue("work").unwrap());
        assert!(store.get("point", "a").is_none() && (length < 2 || !store.damages().is_empty()), "{length}");
    }
}

#[test]
fn a_copy_takes_what_is_sound_and_stops_at_contradictions() {
    let one = tempfile::tempdir().unwrap();
    let two = tempfile::tempdir().unwrap();
    let into = tempfile::tempdir().unwrap();
    two_records(&one);
    two_records(&two);
    tamper(&one, "update records set content = x'03' where key = 'a'");
    let merged = open(&into);
    let equal = |_: &str, a: &[u8], b: &[u8]| a == b;
    for shard in [&one, &two] {
        let from = open(shard);
        assert_eq!(merged.adopt(&from, &[], &equal).unwrap(), None);
        assert_eq!(from.damages().len(), usize::from(std::ptr::eq(shard, &one)));
    }
    assert_eq!(merged.get("point", "a"), Some(vec![1; 5000]));
    let other = tempfile::tempdir().unwrap();
    open(&other).put("point", "c", vec![4]).unwrap();
    open(&other).put("point", "b", vec![3]).unwrap();
    let [here, there] = merged.adopt(&open(&other), &["point"], &equal).unwrap().unwrap();
    assert_eq!((here.content, there.key.as_str()), (vec![2], "b"));
    assert_eq!(merged.get("point", "c"), None, "all or nothing");
}

/// Two workers computed the same record before either saw the other's: one intact copy is enough.
#[test]
fn a_sound_copy_in_another_file_is_found_behind_a_damaged_one() {
    for damaged in ["1", "2"] {
        let folder = tempfile::tempdir().unwrap();
        let one = open(&folder);
        let two = open(&folder);
        [&one, &two].into_iter().for_each(|store| store.put("point", "a", vec![1]).unwrap());
        drop((one, two));
        let path = folder.path().join(format!("records/{damaged}.sqlite"));
        rusqlite::Connection::open(path).unwrap().execute("update records set content = x'03'", []).unwrap();
        assert_eq!(open(&folder).get("point", "a"), Some(vec![1]), "file {damaged} damaged");
    }
}

/// A scan from the first record ends at a damaged page; what lies behind is read from the last one.
#[test]
fn records_on_both_sides_of_a_damaged_page_are_saved() {
    let folder = tempfile::tempdir().unwrap();
    let store = open(&folder);
    (0..60_u8).for_each(|i| store.put("point", &i.to_string(), vec![i; 1000]).unwrap());
    drop(store);
    let path = folder.path().join("records/1.sqlite");
    let mut bytes = std::fs::read(&path).unwrap();
    let place = bytes.windows(1000).position(|part| part.iter().all(|&b| b == 30)).unwrap();
    let page = place / 4096 * 4096;
    bytes[page..page + 4096].fill(0xa5);
    std::fs::write(&path, bytes).unwrap();
    let store = open(&folder);
    drop(store.queue("work").unwrap());
    let saved = (0..60_u8).filter(|&i| store.get("point", &i.to_string()) == Some(vec![i; 1000])).count();
    // A page of 4096 bytes holds three of these records at most.
    assert!((57..60).contains(&saved), "{saved} of 60 records");
}
