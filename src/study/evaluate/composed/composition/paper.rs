//! The paper of a composition: albedo, contact and brightener.

use crate::appearance::fluorescence::{Fluorescence, SHORTEST_NM, STEP_NM, summed_nm};
use crate::appearance::paper::{Albedo, Coupling, PaperError};
use crate::appearance::viewing::Viewing;
use crate::evaluate::prints::Brightened;
use crate::input::fault::EMPTY_LIST;
use crate::input::measured::MeasuredCondition;
use crate::input::study::Paper;
use crate::material::columns::in_other_unit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rounding of quanta that add up to 1, and of steps.
const ROUNDING: f64 = 1e-9;
/// Longest wavelength that a brightener emits, nm.
const LONGEST_NM: f64 = 780.0;

/// The paper of a composition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompositionPaper {
    /// Share of the light that it returns, 0 to 1: a number, or rows of nm and share.
    #[schemars(with = "serde_json::Value")]
    pub albedo: Albedo,
    /// Whether it touches the stack, in a medium of the joint's index; else there is a thin gap.
    pub contact: bool,
    /// Its brightener, of a library whose wavelengths hold the light that excites it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluorescence: Option<CompositionFluorescence>,
}

/// A brightener of a composition's paper: bands, or a bispectral table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "{ excitation = [[nm, share], …], emission = [[nm, quanta], …], yield = 0.5 } or { excitation_nm = […], \
                 emission_nm = […], factors = [[…], …] }"
)]
pub enum CompositionFluorescence {
    /// One brightener. It takes its share of the light before the albedo acts on the rest.
    Bands {
        /// Rows of wavelength in nm and share of the quanta that it absorbs, 0 to 1.
        excitation: Vec<[f64; 2]>,
        /// Rows of wavelength in nm and quanta emitted per nm, in any unit.
        emission: Vec<[f64; 2]>,
        /// Quanta emitted per quantum absorbed, 0 to 1.
        #[serde(rename = "yield")]
        quantum_yield: f64,
    },
    /// A bispectral measurement of the paper behind its surface.
    Table {
        /// Wavelengths of the light, nm, rising in equal steps.
        excitation_nm: Vec<f64>,
        /// Wavelengths emitted, nm, rising.
        emission_nm: Vec<f64>,
        /// Radiance factors: a row for every wavelength emitted, in it one for every wavelength of
        /// the light; those that are not of longer wavelength than their light are left out.
        factors: Vec<Vec<f64>>,
    },
}

impl Default for CompositionPaper {
    fn default() -> Self {
        Self { albedo: Albedo::Constant(0.9), contact: false, fluorescence: None }
    }
}

impl CompositionPaper {
    /// What is between the stack and the paper's scatterers.
    pub(super) fn coupling(&self, joint_index: f64) -> Coupling {
        if self.contact { Coupling::OpticalContact { index: joint_index } } else { Coupling::Gap }
    }

    /// What is wrong with the albedo: found, allowed, and what to do.
    fn albedo_in_words(&self, error: &PaperError, wavelengths_nm: &[f64]) -> String {
        let rows: &[[f64; 2]] = if let Albedo::Spectral(rows) = &self.albedo { rows } else { &[] };
        let used_nm = [0, wavelengths_nm.len().saturating_sub(1)]
            .map(|w| wavelengths_nm.get(w).copied().unwrap_or(0.0));
        let covering =
            format!("two or more rows [nm, albedo], rising, from {} to {} nm", used_nm[0], used_nm[1]);
        match error {
            PaperError::Albedo { value } => {
                format!("paper.albedo: found {value}; allowed 0 to 1: 0.9 is good paper")
            }
            PaperError::AlbedoRange { lo, hi, .. } => {
                let extend = || "extend the table".to_owned();
                let remedy = in_other_unit([*lo, *hi], used_nm).unwrap_or_else(extend);
                format!("paper.albedo: found rows from {lo} to {hi} nm; allowed {covering}: {remedy}")
            }
            _ => {
                let found = if rows.is_empty() { EMPTY_LIST } else { "rows that do not rise, or one alone" };
                format!("paper.albedo: found {found}; allowed {covering}: or write one number, albedo = 0.9")
            }
        }
    }

    /// The paper at a library's wavelengths, as a study has it.
    ///
    /// # Errors
    /// Brighteners that there cannot be, and light that does not excite them.
    pub(super) fn checked(&self, joint_index: f64, wavelengths_nm: &[f64]) -> Result<Paper, String> {
        let mut paper = Paper {
            source: String::new(),
            albedo: self.albedo.clone(),
            coupling: self.coupling(joint_index),
            measured: None,
            fluorescence: None,
            dots: None,
        };
        let at =
            |nm: &f64| paper.albedo.at(*nm).map_err(|error| self.albedo_in_words(&error, wavelengths_nm));
        wavelengths_nm.iter().try_for_each(|nm| at(nm).map(drop))?;
        let Some(written) = &self.fluorescence else { return Ok(paper) };
        let fluorescence = written.checked().map_err(|words| format!("paper.fluorescence{words}"))?;
        let (Some(&from_nm), Some(&to_nm)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
            return Ok(paper);
        };
        if let Some([first, _]) = fluorescence.excited_nm()
            && from_nm > first.max(SHORTEST_NM) + STEP_NM
        {
            return Err(format!(
                "paper.fluorescence: found excitation from {first} nm, a library from {from_nm} nm; allowed is a library that holds \
                 the light that excites: solve its layers again with light.from_nm = {}",
                first.max(SHORTEST_NM)
            ));
        }
        if let Fluorescence::Bands { quantum_yield, .. } = &fluorescence
            && *quantum_yield > 0.0
            && fluorescence.excited_nm().is_some()
            && fluorescence.matrix(&summed_nm(from_nm, to_nm)).iter().flatten().all(|factor| *factor == 0.0)
        {
            return Err(format!(
                "paper.fluorescence.emission: found a yield of {quantum_yield}, and nothing emitted from {from_nm} to {to_nm} nm; \
                 allowed is emission at longer waves than the excitation, within the library's: correct the rows; yield = 0 only absorbs"
            ));
        }
        if matches!(fluorescence, Fluorescence::Bands { .. }) {
            paper.albedo = fluorescence.left_of(&paper.albedo, wavelengths_nm);
        }
        let albedo = |nm: f64| paper.albedo.at(nm).unwrap_or(0.0);
        let most = fluorescence.most_quanta(albedo, &summed_nm(from_nm, to_nm.max(LONGEST_NM)));
        if most > 1.0 + ROUNDING {
            return Err(format!(
                "paper.fluorescence: found {most:.3} quanta reflected and emitted for each that comes in; allowed at most 1: lower \
                 yield or excitation, or the albedo at the wavelengths that excite"
            ));
        }
        paper.fluorescence = Some(fluorescence);
        Ok(paper)
    }
}

/// A paper under the light that excites it: that of an instrument, or the illuminant; `None` if it
/// does not fluoresce.
///
/// # Errors
/// A condition without light of its own.
pub(super) fn lit(
    paper: &Paper,
    wavelengths_nm: &[f64],
    condition: Option<MeasuredCondition>,
    illuminant: &Viewing,
) -> Result<Option<Brightened>, String> {
    if condition == Some(MeasuredCondition::M3) {
        let said = "condition: found M3; allowed M0, M1, M2, or none for the illuminant's light";
        return Err(said.to_owned());
    }
    Brightened::under(paper, wavelengths_nm, condition, illuminant).map_err(|error| error.to_string())
}

impl CompositionFluorescence {
    /// With what there cannot be refused: field, what was found and what is allowed.
    fn checked(&self) -> Result<Fluorescence, String> {
        match self {
            Self::Bands { excitation, emission, quantum_yield } => {
                rising(".excitation", excitation, 1.0)?;
                rising(".emission", emission, f64::MAX)?;
                if !(0.0..=1.0).contains(quantum_yield) {
                    return Err(format!(
                        ".yield: found {quantum_yield}; allowed 0 to 1: 0.5 to 0.9 are usual"
                    ));
                }
                Ok(Fluorescence::Bands {
                    excitation: excitation.clone(),
                    emission: emission.clone(),
                    quantum_yield: *quantum_yield,
                })
            }
            Self::Table { excitation_nm, emission_nm, factors } => {
                let widths: Vec<f64> = excitation_nm.windows(2).map(|pair| pair[1] - pair[0]).collect();
                let even = |width: &f64| *width > 0.0 && (width - widths[0]).abs() <= 1e-6 * widths[0];
                if widths.is_empty() || !widths.iter().all(even) {
                    let count = excitation_nm.len();
                    return Err(format!(
                        ".excitation_nm: found {count} wavelengths; allowed two or more in equal steps"
                    ));
                }
                if emission_nm.len() < 2 || !emission_nm.windows(2).all(|pair| pair[1] > pair[0]) {
                    let count = emission_nm.len();
                    return Err(format!(
                        ".emission_nm: found {count} wavelengths; allowed two or more that rise"
                    ));
                }
                let fits = factors.len() == emission_nm.len()
                    && factors.iter().all(|row| row.len() == excitation_nm.len());
                if !fits || !factors.iter().flatten().all(|x| x.is_finite() && *x >= 0.0) {
                    let words = "allowed is a row for every wavelength emitted, with a number of 0 or more for every one of the light";
                    return Err(format!(".factors: found {} rows; {words}", factors.len()));
                }
                let emitted = |(to, row): (&f64, &Vec<f64>)| {
                    let entry = |(from, factor): (&f64, &f64)| if to > from { *factor } else { 0.0 };
                    excitation_nm.iter().zip(row).map(entry).collect()
                };
                Ok(Fluorescence::Table {
                    excitation_nm: excitation_nm.clone(),
                    emission_nm: emission_nm.clone(),
                    factors: emission_nm.iter().zip(factors).map(emitted).collect(),
                })
            }
        }
    }
}

/// Rows that rise in wavelength and hold values from 0.
fn rising(field: &str, rows: &[[f64; 2]], most: f64) -> Result<(), String> {
    let allowed = "two or more rows [nm, value], rising, values from 0 (shares up to 1)";
    let wrong = rows.iter().find(|row| !(row[0].is_finite() && (0.0..=most).contains(&row[1])));
    if let Some([nm, value]) = wrong {
        return Err(format!("{field}: found {value} at {nm} nm; allowed are {allowed}"));
    }
    if rows.len() < 2 || rows.windows(2).any(|pair| pair[1][0] <= pair[0][0]) {
        return Err(format!("{field}: found {} rows; allowed are {allowed}", rows.len()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::fluorescence::rows_at;

    /// A brightener leaves the albedo what it does not absorb. *Planted*: the albedo taken whole.
    #[test]
    fn a_brightener_takes_its_light_first() {
        let excitation = vec![[350.0, 0.0], [370.0, 0.6], [390.0, 0.0]];
        let emission = vec![[410.0, 0.0], [440.0, 1.0], [500.0, 0.0]];
        let bands =
            CompositionFluorescence::Bands { excitation: excitation.clone(), emission, quantum_yield: 0.5 };
        let paper = CompositionPaper { fluorescence: Some(bands), ..CompositionPaper::default() };
        let nm: Vec<f64> = (0..21).map(|k| 345.0 + 20.0 * f64::from(k)).collect();
        let found = paper.checked(1.5, &nm).expect("a paper");
        for at in nm {
            let want = 0.9 * (1.0 - rows_at(&excitation, at));
            assert!((found.albedo.at(at).expect("in range") - want).abs() < 1e-15, "{at}");
        }
    }
}
