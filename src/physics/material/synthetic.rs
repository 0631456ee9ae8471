//! The built-in pigments.
//!
//! P1 fixes Re η = 1.4 for every pigment and shows Im η of red, yellow, blue and an artificial
//! green only as a plot (Fig. 5). The built-in pigments are therefore **synthetic**: smooth sums of
//! Gaussians made for this project (`validation/data/pigments.json`), not measured data. By Kramers
//! and Kronig such κ make n vary by 0.3 to 0.4 between 400 and 700 nm: 1.43 to 1.88 with n∞ = 1.60
//! in place of P1's 1.4. Measured spectra come from a CSV file.

/// The built-in synthetic pigments (κ(λ) of `validation/data/pigments.json`, Re η = 1.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Synthetic {
    /// Absorbs green.
    Red,
    /// Absorbs blue.
    Yellow,
    /// Absorbs red.
    Blue,
    /// P1's artificial green: absorbs blue and red alike.
    Green,
}

/// Range of the synthetic formulas: that of the CIE tables.
pub(super) const SYNTHETIC_RANGE_NM: [f64; 2] = [380.0, 780.0];

impl Synthetic {
    /// All synthetic pigments.
    pub const ALL: [Self; 4] = [Self::Red, Self::Yellow, Self::Blue, Self::Green];

    /// Name in study files: red, yellow, blue or green.
    pub fn name(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::Yellow => "yellow",
            Self::Blue => "blue",
            Self::Green => "green",
        }
    }

    /// κ(λ) = 0.30 (Σ a exp(−((λ − c)/s)²/2) + floor), λ in nm.
    pub fn kappa(self, wavelength_nm: f64) -> f64 {
        let (bands, floor): (&[[f64; 3]], f64) = match self {
            Self::Red => (&[[0.58, 516., 30.], [0.77, 549., 21.], [0.20, 360., 45.]], 0.015),
            Self::Yellow => (&[[0.55, 412., 34.], [0.74, 457., 23.]], 0.008),
            Self::Blue => (&[[0.80, 618., 36.], [1.00, 705., 40.], [0.18, 345., 45.]], 0.010),
            Self::Green => (&[[1.00, 430., 32.], [1.00, 655., 38.]], 0.008),
        };
        let gauss = |[a, c, s]: &[f64; 3]| a * (-((wavelength_nm - c) / s).powi(2) / 2.0).exp();
        0.30 * (bands.iter().map(gauss).sum::<f64>() + floor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn synthetic_pigments_are_those_of_the_reference_table() {
        let text = include_str!("../../../validation/data/pigments.json");
        let json: serde_json::Value = serde_json::from_str(text).unwrap();
        for pigment in Synthetic::ALL {
            let table = &json["pigments"][pigment.name()];
            let column = |key: &str| -> Vec<f64> { serde_json::from_value(table[key].clone()).unwrap() };
            for (nm, kappa) in column("l").into_iter().zip(column("kappa")) {
                // rounding: the table has 8 significant digits
                approx::assert_relative_eq!(pigment.kappa(nm), kappa, max_relative = 1e-7);
            }
        }
    }
}
