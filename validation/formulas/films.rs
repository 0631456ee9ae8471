//! Plane films by Fresnel's coefficients and the recursion of Airy summation, scalar wave (s-polarised light).
//!
//! Born and Wolf, Principles of Optics, 7th ed., 1.6 (55)–(58): a stack below a film acts as one interface, so the
//! film's own two faces sum up to r = (r₁ + r₂ p²)/(1 + r₁ r₂ p²), t = t₁ t₂ p/(1 + r₁ r₂ p²), p = e^{i k_z d}.

use num_complex::Complex64;
use std::f64::consts::TAU;

/// One homogeneous film.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    pub index: Complex64,
    pub thickness_um: f64,
}

/// Amplitudes (r, t) of a stack between two half-spaces, light from the first at `polar_deg`; r refers to the first
/// face, t to the last.
pub fn amplitudes(
    first: f64,
    films: &[Film],
    last: Complex64,
    wavelength_um: f64,
    polar_deg: f64,
) -> [Complex64; 2] {
    let k0 = TAU / wavelength_um;
    let lateral = k0 * first * polar_deg.to_radians().sin();
    let normal = |index: Complex64| {
        let root = (index * index * k0 * k0 - lateral * lateral).sqrt();
        // Decaying, or travelling onwards.
        if root.im < 0.0 || (root.im == 0.0 && root.re < 0.0) { -root } else { root }
    };
    let mut kz: Vec<Complex64> = vec![Complex64::from(k0 * first * polar_deg.to_radians().cos())];
    kz.extend(films.iter().map(|f| normal(f.index)));
    kz.push(normal(last));
    let mut r = Complex64::ZERO;
    let mut t = Complex64::ONE;
    for j in (0..kz.len() - 1).rev() {
        let sum = kz[j] + kz[j + 1];
        let face_r = (kz[j] - kz[j + 1]) / sum;
        let face_t = 2.0 * kz[j] / sum;
        let p = match films.get(j) {
            Some(film) => (Complex64::I * kz[j + 1] * film.thickness_um).exp(),
            None => Complex64::ONE,
        };
        let many = 1.0 + face_r * r * p * p;
        (r, t) = ((face_r + r * p * p) / many, face_t * t * p / many);
    }
    [r, t]
}
