//! Errors of the tables of indices: the layer of a few packings on its paper, as it is and with
//! every table moved by its standard error.

use super::InkOnPaper;
use crate::evaluate::on_paper::LayerOnPaper;
use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

/// Where the layer of a few packings stands among the nodes: index of its first node, whose
/// followers are those of the spectra and of the colours of the whole.
#[derive(Clone, Debug)]
pub(super) struct MovedNodes {
    /// As the study describes it.
    pub few: usize,
    /// With a table moved.
    pub moved: Vec<usize>,
}

impl InkOnPaper {
    /// Adds the layer of a few packings, as it is and with tables of indices moved by their errors,
    /// from which all errors due to these follow.
    pub(in crate::evaluate) fn keep_moved(&mut self, few: &Self, moved: &[&Self]) {
        let few = self.keep(few);
        let moved = moved.iter().map(|ink| self.keep(ink)).collect();
        self.moved = Some(MovedNodes { few, moved });
    }

    /// Adds the layers of another ink at the wavelengths of spectra and colours; the index of the
    /// first.
    fn keep(&mut self, other: &Self) -> usize {
        let start = self.whole.len();
        let count = other.places.fitted();
        self.nodes.wavelengths_nm.extend_from_slice(&other.nodes.wavelengths_nm[..count]);
        self.nodes.films.extend_from_slice(&other.nodes.films[..count]);
        self.nodes.albedos.extend_from_slice(&other.nodes.albedos[..count]);
        self.nodes.weights.extend_from_slice(&other.nodes.weights[..count]);
        self.nodes.means.extend_from_slice(&other.nodes.means[..count]);
        self.whole.extend(other.whole[..count].iter().map(|layer| layer.at_node(start + layer.node)));
        start
    }

    /// Changes of a quantity at some nodes by every move of a table by one standard error:
    /// \[move\]\[node\].
    /// Both sides of each error are among them, so that half of the sum of their squares is the
    /// variance.
    pub(in crate::evaluate) fn input_changes(
        &self,
        nodes: Range<usize>,
        quantity: impl Fn(&LayerOnPaper) -> f64,
    ) -> Vec<Vec<f64>> {
        let Some(MovedNodes { few, moved }) = &self.moved else { return Vec::new() };
        let value = |start: usize, node: usize| quantity(&self.whole[start + node]);
        let changes =
            |&start: &usize| nodes.clone().map(|node| value(start, node) - value(*few, node)).collect();
        moved.iter().map(changes).collect()
    }

    /// Standard error of a quantity at the `i`-th wavelength of the spectra due to the tables'
    /// errors.
    pub(in crate::evaluate) fn input_error(&self, i: usize, quantity: impl Fn(&LayerOnPaper) -> f64) -> f64 {
        let changes = self.input_changes(i..i + 1, quantity);
        changes.iter().flatten().fold(0.0, |sum: f64, change| sum.hypot(FRAC_1_SQRT_2 * change))
    }
}
