//! Curves, points with bars and guide lines on logarithmic or linear axes, as SVG or bitmap.

use super::figure::{Bitmap, COLOURS, FONT, FigureError};
use super::leaf::{KEY, Leaf, WORDS, failed, fitting, svg_of};
use super::marks::{marker, unbroken};
use super::ticks;
use plotters::coord::Shift;
use plotters::coord::combinators::BindKeyPoints;
use plotters::coord::ranged1d::{AsRangedCoord, BoldPoints, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// Measured points joined by a line.
    Data,
    /// Measured points alone.
    Points,
    /// A line to compare with, dashed; bars become a band.
    Guide,
}

/// Points (x, y, half width of the bar).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// How it is drawn.
    pub style: Style,
    /// x, y and the error of y, 0 where there is none. Where y is not finite, a point is missing and the line is broken.
    pub points: Vec<[f64; 3]>,
    /// Places of its colour and of its marker in their lists; its place among the curves when none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look: Option<[usize; 2]>,
    /// Dashes of a line of data: none at 0, then longer and longer ones.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub dashes: usize,
}

fn is_zero(n: &usize) -> bool {
    *n == 0
}

impl Curve {
    /// A curve without error bars.
    pub fn new(name: impl Into<String>, style: Style, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::with_bars(name, style, points.into_iter().map(|(x, y)| [x, y, 0.0]))
    }

    /// A curve with error bars.
    pub fn with_bars(
        name: impl Into<String>,
        style: Style,
        points: impl IntoIterator<Item = [f64; 3]>,
    ) -> Self {
        Self { name: name.into(), style, points: points.into_iter().collect(), look: None, dashes: 0 }
    }

    /// The same in a colour and with a marker that do not depend on the other curves of the plot.
    pub fn looking(self, colour: usize, marker: usize) -> Self {
        Self { look: Some([colour, marker]), ..self }
    }

    /// The same with a line in dashes, to tell it from others of its colour and marker.
    pub fn dashed(self, dashes: usize) -> Self {
        Self { dashes, ..self }
    }

    /// C x^slope through the last point of another curve, over its range.
    pub fn guide(name: impl Into<String>, along: &Curve, slope: f64) -> Self {
        let last = along.points.last().copied().unwrap_or([1.0; 3]);
        let at = |p: &[f64; 3]| (p[0], last[1] * (p[0] / last[0]).powf(slope));
        Self::new(name, Style::Guide, along.points.iter().map(at))
    }
}

/// A plot; axes are logarithmic where said so.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogPlot {
    /// Title over the plot.
    pub title: String,
    /// Quantity and unit along x.
    pub x_label: String,
    /// Quantity and unit along y.
    pub y_label: String,
    /// Whether x and y are logarithmic.
    pub log: [bool; 2],
    /// The curves, in the order of the legend.
    pub curves: Vec<Curve>,
    /// Ticks along x with their words, such as dates; round numbers or the data's own where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub x_ticks: Vec<(f64, String)>,
}

/// Lines of more points have a marker at every second, third … of them.
const MARKED: usize = 40;
const DASHES: (i32, i32) = (7, 5);

impl LogPlot {
    /// Both axes logarithmic.
    pub fn log_log(title: &str, x_label: &str, y_label: &str, curves: Vec<Curve>) -> Self {
        let (x_label, y_label) = (x_label.into(), y_label.into());
        Self { title: title.into(), x_label, y_label, log: [true; 2], curves, x_ticks: Vec::new() }
    }

    /// Both axes linear.
    pub fn linear(title: &str, x_label: &str, y_label: &str, curves: Vec<Curve>) -> Self {
        Self { log: [false; 2], ..Self::log_log(title, x_label, y_label, curves) }
    }

    /// The plot as SVG text.
    ///
    /// # Errors
    /// Nothing to show, or the drawing library's own failures.
    pub fn svg(&self) -> Result<String, FigureError> {
        svg_of(self.leaf().size(), |area| self.paint(area))
    }

    fn leaf(&self) -> Leaf {
        Leaf::new(&self.title, self.curves.iter().map(|curve| curve.name.as_str()))
    }

    /// The plot as a bitmap.
    ///
    /// # Errors
    /// As [`LogPlot::svg`].
    pub fn bitmap(&self) -> Result<Bitmap, FigureError> {
        let (width, height) = self.leaf().size();
        let mut bitmap = Bitmap::white(width as usize, height as usize)?;
        bitmap.draw(|area| self.paint(area))?;
        Ok(bitmap)
    }

    fn paint<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), FigureError> {
        let [x, y] = [self.range(0)?, self.range(1)?];
        root.fill(&WHITE).map_err(failed)?;
        let along = self.along(&x);
        let keys: Vec<f64> = along.iter().map(|tick| tick.0).collect();
        let up = |range: Range<f64>| {
            let ticks = ticks::logarithmic(&range, ticks::MOST_UP);
            range.log_scale().with_key_points(ticks)
        };
        match self.log {
            [true, true] => self.draw(root, (x.log_scale().with_key_points(keys), up(y)), &along),
            [false, true] => self.draw(root, (ticks::Placed::new(x, keys), up(y)), &along),
            [true, false] => self.draw(root, (x.log_scale().with_key_points(keys), y), &along),
            [false, false] => self.draw(root, (ticks::Placed::new(x, keys), y), &along),
        }
    }

    /// Ticks along x with their words: as given, at few data, or at round numbers.
    fn along(&self, range: &Range<f64>) -> Vec<(f64, String)> {
        if !self.x_ticks.is_empty() {
            return self.x_ticks.clone();
        }
        let data = self.curves.iter().filter(|curve| curve.style != Style::Guide).flat_map(|c| &c.points);
        let data = data.filter(|p| self.shown(p)).map(|p| p[0]);
        if let Some(ticks) = Some(data).filter(|_| self.log[0]).and_then(|data| ticks::at_data(data, range)) {
            return ticks;
        }
        let span = range.end - range.start;
        let at = if self.log[0] {
            ticks::logarithmic(range, ticks::MOST_ALONG)
        } else {
            RangedCoordf64::from(range.clone()).key_points(BoldPoints(ticks::MOST_ALONG))
        };
        at.into_iter().map(|v| (v, ticks::label(v, self.log[0], span))).collect()
    }

    fn shown(&self, p: &[f64; 3]) -> bool {
        let fits = |axis: usize| p[axis].is_finite() && (!self.log[axis] || p[axis] > 0.0);
        fits(0) && fits(1)
    }

    fn range(&self, axis: usize) -> Result<Range<f64>, FigureError> {
        let points = || self.curves.iter().flat_map(|c| &c.points).filter(|p| self.shown(p));
        let bar = |p: &[f64; 3]| if axis == 1 && !self.log[1] { p[2] } else { 0.0 };
        let low = points().map(|p| p[axis] - bar(p)).fold(f64::INFINITY, f64::min);
        let high = points().map(|p| p[axis] + bar(p)).fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return Err(FigureError::Draw(format!("plot \"{}\" has nothing to show", self.title)));
        }
        if self.log[axis] {
            return Ok(ticks::wide(low / 1.25, high * 1.25));
        }
        let margin = 0.04 * if high > low { high - low } else { high.abs().max(1.0) };
        Ok(low - margin..high + margin)
    }

    fn draw<B, X, Y>(
        &self,
        root: &DrawingArea<B, Shift>,
        (x, y): (X, Y),
        along: &[(f64, String)],
    ) -> Result<(), FigureError>
    where
        B: DrawingBackend,
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64>,
        Y::CoordDescType: ValueFormatter<f64>,
    {
        let span = self.range(1).map_or(0.0, |range| range.end - range.start);
        let named =
            |v: &f64| along.iter().find(|tick| tick.0 == *v).map_or_else(String::new, |t| t.1.clone());
        let leaf = self.leaf();
        let (area, names) = leaf.split(root)?;
        let mut chart = ChartBuilder::on(&area)
            .margin(8)
            .margin_right(20)
            .x_label_area_size(48)
            .y_label_area_size(72)
            .build_cartesian_2d(x, y)
            .map_err(failed)?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .label_style((FONT, WORDS))
            .axis_desc_style((FONT, fitting(&self.x_label, 370).min(fitting(&self.y_label, 270))))
            .x_labels(7)
            .y_labels(8)
            .x_label_formatter(&named)
            .y_label_formatter(&|v| ticks::label(*v, self.log[1], span))
            .max_light_lines(0)
            .draw()
            .map_err(failed)?;
        for (k, curve) in self.curves.iter().enumerate() {
            let [place, mark] = curve.look.unwrap_or([k; 2]);
            let colour = if curve.style == Style::Guide { RGBColor(120, 120, 120) } else { palette(place) };
            self.draw_curve(&mut chart, mark, curve, colour)?;
            self.name(&names, (leaf.place(k), mark), curve, colour)?;
        }
        Ok(())
    }

    /// Line or band, markers and bars of one curve.
    fn draw_curve<B, X, Y>(
        &self,
        chart: &mut ChartContext<B, Cartesian2d<X, Y>>,
        mark: usize,
        curve: &Curve,
        colour: RGBColor,
    ) -> Result<(), FigureError>
    where
        B: DrawingBackend,
        X: Ranged<ValueType = f64>,
        Y: Ranged<ValueType = f64>,
    {
        let points: Vec<[f64; 3]> = curve.points.iter().copied().filter(|p| self.shown(p)).collect();
        let line = points.iter().map(|p| (p[0], p[1]));
        match curve.style {
            Style::Data => {
                let missing: Vec<f64> =
                    curve.points.iter().filter(|p| !p[1].is_finite()).map(|p| p[0]).collect();
                for part in unbroken(&points, |p| p[0], &missing) {
                    joined(chart, &part, curve.dashes, colour)?;
                }
            }
            Style::Guide => {
                chart.draw_series([Polygon::new(band(&points), colour.mix(0.25))]).map_err(failed)?;
                let dashed = DashedLineSeries::new(line, DASHES.0 as u32, DASHES.1 as u32, colour.into());
                chart.draw_series(dashed).map_err(failed)?;
            }
            Style::Points => {}
        }
        if curve.style != Style::Guide {
            let every = if curve.style == Style::Data { points.len().div_ceil(MARKED) } else { 1 };
            let marked =
                |p: &[f64; 3]| EmptyElement::at((p[0], p[1])) + Polygon::new(marker(mark), colour.filled());
            chart.draw_series(points.iter().step_by(every.max(1)).map(marked)).map_err(failed)?;
        }
        let barred = |p: &&[f64; 3]| curve.style != Style::Guide && p[2] > 0.0;
        let bars =
            points.iter().filter(barred).filter(|p| !self.log[1] || p[1] > p[2]).map(|p| {
                PathElement::new([(p[0], p[1] - p[2]), (p[0], p[1] + p[2])], colour.stroke_width(1))
            });
        chart.draw_series(bars).map_err(failed)?;
        Ok(())
    }

    /// One entry of the legend.
    fn name<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        ((x, y), mark): ((i32, i32), usize),
        curve: &Curve,
        colour: RGBColor,
    ) -> Result<(), FigureError> {
        let text = Text::new(curve.name.clone(), (x + KEY, y - 8), (FONT, WORDS).into_font());
        area.draw(&text).map_err(failed)?;
        let broken = curve.style == Style::Guide || curve.dashes > 0;
        let dashes: &[[i32; 2]] = if broken { &[[0, 9], [15, 24]] } else { &[[0, 24]] };
        for [a, b] in dashes.iter().filter(|_| curve.style != Style::Points) {
            let line = PathElement::new([(x + a, y), (x + b, y)], colour.stroke_width(2));
            area.draw(&line).map_err(failed)?;
        }
        if curve.style != Style::Guide {
            let mark = EmptyElement::at((x + 12, y)) + Polygon::new(marker(mark), colour.filled());
            area.draw(&mark).map_err(failed)?;
        }
        Ok(())
    }
}

/// A line of data, in dashes where it has some.
fn joined<B, X, Y>(
    chart: &mut ChartContext<B, Cartesian2d<X, Y>>,
    points: &[[f64; 3]],
    dashes: usize,
    colour: RGBColor,
) -> Result<(), FigureError>
where
    B: DrawingBackend,
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let (line, stroke) = (points.iter().map(|p| (p[0], p[1])), colour.stroke_width(2));
    if dashes == 0 {
        chart.draw_series(LineSeries::new(line, stroke)).map_err(failed)?;
    } else {
        chart.draw_series(DashedLineSeries::new(line, 4 * dashes as u32, 4, stroke)).map_err(failed)?;
    }
    Ok(())
}

/// Outline of a curve with its bars: along the upper ends and back along the lower ones.
fn band(points: &[[f64; 3]]) -> Vec<(f64, f64)> {
    let upper = points.iter().map(|p| (p[0], p[1] + p[2]));
    let lower = points.iter().rev().map(|p| (p[0], p[1] - p[2]));
    upper.chain(lower).collect()
}

/// Okabe–Ito, and the same greyer from the eighth curve on.
fn palette(k: usize) -> RGBColor {
    let RGBColor(r, g, b) = COLOURS[k % COLOURS.len()];
    if k < COLOURS.len() { RGBColor(r, g, b) } else { RGBColor(r / 2 + 60, g / 2 + 60, b / 2 + 60) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(svg: &str) -> Vec<usize> {
        let colour = "stroke=\"#000000\" stroke-width=\"2\" points=\"";
        let all = svg
            .split(colour)
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap_or("").split_whitespace().count());
        all.collect()
    }

    /// *Planted*: a line through the missing point has five ends, and one tick at 1.
    #[test]
    fn lines_do_not_run_through_missing_points_and_ticks_stand_at_the_data() {
        let points = [(0.8, 10.0), (1.2, 20.0), (1.6, f64::NAN), (2.4, 20.0), (3.2, 30.0)];
        let plot =
            LogPlot::log_log("", "period, µm", "applications", vec![Curve::new("a", Style::Data, points)]);
        let svg = plot.svg().unwrap();
        // two parts of the line, and its key
        assert_eq!(lines(&svg), [2, 2, 2], "{svg}");
        assert!(
            ["0.8", "1.2", "2.4", "3.2"].iter().all(|tick| svg.contains(&format!(">\n{tick}\n<"))),
            "{svg}"
        );
        assert!(!svg.contains(">\n1\n<"));
    }

    #[test]
    fn ticks_may_have_words() {
        let curve = Curve::new("a", Style::Data, [(0.0, 1.0), (0.08, 2.0)]);
        let x_ticks = vec![(0.0, "11-21 14:32".to_owned()), (0.08, "11-21 16:27".to_owned())];
        let svg = LogPlot { x_ticks, ..LogPlot::linear("", "", "", vec![curve]) }.svg().unwrap();
        assert!(svg.contains("11-21 14:32") && svg.contains("11-21 16:27"), "{svg}");
    }
}
