//! Index of refraction against wavelength: constants, built-in synthetic pigments, a user's table.

mod beside_kappa;
mod error;
mod index_file;
mod table;

pub use beside_kappa::{BesideKappa, Dilution};
pub use error::SpectrumError;
pub use table::{CutBand, ErrorAxis, RowError, Sample, Table};

use super::columns::widest_gap_nm;
#[cfg(feature = "serde")]
use super::dispersion::DataSource;
use super::dispersion::Dispersion;
#[cfg(feature = "serde")]
use super::kramers_kronig::KnownIndex;
use super::named::NamedIndex;
#[cfg(feature = "serde")]
use super::named::{MATERIALS, NamedMaterial, Ray};
use super::synthetic::{SYNTHETIC_RANGE_NM, Synthetic};
use super::usable::Unusable;
use crate::numerics::files::FileError;
use num_complex::Complex64;
use std::path::Path;
use table::{LARGEST, LEAST_N, check_index};

/// Re η of every pigment in P1 section 5, and of the built-in synthetic ones.
pub const PIGMENT_N: f64 = 1.4;

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
                widest_gap_nm(&rows, range_nm).or_else(|| table.gap_in_relation_nm())
            }
        }
    }

    /// The ends at which a table of κ may cut an absorption band on which n depends.
    pub fn cut_bands(&self) -> Vec<CutBand> {
        if let Self::Tabulated(table) = self { table.cut_bands() } else { Vec::new() }
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

#[cfg(test)]
mod spectra_tests;
