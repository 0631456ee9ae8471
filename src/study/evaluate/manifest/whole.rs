//! What is published of a layer that is solved as a whole, beside what every print has.

use super::Count;
use crate::appearance::colour::Colour;
use crate::evaluate::published::{NamedNumber, PublishedRow, Quantity};
use crate::evaluate::survivors::Survivors;
use crate::evaluate::uncertainty::{Budget, nothing};
use crate::numerics::estimate::Estimate;
use crate::store::packing_record::PackingRecord;
use crate::wave::Resolution;
use serde::Serialize;

/// Packings, grid and errors of a layer that is solved as a whole.
#[derive(Clone, Debug, Serialize)]
pub struct EnsembleNotes {
    /// Requested and finished realisations.
    pub realisations: Count,
    /// Numbers of packings with and without room for their grains.
    pub tried_packings: Survivors,
    /// The grid of the shortest wavelengths and the largest contrast.
    pub resolution: Resolution,
    /// The grid of the longest wavelengths, if it differs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub resolution_longest: Option<Resolution>,
    /// Errors and their estimates.
    pub certainty: Certainty,
    /// One record per packing; the file has the first [`super::MOST_LISTED`].
    #[serde(serialize_with = "super::first_ones")]
    pub packings: Vec<PackingRecord>,
}

/// What limits the accuracy of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certainty {
    /// Largest estimated error of an order's complex amplitude due to the grid, over the test
    /// solves.
    pub amplitude_error_estimate: f64,
    /// Estimated error of the layer's R due to the grid, over the test solves; part of the standard
    /// errors.
    pub reflectance_grid_error: f64,
    /// Estimated error of the layer's T due to the grid, over the test solves; part of the standard
    /// errors.
    pub transmittance_grid_error: f64,
    /// Number of packings solved on a finer grid as well, by which the numbers are corrected and
    /// from which the grid's errors of R and T are then estimated; absent if there are none.
    #[serde(skip_serializing_if = "nothing")]
    pub packings_on_finer_grid: usize,
    /// Degrees of freedom of the standard errors: number of realisations minus one; 0 without
    /// randomness.
    pub degrees_of_freedom: usize,
    /// Factor from standard errors to 95 % intervals (Student's t).
    pub coverage_factor_95: Option<f64>,
    /// Standard error of T̄ at the worst wavelength due to the choice of directions; part of the
    /// errors of all colours.
    pub angle_error_estimate: Option<f64>,
    /// T̄ from every second stratum minus T̄ from all, averaged over the wavelengths: an
    /// independent check, zero within its error.
    pub half_strata_difference: Option<Estimate>,
    /// R̄ from the exit side by its own quadrature minus 1 − T̄/n² − Ā, averaged over the
    /// wavelengths, if there are solves from that side: a second check.
    pub exit_reflectance_difference: Option<Estimate>,
    /// Mean |R + T + A − 1| of all solves: the effect of the solver's residual on R and T; part of
    /// the standard errors.
    pub mean_energy_error: f64,
    /// Largest |R + T + A − 1| of all solves.
    pub largest_energy_error: f64,
    /// Largest relative residual of all solves.
    pub largest_residual: f64,
    /// Mean number of iterations.
    pub mean_steps: f64,
    /// Total number of operator applications.
    pub operator_applications: usize,
}

impl Certainty {
    pub(super) fn unphysical(&self) -> Option<String> {
        let numbers = [
            ("amplitude_error_estimate", self.amplitude_error_estimate),
            ("reflectance_grid_error", self.reflectance_grid_error),
            ("transmittance_grid_error", self.transmittance_grid_error),
            ("largest_energy_error", self.largest_energy_error),
            ("largest_residual", self.largest_residual),
        ];
        let wrong = numbers.into_iter().find(|(_, value)| !value.is_finite());
        wrong.map(|(name, value)| format!("certainty.{name} is {value}"))
    }
}

/// A colour under named conditions.
#[derive(Clone, Debug, Serialize)]
pub struct ColourNote {
    /// Illumination and viewing.
    pub conditions: String,
    /// C*ab with its error.
    pub chroma: Estimate,
    /// hab with its error, degrees.
    pub hue_deg: Estimate,
    /// Standard errors of L*, a*, b*; unknown for a single realisation.
    pub lab_standard_error: Option<[f64; 3]>,
    /// Half width of the 95 % interval as a CIEDE2000 difference.
    pub delta_e_2000_95: Option<f64>,
    /// Contributions to the standard error.
    pub budget: Budget,
    /// Number of each realisation and its contribution to Lab; colours of the same realisations
    /// have correlated errors.
    #[serde(skip)]
    pub deviations: Vec<(usize, [f64; 3])>,
    /// The colour.
    #[serde(flatten)]
    pub colour: Colour,
}

/// One wavelength and angle. R, T, A and their specular parts are those of the layer without paper.
#[derive(Clone, Debug, Serialize)]
pub struct SpectrumRow {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Polar angle, degrees.
    pub polar_deg: f64,
    /// Reflectance R.
    pub reflectance: Estimate,
    /// R of the specular order of the cells: ⟨|r|²⟩, which holds the mirror image and the diffuse
    /// light of that order, the more the smaller the cell.
    pub specular_reflectance: Estimate,
    /// Transmittance T.
    pub transmittance: Estimate,
    /// T of the unscattered order of the cells: ⟨|t|²⟩, which holds the coherent light and the
    /// diffuse light of that order, the more the smaller the cell.
    pub specular_transmittance: Estimate,
    /// Coherent transmittance |⟨t⟩|²: what goes straight on through a layer of any size, without
    /// bias; `None` for layers of uneven thickness.
    pub coherent_transmittance: Option<Estimate>,
    /// Absorptance A.
    pub absorptance: Estimate,
    /// The ink on its paper under a uniform sky, viewed along the normal (white diffuser: 1).
    pub natural_light: Option<Estimate>,
    /// π × BRDF of the ink on its paper, lit at 45° and viewed along the normal (white diffuser:
    /// 1).
    pub lit_at_45: Option<Estimate>,
    /// At 0°: the ink on its paper in a sphere, seen at 8° (d:8), with mirrored light.
    pub sphere_at_8: Option<Estimate>,
    /// At 0°: the same without mirrored light.
    pub sphere_at_8_excluded: Option<Estimate>,
    /// At 0°: the ink on its paper under diffuse light, seen along the normal through a port from
    /// which nothing is mirrored (d:0).
    pub diffuse_normal: Option<Estimate>,
    /// At 0°: T̄ of diffuse light from in front. With Ā it gives the series of returns from any
    /// paper, g = ρ/(1 − ρ R̄_b) with R̄_b = 1 − T̄/n² − Ā.
    pub transmittance_diffuse: Option<Estimate>,
    /// At 0°: Ā of unpolarised diffuse light from behind, as the paper sends it.
    pub absorptance_behind: Option<Estimate>,
    /// Number of each realisation and its contribution to R and T.
    #[serde(skip)]
    pub deviations: Vec<(usize, [f64; 2])>,
    /// The numbers without each of the realisations; not written to files.
    #[serde(skip)]
    pub replicates: SpectrumReplicates,
}

/// Jackknife replicates of a row's numbers: each number from all cells but one, in the order of
/// [`SpectrumRow::deviations`]; empty for one cell, and of numbers that are not there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpectrumReplicates {
    /// Of R.
    pub reflectance: Vec<f64>,
    /// Of R of the specular order.
    pub specular_reflectance: Vec<f64>,
    /// Of T.
    pub transmittance: Vec<f64>,
    /// Of T of the unscattered order.
    pub specular_transmittance: Vec<f64>,
    /// Of A.
    pub absorptance: Vec<f64>,
    /// Of the ink on its paper under a uniform sky.
    pub natural_light: Vec<f64>,
    /// Of the ink on its paper at 45:0.
    pub lit_at_45: Vec<f64>,
}

/// A number of a spectrum.
struct SpectrumColumn {
    name: &'static str,
    quantity: Quantity,
    estimate: fn(&SpectrumRow) -> Option<Estimate>,
}

const fn share(name: &'static str, estimate: fn(&SpectrumRow) -> Option<Estimate>) -> SpectrumColumn {
    SpectrumColumn { name, quantity: Quantity::Share, estimate }
}

const fn factor(name: &'static str, estimate: fn(&SpectrumRow) -> Option<Estimate>) -> SpectrumColumn {
    SpectrumColumn { name, quantity: Quantity::Factor, estimate }
}

/// The numbers of a spectrum in the order of `spectra.csv`.
const SPECTRUM: [SpectrumColumn; 8] = [
    share("reflectance", |row| Some(row.reflectance)),
    share("specular_reflectance", |row| Some(row.specular_reflectance)),
    share("transmittance", |row| Some(row.transmittance)),
    share("specular_transmittance", |row| Some(row.specular_transmittance)),
    share("absorptance", |row| Some(row.absorptance)),
    factor("natural_light", |row| row.natural_light),
    factor("lit_at_45", |row| row.lit_at_45),
    share("coherent_transmittance", |row| row.coherent_transmittance),
];

impl PublishedRow for SpectrumRow {
    const PLACE: &'static [&'static str] = &["wavelength_nm", "polar_deg"];

    fn names() -> Vec<&'static str> {
        SPECTRUM.iter().map(|column| column.name).collect()
    }

    fn place(&self) -> Vec<f64> {
        vec![self.wavelength_nm, self.polar_deg]
    }

    fn wavelength_nm(&self) -> f64 {
        self.wavelength_nm
    }

    fn numbers(&self) -> Vec<NamedNumber> {
        let number = |column: &SpectrumColumn| NamedNumber {
            name: column.name,
            in_words: column.name,
            quantity: column.quantity,
            estimate: (column.estimate)(self),
        };
        SPECTRUM.iter().map(number).collect()
    }
}

/// Totals outside 0–1 by more than this are invalid; every single solve has passed a stricter
/// check.
const BEYOND: f64 = 0.03;

impl SpectrumRow {
    pub(super) fn unphysical(&self) -> Option<String> {
        let totals = [
            ("reflectance", self.reflectance),
            ("transmittance", self.transmittance),
            ("absorptance", self.absorptance),
        ];
        let outside = |e: &Estimate| !(-BEYOND..=1.0 + BEYOND).contains(&e.value);
        let no_number = |e: &Estimate| !(e.value.is_finite() && e.standard_error.is_none_or(f64::is_finite));
        let seen = [("natural_light", self.natural_light), ("lit_at_45", self.lit_at_45)];
        let seen = seen.into_iter().filter_map(|(name, e)| Some((name, e?))).find(|(_, e)| no_number(e));
        let wrong = totals.into_iter().find(|(_, e)| no_number(e) || outside(e)).or(seen);
        wrong.map(|(name, e)| format!("{name} is {} at {} nm", e.value, self.wavelength_nm))
    }
}
