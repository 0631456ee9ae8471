//! Records of refractiveindex.info: tabulated indices and its nine dispersion formulas, read from
//! its YAML files (feature `serde`).
//!
//! Wavelengths λ are in µm, as in the files; C₁, C₂, … are a record's coefficients. Sums take pairs
//! of them: formulas 1, 2, 3, 5 and 6 have an odd number of coefficients, formula 4 has 9 + 2i,
//! formula 7 three to six, 8 four and 9 six. A record with another number is refused.
//!
//! | formula | |
//! |---|---|
//! | 1 | n² = 1 + C₁ + Σ C₂ᵢ λ²/(λ² − C₂ᵢ₊₁²) |
//! | 2 | n² = 1 + C₁ + Σ C₂ᵢ λ²/(λ² − C₂ᵢ₊₁) |
//! | 3 | n² = C₁ + Σ C₂ᵢ λ^C₂ᵢ₊₁ |
//! | 4 | n² = C₁ + C₂ λ^C₃/(λ² − C₄^C₅) + C₆ λ^C₇/(λ² − C₈^C₉) + Σ C₁₀₊₂ᵢ λ^C₁₁₊₂ᵢ |
//! | 5 | n = C₁ + Σ C₂ᵢ λ^C₂ᵢ₊₁ |
//! | 6 | n = 1 + C₁ + Σ C₂ᵢ/(C₂ᵢ₊₁ − λ⁻²) |
//! | 7 | n = C₁ + C₂/(λ² − 0.028) + C₃/(λ² − 0.028)² + C₄λ² + C₅λ⁴ + … |
//! | 8 | (n² − 1)/(n² + 2) = C₁ + C₂λ²/(λ² − C₃) + C₄λ² |
//! | 9 | n² = C₁ + C₂/(λ² − C₃) + C₄(λ − C₅)/((λ − C₅)² + C₆) |

#[cfg(feature = "serde")]
mod record;

#[cfg(feature = "serde")]
pub use record::RecordText;

use super::columns::{common, widest, widest_gap_nm};
use super::usable::Unusable;
use num_complex::Complex64;

/// Source of n or κ over a range of wavelengths.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) enum DataSource {
    /// Rows (λ in µm, value), increasing; linear between them.
    Table(Vec<[f64; 2]>),
    /// A formula by number, with its range in µm and its coefficients.
    Formula { number: u8, range_um: [f64; 2], coefficients: Vec<f64> },
}

/// n(λ) and κ(λ) of one record.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Dispersion {
    pub(super) name: String,
    pub(super) n: Option<DataSource>,
    pub(super) kappa: Option<DataSource>,
    /// Ranges without sound rows.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub(super) unusable: Vec<Unusable>,
    /// Records that continue this one beyond its range, without further ones of their own.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub(super) joined: Vec<Dispersion>,
}

impl Dispersion {
    /// The first range without sound rows that wavelengths between two, nm, would need.
    pub fn unusable(&self, range_nm: [f64; 2]) -> Option<&Unusable> {
        self.records().flat_map(|record| &record.unusable).find(|gap| gap.concerns(range_nm))
    }

    /// This record and those that continue it.
    fn records(&self) -> impl Iterator<Item = &Self> {
        [self].into_iter().chain(&self.joined)
    }

    /// The record continued by others, whose ranges it does not overlap.
    pub fn joined_with(self, joined: Vec<Self>) -> Self {
        Self { joined, ..self }
    }

    /// Pairs of wavelengths, nm, between which two records are joined: the last one of the first
    /// and the first one of the second, rising.
    pub fn seams_nm(&self) -> Vec<[f64; 2]> {
        let mut ranges: Vec<[f64; 2]> = self.records().map(Self::own_range_nm).collect();
        ranges.sort_by(|a, b| a[0].total_cmp(&b[0]));
        ranges.windows(2).map(|pair| [pair[0][1], pair[1][0]]).collect()
    }

    /// First and last wavelength at which every part is known, nm; other records fill the range
    /// between them.
    pub fn range_nm(&self) -> [f64; 2] {
        let hull = |[lo, hi]: [f64; 2], [a, b]: [f64; 2]| [f64::min(lo, a), f64::max(hi, b)];
        self.joined.iter().map(Self::own_range_nm).fold(self.own_range_nm(), hull)
    }

    /// The range of this record alone, nm.
    fn own_range_nm(&self) -> [f64; 2] {
        common([&self.n, &self.kappa].into_iter().flatten().map(DataSource::range_um)).map(|um| 1e3 * um)
    }

    /// The widest gap between rows within a range of wavelengths, nm, if wide enough to report.
    pub fn widest_gap_nm(&self, range_nm: [f64; 2]) -> Option<[f64; 2]> {
        let parts = self.records().flat_map(|record| [&record.n, &record.kappa]).flatten();
        widest(parts.filter_map(|part| widest_gap_nm(&part.rows_nm(), range_nm)))
    }

    /// Whether n is a formula's, which is transparent matter's.
    pub fn has_formula(&self) -> bool {
        matches!(self.n, Some(DataSource::Formula { .. }))
    }

    /// The record with a constant real part.
    pub fn with_n(self, n: f64) -> Self {
        let range_um = self.range_nm().map(|nm| 1e-3 * nm);
        let n = DataSource::Formula { number: 5, range_um, coefficients: vec![n] };
        Self { n: Some(n), ..self }
    }

    /// n + iκ at a wavelength in µm inside the range; NaN without n, transparent without k. Across
    /// a seam both are linear between the ends of the two records.
    pub fn index(&self, wavelength_um: f64) -> Complex64 {
        let nm = 1e3 * wavelength_um;
        let holds = |record: &&Self| {
            let [lo, hi] = record.own_range_nm();
            lo * (1.0 - 1e-12) <= nm && nm <= hi * (1.0 + 1e-12)
        };
        if self.joined.is_empty() || holds(&self) {
            return self.own_index(wavelength_um);
        }
        if let Some(record) = self.joined.iter().find(holds) {
            return record.own_index(wavelength_um);
        }
        // at the range's ends, which rounding may exceed, the seam is empty
        let ends = self
            .records()
            .flat_map(|record| record.own_range_nm().map(|end_nm| (end_nm, record.own_index(1e-3 * end_nm))));
        let (below, above): (Vec<_>, Vec<_>) = ends.partition(|(end_nm, _)| *end_nm <= nm);
        let below = below.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let above = above.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        match (below, above) {
            (Some((from, start)), Some((to, end))) => start + (end - start) * ((nm - from) / (to - from)),
            (Some((_, end)), None) | (None, Some((_, end))) => end,
            (None, None) => Complex64::new(f64::NAN, 0.0),
        }
    }

    /// n + iκ of this record alone.
    fn own_index(&self, wavelength_um: f64) -> Complex64 {
        let value = |part: &Option<DataSource>| Some(part.as_ref()?.value(wavelength_um));
        Complex64::new(value(&self.n).unwrap_or(f64::NAN), value(&self.kappa).unwrap_or(0.0))
    }
}

impl DataSource {
    fn range_um(&self) -> [f64; 2] {
        match self {
            Self::Table(rows) => [rows[0][0], rows[rows.len() - 1][0]],
            Self::Formula { range_um, .. } => *range_um,
        }
    }

    /// Wavelengths of a table, nm, without the rounding of the unit conversion; empty for a
    /// formula.
    fn rows_nm(&self) -> Vec<f64> {
        match self {
            Self::Table(rows) => rows.iter().map(|row| (1e9 * row[0]).round() / 1e6).collect(),
            Self::Formula { .. } => Vec::new(),
        }
    }

    fn value(&self, um: f64) -> f64 {
        match self {
            Self::Table(rows) => between(rows, um),
            Self::Formula { number, coefficients, .. } => evaluate(*number, coefficients, um),
        }
    }
}

fn between(rows: &[[f64; 2]], um: f64) -> f64 {
    let after = rows.partition_point(|row| row[0] < um).min(rows.len() - 1);
    let before = after.saturating_sub(1);
    let ([x0, y0], [x1, y1]) = (rows[before], rows[after]);
    if before == after { y0 } else { y0 + (um - x0).clamp(0.0, x1 - x0) / (x1 - x0) * (y1 - y0) }
}

/// n by the formula of that number; `c` is contiguous, so that pairs are (c\[1\], c\[2\]), (c\[3\],
/// c\[4\]) …
fn evaluate(number: u8, c: &[f64], um: f64) -> f64 {
    let at = |i: usize| c.get(i).copied().unwrap_or(0.0);
    let square = um * um;
    let sum = |from: usize, term: &dyn Fn(f64, f64) -> f64| {
        let pairs = c.get(from..).unwrap_or(&[]).chunks(2);
        pairs.map(|p| term(p[0], p.get(1).copied().unwrap_or(0.0))).sum::<f64>()
    };
    match number {
        1 => (1.0 + at(0) + sum(1, &|a, b| a * square / (square - b * b))).sqrt(),
        2 => (1.0 + at(0) + sum(1, &|a, b| a * square / (square - b))).sqrt(),
        3 => (at(0) + sum(1, &|a, b| a * um.powf(b))).sqrt(),
        4 => {
            let resonance = |i: usize| match at(i) {
                0.0 => 0.0,
                strength => strength * um.powf(at(i + 1)) / (square - at(i + 2).powf(at(i + 3))),
            };
            (at(0) + resonance(1) + resonance(5) + sum(9, &|a, b| a * um.powf(b))).sqrt()
        }
        5 => at(0) + sum(1, &|a, b| a * um.powf(b)),
        6 => 1.0 + at(0) + sum(1, &|a, b| a / (b - 1.0 / square)),
        7 => {
            let l = 1.0 / (square - 0.028);
            let powers = c.iter().skip(3).zip(1..).map(|(a, k)| a * square.powi(k));
            at(0) + at(1) * l + at(2) * l * l + powers.sum::<f64>()
        }
        8 => {
            let ratio = at(0) + at(1) * square / (square - at(2)) + at(3) * square;
            ((1.0 + 2.0 * ratio) / (1.0 - ratio)).sqrt()
        }
        _ => {
            let off = um - at(4);
            (at(0) + at(1) / (square - at(2)) + at(3) * off / (off * off + at(5))).sqrt()
        }
    }
}
