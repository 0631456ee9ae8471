//! The start of a fit: a global search on a coarse table.
//!
//! Scattering grows as (n − n_binder)², so that without fringes two branches of n fit, and
//! Gauss–Newton stalls between them. A table of solves with derivatives at a few (n, √κ) gives the
//! differences from the coherent film everywhere, and dynamic programming over the wavelengths
//! finds the smooth path of n and κ that fits best, on both branches and on each alone. √κ is the
//! variable in which reflectance is smooth near κ = 0.

use super::data::{few_cells, jackknife};
use super::load::FitTask;
use super::response::{Origin, Response, Spectra};
use crate::evaluate::seen::NoInk;
use ndarray::Array4;
use rayon::prelude::*;

/// Nodes of the table in n, and values of √(κ/κ_max) in κ.
const NODES_N: usize = 4;
const NODES_ROOT: [f64; 3] = [0.1, 0.4, 1.0];
/// Grid of the search in n and in √κ.
const SEARCH: [usize; 2] = [33, 25];
/// Error of the table's values, of its few cells and of the interpolation, in the search and in the
/// descent on the table.
pub(super) const TABLE_ERROR: f64 = 0.008;
/// Cells of the table.
pub(super) const TABLE_CELLS: usize = 2;
/// Straight line, parabola and cubic on the nodes in n, orthogonal to one another: sums of squares
/// 5, 4 and 20.
const LINEAR: [f64; NODES_N] = [-1.5, -0.5, 0.5, 1.5];
const BENT: [f64; NODES_N] = [1.0, -1.0, -1.0, 1.0];
const MISSED: [f64; NODES_N] = [-1.0, 3.0, -3.0, 1.0];
/// Expected change of n and κ over 20 nm.
const CHANGE: f64 = 0.04;

/// Differences from the film at the nodes: drawdown → wavelength → n → √κ → \[value, d/dn, d/d√κ\].
pub struct Surface {
    n: Vec<f64>,
    roots: Vec<f64>,
    nodes: Array4<[f64; 3]>,
}

impl Surface {
    /// Indices at which solves are needed, for each wavelength the same.
    pub fn indices(task: &FitTask) -> Vec<[f64; 2]> {
        let (n, roots) = Self::axes(task);
        n.iter().flat_map(|&n| roots.iter().map(move |root| [n, root * root])).collect()
    }

    fn axes(task: &FitTask) -> (Vec<f64>, Vec<f64>) {
        let [from, to] = task.settings.n;
        let [_, most] = task.settings.kappa;
        let n = (0..NODES_N).map(|i| from + (to - from) * i as f64 / (NODES_N - 1) as f64).collect();
        (n, NODES_ROOT.iter().map(|share| share * most.sqrt()).collect())
    }

    /// The table, from the responses at [`Surface::indices`] and those of the film there.
    pub fn new(task: &FitTask, solved: &[Response], films: &[Response]) -> Self {
        let (n, roots) = Self::axes(task);
        let shape = (task.measured.len(), task.wavelengths_nm().len(), n.len(), roots.len());
        let nodes = Array4::from_shape_fn(shape, |(d, w, i, j)| {
            let solved = &solved[i * roots.len() + j];
            let film = &films[i * roots.len() + j];
            let [along, across] = [0, 1].map(|k| solved.slopes[k][d][w] - film.slopes[k][d][w]);
            [solved.values[d][w] - film.values[d][w], along, 2.0 * roots[j] * across]
        });
        Self { n, roots, nodes }
    }

    /// The difference of a drawdown from its film at an index, with d/dn and d/dκ.
    pub fn at(&self, drawdown: usize, wave: usize, [n, kappa]: [f64; 2]) -> [f64; 3] {
        let root = kappa.max(1e-12).sqrt();
        let (j, s) = place(&self.roots, root);
        let ds = self.roots[j + 1] - self.roots[j];
        let [lower, upper] = [j, j + 1].map(|j| self.row(drawdown, wave, j, n));
        let [mut value, mut across] = hermite([lower[0], upper[0]], [lower[2], upper[2]], s, ds);
        let [along, _] = hermite([lower[1], upper[1]], [lower[3], upper[3]], s, ds);
        if root < self.roots[0] {
            across = lower[2];
            value += across * (root - self.roots[0]);
        }
        [value, along, across / (2.0 * root.max(0.25 * self.roots[0]))]
    }

    /// At one node of √κ: value, d/dn, d/d√κ and the derivative of that along n.
    fn row(&self, drawdown: usize, wave: usize, j: usize, n: f64) -> [f64; 4] {
        let (i, t) = place(&self.n, n);
        let dn = self.n[i + 1] - self.n[i];
        let [a, b] = [i, i + 1].map(|i| self.nodes[[drawdown, wave, i, j]]);
        let [value, along] = hermite([a[0], b[0]], [a[1], b[1]], t, dn);
        [value, along, a[2] + t * (b[2] - a[2]), (b[2] - a[2]) / dn]
    }

    /// The derivative along n of the parabola through the nodes, which averages over all of the
    /// range, and its variance for values at the nodes of this variance and those that it misses.
    fn trend(&self, (d, w): (usize, usize), [n, kappa]: [f64; 2], variance: f64) -> [f64; 2] {
        let (j, s) = place(&self.roots, kappa.max(0.0).sqrt());
        let node = |i: usize| {
            let [low, high] = [j, j + 1].map(|j| self.nodes[[d, w, i, j]][0]);
            low + s * (high - low)
        };
        let part =
            |weights: [f64; NODES_N]| weights.iter().enumerate().map(|(i, a)| a * node(i)).sum::<f64>();
        let step = (self.n[NODES_N - 1] - self.n[0]) / (NODES_N - 1) as f64;
        let t = ((n - 0.5 * (self.n[0] + self.n[NODES_N - 1])) / step).clamp(-1.5, 1.5);
        let slope = part(LINEAR) / 5.0 + 2.0 * t * part(BENT) / 4.0;
        let all = variance + part(MISSED).powi(2) / 20.0;
        [slope / step, all * (0.2 + t * t) / (step * step)]
    }

    /// Replaces derivatives along n at solves of all cells by means of these and of the table's
    /// trend, each with the inverse of its variance. Where nothing absorbs, cells have resonances:
    /// their derivatives hold at the place alone, and would make steps too short and errors too
    /// small.
    ///
    /// # Errors
    /// The film on its card gives no spectrum.
    pub fn steady(
        &self,
        task: &FitTask,
        response: &mut Response,
        index: &[[f64; 2]],
        log: f64,
    ) -> Result<(), NoInk> {
        let film = Origin::Film.response(task, &task.measured, index, log)?;
        for d in 0..task.measured.len() {
            let cells = response.replicates[d].len();
            for (w, &eta) in index.iter().enumerate() {
                let variance = |all: &[Vec<f64>]| {
                    let one: Vec<f64> = all.iter().map(|cell| cell[w]).collect();
                    few_cells(cells) * jackknife(&one, &one)
                };
                let own = variance(&response.slope_replicates[d]);
                let more_cells = cells as f64 / TABLE_CELLS.min(cells).max(1) as f64;
                let of_nodes = more_cells * variance(&response.replicates[d]);
                let [slope, of_trend] = self.trend((d, w), eta, of_nodes);
                let share = own / (own + of_trend).max(f64::MIN_POSITIVE);
                let along = &mut response.slopes[0][d][w];
                *along += share * (film.slopes[0][d][w] + slope - *along);
            }
        }
        Ok(())
    }

    /// Reflectances with derivatives at an index for every wavelength: the exact film and these
    /// differences.
    ///
    /// # Errors
    /// The film on its card gives no spectrum.
    pub fn response(&self, task: &FitTask, index: &[[f64; 2]], log: f64) -> Result<Response, NoInk> {
        let mut response = Origin::Film.response(task, &task.measured, index, log)?;
        for d in 0..task.measured.len() {
            for (w, &eta) in index.iter().enumerate() {
                let [value, along, across] = self.at(d, w, eta);
                response.values[d][w] += value;
                response.slopes[0][d][w] += along;
                response.slopes[1][d][w] += across;
            }
        }
        Ok(response)
    }
}

/// The interval of a rising list that a value lies in, and its place there, 0 to 1.
fn place(list: &[f64], x: f64) -> (usize, f64) {
    let i = (list.partition_point(|&node| node <= x).max(1) - 1).min(list.len() - 2);
    (i, ((x - list[i]) / (list[i + 1] - list[i])).clamp(0.0, 1.0))
}

/// Cubic through values with derivatives at both ends of an interval of length `h`: value and
/// derivative at the place t.
fn hermite([a, b]: [f64; 2], [da, db]: [f64; 2], t: f64, h: f64) -> [f64; 2] {
    let slope = (b - a) / h;
    let s = 1.0 - t;
    let value = a * s + b * t + h * t * s * ((da - slope) * s - (db - slope) * t);
    let derivative = slope + (da - slope) * s * (s - 2.0 * t) + (db - slope) * t * (t - 2.0 * s);
    [value, derivative]
}

/// The search's grid of \[n, κ\], n first.
fn grid(task: &FitTask) -> Vec<[f64; 2]> {
    let [from, to] = task.settings.n;
    let [least, most] = task.settings.kappa;
    let share = |i: usize, axis: usize| i as f64 / (SEARCH[axis] - 1) as f64;
    let root = |j: usize| least.sqrt() + (most.sqrt() - least.sqrt()) * share(j, 1);
    (0..SEARCH[0])
        .flat_map(|i| (0..SEARCH[1]).map(move |j| [from + (to - from) * share(i, 0), root(j).powi(2)]))
        .collect()
}

/// Paths of n and κ over the wavelengths that fit best, one in each window of n.
///
/// # Errors
/// The film gives no spectrum at any index.
pub fn paths(task: &FitTask, surface: &Surface) -> Result<Vec<Vec<[f64; 2]>>, NoInk> {
    let nm = task.wavelengths_nm();
    let states = grid(task);
    let films: Vec<Option<Spectra>> = states.par_iter().map(|eta| film(task, *eta)).collect();
    let mut costs = vec![vec![f64::INFINITY; states.len()]; nm.len()];
    let variance = task.settings.noise.powi(2) + TABLE_ERROR.powi(2);
    for (k, film) in films.iter().enumerate() {
        let Some(film) = film else { continue };
        for (w, costs) in costs.iter_mut().enumerate() {
            let spectra = task.measured.iter().enumerate().filter(|(_, drawdown)| drawdown.values.is_some());
            let misses = spectra.map(|(d, drawdown)| {
                ((film[d][w] + surface.at(d, w, states[k])[0]) - drawdown.measured(w)).powi(2) / variance
            });
            costs[k] = misses.sum();
        }
    }
    let mut paths: Vec<Vec<[f64; 2]>> = Vec::new();
    for [low, high] in windows(task) {
        let allowed: Vec<usize> =
            (0..states.len()).filter(|&k| (low..=high).contains(&states[k][0])).collect();
        let path = best_path(nm, &states, &costs, &allowed);
        paths.extend(path.filter(|path| !paths.contains(path)));
    }
    Ok(paths)
}

/// Ranges of n that are searched each for itself: all of it, below and above the binder's index,
/// and the halves of these, because fringes repeat.
fn windows(task: &FitTask) -> Vec<[f64; 2]> {
    let [from, to] = task.settings.n;
    let binder = task.binder_index();
    let middle = binder.clamp(from, to);
    let mut all = vec![[from, to], [from, middle], [middle, to]];
    for [low, high] in [[from, middle], [middle, to]] {
        let half = 0.5 * (low + high);
        all.extend([[low, half], [half, high]]);
    }
    all
}

/// Spectra of the film of one index; none where it has no spectrum.
fn film(task: &FitTask, eta: [f64; 2]) -> Option<Spectra> {
    let index = vec![eta; task.wavelengths_nm().len()];
    let all = Origin::Film.spectra(task, &task.measured, &index, ([0.0; 2], 0.0)).ok()?;
    Some(all.into_iter().map(|spectrum| spectrum.values).collect())
}

/// The cheapest path through the allowed states: misfit, and changes from wavelength to wavelength.
fn best_path(
    nm: &[f64],
    states: &[[f64; 2]],
    costs: &[Vec<f64>],
    allowed: &[usize],
) -> Option<Vec<[f64; 2]>> {
    let mut sums: Vec<f64> = allowed.iter().map(|&k| costs[0][k]).collect();
    let mut came: Vec<Vec<usize>> = Vec::new();
    for w in 1..nm.len() {
        let reach = CHANGE * (nm[w] - nm[w - 1]) / 20.0;
        let from = |&k: &usize| -> (f64, usize) {
            let step = |(a, &l): (usize, &usize)| {
                let [x, y] = [0, 1].map(|i| (states[k][i] - states[l][i]) / reach);
                (sums[a] + x * x + y * y, a)
            };
            let best = allowed.iter().enumerate().map(step).min_by(|a, b| a.0.total_cmp(&b.0));
            best.unwrap_or((f64::INFINITY, 0))
        };
        let best: Vec<(f64, usize)> = allowed.par_iter().map(from).collect();
        sums = best.iter().zip(allowed).map(|((sum, _), &k)| sum + costs[w][k]).collect();
        came.push(best.into_iter().map(|(_, a)| a).collect());
    }
    let mut a = (0..allowed.len()).min_by(|&a, &b| sums[a].total_cmp(&sums[b]))?;
    if !sums[a].is_finite() {
        return None;
    }
    let mut path = vec![states[allowed[a]]];
    for came in came.iter().rev() {
        a = came[a];
        path.push(states[allowed[a]]);
    }
    path.reverse();
    Some(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced_with_their_derivative() {
        let f = |x: f64| 1.0 + x - 2.0 * x * x + x * x * x;
        let d = |x: f64| 1.0 - 4.0 * x + 3.0 * x * x;
        for t in [0.0, 0.3, 0.8, 1.0] {
            let [value, derivative] = hermite([f(0.5), f(2.0)], [d(0.5), d(2.0)], t, 1.5);
            let x = 0.5 + 1.5 * t;
            assert!((value - f(x)).abs() < 1e-12 && (derivative - d(x)).abs() < 1e-12, "{t}");
        }
    }

    #[test]
    fn the_cheapest_path_is_found() {
        let states: Vec<[f64; 2]> = (0..5).map(|k| [1.4 + 0.1 * f64::from(k), 0.1]).collect();
        // the cheapest state of every wavelength is a lonely one; the smooth path costs less
        let cost = |w: usize, k: usize| if k == 2 { 1.0 } else { [0.0, 9.0][usize::from(k != 4 * (w % 2))] };
        let costs: Vec<Vec<f64>> = (0..4).map(|w| (0..5).map(|k| cost(w, k)).collect()).collect();
        let nm = [400.0, 420.0, 440.0, 460.0];
        let path = best_path(&nm, &states, &costs, &[0, 1, 2, 3, 4]).unwrap();
        assert!(path.iter().all(|&s| s == states[2]), "{path:?}");
        let low = best_path(&nm, &states, &costs, &[0, 1]).unwrap();
        assert!(low.iter().all(|s| s[0] <= 1.5));
    }

    /// Differences that are a parabola in n have its derivative as their trend, with the variance of
    /// least squares; a cubic beside it is missed, which the variance tells. *Planted*: the
    /// parabola's part left out; half of the distance of the nodes.
    #[test]
    fn the_trend_of_a_parabola_is_its_derivative() {
        let n = vec![1.3, 1.5, 1.7, 1.9];
        let roots = vec![0.1, 0.4, 0.8];
        let surface = |cubic: f64| Surface {
            nodes: Array4::from_shape_fn((1, 1, 4, 3), |(_, _, i, j)| {
                let x: f64 = n[i] - 1.5;
                [0.2 + 0.3 * x + (1.0 + j as f64) * x * x + cubic * MISSED[i], 9.0, 9.0]
            }),
            n: n.clone(),
            roots: roots.clone(),
        };
        for (at, row) in [(1.4, 1.0), (1.6, 1.0), (1.85, 1.0), (1.6, 2.0)] {
            let root: f64 = if row > 1.5 { 0.4 } else { 0.1 };
            let [slope, variance] = surface(0.0).trend((0, 0), [at, root * root], 0.01);
            assert!((slope - (0.3 + 2.0 * row * (at - 1.5))).abs() < 1e-9, "{at} {row}: {slope}");
            // 1/Σ(x − x̄)² in the middle of the nodes, and the parabola's part beside it
            let expected = 0.01 * (0.2 + ((at - 1.6) / 0.2).powi(2)) / 0.04;
            assert!((variance / expected - 1.0).abs() < 1e-9, "{at} {row}: {variance} for {expected}");
        }
        let [_, variance] = surface(0.03).trend((0, 0), [1.6, 0.01], 0.01);
        assert!((variance / ((0.01 + 20.0 * 9e-4) * 0.2 / 0.04) - 1.0).abs() < 1e-9, "{variance}");
    }
}
