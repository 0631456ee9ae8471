//! The outputs of a comparison: tables, plots and a page; among them the cost of an accuracy, the
//! cheapest row of each strategy and program that reaches it.

use super::error::WriteError;
use super::external::protocol::ProgramDescription;
use super::machine::Machine;
use super::row::{Row, dash, grouped, mean_name};
use crate::draw::cell::{self, markdown, records};
use crate::draw::page::{made_by, svg_data, templates};
use crate::draw::seal::sealed;
use crate::solve::Goal;
use crate::store::folder::OutputFolder;
use crate::store::marker::shell_word;
use minijinja::{Value, context};
use std::path::PathBuf;

/// Tables and pages.
const TABLES: [&str; 5] = ["comparison.csv", "comparison.html", "machine.json", "residuals.csv", "README.md"];
/// Plots, without the numbers of those that come in several.
const PLOTS: [&str; 6] = [
    "applications",
    "residuals",
    "error_against_work",
    "error_against_seconds",
    "error_against_cpu_seconds",
    "error_against_solve_seconds",
];

/// A finished comparison.
pub struct Comparison {
    /// Title.
    pub title: String,
    /// The comparison's file.
    pub file: PathBuf,
    /// Reference of the errors, in words.
    pub reference: String,
    /// Name, wave and reference of each case where several files are compared.
    pub cases: Vec<[String; 3]>,
    /// Amplitude error that the grids were searched for; `None` if they were listed.
    pub accuracy: Option<f64>,
    /// Residual to reach, and the most operator applications.
    pub goal: Goal,
    /// Strategies in their order.
    pub strategies: Vec<String>,
    /// Names of the programs beside them.
    pub externals: Vec<String>,
    /// What these say of themselves, empty where they say nothing.
    pub programs: Vec<ProgramDescription>,
    /// All strategies of the registry, whose order determines the colours.
    pub registry: Vec<String>,
    /// What its seconds were measured on.
    pub machine: Machine,
    /// Number of rows planned; there are fewer if the comparison was stopped.
    pub asked: usize,
    /// Case by case, grid by grid, mean by mean, strategy by strategy.
    pub rows: Vec<Row>,
}

/// Whether a file name is one of those that a comparison writes.
fn is_of_a_comparison(name: &str) -> bool {
    let plot =
        name.strip_suffix(".svg").map(|stem| stem.trim_end_matches(|c: char| c == '-' || c.is_ascii_digit()));
    TABLES.contains(&name) || plot.is_some_and(|stem| PLOTS.contains(&stem))
}

impl Comparison {
    /// Writes `comparison.csv`, `machine.json`, the plots (SVG), `README.md` and a self-contained
    /// `comparison.html` into `folder` in place of an earlier comparison, each of them whole or not
    /// at all; of a single case `residuals.csv` too.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn write(&self, folder: &OutputFolder) -> Result<(), WriteError> {
        folder.remove_files(is_of_a_comparison)?;
        folder.write("comparison.csv", &records(self.rows.iter().map(Row::record))?)?;
        folder.write("machine.json", &serde_json::to_vec_pretty(&self.machine)?)?;
        if !self.has_cases() {
            folder.write("residuals.csv", &self.residuals()?)?;
        }
        let mut figures = Vec::new();
        let (plots, left_out) = self.plots();
        for (name, plot) in plots {
            let svg = plot.svg()?;
            folder.write(&name, svg.as_bytes())?;
            figures.push(context!(name, title => plot.title, data => svg_data(&svg)));
        }
        let file = shell_word(&self.file.to_string_lossy());
        let out = shell_word(&folder.path().to_string_lossy());
        let command = format!("inkwave compare {file} --output {out}");
        let all = context!(figures, left_out, command, ..self.context());
        let mut templates = templates()?;
        templates.add_filter("line", |words: String| markdown(&words));
        templates.add_template("lead", include_str!("comparison.lead"))?;
        templates.add_template("reach", include_str!("reach.lead"))?;
        templates.add_template("comparison.md", include_str!("comparison.md"))?;
        templates.add_template("comparison.html", include_str!("comparison.html"))?;
        let page = |name: &str| templates.get_template(name)?.render(&all);
        folder.write("README.md", sealed(&page("comparison.md")?).as_bytes())?;
        folder.write("comparison.html", page("comparison.html")?.as_bytes())?;
        if self.rows.len() == self.asked { Ok(folder.complete()?) } else { Ok(()) }
    }

    /// Data of both pages, without the figures.
    fn context(&self) -> Value {
        let rows = self
            .rows
            .iter()
            .map(|row| context!(failed => !row.converged(), cells => row.shown().map(|(_, cell)| cell)));
        context! {
            title => if self.title.is_empty() { "Comparison of strategies" } else { &self.title },
            made_by => made_by(),
            asked => self.asked,
            tolerance => format!("{:.0e}", self.goal.tolerance),
            max_applications => self.goal.max_applications,
            accuracy => self.accuracy.map(|accuracy| format!("{accuracy:.0e}")),
            reference => &self.reference,
            machine => self.machine.to_string(),
            several => self.has_cases(),
            cases => &self.cases,
            programs => self.described(),
            targets => TARGETS.map(|target| format!("{target:.0e}")),
            reach => self.reach(true),
            reach_of_solves => if self.externals.is_empty() { Vec::new() } else { self.reach(false) },
            costs_header => self.costs_header(),
            costs => self.costs(),
            failures_header => ["strategy", "case", "grid", "reason"],
            failures => self.failures(),
            header => self.rows.first().map(|row| row.shown().map(|(name, _)| name)),
            rows => rows.collect::<Vec<_>>(),
        }
    }

    /// Whether a row is a program's, whose seconds and memory are those of a whole process; the others are
    /// those of a solve alone.
    pub(super) fn is_process(&self, row: &Row) -> bool {
        self.externals.contains(&row.strategy)
    }

    /// One line for each case and each program on it, or each strategy: case, name, the cost of every
    /// target, the smallest error, and why there is no result at all.
    fn reach(&self, of_processes: bool) -> Vec<Vec<String>> {
        let rows = self.rows.iter().filter(|row| self.is_process(row) == of_processes);
        let groups = grouped(rows, |row| (row.case_name(), row.strategy.clone()));
        groups.into_iter().map(|((case, strategy), group)| line([case, strategy], &group)).collect()
    }

    /// Whether several cases are compared.
    pub(super) fn has_cases(&self) -> bool {
        self.rows.iter().any(|row| row.case.is_some() || row.named.is_some())
    }

    /// Every recorded residual, as CSV.
    fn residuals(&self) -> Result<Vec<u8>, csv::Error> {
        let mut records = Vec::new();
        for row in &self.rows {
            for (look, (applications, residual)) in row.looks().into_iter().enumerate() {
                records.push([
                    ("strategy", row.strategy.clone()),
                    ("grid", row.grid()),
                    ("look", look.to_string()),
                    ("applications", applications.to_string()),
                    ("residual", format!("{residual:e}")),
                ]);
            }
        }
        cell::records(records)
    }

    /// Rows of one case, grid and mean: one line of the table of costs.
    fn groups(&self) -> impl Iterator<Item = &[Row]> {
        self.rows.chunk_by(|a, b| a.case == b.case && a.named == b.named && a.discrete == b.discrete)
    }

    fn costs_header(&self) -> Vec<String> {
        let fixed = ["case", "mean", "grid", "grid error"].map(String::from);
        fixed.into_iter().chain(self.strategies.iter().cloned()).collect()
    }

    fn costs(&self) -> Vec<Vec<String>> {
        let cost_of = |group: &[Row], name: &String| group.iter().find(|r| r.strategy == *name).map(cost);
        let line = |group: &[Row]| {
            let costs = self.strategies.iter().map(|name| cost_of(group, name).unwrap_or("–".into()));
            fixed(&group[0]).into_iter().chain(costs).collect()
        };
        self.groups().filter(|group| !self.is_process(&group[0])).map(line).collect()
    }

    /// Failures with strategy, case, grid and reason; only the first of several with one reason.
    fn failures(&self) -> Vec<[String; 4]> {
        let failed = self.rows.iter().filter(|row| !row.converged());
        let alike = grouped(failed, |row| (row.strategy.clone(), row.case_name(), row.outcome()));
        let alike = alike.into_iter();
        alike.map(|((strategy, case, reason), rows)| [strategy, case, rows[0].grid(), reason]).collect()
    }

    /// Name, program, knob and conventions of programs that describe themselves.
    fn described(&self) -> Vec<[String; 4]> {
        let known = self.externals.iter().zip(&self.programs);
        let known = known.filter(|(_, program)| **program != ProgramDescription::default());
        known.map(|(name, p)| [name, &p.program, &p.knob, &p.conventions].map(String::clone)).collect()
    }
}

/// What the strategies of one line of the table of costs share.
fn fixed(row: &Row) -> [String; 4] {
    let mean = row.discrete.map(|d| mean_name(d.absorbing_mean));
    let estimate = row.error_estimate.map(|estimate| format!("{estimate:.1e}"));
    [row.case_name(), dash(mean), row.points(), dash(estimate)]
}

fn cost(row: &Row) -> String {
    match (&row.result, row.processor_seconds) {
        (Ok(_), Some(seconds)) => format!("{} ({seconds:.3} s)", row.applications()),
        _ => format!("fails ({})", row.applications()),
    }
}

/// Amplitude errors whose cost is tabulated.
const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];

fn line(before: [String; 2], group: &[&Row]) -> Vec<String> {
    let errors = group.iter().filter_map(|row| row.result.as_ref().ok().copied());
    let least = errors.reduce(f64::min).map(|error| format!("{error:.1e}"));
    let missed = if least.is_some() { "not within those tried" } else { "–" };
    let costs = TARGETS.map(|target| cheapest(group, target).map_or(missed.into(), seconds_and_memory));
    let reason = if least.is_some() { String::new() } else { group[0].outcome() };
    before.into_iter().chain(costs).chain([dash(least), reason]).collect()
}

/// The row of least processor time (wall time where that is not known) within an error.
fn cheapest<'a>(group: &[&'a Row], target: f64) -> Option<&'a Row> {
    let within = group.iter().filter(|row| row.result.as_ref().is_ok_and(|error| *error <= target));
    within.copied().min_by(|a, b| seconds(a).total_cmp(&seconds(b)))
}

fn seconds(row: &Row) -> f64 {
    row.processor_seconds.or(row.seconds).unwrap_or(f64::INFINITY)
}

fn seconds_and_memory(row: &Row) -> String {
    let seconds = seconds(row);
    let megabytes = row.bytes as f64 / 1e6;
    let places = (2 - seconds.max(1e-4).log10().ceil() as i32).max(0) as usize;
    format!("{seconds:.places$}\u{a0}s, {megabytes:.0}\u{a0}MB")
}

#[cfg(test)]
#[path = "page_tests.rs"]
mod tests;
