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
    let light = Light { first, last, wavelength_um, polar_deg, is_p };
    let fields = light.fields(films);
    let entry = light.admittances(first.into())[1];
    let exit = light.admittances(last.into())[1];
    let [u, v] = fields[0];
    let incident = (entry * u + v) / (2.0 * entry);
    let reflected = (entry * u - v) / (2.0 * entry);
    [(reflected / incident).norm_sqr(), exit.re / entry.re / incident.norm_sqr()]
}

/// Share of the light that every film absorbs: the flux Re U*V at its front less that at its back.
pub fn absorbed(
    [first, last]: [f64; 2],
    films: &[Film],
    wavelength_um: f64,
    polar_deg: f64,
    is_p: bool,
) -> Vec<f64> {
    let light = Light { first, last, wavelength_um, polar_deg, is_p };
    let fields = light.fields(films);
    let entry = light.admittances(first.into())[1];
    let [u, v] = fields[0];
    let incident = ((entry * u + v) / (2.0 * entry)).norm_sqr() * entry.re;
    let flux = |[u, v]: [Complex64; 2]| (u.conj() * v).re / incident;
    fields.windows(2).map(|ends| flux(ends[0]) - flux(ends[1])).collect()
}

/// Light between two half-spaces.
struct Light {
    first: f64,
    last: f64,
    wavelength_um: f64,
    polar_deg: f64,
    is_p: bool,
}

impl Light {
    /// b and q in a medium.
    fn admittances(&self, index: Complex64) -> [Complex64; 2] {
        let along = self.first * self.polar_deg.to_radians().sin();
        let b = (index * index - along * along).sqrt();
        [b, if self.is_p { b / (index * index) } else { b }]
    }

    /// (U, V) in front of every film and behind the last one, where the amplitude is 1.
    fn fields(&self, films: &[Film]) -> Vec<[Complex64; 2]> {
        let mut fields = vec![[Complex64::ONE, self.admittances(self.last.into())[1]]];
        for film in films.iter().rev() {
            let [b, q] = self.admittances(film.index);
            let phase = TAU / self.wavelength_um * film.thickness_um * b;
            let sin = phase.sin();
            let cos = phase.cos();
            let [u, v] = fields[fields.len() - 1];
            fields.push([cos * u - Complex64::I * sin / q * v, cos * v - Complex64::I * q * sin * u]);
        }
        fields.reverse();
        fields
    }
}
