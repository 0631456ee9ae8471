//! Charts: curves with error bars, points and guide lines on linear or logarithmic axes, as SVG or
//! bitmap.
//!
//! Colours are Okabe–Ito, and every curve has its own marker as well, so that charts remain legible
//! for colour-blind readers and in greyscale.

use super::curve::marker;
pub use super::curve::{Curve, Style};
use super::figure::{Area, Bitmap, COLOURS, DrawResult, FONT, failed};
use super::leaf::{KEY, Leaf, WORDS, fitting, svg_of, width};
use super::ticks::{self, Scale};
use plotters::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Curves on linear or logarithmic axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chart {
    /// Title over the chart.
    pub title: String,
    /// Quantity and unit along x, e.g. "wavelength, nm".
    pub x_label: String,
    /// Quantity and unit along y.
    pub y_label: String,
    /// Whether x and y are logarithmic.
    pub log: [bool; 2],
    /// The curves, in the order of the legend.
    pub curves: Vec<Curve>,
    /// Ticks along x with their labels, such as dates; if empty, round numbers or the data
    /// themselves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub x_ticks: Vec<(f64, String)>,
    /// Range of y; by default that of the points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y_range: Option<[f64; 2]>,
    /// Whether a linear y begins at 0 where nothing is negative.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub from_zero: bool,
}

/// Most markers of a line; longer lines have one at every second, third … point.
const MARKED: usize = 40;
/// Dash and gap of guide lines, pixels.
const DASHES: [u32; 2] = [7, 5];
/// Length of the line in the legend, pixels.
const SAMPLE: i32 = 24;
/// Space for the labels along x and along y, pixels.
const ROOM: [u32; 2] = [370, 270];
/// Margin of a linear axis beyond its data, as a share of them.
const MARGIN: f64 = 0.04;
/// Margin of a logarithmic axis, as a factor.
const MARGIN_FACTOR: f64 = 1.25;

/// What stands in place of axes without anything to show.
const NOTHING: &str = "Nothing to show: no value that these axes can hold.";

/// Half the error bar of a point; none where it is not a finite number.
fn half_bar(p: &[f64; 3]) -> f64 {
    if p[2].is_finite() { p[2] } else { 0.0 }
}

type Axes<'a, B> = ChartContext<'a, B, Cartesian2d<Scale, Scale>>;

/// Colour and marker of a curve.
#[derive(Clone, Copy)]
struct Pen {
    colour: RGBColor,
    marker: usize,
}

impl Pen {
    /// The curve's own look, or the one of its position in the chart.
    fn of(k: usize, curve: &Curve) -> Self {
        let [place, marker] = curve.look.unwrap_or([k; 2]);
        let colour = if curve.style == Style::Guide { RGBColor(120, 120, 120) } else { palette(place) };
        Self { colour, marker }
    }
}

impl Chart {
    /// Both axes logarithmic.
    pub fn log_log(title: &str, x_label: &str, y_label: &str, curves: Vec<Curve>) -> Self {
        Self { log: [true; 2], ..Self::linear(title, x_label, y_label, curves) }
    }

    /// Both axes linear.
    pub fn linear(title: &str, x_label: &str, y_label: &str, curves: Vec<Curve>) -> Self {
        let title = title.into();
        let x_label = x_label.into();
        let y_label = y_label.into();
        Self { title, x_label, y_label, curves, ..Self::default() }
    }

    /// The chart as SVG text.
    ///
    /// Without anything to show ([`Chart::is_empty`]) it says so in place of its axes.
    ///
    /// # Errors
    /// A failure of the drawing library.
    pub fn svg(&self) -> DrawResult<String> {
        svg_of(self.leaf().size(), |area| self.paint(area))
    }

    /// The chart as a bitmap.
    ///
    /// # Errors
    /// As [`Chart::svg`].
    pub fn bitmap(&self) -> DrawResult<Bitmap> {
        let (width, height) = self.leaf().size();
        let mut bitmap = Bitmap::white(width as usize, height as usize)?;
        bitmap.draw(|area| self.paint(area))?;
        Ok(bitmap)
    }

    /// Whether no curve has a point that can be shown: a finite one, on logarithmic axes above 0.
    pub fn is_empty(&self) -> bool {
        !self.curves.iter().flat_map(|curve| &curve.points).any(|p| self.shown(p))
    }

    /// Curves that have a name, with their positions.
    fn named(&self) -> impl Iterator<Item = (usize, &Curve)> {
        self.curves.iter().enumerate().filter(|(_, curve)| !curve.name.is_empty())
    }

    fn leaf(&self) -> Leaf {
        Leaf::new(&self.title, self.named().map(|(_, curve)| curve.name.as_str()))
    }

    fn paint<B: DrawingBackend>(&self, root: &Area<B>) -> DrawResult {
        root.fill(&WHITE).map_err(failed)?;
        let leaf = self.leaf();
        let (area, names) = leaf.split(root)?;
        if self.is_empty() {
            let words = Text::new(NOTHING, (KEY, KEY), (FONT, WORDS).into_font());
            return area.draw(&words).map_err(failed);
        }
        let mut axes = ChartBuilder::on(&area)
            .margin(8)
            .margin_right(20)
            .x_label_area_size(48)
            .y_label_area_size(72)
            .build_cartesian_2d(self.scale(0), self.scale(1))
            .map_err(failed)?;
        axes.configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .label_style((FONT, WORDS))
            .axis_desc_style((FONT, fitting(&self.x_label, ROOM[0]).min(fitting(&self.y_label, ROOM[1]))))
            .max_light_lines(0)
            .draw()
            .map_err(failed)?;
        for (k, curve) in self.curves.iter().enumerate() {
            self.draw(&mut axes, curve, Pen::of(k, curve))?;
        }
        let mut entries = self.named().enumerate();
        entries.try_for_each(|(row, (k, curve))| name(&names, leaf.place(row), curve, Pen::of(k, curve)))
    }

    fn scale(&self, axis: usize) -> Scale {
        let range = self.range(axis);
        let log = self.log[axis];
        let placed = if axis == 0 { self.along(&range) } else { None };
        let ticks = placed.unwrap_or_else(|| ticks::round_ticks(&range, axis, log));
        Scale::new(log, range, ticks)
    }

    /// Ticks along x with their labels beside round numbers: the given ones as far as they are
    /// legible, or at the data if these are few.
    fn along(&self, range: &Range<f64>) -> Option<Vec<(f64, String)>> {
        if !self.x_ticks.is_empty() {
            return Some(readable(&self.x_ticks, range.end - range.start));
        }
        let data = self.curves.iter().filter(|curve| curve.style != Style::Guide).flat_map(|c| &c.points);
        let data = data.filter(|p| self.shown(p)).map(|p| p[0]);
        Some(data).filter(|_| self.log[0]).and_then(|data| ticks::at_data(data, range))
    }

    fn shown(&self, p: &[f64; 3]) -> bool {
        (0..2).all(|axis| p[axis].is_finite() && (!self.log[axis] || p[axis] > 0.0))
    }

    /// Range of an axis of a chart that is not empty.
    fn range(&self, axis: usize) -> Range<f64> {
        if let Some([low, high]) = self.y_range.filter(|_| axis == 1) {
            return low..high;
        }
        let points = || self.curves.iter().flat_map(|c| &c.points).filter(|p| self.shown(p));
        let bar = |p: &[f64; 3]| if axis == 1 && !self.log[1] { half_bar(p) } else { 0.0 };
        let low = points().map(|p| p[axis] - bar(p)).fold(f64::INFINITY, f64::min);
        let high = points().map(|p| p[axis] + bar(p)).fold(f64::NEG_INFINITY, f64::max);
        if self.log[axis] {
            return ticks::wide(low / MARGIN_FACTOR, high * MARGIN_FACTOR);
        }
        let grounded = axis == 1 && self.from_zero && low >= 0.0;
        let low = if grounded { 0.0 } else { low };
        let margin = MARGIN * if high > low { high - low } else { high.abs().max(1.0) };
        let below = if grounded { 0.0 } else { margin };
        low - below..high + margin
    }

    /// Axis coordinates of a point.
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (ticks::on(self.log[0], x), ticks::on(self.log[1], y))
    }

    /// Ends of the error bar; the point itself where the lower end has no logarithm.
    fn ends(&self, p: &[f64; 3]) -> [(f64, f64); 2] {
        let half = if self.log[1] && p[1] <= p[2] { 0.0 } else { half_bar(p) };
        [self.at(p[0], p[1] - half), self.at(p[0], p[1] + half)]
    }

    /// Draws line or band, markers and error bars of one curve.
    fn draw<B: DrawingBackend>(&self, axes: &mut Axes<B>, curve: &Curve, pen: Pen) -> DrawResult {
        let shown: Vec<&[f64; 3]> = curve.points.iter().filter(|p| self.shown(p)).collect();
        if curve.style == Style::Guide {
            let lower = shown.iter().map(move |p| self.ends(p)[0]);
            let upper = shown.iter().map(move |p| self.ends(p)[1]);
            let band: Vec<_> = upper.chain(lower.rev()).collect();
            axes.draw_series([Polygon::new(band, pen.colour.mix(0.25))]).map_err(failed)?;
            return self.line(axes, &shown, DASHES, pen.colour.into());
        }
        let mut every = 1;
        if curve.style == Style::Data {
            every = shown.len().div_ceil(MARKED).max(1);
            for part in curve.points.split(|p| !self.shown(p)).filter(|part| !part.is_empty()) {
                let part: Vec<&[f64; 3]> = part.iter().collect();
                self.line(axes, &part, dashes(curve), pen.colour.stroke_width(2))?;
            }
        }
        let bars = shown.iter().filter(|p| half_bar(p) > 0.0).map(|p| self.ends(p));
        let bars = bars.map(|ends| PathElement::new(ends, pen.colour.stroke_width(1)));
        axes.draw_series(bars).map_err(failed)?;
        let markers = shown.iter().step_by(every).map(|p| {
            EmptyElement::at(self.at(p[0], p[1])) + Polygon::new(marker(pen.marker), pen.colour.filled())
        });
        axes.draw_series(markers).map(drop).map_err(failed)
    }

    /// Draws a line through points, solid if the dashes have no length.
    fn line<B: DrawingBackend>(
        &self,
        axes: &mut Axes<B>,
        points: &[&[f64; 3]],
        [dash, gap]: [u32; 2],
        stroke: ShapeStyle,
    ) -> DrawResult {
        let places = points.iter().map(|p| self.at(p[0], p[1]));
        let drawn = match dash {
            0 => axes.draw_series(LineSeries::new(places, stroke)).map(drop),
            _ => axes.draw_series(DashedLineSeries::new(places, dash, gap, stroke)).map(drop),
        };
        drawn.map_err(failed)
    }
}

/// Dash and gap of a line of data, pixels; solid if the dashes have no length.
fn dashes(curve: &Curve) -> [u32; 2] {
    [4 * curve.dashes as u32, 4]
}

/// Draws one entry of the legend.
fn name<B: DrawingBackend>(area: &Area<B>, (x, y): (i32, i32), curve: &Curve, pen: Pen) -> DrawResult {
    area.draw(&Text::new(curve.name.clone(), (x + KEY, y - 8), (FONT, WORDS).into_font())).map_err(failed)?;
    let [dash, gap] = if curve.style == Style::Guide { DASHES } else { dashes(curve) }.map(|px| px as i32);
    let dash = if dash == 0 { SAMPLE } else { dash };
    for a in (0..SAMPLE).step_by((dash + gap) as usize).filter(|_| curve.style != Style::Points) {
        let line = PathElement::new([(x + a, y), (x + SAMPLE.min(a + dash), y)], pen.colour.stroke_width(2));
        area.draw(&line).map_err(failed)?;
    }
    if curve.style != Style::Guide {
        let sign = EmptyElement::at((x + 12, y)) + Polygon::new(marker(pen.marker), pen.colour.filled());
        area.draw(&sign).map_err(failed)?;
    }
    Ok(())
}

/// Ticks whose labels do not overlap, from the first on; `length` is that of the axis.
fn readable(all: &[(f64, String)], length: f64) -> Vec<(f64, String)> {
    let widest = all.iter().map(|tick| width(&tick.1, WORDS) + WORDS).max().unwrap_or(0);
    let apart = length * f64::from(widest) / f64::from(ROOM[0]);
    let mut kept: Vec<(f64, String)> = Vec::new();
    for tick in all {
        if kept.last().is_none_or(|last| tick.0 - last.0 >= apart) {
            kept.push(tick.clone());
        }
    }
    kept
}

/// Okabe–Ito colours, and greyer ones from the eighth curve on.
fn palette(k: usize) -> RGBColor {
    let RGBColor(r, g, b) = COLOURS[k % COLOURS.len()];
    if k < COLOURS.len() { RGBColor(r, g, b) } else { RGBColor(r / 2 + 60, g / 2 + 60, b / 2 + 60) }
}

#[cfg(test)]
#[path = "chart_tests.rs"]
mod tests;
