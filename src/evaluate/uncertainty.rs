//! Published error bars: chance over the packings, and the grid, added as squares.
//!
//! The grid's error is one shift of a whole spectrum, the same in every realisation: averaging does not lessen it.

use crate::appearance::angles::PolarAngle;
use crate::appearance::colour::Colour;
use crate::appearance::ink_on_paper::{InkError, InkOnPaper};
use crate::appearance::paper::LayerOnPaper;
use crate::numerics::estimate::Estimate;
use crate::solve::accuracy::grid_error::GridError;
use std::f64::consts::PI;

/// The errors that one study's numbers share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uncertainty {
    pub grid: GridError,
    /// No grains: chance plays no part, and the grid is all that is uncertain.
    pub certain: bool,
}

impl Uncertainty {
    /// Adds an error of the grid; unknown chance leaves the whole unknown.
    pub fn widen(&self, estimate: Estimate, grid: f64) -> Estimate {
        let chance = estimate.standard_error.or(self.certain.then_some(0.0));
        let standard_error = chance.map(|chance| chance.hypot(grid)).filter(|&e| e > 0.0 || !self.certain);
        Estimate { standard_error, ..estimate }
    }

    /// Error of the radiance factor under a uniform sky: that of R, and that of T on the way in and out.
    pub fn natural_light(&self, layer: &LayerOnPaper, view: &PolarAngle) -> f64 {
        let passes = layer.transmittance(view) + layer.mean_transmittance();
        self.grid.reflectance + layer.return_factor() * passes * self.grid.transmittance
    }

    /// Error of π times the BRDF; the layer's own diffuse part is at most as uncertain as its R.
    pub fn lit(&self, layer: &LayerOnPaper, light: &PolarAngle, view: &PolarAngle) -> f64 {
        let passes = layer.transmittance(light) + layer.transmittance(view);
        self.grid.reflectance + layer.return_factor() * passes * self.grid.transmittance
    }

    /// Colour of a quantity whose error from the grid is `shift`: the covariance of Lab holds both.
    pub fn colour(
        &self,
        ink: &InkOnPaper,
        quantity: impl Fn(&LayerOnPaper) -> f64,
        shift: impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Colour, InkError> {
        let colour = ink.colour(&quantity)?;
        let shifted = ink.colour(|layer| quantity(layer) + shift(layer))?;
        let by: [f64; 3] = std::array::from_fn(|i| shifted.lab[i] - colour.lab[i]);
        let none = (self.certain && by != [0.0; 3]).then_some([[0.0; 3]; 3]);
        let chance = colour.lab_covariance.or(none);
        let sum =
            |c: [[f64; 3]; 3]| std::array::from_fn(|i| std::array::from_fn(|j| c[i][j] + by[i] * by[j]));
        Ok(Colour { lab_covariance: chance.map(sum), ..colour })
    }
}

/// π times the BRDF of the ink on its paper.
pub(crate) fn lit(layer: &LayerOnPaper, light: &PolarAngle, view: &PolarAngle) -> f64 {
    PI * layer.brdf(light, view)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chance_and_grid_add_as_squares_and_unknown_stays_unknown() {
        let grid = GridError { reflectance: 3e-3, transmittance: 0.0 };
        let [chance, sure] = [false, true].map(|certain| Uncertainty { grid, certain });
        let known = Estimate { value: 0.5, standard_error: Some(4e-3) };
        let widened = chance.widen(known, 3e-3);
        assert!((widened.standard_error.unwrap() - 5e-3).abs() < 1e-15 && widened.value == 0.5);
        let unknown = Estimate::unknown_error(0.5);
        assert_eq!(chance.widen(unknown, 3e-3).standard_error, None);
        assert_eq!(sure.widen(unknown, 3e-3).standard_error, Some(3e-3));
        assert_eq!(sure.widen(unknown, 0.0).standard_error, None);
    }
}
