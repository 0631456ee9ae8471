//! The series of returns between a print and its paper, over wavelengths and kinds of area.
//!
//! A print consists of kinds of area k (ink, bare paper, …) with shares q_k. Light E(λ) enters
//! through them, the paper sends it up, and what their undersides send back meets the paper again:
//!
//! ```text
//! Φ_k(λ) = q_k T_k E + R_k U_k               on the paper below k
//! U_k(λ) = Σ_j P_kj (ρ Φ_j + S_j)            from the paper below k      P = (1 − w) 1 + w q 1ᵀ
//! S_k(λ) = Σ_{μ < λ} F(λ, μ) Φ_k(μ)          fluorescence, towards longer wavelengths alone
//! β(λ)   = Σ_k o_k U_k/E                     o_k = T_k(o)/n² towards the eye
//! ```
//!
//! w is the share of the light that the paper spreads over all areas alike: 0 is Neugebauer's
//! average of prints, 1 is Clapper and Yule (J. Opt. Soc. Am. 43, 600–603, 1953). With one kind and
//! without fluorescence it is [`returned`](super::paper::returned). F is triangular, so that one
//! pass over rising wavelengths solves all: Hersch, Appl. Opt. 47, 6710 (2008); Donaldson, Br. J.
//! Appl. Phys. 5, 210 (1954). Every wavelength has a closed form in Y = Σ_k (ρ Φ_k + S_k).

use super::paper::lost_in_a_round;

/// A kind of area at one wavelength, as light between it and the paper meets it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AreaOptics {
    /// Radiance factor of the layer itself, without paper.
    pub own: f64,
    /// T of the incident light.
    pub entering: f64,
    /// T towards the eye over n² of the paper's medium.
    pub leaving: f64,
    /// 1 − R̄_b of diffuse light from the paper: what passes or is absorbed.
    pub lost: f64,
}

impl AreaOptics {
    /// Between two neighbours in wavelength.
    fn between(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| a + share * (b - a);
        Self {
            own: mix(self.own, other.own),
            entering: mix(self.entering, other.entering),
            leaving: mix(self.leaving, other.leaving),
            lost: mix(self.lost, other.lost),
        }
    }

    /// The weighted sum of some of these, such as an interpolation.
    pub fn sum(all: &[Self], shares: &[(usize, f64)]) -> Self {
        let mut sum = Self { own: 0.0, entering: 0.0, leaving: 0.0, lost: 0.0 };
        for &(i, share) in shares {
            sum.own += share * all[i].own;
            sum.entering += share * all[i].entering;
            sum.leaving += share * all[i].leaving;
            sum.lost += share * all[i].lost;
        }
        sum
    }

    /// At another wavelength, linear between those of a rising list and constant beyond its ends.
    pub fn at(all: &[Self], wavelengths_nm: &[f64], nm: f64) -> Self {
        let after = wavelengths_nm.partition_point(|&x| x < nm);
        match (after.checked_sub(1), all.get(after)) {
            (None, Some(first)) => *first,
            (Some(below), Some(above)) => {
                let from = wavelengths_nm[below];
                all[below].between(above, (nm - from) / (wavelengths_nm[after] - from))
            }
            (Some(last), None) => all[last],
            (None, None) => Self::default(),
        }
    }
}

/// A layer against wavelength as light between it and its paper meets it, with its errors: what
/// prints take of layers that were solved elsewhere.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LayerOptics {
    /// Index of the medium between layer and paper.
    pub index_out: f64,
    /// Vacuum wavelengths, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// \[wavelength\]
    pub whole: Vec<AreaOptics>,
    /// \[realisation left out\]\[wavelength\]
    pub replicates: Vec<Vec<AreaOptics>>,
    /// \[cause\]\[wavelength\], each moved by one standard error of grid, solver or a table.
    pub moved: Vec<Vec<AreaOptics>>,
}

impl LayerOptics {
    /// The layer at other wavelengths within its range, linear in between.
    pub fn at(&self, wavelengths_nm: &[f64]) -> Self {
        let moved = |rows: &Vec<AreaOptics>| -> Vec<AreaOptics> {
            wavelengths_nm.iter().map(|&nm| AreaOptics::at(rows, &self.wavelengths_nm, nm)).collect()
        };
        Self {
            index_out: self.index_out,
            wavelengths_nm: wavelengths_nm.to_vec(),
            whole: moved(&self.whole),
            replicates: self.replicates.iter().map(moved).collect(),
            moved: self.moved.iter().map(moved).collect(),
        }
    }
}

/// The kinds of area of a print and the paper that they share.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaMix {
    /// q_k, which add up to 1.
    pub shares: Vec<f64>,
    /// w, the share of the light that is spread over all areas alike, 0 to 1.
    pub spread: f64,
}

impl AreaMix {
    /// One kind of area everywhere.
    pub fn whole() -> Self {
        Self { shares: vec![1.0], spread: 1.0 }
    }

    /// The factor Σ_k q_k own_k + o_k U_k/E at one wavelength, under light of power 1; `emitted` is
    /// S_k for that light, empty without fluorescence. NaN where light cannot leave.
    pub fn factor(&self, areas: &[AreaOptics], albedo: f64, emitted: &[f64]) -> f64 {
        let [_, up] = self.fluxes(areas, albedo, 1.0, emitted);
        let own: f64 = self.shares.iter().zip(areas).map(|(share, area)| share * area.own).sum();
        own + areas.iter().zip(up).map(|(area, up)| area.leaving * up).sum::<f64>()
    }

    /// \[Φ_k, U_k\] at one wavelength under light of this power.
    fn fluxes(&self, areas: &[AreaOptics], albedo: f64, power: f64, emitted: &[f64]) -> [Vec<f64>; 2] {
        let kept = 1.0 - self.spread;
        let mut given = 0.0;
        let mut shared = 0.0;
        for (k, (area, share)) in areas.iter().zip(&self.shares).enumerate() {
            let back = 1.0 - area.lost;
            let emitted = emitted.get(k).copied().unwrap_or(0.0);
            // 1 − ρ R_k (1 − w), written so that rounding leaves a perfect white its light
            let divisor = lost_in_a_round(albedo, area.lost + self.spread * back);
            given += (albedo * share * area.entering * power + emitted) / divisor;
            shared += albedo * self.spread * share * back / divisor;
        }
        let sum = given / (1.0 - shared);
        let mut below = Vec::with_capacity(areas.len());
        let mut up = Vec::with_capacity(areas.len());
        for (k, (area, share)) in areas.iter().zip(&self.shares).enumerate() {
            let back = 1.0 - area.lost;
            let emitted = emitted.get(k).copied().unwrap_or(0.0);
            let divisor = lost_in_a_round(albedo, area.lost + self.spread * back);
            let lit = albedo * share * area.entering * power + emitted;
            let own = (lit + albedo * back * self.spread * share * sum) / divisor;
            let rising = kept * own + self.spread * share * sum;
            up.push(rising);
            below.push(share * area.entering * power + back * rising);
        }
        [below, up]
    }

    /// S_k at every wavelength of a rising list. `areas` are those of each wavelength, `albedos` ρ,
    /// `light` the power E, and `matrix[i][j]` is F(λ_i, λ_j) for j below i.
    pub fn emitted(
        &self,
        areas: &[Vec<AreaOptics>],
        albedos: &[f64],
        light: &[f64],
        matrix: &[Vec<f64>],
    ) -> Vec<Vec<f64>> {
        let mut below: Vec<Vec<f64>> = Vec::new();
        let mut all = Vec::new();
        for (i, row) in matrix.iter().enumerate() {
            let mut emitted = vec![0.0; self.shares.len()];
            for (factor, fluxes) in row.iter().zip(&below).filter(|(factor, _)| **factor != 0.0) {
                emitted.iter_mut().zip(fluxes).for_each(|(sum, flux)| *sum += factor * flux);
            }
            let [lit, _] = self.fluxes(&areas[i], albedos[i], light[i], &emitted);
            below.push(lit);
            all.push(emitted);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::paper::returned;
    use proptest::prelude::*;

    const INK: AreaOptics = AreaOptics { own: 0.01, entering: 0.5, leaving: 0.3, lost: 0.55 };
    const BARE: AreaOptics = AreaOptics { own: 0.0, entering: 0.95, leaving: 0.43, lost: 0.4 };

    proptest! {
        /// Full coverage is the scalar series, whatever the spread. *Planted*: w in the wrong
        /// place.
        #[test]
        fn one_kind_of_area_is_the_scalar_series(rho in 0.0..1.0f64, t in 0.05..1.0f64, a in 0.0..0.3f64, spread in 0.0..=1.0f64) {
            let area = AreaOptics { own: 0.0, entering: t, leaving: 1.0, lost: t + a };
            let mix = AreaMix { shares: vec![1.0, 0.0], spread };
            let got = mix.factor(&[area, BARE], rho, &[]);
            let want = t * returned(rho, t, a, 1.0).unwrap();
            // identity: rounding, which the series of a bright paper amplifies
            let lost = 1.0 - rho * (1.0 - t - a);
            prop_assert!((got - want).abs() < 1e-15 * (1.0 + want / lost), "{got} {want}");
        }

        /// What is neither reflected nor lost adds up: a white paper under areas that absorb
        /// nothing returns all light.
        #[test]
        fn nothing_is_lost_on_a_perfect_white(share in 0.0..1.0f64, t in 0.1..1.0f64, spread in 0.0..=1.0f64) {
            // under diffuse light T̄ enters and T̄ of what rises leaves: radiance by flux
            let area = |t: f64| AreaOptics { own: 1.0 - t, entering: t, leaving: t, lost: t };
            let mix = AreaMix { shares: vec![share, 1.0 - share], spread };
            prop_assert!((mix.factor(&[area(t), area(1.0)], 1.0, &[]) - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn limits_are_neugebauer_and_clapper_yule() {
        let a = 0.37;
        let rho = 0.9;
        let alone = |area: &AreaOptics| {
            area.own + area.entering * area.leaving * rho / (1.0 - rho * (1.0 - area.lost))
        };
        let at = |spread: f64| AreaMix { shares: vec![a, 1.0 - a], spread }.factor(&[INK, BARE], rho, &[]);
        let neugebauer = a * alone(&INK) + (1.0 - a) * alone(&BARE);
        let mean = |f: fn(&AreaOptics) -> f64| a * f(&INK) + (1.0 - a) * f(&BARE);
        let clapper_yule = mean(|x| x.own)
            + rho * mean(|x| x.entering) * mean(|x| x.leaving) / (1.0 - rho * mean(|x| 1.0 - x.lost));
        assert!((at(0.0) - neugebauer).abs() < 1e-14 && (at(1.0) - clapper_yule).abs() < 1e-14);
    }

    /// Two wavelengths in closed form: the longer one holds F Φ of the shorter one besides its own.
    #[test]
    fn fluorescence_of_two_wavelengths_has_a_closed_form() {
        let rho = [0.3, 0.9];
        let f = 0.2;
        let mix = AreaMix::whole();
        let matrix = vec![vec![], vec![f]];
        let emitted = mix.emitted(&[vec![INK], vec![INK]], &rho, &[2.0, 1.0], &matrix);
        let back = 1.0 - INK.lost;
        let below = 2.0 * INK.entering / (1.0 - rho[0] * back);
        assert!((emitted[1][0] - f * below).abs() < 1e-15);
        let want = INK.own + INK.leaving * (rho[1] * INK.entering + f * below) / (1.0 - rho[1] * back);
        assert!((mix.factor(&[INK], rho[1], &emitted[1]) - want).abs() < 1e-15);
    }
}
