//! Colours and the picture of an ink on its paper, with the errors due to fits and angles.

use super::brightened::emitted_parts;
use super::{InkError, InkOnPaper, Places};
use crate::appearance::colour::Colour;
use crate::appearance::paper::MirroredSky;
use crate::appearance::picture::InkPicture;
use crate::appearance::tristimulus::{Colorimeter, EmissionWeights, Guide};
use crate::appearance::viewing::ColourError;
use crate::appearance::viewing::{Summation, Viewing};
use crate::evaluate::layer::{EnsembleMean, LayerEnsemble, Total};
use crate::evaluate::on_paper::curves::anchors;
use crate::evaluate::on_paper::{LayerOnPaper, MEASURED, Measured, PolarAngle};
use crate::evaluate::samples::{SolvedRealisation, SolvedWavelength};
use crate::evaluate::wavelengths::nearest;
use crate::numerics::estimate::{jackknife_covariance, jackknife_deviations};
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::ops::Range;

/// Step of the finite difference along a residual.
const DERIVATIVE_STEP: f64 = 1e-4;

/// Derivatives of a quantity at the wavelengths of one realisation.
type SolveSlopes = Vec<[f64; MEASURED]>;
/// Change of a quantity with what was measured, to first order: realisation, place of its
/// wavelength, node; change.
type Along<'a> = dyn Fn([usize; 3], &Measured) -> f64 + 'a;

/// Illuminant and observer with the wavelengths that are summed.
#[derive(Clone, Debug)]
pub struct Sight {
    pub(in crate::evaluate) meter: Colorimeter,
    /// Indices of the wavelengths.
    pub(super) nodes: Range<usize>,
    /// Whether the spectrum is known at the wavelengths that are summed alone, and not in between.
    apart: bool,
    /// Whether to add the residuals of the solves from the fitted spectra, which requires smooth
    /// weights.
    beyond_fit: bool,
    /// How light is summed that the paper emits under a lamp with lines; none where it is a part of
    /// factors like others.
    emission: Option<EmissionWeights>,
}

impl InkOnPaper {
    /// Prepares the sum for an illuminant and an observer. Plain sums use steps of 5 nm, at which
    /// film and fits are known, whatever the step of the spectra; tabulated weights (ASTM E308) are
    /// meant for the wavelengths of the spectra.
    ///
    /// # Errors
    /// The wavelengths do not suffice for a colour.
    pub fn sight(&self, viewing: &Viewing) -> Result<Sight, ColourError> {
        let tabulated = viewing.summation == Summation::E308;
        let nodes = if tabulated { &self.places.visible } else { &self.places.colours }.clone();
        let meter = Colorimeter::under(&self.nodes.wavelengths_nm[nodes.clone()], viewing)?;
        let apart = nodes == self.places.visible;
        let emission = self.emission(&meter, &nodes);
        Ok(Sight { meter, nodes, apart, beyond_fit: !tabulated && !viewing.has_lines(), emission })
    }

    /// Standard errors of Lab due to what the spectrum does between wavelengths, beside its film
    /// ([`Colorimeter::spacing`]); none where it is known every 5 nm.
    pub(in crate::evaluate) fn spacing(
        &self,
        sight: &Sight,
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Vec<[f64; 3]> {
        if !sight.apart {
            return Vec::new();
        }
        let Ok(xyz) = sight.xyz(&self.whole, quantity) else { return Vec::new() };
        if sight.emission.is_none() {
            let values = self.values(sight, quantity);
            return sight.meter.spacing(&values, xyz, self.guide(sight, quantity).as_ref());
        }
        let dark = |layer: &LayerOnPaper| quantity(&layer.dark());
        let guide = self.guide(sight, &dark);
        let mut shifts = sight.meter.spacing(&self.values(sight, &dark), xyz, guide.as_ref());
        shifts.extend(self.emission_between(sight, xyz, quantity));
        shifts
    }

    /// Standard error of Y due to the same.
    pub(in crate::evaluate) fn spacing_luminance(
        &self,
        sight: &Sight,
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> f64 {
        if !sight.apart {
            return 0.0;
        }
        let guide = self.guide(sight, quantity);
        sight.meter.spacing_luminance(&self.values(sight, quantity), guide.as_ref())
    }

    /// The quantity between the wavelengths of the spectra: of the coherent film beside a list, and
    /// fitted over a range.
    fn guide(&self, sight: &Sight, quantity: &impl Fn(&LayerOnPaper) -> f64) -> Option<Guide> {
        let [on_grid, fine] = self.guides(sight);
        let values = |nodes: &Range<usize>| self.whole[nodes.clone()].iter().map(quantity).collect();
        let fine_nm = self.nodes.wavelengths_nm[fine.clone()].to_vec();
        let guide = Guide { on_grid: values(on_grid), fine: values(fine), fine_nm };
        let known = guide.on_grid.iter().chain(&guide.fine).all(|value| value.is_finite());
        (known && !guide.on_grid.is_empty()).then_some(guide)
    }

    /// Where a guide is known: at the wavelengths of the spectra, and between them.
    pub(super) fn guides<'a>(&'a self, sight: &'a Sight) -> [&'a Range<usize>; 2] {
        let Places { guide, fine_guide, colours, visible, .. } = &self.places;
        if colours == visible { [guide, fine_guide] } else { [&sight.nodes, colours] }
    }

    /// Shifts of Lab due to errors of the tables of indices, each independent: add them in squares.
    ///
    /// # Errors
    /// A quantity that is no number.
    pub(in crate::evaluate) fn input_shifts(
        &self,
        sight: &Sight,
        xyz: [f64; 3],
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Vec<[f64; 3]>, InkError> {
        let here = sight.meter.colour_of(xyz).lab;
        let mut shifts = Vec::new();
        for change in self.input_changes(sight.nodes.clone(), quantity) {
            let by = sight.meter.xyz(&change)?;
            let there = sight.meter.colour_of(std::array::from_fn(|c| (xyz[c] + by[c]).max(0.0))).lab;
            shifts.push(std::array::from_fn(|i| FRAC_1_SQRT_2 * (there[i] - here[i])));
        }
        Ok(shifts)
    }

    /// Changes of Y by every move of a table; see [`InkOnPaper::input_changes`].
    ///
    /// # Errors
    /// A quantity that is no number.
    pub(in crate::evaluate) fn input_luminances(
        &self,
        sight: &Sight,
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Vec<f64>, InkError> {
        let changes = self.input_changes(sight.nodes.clone(), quantity);
        changes.iter().map(|change| Ok(sight.meter.xyz(change)?[1])).collect()
    }

    /// Colour of a quantity that is 1 for a perfect white diffuser, under D65 for the 2° observer,
    /// with the jackknife covariance of Lab.
    ///
    /// # Errors
    /// The wavelengths do not suffice for a colour.
    pub fn colour(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<Colour, InkError> {
        Ok(self.colour_with_deviations(&self.daylight()?, quantity)?.0)
    }

    /// Colour for any observer, with the contribution of each realisation to Lab, in order; empty
    /// for a single one.
    ///
    /// # Errors
    /// As for [`InkOnPaper::colour`].
    pub fn colour_with_deviations(
        &self,
        sight: &Sight,
        quantity: impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<(Colour, Vec<[f64; 3]>), InkError> {
        let labs: Vec<[f64; 3]> = self.replicates_of(sight, &quantity)?.iter().map(|c| c.lab).collect();
        let whole = self.colour_of_mean(sight, &quantity)?;
        Ok((Colour { lab_covariance: jackknife_covariance(&labs), ..whole }, jackknife_deviations(&labs)))
    }

    /// The colours of all leave-one-out ensembles.
    ///
    /// # Errors
    /// As for [`InkOnPaper::colour`].
    pub fn replicates_of(
        &self,
        sight: &Sight,
        quantity: impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Vec<Colour>, InkError> {
        let slopes = self.slopes(sight, &quantity);
        let along = |[r, j, _]: [usize; 3], by: &Measured| -> f64 {
            slopes[r][j].iter().zip(by.numbers()).map(|(slope, by)| slope * by).sum()
        };
        (0..self.replicates.len()).map(|r| self.colour_without(sight, Some(r), &along, &quantity)).collect()
    }

    /// Derivatives of a quantity at every solve; none where residuals do not count.
    fn slopes(&self, sight: &Sight, quantity: &impl Fn(&LayerOnPaper) -> f64) -> Vec<SolveSlopes> {
        let slopes = |node: usize| self.whole[node].slopes(quantity);
        let solved = self.places.solved.iter().filter(|_| sight.beyond_fit);
        solved.map(|nodes| nodes.clone().map(slopes).collect()).collect()
    }

    /// D65 and the 2° observer.
    ///
    /// # Errors
    /// As for [`InkOnPaper::colour`].
    pub fn daylight(&self) -> Result<Sight, ColourError> {
        self.sight(&Viewing::default())
    }

    /// Shift of the colour due to the residuals of the solves from the fitted spectra: the error
    /// that the spacing of the wavelengths alone would have caused. The colour is corrected for it;
    /// see [`InkOnPaper::colour`].
    ///
    /// # Errors
    /// As for [`InkOnPaper::colour`].
    pub fn wavelength_shift(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<[f64; 3], InkError> {
        let sight = self.daylight()?;
        let plain = sight.meter.colour(&self.values(&sight, &quantity))?;
        let full = self.colour_of_mean(&sight, &quantity)?;
        Ok(std::array::from_fn(|i| full.lab[i] - plain.lab[i]))
    }

    /// Colour of the whole ensemble, without its uncertainty.
    ///
    /// # Errors
    /// As for [`InkOnPaper::colour`].
    pub fn colour_of_mean(
        &self,
        sight: &Sight,
        quantity: impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Colour, InkError> {
        let along = |[_, _, node]: [usize; 3], by: &Measured| {
            let here = &self.whole[node];
            (quantity(&here.moved(by, DERIVATIVE_STEP)) - quantity(here)) / DERIVATIVE_STEP
        };
        self.colour_without(sight, None, &along, &quantity)
    }

    /// A quantity at the wavelengths that are summed.
    pub(in crate::evaluate) fn values(
        &self,
        sight: &Sight,
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Vec<f64> {
        sight.values(&self.whole, quantity)
    }

    /// Error of T̄ at each wavelength of the spectra due to the choice of directions: standard
    /// deviation over realisations of the quadrature error of the fitted curve, over √n.
    pub fn angle_errors(&self, solved: &[SolvedRealisation]) -> Vec<f64> {
        self.places.outputs.clone().map(|node| self.angle_error(node, solved)).collect()
    }

    /// Error of T̄ at one wavelength due to the choice of directions.
    fn angle_error(&self, node: usize, solved: &[SolvedRealisation]) -> f64 {
        let error = |realisation: &SolvedRealisation| {
            let strata = &nearest_solved(realisation, self.nodes.wavelengths_nm[node]).strata;
            self.whole[node].quadrature_error(strata, self.layer.exit).transmittance
        };
        let errors: Vec<f64> = solved.iter().map(error).collect();
        let square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        (square / errors.len() as f64).sqrt()
    }

    /// XYZ = ∫ w F(m̂) + ⟨Σ_j w_j F′·(x_j − m̂)⟩: the fitted means m̂ and, to first order, the
    /// residuals of the solves x_j. The smoothness of the fit therefore does not bias the colour.
    ///
    /// F′ is that of the whole ensemble: leaving one out changes it by 1/N, and residuals average
    /// out.
    fn colour_without(
        &self,
        sight: &Sight,
        left_out: Option<usize>,
        along: &Along,
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Colour, InkError> {
        let meter = &sight.meter;
        let layers = left_out.map_or(&self.whole, |r| &self.replicates[r]);
        let mut xyz = sight.xyz(layers, quantity)?;
        let kept: Vec<usize> = (0..self.places.solved.len()).filter(|&r| Some(r) != left_out).collect();
        for &r in kept.iter().filter(|_| sight.beyond_fit) {
            let nodes = self.places.solved[r].clone();
            // of a stratum of wavelengths, nm
            let width = self.places.range_nm / nodes.len().max(1) as f64;
            for (j, node) in nodes.enumerate() {
                let slope = along([r, j, node], &self.residual(left_out, r, j, node));
                let weight = meter.weight_per_nm(self.nodes.wavelengths_nm[node]);
                (0..3).for_each(|c| xyz[c] += weight[c] * width * slope / kept.len() as f64);
            }
        }
        Ok(meter.colour_of(xyz))
    }

    /// Residual of a solve from the fit.
    pub(super) fn residual(&self, left_out: Option<usize>, r: usize, j: usize, node: usize) -> Measured {
        let weights = &self.nodes.weights[node];
        self.measured(|layer, column| layer.measured(r, j, column) - layer.fitted(left_out, weights, column))
    }

    /// Differences from the film at the anchors and of the means; `number` gives those of any
    /// column of an ensemble.
    pub(super) fn measured(&self, number: impl Fn(&LayerEnsemble, usize) -> f64) -> Measured {
        let returned = self.returned.as_ref().map_or(&self.layer, |(layer, _)| layer);
        let at_anchors = |layer: &LayerEnsemble| {
            anchors(self.anchored, |angle, total| number(layer, layer.column(angle, total)))
        };
        let mean = |mean: EnsembleMean| number(returned, returned.mean_column(mean));
        Measured {
            anchors: at_anchors(&self.layer),
            returned: at_anchors(returned),
            straight_on: number(
                &self.layer,
                self.layer.column(self.anchored[0], Total::SpecularTransmittance),
            ),
            transmittance: mean(EnsembleMean::Transmittance),
            absorptance: mean(EnsembleMean::ExitAbsorptance),
        }
    }

    /// Covariance of Lab due to the choice of directions: the quadrature errors of the fitted
    /// curves in each realisation, a part of the jackknife covariance. `None` for a single
    /// realisation.
    ///
    /// # Errors
    /// As for [`InkOnPaper::colour`].
    pub fn angle_covariance(
        &self,
        solved: &[SolvedRealisation],
        quantity: impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Option<[[f64; 3]; 3]>, InkError> {
        let sight = self.daylight()?;
        let mut shifted = Vec::new();
        for realisation in solved.iter().take(self.layer.replicates()) {
            let mut values = self.values(&sight, &quantity);
            for (value, node) in values.iter_mut().zip(sight.nodes.clone()) {
                let near = nearest_solved(realisation, self.nodes.wavelengths_nm[node]);
                let error = self.whole[node].quadrature_error(&near.strata, self.layer.exit);
                let moved = self.whole[node].moved(&error, DERIVATIVE_STEP);
                *value += (quantity(&moved) - quantity(&self.whole[node])) / DERIVATIVE_STEP;
            }
            shifted.push(sight.meter.colour(&values)?.lab);
        }
        let n = shifted.len() as f64;
        // covariance of a mean: the jackknife formula over samples instead of replicates, divided
        // by (n − 1)²
        Ok(jackknife_covariance(&shifted).map(|c| c.map(|row| row.map(|x| x / (n - 1.0).powi(2)))))
    }

    /// The picture of P1 Fig. 6 at the given angles (0–60° there): rows are viewing, columns
    /// illumination angles.
    ///
    /// The strip is natural light, with or without the mirrored sky; the square is π f(i, o),
    /// diffuse, averaged over the azimuth between the two planes (P1 specifies neither).
    ///
    /// # Errors
    /// Angles outside 0–90°, or wavelengths that do not suffice for a colour.
    pub fn picture(&self, angles_deg: &[f64], sky: MirroredSky) -> Result<InkPicture, InkError> {
        let sight = self.daylight()?;
        let angles = angles_deg.iter().map(|&a| self.at(a)).collect::<Result<Vec<PolarAngle>, _>>()?;
        let colour = |f: &dyn Fn(&LayerOnPaper) -> f64| sight.meter.colour(&self.values(&sight, &f));
        let strip = |o: usize| colour(&|l| l.natural_light(&angles[o], sky));
        Ok(InkPicture::new(angles_deg, strip, |o, i| colour(&|l| PI * l.brdf(&angles[i], &angles[o])))?)
    }
}

impl Sight {
    fn values(&self, layers: &[LayerOnPaper], quantity: &impl Fn(&LayerOnPaper) -> f64) -> Vec<f64> {
        layers[self.nodes.clone()].iter().map(quantity).collect()
    }

    /// X, Y, Z of a quantity.
    fn xyz(
        &self,
        layers: &[LayerOnPaper],
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<[f64; 3], ColourError> {
        let Some(weights) = &self.emission else { return self.meter.xyz(&self.values(layers, quantity)) };
        let dark = self.meter.xyz(&self.values(layers, &|layer| quantity(&layer.dark())))?;
        let emitted = weights.xyz(&emitted_parts(&layers[self.nodes.clone()], quantity));
        Ok(std::array::from_fn(|c| dark[c] + emitted[c]))
    }
}

/// The solves at the wavelength nearest to `nm`.
fn nearest_solved(realisation: &SolvedRealisation, nm: f64) -> &SolvedWavelength {
    &realisation.wavelengths[nearest(realisation.wavelengths.iter().map(|w| w.wavelength_nm), nm)]
}
