//! The outputs of a comparison: tables, plots and a page.

use super::row::{HEADER, Row, dash, mean_name};
use crate::report::cell::{markdown, text};
use crate::report::page::{STYLE, made_by, svg_data};
use crate::report::publish::PublishError;
use crate::report::seal::sealed;
use crate::solve::Goal;
use crate::store::folder::OutputFolder;
use minijinja::{Environment, Value, context};
use std::path::PathBuf;

/// Tables and pages.
const TABLES: [&str; 4] = ["comparison.csv", "comparison.html", "residuals.csv", "README.md"];
/// Plots, without the numbers of those that are several.
const PLOTS: [&str; 4] = ["applications", "residuals", "error_against_work", "error_against_seconds"];

/// A finished comparison.
pub struct Comparison {
    /// Title, for people.
    pub title: String,
    /// The comparison's file.
    pub file: PathBuf,
    /// What errors are measured against.
    pub reference: String,
    /// Amplitude error that the grids were searched for; none where they were listed.
    pub accuracy: Option<f64>,
    /// Residual to reach, and the most operator applications.
    pub goal: Goal,
    /// Strategies in their order.
    pub strategies: Vec<String>,
    /// All names of the registry, by whose order each strategy has its colour.
    pub registry: Vec<String>,
    /// Rows asked for; fewer are there where it was stopped.
    pub asked: usize,
    /// Case by case, grid by grid, mean by mean, strategy by strategy.
    pub rows: Vec<Row>,
}

/// Whether a file's name is one of those that a comparison writes.
fn is_of_a_comparison(name: &str) -> bool {
    let plot =
        name.strip_suffix(".svg").map(|stem| stem.trim_end_matches(|c: char| c == '-' || c.is_ascii_digit()));
    TABLES.contains(&name) || plot.is_some_and(|stem| PLOTS.contains(&stem))
}

impl Comparison {
    /// Writes `comparison.csv`, the plots (SVG), `README.md` and a self-contained `comparison.html`
    /// into `folder` in place of an earlier comparison, each of them whole or not at all; of a
    /// single case `residuals.csv` too.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn write(&self, folder: &OutputFolder) -> Result<(), PublishError> {
        folder.remove_files(is_of_a_comparison)?;
        folder.write("comparison.csv", &table(self.rows.iter().map(Row::record))?)?;
        if !self.has_cases() {
            folder.write("residuals.csv", &self.residuals()?)?;
        }
        let mut figures = Vec::new();
        for (name, plot) in self.plots() {
            let svg = plot.svg()?;
            folder.write(&name, svg.as_bytes())?;
            figures.push(context!(name, title => plot.title, data => svg_data(&svg)));
        }
        let command = format!("inkwave compare {} --output {}", self.file.display(), folder.path().display());
        let all = context!(figures, command, ..self.context());
        let mut templates = Environment::new();
        templates.add_filter("line", |words: String| markdown(&words));
        templates.add_template("style.css", STYLE)?;
        templates.add_template("lead", include_str!("comparison.lead"))?;
        templates.add_template("comparison.md", include_str!("comparison.md"))?;
        templates.add_template("comparison.html", include_str!("comparison.html"))?;
        folder
            .write("README.md", sealed(&templates.get_template("comparison.md")?.render(&all)?).as_bytes())?;
        folder
            .write("comparison.html", templates.get_template("comparison.html")?.render(&all)?.as_bytes())?;
        if self.rows.len() == self.asked { Ok(folder.complete()?) } else { Ok(()) }
    }

    /// All that both pages show, but for the figures.
    fn context(&self) -> Value {
        let rows = self.rows.iter().map(|row| context!(failed => !row.converged(), cells => row.shown()));
        context! {
            title => if self.title.is_empty() { "Comparison of strategies" } else { &self.title },
            made_by => made_by(),
            asked => self.asked,
            tolerance => format!("{:.0e}", self.goal.tolerance),
            max_applications => self.goal.max_applications,
            accuracy => self.accuracy.map(|accuracy| format!("{accuracy:.0e}")),
            reference => &self.reference,
            several => self.has_cases(),
            costs_header => self.costs_header(),
            costs => self.costs(),
            failures_header => ["strategy", "case", "grid", "reason"],
            failures => self.failures(),
            header => HEADER,
            rows => rows.collect::<Vec<_>>(),
        }
    }

    /// Whether several cases are compared.
    pub(super) fn has_cases(&self) -> bool {
        self.rows.iter().any(|row| row.case.is_some())
    }

    /// Every look at a residual.
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
        table(records.into_iter())
    }

    /// Rows of one case, grid and mean: one line of the table of costs.
    fn groups(&self) -> impl Iterator<Item = &[Row]> {
        self.rows.chunk_by(|a, b| a.case == b.case && a.discrete == b.discrete)
    }

    fn costs_header(&self) -> Vec<String> {
        let fixed = ["case", "mean", "grid", "grid error"].map(String::from);
        fixed.into_iter().chain(self.strategies.iter().cloned()).collect()
    }

    fn costs(&self) -> Vec<Vec<String>> {
        let of = |group: &[Row], name: &String| group.iter().find(|r| r.strategy == *name).map(cost);
        let line = |group: &[Row]| {
            let costs = self.strategies.iter().map(|name| of(group, name).unwrap_or("–".into()));
            fixed(&group[0]).into_iter().chain(costs).collect()
        };
        self.groups().map(line).collect()
    }

    /// Who failed, where, and why: one line a failure.
    fn failures(&self) -> Vec<[String; 4]> {
        let failed = self.rows.iter().filter(|row| !row.converged());
        failed.map(|row| [row.strategy.clone(), dash(row.case), row.grid(), row.outcome()]).collect()
    }
}

/// A CSV table of named cells.
fn table(records: impl Iterator<Item = impl AsRef<[(&'static str, String)]>>) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (k, record) in records.enumerate() {
        if k == 0 {
            writer.write_record(record.as_ref().iter().map(|cell| cell.0))?;
        }
        writer.write_record(record.as_ref().iter().map(|cell| text(&cell.1)))?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// What the strategies of one line of the table of costs share.
fn fixed(row: &Row) -> [String; 4] {
    let mean = row.discrete.map(|d| mean_name(d.absorbing_mean));
    let estimate = row.error_estimate.map(|estimate| format!("{estimate:.1e}"));
    [dash(row.case), dash(mean), row.points(), dash(estimate)]
}

fn cost(row: &Row) -> String {
    match (&row.result, row.processor_seconds) {
        (Ok(_), Some(seconds)) => format!("{} ({seconds:.3} s)", row.applications()),
        _ => format!("fails ({})", row.applications()),
    }
}
