//! Tables of n and κ with the errors of their rows.

use super::error::SpectrumError;
use crate::material::columns::{widest, widest_gap_nm};
use crate::material::kramers_kronig::{self, End, KnownIndex};
use crate::material::usable::Unusable;
use num_complex::Complex64;

/// Largest n and κ accepted: a lost decimal comma turns 1.55 into 155.
pub(super) const LARGEST: f64 = 10.0;
/// κ whose line over a gap changes n by Kramers and Kronig: a band of 100 nm and 0.001 by 1e-4.
const ABSORBS: f64 = 1e-3;
/// Smallest n of a table that is moved by its error.
pub(super) const LEAST_N: f64 = 0.01;

/// Errors of n at a cut end of a table that are worth a remark: twice what the ultraviolet beyond
/// tables leaves open.
const SAID_N_ERROR: f64 = 0.03;

/// An end of a table of κ that may cut an absorption band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutBand {
    /// Wavelength of the end, nm.
    pub wavelength_nm: f64,
    /// κ there.
    pub kappa: f64,
    /// Standard error of n there.
    pub n_error: f64,
}

/// One row of a tabulated spectrum: η = n + iκ at a vacuum wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sample {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Real part of the index, above 0.
    pub n: f64,
    /// Imaginary part, at least 0.
    pub kappa: f64,
}

/// Standard errors of one row of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RowError {
    /// Of n.
    pub n: f64,
    /// Of κ.
    pub kappa: f64,
    /// Correlation of both, −1 to 1.
    pub correlation: f64,
}

impl RowError {
    /// Refuses negative errors and correlations beyond ±1.
    pub(super) fn check(&self, row: &str) -> Result<(), String> {
        let allowed = "errors are standard errors of at least 0, correlations lie between -1 and 1";
        for (name, value, range) in [
            ("n_error", self.n, 0.0..=f64::MAX),
            ("kappa_error", self.kappa, 0.0..=f64::MAX),
            ("correlation", self.correlation, -1.0..=1.0),
        ] {
            if !range.contains(&value) {
                return Err(format!("{row}: {name} = {value}; {allowed}"));
            }
        }
        Ok(())
    }

    /// One of two independent changes of \[n, κ\] whose squares add up to the covariance of both:
    /// that of n, with what κ changes along with it, and the rest of κ.
    pub(super) fn along(&self, axis: ErrorAxis) -> [f64; 2] {
        match axis {
            ErrorAxis::N => [self.n, self.correlation * self.kappa],
            ErrorAxis::Kappa => [0.0, (1.0 - self.correlation.powi(2)).max(0.0).sqrt() * self.kappa],
            ErrorAxis::Change(_) => [0.0; 2],
        }
    }
}

/// Independent parts of the errors of n and κ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ErrorAxis {
    /// That of n, with what κ changes along with it.
    N,
    /// The rest of that of κ.
    Kappa,
    /// A change of all rows, by its number: what the relation of Kramers and Kronig cannot know.
    Change(usize),
}

/// A tabulated spectrum, increasing in wavelength; linear between its rows.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Table {
    pub(super) name: String,
    pub(super) samples: Vec<Sample>,
    /// Ranges without sound rows.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub(super) unusable: Vec<Unusable>,
    /// Errors of the rows; empty where the table has none.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub(super) errors: Vec<RowError>,
    /// Remarks of the file that n or κ is not determined.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub(super) undetermined: Vec<String>,
    /// Independent changes of \[n, κ\] of all rows by one standard error each.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    pub(super) changes: Vec<Vec<[f64; 2]>>,
}

impl Table {
    /// The table with n by the relation of Kramers and Kronig.
    pub(super) fn with_real_part(mut self, known: KnownIndex, n_error: f64) -> Result<Self, String> {
        if let Some(gap) = self.unusable.first() {
            let [from, to] = gap.between_nm;
            return Err(format!("{} between {from} and {to} nm: Kramers–Kronig needs every row", gap.reason));
        }
        if self.samples.len() > kramers_kronig::MOST_ROWS {
            let most = kramers_kronig::MOST_ROWS;
            return Err(format!("{} rows; Kramers–Kronig takes at most {most}", self.samples.len()));
        }
        let rows: Vec<[f64; 2]> = self.samples.iter().map(|s| [1e-3 * s.wavelength_nm, s.kappa]).collect();
        let real = kramers_kronig::real_part(&rows, known);
        for (sample, n) in self.samples.iter_mut().zip(&real.n) {
            sample.n = *n;
            let at = format!("n = {n:.3} at {} nm by Kramers–Kronig", sample.wavelength_nm);
            check_index("", sample.n, sample.kappa)
                .map_err(|_| format!("{at}; n must be above 0, at most 10: check kappa and the known n"))?;
        }
        let along_n = |of: Vec<f64>| of.into_iter().map(|n| [n, 0.0]).collect::<Vec<_>>();
        self.changes = vec![along_n(real.ultraviolet), along_n(real.infrared)];
        self.changes.push(vec![[n_error, 0.0]; rows.len()]);
        let kappa_errors = self.errors.iter().map(|error| error.kappa);
        let moved: Vec<[f64; 2]> =
            rows.iter().zip(kappa_errors).map(|(row, error)| [row[0], error]).collect();
        if !moved.is_empty() {
            let along = kramers_kronig::change(&moved, known).into_iter();
            self.changes.push(along.zip(&moved).map(|(n, row)| [n, row[1]]).collect());
        }
        self.errors.clear();
        self.changes.retain(|change| change.iter().any(|by| *by != [0.0; 2]));
        Ok(self)
    }

    /// The widest gap anywhere over which absorption is drawn linearly, nm, where n at all
    /// wavelengths depends on it.
    pub(super) fn gap_in_relation_nm(&self) -> Option<[f64; 2]> {
        let absorbing = |pair: &&[Sample]| pair.iter().any(|row| row.kappa > ABSORBS);
        let pairs = self.samples.windows(2).filter(absorbing);
        let gaps = pairs.filter_map(|pair| {
            let ends = [pair[0].wavelength_nm, pair[1].wavelength_nm];
            widest_gap_nm(&ends, ends)
        });
        // only n by the relation of Kramers and Kronig comes with changes of all rows
        if self.changes.is_empty() { None } else { widest(gaps) }
    }

    /// The ends of the table at which κ may be the flank of a band beyond it, where n at all
    /// wavelengths depends on it: wavelength nm, κ there, and the standard error of n there.
    pub(super) fn cut_bands(&self) -> Vec<CutBand> {
        // only n by the relation of Kramers and Kronig comes with changes of all rows
        let (Some(first), Some(last)) = (self.samples.first(), self.samples.last()) else {
            return Vec::new();
        };
        if self.changes.is_empty() {
            return Vec::new();
        }
        let rows: Vec<[f64; 2]> = self.samples.iter().map(|s| [1e-3 * s.wavelength_nm, s.kappa]).collect();
        let at = |sample: &Sample, row: usize| CutBand {
            wavelength_nm: sample.wavelength_nm,
            kappa: sample.kappa,
            n_error: self.changes.iter().map(|change| change[row][0].powi(2)).sum::<f64>().sqrt(),
        };
        let ends = [(End::Short, at(first, 0)), (End::Long, at(last, rows.len() - 1))];
        let cut = ends.into_iter().filter(|(end, _)| kramers_kronig::may_be_cut(&rows, *end));
        cut.map(|(_, band)| band).filter(|band| band.n_error > SAID_N_ERROR).collect()
    }

    /// Linear interpolation between the rows, n and κ separately.
    pub(super) fn interpolate(&self, nm: f64) -> Complex64 {
        let after = self.samples.partition_point(|s| s.wavelength_nm < nm).clamp(1, self.samples.len() - 1);
        let (a, b) = (self.samples[after - 1], self.samples[after]);
        let t = ((nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm)).clamp(0.0, 1.0);
        Complex64::new(a.n + t * (b.n - a.n), a.kappa + t * (b.kappa - a.kappa))
    }
}

pub(super) fn check_index(field: &str, n: f64, kappa: f64) -> Result<(), SpectrumError> {
    let bad = |column, value, allowed, remedy| {
        Err(SpectrumError::BadValue { field: format!("{field}: {column}"), value, allowed, remedy })
    };
    if !(n > 0.0 && n <= LARGEST) {
        return bad("n", n, "greater than 0, at most 10", "give the real part of the index, e.g. 1.4");
    }
    if !(0.0..=LARGEST).contains(&kappa) {
        let remedy = "a pigment's κ is below 1; absorption is positive here: exp(-iωt) convention";
        return bad("kappa", kappa, "of 0 to 10", remedy);
    }
    Ok(())
}
