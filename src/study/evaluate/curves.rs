//! Fits over all solves of an ensemble: curves against the angle, fitted to the difference from the
//! coherent film.

use super::films::{FilmAt, Films};
use super::layer::{LayerEnsemble, Total, film_totals};
use super::on_paper::{
    AZIMUTHAL, Anchors, BENDS, DIFFUSE, LayerTotals, SYMMETRIC, anchor_weights, azimuthal, diffuse_functions,
    symmetric,
};
use super::regression::{Fits, Normal, Sums};
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};
use super::wavelengths::SpectralBasis;

/// Differences from the film at 0° and 45°.
pub(super) fn anchors(places: [usize; 2], of: impl Fn(usize, Total) -> f64) -> Anchors {
    places.map(|angle| LayerTotals {
        reflectance: of(angle, Total::Reflectance),
        transmittance: of(angle, Total::Transmittance),
        specular: of(angle, Total::SpecularReflectance),
    })
}

/// Fits the curves between the anchors, the azimuthal mean of the diffuse BRDF with `diffuse_width`
/// functions, and its dependence on the azimuth; empty without solves.
pub(super) fn fits(
    layer: &LayerEnsemble,
    anchored: [usize; 2],
    solved: &[SolvedRealisation],
    films: &Films,
    diffuse_width: usize,
) -> [Fits; 3] {
    if solved.is_empty() {
        let widths = [(BENDS, 3), (diffuse_width, 1), (SYMMETRIC + AZIMUTHAL, 1)];
        return widths.map(|(width, columns)| Fits::nothing(&layer.basis, width, columns));
    }
    let mean = match diffuse_width {
        DIFFUSE => diffuse::<DIFFUSE>(layer, solved, &polarised_functions),
        _ => diffuse::<SYMMETRIC>(layer, solved, &mean_functions),
    };
    let directional = diffuse::<{ SYMMETRIC + AZIMUTHAL }>(layer, solved, &all_functions);
    [curves(layer, anchored, solved, films), mean, directional]
}

/// Fits R, T and specular R between the anchors to what the solves in the strata add to film and
/// anchors.
pub(super) fn curves(
    layer: &LayerEnsemble,
    anchored: [usize; 2],
    solved: &[SolvedRealisation],
    films: &Films,
) -> Fits {
    let parts = solved.iter().enumerate();
    let parts: Vec<Normal> = parts.map(|part| normal_of_curves(layer, anchored, part, films)).collect();
    Fits::new(&parts, &layer.basis, BENDS)
}

/// Normal equations of the curves for realisation `r`.
fn normal_of_curves(
    layer: &LayerEnsemble,
    anchored: [usize; 2],
    (r, realisation): (usize, &SolvedRealisation),
    films: &Films,
) -> Normal {
    let mut normal = Normal::new(layer.basis.len() * BENDS, 3);
    for (j, at) in realisation.wavelengths.iter().enumerate() {
        let film = films.of_thickness(at.wavelength_nm, realisation.thickness_um);
        let own = anchors(anchored, |angle, total| layer.measured(r, j, layer.column(angle, total)));
        normal.add(&layer.basis.weights(at.wavelength_nm), &sums_of_strata(&at.strata, &film, &own));
    }
    normal
}

/// Sums over the strata of one wavelength: curve functions against the rest of R, T and specular R
/// beyond film and anchors.
fn sums_of_strata(strata: &[SolvedDirection], film: &FilmAt, own: &Anchors) -> Sums {
    let mut sums = Sums::new(BENDS, 3);
    for s in strata {
        let (between, bends) = anchor_weights(s.polar_deg.to_radians().cos());
        let [film_r, _, film_t, ..] = film_totals(film, s.polar_deg);
        let rest = |value: f64, of: fn(&LayerTotals) -> f64| {
            value - between[0] * of(&own[0]) - between[1] * of(&own[1])
        };
        let rests = [
            rest(s.reflectance - film_r, |t| t.reflectance),
            rest(s.transmittance - film_t, |t| t.transmittance),
            rest(s.specular_reflectance - film_r, |t| t.specular),
        ];
        sums.add(&bends, &rests);
    }
    sums
}

/// Functions of a sample: cosines of illumination and of the order, and sin θ_i sin θ_o cos Δφ.
type Functions<const N: usize> = dyn Fn(f64, f64, f64) -> [f64; N];

fn mean_functions(lit: f64, seen: f64, _: f64) -> [f64; SYMMETRIC] {
    symmetric(lit, seen)
}

fn polarised_functions(lit: f64, seen: f64, _: f64) -> [f64; DIFFUSE] {
    diffuse_functions(lit, seen)
}

fn all_functions(lit: f64, seen: f64, s: f64) -> [f64; SYMMETRIC + AZIMUTHAL] {
    let (mean, directional) = (symmetric(lit, seen), azimuthal(lit, seen, s));
    std::array::from_fn(|k| if k < SYMMETRIC { mean[k] } else { directional[k - SYMMETRIC] })
}

/// Fits the layer's diffuse BRDF to all orders of all solves from the incident side: its azimuthal
/// mean, for colours, or its dependence on the azimuth, for renderers.
fn diffuse<const N: usize>(
    layer: &LayerEnsemble,
    solved: &[SolvedRealisation],
    functions: &Functions<N>,
) -> Fits {
    let parts = solved.iter().map(|realisation| normal_of_orders(&layer.basis, realisation, functions));
    Fits::new(&parts.collect::<Vec<_>>(), &layer.basis, N)
}

/// Normal equations of the diffuse BRDF for one realisation.
fn normal_of_orders<const N: usize>(
    basis: &SpectralBasis,
    realisation: &SolvedRealisation,
    functions: &Functions<N>,
) -> Normal {
    let mut normal = Normal::new(basis.len() * N, 1);
    for at in &realisation.wavelengths {
        normal.add(&basis.weights(at.wavelength_nm), &sums_of_orders(at, functions));
    }
    normal
}

/// Sums over the reflected orders of all solves from the incident side at one wavelength: functions
/// against the BRDF.
fn sums_of_orders<const N: usize>(at: &SolvedWavelength, functions: &Functions<N>) -> Sums {
    let mut sums = Sums::new(N, 1);
    for s in at.exact.iter().chain(&at.strata) {
        let (sine, lit) = s.polar_deg.to_radians().sin_cos();
        for order in &s.scattered {
            sums.add(&functions(lit, order.cosine, sine * order.along), &[order.density]);
        }
    }
    sums
}
