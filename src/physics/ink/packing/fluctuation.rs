//! How much the pigment in a window of a wide layer differs from window to window.
//!
//! A small periodic cell that always holds the requested volume fraction lacks these fluctuations,
//! and absorbs more than the layer: T is convex in the pigment's volume, so a window with less of
//! it transmits more than its share. Cells that hold more and less by the standard deviation of the
//! window, in turns, have the mean of the layer (the grand-canonical ensemble in place of the
//! canonical one; the mode k = 0 that the lattice of a periodic cell leaves out).

use super::depth::{DepthLaw, densest};
use super::request::{AUTO_LIMIT, FCC, MethodChoice, PackingRequest, PigmentGrains};
use std::f64::consts::PI;

/// Exponent of 1 − φ in the structure factor at k = 0 after random sequential addition. Measured in
/// cells of 6.4 µm: 0.49–0.56, 0.29, 0.21 at 5, 10, 15 % of spheres of 150–400 nm, 0.16–0.21 for
/// cylinders of 200 nm, each ± 12 %.
const SEQUENTIAL: f64 = 10.5;
/// Share of its envelope that an agglomerate fills: 8 × 100 nm at 15 % has 0.07 ± 0.01.
const FILLED: f64 = 0.6;
/// Relaxation begins with independent places, whose structure factor is 1, and moves grains apart
/// until they fit: exp(−c (d/L)^p) is left of it in the window L. c and p are fitted to spheres of
/// 150, 250 and 400 nm at 20–50 % in windows of 1.2, 1.6 and 2.4 µm, within a fifth of S.
const SMOOTHED: f64 = 1.2;
/// Volume fraction from which relaxation has to move grains far.
const CROWDED: f64 = 0.38;
/// Growth of c above it, per unit of volume fraction.
const CROWDING: f64 = 58.0;
/// Share of the accessible volume that relaxation reaches with any shape. Windows of a layer may
/// hold more; a cell of its own does not. Of cells asked for 50 %, those fail that hold 51.9 % of
/// upright cylinders of 200 nm and 53 % of spheres of 450 nm; of 30 % of agglomerates, 31.4 %.
const REACHED: f64 = 0.54;
/// Quantiles that moments of a distribution of sizes are summed over.
const QUANTILES: usize = 64;

/// One pigment's bodies: grains, or agglomerates of them.
struct PigmentInWindow {
    /// Volume of the pigment in the window, µm³.
    volume_um3: f64,
    /// Mean volume of a body, weighted by volume, µm³.
    body_um3: f64,
    /// Share of its envelope that a body fills.
    filled: f64,
}

/// Bodies of all pigments together.
struct Crowd {
    /// Volume fraction of the bodies' envelopes.
    fraction: f64,
    /// Their mean diameter, µm.
    diameter_um: f64,
}

impl PigmentInWindow {
    /// Volume of the bodies' envelopes in the window, µm³.
    fn envelope_um3(&self) -> f64 {
        self.volume_um3 / self.filled
    }
}

impl PackingRequest {
    /// This cell with volume fractions that differ from those requested by one standard deviation
    /// of a window of the cell's size in a wide layer. `signs`, ± 1 for each pigment, choose the
    /// direction; over all choices mean and covariance are those of the windows. Where the fuller
    /// cells could not be packed, all choices deviate less: T of the layer is then low by at most
    /// half its curvature times the variance left out.
    pub fn fluctuating(&self, signs: &[f64]) -> Self {
        let bodies: Vec<PigmentInWindow> = self.pigments.iter().map(|p| self.bodies(p)).collect();
        let factor = cholesky(&relative_covariance(&bodies, self.structure_factor(&bodies)));
        let part = self.packable(&bodies, &factor);
        let mut moved = Self { usual_fraction: Some(self.usual_fraction()), ..self.clone() };
        for (i, pigment) in moved.pigments.iter_mut().enumerate() {
            let by = part * factor[i].iter().zip(signs).map(|(l, sign)| l * sign).sum::<f64>();
            pigment.volume_fraction *= 1.0 + self.whole(pigment, by);
        }
        moved
    }

    /// Volume fraction of all grains, at the depth where they are densest, by which the method is
    /// chosen.
    pub(super) fn usual_fraction(&self) -> f64 {
        let laws: Vec<Option<DepthLaw>> = self.pigments.iter().map(|p| DepthLaw::of(&p.profile)).collect();
        let fractions: Vec<f64> = self.pigments.iter().map(|p| p.volume_fraction).collect();
        self.usual_fraction.unwrap_or_else(|| densest(&laws, &fractions).min(FCC))
    }

    /// Volume that grains may take, µm³.
    pub(super) fn window_um3(&self) -> f64 {
        let dry_um = self.relief.map_or(self.thickness_um, |relief| relief.dry_um(self.thickness_um));
        self.period_um[0] * self.period_um[1] * dry_um
    }

    fn bodies(&self, pigment: &PigmentGrains) -> PigmentInWindow {
        let together = pigment.agglomeration.as_ref().map_or(1.0, |rule| rule.mean_body());
        PigmentInWindow {
            volume_um3: pigment.volume_fraction * self.window_um3(),
            body_um3: mean_grain_um3(pigment) * together,
            filled: if together > 1.0 { FILLED } else { 1.0 },
        }
    }

    /// Part of the deviations that leaves the fullest cell within reach, 0 to 1.
    fn packable(&self, bodies: &[PigmentInWindow], factor: &[Vec<f64>]) -> f64 {
        let Crowd { fraction, diameter_um } = self.crowd(bodies);
        let room = REACHED / self.accessible(fraction, diameter_um) - 1.0;
        let most = |row: &Vec<f64>| row.iter().map(|l| l.abs()).sum::<f64>();
        let fullest: f64 = bodies.iter().zip(factor).map(|(b, row)| b.envelope_um3() * most(row)).sum();
        (room.max(0.0) * fraction * self.window_um3() / fullest).min(1.0)
    }

    /// How crowded the bodies are.
    fn crowd(&self, bodies: &[PigmentInWindow]) -> Crowd {
        let all: f64 = bodies.iter().map(|b| b.volume_um3).sum();
        let fraction = bodies.iter().map(PigmentInWindow::envelope_um3).sum::<f64>() / self.window_um3();
        let diameters = bodies.iter().map(|b| b.volume_um3 * (6.0 / PI * b.body_um3 / b.filled).cbrt());
        Crowd { fraction, diameter_um: diameters.sum::<f64>() / all }
    }

    /// Structure factor of the bodies' places, averaged over the wave vectors that belong to the
    /// window: the variance of their number over its mean.
    fn structure_factor(&self, bodies: &[PigmentInWindow]) -> f64 {
        let Crowd { fraction, diameter_um } = self.crowd(bodies);
        let crowding = self.accessible(fraction, diameter_um);
        let dilute = self.method == MethodChoice::Auto && crowding <= AUTO_LIMIT;
        if self.equilibration.is_some() {
            percus_yevick(fraction)
        } else if dilute || self.method == MethodChoice::SequentialAddition {
            (1.0 - fraction).powf(SEQUENTIAL)
        } else {
            relaxed(fraction, diameter_um / (self.period_um[0] * self.period_um[1]).sqrt())
        }
    }

    /// Volume fraction where centres may lie, by which the method is chosen.
    pub(super) fn accessible(&self, fraction: f64, diameter_um: f64) -> f64 {
        fraction / (1.0 - if self.walls { 0.5 * diameter_um / self.thickness_um } else { 0.0 })
    }

    /// The step nearest to `by` that whole grains of one size make; any where sizes vary.
    fn whole(&self, pigment: &PigmentGrains, by: f64) -> f64 {
        if pigment.size.has_spread() {
            return by;
        }
        let grains = pigment.volume_fraction * self.window_um3() / mean_grain_um3(pigment);
        (by * grains).round() / grains
    }
}

/// Mean volume of a pigment's grains, weighted by volume, µm³.
fn mean_grain_um3(pigment: &PigmentGrains) -> f64 {
    let template = pigment.shape.template();
    let volume = |k: usize| {
        let nm = pigment.size.quantile_nm((k as f64 + 0.5) / QUANTILES as f64);
        template.volume.um3 * pigment.size.radius_um(nm, &template).powi(3)
    };
    let mut sum = 0.0;
    let mut squares = 0.0;
    for um3 in (0..QUANTILES).map(volume) {
        sum += um3;
        squares += um3 * um3;
    }
    squares / sum
}

/// S of a relaxed packing in a window of `1/smallness` diameters.
fn relaxed(fraction: f64, smallness: f64) -> f64 {
    let moved = 1.0 + CROWDING * (fraction - CROWDED).max(0.0);
    (-moved * smallness.powf(SMOOTHED)).exp()
}

/// S(0) of hard spheres in equilibrium (Percus and Yevick 1958, by compressibility).
fn percus_yevick(fraction: f64) -> f64 {
    (1.0 - fraction).powi(4) / ((1.0 + 2.0 * fraction).powi(2) - 4.0 * fraction.powi(3) + fraction.powi(4))
}

/// Relative covariance of the pigments' volumes, where all bodies' places have the structure factor
/// S and which pigment has which place is chance: Σ n v² δ_ij − (1 − S) w_i w_j / Σ w, w = n v².
fn relative_covariance(bodies: &[PigmentInWindow], structure_factor: f64) -> Vec<Vec<f64>> {
    let weights: Vec<f64> = bodies.iter().map(|b| b.volume_um3 * b.body_um3).collect();
    let sum: f64 = weights.iter().sum();
    let entry = |i: usize, j: usize| {
        let alone = if i == j { weights[i] } else { 0.0 };
        let shared = (1.0 - structure_factor) * weights[i] * weights[j] / sum;
        (alone - shared) / (bodies[i].volume_um3 * bodies[j].volume_um3)
    };
    (0..bodies.len()).map(|i| (0..bodies.len()).map(|j| entry(i, j)).collect()).collect()
}

/// Lower factor L of C = L Lᵀ; rounding below zero counts as zero.
fn cholesky(covariance: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = covariance.len();
    let mut lower = vec![vec![0.0; n]; n];
    for i in 0..n {
        for j in 0..=i {
            let rest = covariance[i][j] - (0..j).map(|k| lower[i][k] * lower[j][k]).sum::<f64>();
            lower[i][j] = match (i == j, lower[j][j] > 0.0) {
                (true, _) => rest.max(0.0).sqrt(),
                (false, true) => rest / lower[j][j],
                (false, false) => 0.0,
            };
        }
    }
    lower
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::pack;
    use num_complex::Complex64;
    use std::f64::consts::TAU;

    fn of(fractions: &[f64], period_um: f64) -> PackingRequest {
        PackingRequest {
            period_um: [period_um; 2],
            pigments: fractions.iter().map(|&f| PigmentGrains::spheres(250.0, f)).collect(),
            ..Default::default()
        }
    }

    /// Relative variance of the number of grains in windows of `side` µm, from those modes of wide
    /// packings that belong to the window.
    fn measured(fraction: f64, side: f64) -> f64 {
        let mut squares = Vec::new();
        for stream in 0..6 {
            let packing = pack(&PackingRequest { stream, ..of(&[fraction], 6.4) }, &mut ()).unwrap();
            let most = (6.4 / side / 2.0) as i32;
            for m in -most..=most {
                for n in (-most..=most).filter(|&n| (m, n) > (0, 0)) {
                    squares.push(mode(&packing, [m, n]).norm_sqr());
                }
            }
        }
        let per_window = fraction * side * side / (PI / 6.0 * 0.25_f64.powi(3));
        let grains = per_window * (6.4 / side).powi(2);
        squares.iter().sum::<f64>() / squares.len() as f64 / grains / per_window
    }

    /// Σ exp(ik·x) over the grains.
    fn mode(packing: &crate::ink::Packing, [m, n]: [i32; 2]) -> Complex64 {
        let place = |[x, y, _]: [f64; 3]| (f64::from(m) * x + f64::from(n) * y) * TAU / 6.4;
        packing.grains().iter().map(|grain| Complex64::cis(place(grain.centre_um()))).sum()
    }

    #[test]
    fn cells_fluctuate_as_windows_of_a_wide_layer_do() {
        for fraction in [0.1, 0.3, 0.45] {
            let asked = of(&[fraction], 1.6);
            let moved = asked.fluctuating(&[1.0]).pigments[0].volume_fraction / fraction - 1.0;
            let truth = measured(fraction, 1.6).sqrt();
            // The squares of 72 independent modes scatter by 100 % each, which leaves 12 % of the
            // variance, and the fit is good to 20 %: 12 % of the deviation, three times
            assert!((moved / truth - 1.0).abs() < 0.36, "{fraction}: {moved} {truth}");
        }
    }

    /// The densest cells that can be packed deviate by nothing, less dense ones by a part.
    #[test]
    fn fuller_cells_stay_within_reach() {
        for (diameter_nm, fraction) in [(450.0, 0.5), (300.0, 0.5), (100.0, 0.52), (250.0, 0.46)] {
            let pigments = vec![PigmentGrains::spheres(diameter_nm, fraction)];
            let asked = PackingRequest { pigments, ..of(&[], 1.6) };
            let fuller = asked.fluctuating(&[1.0]);
            let emptier = asked.fluctuating(&[-1.0]).pigments[0].volume_fraction;
            let most = (REACHED * (1.0 - 0.5e-3 * diameter_nm)).max(fraction);
            // half a grain of rounding
            let grain = mean_grain_um3(&asked.pigments[0]) / asked.window_um3();
            assert!(fuller.pigments[0].volume_fraction < most + 0.5 * grain, "{diameter_nm}");
            assert!((fuller.pigments[0].volume_fraction + emptier - 2.0 * fraction).abs() < 1e-12);
            assert!(fuller.pigments[0].volume_fraction > fraction || most == fraction, "{diameter_nm}");
            assert!(pack(&fuller, &mut ()).is_ok(), "{diameter_nm}");
        }
    }

    /// Sequential addition and relaxation fill a layer differently: a thin one of large grains has
    /// more of them at its walls after relaxation. *Planted*: the method chosen by the share of the
    /// fuller cell.
    #[test]
    fn fuller_cells_are_packed_as_emptier_ones() {
        let pigments = vec![PigmentGrains::spheres(300.0, 0.15)];
        let asked = PackingRequest { pigments, thickness_um: 0.6, ..of(&[], 1.6) };
        let methods = [1.0, -1.0].map(|sign| {
            let moved = asked.fluctuating(&[sign]);
            let own = PackingRequest { usual_fraction: None, ..moved.clone() };
            [moved, own].map(|request| pack(&request, &mut ()).expect("room").account().method)
        });
        assert_eq!(methods[0][0], methods[1][0]);
        assert_ne!(methods[0][1], methods[1][1], "the case does not tell");
        for usual in [-0.1, 0.8, f64::NAN] {
            let wrong = PackingRequest { usual_fraction: Some(usual), ..asked.clone() };
            let error = pack(&wrong, &mut ()).expect_err("refused").to_string();
            assert!(error.contains("usual_fraction") && error.contains("0.74"), "{error}");
        }
    }

    #[test]
    fn cells_in_turns_have_the_mean_and_covariance_of_windows() {
        let asked = of(&[0.2, 0.1], 20.0);
        let signs = [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];
        let moved = signs.map(|s| {
            let all = asked.fluctuating(&s).pigments;
            [all[0].volume_fraction / 0.2 - 1.0, all[1].volume_fraction / 0.1 - 1.0]
        });
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| moved.iter().map(of).sum::<f64>() / 4.0;
        let bodies: Vec<PigmentInWindow> = asked.pigments.iter().map(|p| asked.bodies(p)).collect();
        let covariance = relative_covariance(&bodies, asked.structure_factor(&bodies));
        for (i, j) in [(0, 0), (0, 1), (1, 1)] {
            let found = mean(&|x| x[i] * x[j]);
            // whole grains, of which there are 4900: rounding by half a one in a deviation of 70
            assert!((found - covariance[i][j]).abs() < 0.03 * covariance[i][i].max(covariance[j][j]));
        }
        assert!(mean(&|x| x[0]).abs() < 1e-12 && mean(&|x| x[1]).abs() < 1e-12);
        // together they fluctuate as one pigment of 30 % does
        let one = of(&[0.3], 20.0);
        let whole: Vec<PigmentInWindow> = one.pigments.iter().map(|p| one.bodies(p)).collect();
        let single = relative_covariance(&whole, one.structure_factor(&whole))[0][0];
        let a = 2.0 / 3.0;
        let b = 1.0 / 3.0;
        let sum = a * a * covariance[0][0] + 2.0 * a * b * covariance[0][1] + b * b * covariance[1][1];
        assert!((sum / single - 1.0).abs() < 1e-12, "{sum} {single}");
    }
}
