//! One sphere in an infinite host: the series of Mie for the scalar wave and for Maxwell's equations.
//!
//! Bohren and Huffman, Absorption and Scattering of Light by Small Particles, 1983, chapter 4. With x = ka in the host, m = η/η_host,
//! ψ_l = x j_l(x), ξ_l = x h_l⁽¹⁾(x) and A_l = ψ_l'(mx)/ψ_l(mx):
//!
//!   a_l = (A_l ψ_l/m − ψ_l')/(A_l ξ_l/m − ξ_l')      b_l = (m A_l ψ_l − ψ_l')/(m A_l ξ_l − ξ_l')
//!
//! (4.88). The scalar wave joins u and its slope: rψ and its derivative, so its coefficients are b_l alone, from l = 0 on.
//! A_l runs downwards, A_{l−1} = l/z − 1/(A_l + l/z) (4.89), ψ_l = ψ_{l−1}/(l/x + A_l(x)) with it, and the second solution upwards:
//! each in the direction in which errors die out.

use num_complex::Complex64;
use std::f64::consts::TAU;

/// A sphere and its light.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    pub wavelength_um: f64,
    pub radius_um: f64,
    pub index: Complex64,
    pub host: f64,
}

/// Its series.
#[derive(Clone, Debug)]
pub struct Mie {
    /// Wavenumber in the host, 1/µm.
    pub k: f64,
    /// a_l, l = 0, 1, … (a_0 has no meaning).
    pub a: Vec<Complex64>,
    /// b_l, l = 0, 1, …
    pub b: Vec<Complex64>,
}

impl Sphere {
    pub fn mie(&self) -> Mie {
        let k = TAU / self.wavelength_um * self.host;
        let x = k * self.radius_um;
        let m = self.index / self.host;
        // Wiscombe's count with room: terms far beyond x vanish like (x/2l)^(2l).
        let last = (x + 4.05 * x.cbrt() + 12.0) as usize;
        let inside = logarithmic_derivatives(m * x, last);
        let outside = logarithmic_derivatives(x.into(), last);
        let mut psi = x.sin();
        let mut chi = [x.sin(), -x.cos()];
        let mut a = Vec::new();
        let mut b = Vec::new();
        for l in 0..=last {
            if l > 0 {
                psi /= l as f64 / x + outside[l].re;
                chi = [chi[1], (2 * l - 1) as f64 / x * chi[1] - chi[0]];
            }
            let slope = outside[l].re * psi;
            let xi = Complex64::new(psi, chi[1]);
            let xi_slope = Complex64::new(slope, chi[0] - l as f64 / x * chi[1]);
            let of = |d: Complex64| (d * psi - slope) / (d * xi - xi_slope);
            a.push(of(inside[l] / m));
            b.push(of(inside[l] * m));
        }
        Mie { k, a, b }
    }
}

/// A_l(z) = ψ_l'(z)/ψ_l(z), l = 0 … last, downwards from far beyond |z|.
fn logarithmic_derivatives(z: Complex64, last: usize) -> Vec<Complex64> {
    let start = last.max(z.norm() as usize) + 30;
    let mut values = vec![Complex64::default(); start + 1];
    for l in (1..=start).rev() {
        let ratio = l as f64 / z;
        values[l - 1] = ratio - 1.0 / (values[l] + ratio);
    }
    values.truncate(last + 1);
    values
}

impl Mie {
    /// f(θ) of the scalar wave: u → f e^{ikr}/r far away, f = (i/k) Σ (2l+1) b_l P_l(cos θ).
    pub fn scalar(&self, cosine: f64) -> Complex64 {
        let mut before = 0.0;
        let mut here = 1.0;
        let mut sum = Complex64::default();
        for (l, b) in self.b.iter().enumerate() {
            let n = l as f64;
            sum += b * ((2.0 * n + 1.0) * here);
            (before, here) = (here, ((2.0 * n + 1.0) * cosine * here - n * before) / (n + 1.0));
        }
        Complex64::I / self.k * sum
    }

    /// (S₁, S₂) at cos θ (4.74): E ⊥ and ∥ to the plane of scattering; E → (i/k) S E e^{ikr}/r.
    pub fn amplitudes(&self, cosine: f64) -> [Complex64; 2] {
        let mut before = 0.0;
        let mut pi = 1.0;
        let mut sums = [Complex64::default(); 2];
        for l in 1..self.a.len() {
            let n = l as f64;
            let tau = n * cosine * pi - (n + 1.0) * before;
            let weight = (2.0 * n + 1.0) / (n * (n + 1.0));
            sums[0] += (self.a[l] * pi + self.b[l] * tau) * weight;
            sums[1] += (self.a[l] * tau + self.b[l] * pi) * weight;
            (before, pi) = (pi, ((2.0 * n + 1.0) * cosine * pi - (n + 1.0) * before) / n);
        }
        sums
    }

    /// Efficiencies of scattering and extinction, (4.61) and (4.62) over πa², for Maxwell's equations.
    pub fn efficiencies(&self, radius_um: f64) -> [f64; 2] {
        let x = self.k * radius_um;
        let sum = |of: &dyn Fn(usize) -> f64| {
            2.0 / (x * x) * (1..self.a.len()).map(|l| (2 * l + 1) as f64 * of(l)).sum::<f64>()
        };
        [sum(&|l| self.a[l].norm_sqr() + self.b[l].norm_sqr()), sum(&|l| (self.a[l] + self.b[l]).re)]
    }
}
