//! Refractive indices: evaluates a number, a built-in spectrum or a table at every wavelength.

mod beside_kappa;
mod faults;
mod remarks;

pub(super) use remarks::bridged;

use super::Tabulation;
use crate::input::forms::{INDEX_KEYS, IndexWritten};
use crate::input::study::IndexSpectrum;
use crate::input::{Faults, keys_in_words, limits};
use crate::material::mixing::MixingRule;
use crate::material::named::Ray;
use crate::material::spectra::Spectrum;
use faults::{faulty_rows, no_rays, not_found, outside, unsound};
use num_complex::Complex64;
use std::path::Path;

impl IndexWritten {
    /// Whether it gives both rays of a crystal.
    pub(super) fn is_birefringent(&self) -> bool {
        self.birefringent == Some(true) || self.ordinary.is_some() || self.extraordinary.is_some()
    }

    /// The index at every wavelength, of a crystal that of the ordinary ray; and that of the
    /// extraordinary one.
    pub(super) fn rays(
        &self,
        field: &str,
        tables: &Tabulation,
        faults: &mut Faults,
    ) -> (IndexSpectrum, Option<IndexSpectrum>) {
        if !self.is_birefringent() {
            let one = Self { birefringent: None, ..self.clone() };
            return (one.tabulated(field, tables, faults), None);
        }
        let alone = Self { birefringent: None, ordinary: None, extraordinary: None, ..self.clone() };
        match (&self.ordinary, &self.extraordinary, &self.material) {
            (Some(ordinary), Some(extraordinary), _)
                if self.birefringent.is_none() && alone == Self::default() =>
            {
                let ordinary = ordinary.tabulated(&format!("{field}.ordinary"), tables, faults);
                let other = extraordinary.tabulated(&format!("{field}.extraordinary"), tables, faults);
                (ordinary, Some(other))
            }
            (None, None, Some(name)) if Self { material: None, ..alone.clone() } == Self::default() => {
                match (Spectrum::ray(name, Ray::Ordinary), Spectrum::ray(name, Ray::Extraordinary)) {
                    (Ok(ordinary), Ok(other)) => (
                        tabulated(ordinary, field, "material", tables, faults),
                        Some(tabulated(other, field, "material", tables, faults)),
                    ),
                    (Err(error), _) | (_, Err(error)) => {
                        faults.push(no_rays(field, name, &error));
                        (IndexSpectrum::vacuum(tables), None)
                    }
                }
            }
            _ => {
                let found = keys_in_words(self, INDEX_KEYS);
                let allowed =
                    "{ ordinary = …, extraordinary = … } alone, or { material = \"…\", birefringent = true }";
                let remedy = "write for example index = { ordinary = 2.61, extraordinary = 2.90 }";
                faults.add(field, found, allowed, remedy);
                (IndexSpectrum::vacuum(tables), None)
            }
        }
    }

    /// The index at every wavelength; 1 everywhere after an error, which makes the study invalid
    /// anyway.
    pub(super) fn tabulated(&self, field: &str, tables: &Tabulation, faults: &mut Faults) -> IndexSpectrum {
        if self.birefringent.is_some() || self.ordinary.is_some() || self.extraordinary.is_some() {
            let found = keys_in_words(self, INDEX_KEYS);
            let remedy = "give one index; for the mean of a crystal's rays { material = \"…\" }";
            faults.add(field, found, "one index: grains of pigments alone are birefringent", remedy);
            return IndexSpectrum::vacuum(tables);
        }
        let before = faults.0.len();
        let Some(spectrum) = self.spectrum(field, tables.folder, faults) else {
            return IndexSpectrum::vacuum(tables);
        };
        let key = if self.yaml.is_some() { "yaml" } else { "csv" };
        let tabulated = tabulated(spectrum, field, key, tables, faults);
        if faults.0.len() > before { IndexSpectrum::vacuum(tables) } else { tabulated }
    }

    /// The spectrum that is written; `None` after an error.
    fn spectrum(&self, field: &str, folder: &Path, faults: &mut Faults) -> Option<Spectrum> {
        let Self { n, k, built_in, material, csv, yaml, kramers_kronig, dilution, .. } = self;
        if kramers_kronig.is_some() || dilution.is_some() {
            return self.beside_kappa(field, folder, faults);
        }
        let (key, written, read) = match (built_in, material, csv, yaml, n, k) {
            (Some(name), None, None, None, None, None) => ("built_in", name, Spectrum::synthetic(name)),
            (None, Some(name), None, None, None, None) => ("material", name, Spectrum::material(name)),
            (None, None, Some(csv), None, n, None) => ("csv", csv, Spectrum::from_csv(folder.join(csv), *n)),
            (None, None, None, Some(yaml), n, None) => {
                ("yaml", yaml, Spectrum::from_yaml(folder.join(yaml), *n))
            }
            (None, None, None, None, Some(n), k) => return constant(field, *n, k.unwrap_or(0.0), faults),
            _ => {
                let allowed = "a number, { n = …, k = … }, { built_in = \"…\" }, { material = \"…\" }, { csv = \"…\" } or { yaml = \"…\" }, \
                               with n beside a file of k alone";
                let found = keys_in_words(self, INDEX_KEYS);
                faults.add(field, found, allowed, "write for example index = { n = 1.4, k = 0.1 }");
                return None;
            }
        };
        match read {
            Ok(spectrum) => Some(spectrum.without_folder()),
            Err(error) => {
                faults.push(not_found(&format!("{field}.{key}"), key, written, folder, &error));
                None
            }
        }
    }
}

impl IndexSpectrum {
    /// The index 1, after an error.
    fn vacuum(tables: &Tabulation) -> Self {
        Self {
            source: String::new(),
            index: vec![Complex64::ONE; tables.wavelengths_nm.len()],
            spectrum: Spectrum::VACUUM,
            dissolved: Vec::new(),
            mixing: MixingRule::default(),
        }
    }
}

/// A spectrum at every wavelength, unless it has none there; `key` is that of its file.
fn tabulated(
    spectrum: Spectrum,
    field: &str,
    key: &str,
    tables: &Tabulation,
    faults: &mut Faults,
) -> IndexSpectrum {
    let wavelengths_nm = tables.wavelengths_nm;
    let before = faults.0.len();
    let faulty = faulty_rows(&format!("{field}.{key}"), &spectrum, wavelengths_nm);
    faults.0.extend(faulty.or_else(|| outside(field, &spectrum, wavelengths_nm)));
    let values = wavelengths_nm.iter().map(|nm| spectrum.index(nm * 1e-3));
    let index = values.collect::<Result<Vec<_>, _>>().unwrap_or_default();
    faults.0.extend(unsound(field, &spectrum, &index, wavelengths_nm));
    // wavelengths that are not allowed are reported with the light
    if faults.0.len() > before || index.len() < wavelengths_nm.len() {
        return IndexSpectrum::vacuum(tables);
    }
    IndexSpectrum { source: source(&spectrum), index, spectrum, ..IndexSpectrum::vacuum(tables) }
}

/// Name of the spectrum; a transparent constant without its zero imaginary part.
fn source(spectrum: &Spectrum) -> String {
    match spectrum {
        Spectrum::Constant { n, kappa: 0.0 } => n.to_string(),
        other => other.name(),
    }
}

fn constant(field: &str, n: f64, k: f64, faults: &mut Faults) -> Option<Spectrum> {
    let before = faults.0.len();
    let remedy = "give the real part of the refractive index, 1.3 to 2.7 for pigments and binders";
    faults.number(&format!("{field}.n"), n, limits::INDEX, remedy);
    let remedy = "absorption is a positive k here (time factor exp(-iωt)): change the sign";
    faults.number(&format!("{field}.k"), k, limits::ABSORPTION, remedy);
    if faults.0.len() > before { None } else { Spectrum::constant(n, k).ok() }
}
