//! Method comparison: strategies × resolutions × discretisations on one geometry, side by side.

pub use super::error::CompareError;
pub use super::layer::PackedLayer;
use super::pages::{Comparison, Row};
use super::subject::{Packed, StudyWritten};
use crate::input::case::Case;
use crate::input::fault::StudyError;
use crate::input::limits;
use crate::input::read::read as read_tree;
use crate::input::tree::parse_toml;
use crate::numerics::files;
use crate::numerics::written::older_place;
use crate::run::memory;
use crate::solve::accuracy::{AccuracyError, Task, error_estimate, largest_difference};
use crate::solve::{Coverages, Gmres, Goal, Registry, Silent, SolveError, Solver, SolverChoice, Watch};
use crate::wave::{FarField, Mean, Physical, Problem, Resolution, Scene, Scheme, TotalErrors};
use num_complex::Complex64;
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
    /// Older form of `study`: equal spheres.
    #[schemars(transform = older_place)]
    pub layer: Option<PackedLayer>,
    /// Many contrasts and periods of the study instead of many grids.
    pub matrix: Option<super::matrix::MatrixTable>,
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
            layer: None,
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
    let short = table.get("layer").is_some_and(|layer| layer.get("wavelength_um").is_some());
    table.contains_key("layer") && !short && !own.iter().any(|key| table.contains_key(*key))
}

/// What a comparison is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Bodies of the geometry (of the matrix's own study).
    pub bodies: usize,
    /// Solves, but for those of the search for a grid.
    pub rows: usize,
}

/// The geometry, and the reference amplitudes if its file has them.
struct Subject {
    case: Case,
    known: Option<serde_json::Value>,
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
    fn strategies(&self, registry: &Registry) -> Result<Vec<(String, Box<dyn Solver>)>, CompareError> {
        let by_name = |name: &String| Ok((name.clone(), registry.build(name)?));
        match &self.strategies {
            Some(names) => names.iter().map(by_name).collect(),
            None => {
                let all = registry.entries().iter().map(|e| (e.name().to_string(), e.build()));
                Ok(all.filter(|(_, solver)| solver.most_unknowns().is_none()).collect())
            }
        }
    }

    fn check(&self) -> Result<(), CompareError> {
        let empty = [
            ("strategies", self.strategies.as_ref().is_some_and(Vec::is_empty)),
            ("schemes", self.schemes.is_empty()),
            ("resolutions", self.resolutions.is_empty()),
            ("repeats", self.repeats == 0),
        ];
        if let Some((field, _)) = empty.into_iter().find(|(_, e)| *e) {
            let allowed = "at least one".to_string();
            return Err(CompareError::Field {
                field,
                found: "empty".into(),
                allowed,
                remedy: "add one or leave it out",
            });
        }
        let given = [self.study.is_some(), self.case.is_some(), self.layer.is_some()];
        let count = given.into_iter().filter(|given| *given).count();
        if count != 1 {
            return Err(CompareError::Field {
                field: "geometry",
                found: format!("given {count} times"),
                allowed: "exactly one of `study`, `case` and `[layer]`".into(),
                remedy: "name a study file or a case file, or write a whole study as [study]",
            });
        }
        Ok(())
    }

    /// The study, whichever way it is written; none for a case.
    fn packed(&self) -> Result<Option<Packed>, CompareError> {
        let values = |faults| StudyError::Values { path: self.origin.clone(), text: String::new(), faults };
        let packed = match (&self.study, &self.layer) {
            (Some(study), _) => Packed::read(study, self.folder())?,
            (None, Some(layer)) => layer.packed().map_err(values)?,
            (None, None) => return Ok(None),
        };
        Ok(Some(packed.lit(self.wavelength_nm, self.polar_deg)))
    }

    fn folder(&self) -> &Path {
        self.origin.parent().unwrap_or(Path::new(""))
    }

    /// Rows of the comparison, or of its matrix, without a solve: the geometry is packed, and everything is checked.
    ///
    /// # Errors
    /// As [`ComparisonFile::run`], but those of solves.
    pub fn plan(&self, registry: &Registry) -> Result<Plan, CompareError> {
        self.check()?;
        let strategies = self.strategies(registry)?.len();
        let Subject { case, .. } = self.subject()?;
        let bodies = case.scene.bodies.len();
        let Some(matrix) = &self.matrix else {
            return Ok(Plan { bodies, rows: strategies * self.schemes.len() * self.resolutions.len() });
        };
        matrix.check()?;
        Ok(Plan { bodies, rows: strategies * matrix.pigments.len() * matrix.periods_um.len() })
    }

    fn subject(&self) -> Result<Subject, CompareError> {
        if let Some(path) = &self.case {
            let path = self.folder().join(path);
            let case = Case::read(&path)?;
            let json = files::read_text(&path, files::CASE).ok().and_then(|t| serde_json::from_str(&t).ok());
            let known =
                json.and_then(|v: serde_json::Value| v.get("outputs").and_then(|o| o.get("orders")).cloned());
            return Ok(Subject { case, known });
        }
        let packed = self.packed()?.expect("checked: a study, a case or a layer");
        Ok(Subject { case: packed.case()?, known: None })
    }

    /// Runs the matrix, if one is asked for; `watch` sees each solve's steps and can stop it.
    ///
    /// # Errors
    /// Unknown strategies; layers that cannot be packed; cases that the reference strategy cannot solve; Ctrl-C.
    pub fn run_matrix(
        &self,
        registry: &Registry,
        watch: &mut dyn Watch,
        told: impl FnMut(&super::matrix::Cell),
    ) -> Result<Option<super::matrix::Matrix>, CompareError> {
        let Some(matrix) = &self.matrix else { return Ok(None) };
        self.check()?;
        let Some(packed) = self.packed()? else {
            let (found, allowed) = ("a case".into(), "a study, whose period and index vary".into());
            let remedy = "name a study file, or write a whole study as [study]";
            return Err(CompareError::Field { field: "matrix", found, allowed, remedy });
        };
        let strategies = self.strategies(registry)?;
        let cells = matrix.run(&packed, &strategies, watch, told)?;
        let names = strategies.into_iter().map(|(name, _)| name.to_string()).collect();
        let (title, accuracy) = (self.title.clone(), matrix.accuracy);
        Ok(Some(super::matrix::Matrix { title, accuracy, strategies: names, cells }))
    }

    /// Runs every row with the strategies of `registry`; `watch` sees each solve's steps and can stop the comparison.
    pub fn run(
        &self,
        registry: &Registry,
        watch: &mut dyn Watch,
        mut told: impl FnMut(&Row),
    ) -> Result<Comparison, CompareError> {
        self.check()?;
        let strategies = self.strategies(registry)?;
        let subject = self.subject()?;
        let (truth, reference) = self.reference(&subject)?;
        let coverages = Coverages::of(&subject.case.scene);
        let mut rows = Vec::new();
        for scheme in &self.schemes {
            for points in &self.resolutions {
                let resolution = resolution(&subject.case.scene, *points, *scheme);
                for (name, solver) in &strategies {
                    let row =
                        self.row((name, &**solver), resolution, &subject.case, &coverages, &truth, watch)?;
                    told(&row);
                    rows.push(row);
                }
            }
        }
        Ok(Comparison { title: self.title.clone(), reference, rows })
    }

    /// Amplitudes to compare with: those of the case file, or a solve at half as many points and cells again.
    fn reference(&self, subject: &Subject) -> Result<(FarField, String), CompareError> {
        let most = |f: fn(&Points) -> usize| self.resolutions.iter().map(f).max().unwrap_or(1);
        let finest = Points { points: 3 * most(|p| p.points) / 2, cells: 3 * most(|p| p.cells) / 2 };
        let resolution = resolution(&subject.case.scene, finest, Scheme::Cubic);
        let case = &subject.case;
        let task = Task {
            coverages: &Coverages::of(&case.scene),
            media: &case.media,
            incidence: &case.incidence,
            mean: Mean::default(),
            scheme: Scheme::Cubic,
            solver: &Gmres::default(),
            goal: Goal { tolerance: 1e-9, ..Goal::default() },
            memory: memory::usable(),
        };
        let (problem, solution, _) = task.solve(resolution, &mut Silent)?;
        let errors = TotalErrors::of_totals([1.0; 2], solution.account.residual);
        let mut far = Physical::judge(problem.far_field(&solution.field), errors)
            .map_err(AccuracyError::Unphysical)?
            .into_inner();
        if let Some(known) = subject.known.as_ref().and_then(|k| k.as_array()) {
            far.orders.retain_mut(|o| replace(o, known));
            return Ok((far, "the case file's own amplitudes".into()));
        }
        let name = format!(
            "krylov on {} × {} points and {} cubic cells",
            resolution.nx, resolution.ny, resolution.cells
        );
        Ok((far, name))
    }

    /// One line: a result, or the reason why there is none. Errors: the user stopped it.
    fn row(
        &self,
        (name, solver): (&str, &dyn Solver),
        resolution: Resolution,
        case: &Case,
        coverages: &Coverages,
        truth: &FarField,
        watch: &mut dyn Watch,
    ) -> Result<Row, CompareError> {
        let task = Task {
            coverages,
            media: &case.media,
            incidence: &case.incidence,
            mean: Mean { depends_on_z: self.mean_depends_on_z, absorbing: self.absorbing_mean },
            scheme: resolution.scheme,
            solver,
            goal: self.goal,
            memory: memory::usable(),
        };
        let mut row = Row::new(name, resolution);
        match self.measure(&task, resolution, truth, &mut row, watch) {
            Err(AccuracyError::Solve(cancelled @ SolveError::Cancelled { .. })) => Err(cancelled.into()),
            Err(error) => {
                let account = match &error {
                    AccuracyError::Solve(error) => error.account().cloned(),
                    _ => None,
                };
                account.iter().for_each(|account| row.take(account));
                row.outcome = error.to_string();
                Ok(row)
            }
            Ok(()) => Ok(row),
        }
    }

    /// Solves as often as was asked, and judges the first result.
    fn measure(
        &self,
        task: &Task,
        resolution: Resolution,
        truth: &FarField,
        row: &mut Row,
        watch: &mut dyn Watch,
    ) -> Result<(), AccuracyError> {
        let solver = task.admitted(resolution)?;
        let coverage = task.coverages.at(resolution)?;
        let problem = Problem::new(&coverage, task.media, task.incidence, task.mean)?;
        (row.unknowns, row.bytes) = (problem.unknowns(), problem.bytes());
        let solution = solver.solver().solve(&problem, task.goal, watch)?;
        row.take(&solution.account);
        let far = problem.far_field(&solution.field);
        let error = largest_difference(truth, &far);
        let residual = solution.account.residual;
        row.error_estimate = match task.estimate_parts((&problem, &solution), &far, watch) {
            Err(stopped @ AccuracyError::Solve(SolveError::Cancelled { .. })) => return Err(stopped),
            parts => parts.ok().map(|parts| error_estimate(parts, residual)),
        };
        let errors = TotalErrors::of_amplitudes(row.error_estimate.unwrap_or(error), residual);
        Physical::judge(far, errors)?;
        let mut seconds = vec![solution.account.seconds];
        for _ in 1..self.repeats {
            seconds.push(solver.solver().solve(&problem, task.goal, watch)?.account.seconds);
        }
        seconds.sort_by(f64::total_cmp);
        row.seconds = seconds[seconds.len() / 2];
        row.error = Some(error);
        row.outcome = "converged".into();
        Ok(())
    }
}

/// Puts a reference order's amplitudes in place; false where the reference does not list it.
fn replace(order: &mut crate::wave::Order, known: &[serde_json::Value]) -> bool {
    let same = |k: &&serde_json::Value| {
        k["m"] == order.m && (k["n"] == order.n || (k["n"].is_null() && order.n == 0))
    };
    let Some(found) = known.iter().find(same) else { return false };
    let amplitude = |key: &str| Some(Complex64::new(found[key][0].as_f64()?, found[key][1].as_f64()?));
    order.reflected = amplitude("R").unwrap_or(order.reflected);
    order.transmitted = amplitude("T").unwrap_or(order.transmitted);
    true
}

fn resolution(scene: &Scene, points: Points, scheme: Scheme) -> Resolution {
    let nx = if scene.uniform_in_plane() { 1 } else { points.points };
    let ny = if scene.uniform_in_y() { 1 } else { points.points };
    Resolution { nx, ny, cells: points.cells, scheme }
}
