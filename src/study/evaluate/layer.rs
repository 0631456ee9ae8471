//! The layer without paper: totals at the angles common to all realisations, and hemispherical
//! means.

use super::films::{FilmAt, Films};
use super::regression::{Fits, Normal};
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength, TOTALS, mean};
use super::wavelengths::{SpectralBasis, Weights};
use crate::numerics::estimate::Estimate;
use crate::wave::Side;

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

impl Total {
    /// In the order of the columns.
    pub(super) const ALL: [Self; TOTALS] = [
        Self::Reflectance,
        Self::SpecularReflectance,
        Self::Transmittance,
        Self::SpecularTransmittance,
        Self::Absorptance,
    ];
}

/// Angles closer than this are equal, degrees: rounding of user input.
const SAME_DEG: f64 = 1e-9;

/// Hemispherical means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnsembleMean {
    /// T̄ from the incident side.
    Transmittance,
    /// Ā from the exit side.
    ExitAbsorptance,
    /// R̄ from the exit side by its own quadrature; only for checks, see
    /// [`crate::appearance::paper`].
    ExitReflectance,
}

/// Number of means.
const MEANS: usize = 3;

/// A spectrum with the values of all leave-one-out ensembles.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectrumEstimate {
    /// Values of the whole ensemble.
    pub values: Vec<f64>,
    /// \[realisation left out\]\[wavelength\]; empty for one realisation.
    pub replicates: Vec<Vec<f64>>,
}

impl SpectrumEstimate {
    /// The value at one wavelength from all realisations but one, for each of them; empty for one
    /// realisation.
    pub fn without_each(&self, wavelength: usize) -> Vec<f64> {
        self.replicates.iter().map(|spectrum| spectrum[wavelength]).collect()
    }

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
    /// Number of layers of a stack of whose absorptance the solves tell; 0 for one layer.
    pub layers: usize,
    /// Wavelengths over the range of the spectra, nm, closer than these, over which weighted
    /// numbers are summed; empty without any.
    pub sums_nm: Vec<f64>,
    fits: Fits,
    /// \[realisation\]\[wavelength\]: vacuum wavelength in nm, differences of all columns.
    differences: Vec<Vec<(f64, Vec<f64>)>>,
}

impl LayerEnsemble {
    /// Fits the ensemble; realisations must be complete and have the same angles. Without any the
    /// layer equals its film.
    pub fn new(solved: &[SolvedRealisation], basis: SpectralBasis, films: &Films, exact_deg: &[f64]) -> Self {
        let first = solved.first().and_then(|r| r.wavelengths.first());
        let strata = first.map_or(1, |w| w.strata.len());
        // a film of one slice in air is the same from both sides
        let is_reversible = films.index_out == 1.0 && films.profile.fractions.len() == 1;
        let exit = first.map_or(!is_reversible, |w| !w.exit.is_empty());
        let layers = layers_told(solved, films);
        let columns = exact_deg.len() * (TOTALS + layers) + if strata > 0 { MEANS } else { 0 };
        let of_realisation = |r: &SolvedRealisation| -> Vec<(f64, Vec<f64>)> {
            let film = |w: &SolvedWavelength| films.of_thickness(w.wavelength_nm, r.thickness_um);
            r.wavelengths
                .iter()
                .map(|w| (w.wavelength_nm, differences(w, &film(w), exact_deg, layers)))
                .collect()
        };
        let differences: Vec<_> = solved.iter().map(of_realisation).collect();
        let samples = |(nm, values): &(f64, Vec<f64>)| (*nm, Normal::plain(values));
        let fits = Fits::new(differences.iter().map(|rows| rows.iter().map(samples)), &basis, 1, columns);
        let exact_deg = exact_deg.to_vec();
        Self { fits, basis, exact_deg, strata, exit, layers, sums_nm: Vec::new(), differences }
    }

    /// Number of realisations.
    pub fn realisations(&self) -> usize {
        self.differences.len()
    }

    /// Wavelengths of realisation `r`, nm.
    pub fn wavelengths_nm(&self, r: usize) -> impl ExactSizeIterator<Item = f64> {
        self.differences[r].iter().map(|(nm, _)| *nm)
    }

    /// The layer without its leave-one-out ensembles.
    pub(super) fn of_means(&self) -> Self {
        let mut means = self.clone();
        means.fits.without.clear();
        means
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

    /// Column of what a layer of a stack absorbs at the exact angle with this index.
    pub fn absorbed_column(&self, angle: usize, layer: usize) -> usize {
        let means = if self.strata > 0 { MEANS } else { 0 };
        self.exact_deg.len() * TOTALS + means + angle * self.layers + layer
    }

    /// Measured difference from the film: realisation, index of its wavelength, column.
    pub fn measured(&self, r: usize, j: usize, column: usize) -> f64 {
        self.differences[r][j].1[column]
    }

    /// Fitted difference from the film.
    pub fn fitted(&self, without: Option<usize>, weights: &Weights, column: usize) -> f64 {
        SpectralBasis::at(weights, |i| self.fits.coefficients(without)[[i, column]])
    }
}

/// The film's T̄, and its Ā from the exit side: `exit` where the layer is not the same from both
/// sides.
pub fn film_means(film: &FilmAt, exit: bool) -> [f64; 2] {
    let [r, t] = film.means();
    [t, if exit { film.absorptance_from_exit() } else { 1.0 - r - t }]
}

/// The film's totals in the order of [`Total`].
pub fn film_totals(film: &FilmAt, polar_deg: f64) -> [f64; TOTALS] {
    let [r, t] = film.reflectance_transmittance(polar_deg);
    [r, r, t, t, 1.0 - r - t]
}

/// Differences from the film in the order of the columns.
fn differences(solved: &SolvedWavelength, film: &FilmAt, exact_deg: &[f64], layers: usize) -> Vec<f64> {
    let of_angle = |(s, &deg): (&SolvedDirection, &f64)| {
        let totals = s.totals();
        let film = film_totals(film, deg);
        (0..TOTALS).map(move |i| totals[i] - film[i])
    };
    let mut all: Vec<f64> = solved.exact.iter().zip(exact_deg).flat_map(of_angle).collect();
    if !solved.strata.is_empty() {
        all.extend(means(solved, film));
    }
    if layers > 0 {
        let of_angle = |(s, &deg): (&SolvedDirection, &f64)| {
            let pairs = s.absorbed.iter().zip(film.absorbed(deg));
            pairs.map(|(own, film)| own - film).collect::<Vec<_>>()
        };
        all.extend(solved.exact.iter().zip(exact_deg).flat_map(of_angle));
    }
    all
}

/// Number of layers of a stack, if every solve tells what each of them absorbs; 0 for one layer.
fn layers_told(solved: &[SolvedRealisation], films: &Films) -> usize {
    let layers = films.profile.layers.len();
    let mut solves = solved.iter().flat_map(|r| &r.wavelengths).flat_map(|w| &w.exact);
    if layers > 1 && solves.all(|solve| solve.absorbed.len() == layers) { layers } else { 0 }
}

/// Differences of the means. The film is subtracted solve by solve and its exact mean added again,
/// so that the strata only need to resolve the effect of the grains.
fn means(solved: &SolvedWavelength, film: &FilmAt) -> [f64; MEANS] {
    let of_film = |s: &SolvedDirection| film.reflectance_transmittance(s.polar_deg);
    let transmitted = mean(&solved.strata, |s| s.transmittance - of_film(s)[1]);
    // without solves from the exit side the layer is the same from both sides
    let (side, behind) = match solved.exit.is_empty() {
        true => (Side::Incident, &solved.strata),
        false => (Side::Exit, &solved.exit),
    };
    let below = |s: &SolvedDirection| film.from(side, s.polar_deg);
    let absorbed = mean(behind, |s| s.absorptance - (1.0 - below(s)[0] - below(s)[1]));
    [transmitted, absorbed, mean(behind, |s| s.reflectance - below(s)[0])]
}
