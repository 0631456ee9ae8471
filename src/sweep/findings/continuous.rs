//! Interpolation between the solved settings of an axis, for the sliders of the explorer, with the
//! leave-one-out error of the colour. `explore.html` has the same [`weights`] in JavaScript.

use crate::appearance::colour::ciede2000;
use crate::sweep::definition::load::{AxisOutline, Outline};
use serde::Serialize;
use std::collections::BTreeMap;

/// Fewest settings to interpolate between: an inner one must be left out.
const FEWEST: usize = 3;

/// An axis whose settings are numbers, all with results.
#[derive(Debug, Serialize)]
pub(super) struct Continuous {
    /// Numbers of the settings, rising or falling.
    pub values: Vec<f64>,
    /// Whether their logarithms are interpolated instead, because the median is smaller.
    pub logarithmic: bool,
    /// Median of all leave-one-out errors, ΔE₀₀.
    pub median: f64,
    /// ΔE₀₀ between each variant's colour and that interpolated from the others along the axis;
    /// `None` for the first and last setting.
    pub left_out: Vec<Option<f64>>,
}

impl Continuous {
    /// Axis `a`, with L*, a*, b* of every variant; `None` if it has fewer than three numbers or one
    /// of its variants has no colour.
    pub fn new(outline: &Outline, labs: &[Option<[f64; 3]>], a: usize) -> Option<Self> {
        let values = numbers(&outline.axes[a]).filter(|values| values.len() >= FEWEST)?;
        let lines = lines(outline, a)?;
        let labs = labs.iter().copied().collect::<Option<Vec<_>>>()?;
        let logarithms = values[0].min(values[values.len() - 1]) > 0.0;
        let judged = [false, true].into_iter().filter(|&log| logarithms || !log).filter_map(|logarithmic| {
            let xs: Vec<f64> = values.iter().map(|&x| if logarithmic { x.ln() } else { x }).collect();
            let left_out = left_out(&xs, &lines, &labs);
            Some(Self { values: values.clone(), logarithmic, median: median(&left_out)?, left_out })
        });
        judged.min_by(|one, other| one.median.total_cmp(&other.median))
    }
}

/// The numbers of an axis if all labels are numbers with one unit, in order.
pub(super) fn numbers(axis: &AxisOutline) -> Option<Vec<f64>> {
    let values: Vec<f64> = (0..axis.labels.len()).map(|k| axis.number(k)).collect::<Option<_>>()?;
    let one_unit =
        axis.labels.windows(2).all(|l| l[0].split_whitespace().nth(1) == l[1].split_whitespace().nth(1));
    let in_order = values.is_sorted_by(|x, y| x < y) || values.is_sorted_by(|x, y| x > y);
    (one_unit && in_order).then_some(values)
}

/// The variants along an axis, for every combination of the other settings; `None` if some are
/// missing.
pub(super) fn lines(outline: &Outline, a: usize) -> Option<Vec<Vec<usize>>> {
    let settings = outline.axes[a].labels.len();
    let mut lines: BTreeMap<Vec<usize>, Vec<Option<usize>>> = BTreeMap::new();
    for (v, variant) in outline.variants.iter().enumerate() {
        let mut others = variant.place.clone();
        let k = others.remove(a);
        lines.entry(others).or_insert_with(|| vec![None; settings])[k] = Some(v);
    }
    lines.into_values().map(|line| line.into_iter().collect()).collect()
}

/// Leave-one-out errors of all variants, ΔE₀₀.
fn left_out(xs: &[f64], lines: &[Vec<usize>], labs: &[[f64; 3]]) -> Vec<Option<f64>> {
    let mut errors = vec![None; labs.len()];
    for k in 1..xs.len() - 1 {
        let mut others = xs.to_vec();
        let x = others.remove(k);
        let weights = weights(&others, k - 1, (x - xs[k - 1]) / (xs[k + 1] - xs[k - 1]));
        for line in lines {
            let near = line.iter().filter(|&&v| v != line[k]).zip(&weights);
            let lab = near.fold([0.0; 3], |sum, (&v, w)| std::array::from_fn(|i| sum[i] + w * labs[v][i]));
            errors[line[k]] = Some(ciede2000(lab, labs[line[k]]));
        }
    }
    errors
}

fn median(errors: &[Option<f64>]) -> Option<f64> {
    let mut all: Vec<f64> = errors.iter().flatten().copied().collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied()
}

/// Weights of values at `xs` for the point `t` = 0…1 between `xs[k]` and `xs[k + 1]`: the cubic
/// whose slope at an inner `x` is that of the chord through both neighbours, so that uneven
/// distances cause no large overshoot; at an end the parabola, with two values the line.
fn weights(xs: &[f64], k: usize, t: f64) -> Vec<f64> {
    let h = xs[k + 1] - xs[k];
    let inner = [k > 0, k + 2 < xs.len()];
    let (here, there) = (h * t * (1.0 - t).powi(2), -h * t * t * (1.0 - t));
    // by how much the slopes at both ends differ from that of the line
    let bends = match inner {
        [true, true] => [here, there],
        [true, false] => [here - there, 0.0],
        [false, true] => [0.0, there - here],
        [false, false] => [0.0; 2],
    };
    let mut weights = vec![0.0; xs.len()];
    (weights[k], weights[k + 1]) = (1.0 - t, t);
    for (bend, [i, j]) in bends.into_iter().zip([[k.saturating_sub(1), k + 1], [k, k + 2]]) {
        if bend != 0.0 {
            let chord = bend / (xs[j] - xs[i]);
            weights[j] += chord;
            weights[i] -= chord;
            weights[k + 1] -= bend / h;
            weights[k] += bend / h;
        }
    }
    weights
}

#[cfg(test)]
#[path = "continuous_tests.rs"]
mod tests;
