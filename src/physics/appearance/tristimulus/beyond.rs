//! Visible light outside a wavelength grid: represented by the ends of the grid, with an error
//! estimate.

use super::{Colorimeter, light_times_observer};
use crate::appearance::viewing::Viewing;

/// Range that a colour needs, nm. Plain sums over 400–700 nm are the usual convention of print
/// measurement: light beyond is excluded for sample and white alike.
pub const COLOUR_RANGE_NM: [f64; 2] = [400.0, 700.0];

/// Largest fraction of white's X, Y or Z that may lie outside the grid: under D65, the range below
/// about 441 nm or above about 609 nm.
pub const MOST_OUTSIDE: f64 = 0.25;

/// Standard error per nm of a spectrum beyond the end of the grid; the drift predicted by the slope
/// at the end counts once more, …
const DRIFT_PER_NM: f64 = 0.003;
/// … up to this limit. *Measured* on 200 smooth random spectra like those of prints: test
/// `cut_spectra_keep_their_colour`.
const MOST_DRIFT: f64 = 0.4;
/// Distance over which the slope at the end is estimated, nm.
const SLOPE_OVER_NM: f64 = 10.0;

/// One end of a grid and the spectral range beyond it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SpectrumEnd {
    /// Grid indices of the end, and of an inner wavelength from which the slope is estimated.
    nodes: [usize; 2],
    /// Distance between these two, nm.
    run_nm: f64,
    /// Distance from the end, nm, and weight of X, Y, Z there.
    beyond: Vec<(f64, [f64; 3])>,
}

impl SpectrumEnd {
    /// Both ends of a grid that is summed with step `step_nm`.
    pub(super) fn both(grid: &[f64], step_nm: f64, viewing: &Viewing) -> [Self; 2] {
        let last = grid.len() - 1;
        let [from, to] = COLOUR_RANGE_NM;
        let below = steps(grid[0] - from, step_nm, |nm| light_times_observer(grid[0] - nm, viewing));
        let above = steps(to - grid[last], step_nm, |nm| light_times_observer(grid[last] + nm, viewing));
        [Self::new(grid, 0, below), Self::new(grid, last, above)]
    }

    fn new(grid: &[f64], end: usize, beyond: Vec<(f64, [f64; 3])>) -> Self {
        let last = grid.len() - 1;
        let far = |j: &usize| (grid[*j] - grid[end]).abs() >= SLOPE_OVER_NM;
        let inner = (1..last).filter(far).min_by_key(|j| j.abs_diff(end)).unwrap_or(last - end);
        Self { nodes: [end, inner], run_nm: (grid[end] - grid[inner]).abs(), beyond }
    }

    /// Scales all weights by a factor.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.beyond.iter_mut().for_each(|(_, weight)| *weight = weight.map(|w| factor * w));
        self
    }

    /// Grid index of the end.
    pub(super) fn node(&self) -> usize {
        self.nodes[0]
    }

    /// X, Y, Z of a perfect white's light beyond the end.
    pub(super) fn white(&self) -> [f64; 3] {
        self.sum(|_| 1.0)
    }

    fn sum(&self, factor: impl Fn(f64) -> f64) -> [f64; 3] {
        std::array::from_fn(|c| self.beyond.iter().map(|(nm, weight)| factor(*nm) * weight[c]).sum())
    }

    /// Upper (`up`) or lower standard error of X, Y, Z due to light beyond the end: a reflectance
    /// factor stays between 0 and 1.
    fn drift(&self, values: &[f64], up: bool) -> [f64; 3] {
        let [end, inner] = self.nodes.map(|j| values[j]);
        let slope = (end - inner).abs() / self.run_nm;
        let room = if up { 1.0 - end } else { end };
        let free = |nm: f64| nm * DRIFT_PER_NM.hypot(slope);
        let sign = if up { 1.0 } else { -1.0 };
        self.sum(|nm| sign * (MOST_DRIFT * (1.0 - (-free(nm) / MOST_DRIFT).exp())).min(room.max(0.0)))
    }
}

/// Equal steps of at most `step_nm` across a gap, each with its weight in a sum with such steps.
fn steps(gap_nm: f64, step_nm: f64, weight: impl Fn(f64) -> [f64; 3]) -> Vec<(f64, [f64; 3])> {
    let count = (gap_nm / step_nm - 1e-9).ceil().max(0.0) as usize;
    let width = gap_nm / count.max(1) as f64;
    let step = |k: usize| (k as f64 * width, weight(k as f64 * width).map(|w| w * width / step_nm));
    (1..=count).map(step).collect()
}

impl Colorimeter {
    /// Standard errors of Lab due to light beyond each end of the grid; zero where the grid covers
    /// [`COLOUR_RANGE_NM`]. `values` are the spectrum on the grid, `xyz` its tristimulus values.
    pub fn beyond(&self, values: &[f64], xyz: [f64; 3]) -> [[f64; 3]; 2] {
        let moved = |end: &SpectrumEnd, up: bool| self.lab_moved(xyz, end.drift(values, up));
        self.ends.each_ref().map(|end| longer([moved(end, true), moved(end, false)]))
    }

    pub(super) fn lab_moved(&self, xyz: [f64; 3], by: [f64; 3]) -> [f64; 3] {
        let here = self.colour_of(xyz).lab;
        let there = self.colour_of(std::array::from_fn(|c| xyz[c] + by[c])).lab;
        std::array::from_fn(|i| there[i] - here[i])
    }

    /// Standard error of Y due to light beyond both ends.
    pub fn beyond_luminance(&self, values: &[f64]) -> f64 {
        let drift = |end: &SpectrumEnd| end.drift(values, true)[1].max(-end.drift(values, false)[1]);
        self.ends.iter().map(drift).fold(0.0, f64::hypot)
    }
}

fn longer([a, b]: [[f64; 3]; 2]) -> [f64; 3] {
    let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    if square(&a) >= square(&b) { a } else { b }
}

#[cfg(test)]
#[path = "beyond_tests.rs"]
pub(super) mod tests;
