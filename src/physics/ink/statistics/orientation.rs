//! The orientation tensor of elongated grains.

use crate::ink::Packing;

/// Q = (3⟨u u⟩ − 1)/2 over the axes of grains of more than one sphere: zero if isotropic (standard
/// error of a diagonal component 0.447/√N), diag(−½, −½, 1) if all are along z, diag(¼, ¼, −½) if
/// all are in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientationTensor {
    /// Q, symmetric and traceless, in the coordinates of the cell.
    pub q: [[f64; 3]; 3],
    /// Number of elongated grains averaged.
    pub grains: usize,
}

impl OrientationTensor {
    /// Order parameter S = ⟨3 cos²θ − 1⟩/2 about a unit axis.
    pub fn along(&self, axis: [f64; 3]) -> f64 {
        let row = |r: &[f64; 3]| r.iter().zip(&axis).map(|(q, a)| q * a).sum::<f64>();
        self.q.iter().zip(&axis).map(|(r, a)| row(r) * a).sum()
    }
}

/// The tensor of one pigment, or of all for `None`; the result is `None` without elongated grains.
pub fn orientation_tensor(packing: &Packing, pigment: Option<usize>) -> Option<OrientationTensor> {
    let wanted = |p: usize| pigment.is_none_or(|k| k == p);
    let axes: Vec<[f64; 3]> =
        packing.grains().iter().filter(|g| g.is_elongated() && wanted(g.pigment)).map(|g| g.axis).collect();
    let n = axes.len() as f64;
    let mean = |a: usize, b: usize| axes.iter().map(|u| u[a] * u[b]).sum::<f64>() / n;
    let unit = |a: usize, b: usize| if a == b { 1.0 } else { 0.0 };
    let component = |a: usize, b: usize| 1.5 * mean(a, b) - 0.5 * unit(a, b);
    let q = std::array::from_fn(|a| std::array::from_fn(|b| component(a, b)));
    (!axes.is_empty()).then_some(OrientationTensor { q, grains: axes.len() })
}
