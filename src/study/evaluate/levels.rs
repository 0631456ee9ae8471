//! Two levels: all packings are solved on a coarse grid, a few of them on a finer one as well.
//!
//! The packings hardly change what a finer grid adds (its variance is 3 · 10⁻⁴ … 0.02 of that of
//! the packings), so four of them suffice to correct all the others (Giles, Operations Research 56
//! (2008) 607; Peherstorfer, Willcox, Gunzburger, SIAM J. Sci. Comput. 38 (2016) A3163): where a
//! solve on the finer grid costs 2.4 times as much, the optimal share √(V_d C / (V C_d)) is 1 to
//! 9 %, four of 45 to 400 packings, and with fewer packings four cost little. What the
//! finer grid adds is fitted against wavelength and angle and extrapolated at third order, the
//! lowest observed for grains. Its uncertainty is the scatter between the packings and six tenths
//! of the difference itself: at second order the extrapolation would have to reach as much further,
//! at fifth order less far.

use super::regression::{Fits, Normal};
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength, TOTALS};
use super::wavelengths::SpectralBasis;
use crate::solve::accuracy::grid_error::GridError;
use ndarray::Array2;

/// Order of convergence of the totals in the mesh width.
const ORDER: i32 = 3;
/// Standard error of the extrapolation, relative to the fitted difference.
const EXTRAPOLATION: f64 = 0.6;
/// Functions of the direction: 1, μ, μ².
const WIDTH: usize = 3;

/// A realisation solved on the coarse and on the finer grid.
pub struct Checked {
    /// On the coarse grid.
    pub coarse: SolvedRealisation,
    /// On the finer one.
    pub finer: SolvedRealisation,
}

/// What the grid does to the totals, against wavelength and direction.
#[derive(Clone, Debug)]
pub struct GridCorrection {
    basis: SpectralBasis,
    /// Factor from the difference of both grids to the error of the coarse one.
    factor: f64,
    incident: Fits,
    exit: Fits,
    /// Angles over which the correction of R and T is averaged, degrees.
    angles_deg: Vec<f64>,
}

impl GridCorrection {
    /// Fits the difference between the grids, whose mesh widths have this ratio; `None`
    /// for fewer than two realisations, whose scatter is unknown.
    pub fn new(checked: &[Checked], basis: &SpectralBasis, ratio: f64, angles_deg: &[f64]) -> Option<Self> {
        (checked.len() > 1).then(|| Self {
            basis: basis.clone(),
            factor: 1.0 / (1.0 - ratio.powi(-ORDER)),
            incident: fits(checked, basis, |solved| solved.exact.iter().chain(&solved.strata).collect()),
            exit: fits(checked, basis, |solved| solved.exit.iter().collect()),
            angles_deg: angles_deg.to_vec(),
        })
    }

    /// The solves of a realisation without the error of the grid.
    pub fn apply(&self, solved: &mut SolvedRealisation) {
        for wavelength in &mut solved.wavelengths {
            let incident = wavelength
                .exact
                .iter_mut()
                .chain(&mut wavelength.strata)
                .map(|solved| (solved, &self.incident));
            for (solved, fits) in
                incident.chain(wavelength.exit.iter_mut().map(|solved| (solved, &self.exit)))
            {
                solved.shift(self.shift(&fits.whole, wavelength.wavelength_nm, solved.polar_deg));
            }
        }
    }

    /// R and T at one wavelength, averaged over the angles.
    fn totals(&self, fit: &Array2<f64>, nm: f64) -> [f64; 2] {
        let all: Vec<_> = self.angles_deg.iter().map(|&deg| self.shift(fit, nm, deg)).collect();
        [0, 2].map(|total| all.iter().map(|shift| shift[total]).sum::<f64>() / all.len().max(1) as f64)
    }

    /// Error of the coarse grid, by which its totals are to be shifted.
    fn shift(&self, fit: &Array2<f64>, nm: f64, polar_deg: f64) -> [f64; TOTALS] {
        let weights = self.basis.weights(nm);
        let functions = functions(polar_deg);
        let coefficient =
            |total: usize, k: usize| SpectralBasis::at(&weights, |i| fit[[i * WIDTH + k, total]]);
        std::array::from_fn(|t| {
            self.factor * (0..WIDTH).map(|k| functions[k] * coefficient(t, k)).sum::<f64>()
        })
    }
}

/// What the grid does to R and T of the layer, as it enters all errors.
#[derive(Clone, Debug)]
pub enum GridPart {
    /// Estimated in test solves, unknown in its sign.
    Estimated(GridError),
    /// Corrected, but for the extrapolation and the scatter of the packings on both grids.
    Corrected(Box<GridCorrection>),
}

impl GridPart {
    /// Number of independent errors.
    pub fn parts(&self) -> usize {
        1 + self.checked()
    }

    /// Number of packings that were solved on two grids.
    pub fn checked(&self) -> usize {
        if let Self::Corrected(correction) = self { correction.incident.without.len() } else { 0 }
    }

    /// Standard errors of R and T at one wavelength due to one of the independent errors, signed
    /// where the sign is known to be the same at other wavelengths or the opposite.
    pub fn shift(&self, part: usize, nm: f64) -> [f64; 2] {
        let correction = match self {
            Self::Estimated(grid) => return [grid.reflectance, grid.transmittance],
            Self::Corrected(correction) => correction,
        };
        let whole = correction.totals(&correction.incident.whole, nm);
        let Some(fit) = part.checked_sub(1).map(|k| &correction.incident.without[k]) else {
            return whole.map(|by| EXTRAPOLATION * by / correction.factor);
        };
        let without = correction.totals(fit, nm);
        let n = self.checked() as f64;
        std::array::from_fn(|i| (1.0 - 1.0 / n).sqrt() * (without[i] - whole[i]))
    }

    /// Standard errors of R and T: the largest over these wavelengths.
    pub fn largest(&self, wavelengths_nm: &[f64]) -> GridError {
        let error =
            |nm: f64, i: usize| (0..self.parts()).fold(0.0, |sum: f64, p| sum.hypot(self.shift(p, nm)[i]));
        let most = |i: usize| wavelengths_nm.iter().map(|&nm| error(nm, i)).fold(0.0, f64::max);
        GridError { reflectance: most(0), transmittance: most(1) }
    }
}

fn functions(polar_deg: f64) -> [f64; WIDTH] {
    let mu = polar_deg.to_radians().cos();
    [1.0, mu, mu * mu]
}

/// Fits the differences on one side.
fn fits<'a>(
    checked: &'a [Checked],
    basis: &SpectralBasis,
    side: fn(&SolvedWavelength) -> Vec<&SolvedDirection>,
) -> Fits {
    let samples = |(coarse, finer): (&SolvedWavelength, &SolvedWavelength)| {
        (coarse.wavelength_nm, differences(side(coarse), side(finer)))
    };
    let cell = |cell: &'a Checked| cell.coarse.wavelengths.iter().zip(&cell.finer.wavelengths).map(samples);
    Fits::new(checked.iter().map(cell), basis, WIDTH, TOTALS)
}

/// Samples of the differences between both grids at one wavelength.
fn differences(coarse: Vec<&SolvedDirection>, finer: Vec<&SolvedDirection>) -> Normal {
    let mut samples = Normal::new(WIDTH, TOTALS);
    for (coarse, finer) in coarse.into_iter().zip(finer) {
        let a = coarse.totals();
        let b = finer.totals();
        let differences: [f64; TOTALS] = std::array::from_fn(|i| b[i] - a[i]);
        samples.sample(&functions(coarse.polar_deg), &differences);
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFINEMENT: f64 = 4.0 / 3.0;

    /// T of a made-up layer on a grid of mesh width h whose error is of `order`.
    fn transmittance(nm: f64, polar_deg: f64, h: f64, order: i32) -> f64 {
        let mu = polar_deg.to_radians().cos();
        0.5 + 2e-4 * (nm - 400.0) + 0.02 * (1.0 + mu * mu) * h.powi(order)
    }

    fn realisation(r: usize, h: f64, order: i32) -> SolvedRealisation {
        let chance = 0.01 * (r as f64 - 1.5);
        let direction = |nm: f64, polar_deg: f64| SolvedDirection {
            polar_deg,
            reflectance: 0.1,
            specular_reflectance: 0.05,
            transmittance: transmittance(nm, polar_deg, h, order) + chance,
            specular_transmittance: 0.3,
            unscattered: Default::default(),
            absorptance: 0.1,
            absorbed: vec![0.04, 0.06],
            order_area: 0.1,
            scattered: Vec::new(),
        };
        let wavelength = |nm: f64| SolvedWavelength {
            wavelength_nm: nm,
            exact: vec![direction(nm, 0.0), direction(nm, 45.0)],
            strata: vec![direction(nm, 20.0 + r as f64), direction(nm, 50.0), direction(nm, 70.0)],
            exit: Vec::new(),
        };
        let wavelengths = (0..12).map(|k| wavelength(410.0 + 25.0 * k as f64 + r as f64)).collect();
        SolvedRealisation { thickness_um: 1.0, wavelengths }
    }

    fn correction(order: i32) -> GridCorrection {
        let checked: Vec<Checked> = (0..4)
            .map(|r| Checked {
                coarse: realisation(r, 1.0, order),
                finer: realisation(r, 1.0 / REFINEMENT, order),
            })
            .collect();
        let basis = SpectralBasis::Splines { range_nm: [400.0, 700.0], intervals: 12 };
        GridCorrection::new(&checked, &basis, REFINEMENT, &[0.0]).expect("four packings")
    }

    fn part(correction: &GridCorrection) -> GridPart {
        GridPart::Corrected(Box::new(correction.clone()))
    }

    /// Third order is extrapolated exactly, to the penalty on roughness; second and fifth order
    /// leave less than the error says.
    #[test]
    fn the_error_of_the_grid_is_taken_out_or_in_the_bar() {
        for (order, most) in [(3, 1e-3), (2, 1.0), (5, 1.0)] {
            let correction = correction(order);
            let mut other = realisation(7, 1.0, order);
            let truth = realisation(7, 0.0, order);
            correction.apply(&mut other);
            let error = part(&correction).largest(&[420.0, 550.0, 690.0]);
            for (corrected, exact) in other.wavelengths.iter().zip(&truth.wavelengths) {
                let left = corrected.exact[0].transmittance - exact.exact[0].transmittance;
                assert!(left.abs() < most * error.transmittance, "order {order}: {left} of {error:?}");
            }
            assert!(error.transmittance < 0.02, "a part of the difference: {error:?}");
            assert!(error.reflectance < 1e-9, "R has no error: {error:?}");
        }
    }

    /// What the packings do differently on the two grids is in the error.
    #[test]
    fn the_scatter_between_packings_counts() {
        let mut calm = Vec::new();
        let mut wild = Vec::new();
        for r in 0..4 {
            let coarse = realisation(r, 1.0, 3);
            calm.push(Checked { coarse: coarse.clone(), finer: realisation(r, 0.75, 3) });
            let mut finer = realisation(r, 0.75, 3);
            let by = if r % 2 == 0 { 0.01 } else { -0.01 };
            let solves = finer.wavelengths.iter_mut().flat_map(|w| w.exact.iter_mut().chain(&mut w.strata));
            solves.for_each(|s| s.transmittance += by);
            wild.push(Checked { coarse, finer });
        }
        let basis = SpectralBasis::Splines { range_nm: [400.0, 700.0], intervals: 12 };
        let error = |checked: &[Checked]| {
            let correction = GridCorrection::new(checked, &basis, REFINEMENT, &[0.0]).expect("four packings");
            part(&correction).largest(&[550.0]).transmittance
        };
        // ± 0.01 in four packings: a standard error of 0.01/√3, extrapolated. The packings have
        // their own wavelengths and angles: their weights at one place differ by some tenths.
        let factor = 1.0 / (1.0 - REFINEMENT.powi(-ORDER));
        let added = (error(&wild).powi(2) - error(&calm).powi(2)).sqrt();
        let expected = factor * 0.01 / 3.0_f64.sqrt();
        assert!((added / expected - 1.0).abs() < 0.2, "{added} {expected}");
        assert!(
            GridCorrection::new(&wild[..1], &basis, REFINEMENT, &[0.0]).is_none(),
            "one packing has no scatter"
        );
    }
}
