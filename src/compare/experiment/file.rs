//! A comparison as written, read and checked.

use crate::compare::error::{CompareError, applications};
use crate::compare::matrix::MatrixTable;
use crate::compare::subject::{Packed, StudyWritten};
use crate::input::fault::StudyError;
use crate::input::limits;
use crate::input::read::read as read_tree;
use crate::input::tree::parse_toml;
use crate::numerics::files;
use crate::solve::{Goal, Registry, Solver, SolverChoice};
use crate::wave::Scheme;
use crate::wave::grid::MOST_POINTS;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A comparison as written (TOML). Lengths in the units of the key names; indices as [re, im].
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparisonFile {
    /// Title, for people.
    #[serde(default)]
    pub title: String,
    /// The study whose first packing the strategies are compared on: its file (relative to this one), or a table
    /// `[study]` with a whole study.
    #[schemars(example = &"yellow.toml")]
    pub study: Option<StudyWritten>,
    /// A case file (relative to this file), instead of `study`.
    #[schemars(example = &"case.json")]
    pub case: Option<PathBuf>,
    /// Wavelength of the comparison, nm; the middle one of the study's when left out.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 550)]
    pub wavelength_nm: Option<f64>,
    /// Polar angle of the comparison, degrees; the first of the study's when left out.
    #[schemars(transform = limits::POLAR_DEG.mark(), example = 0)]
    pub polar_deg: Option<f64>,
    /// Many contrasts and periods of the study instead of many grids.
    pub matrix: Option<MatrixTable>,
    /// Names of the strategies; all of the registry but those for tiny grids unless told.
    #[serde(default)]
    #[schemars(schema_with = "strategy_names", example = ["krylov", "bicgstab"])]
    pub strategies: Option<Vec<String>>,
    /// Discretisations along z to compare.
    #[serde(default = "default_schemes")]
    #[schemars(length(min = 1))]
    pub schemes: Vec<Scheme>,
    /// Grids to compare.
    #[serde(default = "default_resolutions")]
    #[schemars(length(min = 1))]
    pub resolutions: Vec<Points>,
    /// Keeps absorption in ⟨k²⟩; relaxation is then left out. Off by default: all strategies share one problem.
    #[serde(default)]
    pub absorbing_mean: bool,
    /// Lets ⟨k²⟩ follow the composition along z, or takes one for the whole layer.
    #[serde(default = "default_true")]
    pub mean_depends_on_z: bool,
    /// Residual to reach, and the most operator applications.
    #[serde(default)]
    pub goal: Goal,
    /// Solves of each row; the median of their seconds is kept.
    #[serde(default = "default_repeats")]
    #[schemars(range(min = 1))]
    pub repeats: usize,
    /// Where the comparison was read.
    #[serde(skip)]
    pub origin: PathBuf,
}

/// Lists of built-in strategies.
fn strategy_names(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": "array", "items": { "enum": SolverChoice::NAMES }, "minItems": 1 })
}

/// One resolution of the list.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Points {
    /// Points along x and y of one period.
    pub points: usize,
    /// Cells along z.
    pub cells: usize,
}

impl Default for ComparisonFile {
    fn default() -> Self {
        Self {
            title: String::new(),
            study: None,
            case: None,
            wavelength_nm: None,
            polar_deg: None,
            matrix: None,
            strategies: None,
            schemes: default_schemes(),
            resolutions: default_resolutions(),
            absorbing_mean: false,
            mean_depends_on_z: true,
            goal: Goal::default(),
            repeats: default_repeats(),
            origin: PathBuf::new(),
        }
    }
}

fn default_schemes() -> Vec<Scheme> {
    vec![Scheme::Cubic, Scheme::SecondDifference]
}

fn default_resolutions() -> Vec<Points> {
    [(9, 8), (15, 12), (25, 20)].map(|(points, cells)| Points { points, cells }).to_vec()
}

fn default_true() -> bool {
    true
}

fn default_repeats() -> usize {
    3
}

/// Whether the file is a study rather than a comparison: it has none of a comparison's own keys.
fn is_study(table: &toml::Table) -> bool {
    let own = ["study", "case", "matrix", "strategies", "schemes", "resolutions", "goal", "repeats"];
    table.contains_key("layer") && !own.iter().any(|key| table.contains_key(*key))
}

impl ComparisonFile {
    /// Reads a comparison; a study or a plain case file is compared with the default lists.
    pub fn read(path: &Path) -> Result<ComparisonFile, CompareError> {
        let read =
            |message: std::io::Error| CompareError::Read { path: path.into(), message: message.to_string() };
        let (origin, name) = (path.to_owned(), path.file_name().map(PathBuf::from));
        if path.extension().is_some_and(|e| e == "json") {
            return Ok(ComparisonFile { case: name, origin, ..ComparisonFile::default() });
        }
        let text = files::read_text(path, files::STUDY).map_err(read)?;
        let table = parse_toml(&text).map_err(|fault| fault.in_file(path, &text))?;
        if is_study(&table) {
            let study = name.map(StudyWritten::File);
            return Ok(ComparisonFile { study, origin, ..ComparisonFile::default() });
        }
        let values = |faults| StudyError::Values { path: path.into(), text: text.clone(), faults };
        Ok(ComparisonFile { origin, ..read_tree(table.into()).map_err(values)? })
    }

    /// The strategies to compare, each of them known.
    pub(super) fn strategies(
        &self,
        registry: &Registry,
    ) -> Result<Vec<(String, Box<dyn Solver>)>, CompareError> {
        let by_name = |name: &String| Ok((name.clone(), registry.build(name)?));
        match &self.strategies {
            Some(names) => names.iter().map(by_name).collect(),
            None => {
                let all = registry.entries().iter().map(|e| (e.name().to_string(), e.build()));
                Ok(all.filter(|(_, solver)| solver.most_unknowns().is_none()).collect())
            }
        }
    }

    pub(super) fn check(&self) -> Result<(), CompareError> {
        let empty = [
            ("strategies", self.strategies.as_ref().is_some_and(Vec::is_empty)),
            ("schemes", self.schemes.is_empty()),
            ("resolutions", self.resolutions.is_empty()),
            ("repeats", self.repeats == 0),
        ];
        if let Some((field, _)) = empty.into_iter().find(|(_, e)| *e) {
            let allowed = "at least one".to_string();
            return Err(CompareError::Field {
                field: field.into(),
                found: "empty".into(),
                allowed,
                remedy: "add one or leave it out",
            });
        }
        if self.study.is_some() == self.case.is_some() {
            return Err(CompareError::Field {
                field: "geometry".into(),
                found: if self.study.is_some() { "both `study` and `case`" } else { "nothing" }.into(),
                allowed: "exactly one of `study` and `case`".into(),
                remedy: "name a study file or a case file, or write a whole study as [study]",
            });
        }
        self.check_numbers()
    }

    /// Refuses what no solve could do.
    fn check_numbers(&self) -> Result<(), CompareError> {
        let sides = self.resolutions.iter().enumerate();
        let sides = sides.flat_map(|(k, grid)| [(k, "points", grid.points), (k, "cells", grid.cells)]);
        let mut outside = sides.filter(|side| !(1..=MOST_POINTS).contains(&side.2));
        if let Some((k, side, count)) = outside.next() {
            let (field, found) = (format!("resolutions[{k}].{side}"), count.to_string());
            let allowed = format!("whole numbers from 1 to {MOST_POINTS}");
            let remedy = "a wavelength in the binder takes some 10 points and 8 cells";
            return Err(CompareError::Field { field, found, allowed, remedy });
        }
        let Goal { tolerance, max_applications } = self.goal;
        if !limits::TOLERANCE.holds(tolerance) {
            let remedy = "1e-6 tells strategies apart, and costs little";
            return Err(CompareError::number("goal.tolerance", tolerance, limits::TOLERANCE, remedy));
        }
        applications("goal.max_applications", max_applications)
    }

    /// The study, whichever way it is written; none for a case.
    pub(super) fn packed(&self) -> Result<Option<Packed>, CompareError> {
        let Some(study) = &self.study else { return Ok(None) };
        Ok(Some(Packed::read(study, &self.origin)?.lit(self.wavelength_nm, self.polar_deg)))
    }

    pub(super) fn folder(&self) -> &Path {
        self.origin.parent().unwrap_or(Path::new(""))
    }
}
