//! Plane films for either polarisation, by characteristic matrices.
//!
//! Born and Wolf, Principles of Optics, 7th ed., 1.6 (36)–(51): the tangential fields (U, V) behind and before a film of
//! normal index b and thickness d are related by [[cos β, −i sin β / q], [−i q sin β, cos β]], β = k₀ b d, with the
//! admittance q = b for s and b/η² for p light. Nothing is shared with the recursion of [`super::films`].

use super::films::Film;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// (R, T) of films between half-spaces of these indices, light from the first at `polar_deg`.
pub fn totals(
    [first, last]: [f64; 2],
    films: &[Film],
    wavelength_um: f64,
    polar_deg: f64,
    is_p: bool,
) -> [f64; 2] {
    let along = first * polar_deg.to_radians().sin();
    let admittance = |index: Complex64| {
        let b = (index * index - along * along).sqrt();
        (b, if is_p { b / (index * index) } else { b })
    };
    let (_, entry) = admittance(first.into());
    let (_, exit) = admittance(last.into());
    // fields behind the last film, whose amplitude is 1
    let (mut u, mut v) = (Complex64::ONE, exit);
    for film in films.iter().rev() {
        let (b, q) = admittance(film.index);
        let phase = TAU / wavelength_um * film.thickness_um * b;
        let (sin, cos) = (phase.sin(), phase.cos());
        (u, v) = (cos * u - Complex64::I * sin / q * v, cos * v - Complex64::I * q * sin * u);
    }
    let incident = (entry * u + v) / (2.0 * entry);
    let reflected = (entry * u - v) / (2.0 * entry);
    [(reflected / incident).norm_sqr(), exit.re / entry.re / incident.norm_sqr()]
}
