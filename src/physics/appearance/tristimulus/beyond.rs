//! Visible light outside a grid of wavelengths: the ends of the grid stand for it, with an error that holds what it could be.

use super::{Colorimeter, light_times_observer};
use crate::appearance::viewing::Viewing;

/// What a colour needs, nm. Plain sums over 400–700 nm are the usual convention of print measurement: light beyond is
/// left out of the sample and of white alike.
pub const COLOUR_RANGE_NM: [f64; 2] = [400.0, 700.0];

/// Largest share of X, Y or Z of white that may lie outside the grid: up to about 441 nm or from about 609 nm on under D65.
pub const MOST_OUTSIDE: f64 = 0.25;

/// How far a spectrum strays from its value at the end of the grid, a standard error: this much a nm, and once more what
/// its slope there would make of the distance, …
const DRIFT_PER_NM: f64 = 0.003;
/// … but hardly more than this. *Measured* on 200 smooth random spectra like those of prints: test `cut_spectra_keep_their_colour`.
const MOST_DRIFT: f64 = 0.4;
/// Distance over which the slope at the end is taken, nm.
const SLOPE_OVER_NM: f64 = 10.0;

/// One end of a grid, and the light beyond it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SpectrumEnd {
    /// Places in the grid: of the end, and of a wavelength inside that tells the slope.
    nodes: [usize; 2],
    /// Between these two, nm.
    run_nm: f64,
    /// Distance from the end, nm, and weight of X, Y, Z there.
    beyond: Vec<(f64, [f64; 3])>,
}

impl SpectrumEnd {
    /// Both ends of a grid that is summed in steps of `step_nm`.
    pub(super) fn both(grid: &[f64], step_nm: f64, viewing: &Viewing) -> [Self; 2] {
        let last = grid.len() - 1;
        let far = |a: usize, b: usize| (grid[a] - grid[b]).abs() >= SLOPE_OVER_NM;
        let after_first = (1..last).find(|&j| far(j, 0)).unwrap_or(last);
        let before_last = (1..last).rev().find(|&j| far(j, last)).unwrap_or(0);
        let [from, to] = COLOUR_RANGE_NM;
        let below = |nm: f64| light_times_observer(grid[0] - nm, viewing);
        let above = |nm: f64| light_times_observer(grid[last] + nm, viewing);
        let run_nm = |[end, inner]: [usize; 2]| (grid[end] - grid[inner]).abs();
        let nodes = [[0, after_first], [last, before_last]];
        let (first, second) = (steps(grid[0] - from, step_nm, below), steps(to - grid[last], step_nm, above));
        [
            Self { nodes: nodes[0], run_nm: run_nm(nodes[0]), beyond: first },
            Self { nodes: nodes[1], run_nm: run_nm(nodes[1]), beyond: second },
        ]
    }

    /// Weights times a factor.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.beyond.iter_mut().for_each(|(_, weight)| *weight = weight.map(|w| factor * w));
        self
    }

    /// Place of the end in the grid.
    pub(super) fn node(&self) -> usize {
        self.nodes[0]
    }

    /// X, Y, Z of a perfect white's light beyond the end.
    pub(super) fn white(&self) -> [f64; 3] {
        self.sum(|_| 1.0)
    }

    fn sum(&self, of: impl Fn(f64) -> f64) -> [f64; 3] {
        std::array::from_fn(|c| self.beyond.iter().map(|(nm, weight)| of(*nm) * weight[c]).sum())
    }

    /// By how much more (`up`) or less light beyond the end may move X, Y, Z, a standard error each: a reflectance factor
    /// stays between 0 and 1.
    fn drift(&self, values: &[f64], up: bool) -> [f64; 3] {
        let [end, inner] = self.nodes.map(|j| values[j]);
        let slope = (end - inner).abs() / self.run_nm;
        let room = if up { 1.0 - end } else { end };
        let free = |nm: f64| nm * DRIFT_PER_NM.hypot(slope);
        let sign = if up { 1.0 } else { -1.0 };
        self.sum(|nm| sign * (MOST_DRIFT * (1.0 - (-free(nm) / MOST_DRIFT).exp())).min(room.max(0.0)))
    }
}

/// Equal steps of at most `step_nm` across a gap, with the weight that each has in a sum with such steps.
fn steps(gap_nm: f64, step_nm: f64, weight: impl Fn(f64) -> [f64; 3]) -> Vec<(f64, [f64; 3])> {
    let count = (gap_nm / step_nm - 1e-9).ceil().max(0.0) as usize;
    let width = gap_nm / count.max(1) as f64;
    let at = |k: usize| (k as f64 * width, weight(k as f64 * width).map(|w| w * width / step_nm));
    (1..=count).map(at).collect()
}

impl Colorimeter {
    /// What the light beyond each end of the grid may move Lab by, a standard error each; zero where the grid covers
    /// [`COLOUR_RANGE_NM`]. `values` are the spectrum on the grid, `xyz` its tristimulus values.
    pub fn beyond(&self, values: &[f64], xyz: [f64; 3]) -> [[f64; 3]; 2] {
        let moved = |end: &SpectrumEnd, up: bool| self.lab_moved(xyz, end.drift(values, up));
        self.ends.each_ref().map(|end| longer([moved(end, true), moved(end, false)]))
    }

    fn lab_moved(&self, xyz: [f64; 3], by: [f64; 3]) -> [f64; 3] {
        let here = self.colour_of(xyz).lab;
        let there = self.colour_of(std::array::from_fn(|c| xyz[c] + by[c])).lab;
        std::array::from_fn(|i| there[i] - here[i])
    }

    /// What it may move Y by, a standard error of both ends together.
    pub fn beyond_luminance(&self, values: &[f64]) -> f64 {
        let of = |end: &SpectrumEnd| end.drift(values, true)[1].max(-end.drift(values, false)[1]);
        self.ends.iter().map(of).fold(0.0, f64::hypot)
    }
}

fn longer([a, b]: [[f64; 3]; 2]) -> [f64; 3] {
    let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    if square(&a) >= square(&b) { a } else { b }
}

#[cfg(test)]
#[path = "beyond_tests.rs"]
mod tests;
