//! Spectra of the layer alone as weighted numbers take them.

use super::{LayerSeen, MovedLayers};
use crate::appearance::tristimulus::Guide;
use crate::evaluate::films::FilmAt;
use crate::evaluate::layer::{Total, film_totals};
use crate::evaluate::summed::{Residuals, SummedSpectrum};
use crate::evaluate::uncertainty::{Shift, Uncertainty};
use crate::evaluate::wavelengths::SpectralBasis;
use crate::input::file::SeenLight;
use std::f64::consts::FRAC_1_SQRT_2;

/// What errors of R and T do to a total.
type MovedBy = fn(Shift) -> f64;

impl LayerSeen {
    /// A spectrum of light along the normal at the wavelengths of weighted numbers.
    ///
    /// # Errors
    /// 0° or the coherent amplitudes are missing.
    pub(in crate::evaluate) fn summed(
        &self,
        light: SeenLight,
        inputs: Option<&MovedLayers>,
        uncertainty: &Uncertainty,
    ) -> Result<SummedSpectrum, String> {
        let angle = self.ensemble.place(0.0).ok_or("there are no solves at 0°")?;
        let of_total = |total: Total, moved: MovedBy| self.total(angle, total, moved, inputs, uncertainty);
        let coherent = || self.coherent_summed(angle, inputs, uncertainty);
        Ok(match light {
            SeenLight::Reflectance => of_total(Total::Reflectance, |[r, _]| r),
            SeenLight::Absorptance => of_total(Total::Absorptance, |[r, t]| r + t),
            SeenLight::CoherentTransmittance => coherent()?,
            SeenLight::ScatteredTransmittance => {
                of_total(Total::Transmittance, |[_, t]| t).less(&coherent()?)
            }
            _ => of_total(Total::Transmittance, |[_, t]| t),
        })
    }

    /// Wavelengths that are summed, nm, with their films.
    fn places(&self) -> (&[f64], &[FilmAt]) {
        match self.ensemble.basis {
            SpectralBasis::Listed(_) => (&self.wavelengths_nm, &self.films),
            SpectralBasis::Splines { .. } => (&self.ensemble.sums_nm, &self.sum_films),
        }
    }

    fn total(
        &self,
        angle: usize,
        total: Total,
        moved: MovedBy,
        inputs: Option<&MovedLayers>,
        uncertainty: &Uncertainty,
    ) -> SummedSpectrum {
        let (nm, films) = self.places();
        let deg = self.ensemble.exact_deg[angle];
        let column = self.ensemble.column(angle, total);
        let film = |films: &[FilmAt]| -> Vec<f64> {
            films.iter().map(|film| film_totals(film, deg)[total as usize]).collect()
        };
        let spectrum = |left_out: Option<usize>| {
            let fitted = |&nm: &f64| self.ensemble.fitted(left_out, &self.ensemble.basis.weights(nm), column);
            film(films).iter().zip(nm).map(|(film, nm)| film + fitted(nm)).collect::<Vec<f64>>()
        };
        let is_sampled = matches!(self.ensemble.basis, SpectralBasis::Listed(_));
        let replicates = self.ensemble.replicates();
        SummedSpectrum {
            wavelengths_nm: nm.to_vec(),
            values: spectrum(None),
            replicates: (0..replicates).map(|r| spectrum(Some(r))).collect(),
            shared: shifts(nm, moved, uncertainty),
            inputs: inputs.map_or(Vec::new(), |layers| layers.sum_changes(angle, total)),
            guide: is_sampled.then(|| Guide {
                on_grid: film(&self.films),
                fine: film(&self.sum_films),
                fine_nm: self.ensemble.sums_nm.clone(),
            }),
            is_sampled,
            residuals: if is_sampled { Residuals::default() } else { self.residuals(column) },
        }
    }

    /// What the solves have beyond the fit of a column.
    fn residuals(&self, column: usize) -> Residuals {
        let ensemble = &self.ensemble;
        let nm: Vec<Vec<f64>> =
            (0..ensemble.realisations()).map(|r| ensemble.wavelengths_nm(r).collect()).collect();
        let SpectralBasis::Splines { range_nm: [from, to], .. } = ensemble.basis else {
            return Residuals::default();
        };
        let residual = |left_out: Option<usize>, r: usize, j: usize| {
            let weights = ensemble.basis.weights(nm[r][j]);
            ensemble.measured(r, j, column) - ensemble.fitted(left_out, &weights, column)
        };
        Residuals::new(nm.clone(), to - from, ensemble.replicates(), &residual)
    }

    /// |⟨t⟩|². Tables of indices move it as they move the specular order, to first order.
    fn coherent_summed(
        &self,
        angle: usize,
        inputs: Option<&MovedLayers>,
        uncertainty: &Uncertainty,
    ) -> Result<SummedSpectrum, String> {
        let coherent = self.coherent.as_ref().ok_or("a layer of uneven thickness has no coherent light")?;
        let (nm, films) = self.places();
        let deg = self.ensemble.exact_deg[angle];
        let without = coherent.without(angle, films, deg, nm);
        let moved: MovedBy = |[_, t]| t;
        let mut shared = shifts(nm, moved, uncertainty);
        // what is taken off as bias is known no better than by its size
        shared.push(without.iter().map(|left_out| left_out.variance).collect());
        let estimates = coherent.transmittance(angle, films, deg, nm);
        let is_sampled = matches!(self.ensemble.basis, SpectralBasis::Listed(_));
        let film = |films: &[FilmAt]| -> Vec<f64> {
            films.iter().map(|film| film_totals(film, deg)[Total::Transmittance as usize]).collect()
        };
        let replicate = |r: usize| without.iter().map(|left_out| left_out.powers[r]).collect();
        Ok(SummedSpectrum {
            wavelengths_nm: nm.to_vec(),
            values: estimates.iter().map(|estimate| estimate.value).collect(),
            replicates: (0..self.ensemble.replicates()).map(replicate).collect(),
            shared,
            inputs: inputs
                .map_or(Vec::new(), |layers| layers.sum_changes(angle, Total::SpecularTransmittance)),
            guide: is_sampled.then(|| Guide {
                on_grid: film(&self.films),
                fine: film(&self.sum_films),
                fine_nm: self.ensemble.sums_nm.clone(),
            }),
            is_sampled,
            residuals: Residuals::default(),
        })
    }
}

/// What errors that all realisations share do to a total: \[part\]\[wavelength\].
fn shifts(nm: &[f64], moved: MovedBy, uncertainty: &Uncertainty) -> Vec<Vec<f64>> {
    let part = |part: usize| nm.iter().map(|nm| moved(uncertainty.shift(part, *nm))).collect();
    (0..uncertainty.parts()).map(part).collect()
}

impl MovedLayers {
    /// Standard errors of a total at the wavelengths that are summed, by each table of indices.
    fn sum_changes(&self, angle: usize, total: Total) -> Vec<Vec<f64>> {
        let values = |layer: &LayerSeen| -> Vec<f64> {
            let (nm, films) = layer.places();
            let ensemble = &layer.ensemble;
            let deg = ensemble.exact_deg[angle];
            let fitted =
                |nm: f64| ensemble.fitted(None, &ensemble.basis.weights(nm), ensemble.column(angle, total));
            let film = |film: &FilmAt| film_totals(film, deg)[total as usize];
            films.iter().zip(nm).map(|(at_nm, &nm)| film(at_nm) + fitted(nm)).collect()
        };
        let unmoved = values(&self.few);
        let change = |moved: &LayerSeen| {
            values(moved).iter().zip(&unmoved).map(|(there, here)| FRAC_1_SQRT_2 * (there - here)).collect()
        };
        self.moved.iter().map(change).collect()
    }
}

impl SummedSpectrum {
    /// The spectrum less another of the same layer, whose errors of R and T are left out: both
    /// have the same.
    fn less(self, other: &Self) -> Self {
        let difference = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        let each = |a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<Vec<f64>> {
            a.iter().zip(b).map(|(a, b)| difference(a, b)).collect()
        };
        let extra = other.shared.get(self.shared.len()..).unwrap_or_default().to_vec();
        Self {
            values: difference(&self.values, &other.values),
            replicates: each(&self.replicates, &other.replicates),
            inputs: each(&self.inputs, &other.inputs),
            // a film scatters nothing
            guide: None,
            shared: [self.shared, extra].concat(),
            ..self
        }
    }
}
