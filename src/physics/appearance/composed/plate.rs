//! Flux matrices of a slab for light from both of its sides, and their composition.

use crate::numerics::dense::MatrixEntry;
use faer::Mat;

/// Reflection and transmission of a slab with sides a and b. Entry (i, j) is the share of a unit
/// flux in state j that goes to state i; states are those of the medium on the side concerned.
#[derive(Clone, Debug)]
pub struct Plate {
    /// Reflection of light from a, and of light from b.
    pub reflection: [Mat<f64>; 2],
    /// Transmission from a to b, and from b to a.
    pub transmission: [Mat<f64>; 2],
}

impl Plate {
    /// Nothing at all, in a medium with this number of states.
    pub fn nothing(states: usize) -> Self {
        let none = Mat::zeros(states, states);
        let all = Mat::identity(states, states);
        Self { reflection: [none.clone(), none], transmission: [all.clone(), all] }
    }

    /// The element turned over.
    pub fn turned(&self) -> Self {
        let [ra, rb] = self.reflection.clone();
        let [tab, tba] = self.transmission.clone();
        Self { reflection: [rb, ra], transmission: [tba, tab] }
    }

    /// A Lambertian surface of this albedo behind states with these étendues: nothing passes.
    pub fn lambertian(albedo: f64, weights: &[f64]) -> Self {
        let n = weights.len();
        let sum = weights.iter().sum::<f64>();
        let back = Mat::from_fn(n, n, |i, _| albedo * weights[i] / sum);
        let none = Mat::zeros(n, n);
        Self { reflection: [back, none.clone()], transmission: [none.clone(), none] }
    }

    /// This element in front of another, side b of this at side a of the other.
    pub fn then(&self, behind: &Self) -> Self {
        let [ra, rb] = &self.reflection;
        let [tab, tba] = &self.transmission;
        let [sa, sb] = &behind.reflection;
        let [uab, uba] = &behind.transmission;
        let down = bounced(rb, sa, tab);
        let up = bounced(sa, rb, uba);
        let back = tba * (sa * &down);
        Self { reflection: [ra + back, sb + uab * (rb * &up)], transmission: [uab * down, tba * up] }
    }

    /// With `by` more of the light reflected and less transmitted, as far as there is any.
    pub fn moved(mut self, by: f64) -> Self {
        for k in 0..2 {
            let r = &mut self.reflection[k];
            let t = &mut self.transmission[k];
            for j in 0..r.ncols() {
                let back = (0..r.nrows()).map(|i| r[(i, j)]).sum::<f64>();
                let onward = (0..t.nrows()).map(|i| t[(i, j)]).sum::<f64>();
                if back > by && onward > by {
                    (0..r.nrows()).for_each(|i| r[(i, j)] *= (back + by) / back);
                    (0..t.nrows()).for_each(|i| t[(i, j)] *= (onward - by) / onward);
                }
            }
        }
        self
    }

    /// This number of such elements, one behind another.
    pub fn repeated(&self, count: usize) -> Self {
        in_a_row(Self::nothing(self.reflection[0].nrows()), self.clone(), count, Self::then)
    }

    /// Fluxes \[onward, back\] of every state between this element and the one behind, for light
    /// `incident` on side a.
    pub fn between(&self, behind: &Self, incident: &Mat<f64>) -> [Mat<f64>; 2] {
        let down = bounced(&self.reflection[1], &behind.reflection[0], &(&self.transmission[0] * incident));
        let up = &behind.reflection[0] * &down;
        [down, up]
    }
}

/// (1 − A B)⁻¹ x.
pub(super) fn bounced(a: &Mat<f64>, b: &Mat<f64>, x: &Mat<f64>) -> Mat<f64> {
    let n = a.nrows();
    let product = a * b;
    let matrix = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - product[(i, j)]);
    f64::solve(&f64::factors(matrix.as_ref()), x.as_ref())
}

/// Sum of all entries.
pub fn total(flux: &Mat<f64>) -> f64 {
    (0..flux.ncols()).flat_map(|j| (0..flux.nrows()).map(move |i| flux[(i, j)])).sum()
}
/// This number of elements behind `nothing`, by products that are doubled.
pub(super) fn in_a_row<T>(nothing: T, one: T, mut count: usize, then: impl Fn(&T, &T) -> T) -> T {
    let mut power = one;
    let mut all = nothing;
    while count > 0 {
        if count % 2 == 1 {
            all = then(&all, &power);
        }
        count /= 2;
        if count > 0 {
            power = then(&power, &power);
        }
    }
    all
}
