//! Colours and the picture of an ink on its paper, with what fits and angles do to them.

use super::{InkError, InkOnPaper};
use crate::appearance::colour::Colour;
use crate::appearance::paper::MirroredSky;
use crate::appearance::picture::InkPicture;
use crate::evaluate::curves::anchors;
use crate::evaluate::layer::{LayerEnsemble, Mean};
use crate::evaluate::on_paper::{LayerOnPaper, Measured, PolarAngle};
use crate::evaluate::samples::{Solved, SolvedRealisation, SolvedWavelength};
use crate::evaluate::wavelengths::SpectralBasis;
use crate::numerics::estimate::{jackknife_covariance, jackknife_deviations};
use ndarray::Array2;
use std::f64::consts::PI;

/// Length of the step in the direction of a residual that a derivative is taken with.
const DERIVATIVE_STEP: f64 = 1e-4;

impl InkOnPaper {
    /// Colour of a quantity that is 1 for a perfect white diffuser, with the jackknife covariance of Lab.
    ///
    /// # Errors
    /// Wavelengths that cannot carry a colour.
    pub fn colour(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<Colour, InkError> {
        Ok(self.colour_with_deviations(quantity)?.0)
    }

    /// The same, and what each realisation moves Lab by, in the order of the realisations; nothing for one.
    ///
    /// # Errors
    /// As [`InkOnPaper::colour`].
    pub fn colour_with_deviations(
        &self,
        quantity: impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<(Colour, Vec<[f64; 3]>), InkError> {
        let labs = (0..self.replicates.len()).map(|r| Ok(self.colour_without(Some(r), &quantity)?.lab));
        let labs = labs.collect::<Result<Vec<_>, InkError>>()?;
        let whole = self.colour_without(None, &quantity)?;
        let colour = Colour { lab_covariance: jackknife_covariance(&labs), ..whole };
        Ok((colour, jackknife_deviations(&labs)))
    }

    /// How far the colour moves by what the spectra's fit leaves over at the wavelengths solved: the part of the colour that the
    /// wavelengths' spacing alone would have lost. It is in the colour; see [`InkOnPaper::colour`].
    ///
    /// # Errors
    /// As [`InkOnPaper::colour`].
    pub fn wavelength_shift(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<[f64; 3], InkError> {
        let meter = self.meter.as_ref().map_err(Clone::clone)?;
        let plain = meter.colour(&self.colour_values(&self.whole, &quantity))?;
        let full = self.colour_without(None, &quantity)?;
        Ok(std::array::from_fn(|i| full.lab[i] - plain.lab[i]))
    }

    /// Colour of the whole ensemble, without its uncertainty.
    ///
    /// # Errors
    /// As [`InkOnPaper::colour`].
    pub fn colour_of_mean(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<Colour, InkError> {
        self.colour_without(None, &quantity)
    }

    /// What the placing of the directions may cost in T̄ at each wavelength of the spectra: standard deviation over realisations of the
    /// quadrature error of the fitted curve, over √n.
    pub fn angle_errors(&self, solved: &[SolvedRealisation]) -> Vec<f64> {
        let at = |node: usize| {
            let nm = self.nodes.wavelengths_nm[node];
            let error = |realisation: &SolvedRealisation| {
                let strata = &realisation.wavelengths[nearest(&realisation.wavelengths, nm)].strata;
                let polar_deg = strata.iter().map(|s| s.polar_deg);
                self.whole[node].quadrature_error(polar_deg, self.layer.exit).transmittance
            };
            let errors: Vec<f64> = solved.iter().map(error).collect();
            let square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            (square / errors.len() as f64).sqrt()
        };
        self.places.outputs.clone().map(at).collect()
    }

    fn colour_values(&self, layers: &[LayerOnPaper], quantity: &impl Fn(&LayerOnPaper) -> f64) -> Vec<f64> {
        layers[self.places.colours.clone()].iter().map(quantity).collect()
    }

    /// XYZ = ∫ w F(m̂) + ⟨Σ_j w_j F′(m̂)·(x_j − m̂)⟩: the fitted means m̂, and to first order what the solves x_j say beyond
    /// them. So the smoothness of the fit costs the colour nothing.
    fn colour_without(
        &self,
        left_out: Option<usize>,
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Colour, InkError> {
        let meter = self.meter.as_ref().map_err(Clone::clone)?;
        let layers = left_out.map_or(&self.whole, |r| &self.replicates[r]);
        let mut xyz = meter.xyz(&self.colour_values(layers, quantity))?;
        let kept: Vec<usize> = (0..self.places.solved.len()).filter(|&r| Some(r) != left_out).collect();
        for &r in &kept {
            let nodes = self.places.solved[r].clone();
            let width = self.step_nm(nodes.len());
            for (j, node) in nodes.enumerate() {
                let moved = layers[node].moved(&self.residual(left_out, r, j, node), DERIVATIVE_STEP);
                let slope = (quantity(&moved) - quantity(&layers[node])) / DERIVATIVE_STEP;
                let weight = meter.weight_per_nm(self.nodes.wavelengths_nm[node]);
                (0..3).for_each(|c| xyz[c] += weight[c] * width * slope / kept.len() as f64);
            }
        }
        Ok(meter.colour_of(xyz))
    }

    /// Width of a stratum of wavelengths, nm.
    fn step_nm(&self, strata: usize) -> f64 {
        match self.layer.basis {
            SpectralBasis::Splines { range_nm: [from, to], .. } => (to - from) / strata.max(1) as f64,
            SpectralBasis::Listed(_) => 0.0,
        }
    }

    /// What a solve says beyond the fit.
    fn residual(&self, left_out: Option<usize>, r: usize, j: usize, node: usize) -> Measured {
        let shares = &self.nodes.shares[node];
        self.measured(|layer, column| layer.measured(r, j, column) - layer.fitted(left_out, shares, column))
    }

    /// Differences from the film at the anchors and of the means, by a source of them for any column of an ensemble.
    pub(super) fn measured(&self, of: impl Fn(&LayerEnsemble, usize) -> f64) -> Measured {
        let returned = self.returned.as_ref().map_or(&self.layer, |(layer, _)| layer);
        let at = |layer: &LayerEnsemble| {
            anchors(self.anchored, |angle, total| of(layer, layer.column(angle, total)))
        };
        let mean = |mean: Mean| of(returned, returned.mean_column(mean));
        Measured {
            anchors: at(&self.layer),
            returned: at(returned),
            transmittance: mean(Mean::Transmittance),
            absorptance: mean(Mean::ExitAbsorptance),
        }
    }

    /// Covariance of Lab that the placing of the directions alone has brought into a colour: each realisation's quadrature error of the
    /// fitted curves, a part of the jackknife's. `None` for one realisation.
    ///
    /// # Errors
    /// As [`InkOnPaper::colour`].
    pub fn angle_covariance(
        &self,
        solved: &[SolvedRealisation],
        quantity: impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Option<[[f64; 3]; 3]>, InkError> {
        let meter = self.meter.as_ref().map_err(Clone::clone)?;
        let mut shifted = Vec::new();
        for realisation in solved.iter().take(self.layer.replicates()) {
            let mut values = self.colour_values(&self.whole, &quantity);
            let strata: Vec<&[Solved]> =
                realisation.wavelengths.iter().map(|w| w.strata.as_slice()).collect();
            for (value, node) in values.iter_mut().zip(self.places.colours.clone()) {
                let near = nearest(&realisation.wavelengths, self.nodes.wavelengths_nm[node]);
                let error = self.whole[node]
                    .quadrature_error(strata[near].iter().map(|s| s.polar_deg), self.layer.exit);
                let moved = self.whole[node].moved(&error, DERIVATIVE_STEP);
                *value += (quantity(&moved) - quantity(&self.whole[node])) / DERIVATIVE_STEP;
            }
            shifted.push(meter.colour(&values)?.lab);
        }
        let n = shifted.len() as f64;
        // the covariance of a mean: the jackknife's formula over samples instead of replicates, less a factor (n − 1)²
        Ok(jackknife_covariance(&shifted).map(|c| c.map(|row| row.map(|x| x / (n - 1.0).powi(2)))))
    }

    /// The picture of P1 Fig. 6 at the given angles (0–60° there), rows viewing, columns illumination.
    ///
    /// The strip is natural light, with or without the mirrored sky; the square is π f(i, o), diffuse, averaged over
    /// the azimuth between the two planes (P1 leaves both open).
    ///
    /// # Errors
    /// Angles outside 0–90°, or wavelengths that cannot carry a colour.
    pub fn picture(&self, angles_deg: &[f64], sky: MirroredSky) -> Result<InkPicture, InkError> {
        let meter = self.meter.as_ref().map_err(Clone::clone)?;
        let angles = angles_deg.iter().map(|&a| self.at(a)).collect::<Result<Vec<PolarAngle>, _>>()?;
        let colour = |f: &dyn Fn(&LayerOnPaper) -> f64| {
            let values: Vec<f64> = self.whole[self.places.colours.clone()].iter().map(f).collect();
            meter.colour(&values)
        };
        let strip =
            angles.iter().map(|o| colour(&|l| l.natural_light(o, sky))).collect::<Result<Vec<_>, _>>()?;
        let cells = angles.iter().flat_map(|o| angles.iter().map(move |i| (o, i)));
        let square = cells.map(|(o, i)| colour(&|l| PI * l.brdf(i, o))).collect::<Result<Vec<_>, _>>()?;
        let square =
            Array2::from_shape_fn((angles.len(), angles.len()), |(o, i)| square[o * angles.len() + i]);
        Ok(InkPicture { angles_deg: angles_deg.to_vec(), strip, square })
    }
}

/// Place of the wavelength nearest to `nm`.
fn nearest(wavelengths: &[SolvedWavelength], nm: f64) -> usize {
    let distance = |w: &SolvedWavelength| (w.wavelength_nm - nm).abs();
    (0..wavelengths.len())
        .min_by(|&a, &b| distance(&wavelengths[a]).total_cmp(&distance(&wavelengths[b])))
        .unwrap_or(0)
}
