//! Files of κ alone, and of the absorbance of a dilution: what n follows from.

use super::{constant, not_found};
use crate::input::forms::{DilutionWritten, INDEX_KEYS, IndexWritten, KramersKronigWritten};
use crate::input::{Faults, keys_in_words, limits};
use crate::material::kramers_kronig::KnownIndex;
use crate::material::spectra::{BesideKappa, Dilution, Spectrum};
use std::path::Path;

impl IndexWritten {
    /// The spectrum of a file of κ with a relation for n, or of the absorbance of a dilution.
    pub(super) fn beside_kappa(&self, field: &str, folder: &Path, faults: &mut Faults) -> Option<Spectrum> {
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
