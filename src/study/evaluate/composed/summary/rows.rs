//! Rows of the published tables, and what of them is withheld.

use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::tristimulus::Guide;
use crate::evaluate::composed::between::Fringes;
use crate::evaluate::composed::distribution::projected_sr;
use crate::evaluate::composed::gate::{self, LayerInColour};
use crate::evaluate::composed::level::Slabs;
use crate::evaluate::composed::numbers::LayerTask;
use crate::evaluate::gate::impossible;
use crate::evaluate::manifest::composed::{
    AbsorbedRow, ComposedColours, ComposedRow, DistributionRow, MediumRow,
};
use crate::evaluate::prints::paper_between;
use crate::evaluate::published::{ErrorParts, NumberNote, NumberParts, Withheld};
use crate::evaluate::quantities::{Distribution, LayerNumbers, MediumNumbers, ThicknessNumbers};
use crate::input::study::Study;

/// Share of unscattered light from which a slab that gives no coefficients is too thin, not too
/// thick, for them.
const CLEAR: f64 = 0.5;

/// The rows and colours of some thicknesses, and what of them cannot be.
#[derive(Default)]
pub(super) struct ThicknessRows {
    pub rows: Vec<ComposedRow>,
    pub colours: Vec<ComposedColours>,
    /// X, Y, Z at 45:0 that these have beyond the factors of the rows.
    pub beyond_factors: Vec<[f64; 3]>,
    pub weighted: Vec<NumberNote>,
    pub withheld: Vec<Withheld>,
}

impl ThicknessRows {
    /// Of layers of these thicknesses, µm.
    pub fn of(task: &LayerTask, thicknesses_um: &[f64], layers: &[ThicknessNumbers<ErrorParts>]) -> Self {
        let mut all = Self::default();
        for (um, layer) in thicknesses_um.iter().zip(layers) {
            all.add(task, *um, layer);
        }
        all
    }

    /// Adds a layer of one thickness.
    pub fn add(&mut self, task: &LayerTask, thickness_um: f64, numbers: &ThicknessNumbers<ErrorParts>) {
        let row = |(&wavelength_nm, numbers): (&f64, &LayerNumbers<ErrorParts>)| ComposedRow {
            thickness_um,
            wavelength_nm,
            layer: numbers.map(Some),
        };
        let all: Vec<ComposedRow> = task.study.wavelengths_nm.iter().zip(&numbers.spectra).map(row).collect();
        let mut kept = all.clone();
        let fluoresces = task.daylight.is_some();
        let values: Vec<LayerNumbers<f64>> =
            numbers.spectra.iter().map(|row| row.map(|number| number.value)).collect();
        let fringes = task.films(thickness_um).fringes(&task.study.wavelengths_nm, &values);
        self.withheld.extend(gate::rows(&mut kept, fluoresces));
        if let Some((eye, numbers)) = task.colorimeter.as_ref().zip(numbers.colours.as_ref()) {
            let seen = task.visible.clone();
            let Study { paper, wavelengths_nm, .. } = task.study;
            let paper = paper_between(paper, wavelengths_nm, task.daylight.as_ref(), eye.viewing());
            let layer = LayerInColour {
                eye,
                all: &all[seen.clone()],
                kept: &kept[seen.clone()],
                paper,
                fluoresces,
                fringes: fringes.as_ref().map(|fringes| (fringes, seen)),
            };
            let (colours, withheld) = layer.colours(numbers);
            self.colours.push(colours);
            self.beyond_factors.push(numbers.beyond_factors[1].map(|xyz| xyz.value));
            self.withheld.extend(withheld);
        }
        self.add_weighted(task, thickness_um, numbers, fringes.as_ref());
        self.rows.extend(kept);
    }

    /// Adds the weighted numbers of a layer of one thickness.
    fn add_weighted(
        &mut self,
        task: &LayerTask,
        thickness_um: f64,
        numbers: &ThicknessNumbers<ErrorParts>,
        fringes: Option<&Fringes>,
    ) {
        let values: Vec<LayerNumbers<f64>> =
            numbers.spectra.iter().map(|row| row.map(|number| number.value)).collect();
        for (asked, number) in task.weighted.iter().zip(&numbers.weighted) {
            let spectra = task.weighted_spectra(asked, &values);
            let spectra: Vec<&[f64]> = spectra.iter().map(Vec::as_slice).collect();
            let ErrorParts { value, chance, model, grid, directions, inputs, .. } = *number;
            let films = fringes.map(|fringes| task.weighted_films(asked, fringes)).unwrap_or_default();
            let [film, quarter]: [Vec<Guide>; 2] = films;
            let known: Vec<Option<&Guide>> = film.iter().map(Some).collect();
            let missed = if quarter.is_empty() { 0.0 } else { asked.missed(&spectra, &quarter) };
            let wavelengths = asked.wavelength_error(&spectra, &known, true).hypot(missed);
            let parts = NumberParts { chance, model, grid, directions, wavelengths, inputs };
            let error = parts.together();
            let impossible = asked.impossible(value, Some(error));
            let possible = impossible.is_none();
            self.weighted.push(NumberNote {
                name: asked.wanted.name.clone(),
                thickness_um: Some(thickness_um),
                value: possible.then_some(value),
                standard_error: possible.then_some(error),
                parts: if possible { parts } else { NumberParts::default() },
                deviations: Vec::new(),
                about: asked.wanted.in_words(),
            });
            self.withheld.extend(impossible.map(|reason| Withheld {
                number: format!("{} of {thickness_um} µm", reason.number),
                ..reason
            }));
        }
    }
}

/// A coefficient of the medium that is left out at a wavelength.
pub(super) struct LostCoefficient {
    number: &'static str,
    wavelength_nm: f64,
    reason: String,
    /// Share of light at 0° that an inner slab passes straight on.
    straight: f64,
    remedy: &'static str,
}

/// What is said of coefficients that are left out: once of each, with the first of the wavelengths
/// that have one remedy, and how many they are.
pub(super) fn lost_in_words(all: &[LostCoefficient]) -> Vec<Withheld> {
    let is_like = |a: &LostCoefficient, b: &LostCoefficient| a.number == b.number && a.remedy == b.remedy;
    let mut withheld = Vec::new();
    for (k, lost) in all.iter().enumerate() {
        if all[..k].iter().any(|before| is_like(before, lost)) {
            continue;
        }
        let LostCoefficient { number, wavelength_nm, reason, straight, remedy } = lost;
        let count = all.iter().filter(|other| is_like(lost, other)).count();
        let passed = if *straight < 1e-6 { "nothing".into() } else { format!("{straight:.2} of the light") };
        let reason = format!(
            "{reason} at {wavelength_nm} nm, where a slab passes {passed} unscattered in the mean of these realisations: {remedy}; \
             {count} of its wavelengths are left out"
        );
        withheld.push(Withheld { number: (*number).to_owned(), reason });
    }
    withheld
}

/// The coefficients of the medium as far as they are possible; the others are lost.
pub(super) fn medium_row(
    wavelength_nm: f64,
    slabs: &Slabs,
    numbers: MediumNumbers<ErrorParts>,
    lost: &mut Vec<LostCoefficient>,
) -> MediumRow {
    // share of light at 0° that an inner slab passes straight on
    let straight = slabs.inner.transmission[0][(0, 0)];
    let remedy = if straight < CLEAR {
        "take thinner slabs or more realisations"
    } else {
        "so clear a slab hardly scatters: take thicker slabs or more realisations"
    };
    let mut medium = numbers.map(Some);
    for number in medium.named() {
        let reason = number.estimate.and_then(|estimate| impossible(number.quantity, estimate));
        let Some(reason) = reason else { continue };
        lost.push(LostCoefficient { number: number.in_words, wavelength_nm, reason, straight, remedy });
        medium.withhold(number.name);
    }
    let embedding_index = slabs.media[1].ordinates.index;
    // The medium of transport theory has the index of the half-spaces; another one would change the
    // étendue of its light.
    let apart =
        medium.effective_index.map_or(0.0, |index| ((index.value / embedding_index).powi(2) - 1.0).abs());
    let embedded = |number: ErrorParts| number.with_model(apart * number.value.abs());
    let medium = MediumNumbers {
        absorption_per_um: medium.absorption_per_um.map(embedded),
        asymmetry: medium.asymmetry.map(embedded),
        transport_path_um: medium.transport_path_um.map(embedded),
        ..medium
    };
    MediumRow { wavelength_nm, embedding_index, medium }
}

/// Where light at 0° goes, of each requested thickness and wavelength.
pub(super) fn distributions(
    study: &Study,
    media: &[[&Hemisphere; 2]],
    thicknesses_um: &[f64],
    numbers: &[Vec<Distribution<ErrorParts>>],
) -> Vec<DistributionRow> {
    let mut rows = Vec::new();
    for (&thickness_um, distributions) in thicknesses_um.iter().zip(numbers) {
        for ((&wavelength_nm, [before, behind]), distribution) in
            study.wavelengths_nm.iter().zip(media).zip(distributions)
        {
            let mut add = |reflected: bool, medium: &Hemisphere, lobe: &[ErrorParts]| {
                rows.extend(lobe.iter().enumerate().map(|(node, &bdf_per_sr)| DistributionRow {
                    thickness_um,
                    wavelength_nm,
                    reflected,
                    polar_out_deg: medium.ordinates.polar_deg(node),
                    projected_sr: projected_sr(medium, node),
                    bdf_per_sr,
                }));
            };
            add(true, before, &distribution.reflected);
            add(false, behind, &distribution.transmitted);
        }
    }
    rows
}

/// What every layer of a stack absorbs.
pub(super) fn absorbed(
    study: &Study,
    thicknesses_um: &[f64],
    numbers: &[Vec<Vec<ErrorParts>>],
) -> Vec<AbsorbedRow> {
    let mut rows = Vec::new();
    for (&thickness_um, spectra) in thicknesses_um.iter().zip(numbers) {
        for (&wavelength_nm, layers) in study.wavelengths_nm.iter().zip(spectra) {
            for (layer, &absorptance_normal) in study.stack.iter().zip(layers) {
                let layer = layer.name.clone();
                rows.push(AbsorbedRow { thickness_um, wavelength_nm, layer, absorptance_normal });
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One line a coefficient and remedy, whatever the number of wavelengths. *Planted*: a line for
    /// every wavelength.
    #[test]
    fn lost_coefficients_are_told_once() {
        let lost = |wavelength_nm: f64, straight: f64, remedy: &'static str| LostCoefficient {
            number: "asymmetry",
            wavelength_nm,
            reason: "not determined".into(),
            straight,
            remedy,
        };
        let all = [lost(400.0, 0.0, "thinner"), lost(450.0, 1e-9, "thinner"), lost(2500.0, 0.998, "thicker")];
        let words: Vec<String> = lost_in_words(&all).iter().map(|lost| lost.reason.clone()).collect();
        assert_eq!(words.len(), 2, "{words:?}");
        assert!(
            words[0].contains("at 400 nm") && words[0].contains("passes nothing unscattered"),
            "{words:?}"
        );
        assert!(words[0].ends_with("thinner; 2 of its wavelengths are left out"), "{words:?}");
        assert!(
            words[1].contains("passes 1.00 of the light") && words[1].contains("thicker; 1 of"),
            "{words:?}"
        );
    }
}
