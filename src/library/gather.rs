//! From folders of finished studies and from other libraries to one library.

use crate::evaluate::composed::library::Library;
use crate::evaluate::evaluated::FinishedSolves;
use crate::evaluate::manifest::program;
use crate::export::folder::StoredFolder;
use crate::input::study::Study;
use std::path::{Path, PathBuf};

/// The folder of a sweep's variants.
const VARIANTS: &str = "variants";
/// What a run that was asked for its results has.
const RESULTS: &str = "results.json";
/// The library of a run that was asked for its plates alone.
pub const OWN_LIBRARY: &str = "library.json";

/// Why there is no library.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}", path = .path.display())]
pub struct GatherError {
    /// The folder or file.
    pub path: PathBuf,
    /// The reason.
    pub reason: String,
}

/// A library, and what was left out of it.
#[derive(Clone, Debug)]
pub struct GatheredLibrary {
    /// The plates.
    pub library: Library,
    /// Layers of the sources that are no plates, in words, each once.
    pub left_out: Vec<String>,
}

/// One library of all plates: `sources` are folders of `inkwave run`, of sweeps, and libraries.
///
/// # Errors
/// A source that cannot be read or holds no plates, and sources that do not fit together.
pub fn gather(sources: &[PathBuf]) -> Result<GatheredLibrary, GatherError> {
    let mut all: Option<Library> = None;
    let mut left_out = Vec::new();
    for source in sources {
        for (path, GatheredLibrary { library, left_out: more }) in read(source)? {
            match &mut all {
                None => all = Some(library),
                Some(all) => all.merge(library).map_err(|reason| GatherError { path, reason })?,
            }
            left_out.extend(more);
        }
    }
    left_out.sort();
    left_out.dedup();
    let library = all.filter(|library| !library.plates.is_empty()).ok_or_else(|| GatherError {
        path: sources.first().cloned().unwrap_or_default(),
        reason: "found no layer with grains; allowed are stacks with one or more".to_owned(),
    })?;
    Ok(GatheredLibrary { library, left_out })
}

/// A library of which nothing is known that was left out.
fn whole(library: Library) -> GatheredLibrary {
    GatheredLibrary { library, left_out: Vec::new() }
}

/// A library from its file.
///
/// # Errors
/// A file that cannot be read, and what [`Library::read`] refuses.
pub fn from_file(path: &Path) -> Result<Library, GatherError> {
    let failed = |reason: String| GatherError { path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(|error| failed(error.to_string()))?;
    Library::read(&text).map_err(failed)
}

/// The libraries of one source, with the places where they are.
fn read(source: &Path) -> Result<Vec<(PathBuf, GatheredLibrary)>, GatherError> {
    if source.is_file() {
        return Ok(vec![(source.to_owned(), whole(from_file(source)?))]);
    }
    let own = source.join(OWN_LIBRARY);
    if own.is_file() && !source.join(RESULTS).is_file() {
        return Ok(vec![(own.clone(), whole(from_file(&own)?))]);
    }
    let variants = source.join(VARIANTS);
    if !variants.is_dir() {
        return Ok(vec![(source.to_owned(), of_folder(source)?)]);
    }
    let failed = |reason: String| GatherError { path: variants.clone(), reason };
    let entries = std::fs::read_dir(&variants).map_err(|error| failed(error.to_string()))?;
    let mut folders = Vec::new();
    for entry in entries {
        folders.push(entry.map_err(|error| failed(error.to_string()))?.path());
    }
    folders.sort();
    folders.retain(|folder| folder.is_dir());
    folders.into_iter().map(|folder| Ok((folder.clone(), of_folder(&folder)?))).collect()
}

/// The plates of solves that are finished.
///
/// # Errors
/// Layers without complete realisations.
pub fn of_solves(study: &Study, solved: &FinishedSolves) -> Result<Library, String> {
    Library::of_stack(study, solved.slabs(), &program())
}

/// The plates of one finished study.
fn of_folder(path: &Path) -> Result<GatheredLibrary, GatherError> {
    let failed = |reason: String| GatherError { path: path.to_owned(), reason };
    let stored = StoredFolder::read(path).map_err(|error| failed(error.to_string()))?;
    match &stored {
        StoredFolder::Composed(slabs) => {
            let (study, solved) = slabs.portions();
            let library = Library::of_stack(study, solved, &program()).map_err(failed)?;
            Ok(GatheredLibrary { library, left_out: Vec::from_iter(study.layers_without_plates()) })
        }
        StoredFolder::Whole(_) => Err(failed(
            "a layer that was solved with the air around it, from directions of its own: it holds no plates. Solve it as a plate: \
             inkwave run STUDY.toml --library; or write it as [[layer]] with [stack.composed] joint_index = 1.5 (or the index of \
             its binder), and run it again"
                .to_owned(),
        )),
    }
}
