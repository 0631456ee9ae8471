//! The outputs of a comparison: tables, plots with logarithmic axes, and a page.

use super::error::missing;
use crate::draw::figure::FigureError;
use crate::draw::log_plot::{Curve, LogPlot, Style};
use crate::report::cell::markdown;
use crate::solve::Account;
use crate::wave::{Resolution, Scheme};
use minijinja::{Environment, context};
use serde::Serialize;
use std::path::Path;
use thiserror::Error;

/// Plots, without the numbers of those that are several.
const PLOTS: [&str; 4] = ["applications", "residuals", "error_against_work", "error_against_seconds"];

/// What may fail while a comparison is written.
#[derive(Debug, Error)]
pub enum ComparisonError {
    /// A file cannot be written.
    #[error("cannot write {path}: {source}; choose a folder that can be written")]
    Write {
        /// The file.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// A table.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// A plot.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The template does not fit its data: a fault of the program.
    #[error("cannot make the page: {0}")]
    Page(#[from] minijinja::Error),
}

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name of the strategy.
    pub strategy: String,
    /// Discretisation along z.
    pub scheme: Scheme,
    /// Points along x.
    pub nx: usize,
    /// Points along y.
    pub ny: usize,
    /// Cells along z.
    pub cells: usize,
    /// Complex unknowns.
    pub unknowns: usize,
    /// Largest amplitude error against the reference.
    pub error: Option<f64>,
    /// Largest expected amplitude error, as `inkwave solve` estimates it; unknown where no companion could be solved.
    pub error_estimate: Option<f64>,
    /// Relative residual reached.
    pub residual: f64,
    /// Steps taken.
    pub steps: usize,
    /// Operator applications.
    pub operator_applications: usize,
    /// Median wall time, s.
    pub seconds: f64,
    /// Bytes of problem and strategy.
    pub bytes: usize,
    /// "converged", or why not.
    pub outcome: String,
    /// Relative residual after each step, the start included.
    #[serde(skip)]
    pub history: Vec<f64>,
}

/// A finished comparison.
pub struct Comparison {
    /// Title, for people.
    pub title: String,
    /// What errors are measured against.
    pub reference: String,
    /// All names of the registry, by whose order each strategy has its colour.
    pub registry: Vec<String>,
    /// Rows asked for; fewer are there where it was stopped.
    pub asked: usize,
    /// One row for each strategy, discretisation and grid.
    pub rows: Vec<Row>,
}

/// Whether a file's name is one of those that a comparison or a matrix of comparisons writes.
pub fn is_of_a_comparison(name: &str) -> bool {
    let tables = ["comparison", "residuals", "matrix"]
        .map(|stem| ["csv", "md", "html"].map(|e| format!("{stem}.{e}")));
    let plot =
        name.strip_suffix(".svg").map(|stem| stem.trim_end_matches(|c: char| c == '-' || c.is_ascii_digit()));
    tables.as_flattened().iter().any(|table| table == name) || plot.is_some_and(|stem| PLOTS.contains(&stem))
}

impl Comparison {
    /// Writes `comparison.csv`, `residuals.csv`, three plots (SVG), `comparison.md` and a self-contained
    /// `comparison.html` into `folder`, each of them whole or not at all.
    pub fn write(&self, folder: &Path) -> Result<(), ComparisonError> {
        let failed =
            |path: &Path, source| ComparisonError::Write { path: path.display().to_string(), source };
        std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
        let save = |name: &str, bytes: &[u8]| {
            let path = folder.join(name);
            crate::store::safely::write(&path, bytes).map_err(|e| failed(&path, e))
        };
        save("comparison.csv", &self.table()?)?;
        save("residuals.csv", &self.residuals()?)?;
        let mut pictures = Vec::new();
        for (name, plot) in self.plots().into_iter().filter(|(_, plot)| !plot.curves.is_empty()) {
            let svg = plot.svg()?;
            save(name, svg.as_bytes())?;
            pictures.push((plot.title, svg));
        }
        save("comparison.md", self.markdown().as_bytes())?;
        save("comparison.html", self.html(&pictures)?.as_bytes())
    }

    fn table(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        self.rows.iter().try_for_each(|row| writer.serialize(row))?;
        writer.into_inner().map_err(|error| error.into_error().into())
    }

    fn residuals(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(["strategy", "scheme", "nx", "cells", "look", "applications", "residual"])?;
        for row in &self.rows {
            for (look, (applications, residual)) in row.looks().into_iter().enumerate() {
                let numbers =
                    [row.nx.to_string(), row.cells.to_string(), look.to_string(), applications.to_string()];
                let [nx, cells, look, applications] = numbers;
                let scheme = scheme_name(row);
                writer.write_record([
                    row.strategy.clone(),
                    scheme,
                    nx,
                    cells,
                    look,
                    applications,
                    format!("{residual:e}"),
                ])?;
            }
        }
        writer.into_inner().map_err(|error| error.into_error().into())
    }

    /// File name and plot.
    fn plots(&self) -> Vec<(&'static str, LogPlot)> {
        let finest = self.rows.iter().map(|r| (r.unknowns, r.nx)).max().unwrap_or_default();
        let last = self.rows.iter().filter(|r| (r.unknowns, r.nx) == finest);
        // The start, before any application, would not show on a logarithmic axis.
        let shown = |r: &Row| r.looks().into_iter().filter(|l| l.0 > 0.0).collect::<Vec<_>>();
        let histories = last.map(|r| self.looking(Curve::new(r.label(), Style::Data, shown(r)), r));
        let histories = histories.filter(|c| !c.points.is_empty()).collect();
        let work = self.curves(|r| (r.operator_applications * r.unknowns) as f64);
        let seconds = self.curves(|r| r.seconds);
        let error = "largest amplitude error";
        let residuals = LogPlot {
            log: [false, true],
            ..LogPlot::log_log(
                "Residual on the finest grid",
                "operator applications",
                "relative residual",
                histories,
            )
        };
        vec![
            ("residuals.svg", residuals),
            (
                "error_against_work.svg",
                LogPlot::log_log("Error against work", "applications × unknowns", error, work),
            ),
            ("error_against_seconds.svg", LogPlot::log_log("Error against time", "seconds", error, seconds)),
        ]
    }

    /// One curve per strategy and scheme, from the cheapest grid to the dearest.
    fn curves(&self, cost: impl Fn(&Row) -> f64) -> Vec<Curve> {
        let mut curves: Vec<Curve> = Vec::new();
        for row in self.rows.iter().filter(|r| r.converged()) {
            let point = [cost(row), row.error.unwrap_or(f64::NAN), 0.0];
            if !(point[0] > 0.0 && point[1] > 0.0 && point[1].is_finite()) {
                continue;
            }
            match curves.iter_mut().find(|c| c.name == row.label()) {
                Some(curve) => curve.points.push(point),
                None => curves.push(self.looking(Curve::with_bars(row.label(), Style::Data, [point]), row)),
            }
        }
        curves
    }

    /// One colour and one marker a strategy over the whole page; dashes tell its schemes apart.
    fn looking(&self, curve: Curve, row: &Row) -> Curve {
        let place = place_in(&self.registry, &row.strategy);
        let schemes = self.rows.iter().position(|r| r.scheme == row.scheme);
        let scheme = schemes.map_or(0, |first| schemes_before(&self.rows[..first]));
        curve.looking(place, place).dashed(scheme)
    }

    fn markdown(&self) -> String {
        let missing =
            missing(self.rows.len(), self.asked).map_or_else(String::new, |said| format!("{said} "));
        let (heading, reference) = (markdown(self.heading()), &self.reference);
        let mut text = format!("# {heading}\n\n{missing}Errors against {reference}.\n\n");
        text += "| strategy | scheme | grid | unknowns | error | estimate | residual | steps | applications | seconds | MB | outcome |\n";
        text += "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
        self.rows.iter().for_each(|r| text += &format!("| {} |\n", r.cells_of_table().join(" | ")));
        text + "\n![Residuals](residuals.svg)\n![Error against work](error_against_work.svg)\n![Error against time](error_against_seconds.svg)\n"
    }

    fn html(&self, pictures: &[(String, String)]) -> Result<String, minijinja::Error> {
        let mut templates = Environment::new();
        templates.add_template("style.css", crate::report::page::STYLE)?;
        templates.add_template("comparison.html", include_str!("comparison.html"))?;
        let rows = self.rows.iter().map(Row::on_the_page);
        let figures =
            pictures.iter().map(|(title, svg)| context!(title, data => crate::report::page::svg_data(svg)));
        templates.get_template("comparison.html")?.render(context! {
            title => self.heading(),
            reference => &self.reference,
            missing => missing(self.rows.len(), self.asked),
            rows => rows.collect::<Vec<_>>(),
            figures => figures.collect::<Vec<_>>(),
        })
    }

    fn heading(&self) -> &str {
        if self.title.is_empty() { "Comparison of strategies" } else { &self.title }
    }
}

/// Place of a strategy in the registry's order, or after it.
pub(super) fn place_in(registry: &[String], strategy: &str) -> usize {
    registry.iter().position(|name| name == strategy).unwrap_or(registry.len())
}

fn schemes_before(rows: &[Row]) -> usize {
    rows.chunk_by(|a, b| a.scheme == b.scheme).count()
}

impl Row {
    /// A row without a result yet.
    pub(crate) fn new(strategy: &str, resolution: Resolution) -> Self {
        let Resolution { nx, ny, cells, scheme } = resolution;
        Self {
            strategy: strategy.to_owned(),
            scheme,
            nx,
            ny,
            cells,
            unknowns: 0,
            error: None,
            error_estimate: None,
            residual: f64::NAN,
            steps: 0,
            operator_applications: 0,
            seconds: 0.0,
            bytes: 0,
            outcome: String::new(),
            history: Vec::new(),
        }
    }

    /// What a solve took, finished or not.
    pub(crate) fn take(&mut self, account: &Account) {
        self.residual = account.residual;
        self.steps = account.steps;
        self.operator_applications = account.operator_applications;
        self.seconds = account.seconds;
        self.bytes += account.bytes;
        self.history = account.history.clone();
    }

    /// Whether the row has a result.
    pub fn converged(&self) -> bool {
        self.error.is_some()
    }

    /// The cells of the table; a failure's reason has a line of its own beneath, where there is room for it.
    fn on_the_page(&self) -> minijinja::Value {
        let (failed, mut cells) = (!self.converged(), self.cells_of_table());
        let reason = cells.last_mut().filter(|_| failed).map(|last| std::mem::replace(last, "failed".into()));
        context!(failed, cells, reason)
    }

    fn label(&self) -> String {
        format!("{}, {}", self.strategy, scheme_name(self))
    }

    /// Looks at the residual: applications done by then (spread evenly where a look covers several), and the residual.
    fn looks(&self) -> Vec<(f64, f64)> {
        let looks = self.history.len().max(2) - 1;
        let per_look = self.operator_applications as f64 / looks as f64;
        self.history.iter().enumerate().map(|(i, &r)| (i as f64 * per_look, r)).collect()
    }

    fn cells_of_table(&self) -> Vec<String> {
        let number = |x: Option<f64>| x.map_or("–".into(), |x| format!("{x:.1e}"));
        vec![
            self.strategy.clone(),
            scheme_name(self),
            format!("{}\u{a0}×\u{a0}{}\u{a0}×\u{a0}{}", self.nx, self.ny, self.cells),
            self.unknowns.to_string(),
            number(self.error),
            number(self.error_estimate),
            format!("{:.1e}", self.residual),
            self.steps.to_string(),
            self.operator_applications.to_string(),
            format!("{:.3}", self.seconds),
            format!("{:.1}", self.bytes as f64 / 1e6),
            self.outcome.replace('\n', " "),
        ]
    }
}

fn scheme_name(row: &Row) -> String {
    format!("{:?}", row.scheme).to_lowercase().replace("seconddifference", "second difference")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// *Planted*: a reason in the last of twelve columns is a sliver at 1280 pixels.
    #[test]
    fn the_reason_of_a_failure_has_the_whole_width() {
        let grid = Resolution { nx: 9, ny: 9, cells: 4, scheme: Scheme::Cubic };
        let failed = Row { outcome: "born diverges: use krylov".into(), ..Row::new("born", grid) };
        let there = Row { error: Some(1e-3), outcome: "converged".into(), ..Row::new("krylov", grid) };
        let registry = vec!["krylov".to_owned(), "born".to_owned()];
        let rows = vec![failed, there];
        let (title, reference) = (String::new(), "the dense solve".to_owned());
        let html = Comparison { title, reference, registry, asked: 2, rows }.html(&[]).unwrap();
        assert!(html.contains("<td colspan=\"12\">born diverges: use krylov</td>"), "{html}");
        assert!(html.contains("<td>converged</td>") && html.matches("colspan").count() == 1, "{html}");
    }
}
