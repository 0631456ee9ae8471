//! Fringes of weak layers: the coherent light between the two surfaces, which composing fluxes
//! treats as if it did not interfere with itself.
//!
//! The mean field goes through a layer of m slabs as through a film: with amplitudes r, t of the
//! front (r′, t′ from inside), r_b of the back, and P of all inner slabs,
//!
//! ```text
//! ρ = r′ P² r_b      T_c/T_i = (1 − |ρ|²)/|1 − ρ|²
//! R_c = |r + t t′ P² r_b/(1 − ρ)|²      R_i = |r|² + |t t′ P² r_b|²/(1 − |ρ|²)
//! ```
//!
//! where c is the film and i its incoherent composition. What the film takes from the field by
//! scattering and absorption, L = 1 − R − T, is shared as it was before: R → R + (R_c − R_i) + s_R
//! (L_c − L_i), with s_R the share of L_i that composing reflects. So R + T + A stays 1 exactly.

use super::flux::{Coherent, Hemisphere};
use super::ordinates::gauss;
use crate::numerics::interpolate::lagrange;
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// Directions of the mean over the hemisphere: fringes are narrower than the nodes' distance.
const DIRECTIONS: usize = 64;
/// Below this nothing is lost that could be shared.
const NOTHING: f64 = 1e-9;

/// Amplitudes of the slabs of a layer at one wavelength.
#[derive(Clone, Debug)]
pub struct CoherentFilm {
    /// Of the front slab, of an inner one, and of the back slab.
    pub slabs: [Coherent; 3],
    /// Media in front and within.
    pub media: [Hemisphere; 2],
    /// Thickness of a slab, µm.
    pub slab_um: f64,
    /// Vacuum wavelength, µm.
    pub wavelength_um: f64,
}

/// Cosines, and what is known there: slow amplitudes and shares of the loss.
type Known<'a> = (&'a [f64], &'a [Slow], &'a [[f64; 2]]);

/// One direction of one polarisation: what varies slowly with the angle.
type Slow = [Complex64; 6];

impl CoherentFilm {
    /// Corrections \[R, T\] of one polarisation at 0°, at `oblique` (its cosine in air) and of
    /// diffuse light, for a layer of `count` slabs whose composed \[R, T\] at 0° and at the nodes
    /// are `composed`.
    pub fn corrections(
        &self,
        count: usize,
        polarisation: usize,
        composed: &[[f64; 2]],
        oblique: f64,
    ) -> [[f64; 2]; 3] {
        let (points, slow) = self.solved(polarisation);
        let own = points.iter().zip(&slow).map(|(mu, slow)| self.film(count, *mu, slow)[1]);
        let shares: Vec<_> = own.zip(composed).map(|(own, all)| shares(own, *all)).collect();
        let at = |mu: f64| self.correction(count, mu, (&points, &slow, &shares));
        let mut diffuse = [0.0; 2];
        for &(mu, weight) in hemisphere() {
            let own = at(mu);
            (0..2).for_each(|k| diffuse[k] += weight * own[k]);
        }
        [at(1.0), at(oblique), diffuse]
    }

    /// The correction \[R, T\] at one angle, by its cosine in air, from what is known at some.
    fn correction(&self, count: usize, mu: f64, (points, slow, shares): Known) -> [f64; 2] {
        let weights = lagrange(points, mu);
        let [c, i] = self.film(count, mu, &between(points, slow, mu));
        let lost = (i[0] + i[1]) - (c[0] + c[1]);
        let share = |k: usize| -> f64 { weights.iter().zip(shares).map(|(w, s)| w * s[k]).sum() };
        [0, 1].map(|k| c[k] - i[k] + share(k) * lost)
    }

    /// Cosines of the directions that were solved, and the amplitudes there.
    fn solved(&self, polarisation: usize) -> (Vec<f64>, Vec<Slow>) {
        let ordinates = &self.media[0].ordinates;
        let nodes = (0..ordinates.escaping()).map(|i| ordinates.cosine(i));
        let points: Vec<f64> = [1.0].into_iter().chain(nodes).collect();
        let mut slow: Vec<Slow> = (0..).zip(&points).map(|(d, mu)| self.slow(d, polarisation, *mu)).collect();
        unwrap(&points, &mut slow);
        (points, slow)
    }

    /// Share of the light that is mirrored at an angle, by its cosine in the medium in front:
    /// \[with, without\] interference between the slabs.
    pub fn mirrored(&self, count: usize, polarisation: usize, cosine: f64) -> [f64; 2] {
        let (points, slow) = self.solved(polarisation);
        self.film(count, cosine, &between(&points, &slow, cosine)).map(|[r, _]| r)
    }

    /// What interference changes of the beam at 0° itself, \[R, T\].
    pub fn beam(&self, count: usize, polarisation: usize) -> [f64; 2] {
        let [c, i] = self.film(count, 1.0, &self.slow(0, polarisation, 1.0));
        [c[0] - i[0], c[1] - i[1]]
    }

    /// k_z of light with this cosine in air, in the even medium, 1/µm.
    fn phase_per_um(&self, cosine: f64) -> f64 {
        let [outer, inner] = [0, 1].map(|k| self.media[k].ordinates.index);
        let square = inner * inner - outer * outer * (1.0 - cosine * cosine);
        TAU / self.wavelength_um * square.max(0.0).sqrt()
    }

    /// r, t t′, r′ and r_b less the phase of the even medium; the logarithm of an inner slab's
    /// amplitude less it; √(T T_b).
    fn slow(&self, direction: usize, polarisation: usize, cosine: f64) -> Slow {
        let amplitude =
            |slab: usize, side: usize, lobe: usize| self.slabs[slab][side][direction][polarisation][lobe];
        let once = Complex64::from_polar(1.0, -self.phase_per_um(cosine) * self.slab_um);
        let twice = once * once;
        [
            amplitude(0, 0, 0),
            amplitude(0, 0, 1) * amplitude(0, 1, 1) * twice,
            amplitude(0, 1, 0) * twice,
            amplitude(2, 0, 0) * twice,
            (amplitude(1, 0, 1) * once).ln(),
            (amplitude(0, 0, 1).norm() * amplitude(2, 0, 1).norm()).into(),
        ]
    }

    /// \[R, T\] of the film, and of its incoherent composition.
    fn film(&self, count: usize, cosine: f64, slow: &Slow) -> [[f64; 2]; 2] {
        let [front, through, inside, behind, slab, power] = *slow;
        let inner = (count - 2) as f64;
        let depth = self.phase_per_um(cosine) * self.slab_um;
        let passed = (slab * (2.0 * inner)).exp();
        // both ways through the back slab and the inner ones, then through the front one
        let to_back = Complex64::from_polar(1.0, 2.0 * depth * (inner + 1.0)) * passed * behind;
        let front_depth = Complex64::from_polar(1.0, 2.0 * depth);
        let rho = inside * front_depth * to_back;
        let back = through * front_depth * to_back;
        let t = power.norm_sqr() * passed.norm() / (1.0 - rho.norm_sqr());
        let coherent = (front + back / (1.0 - rho)).norm_sqr();
        let incoherent = front.norm_sqr() + back.norm_sqr() / (1.0 - rho.norm_sqr());
        let ratio = (1.0 - rho.norm_sqr()) / (1.0 - rho).norm_sqr();
        [[coherent, t * ratio], [incoherent, t]]
    }
}

/// Nodes and weights of the mean over the hemisphere. Their search takes milliseconds, and every
/// number of a jackknife needs them.
fn hemisphere() -> &'static [(f64, f64)] {
    static RULE: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
    RULE.get_or_init(|| gauss(DIRECTIONS))
}

/// Takes jumps of 2π out of the logarithms along the cosines, which are interpolated.
fn unwrap(points: &[f64], slow: &mut [Slow]) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[b].total_cmp(&points[a]));
    for pair in order.windows(2) {
        let turns = (slow[pair[1]][4].im - slow[pair[0]][4].im) / TAU;
        slow[pair[1]][4].im -= TAU * turns.round();
    }
}

/// Shares of what the coherent field loses that composing reflects and transmits.
fn shares([r, t]: [f64; 2], composed: [f64; 2]) -> [f64; 2] {
    let lost = 1.0 - r - t;
    if lost < NOTHING { [0.0; 2] } else { [(composed[0] - r) / lost, (composed[1] - t) / lost] }
}

/// Amplitudes at a cosine between those known. No slab amplifies: beyond the flattest node, noise
/// of few realisations could, and many slabs would raise it to their power.
fn between(points: &[f64], slow: &[Slow], mu: f64) -> Slow {
    let weights = lagrange(points, mu);
    let mut all: Slow = std::array::from_fn(|k| weights.iter().zip(slow).map(|(w, s)| w * s[k]).sum());
    all[4].re = all[4].re.min(0.0);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::composed::ordinates::Ordinates;

    /// A clear film of four slabs of 1 µm in air, s-polarised: amplitudes of each are known.
    fn film(index: f64) -> CoherentFilm {
        let (slab_um, wavelength_um) = (1.0, 0.55);
        let medium = |index: f64| Hemisphere {
            ordinates: Ordinates::new(index, &[], [3, 3]),
            polarisations: 1,
            oblique_deg: None,
        };
        let media = [medium(1.0), medium(index)];
        let sines = || [0.0].into_iter().chain(media[0].ordinates.sines.iter().copied());
        let phase = |s: f64| {
            Complex64::from_polar(1.0, TAU / wavelength_um * (index * index - s * s).sqrt() * slab_um)
        };
        let fresnel = |s: f64| {
            let [outer, inner] = [(1.0 - s * s).sqrt(), (index * index - s * s).sqrt()];
            (outer - inner) / (outer + inner)
        };
        let through = |s: f64| (1.0 - fresnel(s).powi(2)).sqrt() * phase(s);
        let outside = sines().map(|s| vec![[fresnel(s).into(), through(s)]]).collect::<Vec<_>>();
        let inside =
            sines().map(|s| vec![[-fresnel(s) * phase(s) * phase(s), through(s)]]).collect::<Vec<_>>();
        let between = sines().map(|s| vec![[Complex64::ZERO, phase(s)]]).collect::<Vec<_>>();
        let slabs = [[outside.clone(), inside.clone()], [between.clone(), between], [inside, outside]];
        CoherentFilm { slabs, media, slab_um, wavelength_um }
    }

    /// A medium whose index is off by 0.17 is out of phase by −π − 0.3 to −π + 0.4 over 1 µm.
    #[test]
    fn logarithms_do_not_jump_between_angles() {
        let points = [1.0, 0.2, 0.9, 0.6];
        let phases = [-0.3, 0.4, -0.2, 0.1];
        let mut slow = phases.map(|by| {
            let mut slow: Slow = Default::default();
            slow[4] = Complex64::from_polar(0.5, by - 0.5 * TAU).ln();
            slow
        });
        unwrap(&points, &mut slow);
        let middle = between(&points, &slow, 0.75)[4].exp();
        let smooth = between(&points, &phases.map(|x| [x.into(); 6]), 0.75)[4].re;
        assert!((middle - Complex64::from_polar(0.5, smooth - 0.5 * TAU)).norm() < 1e-12, "{middle}");
    }

    /// Airy's film, and its incoherent composition 2R/(1 + R).
    #[test]
    fn a_clear_film_has_its_fringes() {
        let (index, film) = (1.5, film(1.5));
        let airy = |mu: f64| {
            let s2 = 1.0 - mu * mu;
            let inner = (index * index - s2).sqrt();
            let r = ((mu - inner) / (mu + inner)).powi(2);
            let half = (TAU / 0.55 * inner * 4.0).sin().powi(2);
            let coherent = 4.0 * r * half / ((1.0 - r).powi(2) + 4.0 * r * half);
            [coherent, 2.0 * r / (1.0 + r)]
        };
        let nodes = (0..3).map(|i| film.media[0].ordinates.cosine(i));
        let composed: Vec<[f64; 2]> =
            [1.0].into_iter().chain(nodes).map(|mu| [airy(mu)[1], 1.0 - airy(mu)[1]]).collect();
        let oblique = 45.0_f64.to_radians().cos();
        let [normal, slanted, diffuse] = film.corrections(4, 0, &composed, oblique);
        let want = |mu: f64| airy(mu)[0] - airy(mu)[1];
        let [with, without] = film.mirrored(4, 0, 1.0);
        assert!((with - airy(1.0)[0]).abs() < 1e-9 && (without - airy(1.0)[1]).abs() < 1e-9);
        assert!((normal[0] - want(1.0)).abs() < 1e-9 && (normal[0] + normal[1]).abs() < 1e-9);
        // Fresnel's amplitudes at the four nodes stand for those between
        assert!((slanted[0] - want(oblique)).abs() < 3e-3, "{slanted:?} {}", want(oblique));
        let mean: f64 = gauss(400).into_iter().map(|(mu, weight)| weight * want(mu)).sum();
        assert!((diffuse[0] - mean).abs() < 3e-3, "{diffuse:?} {mean}");
    }
}
