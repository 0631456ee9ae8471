//! Functions fitted over the angles: of one cosine, of two, and of the azimuth between the planes.
//! Their fits over all solves of an ensemble, to the difference from the coherent film.

use super::{Anchors, CURVES};
use crate::evaluate::films::{FilmAt, Films};
use crate::evaluate::layer::{LayerEnsemble, Total, film_totals};
use crate::evaluate::regression::{Fits, Normal};
use crate::evaluate::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};
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

/// Fitted curves over the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngleCurve {
    /// Coefficients of the curves between the anchors.
    pub bends: [[f64; BENDS]; CURVES],
    /// Coefficients in the light returned by the paper.
    pub returned: [[f64; BENDS]; CURVES],
    /// Coefficients of the layer's diffuse BRDF, 1/sr.
    pub diffuse: [f64; DIFFUSE],
    /// Coefficients of its dependence on the azimuth, 1/sr.
    pub azimuthal: [f64; AZIMUTHAL],
    /// Projected solid angle of an order, averaged over the ensemble, sr; the specular order
    /// contains this much diffuse light.
    pub order_area: f64,
}

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
    let sum = x + y;
    let product = x * y;
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

/// Fitted difference of a total from the film: weights of the anchors, and curve functions.
#[inline]
pub(super) fn curve(
    anchors: &Anchors,
    coefficients: &[f64; BENDS],
    between: [f64; 2],
    bends: [f64; BENDS],
    total: usize,
) -> f64 {
    between.iter().zip(anchors).map(|(w, a)| w * a[total]).sum::<f64>() + weighted(&bends, coefficients)
}

/// The sum of functions times their coefficients.
#[inline]
pub(super) fn weighted(functions: &[f64], coefficients: &[f64]) -> f64 {
    functions.iter().zip(coefficients).map(|(f, c)| f * c).sum()
}

/// Differences from the film at 0° and 45°.
pub(in crate::evaluate) fn anchors(places: [usize; 2], difference: impl Fn(usize, Total) -> f64) -> Anchors {
    let curves = [Total::Reflectance, Total::Transmittance, Total::SpecularReflectance];
    places.map(|angle| curves.map(|total| difference(angle, total)))
}

/// Fits the curves between the anchors, the azimuthal mean of the diffuse BRDF with `diffuse_width`
/// functions, and its dependence on the azimuth.
pub(in crate::evaluate) fn fits(
    layer: &LayerEnsemble,
    anchored: [usize; 2],
    solved: &[SolvedRealisation],
    films: &Films,
    diffuse_width: usize,
) -> [Fits; 3] {
    let mean = match diffuse_width {
        DIFFUSE => diffuse(layer, solved, &|lit, seen, _| diffuse_functions(lit, seen)),
        _ => diffuse(layer, solved, &|lit, seen, _| symmetric(lit, seen)),
    };
    [curves(layer, anchored, solved, films), mean, diffuse(layer, solved, &all_functions)]
}

/// Fits R, T and specular R between the anchors to what the solves in the strata add to film and
/// anchors.
pub(in crate::evaluate) fn curves(
    layer: &LayerEnsemble,
    anchored: [usize; 2],
    solved: &[SolvedRealisation],
    films: &Films,
) -> Fits {
    let samples = |r: usize, j: usize| {
        let wavelength = &solved[r].wavelengths[j];
        let thickness_um = solved[r].thickness_um;
        let at_anchors = anchors(anchored, |angle, total| layer.measured(r, j, layer.column(angle, total)));
        let film = films.of_thickness(wavelength.wavelength_nm, thickness_um);
        (wavelength.wavelength_nm, of_strata(&wavelength.strata, &film, &at_anchors))
    };
    let ensemble = (0..solved.len()).map(|r| (0..solved[r].wavelengths.len()).map(move |j| samples(r, j)));
    Fits::new(ensemble, &layer.basis, BENDS, CURVES)
}

/// Samples of the strata of one wavelength: curve functions against the rest of R, T and specular R
/// beyond film and anchors.
fn of_strata(strata: &[SolvedDirection], film: &FilmAt, at_anchors: &Anchors) -> Normal {
    let mut samples = Normal::new(BENDS, CURVES);
    for s in strata {
        let (between, bends) = anchor_weights(s.polar_deg.to_radians().cos());
        let [film_r, _, film_t, ..] = film_totals(film, s.polar_deg);
        let beyond = [s.reflectance - film_r, s.transmittance - film_t, s.specular_reflectance - film_r];
        let rest = |i: usize| beyond[i] - between[0] * at_anchors[0][i] - between[1] * at_anchors[1][i];
        samples.sample(&bends, &[0, 1, 2].map(rest));
    }
    samples
}

/// Functions of a sample: cosines of illumination and of the order, and sin θ_i sin θ_o cos Δφ.
type Functions<const N: usize> = dyn Fn(f64, f64, f64) -> [f64; N];

fn all_functions(lit: f64, seen: f64, s: f64) -> [f64; SYMMETRIC + AZIMUTHAL] {
    let mean = symmetric(lit, seen);
    let directional = azimuthal(lit, seen, s);
    std::array::from_fn(|k| if k < SYMMETRIC { mean[k] } else { directional[k - SYMMETRIC] })
}

/// Fits the layer's diffuse BRDF to all orders of all solves from the incident side: its azimuthal
/// mean, for colours, or its dependence on the azimuth, for renderers.
fn diffuse<const N: usize>(
    layer: &LayerEnsemble,
    solved: &[SolvedRealisation],
    functions: &Functions<N>,
) -> Fits {
    let samples =
        |wavelength: &SolvedWavelength| (wavelength.wavelength_nm, of_orders(wavelength, functions));
    Fits::new(solved.iter().map(|r| r.wavelengths.iter().map(samples)), &layer.basis, N, 1)
}

/// Samples of the reflected orders of all solves from the incident side at one wavelength:
/// functions against the BRDF.
fn of_orders<const N: usize>(wavelength: &SolvedWavelength, functions: &Functions<N>) -> Normal {
    let mut samples = Normal::new(N, 1);
    for s in wavelength.exact.iter().chain(&wavelength.strata) {
        let (sine, lit) = s.polar_deg.to_radians().sin_cos();
        for order in &s.scattered {
            samples.sample(&functions(lit, order.cosine, sine * order.along), &[order.density]);
        }
    }
    samples
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
