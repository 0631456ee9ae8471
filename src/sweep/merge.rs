//! Merges the stores of several shards into one folder.

use crate::run::Stores;
use crate::run::realisation::all_point_keys;
use crate::run::resolve::{Resolved, kept};
use crate::store::database::Database;
use crate::store::folder::{FolderError, OutputFolder};
use crate::store::record::{FailureRecord, PointRecord};
use crate::store::seal::{Damage, Sealed};
use crate::store::store::Record;
use crate::store::{PackingRecord, same};
use crate::sweep::Sweep;
use crate::sweep::definition::folder;
use crate::sweep::definition::folder::OpenError;
use crate::work::variant::solved_for;
use std::io;
use std::path::{Path, PathBuf};

/// Why shards cannot be merged.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// A folder holds no shard of a sweep.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The output folder cannot be written.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The shards belong to different sweeps.
    #[error("{0}")]
    OtherSweep(String),
    /// Two intact records of the same inputs contain different numbers: the solve, packing or grid,
    /// the later shard, and the programs that computed them.
    #[error("{0}")]
    Contradiction(String),
    /// A store cannot be read or written: the shard, and the system's error message.
    #[error("cannot read or copy the records of {0}")]
    Copy(String),
}

/// Result of a merge.
#[derive(Debug)]
pub struct Merged {
    /// The sweep that the shards belong to.
    pub sweep: Sweep,
    /// Damaged records and files without an intact copy in another shard.
    pub damages: Vec<Damage>,
    /// Number of damaged records replaced by an intact copy from another shard.
    pub healed: usize,
}

/// Kinds of records that are merged; pages are made anew.
const MERGED: [&str; 4] = [PointRecord::KIND, PackingRecord::KIND, Resolved::KIND, FailureRecord::KIND];

/// Copies the intact records of all shards into `folder`.
///
/// # Errors
/// The shards belong to different sweeps, intact records of the same inputs differ, or files cannot
/// be read or written.
pub fn merge(shards: &[PathBuf], folder: &OutputFolder) -> Result<Merged, MergeError> {
    let first = shards.first().map_or(Path::new(""), PathBuf::as_path);
    let sweep = folder::read(first)?;
    shards[1..].iter().try_for_each(|other| refuse_other_sweep(&sweep, first, other))?;
    folder.begin()?;
    folder::write(&sweep, folder)?;
    let failed = |shard: &Path| {
        let shard = shard.display().to_string();
        move |error: io::Error| MergeError::Copy(format!("{shard}: {error}"))
    };
    let into = Database::open(folder.path()).map_err(failed(folder.path()))?;
    let mut of_shards = Vec::new();
    for shard in shards {
        let from = Database::open(shard).map_err(failed(shard))?;
        if let Some([one, other]) = into.adopt(&from, &MERGED, &same_numbers).map_err(failed(shard))? {
            let what = describe(&sweep, folder, &other);
            let builds = format!("{} and {}", one.program, other.program);
            let differs = "differs from the intact record of the same inputs in another shard";
            let shard = shard.display();
            return Err(MergeError::Contradiction(format!("{what} in {shard} {differs} ({builds})")));
        }
        of_shards.extend(from.damages());
    }
    let mut damages = of_shards.clone();
    damages.retain(|damage| !is_healed(damage, &into));
    Ok(Merged { sweep, healed: of_shards.len() - damages.len(), damages })
}

fn refuse_other_sweep(sweep: &Sweep, first: &Path, shard: &Path) -> Result<(), MergeError> {
    let other = folder::read(shard)?;
    // Studies name their tables by checksum: equal texts read equal tables.
    if other.outline != sweep.outline || other.texts != sweep.texts {
        let (first, other) = (first.display(), shard.display());
        return Err(MergeError::OtherSweep(format!("{other} belongs to another sweep than {first}")));
    }
    Ok(())
}

fn is_healed(damage: &Damage, into: &Database) -> bool {
    match damage {
        Damage::Record { kind, key, .. } => into.get(kind, key).is_some(),
        Damage::File { .. } => false,
    }
}

/// Whether two records of a kind contain the same numbers, regardless of program and computing
/// time.
fn same_numbers(kind: &str, one: &[u8], other: &[u8]) -> bool {
    match kind {
        PointRecord::KIND => same::<PointRecord>(one, other),
        PackingRecord::KIND => same::<PackingRecord>(one, other),
        Resolved::KIND => same::<Resolved>(one, other),
        FailureRecord::KIND => true,
        _ => one == other,
    }
}

/// Describes a record: variant, realisation, wavelength and angle of a solve; kind and hash of
/// anything else.
fn describe(sweep: &Sweep, folder: &OutputFolder, row: &Sealed) -> String {
    let hash = format!("{} {}", row.kind, row.key);
    let Ok(stores) = Stores::open(folder) else { return hash };
    for variant in solved_for(&sweep.variants).iter().filter(|_| row.kind == PointRecord::KIND) {
        let Some(resolved) = kept(&variant.study, &stores.grids) else { continue };
        let realisations = 0..variant.study.realisations;
        let mut points = realisations.flat_map(|r| all_point_keys(&variant.study, &resolved, r));
        if let Some((point, _)) = points.find(|(_, key)| key.as_str() == row.key) {
            let nm = 1e3 * point.incidence.wavelength_um;
            let deg = point.incidence.polar_deg;
            let realisation = point.realisation + 1;
            return format!("{}, realisation {realisation}, {nm:.0} nm, {deg:.1}° ({hash})", variant.name);
        }
    }
    hash
}
