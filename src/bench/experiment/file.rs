//! A comparison as written, with the axes of a matrix, read and checked; and keys of the input
//! files that have no effect on a comparison, for a note to the user.

use super::NamedStrategy;
use crate::error::{CompareError, CompareResult};
use crate::external::ExternalTable;
use crate::input::fault::{Fault, Faults};
use crate::input::limits;
use crate::input::load::read_file;
use crate::input::locate::steps;
use crate::input::tree::Node;
use crate::input::wave_kind::WaveKind;
use crate::numerics::allowed::Whole;
use crate::row::Varied;
use crate::solve::{Goal, Registry, SolverChoice};
use crate::subject::{Packed, StudyWritten};
use crate::wave::MOST_POINTS;
use crate::wave::Scheme;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A comparison as written (TOML). Lengths in the units of the key names; indices as [re, im].
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ComparisonFile {
    /// Title of the page.
    pub title: String,
    /// The study whose first packing the strategies are compared on: its file (relative to this
    /// one), or a table `[study]` with a whole study.
    #[schemars(example = &"yellow.toml")]
    pub study: Option<StudyWritten>,
    /// A case file (relative to this file), instead of `study`.
    #[schemars(example = &"case.json")]
    pub case: Option<PathBuf>,
    /// Several case files, instead of `case`, each with rows and a chart of its own.
    pub cases: Vec<ComparedCase>,
    /// The equation: `scalar`, or `vector` for Maxwell's equations in s and p light.
    #[schemars(example = WaveKind::Scalar)]
    pub wave: WaveKind,
    /// Wavelength of the comparison, nm; the middle one of the study's when left out.
    #[schemars(transform = limits::WAVELENGTH_NM.mark(), example = 550)]
    pub wavelength_nm: Option<f64>,
    /// Polar angle of the comparison, degrees; the first of the study's when left out.
    #[schemars(transform = limits::POLAR_DEG.mark(), example = 0)]
    pub polar_deg: Option<f64>,
    /// Several pigments and periods of the study, each combination a case of its own.
    pub matrix: Option<MatrixTable>,
    /// Names of the strategies; all but those for tiny grids when left out.
    #[schemars(schema_with = "strategy_names", example = ("krylov", "bicgstab"))]
    pub strategies: Option<Vec<String>>,
    /// Discretisations along z to compare; when left out, cubic cells and second differences on
    /// listed grids, cubic cells on searched ones.
    #[schemars(length(min = 1), example = ("cubic",))]
    pub schemes: Option<Vec<Scheme>>,
    /// Grids to compare; when left out, three of them, or with `accuracy` or `[matrix]` the one
    /// that a search finds.
    #[schemars(length(min = 1))]
    pub resolutions: Option<Vec<Points>>,
    /// Largest amplitude error for which the grid of each case and scheme is searched, instead of
    /// `resolutions`; 1e-2 in a matrix without either.
    #[schemars(transform = limits::ACCURACY.mark(), example = 1e-2)]
    pub accuracy: Option<f64>,
    /// Whether ⟨k²⟩ includes the absorption. When left out: as suits each strategy, and the real
    /// mean as well where this makes a difference.
    #[schemars(example = true)]
    pub absorbing_mean: Option<bool>,
    /// Whether ⟨k²⟩ follows the composition along z, as it does when left out, or is one value for
    /// the whole layer.
    #[schemars(example = false)]
    pub mean_depends_on_z: Option<bool>,
    /// Residual to reach, and the most operator applications.
    pub goal: GoalWritten,
    /// Solves of each row, whose median time is reported; 3 when left out.
    #[schemars(range(min = 1), example = 3)]
    pub repeats: Option<usize>,
    /// Programs of other projects, rows beside those of the strategies.
    pub external: Vec<ExternalTable>,
    /// The file that the comparison was read from.
    #[serde(skip)]
    pub origin: PathBuf,
}

/// One of several case files.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedCase {
    /// The case file, relative to this file.
    #[schemars(example = &"film.json")]
    pub file: PathBuf,
    /// The case of this `id`, in a file that lists several as `cases`.
    #[schemars(example = &"sph02")]
    pub id: Option<String>,
    /// Name of the case on the page; its `id` or the file's when left out.
    #[schemars(example = &"film")]
    pub name: Option<String>,
    /// The equation of this case; that of the comparison when left out.
    pub wave: Option<WaveKind>,
}

/// Goal of every solve.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GoalWritten {
    /// Relative residual to reach; when left out, 1e-6 on listed grids and a hundredth of the
    /// accuracy on searched ones.
    #[schemars(transform = limits::TOLERANCE.mark(), example = 1e-6)]
    pub tolerance: Option<f64>,
    /// Most operator applications (each one inverse and one forward transform of every plane); 2000
    /// when left out.
    #[schemars(transform = limits::APPLICATIONS.mark(), example = 300)]
    pub max_applications: Option<usize>,
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
    #[schemars(range(min = 1, max = MOST_POINTS))]
    pub points: usize,
    /// Cells along z.
    #[schemars(range(min = 1, max = MOST_POINTS))]
    pub cells: usize,
}

/// Whether the file is a study rather than a comparison: it has none of a comparison's own keys.
fn is_study(table: &toml::Table) -> bool {
    let keys =
        ["study", "case", "cases", "matrix", "strategies", "schemes", "resolutions", "goal", "repeats"];
    table.contains_key("layer") && !keys.iter().any(|key| table.contains_key(*key))
}

fn is_empty<T>(list: &Option<Vec<T>>) -> bool {
    list.as_ref().is_some_and(Vec::is_empty)
}

fn has_twin<T: PartialEq>(list: &Option<Vec<T>>) -> bool {
    let list = list.as_deref().unwrap_or_default();
    list.iter().enumerate().any(|(k, entry)| list[..k].contains(entry))
}

impl ComparisonFile {
    /// Reads a comparison; a study or a plain case file is compared with the default lists.
    pub fn read(path: &Path) -> CompareResult<ComparisonFile> {
        let origin = path.to_owned();
        let name = path.file_name().map(PathBuf::from);
        if path.extension().is_some_and(|e| e == "json") {
            return Ok(ComparisonFile { case: name, origin, ..ComparisonFile::default() });
        }
        if is_study(&read_file(path)?.1) {
            let study = name.map(StudyWritten::File);
            return Ok(ComparisonFile { study, origin, ..ComparisonFile::default() });
        }
        Ok(ComparisonFile { origin, ..read_file(path)?.1 })
    }

    /// The strategies to compare, checked against the registry.
    pub(super) fn strategies(&self, registry: &Registry) -> CompareResult<Vec<NamedStrategy>> {
        match &self.strategies {
            Some(names) => {
                let named =
                    |name: &String| Ok(NamedStrategy { name: name.clone(), solver: registry.build(name)? });
                names.iter().map(named).collect()
            }
            None => {
                let all = registry.entries().iter();
                let all = all.map(|entry| NamedStrategy { name: entry.name.clone(), solver: entry.build() });
                Ok(all.filter(|strategy| strategy.solver.most_unknowns().is_none()).collect())
            }
        }
    }

    /// The grids listed; `None` if they are searched.
    pub(super) fn listed(&self) -> Option<Vec<Points>> {
        match self.searched() {
            Some(_) => None,
            None => Some(self.resolutions.clone().unwrap_or_else(|| {
                [(9, 8), (15, 12), (25, 20)].map(|(points, cells)| Points { points, cells }).to_vec()
            })),
        }
    }

    /// The accuracy that grids are searched for; `None` if they are listed.
    pub(super) fn searched(&self) -> Option<f64> {
        self.accuracy.or((self.matrix.is_some() && self.resolutions.is_none()).then_some(1e-2))
    }

    /// Discretisations along z; the vector wave has one only.
    pub(super) fn schemes(&self, wave: WaveKind) -> Vec<Scheme> {
        match wave {
            WaveKind::Scalar => self.schemes.clone().unwrap_or_else(|| match self.searched() {
                Some(_) => vec![Scheme::Cubic],
                None => vec![Scheme::Cubic, Scheme::SecondDifference],
            }),
            WaveKind::Vector => vec![Scheme::Quadratic],
        }
    }

    /// Goal of every solve.
    pub(super) fn goal(&self) -> Goal {
        let usual = Goal::default();
        let tolerance = self.searched().map_or(usual.tolerance, |accuracy| 1e-2 * accuracy);
        let max_applications = self.goal.max_applications.unwrap_or(usual.max_applications);
        Goal { tolerance: self.goal.tolerance.unwrap_or(tolerance), max_applications }
    }

    pub(super) fn check(&self) -> CompareResult {
        let mut faults = Faults::default();
        let given = [self.study.is_some(), self.case.is_some(), !self.cases.is_empty()];
        let given = given.into_iter().filter(|given| *given).count();
        let case = self.study.is_none();
        let vector = self.wave == WaveKind::Vector;
        let some = "at least one";
        let fill = "add one or leave it out";
        let leave = "leave one out";
        let one = "exactly one of `study`, `case` and `cases`";
        let name = "name a study file or case files, or write a whole study as [study]";
        let beside = "a value beside a case";
        let instead = "name a study instead, or leave it out";
        let one_scheme = "no schemes: the vector wave has one discretisation only";
        let varied = "a study, whose period and index vary";
        let (wave, direction) =
            ("a study: a case has its own wavelength", "a study: a case has its own direction");
        let grids = "one of `accuracy`, which searches the grids, and `resolutions`, which lists them";
        let both = self.accuracy.is_some() && self.resolutions.is_some();
        let rules = [
            (has_twin(&self.strategies), "strategies", "one of them twice", "each once", "remove the second"),
            (is_empty(&self.strategies), "strategies", "empty", some, fill),
            (is_empty(&self.schemes), "schemes", "empty", some, fill),
            (is_empty(&self.resolutions), "resolutions", "empty", some, fill),
            (self.repeats == Some(0), "repeats", "0", some, fill),
            (vector && self.schemes.is_some(), "schemes", "a list with wave = \"vector\"", one_scheme, leave),
            (given > 1, "geometry", "more than one of them", one, name),
            (given == 0, "geometry", "none of them", one, name),
            (case && self.matrix.is_some(), "matrix", beside, varied, instead),
            (case && self.wavelength_nm.is_some(), "wavelength_nm", beside, wave, instead),
            (case && self.polar_deg.is_some(), "polar_deg", beside, direction, instead),
            (both, "accuracy", "a value beside `resolutions`", grids, leave),
        ];
        for (_, field, found, allowed, remedy) in rules.into_iter().filter(|rule| rule.0) {
            faults.add(field, found, allowed, remedy);
        }
        for (i, case) in self.cases.iter().enumerate() {
            let name = case.name.as_deref().filter(|name| name.trim().is_empty());
            name.into_iter().for_each(|blank| faults.name(format!("cases[{i}].name"), blank, [], "case"));
        }
        self.matrix.iter().for_each(|matrix| matrix.check(&mut faults));
        let mut taken: Vec<String> = SolverChoice::NAMES.iter().map(|name| name.to_string()).collect();
        for program in &self.external {
            program.check(&taken, &mut faults);
            taken.push(program.name.clone());
        }
        self.check_numbers(&mut faults);
        if faults.0.is_empty() { Ok(()) } else { Err(CompareError::Fields(faults)) }
    }

    /// Refuses values that no solve could use.
    fn check_numbers(&self, faults: &mut Faults) {
        for (k, grid) in self.resolutions.iter().flatten().enumerate() {
            let remedy = "a wavelength in the binder needs about 10 points and 8 cells";
            for (side, count) in [("points", grid.points), ("cells", grid.cells)] {
                let name = format!("resolutions[{k}].{side}");
                faults.whole(&name, count, Whole::between(1, MOST_POINTS), remedy);
            }
        }
        let numbers = [
            ("accuracy", self.accuracy, limits::ACCURACY, "1e-2 is usual"),
            ("goal.tolerance", self.goal.tolerance, limits::TOLERANCE, "1e-6 tells strategies apart cheaply"),
        ];
        for (name, value, allowed, remedy) in numbers {
            value.into_iter().for_each(|value| faults.number(name, value, allowed, remedy));
        }
        let remedy = "a few hundred suffice for most inks";
        faults.whole("goal.max_applications", self.goal().max_applications, limits::APPLICATIONS, remedy);
    }

    /// The study under the comparison's light.
    ///
    /// # Errors
    /// Its faults; a case instead.
    pub(super) fn packed(&self) -> CompareResult<Packed> {
        let missing = || Fault::new("study", "missing", "a study", "name a study file or write [study]");
        let study = self.study.as_ref().ok_or_else(missing)?;
        Packed::read(study, &self.origin, self.wavelength_nm, self.polar_deg)
    }

    pub(super) fn folder(&self) -> &Path {
        self.origin.parent().unwrap_or(Path::new(""))
    }
}

/// The axes around the comparison's study: one case for each pigment and period.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixTable {
    /// Indices [n, κ] of the first pigment.
    #[schemars(length(min = 1), example = ((1.4, 0.1),))]
    pub pigments: Vec<[f64; 2]>,
    /// Periods of the square cell, µm.
    #[schemars(length(min = 1), example = (1.6,))]
    pub periods_um: Vec<f64>,
}

impl MatrixTable {
    /// Reports empty axes, and entries that no study could have.
    pub fn check(&self, faults: &mut Faults) {
        let empty = [("pigments", self.pigments.is_empty()), ("periods_um", self.periods_um.is_empty())];
        for (axis, _) in empty.into_iter().filter(|(_, empty)| *empty) {
            let remedy = "give pigments = [[1.4, 0.1]], periods_um = [1.6]";
            faults.add(format!("matrix.{axis}"), "empty", "at least one entry", remedy);
        }
        let remedy = "pigments are pairs [n, κ], periods some µm";
        for (k, [n, kappa]) in self.pigments.iter().enumerate() {
            faults.number(&format!("matrix.pigments[{k}][0]"), *n, limits::INDEX, remedy);
            faults.number(&format!("matrix.pigments[{k}][1]"), *kappa, limits::ABSORPTION, remedy);
        }
        for (k, um) in self.periods_um.iter().enumerate() {
            faults.number(&format!("matrix.periods_um[{k}]"), *um, limits::PERIOD_UM, remedy);
        }
    }

    /// All cases, period by period.
    pub(super) fn cases(&self) -> impl Iterator<Item = Varied> {
        self.periods_um
            .iter()
            .flat_map(|&period_um| self.pigments.iter().map(move |&pigment| Varied { pigment, period_um }))
    }
}

/// Study keys that a comparison replaces or does not use.
const OF_STUDIES: [&str; 16] = [
    "layer.composed",
    "paper",
    "resolution",
    "solver",
    "output",
    "colour",
    "compare",
    "realisations",
    "run.realisations",
    "run.target_delta_e",
    "run.target_colour",
    "light.step_nm",
    "light.per_realisation",
    "light.sampling",
    "angles.count",
    "angles.picture_max_deg",
];
/// Study keys that a matrix replaces.
const OF_VARIED_STUDIES: [&str; 3] = ["layer.cell", "layer.period_um", "pigment[0].index"];

impl ComparisonFile {
    /// Keys of the comparison's study that are written and have no effect; none where a file cannot
    /// be read again.
    pub fn unused(&self) -> Vec<String> {
        let varied = if self.matrix.is_some() { &OF_VARIED_STUDIES[..] } else { &[] };
        let of_study = OF_STUDIES.iter().chain(varied);
        let (table, before) = match &self.study {
            Some(StudyWritten::File(path)) => {
                let read = read_file::<toml::Table>(&self.folder().join(path));
                (read.map(|(_, table)| table).unwrap_or_default(), format!("{}: ", path.display()))
            }
            Some(StudyWritten::Table(table)) => (table.clone(), "study.".to_owned()),
            None => return Vec::new(),
        };
        let table = Node::from(table);
        of_study.filter(|key| has(&table, key)).map(|key| format!("{before}{key}")).collect()
    }
}

/// Whether a table has a key.
fn has(table: &Node, key: &str) -> bool {
    let inner = steps(key).try_fold(table, |here, step| match here {
        Node::List(items) => items.get(step.parse::<usize>().ok()?),
        _ => here.get(step),
    });
    inner.is_some()
}
