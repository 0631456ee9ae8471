//! Refractive indices: evaluates a number, a built-in spectrum or a table at every wavelength, and
//! warns of files whose rows are far apart, which may be intended.

use super::Tabulation;
use crate::input::forms::{DilutionWritten, INDEX_KEYS, IndexWritten, KramersKronigWritten};
use crate::input::study::{IndexSpectrum, Study};
use crate::input::{Fault, Faults, keys_in_words, limits};
use crate::material::columns::widest_gap_nm;
use crate::material::kramers_kronig::KnownIndex;
use crate::material::mixing::MixingRule;
use crate::material::named::{MATERIALS, NamedMaterial, Ray, Synthetic};
use crate::material::spectra::{BesideKappa, Dilution, Spectrum, SpectrumError};
use crate::numerics::allowed::shown;
use num_complex::Complex64;
use std::collections::BTreeSet;
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
                let of = |ray: Ray| Spectrum::ray(name, ray);
                match (of(Ray::Ordinary), of(Ray::Extraordinary)) {
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
        let (key, written, found) = match (built_in, material, csv, yaml, n, k) {
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
        match found {
            Ok(spectrum) => Some(spectrum.without_folder()),
            Err(error) => {
                faults.push(not_found(&format!("{field}.{key}"), key, written, folder, &error));
                None
            }
        }
    }
}

impl IndexWritten {
    /// The spectrum of a file of κ with a relation for n, or of the absorbance of a dilution.
    fn beside_kappa(&self, field: &str, folder: &Path, faults: &mut Faults) -> Option<Spectrum> {
        let (key, written) = match (&self.csv, &self.yaml, self.k, &self.built_in, &self.material) {
            (Some(csv), None, None, None, None) => ("csv", csv),
            (None, Some(yaml), None, None, None) if self.dilution.is_none() => ("yaml", yaml),
            _ => {
                let found = keys_in_words(self, INDEX_KEYS);
                let allowed = "kramers_kronig beside csv or yaml alone, and dilution beside csv alone: the file gives κ, or the absorbance";
                let remedy =
                    "write for example { csv = \"kappa.csv\", kramers_kronig = { n_nm = 589, n = 1.65 } }";
                faults.add(field, found, allowed, remedy);
                return None;
            }
        };
        let before = faults.0.len();
        let beside = match (self.n, &self.kramers_kronig) {
            (Some(n), None) => {
                constant(field, n, 0.0, faults);
                Some(BesideKappa::Constant(n))
            }
            (None, Some(written)) => written.known(&format!("{field}.kramers_kronig"), faults),
            (n, _) => {
                let found = if n.is_some() { "n and kramers_kronig" } else { "dilution without n" };
                let remedy =
                    "keep n for one value at all wavelengths, or kramers_kronig for n by its relation to κ";
                faults.add(field, found, "either of them beside the file", remedy);
                None
            }
        };
        let dilution =
            self.dilution.as_ref().map(|written| written.checked(&format!("{field}.dilution"), faults));
        if faults.0.len() > before {
            return None;
        }
        let path = folder.join(written);
        let read = match (key, beside?) {
            ("yaml", BesideKappa::KramersKronig { known, n_error }) => {
                Spectrum::from_recorded_kappa(path, known, n_error)
            }
            (_, beside) => Spectrum::from_kappa(path, &beside, dilution.as_ref()),
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

impl KramersKronigWritten {
    /// What is known of n; `None` after an error.
    fn known(&self, field: &str, faults: &mut Faults) -> Option<BesideKappa> {
        let remedy = "give n where it was measured, such as n_nm = 589 and n = 1.65 by immersion";
        let before = faults.0.len();
        for (key, value, range) in [
            ("n", self.n, limits::INDEX),
            ("n_infinity", self.n_infinity, limits::INDEX),
            ("n_error", self.n_error, limits::N_ERROR),
        ] {
            value.inspect(|value| faults.number(&format!("{field}.{key}"), *value, range, remedy));
        }
        let below = "n is known there by no pole of the ultraviolet; give a longer wavelength";
        self.n_nm.inspect(|nm| faults.number(&format!("{field}.n_nm"), *nm, limits::ANCHOR_NM, below));
        let known = match (self.n_nm, self.n, self.n_infinity) {
            (Some(nm), Some(n), None) => KnownIndex::At { wavelength_um: 1e-3 * nm, n },
            (None, None, Some(n)) => KnownIndex::Infinity(n),
            _ => {
                let found = keys_in_words(self, &["n_nm", "n", "n_infinity"]);
                let allowed = "n_nm and n, or n_infinity alone: κ gives n up to a constant";
                faults.add(field, found, allowed, remedy);
                return None;
            }
        };
        let n_error = self.n_error.unwrap_or(0.0);
        (faults.0.len() == before).then_some(BesideKappa::KramersKronig { known, n_error })
    }
}

impl DilutionWritten {
    fn checked(&self, field: &str, faults: &mut Faults) -> Dilution {
        let Self { path_mm, concentration_g_per_l, density_g_per_cm3 } = *self;
        for (key, value, range, remedy) in [
            ("path_mm", path_mm, limits::PATH_MM, "a cuvette has 10 mm"),
            (
                "concentration_g_per_l",
                concentration_g_per_l,
                limits::CONCENTRATION,
                "give the pigment's mass in a litre of the dilution",
            ),
            (
                "density_g_per_cm3",
                density_g_per_cm3,
                limits::DENSITY,
                "organic pigments have 1.3 to 2, oxides 4 to 6",
            ),
        ] {
            faults.number(&format!("{field}.{key}"), value, range, remedy);
        }
        let share = 1e-3 * concentration_g_per_l / density_g_per_cm3;
        if share > limits::DILUTE && limits::CONCENTRATION.holds(concentration_g_per_l) {
            let found = format!("{concentration_g_per_l}, {:.0} % of the volume", 100.0 * share);
            let allowed = format!("at most {:.0} % of the volume", 100.0 * limits::DILUTE);
            let remedy = "check its unit, g/l, and the density, g/cm³: grains of a denser one change each other's light";
            faults.add(format!("{field}.concentration_g_per_l"), found, allowed, remedy);
        }
        Dilution { path_mm, concentration_g_per_l, density_g_per_cm3 }
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
    faults.0.extend(unsound(field, &index, wavelengths_nm));
    // wavelengths that are not allowed are reported with the light
    if faults.0.len() > before || index.len() < wavelengths_nm.len() {
        return IndexSpectrum::vacuum(tables);
    }
    IndexSpectrum { source: source(&spectrum), index, spectrum, ..IndexSpectrum::vacuum(tables) }
}

/// A listed material without two rays.
fn no_rays(field: &str, name: &str, error: &SpectrumError) -> Fault {
    let uniaxial = MATERIALS.iter().filter(|material| material.is_uniaxial()).map(|material| material.name);
    let allowed = format!("a uniaxial crystal: {}", uniaxial.collect::<Vec<_>>().join(", "));
    let remedy = "take one of these, or your own { ordinary = …, extraordinary = … }; or remove birefringent";
    match error {
        SpectrumError::UnknownMaterial { .. } => {
            Fault::new(format!("{field}.material"), format!("{name:?}"), allowed, remedy)
        }
        _ => Fault::new(format!("{field}.birefringent"), format!("true for {name:?}"), allowed, remedy),
    }
}

/// Largest n or k of a medium.
const LARGEST_PART: f64 = 100.0;

/// Refuses indices that no passive medium has: the formulas of records may have poles.
fn unsound(field: &str, index: &[Complex64], wavelengths_nm: &[f64]) -> Option<Fault> {
    let is_sound = |eta: &Complex64| eta.re > 0.0 && eta.im >= 0.0 && eta.re.max(eta.im) <= LARGEST_PART;
    let i = index.iter().position(|eta| !is_sound(eta))?;
    let n = shown(index[i].re);
    let k = shown(index[i].im);
    let found = format!("n = {n}, k = {k} at {} nm", wavelengths_nm[i]);
    let remedy = "correct the file; absorption is a positive k here (time factor exp(-iωt))";
    Some(Fault::new(field, found, "n greater than 0 and k of at least 0, both at most 100", remedy))
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

/// A name that is not known, or a file that holds no index: the value `written` of `key`.
fn not_found(field: &str, key: &str, written: &str, folder: &Path, error: &SpectrumError) -> Fault {
    let take = "take one of these, or your own table with { csv = \"file.csv\" }";
    let found = match (key, error) {
        ("built_in" | "material", _) => format!("{written:?}"),
        ("yaml", _)
        | (_, SpectrumError::File(_) | SpectrumError::RealPart(_) | SpectrumError::KramersKronig(_)) => {
            error.to_string()
        }
        _ => format!("{} ({error})", folder.join(written).display()),
    };
    let allowed = match key {
        "built_in" => Synthetic::ALL.map(Synthetic::name).join(", "),
        "material" => MATERIALS.iter().map(|material| material.name).collect::<Vec<_>>().join(", "),
        "csv" => {
            "a readable table wavelength_nm,kappa[,n] with rising or falling wavelengths, kappa ≥ 0 and n > 0"
                .into()
        }
        _ => "a record of refractiveindex.info: tabulated nk, n, k, or formula 1 to 9".into(),
    };
    let remedy = match (key, error) {
        (_, SpectrumError::RealPart(_)) => {
            format!(
                "write n beside the file where it has k alone: {{ {key} = \"…\", n = 1.4 }}, or for a CSV file kramers_kronig = {{ n_nm = 589, n = 1.65 }}"
            )
        }
        (_, SpectrumError::KramersKronig(_)) => "correct the table, or give n beside it".to_owned(),
        ("built_in", _) if NamedMaterial::find(written).is_some() => {
            format!("{written} is a measured material: {{ material = {written:?} }}")
        }
        ("material", _) if Synthetic::ALL.iter().any(|known| known.name() == written) => {
            format!("{written} is a built-in pigment: {{ built_in = {written:?} }}")
        }
        ("material", _) if !NamedMaterial::with_words(written).is_empty() => {
            format!("did you mean {}?", NamedMaterial::with_words(written).join(" or "))
        }
        ("built_in", _) => take.to_owned(),
        ("material", _) => format!("{take}; organic pigments are in no open collection of indices"),
        ("csv", _) => "correct the table; its path is relative to the study file".to_owned(),
        _ => "download the record's YAML file; its path is relative to the study file".to_owned(),
    };
    Fault::new(field, found, allowed, remedy)
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

/// Rows of a file that cannot be used, where the study's wavelengths need them.
fn faulty_rows(field: &str, spectrum: &Spectrum, wavelengths_nm: &[f64]) -> Option<Fault> {
    let (&first, &last) = wavelengths_nm.first().zip(wavelengths_nm.last())?;
    let gap = spectrum.unusable([first, last])?;
    let [from, to] = gap.between_nm;
    let allowed = format!(
        "sound rows (each wavelength once and in order, kappa ≥ 0, n > 0) from {first} to {last} nm, where the study needs them; \
         faults in other rows do no harm"
    );
    let remedy = format!("correct the table between {from} and {to} nm, or choose other wavelengths");
    Some(Fault::new(field, format!("{}: {}", spectrum.name(), gap.reason), allowed, remedy))
}

/// One remark for every file with a wide gap within the study's wavelengths, for every seam of
/// joined records there, and for every material under a former name.
pub(super) fn bridged(study: &Study) -> BTreeSet<String> {
    let Some(&from) = study.wavelengths_nm.first() else { return BTreeSet::new() };
    let Some(&to) = study.wavelengths_nm.last() else { return BTreeSet::new() };
    let dissolved = study.dissolved.iter().map(|dissolved| &dissolved.material);
    let materials = study.materials().chain(study.extraordinary_indices());
    let spectra = materials.chain(dissolved).chain([&study.layer.binder]).map(|m| &m.spectrum);
    let spectra: Vec<&Spectrum> = spectra.collect();
    let listed = spectra.iter().flat_map(|spectrum| of_listed(spectrum, [from, to]));
    let gaps = spectra.iter().filter_map(|s| Some(gap_in_words(&s.name(), s.widest_gap_nm([from, to])?)));
    let gap_measured = study.judgement.measured.as_ref().and_then(|measured| {
        let rows: Vec<f64> = measured.rows.iter().map(|row| row[0]).collect();
        Some(gap_in_words(&measured.source, widest_gap_nm(&rows, [from, to])?))
    });
    gaps.chain(gap_measured).chain(listed).collect()
}

/// What is to be known of a listed material: seams between its records, and that its name changed.
fn of_listed(spectrum: &Spectrum, [from, to]: [f64; 2]) -> Vec<String> {
    let Spectrum::Named(named) = spectrum else { return Vec::new() };
    let called = spectrum.name();
    let within = |seam: &[f64; 2]| seam[1] > from && seam[0] < to && seam[0] < seam[1];
    let seams = named.seams_nm().into_iter().filter(within);
    let mut said: Vec<String> = seams
        .map(|[end, start]| {
            format!("{called}: two records are joined between {end:.0} and {start:.0} nm, where n and κ are straight lines")
        })
        .collect();
    if let Some(material) = NamedMaterial::find(&called)
        && material.name != called
    {
        said.push(format!("{called} is listed as {:?} ({})", material.name, material.what));
    }
    said
}

fn gap_in_words(file: &str, [from, to]: [f64; 2]) -> String {
    let width = to - from;
    format!(
        "{file}: no row between {from} and {to} nm; these {width} nm are interpolated linearly: \
         add rows every 10 or 20 nm if the spectrum bends there"
    )
}
