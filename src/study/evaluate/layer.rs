//! The layer without paper: totals at the angles common to all realisations, and hemispherical
//! means.

use super::films::{FilmAt, Films};
use super::regression::{Fits, Normal, Sums};
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength, TOTALS, mean};
use super::wavelengths::{SpectralBasis, Weights};
use crate::numerics::estimate::Estimate;
use ndarray::Array2;

/// Totals at one angle, relative to the incident power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Total {
    /// R.
    Reflectance,
    /// R of the specular order.
    SpecularReflectance,
    /// T.
    Transmittance,
    /// T of the unscattered order.
    SpecularTransmittance,
    /// A.
    Absorptance,
}

/// Angles closer than this are equal, degrees: rounding of user input.
const SAME_DEG: f64 = 1e-9;

/// Hemispherical means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnsembleMean {
    /// T̄ from the incident side.
    Transmittance,
    /// R̄ from the incident side.
    Reflectance,
    /// Ā from the exit side.
    ExitAbsorptance,
    /// R̄ from the exit side by its own quadrature; only for checks, see
    /// [`crate::appearance::paper`].
    ExitReflectance,
}

/// Number of means.
const MEANS: usize = 4;

/// A spectrum with the values of all leave-one-out ensembles.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumEstimate {
    /// Values of the whole ensemble.
    pub values: Vec<f64>,
    /// \[realisation left out\]\[wavelength\]; empty for one realisation.
    pub replicates: Vec<Vec<f64>>,
}

impl SpectrumEstimate {
    /// Value and jackknife standard error at each wavelength.
    pub fn estimates(&self) -> Vec<Estimate> {
        let column = |k: usize| self.replicates.iter().map(|r| r[k]).collect::<Vec<_>>();
        self.values.iter().enumerate().map(|(k, &v)| Estimate::jackknife(v, &column(k))).collect()
    }
}

/// Fitted differences of an ensemble from its coherent film, against wavelength.
#[derive(Clone, Debug)]
pub struct LayerEnsemble {
    /// Functions of the wavelength.
    pub basis: SpectralBasis,
    /// Angles common to all realisations, degrees.
    pub exact_deg: Vec<f64>,
    /// Number of strata of μ²; 0 if only single angles were requested.
    pub strata: usize,
    /// Whether there are solves from the exit side.
    pub exit: bool,
    fits: Fits,
    /// \[realisation\]\[wavelength\]\[column\]
    differences: Vec<Vec<Vec<f64>>>,
    /// \[realisation\]\[wavelength\]
    wavelengths_nm: Vec<Vec<f64>>,
}

impl LayerEnsemble {
    /// Fits the ensemble; realisations must be complete and have the same angles.
    pub fn new(
        realisations: &[SolvedRealisation],
        basis: SpectralBasis,
        films: &Films,
        exact_deg: &[f64],
    ) -> Self {
        let first = realisations.first().and_then(|r| r.wavelengths.first());
        let strata = first.map_or(0, |w| w.strata.len());
        let of = |r: &SolvedRealisation| -> Vec<Vec<f64>> {
            let film = |w: &SolvedWavelength| films.of_thickness(w.wavelength_nm, r.thickness_um);
            r.wavelengths.iter().map(|w| differences(w, &film(w), exact_deg)).collect()
        };
        let exit = first.is_some_and(|w| !w.exit.is_empty());
        let differences: Vec<Vec<Vec<f64>>> = realisations.iter().map(of).collect();
        let wavelengths_nm: Vec<Vec<f64>> =
            realisations.iter().map(|r| r.wavelengths.iter().map(|w| w.wavelength_nm).collect()).collect();
        let columns = columns(exact_deg.len(), strata);
        let part = |(values, nm): (&Vec<Vec<f64>>, &Vec<f64>)| {
            let mut normal = Normal::new(basis.len(), columns);
            values.iter().zip(nm).for_each(|(v, &nm)| normal.add(&basis.weights(nm), &Sums::plain(v)));
            normal
        };
        let parts: Vec<Normal> = differences.iter().zip(&wavelengths_nm).map(part).collect();
        let fits = Fits::new(&parts, &basis, 1);
        Self { fits, basis, exact_deg: exact_deg.to_vec(), strata, exit, differences, wavelengths_nm }
    }

    /// A layer that equals its film, without solves. `exit` if the half-spaces differ.
    pub fn film_alone(basis: SpectralBasis, exact_deg: &[f64], exit: bool) -> Self {
        let fits = Fits::nothing(&basis, 1, columns(exact_deg.len(), 1));
        let (differences, wavelengths_nm) = (Vec::new(), Vec::new());
        Self { fits, basis, exact_deg: exact_deg.to_vec(), strata: 1, exit, differences, wavelengths_nm }
    }

    /// Number of realisations.
    pub fn realisations(&self) -> usize {
        self.differences.len()
    }

    /// Wavelengths of realisation `r`, nm.
    pub fn wavelengths_nm(&self, r: usize) -> &[f64] {
        &self.wavelengths_nm[r]
    }

    /// The fit to all realisations (`None`) or to all but one.
    pub fn coefficients(&self, without: Option<usize>) -> &Array2<f64> {
        without.map_or(&self.fits.whole, |r| &self.fits.without[r])
    }

    /// Number of leave-one-out ensembles; 0 for a single realisation.
    pub fn replicates(&self) -> usize {
        self.fits.without.len()
    }

    /// Index of an angle in degrees among the exact ones.
    pub fn place(&self, polar_deg: f64) -> Option<usize> {
        self.exact_deg.iter().position(|deg| (deg - polar_deg).abs() < SAME_DEG)
    }

    /// Column of a total at the exact angle with this index.
    pub fn column(&self, angle: usize, total: Total) -> usize {
        angle * TOTALS + total as usize
    }

    /// Column of a hemispherical mean; there are none without strata.
    pub fn mean_column(&self, mean: EnsembleMean) -> usize {
        self.exact_deg.len() * TOTALS + mean as usize
    }

    /// Measured difference from the film: realisation, index of its wavelength, column.
    pub fn measured(&self, r: usize, j: usize, column: usize) -> f64 {
        self.differences[r][j][column]
    }

    /// Fitted difference from the film.
    pub fn fitted(&self, without: Option<usize>, weights: &Weights, column: usize) -> f64 {
        let coefficients = self.coefficients(without);
        SpectralBasis::at(weights, |i| coefficients[[i, column]])
    }

    /// A total at one of the exact angles, at the given wavelengths.
    pub fn spectrum(
        &self,
        films: &[FilmAt],
        wavelengths_nm: &[f64],
        angle: usize,
        total: Total,
    ) -> SpectrumEstimate {
        let column = self.column(angle, total);
        let film: Vec<f64> =
            films.iter().map(|film| film_totals(film, self.exact_deg[angle])[total as usize]).collect();
        let of = |without: Option<usize>| -> Vec<f64> {
            let fitted = |&nm: &f64| self.fitted(without, &self.basis.weights(nm), column);
            wavelengths_nm.iter().map(fitted).zip(&film).map(|(difference, film)| film + difference).collect()
        };
        SpectrumEstimate {
            values: of(None),
            replicates: (0..self.replicates()).map(|r| of(Some(r))).collect(),
        }
    }
}

fn columns(angles: usize, strata: usize) -> usize {
    angles * TOTALS + if strata > 0 { MEANS } else { 0 }
}

/// The film's means in the order of [`EnsembleMean`]; `exit` if there are solves from the exit
/// side.
pub fn film_means(film: &FilmAt, exit: bool) -> [f64; MEANS] {
    let [r, t] = film.means();
    if !exit {
        return [t, r, 1.0 - r - t, r];
    }
    let absorbed = film.absorptance_from_exit();
    // reciprocity: what leaves through the film equals what enters, over n²
    [t, r, absorbed, 1.0 - absorbed - t / film.index_out().powi(2)]
}

/// The film's totals in the order of [`Total`].
pub fn film_totals(film: &FilmAt, polar_deg: f64) -> [f64; TOTALS] {
    let [r, t] = film.reflectance_transmittance(polar_deg);
    [r, r, t, t, 1.0 - r - t]
}

/// Differences from the film in the order of the columns.
fn differences(solved: &SolvedWavelength, film: &FilmAt, exact_deg: &[f64]) -> Vec<f64> {
    let of_angle = |(s, &deg): (&SolvedDirection, &f64)| {
        let (own, film) = (s.totals(), film_totals(film, deg));
        (0..TOTALS).map(move |i| own[i] - film[i])
    };
    let mut all: Vec<f64> = solved.exact.iter().zip(exact_deg).flat_map(of_angle).collect();
    if !solved.strata.is_empty() {
        all.extend(means(solved, film));
    }
    all
}

/// Differences of the means. The film is subtracted solve by solve and its exact mean added again,
/// so that the strata only need to resolve the effect of the grains.
fn means(solved: &SolvedWavelength, film: &FilmAt) -> [f64; MEANS] {
    let own = |s: &SolvedDirection| film.reflectance_transmittance(s.polar_deg);
    let transmitted = mean(&solved.strata, |s| s.transmittance - own(s)[1]);
    let reflected = mean(&solved.strata, |s| s.reflectance - own(s)[0]);
    let (absorbed, back) = if solved.exit.is_empty() {
        (mean(&solved.strata, |s| s.absorptance - (1.0 - own(s)[0] - own(s)[1])), reflected)
    } else {
        let below = |s: &SolvedDirection| film.from_exit(s.polar_deg);
        let absorbed = mean(&solved.exit, |s| s.absorptance - (1.0 - below(s)[0] - below(s)[1]));
        (absorbed, mean(&solved.exit, |s| s.reflectance - below(s)[0]))
    };
    [transmitted, reflected, absorbed, back]
}
