//! What the mean wave loses in every layer of a stack, and how much of it the layer absorbs.

use super::FAINT;
use super::film_matrix::FilmMatrix;
use super::stack_film::{FilmElement, StackFilm};
use crate::appearance::composed::plate::Plate;
use faer::Mat;
use num_complex::Complex64;

impl StackFilm {
    /// Shares of light at 0° that the mean wave loses in every layer, with interference and as
    /// composing has it; `layers` are those of the elements.
    pub(in crate::appearance::composed) fn lost(&self, layers: &[usize]) -> [Vec<f64>; 2] {
        let beyond = self.beyond(&[0.0], 0);
        let count = layers.iter().max().map_or(0, |last| last + 1);
        let mut waves = vec![FilmMatrix::NONE; count];
        let mut powers = vec![FilmMatrix::NONE.powers(); count];
        for ((element, beyond), layer) in self.elements.iter().zip(&beyond).zip(layers) {
            let (next, next_powers) = self.element(element, beyond, &[1.0], 0, 0.0);
            waves[*layer] = waves[*layer].then(next);
            powers[*layer] = powers[*layer].then(next_powers);
        }
        let onward = |front: &FilmMatrix<Complex64>, behind: &FilmMatrix<Complex64>| {
            let down = front.transmitted / (1.0 - front.reflected[1] * behind.reflected[0]);
            down.norm_sqr() * (1.0 - behind.reflected[0].norm_sqr())
        };
        let onward_powers = |front: &FilmMatrix<f64>, behind: &FilmMatrix<f64>| {
            let down = front.transmitted / (1.0 - front.reflected[1] * behind.reflected[0]).max(FAINT);
            down * (1.0 - behind.reflected[0])
        };
        [
            lost_in_a_row(&waves, FilmMatrix::NONE, |front, behind| front.then(behind), onward),
            lost_in_a_row(
                &powers,
                FilmMatrix::NONE.powers(),
                |front, behind| front.then(behind),
                onward_powers,
            ),
        ]
    }

    /// What an element absorbs of the mean wave that it takes away at 0°, as a share; the rest is
    /// scattered. `plate` is the element as fluxes.
    pub(in crate::appearance::composed) fn absorbed_of_lost(element: &FilmElement, plate: &Plate) -> f64 {
        let FilmElement::Solved(solved) = element else { return 1.0 };
        let [reflected, transmitted] = solved.amplitudes[0][0][0].map(|amplitude| amplitude.norm_sqr());
        let lost = 1.0 - reflected - transmitted;
        let leaves = |fluxes: &Mat<f64>| fluxes.col(0).iter().sum::<f64>();
        let absorbed = 1.0 - leaves(&plate.reflection[0]) - leaves(&plate.transmission[0]);
        if lost > FAINT { (absorbed / lost).clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// What light loses in every one of layers in a row, with nothing behind them: `onward` is the net
/// flux between those in front of a joint and those behind it.
fn lost_in_a_row<M: Copy>(
    layers: &[M],
    none: M,
    then: fn(M, M) -> M,
    onward: impl Fn(&M, &M) -> f64,
) -> Vec<f64> {
    let mut behind = vec![none];
    for layer in layers.iter().rev() {
        behind.push(then(*layer, behind[behind.len() - 1]));
    }
    let mut front = none;
    let mut entered = onward(&front, &behind[layers.len()]);
    let mut lost = Vec::new();
    for (place, layer) in layers.iter().enumerate() {
        front = then(front, *layer);
        let passed = onward(&front, &behind[layers.len() - 1 - place]);
        lost.push(entered - passed);
        entered = passed;
    }
    lost
}
