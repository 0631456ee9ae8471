//! Quantities of instruments that are no reflectance, by the words of columns and declarations.

use super::fields::Declared;
use super::words::{self, MeasuredKind, has_phrase, word_list};

/// Logarithms of reflectance and other absorbances, as they are written without blanks.
const LOGARITHMS: [&str; 12] = [
    "log(1/r)",
    "log10(1/r)",
    "log1/r",
    "log101/r",
    "ln(1/r)",
    "ln1/r",
    "-log(r)",
    "-log10(r)",
    "-logr",
    "-log10r",
    "-ln(r)",
    "-lnr",
];
/// Words that name an absorbance or a density wherever they stand.
const ABSORBANCES: [&str; 9] = [
    "absorbance",
    "absorbancy",
    "absorption",
    "absorptance",
    "absorptivity",
    "absorbanz",
    "extinction",
    "extinktion",
    "optical density",
];
/// Words that name one where they stand last; a sample may be called density step 3.
const LAST: [&str; 4] = ["density", "densities", "od", "densität"];
/// Words that name emitted or received light, without a white.
const LIGHTS: [&str; 7] =
    ["radiance", "irradiance", "emission", "emissivity", "emittance", "counts", "intensity"];

/// The quantity that a name or a declaration states, if it is known to be none that a white
/// diffuser has as 1: K/S, a logarithm, an absorbance, a density, a transmittance, emitted light.
pub fn other_quantity(text: &str) -> Option<MeasuredKind> {
    let lower = text.trim().to_lowercase();
    let words = word_list(&lower);
    let dense: String = lower.chars().filter(|c| !c.is_whitespace() && *c != '_').collect();
    let is_last = |all: &[&str]| words.last().is_some_and(|word| all.contains(&word.as_str()));
    let has_word = |all: &[&str]| words.iter().any(|word| all.contains(&word.as_str()));
    let two_functions = words.len() <= 2 && (dense.starts_with("f(r") || dense.starts_with("k/s"));
    if lower.contains("kubelka")
        || has_phrase(&lower.replace(" / ", "/"), "k/s")
        || two_functions
        || ["ks", "k/s", "k_s", "k-s", "ks value", "ks values", "km"].contains(&lower.as_str())
    {
        return Some(MeasuredKind::KubelkaMunk);
    }
    if LOGARITHMS.iter().any(|log| dense.contains(log))
        || ABSORBANCES.iter().any(|name| words.join(" ").contains(name))
        || is_last(&LAST)
        || ["a", "a.u.", "abs", "abs."].contains(&lower.as_str())
        || (words.len() <= 2 && words.first().is_some_and(|word| word == "od"))
    {
        return Some(MeasuredKind::Absorbance);
    }
    let is_share_of_t = words.first().is_some_and(|word| word == "t") && words.len() > 1;
    let percent_t = dense.contains('%') && has_word(&["t"]);
    if lower.contains("transmi") || words == ["t"] || is_share_of_t || percent_t {
        return Some(MeasuredKind::Transmittance);
    }
    has_word(&LIGHTS).then_some(MeasuredKind::Emission)
}

/// What a line such as `Y units: K/S`, or a title such as `Absorbance`, says was measured.
pub fn declared_quantity(line: &str) -> Option<MeasuredKind> {
    const ABOUT: [&str; 8] = ["mode", "type", "ordinate", "unit", "units", "quantity", "yaxis", "ylabel"];
    match line.split_once([':', '=']) {
        Some((key, value)) => {
            let key: String = key.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect();
            let of_values = key.starts_with('y') || key == "ordinate";
            let of_wavelengths = key.starts_with('x') || key.contains("wavelength");
            let tells = !of_wavelengths && ABOUT.iter().any(|word| key.ends_with(word));
            // a single letter may also be a type of instrument or light
            other_quantity(value).filter(|_| tells && (of_values || value.trim().len() > 1))
        }
        None => {
            let words = word_list(line);
            let is_plain =
                words.len() == 1 || line.contains('(') || words.first().is_some_and(|word| word == "optical");
            let is_declared = |kind: &MeasuredKind| is_plain || *kind == MeasuredKind::KubelkaMunk;
            other_quantity(line).filter(|kind| line.trim().len() > 1 && is_declared(kind))
        }
    }
}

/// What lines of text declare.
pub(super) fn declared<'a>(texts: impl Iterator<Item = &'a String>) -> Declared {
    let mut all = Declared::default();
    for text in texts {
        let lower = text.to_lowercase();
        let about =
            ["reflect", "%r", "r%", "% r", "r [%", "r (%", "r(%", "r[%", "unit", "ordinate", "albedo"];
        if about.iter().any(|word| lower.contains(word)) || lower.trim() == "%" {
            if lower.contains('%') || lower.contains("percent") {
                all.white = Some(100.0);
            } else if lower.contains("factor")
                || lower.contains("share")
                || lower.contains("0-1")
                || lower.contains("0..1")
            {
                all.white = all.white.or(Some(1.0));
            }
        }
        all.condition = all.condition.or(words::conditions(text).first().copied());
        all.geometries.extend(words::geometries(text));
        let measured = lower.contains("mode") || lower.contains("type") || lower.contains("ordinate");
        if measured && let Some(kind) = MeasuredKind::of(text) {
            all.kind = kind;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_other_quantities_are_known_and_names_of_samples_are_none() {
        use MeasuredKind::{Absorbance, Emission, KubelkaMunk, Transmittance};
        for (name, kind) in [
            ("K/S", KubelkaMunk),
            ("KS", KubelkaMunk),
            ("k / s", KubelkaMunk),
            ("ink K/S", KubelkaMunk),
            ("Kubelka-Munk units", KubelkaMunk),
            ("F(R)", KubelkaMunk),
            ("log(1/R)", Absorbance),
            ("log 1/R", Absorbance),
            ("-log10(R)", Absorbance),
            ("A", Absorbance),
            ("Abs", Absorbance),
            ("OD", Absorbance),
            ("Optical density", Absorbance),
            ("Reflection density", Absorbance),
            ("Absorbance of ink", Absorbance),
            ("T", Transmittance),
            ("%T", Transmittance),
            ("T (%)", Transmittance),
            ("ink %T", Transmittance),
            ("TRANSMITTANCE", Transmittance),
            ("radiance", Emission),
        ] {
            assert_eq!(other_quantity(name), Some(kind), "{name}");
        }
        for name in [
            "R",
            "%R",
            "ink",
            "ink/substrate",
            "black K",
            "K",
            "S",
            "density 1.2",
            "tack",
            "kste",
            "T1",
            "albedo",
            "reflectance_factor",
            "Reflectance (%)",
            "A4",
            "log",
        ] {
            assert_eq!(other_quantity(name), None, "{name}");
        }
        assert_eq!(declared_quantity("Y units: K/S"), Some(KubelkaMunk));
        assert_eq!(declared_quantity("Absorbance"), Some(Absorbance));
        for line in [
            "Instrument: T 100",
            "A",
            "ink of low density",
            "x units: 1/cm",
            "Mode: reflectance",
            "Instrument type: A",
            "Model: OD-200",
            "low density",
        ] {
            assert_eq!(declared_quantity(line), None, "{line}");
        }
    }
}
