//! A quantity of the layer on paper as weighted numbers take it: at the wavelengths that are
//! summed, with all that its errors follow from.

use super::InkOnPaper;
use crate::appearance::tristimulus::Guide;
use crate::evaluate::on_paper::LayerOnPaper;
use crate::evaluate::summed::{Residuals, SummedSpectrum};
use std::f64::consts::FRAC_1_SQRT_2;

impl InkOnPaper {
    /// A quantity at the wavelengths of weighted numbers; `changed` are the layers' quantities with
    /// each of the errors of R and T that all realisations share.
    pub(in crate::evaluate) fn summed(
        &self,
        quantity: &impl Fn(&LayerOnPaper) -> f64,
        changed: &[&dyn Fn(&LayerOnPaper) -> f64],
    ) -> SummedSpectrum {
        let sums = self.places.sums.clone();
        let values: Vec<f64> = self.whole[sums.clone()].iter().map(quantity).collect();
        let change = |number: &&dyn Fn(&LayerOnPaper) -> f64| -> Vec<f64> {
            self.whole[sums.clone()].iter().zip(&values).map(|(layer, value)| number(layer) - value).collect()
        };
        let of_inputs = |changes: Vec<f64>| changes.into_iter().map(|by| FRAC_1_SQRT_2 * by).collect();
        SummedSpectrum {
            wavelengths_nm: self.nodes.wavelengths_nm[sums.clone()].to_vec(),
            replicates: self
                .replicates
                .iter()
                .map(|layers| layers[sums.clone()].iter().map(quantity).collect())
                .collect(),
            shared: changed.iter().map(change).collect(),
            inputs: self.input_changes(sums.clone(), quantity).into_iter().map(of_inputs).collect(),
            guide: self.sum_guide(quantity),
            is_sampled: self.places.solved.is_empty(),
            residuals: self.sum_residuals(quantity),
            values,
        }
    }

    /// The quantity of the coherent film at and between the wavelengths of a list.
    fn sum_guide(&self, quantity: &impl Fn(&LayerOnPaper) -> f64) -> Option<Guide> {
        let values = |nodes: &std::ops::Range<usize>| -> Vec<f64> {
            self.whole[nodes.clone()].iter().map(quantity).collect()
        };
        let fine = &self.places.fine_sum_guide;
        let guide = Guide {
            on_grid: values(&self.places.sum_guide),
            fine: values(fine),
            fine_nm: self.nodes.wavelengths_nm[fine.clone()].to_vec(),
        };
        let known = guide.on_grid.iter().chain(&guide.fine).all(|value| value.is_finite());
        (known && !guide.on_grid.is_empty()).then_some(guide)
    }

    /// To first order, what the solves have beyond the fitted spectra.
    fn sum_residuals(&self, quantity: &impl Fn(&LayerOnPaper) -> f64) -> Residuals {
        let slopes: Vec<Vec<_>> = self
            .places
            .solved
            .iter()
            .map(|nodes| nodes.clone().map(|node| self.whole[node].slopes(quantity)).collect())
            .collect();
        let change = |left_out: Option<usize>, r: usize, j: usize| -> f64 {
            let node = self.places.solved[r].start + j;
            let by = self.residual(left_out, r, j, node);
            slopes[r][j].iter().zip(by.numbers()).map(|(slope, by)| slope * by).sum()
        };
        let nm = self.places.solved.iter().map(|nodes| self.nodes.wavelengths_nm[nodes.clone()].to_vec());
        Residuals::new(nm.collect(), self.places.range_nm, self.replicates.len(), &change)
    }
}
