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
        let values = numbers(&outline.axes[a])?;
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
fn numbers(axis: &AxisOutline) -> Option<Vec<f64>> {
    let values: Vec<f64> = (0..axis.labels.len()).map(|k| axis.number(k)).collect::<Option<_>>()?;
    let one_unit =
        axis.labels.windows(2).all(|l| l[0].split_whitespace().nth(1) == l[1].split_whitespace().nth(1));
    let in_order = values.is_sorted_by(|x, y| x < y) || values.is_sorted_by(|x, y| x > y);
    (one_unit && in_order && values.len() >= FEWEST).then_some(values)
}

/// The variants along an axis, for every combination of the other settings; `None` if some are
/// missing.
fn lines(outline: &Outline, a: usize) -> Option<Vec<Vec<usize>>> {
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
            let neighbours = line.iter().filter(|&&v| v != line[k]).zip(&weights);
            let lab =
                neighbours.fold([0.0; 3], |sum, (&v, w)| std::array::from_fn(|i| sum[i] + w * labs[v][i]));
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
    let (h, inner) = (xs[k + 1] - xs[k], [k > 0, k + 2 < xs.len()]);
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
mod tests {
    use super::*;
    use crate::sweep::definition::load::Place;

    fn outline(labels: [&[&str]; 2]) -> Outline {
        let axis = |labels: &[&str]| AxisOutline {
            name: "size".into(),
            labels: labels.iter().map(|l| (*l).to_owned()).collect(),
            unit: String::new(),
        };
        let place = |i: usize, j: usize| Place { name: format!("{i}-{j}"), place: vec![i, j] };
        let inner = labels[1].len();
        Outline {
            title: String::new(),
            axes: labels.map(axis).to_vec(),
            sheet: Default::default(),
            reference: 0,
            reference_asked: false,
            claims: Vec::new(),
            variants: (0..labels[0].len() * inner).map(|v| place(v / inner, v % inner)).collect(),
        }
    }

    /// L* = 50 + x² at −2, …, 2, two times: without an inner x the cubic (at 0: slopes −1 and 1 at
    /// −1 and 1) and the parabolas (at −1 and 1) miss by 1/2, where lines miss by 1.
    /// *Planted*: without the bends this gives the errors of lines.
    #[test]
    fn leaving_one_out_of_a_parabola_misses_by_a_half() {
        let outline = outline([&["red", "blue"], &["-2 nm", "-1 nm", "0 nm", "1 nm", "2 nm"]]);
        let lab = |x: f64| [50.0 + x * x, 0.0, 0.0];
        let labs: Vec<_> = (0..10).map(|v| Some(lab(f64::from(v % 5) - 2.0))).collect();
        let axis = Continuous::new(&outline, &labs, 1).unwrap();
        let missed = |v: usize| labs[v].map(|[l, ..]| ciede2000([l + 0.5, 0.0, 0.0], [l, 0.0, 0.0]));
        for v in 0..10 {
            let expected = (1..4).contains(&(v % 5)).then(|| missed(v).unwrap());
            assert!((axis.left_out[v].unwrap_or(9.0) - expected.unwrap_or(9.0)).abs() < 1e-9, "{axis:?}");
        }
        assert!(axis.values == [-2.0, -1.0, 0.0, 1.0, 2.0] && !axis.logarithmic);
        assert!((axis.median - missed(1).unwrap()).abs() < 1e-9, "{axis:?}");
    }

    #[test]
    fn a_colour_linear_in_the_logarithm_is_interpolated_in_it() {
        let outline = outline([&["1"], &["800", "400", "200", "100"]]);
        let labs = [60.0, 50.0, 40.0, 30.0].map(|l| Some([l, 0.0, 0.0]));
        let axis = Continuous::new(&outline, &labs, 1).unwrap();
        assert!(axis.logarithmic && axis.median < 1e-9, "{axis:?}");
    }

    #[test]
    fn axes_with_two_values_words_or_gaps_stay_discrete() {
        let is_continuous = |labels: &[&str], gaps: usize| {
            let mut outline = outline([&["1", "2"], labels]);
            outline.variants.truncate(outline.variants.len() - gaps);
            Continuous::new(&outline, &vec![Some([50.0, 0.0, 0.0]); outline.variants.len()], 1).is_some()
        };
        assert!(is_continuous(&["1 nm", "2 nm", "4 nm"], 0));
        for labels in [&["1 nm", "2 nm"][..], &["1 nm", "2 µm", "4 µm"], &["1", "2", "all"], &["1", "3", "2"]]
        {
            assert!(!is_continuous(labels, 0), "{labels:?}");
        }
        assert!(!is_continuous(&["1 nm", "2 nm", "4 nm"], 1));
        let (three, unsolved) =
            (outline([&["1"], &["1", "2", "3"]]), [Some([50.0; 3]), None, Some([50.0; 3])]);
        assert!(Continuous::new(&three, &unsolved, 1).is_none());
    }

    #[test]
    fn weights_reproduce_lines_and_settings() {
        let xs = [1.0, 2.0, 5.0, 20.0];
        for (k, t) in [(0, 0.3), (1, 0.5), (2, 0.9), (2, 1.0)] {
            let weights = weights(&xs, k, t);
            let x: f64 = weights.iter().zip(xs).map(|(w, x)| w * x).sum();
            assert!((x - (xs[k] + t * (xs[k + 1] - xs[k]))).abs() < 1e-12, "{weights:?}");
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{weights:?}");
        }
        assert_eq!(weights(&xs, 1, 0.0), [0.0, 1.0, 0.0, 0.0]);
    }
}
