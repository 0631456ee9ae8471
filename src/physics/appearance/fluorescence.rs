//! Fluorescence of a paper: its brightener takes quanta of short waves and gives back fewer of
//! longer ones.
//!
//! The paper sends up S(λ) = ∫_{μ < λ} f(λ, μ) Φ(μ) dμ besides what it reflects. With bands,
//!
//! ```text
//! f(λ, μ) = y · a(μ) · e(λ) · μ/λ       ∫ e dλ = 1
//! ```
//!
//! a is the share of the quanta that the brightener absorbs, y the quanta emitted of those, e their
//! spectrum. A table holds Donaldson's matrix of the paper (Br. J. Appl. Phys. 5, 210, 1954):
//! radiance factor at λ per band of light at μ, so that f is the entry over the width of a band.

use super::paper::Albedo;
use super::viewing::Viewing;

/// Step of the wavelengths at which excitation is summed, nm.
pub const STEP_NM: f64 = 5.0;
/// Shortest wavelength of light that excites, nm: daylight has next to none below.
pub const SHORTEST_NM: f64 = 300.0;
/// Light below this is cut off in the condition M2, nm.
pub const CUT_NM: f64 = 420.0;

/// What a paper emits, of which light.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Fluorescence {
    /// One brightener.
    Bands {
        /// Rows of wavelength in nm and share of the quanta absorbed, 0 to 1; nothing beyond.
        excitation: Vec<[f64; 2]>,
        /// Rows of wavelength in nm and quanta emitted per nm, in any unit; nothing beyond.
        emission: Vec<[f64; 2]>,
        /// Quanta emitted per quantum absorbed, 0 to 1.
        quantum_yield: f64,
    },
    /// A bispectral table, without what is reflected.
    Table {
        /// Wavelengths of the light, nm, rising in equal steps.
        excitation_nm: Vec<f64>,
        /// Wavelengths emitted, nm, rising.
        emission_nm: Vec<f64>,
        /// Radiance factor \[emitted\]\[light\].
        factors: Vec<Vec<f64>>,
    },
}

impl Fluorescence {
    /// Share of the quanta of light of a wavelength that bands absorb; 0 for a table, which does
    /// not say.
    pub fn absorbed(&self, nm: f64) -> f64 {
        match self {
            Self::Bands { excitation, .. } => rows_at(excitation, nm),
            Self::Table { .. } => 0.0,
        }
    }

    /// What an albedo reflects of the light that bands leave it, at these wavelengths, at those of
    /// the sum over excitation and at its own between them.
    pub fn left_of(&self, albedo: &Albedo, wavelengths_nm: &[f64]) -> Albedo {
        let (Some(&from_nm), Some(&to_nm)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
            return albedo.clone();
        };
        let mut nm = summed_nm(from_nm, to_nm);
        nm.extend(wavelengths_nm);
        if let Albedo::Spectral(rows) = albedo {
            nm.extend(rows.iter().map(|row| row[0]).filter(|at| (from_nm..=to_nm).contains(at)));
        }
        nm.sort_by(f64::total_cmp);
        nm.dedup();
        let row = |nm: f64| Some([nm, albedo.at(nm).ok()? * (1.0 - self.absorbed(nm))]);
        Albedo::Spectral(nm.into_iter().filter_map(row).collect())
    }

    /// First and last wavelength of light that excites, nm; `None` if there is none.
    pub fn excited_nm(&self) -> Option<[f64; 2]> {
        let active: Vec<f64> = match self {
            Self::Bands { excitation, .. } => {
                let of = |i: usize| excitation[i][1] > 0.0;
                let near =
                    |i: usize| of(i) || (i > 0 && of(i - 1)) || (i + 1 < excitation.len() && of(i + 1));
                (0..excitation.len()).filter(|&i| near(i)).map(|i| excitation[i][0]).collect()
            }
            Self::Table { excitation_nm, factors, .. } => {
                let emits = |j: &usize| factors.iter().any(|row| row[*j] != 0.0);
                (0..excitation_nm.len()).filter(emits).map(|j| excitation_nm[j]).collect()
            }
        };
        Some([*active.first()?, *active.last()?])
    }

    /// F(λ_i, λ_j) for every pair of a rising list in steps of [`STEP_NM`] with j below i.
    pub fn matrix(&self, wavelengths_nm: &[f64]) -> Vec<Vec<f64>> {
        let kernel = self.kernel();
        let row = |i: usize| {
            let pair = |j: usize| STEP_NM * kernel(wavelengths_nm[i], wavelengths_nm[j]);
            (0..i).map(pair).collect()
        };
        (0..wavelengths_nm.len()).map(row).collect()
    }

    /// f(λ, μ), 1/nm.
    fn kernel(&self) -> Box<dyn Fn(f64, f64) -> f64 + '_> {
        match self {
            Self::Bands { excitation, emission, quantum_yield } => {
                let sum = area(emission);
                let scale = if sum > 0.0 { quantum_yield / sum } else { 0.0 };
                Box::new(move |to, from| {
                    scale * rows_at(emission, to) * rows_at(excitation, from) * from / to
                })
            }
            Self::Table { excitation_nm, emission_nm, factors } => {
                let width = excitation_nm[1] - excitation_nm[0];
                Box::new(move |to, from| {
                    let columns = |row: &Vec<f64>| -> Vec<[f64; 2]> {
                        excitation_nm.iter().copied().zip(row.iter().copied()).map(<[f64; 2]>::from).collect()
                    };
                    let along: Vec<[f64; 2]> = emission_nm
                        .iter()
                        .zip(factors)
                        .map(|(nm, row)| [*nm, rows_at(&columns(row), from)])
                        .collect();
                    rows_at(&along, to) / width
                })
            }
        }
    }

    /// Most quanta emitted and reflected of one that comes in, over all wavelengths of the light,
    /// where `albedo` is what the paper reflects: above 1 the paper makes light.
    pub fn most_quanta(&self, albedo: impl Fn(f64) -> f64, wavelengths_nm: &[f64]) -> f64 {
        let matrix = self.matrix(wavelengths_nm);
        let quanta = |j: usize| {
            let from = wavelengths_nm[j];
            let sum: f64 =
                (j + 1..wavelengths_nm.len()).map(|i| matrix[i][j] * wavelengths_nm[i] / from).sum();
            sum + albedo(from)
        };
        (0..wavelengths_nm.len()).map(quanta).fold(0.0, f64::max)
    }
}

/// Wavelengths of the sum over excitation from 300 nm, or the first of the light, to `last_nm`.
pub fn summed_nm(first_nm: f64, last_nm: f64) -> Vec<f64> {
    let first = (first_nm.max(SHORTEST_NM) / STEP_NM).ceil() as usize;
    let last = (last_nm / STEP_NM).floor() as usize;
    (first..=last).map(|k| STEP_NM * k as f64).collect()
}

/// Powers of a light at these wavelengths, each for the light about it.
pub fn summed_powers(light: &Viewing, summed_nm: &[f64]) -> Vec<f64> {
    summed_nm.iter().map(|&nm| light.mean_power([nm - STEP_NM, nm, nm + STEP_NM])).collect()
}

/// A value of rising rows, linear between them and nothing beyond.
pub fn rows_at(rows: &[[f64; 2]], nm: f64) -> f64 {
    let after = rows.partition_point(|row| row[0] < nm);
    match (after.checked_sub(1), rows.get(after)) {
        (_, Some([at, value])) if *at == nm => *value,
        (Some(below), Some([to, above])) => {
            let [from, value] = rows[below];
            value + (nm - from) / (to - from) * (above - value)
        }
        _ => 0.0,
    }
}

/// ∫ of rows that are linear in between.
fn area(rows: &[[f64; 2]]) -> f64 {
    rows.windows(2).map(|pair| 0.5 * (pair[1][0] - pair[0][0]) * (pair[0][1] + pair[1][1])).sum()
}

/// Share of the quanta that a usual brightener on bright paper absorbs: a band about 365 nm.
pub fn standard_excitation() -> Vec<[f64; 2]> {
    let row = |k: usize| {
        let nm = SHORTEST_NM + STEP_NM * k as f64;
        [nm, if nm < CUT_NM { 0.75 * (-0.5 * ((nm - 365.0) / 20.0).powi(2)).exp() } else { 0.0 }]
    };
    (0..=((CUT_NM - SHORTEST_NM) / STEP_NM) as usize).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brightener(quantum_yield: f64) -> Fluorescence {
        let emission = vec![[410.0, 0.0], [440.0, 1.0], [470.0, 0.4], [520.0, 0.0]];
        Fluorescence::Bands { excitation: standard_excitation(), emission, quantum_yield }
    }

    /// Of the quanta absorbed the yield comes out, but for what would be of shorter wavelength.
    /// *Planted*: μ/λ the other way round.
    #[test]
    fn quanta_out_are_the_yield_of_those_in() {
        let nm = summed_nm(300.0, 780.0);
        let matrix = brightener(0.6).matrix(&nm);
        let j = nm.iter().position(|&x| x == 365.0).unwrap();
        let quanta: f64 = (j + 1..nm.len()).map(|i| matrix[i][j] * nm[i] / nm[j]).sum();
        // the emission is linear between multiples of the step: the sum over them is exact
        assert!((quanta - 0.6 * 0.75).abs() < 1e-12, "{quanta}");
        let most = brightener(1.0).most_quanta(|_| 0.25, &nm);
        assert!((most - 1.0).abs() < 1e-12, "{most}");
    }

    /// A table of the bands at 10 nm says what the bands say.
    #[test]
    fn a_table_is_a_band_written_out() {
        let excitation_nm: Vec<f64> = (0..13).map(|k| 300.0 + 10.0 * f64::from(k)).collect();
        let emission_nm: Vec<f64> = (0..13).map(|k| 400.0 + 10.0 * f64::from(k)).collect();
        let bands = brightener(0.6);
        let kernel = bands.kernel();
        let row = |to: &f64| excitation_nm.iter().map(|from| 10.0 * kernel(*to, *from)).collect();
        let factors: Vec<Vec<f64>> = emission_nm.iter().map(row).collect();
        let table = Fluorescence::Table { excitation_nm, emission_nm, factors };
        let nm = summed_nm(300.0, 700.0);
        let one = bands.matrix(&nm);
        let other = table.matrix(&nm);
        let i = nm.iter().position(|x| *x == 440.0).unwrap();
        let j = nm.iter().position(|x| *x == 360.0).unwrap();
        assert!((one[i][j] / other[i][j] - 1.0).abs() < 1e-12);
        let sum = |m: &[Vec<f64>]| m.iter().flatten().sum::<f64>();
        assert!((sum(&one) / sum(&other) - 1.0).abs() < 0.02);
        assert_eq!(table.excited_nm(), Some([300.0, 420.0].map(|x: f64| x.min(410.0))));
    }
}
