use super::*;
use crate::sweep::definition::load::{AxisOutline, Outline, Place};

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
    for labels in [&["1 nm", "2 nm"][..], &["1 nm", "2 µm", "4 µm"], &["1", "2", "all"], &["1", "3", "2"]] {
        assert!(!is_continuous(labels, 0), "{labels:?}");
    }
    assert!(!is_continuous(&["1 nm", "2 nm", "4 nm"], 1));
    let three = outline([&["1"], &["1", "2", "3"]]);
    let unsolved = [Some([50.0; 3]), None, Some([50.0; 3])];
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
