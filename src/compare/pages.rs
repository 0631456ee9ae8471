//! The outputs of a comparison: tables, plots with logarithmic axes, and a page.

use crate::draw::figure::{Bitmap, COLOURS, FONT, FigureError, register_fonts};
use crate::solve::Account;
use crate::wave::Scheme;
use plotters::prelude::*;
use serde::Serialize;
use std::path::Path;
use thiserror::Error;

/// What may fail while a comparison is written.
#[derive(Debug, Error)]
pub enum ComparisonError {
    #[error("cannot write {path}: {source}; choose a folder that can be written")]
    Write { path: String, source: std::io::Error },
    #[error(transparent)]
    Csv(#[from] csv::Error),
    #[error(transparent)]
    Figure(#[from] FigureError),
}

/// One line of the table.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub strategy: String,
    pub scheme: Scheme,
    pub nx: usize,
    pub ny: usize,
    pub cells: usize,
    pub unknowns: usize,
    /// Largest amplitude error against the reference.
    pub error: Option<f64>,
    /// Difference to four fifths of the points and cells.
    pub error_estimate: Option<f64>,
    pub residual: f64,
    pub steps: usize,
    pub operator_applications: usize,
    pub seconds: f64,
    pub bytes: usize,
    /// "converged", or why not.
    pub outcome: String,
    #[serde(skip)]
    pub history: Vec<f64>,
}

/// A finished comparison.
pub struct Comparison {
    pub title: String,
    /// What errors are measured against.
    pub reference: String,
    pub rows: Vec<Row>,
}

/// A name and its points.
pub type Curve = (String, Vec<(f64, f64)>);

impl Comparison {
    /// Writes `comparison.csv`, `residuals.csv`, three PNG plots, `comparison.md` and a self-contained
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
        for (name, title, x, y, curves) in self.plots() {
            let temporary =
                tempfile::Builder::new().suffix(".png").tempfile().map_err(|e| failed(folder, e))?;
            log_plot(&title, x, y, &curves)?.write_png(temporary.path(), &[("Title", title.as_str())])?;
            let png = std::fs::read(temporary.path()).map_err(|e| failed(folder, e))?;
            save(name, &png)?;
            pictures.push((title, png));
        }
        save("comparison.md", self.markdown().as_bytes())?;
        save("comparison.html", self.html(&pictures).as_bytes())
    }

    fn table(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        self.rows.iter().try_for_each(|row| writer.serialize(row))?;
        Ok(writer.into_inner().unwrap_or_default())
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
        Ok(writer.into_inner().unwrap_or_default())
    }

    /// File name, title, axes and curves of every plot.
    fn plots(&self) -> Vec<(&'static str, String, &'static str, &'static str, Vec<Curve>)> {
        let finest = self.rows.iter().map(|r| (r.unknowns, r.nx)).max().unwrap_or_default();
        let last = self.rows.iter().filter(|r| (r.unknowns, r.nx) == finest);
        // The start, before any application, would not show on a logarithmic axis.
        let shown = |r: &Row| r.looks().into_iter().filter(|l| l.0 > 0.0).collect();
        let histories = last.map(|r| (r.label(), shown(r))).collect();
        vec![
            (
                "residuals.png",
                "Residual on the finest grid".into(),
                "operator applications",
                "relative residual",
                histories,
            ),
            (
                "error_against_work.png",
                "Error against work".into(),
                "applications × unknowns",
                "largest amplitude error",
                self.curves(|r| (r.operator_applications * r.unknowns) as f64),
            ),
            (
                "error_against_seconds.png",
                "Error against time".into(),
                "seconds",
                "largest amplitude error",
                self.curves(|r| r.seconds),
            ),
        ]
    }

    fn curves(&self, cost: impl Fn(&Row) -> f64) -> Vec<Curve> {
        let mut curves: Vec<Curve> = Vec::new();
        for row in self.rows.iter().filter(|r| r.converged()) {
            let point = (cost(row), row.error.unwrap_or(f64::NAN));
            match curves.iter_mut().find(|c| c.0 == row.label()) {
                Some(curve) => curve.1.push(point),
                None => curves.push((row.label(), vec![point])),
            }
        }
        curves
    }

    fn markdown(&self) -> String {
        let mut text = format!("# {}\n\nErrors against {}.\n\n", self.heading(), self.reference);
        text += "| strategy | scheme | grid | unknowns | error | estimate | residual | steps | applications | seconds | MB | outcome |\n";
        text += "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
        self.rows.iter().for_each(|r| text += &format!("| {} |\n", r.cells_of_table().join(" | ")));
        text + "\n![](residuals.png)\n![](error_against_work.png)\n![](error_against_seconds.png)\n"
    }

    fn html(&self, pictures: &[(String, Vec<u8>)]) -> String {
        let cell = |c: &String| format!("<td>{}</td>", escape(c));
        let row = |r: &Row| {
            let class = if r.converged() { "" } else { " class=\"failed\"" };
            format!("<tr{class}>{}</tr>\n", r.cells_of_table().iter().map(cell).collect::<String>())
        };
        let rows: String = self.rows.iter().map(row).collect();
        let figure = |(title, png): &(String, Vec<u8>)| {
            format!(
                "<figure><img alt=\"{0}\" src=\"{1}\"><figcaption>{0}</figcaption></figure>",
                escape(title),
                crate::report::page::png_data(png)
            )
        };
        let figures: String = pictures.iter().map(figure).collect();
        include_str!("comparison.html")
            .replace("{title}", &escape(self.heading()))
            .replace("{reference}", &escape(&self.reference))
            .replace("{rows}", &rows)
            .replace("{figures}", &figures)
    }

    fn heading(&self) -> &str {
        if self.title.is_empty() { "Comparison of strategies" } else { &self.title }
    }
}

impl Row {
    pub(crate) fn take(&mut self, account: &Account, outcome: String, problem_bytes: usize) {
        self.residual = account.residual;
        self.steps = account.steps;
        self.operator_applications = account.operator_applications;
        self.bytes = account.bytes + problem_bytes;
        self.history = account.history.clone();
        self.outcome = outcome;
    }

    pub fn converged(&self) -> bool {
        self.error.is_some()
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
            format!("{} × {} × {}", self.nx, self.ny, self.cells),
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

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Curves on a logarithmic y axis; x is logarithmic too unless a curve starts at 0.
pub fn log_plot(title: &str, x_label: &str, y_label: &str, curves: &[Curve]) -> Result<Bitmap, FigureError> {
    register_fonts();
    let mut bitmap = Bitmap::white(900, 560)?;
    let all = || {
        curves
            .iter()
            .flat_map(|c| c.1.iter().copied())
            .filter(|p| p.0.is_finite() && p.1.is_finite() && p.1 > 0.0)
    };
    let range = |pick: fn((f64, f64)) -> f64| {
        all().map(pick).fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(v), b.max(v)))
    };
    let ((x0, x1), (y0, y1)) = (range(|p| p.0), range(|p| p.1));
    if y1 <= 0.0 {
        return Ok(bitmap);
    }
    let (y0, y1) = (0.5 * y0, 2.0 * y1.min(1e4 * y0.max(1e-12) * 1e12));
    let failed = |e: String| FigureError::Draw(e);
    bitmap.draw(|area| {
        let (plot, names) = area.split_horizontally(640);
        let mut builder = ChartBuilder::on(&plot);
        builder.caption(title, (FONT, 20)).margin(14).x_label_area_size(50).y_label_area_size(80);
        macro_rules! finish {
            ($x:expr) => {{
                let mut chart = builder
                    .build_cartesian_2d($x, (y0..y1).log_scale())
                    .map_err(|e| failed(e.to_string()))?;
                chart
                    .configure_mesh()
                    .x_desc(x_label)
                    .y_desc(y_label)
                    .label_style((FONT, 14))
                    .axis_desc_style((FONT, 16))
                    .x_labels(7)
                    .x_label_formatter(&|v| short(*v))
                    .y_label_formatter(&|v| format!("{v:.0e}"))
                    .draw()
                    .map_err(|e| failed(e.to_string()))?;
                for (i, (_, points)) in curves.iter().enumerate() {
                    let colour = colour(i);
                    let points: Vec<_> =
                        points.iter().copied().filter(|p| p.1.is_finite() && p.1 > 0.0).collect();
                    let line = LineSeries::new(points.clone(), colour.stroke_width(2));
                    chart.draw_series(line).map_err(|e| failed(e.to_string()))?;
                    let marks = points
                        .iter()
                        .map(|&p| Circle::new(p, 3 + (i / COLOURS.len()) as i32, colour.filled()));
                    chart.draw_series(marks).map_err(|e| failed(e.to_string()))?;
                }
            }};
        }
        if x0 > 0.0 {
            finish!((0.8 * x0..1.25 * x1).log_scale())
        } else {
            finish!(0.0..1.02 * x1)
        }
        for (i, (name, _)) in curves.iter().enumerate() {
            let y = 60 + 24 * i as i32;
            let mark = Rectangle::new([(4, y), (22, y + 12)], colour(i).filled());
            names.draw(&mark).map_err(|e| failed(e.to_string()))?;
            let text = Text::new(name.clone(), (30, y - 1), (FONT, 14).into_font().color(&BLACK));
            names.draw(&text).map_err(|e| failed(e.to_string()))?;
        }
        Ok(())
    })?;
    Ok(bitmap)
}

fn short(v: f64) -> String {
    if v == 0.0 || (0.01..10_000.0).contains(&v) {
        format!("{v:.3}").trim_end_matches('0').trim_end_matches('.').into()
    } else {
        format!("{v:.0e}")
    }
}

/// The palette, then the same colours lighter.
fn colour(i: usize) -> RGBColor {
    let base = COLOURS[i % COLOURS.len()];
    let RGBColor(r, g, b) = base;
    if i < COLOURS.len() { base } else { RGBColor(r / 2 + 110, g / 2 + 110, b / 2 + 110) }
}
