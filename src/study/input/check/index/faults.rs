//! What can be wrong with an index: names and files that are not found, wavelengths without a
//! value, values that no medium has.

use crate::input::check::paper::range;
use crate::input::{Fault, limits};
use crate::material::columns::in_other_unit;
use crate::material::named::{MATERIALS, NamedMaterial};
use crate::material::spectra::{Spectrum, SpectrumError};
use crate::material::synthetic::Synthetic;
use crate::numerics::allowed::shown;
use num_complex::Complex64;
use std::path::Path;

/// Largest n or k of a medium.
const LARGEST_PART: f64 = 100.0;

/// A name that is not known, or a file that holds no index: the value `written` of `key`.
pub(super) fn not_found(
    field: &str,
    key: &str,
    written: &str,
    folder: &Path,
    error: &SpectrumError,
) -> Fault {
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

/// A listed material without two rays.
pub(super) fn no_rays(field: &str, name: &str, error: &SpectrumError) -> Fault {
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

/// Refuses indices that no passive medium has: the formulas of records may have poles, or a square
/// of n below 0.
pub(super) fn unsound(
    field: &str,
    spectrum: &Spectrum,
    index: &[Complex64],
    wavelengths_nm: &[f64],
) -> Option<Fault> {
    let has_formula = matches!(spectrum, Spectrum::Recorded(record) if record.has_formula());
    let is_sound = |eta: &Complex64| {
        let in_range = if has_formula { limits::INDEX.holds(eta.re) } else { eta.re > 0.0 };
        in_range && eta.im >= 0.0 && eta.re.max(eta.im) <= LARGEST_PART
    };
    let i = index.iter().position(|eta| !is_sound(eta))?;
    let n = shown(index[i].re);
    let k = shown(index[i].im);
    let nm = wavelengths_nm[i];
    if has_formula && index[i].im >= 0.0 {
        let found = match index[i].re {
            n if n.is_nan() => format!("a square of n below 0 at {nm} nm by the record's formula"),
            _ => format!("n = {n} at {nm} nm by the record's formula"),
        };
        let remedy = "correct the formula's number and coefficients, or choose wavelengths away from its poles; \
                      a metal needs a table of n and k";
        return Some(Fault::new(field, found, format!("n {}", limits::INDEX), remedy));
    }
    let found = format!("n = {n}, k = {k} at {nm} nm");
    let remedy = "correct the file; absorption is a positive k here (time factor exp(-iωt))";
    Some(Fault::new(field, found, "n greater than 0 and k of at least 0, both at most 100", remedy))
}

/// The first wavelength at which a spectrum has no value.
pub(super) fn outside(field: &str, spectrum: &Spectrum, wavelengths_nm: &[f64]) -> Option<Fault> {
    let [low, high] = spectrum.range_nm()?;
    let slack = 1e-9;
    let nm = wavelengths_nm.iter().find(|&&nm| nm < low - slack || nm > high + slack)?;
    let allowed = format!("from {low} to {high} nm, where {} is known", spectrum.name());
    let usual = "give a table that covers 400 to 700 nm; with [light] inside the table's range spectra lack nothing, but colours \
                 have wider error bars, and need 440 to 610 nm at least";
    let remedy = in_other_unit([low, high], range(wavelengths_nm)).unwrap_or_else(|| usual.to_owned());
    Some(Fault::new(field, format!("no value at {nm} nm"), allowed, remedy))
}

/// Rows of a file that cannot be used, where the study's wavelengths need them.
pub(super) fn faulty_rows(field: &str, spectrum: &Spectrum, wavelengths_nm: &[f64]) -> Option<Fault> {
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
