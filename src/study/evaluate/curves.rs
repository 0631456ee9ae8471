//! Fits over all solves of an ensemble: curves against the angle, fitted to the difference from the
//! coherent film.

use super::films::{FilmAt, Films};
use super::layer::{LayerEnsemble, Total, film_totals};
use super::on_paper::{
    AZIMUTHAL, Anchors, BENDS, CURVES, DIFFUSE, SYMMETRIC, anchor_weights, azimuthal, diffuse_functions,
    symmetric,
};
use super::regression::{Fits, Normal};
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};

/// Differences from the film at 0° and 45°.
pub(super) fn anchors(places: [usize; 2], of: impl Fn(usize, Total) -> f64) -> Anchors {
    let curves = [Total::Reflectance, Total::Transmittance, Total::SpecularReflectance];
    places.map(|angle| curves.map(|total| of(angle, total)))
}

/// Fits the curves between the anchors, the azimuthal mean of the diffuse BRDF with `diffuse_width`
/// functions, and its dependence on the azimuth.
pub(super) fn fits(
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
pub(super) fn curves(
    layer: &LayerEnsemble,
    anchored: [usize; 2],
    solved: &[SolvedRealisation],
    films: &Films,
) -> Fits {
    let samples = |r: usize, j: usize| {
        let (at, thickness_um) = (&solved[r].wavelengths[j], solved[r].thickness_um);
        let own = anchors(anchored, |angle, total| layer.measured(r, j, layer.column(angle, total)));
        (at.wavelength_nm, of_strata(&at.strata, &films.of_thickness(at.wavelength_nm, thickness_um), &own))
    };
    let ensemble = (0..solved.len()).map(|r| (0..solved[r].wavelengths.len()).map(move |j| samples(r, j)));
    Fits::new(ensemble, &layer.basis, [BENDS, CURVES])
}

/// Samples of the strata of one wavelength: curve functions against the rest of R, T and specular R
/// beyond film and anchors.
fn of_strata(strata: &[SolvedDirection], film: &FilmAt, own: &Anchors) -> Normal {
    let mut samples = Normal::new(BENDS, CURVES);
    for s in strata {
        let (between, bends) = anchor_weights(s.polar_deg.to_radians().cos());
        let [film_r, _, film_t, ..] = film_totals(film, s.polar_deg);
        let beyond = [s.reflectance - film_r, s.transmittance - film_t, s.specular_reflectance - film_r];
        let rest = |i: usize| beyond[i] - between[0] * own[0][i] - between[1] * own[1][i];
        samples.sample(&bends, &[0, 1, 2].map(rest));
    }
    samples
}

/// Functions of a sample: cosines of illumination and of the order, and sin θ_i sin θ_o cos Δφ.
type Functions<const N: usize> = dyn Fn(f64, f64, f64) -> [f64; N];

fn all_functions(lit: f64, seen: f64, s: f64) -> [f64; SYMMETRIC + AZIMUTHAL] {
    let (mean, directional) = (symmetric(lit, seen), azimuthal(lit, seen, s));
    std::array::from_fn(|k| if k < SYMMETRIC { mean[k] } else { directional[k - SYMMETRIC] })
}

/// Fits the layer's diffuse BRDF to all orders of all solves from the incident side: its azimuthal
/// mean, for colours, or its dependence on the azimuth, for renderers.
fn diffuse<const N: usize>(layer: &LayerEnsemble, solved: &[SolvedRealisation], of: &Functions<N>) -> Fits {
    let samples = |at: &SolvedWavelength| (at.wavelength_nm, of_orders(at, of));
    Fits::new(solved.iter().map(|r| r.wavelengths.iter().map(samples)), &layer.basis, [N, 1])
}

/// Samples of the reflected orders of all solves from the incident side at one wavelength:
/// functions against the BRDF.
fn of_orders<const N: usize>(at: &SolvedWavelength, functions: &Functions<N>) -> Normal {
    let mut samples = Normal::new(N, 1);
    for s in at.exact.iter().chain(&at.strata) {
        let (sine, lit) = s.polar_deg.to_radians().sin_cos();
        for order in &s.scattered {
            samples.sample(&functions(lit, order.cosine, sine * order.along), &[order.density]);
        }
    }
    samples
}
