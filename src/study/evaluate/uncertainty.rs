//! Published standard errors: the jackknife over realisations (randomness, cell, angles,
//! wavelengths), the grid and the solver's residual, added in quadrature.
//!
//! The errors of the grid and of the residual shift a whole spectrum, equally in all realisations:
//! averaging does not reduce them.

use super::ink::{InkError, InkOnPaper, Sight};
use super::levels::GridPart;
use super::on_paper::{EmittedShare, LayerOnPaper, PolarAngle};
use super::samples::SolvedRealisation;
use crate::appearance::bare_paper::SPHERE_DEG;
use crate::appearance::colour::Colour;
use crate::appearance::paper::{MirroredSky, PRINT_DEG, PaperError};
use crate::numerics::estimate::Estimate;
use serde::Serialize;
use std::f64::consts::PI;

/// Energy errors of this size are rounding.
const ROUNDING: f64 = 1e-12;

/// The errors shared by all numbers of a study.
#[derive(Clone, Debug)]
pub(super) struct Uncertainty {
    /// Errors of R and T due to the grid.
    pub grid: GridPart,
    /// Error of R and T due to the solver's residual: the mean energy error.
    pub residual: f64,
    /// Largest shift due to packings without room, in random standard errors.
    pub missing_cells: f64,
    /// Without grains there is no randomness, and only the grid is uncertain.
    pub certain: bool,
}

/// Errors of R and T.
pub(super) type Shift = [f64; 2];
/// No error of R and T.
pub(super) const UNMOVED: Shift = [0.0; 2];
/// A colour, the contributions to its error, and the contribution of each realisation to Lab.
pub(super) type ColourParts = (Colour, Budget, Vec<[f64; 3]>);
/// A quantity of the layer on paper, shifted by errors of R and T.
type PaperQuantity<'a> = dyn Fn(&LayerOnPaper, Shift) -> f64 + 'a;

impl Uncertainty {
    /// Number of independent errors of R and T common to all realisations: those of the grid, and
    /// last that of the residual. Each shifts everything at once.
    pub fn parts(&self) -> usize {
        self.grid.parts() + 1
    }

    /// One of these errors at a wavelength.
    pub fn shift(&self, part: usize, nm: f64) -> Shift {
        let residual = if self.residual > ROUNDING { self.residual } else { 0.0 };
        if part < self.grid.parts() { self.grid.shift(part, nm) } else { [residual; 2] }
    }

    /// A number of the ink, computed anew with each of these errors.
    pub fn moved<T>(
        &self,
        ink: &InkOnPaper,
        number: impl Fn(&dyn Fn(&LayerOnPaper) -> Shift) -> Result<T, InkError>,
    ) -> Result<Vec<T>, InkError> {
        (0..self.parts()).map(|part| number(&|layer| self.shift(part, ink.wavelength_nm(layer)))).collect()
    }

    /// Like [`Uncertainty::widen`], for a quantity at a wavelength that shared errors of R and T
    /// shift by `moved`; `inputs` is its error due to tables of indices.
    pub fn widen_by(
        &self,
        estimate: Estimate,
        nm: f64,
        inputs: f64,
        moved: impl Fn(Shift) -> f64,
    ) -> Estimate {
        let all = (0..self.parts()).map(|part| moved(self.shift(part, nm)));
        self.widen(estimate, all.fold(inputs, |sum: f64, x| sum.hypot(x)))
    }

    /// Random covariance of Lab, plus the shifts of Lab by shared errors.
    pub fn widen_lab(&self, chance: Option<[[f64; 3]; 3]>, moved: &[[f64; 3]]) -> Option<[[f64; 3]; 3]> {
        let none = (self.certain && moved.iter().any(|by| *by != [0.0; 3])).then_some([[0.0; 3]; 3]);
        let shared = |i: usize, j: usize| moved.iter().map(|by| by[i] * by[j]).sum::<f64>();
        // packings without room shift the mean in any direction
        let scale = 1.0 + self.missing_cells * self.missing_cells;
        let c = chance.or(none)?;
        Some(std::array::from_fn(|i| std::array::from_fn(|j| c[i][j] * scale + shared(i, j))))
    }

    /// Adds a shared error; if the random error is unknown, so is the sum.
    pub fn widen(&self, estimate: Estimate, shared: f64) -> Estimate {
        let chance = estimate.standard_error.map(|chance| chance * 1.0_f64.hypot(self.missing_cells));
        let chance = chance.or(self.certain.then_some(0.0));
        let standard_error = chance.map(|chance| chance.hypot(shared)).filter(|&e| e > 0.0 || !self.certain);
        Estimate { standard_error, ..estimate }
    }

    /// Colour of a quantity for an observer, including errors of R and T and the effect of the
    /// wavelength range.
    pub fn widened(
        &self,
        ink: &InkOnPaper,
        sight: &Sight,
        quantity: &PaperQuantity,
    ) -> Result<Widened, InkError> {
        let plain = |layer: &LayerOnPaper| quantity(layer, UNMOVED);
        let (colour, deviations) = ink.colour_with_deviations(sight, plain)?;
        let mut shared = self.moved(ink, |by| {
            let shifted = ink.colour_of_mean(sight, |layer| quantity(layer, by(layer)))?;
            Ok(std::array::from_fn(|i| shifted.lab[i] - colour.lab[i]))
        })?;
        shared.extend(sight.meter.beyond(&ink.values(sight, &plain), colour.xyz));
        let spacing = ink.spacing(sight, &plain);
        let inputs = ink.input_shifts(sight, colour.xyz, &plain)?;
        let directions = ink.unseen_directions(sight, colour.xyz, &plain)?;
        let chance = colour.lab_covariance;
        let all = shared.iter().chain(&spacing).chain(&inputs).chain(&directions);
        let all: Vec<[f64; 3]> = all.copied().collect();
        let colour = Colour { lab_covariance: self.widen_lab(chance, &all), ..colour };
        Ok(Widened { colour, chance, shared, spacing, inputs, directions, deviations })
    }

    /// Colour of a quantity for the standard observer with its total covariance, the contributions
    /// to it, and that of each realisation to Lab.
    pub fn colour(
        &self,
        ink: &InkOnPaper,
        solved: &[SolvedRealisation],
        quantity: &PaperQuantity,
    ) -> Result<ColourParts, InkError> {
        let Widened { colour, chance, shared, spacing, inputs, directions, deviations } =
            self.widened(ink, &ink.daylight()?, quantity)?;
        let plain = |layer: &LayerOnPaper| quantity(layer, UNMOVED);
        let lengths: Vec<f64> = shared.into_iter().map(length).collect();
        let whole_length = |shifts: &[[f64; 3]]| shifts.iter().copied().map(length).fold(0.0, f64::hypot);
        let (grid, rest) = lengths.split_at(self.grid.parts());
        let together = |parts: &[f64]| parts.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
        let angles = ink.angle_covariance(solved, plain)?.map(spread);
        // the contribution of the directions is a part of the jackknife's
        let apart = |whole: f64| (whole * whole - angles.unwrap_or(0.0).powi(2)).max(0.0).sqrt();
        let unseen = whole_length(&directions);
        let budget = Budget {
            chance_and_cell: chance.map(spread).map(apart),
            angles: angles.map(|seen| if unseen > 0.0 { seen.hypot(unseen) } else { seen }),
            wavelengths: length(ink.wavelength_shift(plain)?),
            grid: together(grid),
            residual: rest[0],
            missing_cells: self.missing_cells * chance.map_or(0.0, spread),
            beyond_range: together(&rest[1..]),
            between_wavelengths: whole_length(&spacing),
            inputs: whole_length(&inputs),
        };
        Ok((colour, budget, deviations))
    }
}

/// A colour with its covariance, and the contributions to it.
pub(super) struct Widened {
    /// The colour with its total covariance.
    pub colour: Colour,
    /// The random covariance.
    chance: Option<[[f64; 3]; 3]>,
    /// Shifts of Lab due to the grid, the residual, and light beyond each end of the wavelength
    /// range.
    shared: Vec<[f64; 3]>,
    /// Shifts of Lab due to light between the wavelengths of a list.
    spacing: Vec<[f64; 3]>,
    /// Shifts of Lab due to the errors of tables of indices.
    inputs: Vec<[f64; 3]>,
    /// Shifts of Lab by errors of the directions that all cells have in common.
    directions: Vec<[f64; 3]>,
    /// Contribution of each realisation to Lab.
    pub deviations: Vec<[f64; 3]>,
}

/// Contributions to a colour's error: root mean square distances in Lab (ΔE*ab). In quadrature all
/// parts except `wavelengths`, which is corrected for, add up to the standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Budget {
    /// Random packings, each in its own cell; `null` if a single realisation leaves it unknown.
    pub chance_and_cell: Option<f64>,
    /// The choice of directions over the hemisphere.
    pub angles: Option<f64>,
    /// The effect of the wavelength spacing, for which the colour is corrected.
    pub wavelengths: f64,
    /// The grid.
    pub grid: f64,
    /// The solver's residual.
    pub residual: f64,
    /// Packings without room: the largest effect of their cells; absent if all had room.
    #[serde(skip_serializing_if = "nothing")]
    pub missing_cells: f64,
    /// Visible light outside the wavelength range, extrapolated from the ends of the spectrum;
    /// absent if there is none.
    #[serde(skip_serializing_if = "nothing")]
    pub beyond_range: f64,
    /// What the spectrum may do between listed wavelengths, which its coherent film tells in part;
    /// absent where the spectrum is known at all wavelengths.
    #[serde(skip_serializing_if = "nothing")]
    pub between_wavelengths: f64,
    /// The errors of the tables of indices (columns `n_error`, `kappa_error`, `correlation`), taken
    /// as common to all wavelengths; absent without such columns.
    #[serde(skip_serializing_if = "nothing")]
    pub inputs: f64,
}

impl Budget {
    /// What to change where more packings would not help: the remedy for the largest part, if that
    /// is not chance.
    pub fn remedy_but_packings(&self) -> Option<&'static str> {
        let chance =
            self.chance_and_cell.unwrap_or(0.0).hypot(self.angles.unwrap_or(0.0)).hypot(self.missing_cells);
        let parts = [
            (
                self.between_wavelengths.hypot(self.wavelengths),
                "wavelengths that are closer, or a range: light.from_nm, to_nm and step_nm",
            ),
            (self.grid.hypot(self.residual), "a finer grid: a smaller resolution.accuracy"),
            (self.inputs, "tables of indices with smaller errors"),
            (self.beyond_range, "wavelengths from 400 to 700 nm"),
        ];
        let (part, remedy) = parts.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        (part > chance).then_some(remedy)
    }
}

/// Whether a number is zero, and so is left out of the results.
pub(super) fn nothing<T: Default + PartialEq>(number: &T) -> bool {
    *number == T::default()
}

/// The conditions of instruments: two viewed along the normal, and a sphere viewed at 8°.
pub(super) struct Conditions {
    light: PolarAngle,
    view: PolarAngle,
    slanted: PolarAngle,
    sky: MirroredSky,
}

impl Conditions {
    pub fn new(ink: &InkOnPaper, sky: MirroredSky) -> Result<Self, PaperError> {
        let slanted = ink.at(SPHERE_DEG)?;
        Ok(Self { light: ink.at(PRINT_DEG)?, view: ink.at(0.0)?, slanted, sky })
    }

    /// The radiance factor under a uniform sky, shifted by the error of R, of T on the way in and
    /// out, and of R̄ on the paper's side.
    pub fn natural_light(&self, layer: &LayerOnPaper, by: Shift) -> f64 {
        under_sky(layer, &self.view, self.sky, by)
    }

    /// The radiance factor in a sphere seen at 8° (d:8), with or without mirrored light.
    pub fn in_sphere(&self, sky: MirroredSky, layer: &LayerOnPaper, by: Shift) -> f64 {
        under_sky(layer, &self.slanted, sky, by)
    }

    /// The radiance factor of diffuse light seen along the normal through a port, from which
    /// nothing is mirrored (d:0).
    pub fn diffuse_normal(&self, layer: &LayerOnPaper, by: Shift) -> f64 {
        under_sky(layer, &self.view, MirroredSky::Excluded, by)
    }

    /// π times the BRDF of the ink on its paper lit at 45°, shifted by errors; the error of the
    /// layer's diffuse part is at most that of its R.
    pub fn lit_at_45(&self, layer: &LayerOnPaper, [r, t]: Shift) -> f64 {
        let inwards = layer.transmittance(&self.light);
        let outwards = layer.transmittance_returned(&self.view);
        let emitted = emitted_error(layer, layer.emitted.lit_at_45, outwards, [r, t]);
        let shift = r + through_paper(layer, inwards, outwards, [r, t]);
        PI * layer.brdf(&self.light, &self.view) + (shift + emitted)
    }
}

/// The radiance factor under a uniform sky with its shift.
fn under_sky(layer: &LayerOnPaper, view: &PolarAngle, sky: MirroredSky, [r, t]: Shift) -> f64 {
    let inwards = layer.transmittance(view);
    let outwards = layer.mean_transmittance();
    let emitted = emitted_error(layer, layer.emitted.natural, inwards, [r, t]);
    let shift = r + through_paper(layer, inwards, outwards, [r, t]);
    layer.natural_light(view, sky) + (shift + emitted)
}

/// Error of S b T towards the eye, where S is emitted, db = n² ρ b² dR̄_b, and errors of R and T
/// change S as well.
fn emitted_error(layer: &LayerOnPaper, emitted: EmittedShare, outwards: f64, [r, t]: Shift) -> f64 {
    let [share, by_r, by_t] = emitted;
    if share == 0.0 {
        return 0.0;
    }
    let series = layer.emerging_factor();
    let moved_series = (layer.index_out * series).powi(2) * layer.paper_albedo * r;
    (by_r * r + by_t * t) * series * outwards + share * (moved_series * outwards + series * t)
}

/// Error of g T₁ T₂, where dg = n² g² dR̄_b and R̄_b has the same error as R.
fn through_paper(layer: &LayerOnPaper, inwards: f64, outwards: f64, [r, t]: Shift) -> f64 {
    let factor = layer.return_factor();
    let moved_factor = (layer.index_out * factor).powi(2) * r;
    factor * (inwards + outwards) * t + moved_factor * inwards * outwards
}

/// Root mean square distance for a covariance.
fn spread(c: [[f64; 3]; 3]) -> f64 {
    (c[0][0] + c[1][1] + c[2][2]).max(0.0).sqrt()
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::accuracy::grid_error::GridError;

    #[test]
    fn chance_and_grid_add_as_squares_and_unknown_stays_unknown() {
        let grid = GridError { reflectance: 3e-3, transmittance: 0.0 };
        let [chance, sure] = [false, true].map(|certain| Uncertainty {
            grid: GridPart::Estimated(grid),
            residual: 4e-3,
            missing_cells: 0.0,
            certain,
        });
        let known = Estimate { value: 0.5, standard_error: Some(4e-3) };
        let widened = chance.widen(known, 3e-3);
        assert!((widened.standard_error.unwrap() - 5e-3).abs() < 1e-15 && widened.value == 0.5);
        // a shift of 0.75 standard errors: 4e-3 and 3e-3
        let missing = Uncertainty { missing_cells: 0.75, ..chance.clone() };
        assert!((missing.widen(known, 0.0).standard_error.unwrap() - 5e-3).abs() < 1e-15);
        let covariance = missing.widen_lab(Some([[16e-6, 0.0, 0.0], [0.0; 3], [0.0; 3]]), &[]).unwrap();
        assert!((covariance[0][0] - 25e-6).abs() < 1e-18);
        let unknown = Estimate::unknown_error(0.5);
        assert_eq!(chance.widen(unknown, 3e-3).standard_error, None);
        assert_eq!(sure.widen(unknown, 3e-3).standard_error, Some(3e-3));
        assert_eq!(sure.widen(unknown, 0.0).standard_error, None);
        // grid: 3e-3 in R only, residual: 4e-3 in both; 3e-3 and 8e-3 in R + T
        let both = sure.widen_by(unknown, 550.0, 0.0, |[r, t]| r + t).standard_error.unwrap();
        assert!((both - 3e-3_f64.hypot(8e-3)).abs() < 1e-15, "{both}");
    }
}
