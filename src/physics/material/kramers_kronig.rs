//! n from κ by the relation of Kramers and Kronig (time factor e^(−iωt)), with ω = 1/λ in µm⁻¹:
//!
//!   n(ω) = n∞ + c p(ω) + (2/π) P∫ ω′κ(ω′)/(ω′² − ω²) dω′,   p = (ωλ_p)²/(1 − (ωλ_p)²).
//!
//! κ is linear in ω between nodes, so that the integral is a sum of logarithms. Absorption in the
//! ultraviolet beyond the table is one pole: the constant n∞ it gives far to the red, and its slope
//! c p. One known n, the anchor, takes the place of n∞.

use std::f64::consts::PI;

/// Wavelength of the pole in the ultraviolet, µm, for tables that begin at twice it or later.
pub const POLE_UM: f64 = 0.2;
/// Strength c of the pole, and its standard error: silica, calcite and the listed polymers have
/// 0.06 to 0.18 (a test reads them from their records).
pub const POLE_STRENGTH: [f64; 2] = [0.1, 0.1];
/// κ beyond an end of the table falls linearly to 0 within the first share of the end's ω; that it
/// does so within the second instead is the standard error.
const TAIL: [f64; 2] = [0.15, 0.45];
/// Rows of a table: the sums take the square of their number.
pub const MOST_ROWS: usize = 4000;

/// What is known of n beside κ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnownIndex {
    /// n at one wavelength.
    At {
        /// Vacuum wavelength, µm, above that of the pole.
        wavelength_um: f64,
        /// n there.
        n: f64,
    },
    /// n far to the red of all absorption in the ultraviolet, without the bands of the table.
    Infinity(f64),
}

/// n at the rows of a table of κ, and how its independent errors change it there.
#[derive(Clone, Debug, PartialEq)]
pub struct RealPart {
    /// n, one per row.
    pub n: Vec<f64>,
    /// Change by one standard error of the absorption at shorter wavelengths than the table's.
    pub ultraviolet: Vec<f64>,
    /// What longer wavelengths add.
    pub infrared: Vec<f64>,
}

/// κ at increasing ω, linear in between and 0 at both ends.
struct KappaNodes {
    omega: Vec<f64>,
    kappa: Vec<f64>,
}

impl KappaNodes {
    /// The rows (λ in µm, κ), with tails that fall to 0 over these shares of ω at the long and at
    /// the short end of the wavelengths.
    fn new(rows: &[[f64; 2]], [long, short]: [f64; 2]) -> Self {
        let rising = rows.iter().rev().map(|[um, kappa]| [1.0 / um, *kappa]);
        let mut omega: Vec<f64> = rising.clone().map(|row| row[0]).collect();
        let mut kappa: Vec<f64> = rising.map(|row| row[1]).collect();
        let (first, last) = (omega[0], omega[omega.len() - 1]);
        omega.insert(0, first * (1.0 - long));
        omega.push(last * (1.0 + short));
        kappa.insert(0, 0.0);
        kappa.push(0.0);
        Self { omega, kappa }
    }

    /// (2/π) P∫ ω′κ/(ω′² − ω²) dω′.
    fn integral(&self, w: f64) -> f64 {
        let hats = self.omega.windows(3).zip(&self.kappa[1..]);
        hats.map(|(nodes, kappa)| kappa * transform([nodes[0], nodes[1], nodes[2]], w)).sum()
    }
}

/// n at rows (λ in µm rising, κ). At least two rows, at most [`MOST_ROWS`].
pub fn real_part(rows: &[[f64; 2]], known: KnownIndex) -> RealPart {
    let [near, far] = TAIL;
    let central = KappaNodes::new(rows, [near; 2]);
    let longer = KappaNodes::new(rows, [far, near]);
    let shorter = KappaNodes::new(rows, [near, far]);
    let pole_um = POLE_UM.min(0.5 * rows[0][0]);
    let [strength, error] = POLE_STRENGTH;
    let pole = |w: f64| (w * pole_um).powi(2) / (1.0 - (w * pole_um).powi(2));
    // [n, change by the ultraviolet, change by the infrared] up to constants
    let parts = |w: f64| {
        let middle = central.integral(w);
        let ultraviolet = error * pole(w) + shorter.integral(w) - middle;
        [middle + strength * pole(w), ultraviolet, longer.integral(w) - middle]
    };
    let constant = match known {
        KnownIndex::Infinity(n) => [n, 0.0, 0.0],
        KnownIndex::At { wavelength_um, n } => {
            let [own, ultraviolet, infrared] = parts(1.0 / wavelength_um);
            [n - own, -ultraviolet, -infrared]
        }
    };
    let all: Vec<[f64; 3]> = rows.iter().map(|[um, _]| parts(1.0 / um)).collect();
    let column = |i: usize| all.iter().map(|parts| parts[i] + constant[i]).collect();
    RealPart { n: column(0), ultraviolet: column(1), infrared: column(2) }
}

/// Change of n at the rows by a change of κ there, with n kept where it is known.
pub fn change(rows: &[[f64; 2]], known: KnownIndex) -> Vec<f64> {
    let nodes = KappaNodes::new(rows, [TAIL[0]; 2]);
    let kept = match known {
        KnownIndex::Infinity(_) => 0.0,
        KnownIndex::At { wavelength_um, .. } => nodes.integral(1.0 / wavelength_um),
    };
    rows.iter().map(|[um, _]| nodes.integral(1.0 / um) - kept).collect()
}

/// The function that is 1 at the middle node and linear to 0 at the others.
pub fn hat([a, b, c]: [f64; 3], w: f64) -> f64 {
    ((w - a) / (b - a)).min((c - w) / (c - b)).max(0.0)
}

/// (2/π) P∫ ω′h/(ω′² − ω²) dω′ of a hat: (1/π) ∫ h (1/(ω′ − ω) + 1/(ω′ + ω)) dω′.
pub fn transform(nodes: [f64; 3], w: f64) -> f64 {
    (over(nodes, w) + over(nodes, -w)) / PI
}

/// P∫ h(x)/(x − w) dx of a hat; the logarithms' poles cancel.
fn over([a, b, c]: [f64; 3], w: f64) -> f64 {
    let log = |x: f64| if (x - w).abs() < 1e-12 { 0.0 } else { (x - w).abs().ln() };
    let (rising, falling) = ((w - a) / (b - a), (c - w) / (c - b));
    rising * (log(b) - log(a)) + falling * (log(c) - log(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex64;

    /// Complex index of a Lorentz oscillator at an angular wavenumber.
    fn lorentz(w: f64) -> Complex64 {
        let [strength, centre, width] = [0.12_f64, 2.0, 0.25];
        let lower = Complex64::new(centre * centre - w * w, -width * w);
        (1.0 + strength * centre * centre / lower).sqrt()
    }

    /// Error of n from κ at knots of some distance.
    fn transform_error(distance: f64, w: f64) -> f64 {
        let knots: Vec<f64> = (0..(10.0 / distance) as i32).map(|k| distance * f64::from(k)).collect();
        let part = |x: &[f64]| lorentz(x[1]).im * transform([x[0], x[1], x[2]], w);
        (1.0 + knots.windows(3).map(part).sum::<f64>() - lorentz(w).re).abs()
    }

    /// κ of a Lorentz oscillator at the knots gives its n − n(∞), up to their distance squared.
    #[test]
    fn the_transform_of_a_lorentz_line_is_its_dispersion() {
        for w in [1.6, 1.9, 2.0, 2.2, 2.5] {
            let [coarse, fine] = [0.025, 0.0125].map(|distance| transform_error(distance, w));
            // h²κ″/12 at the line's peak, 0.44 high and 0.25 wide
            assert!(coarse < 3e-3, "{w}: {coarse:e}");
            // second order; κ beyond 10/µm, which is left out, gives 1.3e-5
            assert!(fine < coarse / 3.0 + 2e-5, "{w}: {coarse:e} {fine:e}");
        }
    }

    /// The anchor is met, whatever lies beyond the table, and no error moves it; with n∞ = 1 a band
    /// within the table has the n of its oscillator but for the pole, which is subtracted.
    #[test]
    fn the_anchor_is_kept_and_a_band_within_the_table_has_its_dispersion() {
        let rows: Vec<[f64; 2]> = (0..=800)
            .map(|k| {
                let um = 0.35 + 0.00125 * f64::from(k);
                [um, lorentz(1.0 / um).im]
            })
            .collect();
        let place = rows.iter().position(|row| row[0] == 0.7).unwrap();
        let found = real_part(&rows, KnownIndex::At { wavelength_um: 0.7, n: 1.65 });
        assert!((found.n[place] - 1.65).abs() < 1e-12);
        assert!(found.ultraviolet[place].abs().max(found.infrared[place].abs()) < 1e-12);
        assert!(found.ultraviolet[0] > 0.01, "{}", found.ultraviolet[0]);
        let free = real_part(&rows, KnownIndex::Infinity(1.0));
        for (row, n) in rows.iter().zip(&free.n).filter(|(row, _)| (0.4..1.0).contains(&row[0])) {
            let w = 1.0 / row[0];
            let pole = POLE_STRENGTH[0] * (w * 0.175).powi(2) / (1.0 - (w * 0.175).powi(2));
            // κ of 0.002 at the ends of the table, whose tails are guessed
            assert!((n - pole - lorentz(w).re).abs() < 4e-3, "{row:?}: {n}");
        }
        // linear in κ
        let double: Vec<[f64; 2]> = rows.iter().map(|[um, kappa]| [*um, 2.0 * kappa]).collect();
        let changed = change(&rows, KnownIndex::Infinity(1.0));
        let twice = real_part(&double, KnownIndex::Infinity(1.0));
        for ((a, b), by) in twice.n.iter().zip(&free.n).zip(changed) {
            assert!((a - b - by).abs() < 1e-12);
        }
    }

    /// What the pole's strength and error are taken from: the dispersion from 400 to 700 nm of the
    /// clear materials of the list that paints and inks are made of.
    #[cfg(feature = "serde")]
    #[test]
    fn clear_materials_have_poles_of_the_assumed_strength() {
        use crate::material::named::NamedMaterial;
        let pole = |um: f64| (POLE_UM / um).powi(2) / (1.0 - (POLE_UM / um).powi(2));
        for name in ["SiO2", "CaCO3", "PMMA", "PS"] {
            let index = NamedMaterial::find(name).unwrap().index();
            let strength = (index.index(0.4).re - index.index(0.7).re) / (pole(0.4) - pole(0.7));
            let [expected, error] = POLE_STRENGTH;
            assert!((strength - expected).abs() < error, "{name}: {strength}");
        }
    }
}
