//! Index of refraction against wavelength: constants, built-in synthetic pigments, a user's table.

mod error;
mod index_file;

pub use error::SpectrumError;

use super::columns::widest_gap_nm;
#[cfg(feature = "serde")]
use super::dispersion::DataSource;
use super::dispersion::Dispersion;
use super::kramers_kronig::{self, KnownIndex};
#[cfg(feature = "serde")]
use super::named::{MATERIALS, NamedMaterial, Ray};
use super::named::{NamedIndex, SYNTHETIC_RANGE_NM, Synthetic};
use super::usable::Unusable;
use crate::numerics::files::FileError;
use num_complex::Complex64;
use std::f64::consts::{LN_10, PI};
use std::path::Path;

/// Re η of every pigment in P1 section 5, and of the built-in synthetic ones.
pub const PIGMENT_N: f64 = 1.4;
/// Largest n and κ accepted: a lost decimal comma turns 1.55 into 155.
const LARGEST: f64 = 10.0;
/// Smallest n of a table that is moved by its error.
const LEAST_N: f64 = 0.01;

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
    fn check(&self, row: &str) -> Result<(), String> {
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
    fn along(&self, axis: ErrorAxis) -> [f64; 2] {
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
    name: String,
    samples: Vec<Sample>,
    /// Ranges without sound rows.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    unusable: Vec<Unusable>,
    /// Errors of the rows; empty where the table has none.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    errors: Vec<RowError>,
    /// Remarks of the file that n or κ is not determined.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    undetermined: Vec<String>,
    /// Independent changes of \[n, κ\] of all rows by one standard error each.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Vec::is_empty"))]
    changes: Vec<Vec<[f64; 2]>>,
}

/// Index of refraction η(λ) = n + iκ of one material; κ > 0 absorbs (time factor e^{−iωt}).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Spectrum {
    /// A constant index for all wavelengths.
    Constant {
        /// Real part.
        n: f64,
        /// Imaginary part.
        kappa: f64,
    },
    /// A built-in synthetic pigment.
    Synthetic(Synthetic),
    /// A user's table.
    Tabulated(Table),
    /// A record of refractiveindex.info.
    Recorded(Dispersion),
    /// A material of the program's list.
    Named(NamedIndex),
}

impl Spectrum {
    /// The index 1 at every wavelength.
    pub const VACUUM: Self = Self::Constant { n: 1.0, kappa: 0.0 };

    /// A constant index.
    ///
    /// # Errors
    /// `n` not positive, `kappa` negative, or either not finite.
    pub fn constant(n: f64, kappa: f64) -> Result<Self, SpectrumError> {
        check_index("index", n, kappa)?;
        Ok(Self::Constant { n, kappa })
    }

    /// A built-in synthetic pigment by name: red, yellow, blue or green.
    pub fn synthetic(name: &str) -> Result<Self, SpectrumError> {
        let known = Synthetic::ALL.into_iter().find(|s| s.name() == name);
        known.map(Self::Synthetic).ok_or_else(|| SpectrumError::UnknownPigment { value: name.into() })
    }

    /// A material of the program's list by name; see [`MATERIALS`].
    ///
    /// # Errors
    /// A name that is not in the list.
    #[cfg(feature = "serde")]
    pub fn material(name: &str) -> Result<Self, SpectrumError> {
        let Some(material) = NamedMaterial::find(name) else {
            let known = MATERIALS.iter().map(|material| material.name).collect::<Vec<_>>().join(", ");
            return Err(SpectrumError::UnknownMaterial { value: name.into(), known });
        };
        let called = material.former.iter().find(|former| former.eq_ignore_ascii_case(name));
        Ok(Self::Named(material.index_called(called.unwrap_or(&material.name))))
    }

    /// One ray of a uniaxial crystal of the program's list.
    ///
    /// # Errors
    /// A name that is not in the list, or that of another material.
    #[cfg(feature = "serde")]
    pub fn ray(name: &str, ray: Ray) -> Result<Self, SpectrumError> {
        Self::material(name)?;
        let index = NamedMaterial::find(name).and_then(|material| material.ray(ray, material.name));
        index.map(Self::Named).ok_or_else(|| SpectrumError::NotUniaxial { value: name.into() })
    }

    /// Reads `wavelength_nm,kappa[,n]` (or `k`), with commas, semicolons or tabs, or the blocks
    /// `wl,n` and `wl,k` (µm) of refractiveindex.info; rows may fall, lines that start with `#` are
    /// remarks. A table without a column `n` needs `n` beside it. Columns `n_error`, `kappa_error`
    /// and `correlation` are the standard errors of both and their correlation.
    ///
    /// # Errors
    /// Unreadable files, unknown columns, fewer than two sound rows, n nowhere or twice. Rows with
    /// κ < 0, n ≤ 0, no number, or a wavelength that stands twice or out of order leave a range
    /// that cannot be used ([`Spectrum::unusable`]).
    pub fn from_csv(path: impl AsRef<Path>, n: Option<f64>) -> Result<Self, SpectrumError> {
        index_file::read(path.as_ref(), n)
    }

    /// Reads a table of κ, or of the absorbance of a dilution, and gives it n by the relation of
    /// Kramers and Kronig. What this cannot know, absorption beyond the table and the error of the
    /// known n, moves the table as its own errors do.
    ///
    /// # Errors
    /// As [`Spectrum::from_csv`]; also rows that cannot be used, since the relation needs all, too
    /// many of them, and n that falls to 0 or exceeds what is accepted.
    pub fn from_kappa(
        path: impl AsRef<Path>,
        beside: &BesideKappa,
        dilution: Option<&Dilution>,
    ) -> Result<Self, SpectrumError> {
        let path = path.as_ref();
        let n = if let BesideKappa::Constant(n) = beside { *n } else { PLACEHOLDER_N };
        let read = match dilution {
            Some(dilution) => index_file::read_absorbance(path, n, dilution)?,
            None => index_file::read(path, Some(n))?,
        };
        let BesideKappa::KramersKronig { known, n_error } = *beside else { return Ok(read) };
        let refused = |reason: String| SpectrumError::KramersKronig(FileError::new(path.display(), reason));
        let Self::Tabulated(table) = read else {
            let reason = "the table must be wavelength_nm,kappa in one block";
            return Err(refused(reason.to_owned()));
        };
        table.with_real_part(known, n_error).map(Self::Tabulated).map_err(refused)
    }

    /// Reads a record of refractiveindex.info (YAML); a record without n needs `n` beside it,
    /// without k the material is transparent.
    ///
    /// # Errors
    /// Unreadable files, files that are no such record, n nowhere or twice.
    #[cfg(feature = "serde")]
    pub fn from_yaml(path: impl AsRef<Path>, n: Option<f64>) -> Result<Self, SpectrumError> {
        let record = Dispersion::read(path.as_ref())?;
        Ok(Self::Recorded(match the_other(path.as_ref(), record.n.is_some(), n)? {
            Some(n) => record.with_n(n),
            None => record,
        }))
    }

    /// Reads κ of a record of refractiveindex.info (YAML) that has no n, and gives it n by the
    /// relation of Kramers and Kronig, as [`Spectrum::from_kappa`] does for tables.
    ///
    /// # Errors
    /// As [`Spectrum::from_yaml`] and [`Spectrum::from_kappa`]; a record with n, or with κ by a
    /// formula.
    #[cfg(feature = "serde")]
    pub fn from_recorded_kappa(
        path: impl AsRef<Path>,
        known: KnownIndex,
        n_error: f64,
    ) -> Result<Self, SpectrumError> {
        let path = path.as_ref();
        let record = Dispersion::read(path)?;
        let refused = |reason: String| SpectrumError::KramersKronig(FileError::new(path.display(), reason));
        if record.n.is_some() {
            return Err(refused("the record has n itself: leave kramers_kronig out".to_owned()));
        }
        let Some(DataSource::Table(rows)) = record.kappa else {
            return Err(refused("no tabulated k, from which n could follow".to_owned()));
        };
        let sample = |&[um, kappa]: &[f64; 2]| Sample { wavelength_nm: 1e3 * um, n: PLACEHOLDER_N, kappa };
        let table = Self::tabulated(&record.name, rows.iter().map(sample).collect())?;
        let Self::Tabulated(mut table) = table else { return Ok(table) };
        table.unusable = record.unusable;
        table.with_real_part(known, n_error).map(Self::Tabulated).map_err(refused)
    }

    /// Drops the folder from the name of a table: it is the same in any folder.
    pub fn without_folder(mut self) -> Self {
        if let Self::Tabulated(Table { name, .. }) | Self::Recorded(Dispersion { name, .. }) = &mut self
            && let Some(file) = Path::new(name.as_str()).file_name()
        {
            *name = file.to_string_lossy().into_owned();
        }
        self
    }

    /// A table given in memory, checked as [`Spectrum::from_csv`] checks a file.
    pub fn tabulated(name: &str, samples: Vec<Sample>) -> Result<Self, SpectrumError> {
        if samples.len() < 2 {
            return Err(SpectrumError::TooFewRows { name: name.into(), rows: samples.len() });
        }
        for (row, s) in samples.iter().enumerate() {
            check_index(&format!("{name}, row {}", row + 1), s.n, s.kappa)?;
            let before = if row == 0 { 0.0 } else { samples[row - 1].wavelength_nm };
            if !(s.wavelength_nm.is_finite() && s.wavelength_nm > before) {
                return Err(SpectrumError::BadValue {
                    field: format!("{name}, row {}: wavelength_nm", row + 1),
                    value: s.wavelength_nm,
                    allowed: "that increase from row to row, greater than 0",
                    remedy: "sort the table by wavelength and remove repeated rows",
                });
            }
        }
        Ok(Self::Tabulated(Table {
            name: name.into(),
            samples,
            unusable: Vec::new(),
            errors: Vec::new(),
            undetermined: Vec::new(),
            changes: Vec::new(),
        }))
    }

    /// The first range of a file without sound rows that wavelengths between two, nm, would need.
    pub fn unusable(&self, range_nm: [f64; 2]) -> Option<&Unusable> {
        match self {
            Self::Tabulated(table) => table.unusable.iter().find(|gap| gap.concerns(range_nm)),
            Self::Recorded(record) => record.unusable(range_nm),
            _ => None,
        }
    }

    /// What the file says of quantities that are not determined.
    pub fn undetermined(&self) -> &[String] {
        if let Self::Tabulated(table) = self { &table.undetermined } else { &[] }
    }

    /// The independent parts of the errors of a table.
    pub fn error_axes(&self) -> Vec<ErrorAxis> {
        let Self::Tabulated(table) = self else { return Vec::new() };
        let axes = [ErrorAxis::N, ErrorAxis::Kappa].into_iter();
        let axes = axes.chain((0..table.changes.len()).map(ErrorAxis::Change));
        axes.filter(|axis| self.moved(*axis, 1.0).is_some()).collect()
    }

    /// The table moved by `times` one of the independent parts of its errors, in every row at once;
    /// `None` without errors along it. No n falls to 0 and no κ below 0.
    pub fn moved(&self, axis: ErrorAxis, times: f64) -> Option<Self> {
        let Self::Tabulated(table) = self else { return None };
        let steps: Vec<[f64; 2]> = match axis {
            ErrorAxis::Change(number) => table.changes.get(number).cloned().unwrap_or_default(),
            _ => table.errors.iter().map(|error| error.along(axis)).collect(),
        };
        if steps.iter().all(|step| *step == [0.0; 2]) {
            return None;
        }
        let moved = table.samples.iter().zip(&steps).map(|(row, [n, kappa])| Sample {
            wavelength_nm: row.wavelength_nm,
            n: (row.n + times * n).clamp(LEAST_N, LARGEST),
            kappa: (row.kappa + times * kappa).clamp(0.0, LARGEST),
        });
        let samples = moved.collect();
        Some(Self::Tabulated(Table { samples, errors: Vec::new(), changes: Vec::new(), ..table.clone() }))
    }

    /// The index η at a vacuum wavelength in µm.
    ///
    /// # Errors
    /// The wavelength is not positive, or outside [`Spectrum::range_nm`].
    pub fn index(&self, wavelength_um: f64) -> Result<Complex64, SpectrumError> {
        let nm = wavelength_um * 1000.0;
        if !(nm.is_finite() && nm > 0.0) {
            return Err(SpectrumError::BadWavelength { value: nm });
        }
        // 0.38 µm · 1000 may differ from 380 by rounding
        if let Some([lo, hi]) = self.range_nm()
            && (nm < lo * (1.0 - 1e-12) || nm > hi * (1.0 + 1e-12))
        {
            return Err(SpectrumError::OutOfRange { name: self.name(), value: nm, lo, hi });
        }
        Ok(match self {
            Self::Constant { n, kappa } => Complex64::new(*n, *kappa),
            Self::Synthetic(pigment) => Complex64::new(PIGMENT_N, pigment.kappa(nm)),
            Self::Tabulated(table) => table.interpolate(nm),
            Self::Recorded(record) => record.index(wavelength_um),
            Self::Named(material) => material.index(wavelength_um),
        })
    }

    /// First and last wavelength of the spectrum's range, nm; `None` for a constant.
    pub fn range_nm(&self) -> Option<[f64; 2]> {
        match self {
            Self::Constant { .. } => None,
            Self::Synthetic(_) => Some(SYNTHETIC_RANGE_NM),
            Self::Recorded(record) => Some(record.range_nm()),
            Self::Named(material) => Some(material.range_nm()),
            Self::Tabulated(t) => Some([0, t.samples.len() - 1].map(|i| t.samples[i].wavelength_nm)),
        }
    }

    /// The widest gap between a file's rows within a range of wavelengths, nm, if wide enough to
    /// report.
    pub fn widest_gap_nm(&self, range_nm: [f64; 2]) -> Option<[f64; 2]> {
        match self {
            Self::Constant { .. } | Self::Synthetic(_) => None,
            Self::Recorded(record) => record.widest_gap_nm(range_nm),
            Self::Named(material) => material.widest_gap_nm(range_nm),
            Self::Tabulated(table) => {
                let rows: Vec<f64> = table.samples.iter().map(|sample| sample.wavelength_nm).collect();
                widest_gap_nm(&rows, range_nm)
            }
        }
    }

    /// Display name for messages and tables; synthetic spectra are marked as such.
    pub fn name(&self) -> String {
        match self {
            Self::Constant { n, kappa } => format!("{n} + {kappa}i"),
            Self::Synthetic(pigment) => format!("{} (synthetic)", pigment.name()),
            Self::Tabulated(table) => table.name.clone(),
            Self::Recorded(record) => record.name.clone(),
            Self::Named(material) => material.name.clone(),
        }
    }
}

/// The real part given beside a file that has none: exactly one of the two must give it.
fn the_other(path: &Path, in_file: bool, beside: Option<f64>) -> Result<Option<f64>, SpectrumError> {
    let reason = match (in_file, beside) {
        (false, None) => "no real part n; add n to the file, or give it beside the file, such as n = 1.4",
        (true, Some(_)) => "the real part n is given twice, in the file and beside it; keep one of them",
        _ => return Ok(beside),
    };
    Err(SpectrumError::RealPart(FileError::new(path.display(), reason)))
}

/// n until that of the relation takes its place.
const PLACEHOLDER_N: f64 = 1.0;

/// What is known of n beside a table of κ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BesideKappa {
    /// One n at all wavelengths.
    Constant(f64),
    /// n by the relation of Kramers and Kronig.
    KramersKronig {
        /// n at one wavelength, or far from all absorption.
        known: KnownIndex,
        /// Its standard error.
        n_error: f64,
    },
}

/// A dilution whose absorbance was measured: molecules, or grains far smaller than the wavelength,
/// that neither scatter nor change each other's light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dilution {
    /// Path of the light, mm.
    pub path_mm: f64,
    /// Mass of the pigment in a volume of the dilution, g/l.
    pub concentration_g_per_l: f64,
    /// Density of the pigment, g/cm³.
    pub density_g_per_cm3: f64,
}

impl Dilution {
    /// κ of the pigment by a decadic absorbance A at a wavelength: A ln 10 = 4πκ φ d/λ, with φ the
    /// pigment's share of the volume.
    pub fn kappa(&self, absorbance: f64, wavelength_nm: f64) -> f64 {
        let fraction = 1e-3 * self.concentration_g_per_l / self.density_g_per_cm3;
        absorbance * LN_10 * 1e-6 * wavelength_nm / (4.0 * PI * fraction * self.path_mm)
    }
}

impl Table {
    /// The table with n by the relation of Kramers and Kronig.
    fn with_real_part(mut self, known: KnownIndex, n_error: f64) -> Result<Self, String> {
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

    /// Linear interpolation between the rows, n and κ separately.
    fn interpolate(&self, nm: f64) -> Complex64 {
        let after = self.samples.partition_point(|s| s.wavelength_nm < nm).clamp(1, self.samples.len() - 1);
        let (a, b) = (self.samples[after - 1], self.samples[after]);
        let t = ((nm - a.wavelength_nm) / (b.wavelength_nm - a.wavelength_nm)).clamp(0.0, 1.0);
        Complex64::new(a.n + t * (b.n - a.n), a.kappa + t * (b.kappa - a.kappa))
    }
}

fn check_index(field: &str, n: f64, kappa: f64) -> Result<(), SpectrumError> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn file(text: &str) -> tempfile::NamedTempFile {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        file
    }

    #[test]
    fn a_table_is_linear_between_rows_and_exact_on_them() {
        let csv = file("# measured by me\nwavelength_nm, kappa, n\n400, 0.1, 1.4\n500, 0.3, 1.6\n");
        let spectrum = Spectrum::from_csv(csv.path(), None).unwrap();
        assert_eq!(spectrum.range_nm(), Some([400.0, 500.0]));
        for (um, n, kappa) in [(0.4, 1.4, 0.1), (0.425, 1.45, 0.15), (0.5, 1.6, 0.3)] {
            let eta = spectrum.index(um).unwrap();
            approx::assert_abs_diff_eq!(eta.re, n, epsilon = 1e-14);
            approx::assert_abs_diff_eq!(eta.im, kappa, epsilon = 1e-14);
        }
    }

    /// Tables of instruments, spreadsheets and the collection's own site.
    #[test]
    fn tables_of_other_programs_are_read() {
        let read = |text: &str| Spectrum::from_csv(file(text).path(), None).unwrap();
        let site = read("wl,n\n0.4,1.4\n0.6,1.6\n\nwl,k\n0.3,0.0\n0.5,0.2\n0.7,0.0\n");
        let eta = site.index(0.55).unwrap();
        assert!((eta.re - 1.55).abs() < 1e-12 && (eta.im - 0.15).abs() < 1e-12, "{eta}");
        assert_eq!(site.range_nm(), Some([400.0, 600.0]));
        let clear = read("wl,n\n0.4,1.4\n0.6,1.6\n").index(0.5).unwrap();
        assert!((clear - Complex64::new(1.5, 0.0)).norm() < 1e-12);
        let plain = read("wavelength_nm,n,kappa\n400,1.4,0.1\n600,1.6,0.3\n").index(0.5).unwrap();
        for text in [
            "sep=;\n# mine\nwavelength_nm;n;kappa\n# more\n600;1,6;0,3\n400;1,4;0,1\n",
            "wl,n,k\n0.6,1.6,0.3\n0.4,1.4,0.1\n",
            "wavelength (nm)\tk\tn\n400\t0.1\t1.4\n400\t0.1\t1.4\n600\t0.3\t1.6\n",
        ] {
            assert!((read(text).index(0.5).unwrap() - plain).norm() < 1e-12, "{text}");
        }
        let nm = Spectrum::from_csv(file("wl,n\n400,1.4\n600,1.6\n").path(), None).unwrap_err().to_string();
        assert!(nm.contains("these look like nm"), "{nm}");
    }

    /// A bad row in the infrared blocks nothing in the visible.
    #[test]
    fn faulty_rows_cost_their_own_range() {
        let csv = file("wavelength_nm,n,kappa\n400,1.5,0.1\n700,1.5,0.1\n2000,1.5,-0.1\n3000,1.5,0.1\n");
        let table = Spectrum::from_csv(csv.path(), None).unwrap();
        assert_eq!(table.unusable([400.0, 700.0]), None);
        assert!(table.unusable([690.0, 800.0]).unwrap().reason.contains("row 3: kappa = -0.1"));
    }

    /// The squares of the moves are the covariance of n and κ. *Planted*: the correlation left out,
    /// or its sign lost.
    #[test]
    fn errors_move_n_and_kappa_together() {
        let csv = file(
            "# n is not determined: two branches\nwavelength_nm,n,kappa,n_error,kappa_error,correlation\n\
             400,1.5,0.2,0.2,0.03,-0.97\n700,1.5,0.2,0.1,0.01,0.5\n",
        );
        let table = Spectrum::from_csv(csv.path(), None).unwrap();
        assert_eq!(table.undetermined(), ["n is not determined: two branches"]);
        for (um, n, kappa, correlation) in [(0.4, 0.2, 0.03, -0.97), (0.7, 0.1, 0.01, 0.5)] {
            let here = table.index(um).unwrap();
            let mut sums = [0.0; 3];
            for axis in [ErrorAxis::N, ErrorAxis::Kappa] {
                let step = table.moved(axis, 1.0).unwrap().index(um).unwrap() - here;
                let back = table.moved(axis, -1.0).unwrap().index(um).unwrap() - here;
                assert!((step + back).norm() < 1e-15);
                sums[0] += step.re * step.re;
                sums[1] += step.im * step.im;
                sums[2] += step.re * step.im;
            }
            for (sum, want) in sums.iter().zip([n * n, kappa * kappa, correlation * n * kappa]) {
                assert!((sum - want).abs() < 1e-15, "{sum} {want}");
            }
        }
        // no errors, or errors of zero
        let without = "wavelength_nm,n,kappa\n400,1.5,0.2\n700,1.5,0.2\n";
        let zero = "wavelength_nm,n,kappa,n_error,kappa_error\n400,1.5,0.2,0,0\n700,1.5,0.2,0,0\n";
        let [without, zero] = [without, zero].map(|text| {
            let table = Spectrum::from_csv(file(text).path(), None).unwrap();
            assert_eq!(table.moved(ErrorAxis::N, 1.0), None);
            serde_json::to_value(&table).unwrap()["tabulated"]["samples"].clone()
        });
        assert_eq!(without, zero);
        let bad = file("wavelength_nm,n,kappa,n_error\n400,1.5,0.2,-1\n700,1.5,0.2,0\n");
        let message = Spectrum::from_csv(bad.path(), None).unwrap_err().to_string();
        assert!(message.contains("n_error = -1"), "{message}");
    }

    /// Identity: a record of κ has the n of a table with its rows.
    #[test]
    fn recorded_kappa_has_the_n_of_its_table() {
        let known = KnownIndex::At { wavelength_um: 0.589, n: 1.65 };
        let csv = file("wavelength_nm,kappa\n400,0.1\n500,0.3\n600,0.05\n");
        let beside = BesideKappa::KramersKronig { known, n_error: 0.01 };
        let table = Spectrum::from_kappa(csv.path(), &beside, None).unwrap();
        let yaml = file(
            "DATA:\n  - type: tabulated k\n    data: |\n        0.4 0.1\n        0.5 0.3\n        0.6 0.05\n",
        );
        let record = Spectrum::from_recorded_kappa(yaml.path(), known, 0.01).unwrap();
        for um in [0.4, 0.47, 0.6] {
            assert!((record.index(um).unwrap() - table.index(um).unwrap()).norm() < 1e-12);
        }
        assert_eq!(record.error_axes().len(), table.error_axes().len());
        let both = "  - type: tabulated nk\n    data: |\n        0.4 1.5 0.1\n        0.6 1.5 0.2\n";
        let both = file(&format!("DATA:\n{both}"));
        let said = Spectrum::from_recorded_kappa(both.path(), known, 0.0).unwrap_err().to_string();
        assert!(said.contains("has n itself"), "{said}");
    }

    #[test]
    fn n_is_in_the_file_or_beside_it() {
        let csv = file("wavelength_nm,kappa\n400,0.1\n500,0.3\n");
        assert_eq!(Spectrum::from_csv(csv.path(), Some(1.5)).unwrap().index(0.45).unwrap().re, 1.5);
        let without = Spectrum::from_csv(csv.path(), None).unwrap_err().to_string();
        assert!(without.contains("no real part n"), "{without}");
        let both = file("wavelength_nm,kappa,n\n400,0.1,1.4\n500,0.3,1.4\n");
        assert!(Spectrum::from_csv(both.path(), Some(1.5)).unwrap_err().to_string().contains("twice"));
        let yaml = file("DATA:\n  - type: tabulated k\n    data: |\n        0.4 0.1\n        0.6 0.2\n");
        let record = Spectrum::from_yaml(yaml.path(), Some(1.6)).unwrap();
        assert_eq!((record.index(0.5).unwrap().re, record.range_nm()), (1.6, Some([400.0, 600.0])));
        assert!(Spectrum::from_yaml(yaml.path(), None).is_err());
    }

    #[test]
    fn bad_tables_and_wavelengths_are_refused_with_the_field() {
        let message = |text| {
            Spectrum::from_csv(file(text).path(), text.starts_with("wavelength_nm,kappa\n").then_some(1.4))
                .unwrap_err()
                .to_string()
        };
        assert!(message("wavelength_nm,kappa\n400,-0.1\n500,0.3\n").contains("row 1: kappa = -0.1"));
        assert!(message("wavelength_nm,kappa\n400,0.1\n500,12\n").contains("row 2: kappa = 12"));
        assert!(message("wavelength_nm,kappa\n500,0.1\n500,0.3\n").contains("two rows at 500 nm"));
        assert!(message("wavelength_nm,kappa\n500,NaN\n600,0.3\n").contains("kappa = NaN"));
        assert!(message("wavelength_nm,kappa,n\n500,1,0\n600,0.3,1\n").contains("n = 0"));
        assert!(
            message("wavelength_nm,kappa,n\n500,1,\n600,0.3,1\n").contains("line 2, column n: an empty cell")
        );
        assert!(message("wavelength_nm,kappa\n0.5,0.1\n0.6,0.3\n").contains("these look like µm"));
        assert!(message("wavelength_nm,kappa\n500,0.1\n").contains("1 rows"));
        assert!(message("lambda,kappa\n500,0.1\n600,0.1\n").contains("lambda"));
        assert!(
            Spectrum::from_csv("no/such/file.csv", None)
                .unwrap_err()
                .to_string()
                .contains("no/such/file.csv")
        );
        let yellow = Spectrum::synthetic("yellow").unwrap();
        assert!(yellow.index(0.30).unwrap_err().to_string().contains("380 to 780 nm"));
        assert!(yellow.index(f64::NAN).is_err() && yellow.index(0.0).is_err());
        assert!(yellow.index(0.38).is_ok() && yellow.index(0.78).is_ok());
        assert!(Spectrum::synthetic("mauve").is_err());
        assert!(Spectrum::constant(1.4, -0.1).is_err() && Spectrum::constant(0.0, 0.1).is_err());
    }

    const ANCHORED: BesideKappa =
        BesideKappa::KramersKronig { known: KnownIndex::At { wavelength_um: 0.589, n: 1.65 }, n_error: 0.01 };

    /// A file of κ has n by its relation to κ, the anchor's n at the anchor, and its unknowns as
    /// independent moves. *Planted*: the moves dropped; n of the placeholder kept.
    #[test]
    fn a_table_of_kappa_has_n_by_kramers_and_kronig() {
        let band = |nm: f64| 0.3 * (-((nm - 550.0) / 40.0).powi(2)).exp() + 0.01;
        let rows: String =
            (0..=76).map(|k| 400.0 + 5.0 * f64::from(k)).map(|nm| format!("{nm},{}\n", band(nm))).collect();
        let csv = file(&format!("wavelength_nm,kappa\n{rows}"));
        let spectrum = Spectrum::from_kappa(csv.path(), &ANCHORED, None).unwrap();
        let n = |nm: f64| spectrum.index(1e-3 * nm).unwrap().re;
        assert!((n(589.0) - 1.65).abs() < 2e-3, "{}", n(589.0));
        // anomalous within the band: n rises through it towards the red
        assert!(n(590.0) - n(510.0) > 0.1, "{} {}", n(510.0), n(590.0));
        let axes = spectrum.error_axes();
        assert_eq!(axes, (0..3).map(ErrorAxis::Change).collect::<Vec<_>>(), "ultraviolet, infrared, anchor");
        let moved = |axis: usize, nm: f64| {
            spectrum.moved(ErrorAxis::Change(axis), 1.0).unwrap().index(1e-3 * nm).unwrap().re - n(nm)
        };
        assert!(
            moved(0, 400.0) > 0.005 && moved(0, 589.0).abs() < 1e-3,
            "{} {}",
            moved(0, 400.0),
            moved(0, 589.0)
        );
        assert!((moved(2, 450.0) - 0.01).abs() < 1e-12);
        let with_errors =
            file(&format!("wavelength_nm,kappa,kappa_error\n{}", rows.replace('\n', ",0.02\n")));
        let spectrum = Spectrum::from_kappa(with_errors.path(), &ANCHORED, None).unwrap();
        let moved = spectrum.moved(ErrorAxis::Change(3), 1.0).unwrap().index(0.45).unwrap();
        assert!((moved.im - spectrum.index(0.45).unwrap().im - 0.02).abs() < 1e-12);
    }

    /// A = εcd of a dilution and κ = A λ ln 10/(4π φ d) are one number: 0.02 g/l of density 2 are a
    /// share of 1e-5; over 10 mm A = 1 at 500 nm is κ = 0.9162.
    #[test]
    fn the_absorbance_of_a_dilution_is_kappa() {
        let csv = file("wavelength_nm,absorbance\n500,1\n600,0.5\n700,-0.001\n");
        let dilution = Dilution { path_mm: 10.0, concentration_g_per_l: 0.02, density_g_per_cm3: 2.0 };
        let spectrum =
            Spectrum::from_kappa(csv.path(), &BesideKappa::Constant(1.6), Some(&dilution)).unwrap();
        let kappa = [0.5, 0.6, 0.7].map(|um| spectrum.index(um).unwrap().im);
        approx::assert_relative_eq!(kappa[0], 0.916_17, max_relative = 1e-4);
        approx::assert_relative_eq!(kappa[1], 0.6 * kappa[0], max_relative = 1e-12);
        assert_eq!(kappa[2], 0.0);
        let said = |beside: &BesideKappa, dilution: Option<&Dilution>, text: &str| {
            Spectrum::from_kappa(file(text).path(), beside, dilution).unwrap_err().to_string()
        };
        let absorbance = "wavelength_nm,absorbance\n500,1\n600,0.5\n";
        assert!(said(&ANCHORED, None, absorbance).contains("path, concentration and density"));
        let kappa = "wavelength_nm,kappa\n500,1\n600,0.5\n";
        assert!(said(&ANCHORED, Some(&dilution), kappa).contains("no column absorbance"));
        let twice = "wavelength_nm,kappa,n\n500,1,1.5\n600,0.5,1.5\n";
        assert!(said(&ANCHORED, None, twice).contains("given twice"));
        let gap = "wavelength_nm,kappa\n500,0.1\n550,-1\n600,0.1\n";
        assert!(said(&ANCHORED, None, gap).contains("needs every row"));
        let strong = "wavelength_nm,kappa\n400,0\n540,0.1\n580,9\n620,0.1\n700,0\n";
        assert!(said(&ANCHORED, None, strong).contains("n must be above 0"));
    }
}
