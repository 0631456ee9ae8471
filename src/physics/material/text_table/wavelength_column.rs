//! Which columns hold wavelengths, and in which unit.

/// Factor from the unit of a column of wavelengths to nm, by its name: `Wavelength (nm)`, `nm`,
/// `wl` (µm: so the website of refractiveindex.info names it), `lambda_um`; none for other columns.
/// A name without a unit is taken as nm.
pub fn wavelength_factor(name: &str) -> Option<f64> {
    let lower = name.trim().to_lowercase();
    let words: Vec<&str> =
        lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
    let is = |all: &[&str]| words.iter().any(|word| all.contains(word));
    let quantity = is(&["wavelength", "wavelengths", "wavelen", "wave", "lambda", "λ", "wellenlänge", "wl"]);
    let unit = if is(&["um", "µm", "μm", "micron", "microns", "micrometer", "micrometers", "micrometre"]) {
        Some(1000.0)
    } else if is(&["nm", "nanometer", "nanometers", "nanometre", "nanometres"]) {
        Some(1.0)
    } else if is(&["å", "angstrom", "angstroms"]) {
        Some(0.1)
    } else {
        None
    };
    let only_unit = words.len() == 1 && unit.is_some();
    if lower == "wl" {
        return Some(1000.0);
    }
    (quantity || only_unit).then(|| unit.unwrap_or(1.0))
}

/// As [`wavelength_factor`], of a name that may be numbered: spreadsheets number equal names, as in
/// `nm.1` and `nm_2`.
pub fn numbered_wavelength_factor(name: &str) -> Option<f64> {
    let unnumbered = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let unnumbered = unnumbered.trim_end_matches(['.', '_', ' ', '-', '#']);
    wavelength_factor(name).or_else(|| wavelength_factor(unnumbered))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_wavelengths_are_known_by_name_and_unit() {
        for (name, factor) in [
            ("Wavelength (nm)", Some(1.0)),
            ("nm", Some(1.0)),
            ("wavelength_nm", Some(1.0)),
            ("λ [µm]", Some(1000.0)),
            ("wl", Some(1000.0)),
            ("WL", Some(1000.0)),
            ("lambda", Some(1.0)),
            ("ink", None),
            ("%R", None),
        ] {
            assert_eq!(wavelength_factor(name), factor, "{name}");
        }
    }
}
