//! Functions fitted over the angles: of one cosine, of two, and of the azimuth between their
//! planes.

use std::f64::consts::FRAC_1_SQRT_2;

/// Number of functions of a curve, in addition to its values at 0° and 45°.
pub const BENDS: usize = 2;
/// Number of symmetric functions of both cosines in the diffuse BRDF.
pub const SYMMETRIC: usize = 6;
/// Number of functions including the antisymmetric ones, which occur for polarised incident light
/// if both polarisations are observed.
pub const DIFFUSE: usize = 9;
/// Number of functions of the azimuth between the planes.
pub const AZIMUTHAL: usize = 4;

/// Basis of a curve over μ: weights of its values at 0° and 45° (Lagrange polynomials through these
/// and zero at grazing, where every layer reflects everything), and functions that vanish at all
/// three.
pub fn anchor_weights(mu: f64) -> ([f64; 2], [f64; BENDS]) {
    let print = FRAC_1_SQRT_2;
    let normal = mu * (mu - print) / (1.0 - print);
    let slanted = mu * (1.0 - mu) / (print * (1.0 - print));
    let bend = mu * (1.0 - mu) * (mu - print);
    ([normal, slanted], std::array::from_fn(|b| bend * mu.powi(b as i32)))
}

/// Polynomials of both cosines, at most of second degree in each, symmetric under exchange
/// (reciprocity).
pub fn symmetric(x: f64, y: f64) -> [f64; SYMMETRIC] {
    let (sum, product) = (x + y, x * y);
    [1.0, sum, product, x * x + y * y, product * sum, product * product]
}

/// Symmetric and antisymmetric polynomials of the cosines of illumination and viewing.
pub fn diffuse_functions(lit: f64, seen: f64) -> [f64; DIFFUSE] {
    let [one, sum, product, squares, mixed, fourth] = symmetric(lit, seen);
    let apart = lit - seen;
    [one, sum, product, squares, mixed, fourth, apart, apart * sum, apart * product]
}

/// Functions of both cosines and of s = sin θ_i sin θ_o cos Δφ with zero mean over Δφ, symmetric
/// under exchange of the directions: cos Δφ with first-order corrections, and cos 2Δφ. The powers
/// of the sines keep f smooth at the normal.
pub fn azimuthal(x: f64, y: f64, s: f64) -> [f64; AZIMUTHAL] {
    [s, s * (x + y), s * x * y, 2.0 * s * s - (1.0 - x * x) * (1.0 - y * y)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_pass_through_their_anchors_and_vanish_at_grazing() {
        let ([normal, slanted], bends) = anchor_weights(1.0);
        assert!(normal == 1.0 && slanted == 0.0 && bends == [0.0; BENDS]);
        let (between, bends) = anchor_weights(FRAC_1_SQRT_2);
        assert!(between[0].abs() < 1e-15 && (between[1] - 1.0).abs() < 1e-15 && bends[0].abs() < 1e-15);
        assert_eq!(anchor_weights(0.0), ([0.0; 2], [0.0; BENDS]));
    }
}
