//! The coherent film: the layer with its contents averaged within every plane, solved exactly.
//!
//! Its index is √⟨η²⟩(z), as in the mean operator of the wave problem. The film contains the
//! interference fringes of the layer, so that the difference due to the grains is smooth in angle
//! and wavelength and needs few solves. In the limit of many solves the results do not depend on
//! the film; it only speeds up convergence.

use crate::wave::Side;
use crate::wave::maxwell::Polarisation;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Volume fractions across the layer, in equal slices from the incident side; as many in every
/// layer of a stack.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// \[slice\]\[inclusion\], 0–1; the rest is background.
    pub fractions: Vec<Vec<f64>>,
    /// The layers of a stack, in the order of the light; empty for a single layer.
    pub layers: Vec<ProfileLayer>,
}

/// One layer of a stack, as its film sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileLayer {
    /// Mean thickness, µm.
    pub thickness_um: f64,
    /// Whether what the stack has more or less than its mean thickness is in this layer.
    pub is_uneven: bool,
}

impl Profile {
    /// One slice without inclusions.
    pub fn homogeneous() -> Self {
        Self { fractions: vec![Vec::new()], layers: Vec::new() }
    }

    /// η² of every slice: Σ φ η² of the inclusions, and of its layer's background for the rest.
    pub fn squared_indices(&self, backgrounds: &[Complex64], inclusions: &[Complex64]) -> Vec<Complex64> {
        let each = self.fractions.len() / self.layers.len().max(1);
        let mixed = |(number, slice): (usize, &Vec<f64>)| {
            let background = backgrounds[number / each];
            let base = background * background;
            let add = |sum, (&share, &eta): (&f64, &Complex64)| sum + share * (eta * eta - base);
            slice.iter().zip(inclusions).fold(base, add)
        };
        self.fractions.iter().enumerate().map(mixed).collect()
    }

    /// Thicknesses of the layers of a stack of this whole thickness, µm.
    pub fn layers_um(&self, thickness_um: f64) -> Vec<f64> {
        if self.layers.is_empty() {
            return vec![thickness_um];
        }
        let more_um = thickness_um - self.layers.iter().map(|layer| layer.thickness_um).sum::<f64>();
        let own = |layer: &ProfileLayer| layer.thickness_um + if layer.is_uneven { more_um } else { 0.0 };
        self.layers.iter().map(own).collect()
    }
}

/// A stack of slices at one wavelength, equal ones in each layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// η² of the slices, from the incident side.
    pub squared_indices: Vec<Complex64>,
    /// Thicknesses of the layers, each of as many equal slices, µm.
    pub layers_um: Vec<f64>,
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
    /// Index of the half-space on the exit side; that on the incident side is vacuum.
    pub index_out: f64,
}

impl Film {
    /// (R, T) of a plane wave from `side`, with the polar angle in the half-space of incidence. The
    /// scalar wave behaves as s light. Grazing incidence gives the limit (1, 0).
    ///
    /// With admittances y, the normal index b for s and b/η² for p (where the amplitude is that of
    /// the magnetic field), from the far face backwards: Γ = (r + Γ′ e^{2ibh})/(1 + r Γ′ e^{2ibh})
    /// with r = (y_a − y_b)/(y_a + y_b); only decaying exponentials occur.
    pub fn reflectance_transmittance(&self, side: Side, polar_deg: f64, light: Polarisation) -> (f64, f64) {
        let [reflected, transmitted] = self.amplitudes(side, polar_deg, light);
        (reflected.norm_sqr(), transmitted.norm_sqr())
    }

    /// Amplitudes at the faces, reflected and transmitted, scaled so that their squares are R and
    /// T.
    pub fn amplitudes(&self, side: Side, polar_deg: f64, light: Polarisation) -> [Complex64; 2] {
        self.wave(side, polar_deg, light).amplitudes(&self.layers_um)
    }

    /// The wave in the film, for any thicknesses of its layers.
    pub fn wave(&self, side: Side, polar_deg: f64, light: Polarisation) -> FilmWave {
        let (from, to) = if side == Side::Incident { (1.0, self.index_out) } else { (self.index_out, 1.0) };
        let k0 = TAU / self.wavelength_um;
        let (sin, cos) = polar_deg.to_radians().sin_cos();
        if cos < 1e-12 {
            return FilmWave { slices: Vec::new(), front: Complex64::ONE, passed: 0.0 };
        }
        let along = from * sin;
        let admittance = |b: Complex64, squared: Complex64| match light {
            Polarisation::S => b,
            Polarisation::P => b / squared,
        };
        let entry = admittance(Complex64::from(from * cos), (from * from).into());
        let exit = admittance((Complex64::from(to * to) - along * along).sqrt(), (to * to).into());
        let count = self.squared_indices.len();
        let each = count / self.layers_um.len();
        let mut after = exit;
        let mut slices = Vec::with_capacity(count);
        for behind in 0..count {
            let number = if side == Side::Incident { count - 1 - behind } else { behind };
            let squared = self.squared_indices[number];
            let b = nonzero((squared - along * along).sqrt());
            let here = admittance(b, squared);
            let exponent = Complex64::i() * b * k0 / each as f64;
            slices.push(WaveSlice { layer: number / each, back: face(here, after), exponent });
            after = here;
        }
        FilmWave { slices, front: face(entry, after), passed: (exit.re / entry.re).max(0.0).sqrt() }
    }
}

/// A plane wave in a film, but for the thicknesses of the layers: what many thicknesses share.
#[derive(Clone, Debug)]
pub struct FilmWave {
    /// From the far face to the near one.
    slices: Vec<WaveSlice>,
    /// Reflection of the near face alone.
    front: Complex64,
    /// Scale of the transmitted amplitude.
    passed: f64,
}

/// A slice of a [`FilmWave`].
#[derive(Clone, Copy, Debug)]
struct WaveSlice {
    /// Number of its layer.
    layer: usize,
    /// Reflection of its far face alone.
    back: Complex64,
    /// Logarithm of what a passage leaves of the wave, per µm of the layer.
    exponent: Complex64,
}

impl FilmWave {
    /// Amplitudes at the faces, reflected and transmitted, for layers of these thicknesses in µm.
    pub fn amplitudes(&self, layers_um: &[f64]) -> [Complex64; 2] {
        let mut gamma = Complex64::ZERO;
        let mut through = Complex64::ONE;
        for slice in &self.slices {
            let (next, passed) = seen_through(slice.back, gamma);
            let phase = (slice.exponent * layers_um[slice.layer]).exp();
            through *= passed * phase;
            gamma = next * phase * phase;
        }
        let (reflected, passed) = seen_through(self.front, gamma);
        [reflected, self.passed * through * passed]
    }
}

/// A slice seen from in front: its admittance, what everything behind reflects at its front and at
/// its back, the wave that enters it for one in front, and what a passage leaves of the wave.
struct PassedSlice {
    admittance: Complex64,
    reflects: [Complex64; 2],
    enters: Complex64,
    phase: Complex64,
}

impl Film {
    /// Share of the power of a plane wave from the incident side that every layer absorbs, with the
    /// polar angle in vacuum. Nothing at grazing incidence.
    ///
    /// A wave f with the reflection Γ carries |f|² Re{(1 + Γ)* y (1 − Γ)}, y the admittance; what a
    /// layer keeps is the difference between its faces.
    pub fn absorbed(&self, polar_deg: f64, light: Polarisation) -> Vec<f64> {
        let each = self.squared_indices.len() / self.layers_um.len();
        let mut absorbed = vec![0.0; self.layers_um.len()];
        let (sin, cos) = polar_deg.to_radians().sin_cos();
        if cos < 1e-12 {
            return absorbed;
        }
        let k0 = TAU / self.wavelength_um;
        let admittance = |b: Complex64, squared: Complex64| match light {
            Polarisation::S => b,
            Polarisation::P => b / squared,
        };
        let exit = Complex64::from(self.index_out * self.index_out);
        let mut after = admittance((exit - sin * sin).sqrt(), exit);
        let mut gamma = Complex64::ZERO;
        let mut slices = Vec::new();
        for (slice, &squared) in self.squared_indices.iter().enumerate().rev() {
            let b = nonzero((squared - sin * sin).sqrt());
            let here = admittance(b, squared);
            let (back, _) = interface(here, after, gamma);
            let phase = (Complex64::i() * b * k0 * self.layers_um[slice / each] / each as f64).exp();
            gamma = back * phase * phase;
            slices.push(PassedSlice {
                admittance: here,
                reflects: [gamma, back],
                enters: Complex64::ZERO,
                phase,
            });
            after = here;
        }
        slices.reverse();
        let mut before = admittance(cos.into(), Complex64::ONE);
        let entry = before.re;
        for slice in &mut slices {
            slice.enters = interface(before, slice.admittance, slice.reflects[0]).1;
            before = slice.admittance;
        }
        let carried = |y: Complex64, gamma: Complex64| ((1.0 + gamma).conj() * y * (1.0 - gamma)).re;
        let mut wave = Complex64::ONE;
        for (number, slice) in slices.iter().enumerate() {
            wave *= slice.enters;
            let front = wave.norm_sqr() * carried(slice.admittance, slice.reflects[0]);
            wave *= slice.phase;
            let back = wave.norm_sqr() * carried(slice.admittance, slice.reflects[1]);
            absorbed[number / each] += (front - back) / entry;
        }
        absorbed
    }
}

/// Reflection of a face between admittances `a` and `b` alone.
fn face(a: Complex64, b: Complex64) -> Complex64 {
    (a - b) / (a + b)
}

/// Reflection at a face that alone reflects `r`, where everything behind reflects `gamma`, and the
/// transmitted amplitude, both at the face.
fn seen_through(r: Complex64, gamma: Complex64) -> (Complex64, Complex64) {
    let inverse = (1.0 + r * gamma).inv();
    ((r + gamma) * inverse, (1.0 + r) * inverse)
}

/// Reflection at a face between admittances `a` and `b`, as [`seen_through`] gives it.
fn interface(a: Complex64, b: Complex64, gamma: Complex64) -> (Complex64, Complex64) {
    seen_through(face(a, b), gamma)
}

/// Avoids zero at the critical angle of a slice.
fn nonzero(b: Complex64) -> Complex64 {
    if b.norm() < 1e-9 { Complex64::from(1e-9) } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Airy's formulas of one slab, with complex exponentials of both signs; independent of the
    /// recursion.
    fn airy(
        index: Complex64,
        h: f64,
        wavelength: f64,
        [from, to]: [f64; 2],
        deg: f64,
        p: bool,
    ) -> (f64, f64) {
        let along = from * deg.to_radians().sin();
        let a = Complex64::from(from * deg.to_radians().cos());
        let c = (Complex64::from(to * to) - along * along).sqrt();
        let b = (index * index - along * along).sqrt();
        let delta = b * h * TAU / wavelength;
        // H instead of E for p light: every normal index is divided by its index squared
        let over = |z: Complex64, n: Complex64| if p { z / (n * n) } else { z };
        let a = over(a, from.into());
        let b = over(b, index);
        let c = over(c, to.into());
        let cos = delta.cos();
        let sin = delta.sin();
        // characteristic matrix of the slab
        let m11 = cos;
        let m12 = -Complex64::i() * sin / b;
        let m21 = -Complex64::i() * b * sin;
        let u = m11 + m12 * c;
        let v = m21 + cos * c;
        let r = (a * u - v) / (a * u + v);
        let t = 2.0 * a / (a * u + v);
        (r.norm_sqr(), c.re / a.re * t.norm_sqr())
    }

    proptest! {
        /// Equal slices act as one slab, from both sides, whatever their number.
        #[test]
        fn equal_slices_are_the_slab_of_airy(
            n in 1.05..2.0f64, kappa in 0.0..0.3f64, h in 0.1..3.0f64, out in 1.0..1.7f64, deg in 0.0..88.0f64, count in 1..30usize,
        ) {
            let index = Complex64::new(n, kappa);
            let film = Film { squared_indices: vec![index * index; count], layers_um: vec![h], wavelength_um: 0.5, index_out: out };
            let sides = [(Side::Incident, [1.0, out]), (Side::Exit, [out, 1.0])];
            for ((side, ends), light) in sides.into_iter().flat_map(|s| Polarisation::BOTH.map(|l| (s, l))) {
                let want = airy(index, h, 0.5, ends, deg, light == Polarisation::P);
                let got = film.reflectance_transmittance(side, deg, light);
                // identity; 1/cos θ ≤ 30 and e^{κ k h} ≤ 1e5 in the matrix amplify rounding errors
                prop_assert!((want.0 - got.0).abs() < 1e-9 && (want.1 - got.1).abs() < 1e-9, "{want:?} {got:?}");
            }
        }

        /// What the layers of a stack absorb is what it neither reflects nor transmits, and a layer
        /// that does not absorb has none of it.
        #[test]
        fn layers_absorb_what_the_stack_keeps(
            n in proptest::collection::vec(1.0..2.0f64, 6), kappa in 0.0..0.3f64, deg in 0.0..88.0f64, out in 1.0..1.7f64,
        ) {
            let index = |(i, &n): (usize, &f64)| Complex64::new(n, if i < 2 { 0.0 } else { kappa * i as f64 }).powu(2);
            let squared_indices: Vec<Complex64> = n.iter().enumerate().map(index).collect();
            let film = Film { squared_indices, layers_um: vec![0.3, 0.5, 0.2], wavelength_um: 0.5, index_out: out };
            for light in Polarisation::BOTH {
                let (r, t) = film.reflectance_transmittance(Side::Incident, deg, light);
                let layers = film.absorbed(deg, light);
                // identity, amplified by 1/cos θ ≤ 30
                prop_assert!((layers.iter().sum::<f64>() - (1.0 - r - t)).abs() < 1e-9, "{layers:?} {r} {t}");
                prop_assert!(layers[0].abs() < 1e-9 && layers[1..].iter().all(|a| *a > -1e-9), "{layers:?}");
            }
        }

        /// A graded film is reciprocal, and lossless without absorption.
        #[test]
        fn graded_films_are_reciprocal(n in proptest::collection::vec(1.0..2.0f64, 1..12), deg in 0.0..88.0f64, out in 1.0..1.7f64) {
            let squared_indices: Vec<Complex64> = n.iter().map(|n| (n * n).into()).collect();
            let film = Film { squared_indices, layers_um: vec![0.7], wavelength_um: 0.5, index_out: out };
            let inside = (deg.to_radians().sin() / out).asin().to_degrees();
            for light in Polarisation::BOTH {
                let (r, t) = film.reflectance_transmittance(Side::Incident, deg, light);
                let (_, back) = film.reflectance_transmittance(Side::Exit, inside, light);
                prop_assert!((r + t - 1.0).abs() < 1e-10 && (t - back).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn squared_indices_mix_by_volume() {
        let profile = Profile { fractions: vec![vec![0.25, 0.5], vec![0.0, 0.0]], ..Profile::default() };
        let mixed = profile.squared_indices(&[2.0.into()], &[1.0.into(), 3.0.into()]);
        assert_eq!(mixed, [Complex64::from(0.25 + 4.5 + 1.0), Complex64::from(4.0)]);
    }
}
