//! Line plots with error bars (spectra, curves against concentration or size) and polar plots of a BRDF.
//!
//! Written as SVG or PNG by the ending of the path. Colours are Okabe–Ito, and every series has its own marker too, so
//! that plots survive colour blindness and a grey printer.

use super::figure::{Bitmap, COLOURS, FONT, FigureError, register_fonts};
use super::leaf::{Area, KEY, Leaf, WORDS, failed, fitting, svg_of};
use super::marks::{marker, unbroken};
use super::ticks;
use crate::numerics::estimate::Estimate;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::path::Path;

/// One curve: (x, y with standard error). Points without a known error have no bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Abscissa and value with its error.
    pub points: Vec<(f64, Estimate)>,
    /// Abscissae that were asked for and have no value: the line is broken there.
    pub missing: Vec<f64>,
}

impl Series {
    /// A curve from parallel columns; the shorter one decides.
    pub fn new(name: &str, x: &[f64], y: &[Estimate]) -> Self {
        Self::of_points(name, x.iter().copied().zip(y.iter().copied()).collect())
    }

    /// A curve of which nothing is missing.
    pub fn of_points(name: impl Into<String>, points: Vec<(f64, Estimate)>) -> Self {
        Self { name: name.into(), points, missing: Vec::new() }
    }

    /// The same, broken at the abscissae that were asked for and have no point.
    pub fn asked_at(mut self, asked: &[f64]) -> Self {
        let found = |x: f64| self.points.iter().any(|p| (p.0 - x).abs() < SAME);
        self.missing = asked.iter().copied().filter(|&x| !found(x)).collect();
        self
    }
}

/// Abscissae closer than this are one: wavelengths in nm, angles in degrees.
const SAME: f64 = 1e-6;

/// A plot on linear axes. Ranges that are `None` follow from the data (y from 0 unless data are negative).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// Title over the plot.
    pub title: String,
    /// With the unit, e.g. "wavelength, nm".
    pub x_label: String,
    /// Quantity and unit along y.
    pub y_label: String,
    /// Range of x; from the points unless told.
    pub x_range: Option<[f64; 2]>,
    /// Range of y; from the points unless told.
    pub y_range: Option<[f64; 2]>,
    /// The series, in the order of the legend.
    pub series: Vec<Series>,
}

type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Plot {
    /// Writes the plot; `.png` gives a bitmap, anything else SVG.
    ///
    /// # Errors
    /// No series or points; numbers that are not finite; a path that cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), FigureError> {
        let path = path.as_ref();
        register_fonts();
        self.check()?;
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            let (width, height) = self.leaf().size();
            let mut bitmap = Bitmap::white(width as usize, height as usize)?;
            bitmap.draw(|area| self.draw(area))?;
            return bitmap.write_png(path, &[("Title", self.title.as_str())]);
        }
        let failed = |e: std::io::Error| FigureError::Write { path: path.into(), message: e.to_string() };
        std::fs::write(path, self.svg()?).map_err(failed)
    }

    /// The plot as SVG text.
    ///
    /// # Errors
    /// As [`Plot::write`], without the path.
    pub fn svg(&self) -> Result<String, FigureError> {
        self.check()?;
        svg_of(self.leaf().size(), |area| self.draw(area))
    }

    /// One series needs no name.
    fn leaf(&self) -> Leaf {
        let named = if self.series.len() < 2 { &[] } else { &self.series[..] };
        Leaf::new(&self.title, named.iter().map(|series| series.name.as_str()))
    }

    fn check(&self) -> Result<(), FigureError> {
        check_series(&self.series)
    }

    fn draw<'a, B: DrawingBackend + 'a>(&self, area: &Area<B>) -> Result<(), FigureError> {
        area.fill(&WHITE).map_err(failed)?;
        let [x0, x1] = self.x_range.unwrap_or_else(|| extent(self.numbers(|p| [p.0; 2]), 0.0, false));
        let [y0, y1] = self.y_range.unwrap_or_else(|| extent(self.numbers(|p| ends(&p.1)), 0.06, true));
        let leaf = self.leaf();
        let (plot, names) = leaf.split(area)?;
        let mut chart = ChartBuilder::on(&plot)
            .margin(8)
            .margin_right(20)
            .x_label_area_size(48)
            .y_label_area_size(66)
            .build_cartesian_2d(x0..x1, y0..y1)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_labels(7)
            .y_labels(8)
            .label_style((FONT, WORDS))
            .axis_desc_style((FONT, fitting(&self.x_label, 370).min(fitting(&self.y_label, 270))))
            .x_label_formatter(&|v| ticks::label(*v, false, x1 - x0))
            .y_label_formatter(&|v| ticks::label(*v, false, y1 - y0))
            .max_light_lines(0)
            .draw()
            .map_err(failed)?;
        for (k, series) in self.series.iter().enumerate() {
            curve(&mut chart, k, series)?;
        }
        if self.series.len() < 2 { Ok(()) } else { legend(&leaf, &names, &self.series) }
    }

    fn numbers<'a>(
        &'a self,
        f: impl Fn(&(f64, Estimate)) -> [f64; 2] + 'a,
    ) -> impl Iterator<Item = f64> + 'a {
        self.series.iter().flat_map(|s| &s.points).flat_map(f)
    }
}

fn check_series(series: &[Series]) -> Result<(), FigureError> {
    if series.iter().all(|s| s.points.is_empty()) {
        return Err(FigureError::Empty { field: "series" });
    }
    let finite = |p: &(f64, Estimate)| p.0.is_finite() && ends(&p.1).iter().all(|y| y.is_finite());
    match series.iter().find(|s| !s.points.iter().all(finite)) {
        Some(s) => Err(FigureError::Draw(format!("series {:?} has a number that is not finite", s.name))),
        None => Ok(()),
    }
}

/// Ends of the error bar.
fn ends(y: &Estimate) -> [f64; 2] {
    let half = y.standard_error.unwrap_or(0.0);
    [y.value - half, y.value + half]
}

/// Range of the data with a margin; from 0 if asked and nothing is negative. Never empty.
fn extent(values: impl Iterator<Item = f64>, margin: f64, from_zero: bool) -> [f64; 2] {
    let (lo, hi) = values.fold((f64::MAX, f64::MIN), |(lo, hi), v| (lo.min(v), hi.max(v)));
    let grounded = from_zero && lo >= 0.0;
    let lo = if grounded { 0.0 } else { lo };
    let width = if hi > lo { hi - lo } else { lo.abs().max(1.0) };
    [if grounded { 0.0 } else { lo - margin * width }, if hi > lo { hi } else { lo + width } + margin * width]
}

/// Line, error bars and markers of one series.
fn curve<'a, B: DrawingBackend + 'a>(
    chart: &mut Chart<'a, B>,
    k: usize,
    series: &Series,
) -> Result<(), FigureError> {
    let colour = COLOURS[k % COLOURS.len()];
    let at = |p: &(f64, Estimate)| (p.0, p.1.value);
    for part in unbroken(&series.points, |p| p.0, &series.missing) {
        let line = part.iter().map(at);
        chart.draw_series(LineSeries::new(line, colour.stroke_width(2))).map_err(failed)?;
    }
    let bars = series.points.iter().filter(|p| p.1.standard_error.is_some()).map(|p| {
        let [lo, hi] = ends(&p.1);
        PathElement::new([(p.0, lo), (p.0, hi)], colour.stroke_width(1))
    });
    chart.draw_series(bars).map_err(failed)?;
    let markers =
        series.points.iter().map(|p| EmptyElement::at(at(p)) + Polygon::new(marker(k), colour.filled()));
    chart.draw_series(markers).map_err(failed)?;
    Ok(())
}

/// Names beneath the plot, where they cover no data.
fn legend<B: DrawingBackend>(leaf: &Leaf, area: &Area<B>, series: &[Series]) -> Result<(), FigureError> {
    for (k, s) in series.iter().enumerate() {
        let colour = COLOURS[k % COLOURS.len()];
        let entry = EmptyElement::at(leaf.place(k))
            + PathElement::new([(0, 0), (24, 0)], colour.stroke_width(2))
            + Polygon::new(
                marker(k).into_iter().map(|(x, y)| (x + 12, y)).collect::<Vec<_>>(),
                colour.filled(),
            )
            + Text::new(s.name.clone(), (KEY, -8), (FONT, WORDS).into_font());
        area.draw(&entry).map_err(failed)?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "plots_tests.rs"]
mod tests;
