//! Refractive indices: evaluates a number, a built-in spectrum or a table at every wavelength.

use crate::input::fault::{Fault, Faults, keys_in_words};
use crate::input::forms::{INDEX_KEYS, IndexWritten};
use crate::input::limits;
use crate::input::study::IndexSpectrum;
use crate::material::mixing::MixingRule;
use crate::material::named::MATERIALS;
use crate::material::spectra::{Spectrum, SpectrumError};
use crate::material::synthetic::Synthetic;
use crate::numerics::allowed::shown;
use num_complex::Complex64;
use std::path::Path;

/// Wavelengths at which indices are needed, and where to find their tables.
#[derive(Clone, Copy)]
pub struct Tabulation<'a> {
    pub wavelengths_nm: &'a [f64],
    pub folder: &'a Path,
}

impl Tabulation<'_> {
    /// The index at every wavelength; 1 everywhere after an error, which makes the study invalid
    /// anyway.
    pub fn tabulate(self, field: &str, written: &IndexWritten, faults: &mut Faults) -> IndexSpectrum {
        let vacuum = || vacuum(self.wavelengths_nm.len());
        let Some(spectrum) = spectrum(field, written, self.folder, faults) else { return vacuum() };
        if let Some(fault) = outside(field, &spectrum, self.wavelengths_nm) {
            faults.push(fault);
            return vacuum();
        }
        let values = self.wavelengths_nm.iter().map(|nm| spectrum.index(nm * 1e-3));
        // invalid wavelengths are reported separately
        let Ok(index) = values.collect::<Result<Vec<_>, _>>() else { return vacuum() };
        if let Some(fault) = unsound(field, &index, self.wavelengths_nm) {
            faults.push(fault);
            return vacuum();
        }
        let (source, dissolved) = (source(&spectrum), Vec::new());
        IndexSpectrum { source, index, spectrum, dissolved, mixing: MixingRule::default() }
    }
}

/// The index 1 at this number of wavelengths.
fn vacuum(wavelengths: usize) -> IndexSpectrum {
    IndexSpectrum {
        source: String::new(),
        index: vec![Complex64::ONE; wavelengths],
        spectrum: Spectrum::VACUUM,
        dissolved: Vec::new(),
        mixing: MixingRule::default(),
    }
}

/// What to write for a file without n.
const BESIDE_CSV: &str = "write n beside the file where it has k alone: { csv = \"…\", n = 1.4 }";
const BESIDE_YAML: &str = "write n beside the file where it has k alone: { yaml = \"…\", n = 1.4 }";
/// Between 100 nm and 10 µm neither part of any medium's index exceeds this: aluminium reaches 25 +
/// 90i.
const LARGEST_PART: f64 = 100.0;

/// Refuses indices that no passive medium has: the formulas of records may have poles.
fn unsound(field: &str, index: &[Complex64], wavelengths_nm: &[f64]) -> Option<Fault> {
    let i = index
        .iter()
        .position(|eta| !(eta.re > 0.0 && eta.im >= 0.0 && eta.re.max(eta.im) <= LARGEST_PART))?;
    let [n, k] = [index[i].re, index[i].im].map(shown);
    let found = format!("n = {n}, k = {k} at {} nm", wavelengths_nm[i]);
    let remedy = "correct the file; absorption is a positive k here (time factor exp(-iωt))";
    Some(Fault::new(field, found, "n greater than 0 and k of at least 0, both at most 100", remedy))
}

/// Name of the spectrum; a transparent constant without its zero imaginary part.
fn source(spectrum: &Spectrum) -> String {
    match spectrum {
        Spectrum::Constant { n, kappa: 0.0 } => n.to_string(),
        // only the file name: the same table is the same material in any folder
        Spectrum::Tabulated(_) | Spectrum::Recorded(_) => Path::new(&spectrum.name())
            .file_name()
            .map_or_else(|| spectrum.name(), |name| name.to_string_lossy().into_owned()),
        other => other.name(),
    }
}

fn spectrum(field: &str, written: &IndexWritten, folder: &Path, faults: &mut Faults) -> Option<Spectrum> {
    let IndexWritten { n, k, built_in: pigment, material: known, csv, yaml } = written;
    match (pigment, known, csv, yaml, n, k) {
        (Some(name), None, None, None, None, None) => built_in(field, name, faults),
        (None, Some(name), None, None, None, None) => material(field, name, faults),
        (None, None, Some(csv), None, n, None) => from_csv(field, (&folder.join(csv), *n), faults),
        (None, None, None, Some(yaml), n, None) => from_yaml(field, (&folder.join(yaml), *n), faults),
        (None, None, None, None, Some(n), k) => constant(field, *n, k.unwrap_or(0.0), faults),
        _ => {
            faults.push(unclear(field, written));
            None
        }
    }
}

/// Reports that no form of an index is given, or more than one.
fn unclear(field: &str, written: &IndexWritten) -> Fault {
    let allowed = "a number, { n = …, k = … }, { built_in = \"…\" }, { material = \"…\" }, { csv = \"…\" } or { yaml = \"…\" }, \
                   with n beside a file of k alone";
    let found = keys_in_words(written, INDEX_KEYS);
    Fault::new(field, found, allowed, "write for example index = { n = 1.4, k = 0.1 }")
}

fn constant(field: &str, n: f64, k: f64, faults: &mut Faults) -> Option<Spectrum> {
    let before = faults.0.len();
    let remedy = "give the real part of the refractive index, 1.3 to 2.7 for pigments and binders";
    faults.number(&format!("{field}.n"), n, limits::INDEX, remedy);
    let remedy = "absorption is a positive k here (time factor exp(-iωt)): change the sign";
    faults.number(&format!("{field}.k"), k, limits::ABSORPTION, remedy);
    if faults.0.len() > before { None } else { Spectrum::constant(n, k).ok() }
}

fn built_in(field: &str, name: &str, faults: &mut Faults) -> Option<Spectrum> {
    let found = Spectrum::synthetic(name).ok();
    if found.is_none() {
        let names = Synthetic::ALL.map(Synthetic::name).join(", ");
        let remedy = "take one of these, or your own table with { csv = \"file.csv\" }";
        faults.add(format!("{field}.built_in"), format!("{name:?}"), names, remedy);
    }
    found
}

/// A measured material that comes with the program.
fn material(field: &str, name: &str, faults: &mut Faults) -> Option<Spectrum> {
    let found = Spectrum::material(name).ok();
    if found.is_none() {
        let names = MATERIALS.iter().map(|material| material.name).collect::<Vec<_>>().join(", ");
        let remedy = "take one of these, or your own table with { csv = \"file.csv\" }; organic pigments are in no open \
                      collection of indices";
        faults.add(format!("{field}.material"), format!("{name:?}"), names, remedy);
    }
    found
}

/// A table, with a separate n if it contains only κ.
fn from_csv(field: &str, (path, n): (&Path, Option<f64>), faults: &mut Faults) -> Option<Spectrum> {
    Spectrum::from_csv(path, n).map_err(|error| faults.push(csv_fault(field, path, &error))).ok()
}

/// A record, with a separate n if it contains only k.
fn from_yaml(field: &str, (path, n): (&Path, Option<f64>), faults: &mut Faults) -> Option<Spectrum> {
    Spectrum::from_yaml(path, n).map_err(|error| faults.push(yaml_fault(field, &error))).ok()
}

fn yaml_fault(field: &str, error: &SpectrumError) -> Fault {
    let allowed = "a record of refractiveindex.info: tabulated nk, n, k, or formula 1 to 9";
    let remedy = match error {
        SpectrumError::NoRealPart { .. } | SpectrumError::TwoRealParts { .. } => BESIDE_YAML,
        _ => "download the record's YAML file; its path is relative to the study file",
    };
    Fault::new(format!("{field}.yaml"), error.to_string(), allowed, remedy)
}

fn csv_fault(field: &str, path: &Path, error: &SpectrumError) -> Fault {
    let found = match error {
        SpectrumError::Unreadable(_)
        | SpectrumError::Header { .. }
        | SpectrumError::NoRealPart { .. }
        | SpectrumError::TwoRealParts { .. } => error.to_string(),
        other => format!("{} ({other})", path.display()),
    };
    let allowed = "a readable table wavelength_nm,kappa[,n] with rising wavelengths, kappa ≥ 0 and n > 0";
    let remedy = match error {
        SpectrumError::NoRealPart { .. } | SpectrumError::TwoRealParts { .. } => BESIDE_CSV,
        _ => "correct the table; its path is relative to the study file",
    };
    Fault::new(format!("{field}.csv"), found, allowed, remedy)
}

fn outside(field: &str, spectrum: &Spectrum, wavelengths_nm: &[f64]) -> Option<Fault> {
    let [low, high] = spectrum.range_nm()?;
    let slack = 1e-9;
    let nm = wavelengths_nm.iter().find(|&&nm| nm < low - slack || nm > high + slack)?;
    let allowed = format!("from {low} to {high} nm, where {} is known", spectrum.name());
    let remedy = "give a table that covers 400 to 700 nm; with [light] inside the table's range spectra lack nothing, but colours \
                  have wider error bars, and need 440 to 610 nm at least";
    Some(Fault::new(field, format!("no value at {nm} nm"), allowed, remedy))
}
