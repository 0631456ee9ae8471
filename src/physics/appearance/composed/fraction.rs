//! A fraction of a slab: what an even medium does over a part of the slab's thickness.
//!
//! Light that comes from both sides alike (+) or with opposite signs (−) meets C± = R ± T. In an
//! even medium, with F₊ and F₋ the fluxes onward and back and (F₊ + F₋)″ = Γ² (F₊ + F₋),
//!
//! ```text
//! Y = (1 − C₊)/(1 + C₊) ∝ tanh Γh/2      X = (1 + C₋)/(1 − C₋) ∝ tanh Γh/2      X Y = tanh² Γh/2
//! Y(f) = Y g(X Y)      X(f) = g(X Y) X      g(θ) = tanh(f artanh √θ)/√θ
//! ```
//!
//! for the part f of h. With étendues taken out, reciprocal matrices are symmetric, and no gain and
//! no loss arise that the slab does not have. Of a slab so opaque that T is noise or rounding in
//! some direction, there θ is held below 1: then a part passes more than it should, of light that
//! the layer does not pass.

use super::plate::Plate;
use crate::numerics::dense::symmetric_eigen;
use faer::Mat;

/// Étendue that stands for a beam, which has none: what goes from the diffuse light into it is as
/// small.
const PENCIL: f64 = 1e-10;
/// Distance from total loss, total reflection and total opacity that keeps quotients finite.
const LEAST: f64 = 1e-12;
/// Below this θ, g is its series.
const SMALL: f64 = 1e-6;

impl Plate {
    /// This part, 0 to 1, of a slab that is alike from both sides; étendues of its states, 0 for
    /// beams. `None` if eigenvalues are not found: entries that are not finite.
    pub fn fraction(&self, part: f64, weights: &[f64]) -> Option<Self> {
        let etendue: Vec<f64> = weights.iter().map(|w| if *w > 0.0 { *w } else { PENCIL }).collect();
        // without étendues; light goes from beams to nodes alone, and reciprocity gives the rest
        let even_out = |m: &Mat<f64>| {
            let scaled = |i: usize, j: usize| m[(i, j)] * (etendue[j] / etendue[i]).sqrt();
            Mat::from_fn(weights.len(), weights.len(), |i, j| match (weights[i] > 0.0, weights[j] > 0.0) {
                (true, false) => scaled(i, j),
                (false, true) => scaled(j, i),
                _ => 0.5 * (scaled(i, j) + scaled(j, i)),
            })
        };
        let r = even_out(&self.reflection[0]);
        let t = even_out(&self.transmission[0]);
        let y = function_of(&(&r + &t), |c| ((1.0 - c) / (1.0 + c).max(LEAST)).max(0.0))?;
        let x = function_of(&(&r - &t), |c| ((1.0 + c) / (1.0 - c).max(LEAST)).max(0.0))?;
        let root = function_of(&y, |y| y.max(0.0).sqrt())?;
        let product = &root * &x * &root;
        let part_y = &root * function_of(&product, |theta| shrunk(part, theta))? * &root;
        let further = |theta: f64| shrunk_further(part, theta);
        let part_x = part * &x + &x * &root * function_of(&product, further)? * &root * &x;
        let alike = function_of(&part_y, |y| (1.0 - y) / (1.0 + y.max(0.0)))?;
        let opposite = function_of(&part_x, |x| (x - 1.0) / (x.max(0.0) + 1.0))?;
        let flux = |sign: f64| {
            Mat::from_fn(weights.len(), weights.len(), |i, j| {
                let into_a_beam = weights[i] == 0.0 && weights[j] > 0.0;
                let symmetric = 0.5 * (alike[(i, j)] + sign * opposite[(i, j)]);
                if into_a_beam { 0.0 } else { symmetric * (etendue[i] / etendue[j]).sqrt() }
            })
        };
        let back = flux(1.0);
        let onward = flux(-1.0);
        Some(Self { reflection: [back.clone(), back], transmission: [onward.clone(), onward] })
    }
}

/// g(θ).
fn shrunk(part: f64, theta: f64) -> f64 {
    let theta = theta.clamp(0.0, 1.0 - LEAST);
    if theta < SMALL {
        return part + theta * shrunk_further(part, theta);
    }
    (part * theta.sqrt().atanh()).tanh() / theta.sqrt()
}

/// (g(θ) − g(0))/θ with g(0) = f; its limit at 0 is f (1 − f²)/3.
fn shrunk_further(part: f64, theta: f64) -> f64 {
    if theta < SMALL {
        return part * (1.0 - part * part) / 3.0;
    }
    (shrunk(part, theta) - part) / theta.min(1.0)
}

/// A function of a symmetric matrix.
pub(super) fn function_of(matrix: &Mat<f64>, f: impl Fn(f64) -> f64) -> Option<Mat<f64>> {
    let (values, vectors) = symmetric_eigen(matrix)?;
    let scaled = Mat::from_fn(values.len(), values.len(), |i, j| vectors[(i, j)] * f(values[j]));
    Some(&scaled * vectors.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::composed::flux::Hemisphere;
    use crate::appearance::composed::ordinates::Ordinates;
    use crate::appearance::composed::transport::Transport;

    fn medium() -> Hemisphere {
        let ordinates = Ordinates::for_transfer(1.5, [3, 3]);
        Hemisphere { ordinates, polarisations: 1, oblique_deg: None }
    }

    fn distance(a: &Plate, b: &Plate) -> f64 {
        let pairs = [(&a.reflection[0], &b.reflection[0]), (&a.transmission[0], &b.transmission[0])];
        pairs.iter().map(|(a, b)| (*a - *b).norm_max()).fold(0.0, f64::max)
    }

    /// Radiative transfer is a medium: a part of a layer is a thinner layer, beam and diffuse
    /// light, with and without absorption.
    #[test]
    fn a_part_of_an_even_layer_is_a_thinner_layer() {
        let inside = medium();
        for [k_s, k_a, g] in [[0.75, 0.0, 0.5], [0.4, 0.3, 0.7], [0.0, 0.2, 0.0], [0.6, 0.1, 0.2]] {
            let light = Transport { scattering_per_um: k_s, absorption_per_um: k_a, asymmetry: g };
            let slab = light.layer(&inside, 2.0).unwrap();
            for part in [0.0, 0.15, 0.5, 1.0] {
                let got = slab.fraction(part, &inside.weights()).unwrap();
                let thinner = || light.layer(&inside, 2.0 * part).unwrap();
                let want = if part > 0.0 { thinner() } else { Plate::nothing(7) };
                // the étendue that stands for the beam's adds some 1e-6
                assert!(distance(&got, &want) < 2e-5, "{k_s} {k_a} {part}: {}", distance(&got, &want));
            }
        }
    }

    /// Two parts are the slab, and no flux is negative, where noise of few realisations makes T no
    /// power of anything.
    #[test]
    fn parts_add_up_and_lose_nothing_with_noise() {
        let inside = medium();
        let weights = inside.weights();
        let whole: f64 = weights.iter().sum();
        // R of 0.7 and T of 0.3 to all directions, and noise that keeps reciprocity
        let noise = |i: usize, j: usize| 0.02 * ((i * j) as f64).sin();
        let shape = |share: f64, sign: f64| {
            let mut m = Mat::from_fn(7, 7, |i, j| weights[i] / whole * (share + sign * noise(i, j)));
            m[(0, 0)] = if sign > 0.0 { 0.0 } else { 0.01 };
            m
        };
        let r = shape(0.7, 1.0);
        let t = shape(0.3, -1.0);
        let slab = Plate { reflection: [r.clone(), r], transmission: [t.clone(), t] };
        let first = slab.fraction(0.3, &weights).unwrap();
        let second = slab.fraction(0.7, &weights).unwrap();
        let sums = |plate: &Plate, j: usize| -> f64 {
            (0..7).map(|i| plate.reflection[0][(i, j)] + plate.transmission[0][(i, j)]).sum()
        };
        for j in 1..inside.states() {
            // columns add up to 1, of which the pencil takes a little
            assert!((sums(&first, j) - 1.0).abs() < 1e-8, "{j}: {}", sums(&first, j));
        }
        // T of this slab is noise but for one direction's worth: of that the parts are made
        let both = first.then(&second);
        let total = |m: &Mat<f64>| -> f64 {
            (1..7).map(|j| (0..7).map(|i| m[(i, j)]).sum::<f64>() * weights[j] / whole).sum()
        };
        assert!((total(&both.transmission[0]) - 0.3).abs() < 0.01, "{}", total(&both.transmission[0]));
    }
}
