//! Curves of a chart: points with error bars, joined or not, and guide lines; markers of points.

use crate::numerics::estimate::Estimate;
use serde::{Deserialize, Serialize};

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// Measured points joined by a line.
    Data,
    /// Measured points alone.
    Points,
    /// A reference line, dashed and without markers; error bars become a band.
    Guide,
}

/// A named series of points with error bars.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name in the legend; not listed if empty.
    pub name: String,
    /// How it is drawn.
    pub style: Style,
    /// x, y and the half width of the error bar of y, 0 if there is none. A y that is not finite
    /// marks a missing point, at which the line is broken.
    pub points: Vec<[f64; 3]>,
    /// Indices of colour and marker in their lists; by default the position of the curve in the
    /// chart.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look: Option<[usize; 2]>,
    /// Dashes of a line of data: 0 is solid, larger numbers have longer dashes.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub dashes: usize,
}

fn is_zero(n: &usize) -> bool {
    *n == 0
}

/// Abscissae closer than this count as equal: wavelengths in nm, angles in degrees.
const SAME: f64 = 1e-6;

/// Fewest points for the fit of an exponent: two determine a line, three leave one degree of
/// freedom.
const FEWEST_POINTS: usize = 4;

impl Curve {
    /// A curve without error bars.
    pub fn new(name: impl Into<String>, style: Style, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::with_bars(name, style, points.into_iter().map(|(x, y)| [x, y, 0.0]))
    }

    /// A curve with error bars.
    pub fn with_bars(
        name: impl Into<String>,
        style: Style,
        bars: impl IntoIterator<Item = [f64; 3]>,
    ) -> Self {
        Self { name: name.into(), style, points: bars.into_iter().collect(), look: None, dashes: 0 }
    }

    /// A data curve whose error bars are the standard errors, where these are known.
    pub fn measured(name: impl Into<String>, points: impl IntoIterator<Item = (f64, Estimate)>) -> Self {
        let points = points.into_iter().map(|(x, y)| [x, y.value, y.standard_error.unwrap_or(0.0)]);
        Self::with_bars(name, Style::Data, points)
    }

    /// Whether there is anything to show.
    pub fn has_points(&self) -> bool {
        self.points.iter().any(|p| p[1].is_finite())
    }

    /// Breaks the curve at the requested abscissae that have no point.
    pub fn asked_at(mut self, requested: &[f64]) -> Self {
        let has_point = |x: f64| self.points.iter().any(|p| (p[0] - x).abs() < SAME);
        let missing: Vec<_> =
            requested.iter().filter(|&&x| !has_point(x)).map(|&x| [x, f64::NAN, 0.0]).collect();
        self.points.extend(missing);
        self.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        self
    }

    /// Fixes colour and marker, which otherwise depend on the position of the curve in the chart.
    pub fn looking(self, colour: usize, marker: usize) -> Self {
        Self { look: Some([colour, marker]), ..self }
    }

    /// Dashes the line, to distinguish it from others of the same colour and marker.
    pub fn dashed(self, dashes: usize) -> Self {
        Self { dashes, ..self }
    }

    /// Guide line C x^slope through the last point of another curve, over its range.
    pub fn guide(name: impl Into<String>, along: &Curve, slope: f64) -> Self {
        let last = along.points.last().copied().unwrap_or([1.0; 3]);
        let points = along.points.iter().map(|p| (p[0], last[1] * (p[0] / last[0]).powf(slope)));
        Self::new(name, Style::Guide, points)
    }

    /// Slope of a least-squares line through the logarithms, with its standard error; `None` for
    /// fewer than four points.
    pub fn exponent(&self) -> Option<Estimate> {
        let points: Vec<[f64; 2]> = self.points.iter().map(|p| [p[0].ln(), p[1].ln()]).collect();
        if points.len() < FEWEST_POINTS {
            return None;
        }
        let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64;
        let x = mean(0);
        let y = mean(1);
        let square: f64 = points.iter().map(|p| (p[0] - x).powi(2)).sum();
        let slope = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / square;
        let variance = points.iter().map(|p| (p[1] - y - slope * (p[0] - x)).powi(2)).sum::<f64>()
            / (points.len() - 2) as f64;
        Some(Estimate { value: slope, standard_error: Some((variance / square).sqrt()) })
    }
}

/// Number of different markers.
const MARKERS: usize = 7;

/// Outline of marker `k` in pixels around the point: disc, triangle, square, diamond, triangle on
/// its tip, plus and hourglass.
pub(super) fn marker(k: usize) -> Vec<(i32, i32)> {
    match k % MARKERS {
        0 => vec![(-1, -4), (1, -4), (4, -1), (4, 1), (1, 4), (-1, 4), (-4, 1), (-4, -1)],
        1 => vec![(0, -5), (5, 4), (-5, 4)],
        2 => vec![(-4, -4), (4, -4), (4, 4), (-4, 4)],
        3 => vec![(0, -6), (6, 0), (0, 6), (-6, 0)],
        4 => vec![(0, 5), (5, -4), (-5, -4)],
        5 => PLUS.to_vec(),
        _ => vec![(-4, -5), (4, -5), (0, 0), (4, 5), (-4, 5), (0, 0)],
    }
}

const PLUS: [(i32, i32); 12] = [
    (-1, -5),
    (1, -5),
    (1, -1),
    (5, -1),
    (5, 1),
    (1, 1),
    (1, 5),
    (-1, 5),
    (-1, 1),
    (-5, 1),
    (-5, -1),
    (-1, -1),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// *Planted*: an exponent of two points, and none of its error.
    #[test]
    fn an_exponent_has_an_error_and_needs_four_points() {
        let of = |points: &[(f64, f64)]| Curve::new("", Style::Data, points.iter().copied()).exponent();
        assert_eq!(of(&[(1.0, 1.0), (2.0, 4.0), (4.0, 16.0)]), None);
        let exact = of(&[(1.0, 3.0), (2.0, 12.0), (4.0, 48.0), (8.0, 192.0)]).unwrap();
        assert!((exact.value - 2.0).abs() < 1e-12 && exact.standard_error.unwrap() < 1e-12, "{exact:?}");
        // ln y = ±0.1 about a line over ln x = 0 … 3: slope −0.04, variance 0.032/2, Σx² 5
        let rough = of(&[0.1, -0.1, 0.1, -0.1].map({
            let mut k = 0.0;
            move |e: f64| {
                k += 1.0;
                ((k - 1.0f64).exp(), e.exp())
            }
        }))
        .unwrap();
        let error = rough.standard_error.unwrap();
        assert!((rough.value + 0.04).abs() < 1e-12 && (error - 0.0032f64.sqrt()).abs() < 1e-12, "{rough:?}");
    }

    #[test]
    fn what_was_asked_for_and_is_not_there_is_missing_in_its_place() {
        let exact = |value: f64| Estimate { value, standard_error: None };
        let curve = Curve::measured("a", [(400.0, exact(1.0)), (500.0, exact(2.0))]);
        let curve = curve.asked_at(&[400.0, 450.0, 500.0 + 1e-9]);
        assert_eq!(curve.points.iter().map(|p| p[0]).collect::<Vec<_>>(), [400.0, 450.0, 500.0]);
        assert!(curve.points[1][1].is_nan());
    }

    #[test]
    fn markers_differ() {
        let all: std::collections::HashSet<_> = (0..MARKERS).map(marker).collect();
        assert_eq!(all.len(), MARKERS);
    }
}
