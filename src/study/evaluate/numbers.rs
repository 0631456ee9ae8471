//! Weighted numbers: means of spectra over their wavelengths and what is made of them, with errors
//! as colours have them.
//!
//! A number is a function of a few sums that are linear in the spectrum. All that moves a spectrum
//! moves its sums together, and the number is computed anew: every leave-one-out ensemble, every
//! error of R and T that the realisations share, tables of indices moved by their errors, and what
//! the spectrum may be between and beyond the wavelengths.

use super::ink::{InkError, InkOnPaper};
use super::layer::Total;
use super::levels::GridPart;
use super::on_paper::LayerOnPaper;
use super::published::{NumberNote, NumberParts, Withheld};
use super::seen::{Seen, film_at, film_totals_at};
use super::summed::SummedSpectrum;
use super::uncertainty::{Conditions, Shift, UNMOVED, Uncertainty};
use crate::appearance::paper::MirroredSky;
use crate::appearance::tristimulus::Guide;
use crate::appearance::weighted::{NamedWeights, NumberTransform, WeightedSum};
use crate::input::file::SeenLight;
use crate::input::study::{Study, WantedNumber};
use crate::numerics::estimate::{Estimate, jackknife_deviations};
use crate::solve::accuracy::grid_error::GridError;

/// Means below this are rounding.
const NOTHING: f64 = 1e-9;

/// A number that is asked for, on a grid of wavelengths.
pub struct AskedNumber<'a> {
    /// As the study asks for it.
    pub wanted: &'a WantedNumber,
    weights: NamedWeights,
    sums: Vec<WeightedSum>,
}

/// Sums of the spectra that a number takes: the tables of the first, and one of the second.
type Sums = Vec<f64>;

impl<'a> AskedNumber<'a> {
    /// On these wavelengths, nm; `None` of weights that are unknown.
    pub fn new(wanted: &'a WantedNumber, wavelengths_nm: &[f64]) -> Option<Self> {
        let all = wanted.tables()?;
        let weights = match (wanted.transform.of_tristimulus(), all.tables.len()) {
            // the luminance factor
            (false, 3) => NamedWeights { tables: vec![all.tables[1].clone()], ..all },
            _ => all,
        };
        let sums = weights.sums(wavelengths_nm);
        Some(Self { wanted, weights, sums })
    }

    /// The number of spectra in the order of [`WantedNumber::spectra`].
    pub fn of(&self, spectra: &[&[f64]]) -> f64 {
        self.number(&self.sums_of(spectra))
    }

    /// The sums of its spectra that the number is a function of, each linear in a spectrum: those
    /// of the first, and that of the second.
    pub fn sums_of(&self, spectra: &[&[f64]]) -> Vec<f64> {
        let of_first = self.sums.iter().map(|sum| sum.of(spectra[0]));
        of_first.chain(spectra.get(1).map(|second| self.sums[0].of(second))).collect()
    }

    /// How many sums it takes.
    pub fn count(&self) -> usize {
        self.sums.len() + usize::from(self.wanted.over.is_some())
    }

    /// The number of such sums; NaN where there is none, such as the density of a negative mean.
    pub fn number(&self, sums: &[f64]) -> f64 {
        let transform = self.wanted.transform;
        match (&self.weights.white, sums) {
            (Some(white), &[x, y, z]) if transform.of_tristimulus() => {
                let mut xyz = white.xyz;
                xyz.iter_mut().zip([x, y, z]).for_each(|(white, share)| *white *= share);
                transform.of_xyz(xyz, white)
            }
            // rounding of a spectrum that is 0 is no mean to divide by
            (_, &[_, over]) if over.abs() < NOTHING => f64::NAN,
            (_, &[of, over]) => transform.of_mean(of / over),
            (_, sums) => transform.of_mean(sums.first().copied().unwrap_or(f64::NAN)),
        }
    }

    /// Standard error of the number due to what spectra that are known at the wavelengths alone may
    /// be between and beyond them; `guides` are films of theirs, where there are any.
    pub fn wavelength_error(&self, spectra: &[&[f64]], guides: &[Option<&Guide>], is_sampled: bool) -> f64 {
        self.moved_by(spectra, |sum, k| {
            let guide = guides.get(k).copied().flatten();
            let between = if is_sampled { sum.spacing(spectra[k], guide) } else { Vec::new() };
            between.into_iter().chain(sum.beyond(spectra[k])).collect()
        })
    }

    /// What the wavelengths miss of the number by films of the spectra, one of each.
    pub fn missed(&self, spectra: &[&[f64]], films: &[Guide]) -> f64 {
        self.moved_by(spectra, |sum, k| vec![sum.missed(&films[k])])
    }

    /// Standard error of the number due to independent changes of the sums of each spectrum.
    fn moved_by(&self, spectra: &[&[f64]], changes: impl Fn(&WeightedSum, usize) -> Vec<f64>) -> f64 {
        let here = self.sums_of(spectra);
        let at = self.number(&here);
        let mut square: f64 = 0.0;
        for k in 0..spectra.len() {
            // the sums of one spectrum move together
            let of_spectrum = if k == 0 { 0..self.sums.len() } else { self.sums.len()..here.len() };
            let parts: Vec<Vec<f64>> = of_spectrum
                .clone()
                .map(|place| changes(&self.sums[if k == 0 { place } else { 0 }], k))
                .collect();
            for part in 0..parts.first().map_or(0, Vec::len) {
                let mut moved = here.clone();
                of_spectrum.clone().zip(&parts).for_each(|(place, parts)| moved[place] += parts[part]);
                square += (self.number(&moved) - at).powi(2);
            }
        }
        square.sqrt()
    }

    /// Why the number cannot be, if so.
    pub fn impossible(&self, value: f64, error: Option<f64>) -> Option<Withheld> {
        let transform = self.wanted.transform;
        let reason = if value.is_finite() && error.is_none_or(f64::is_finite) {
            let least = match (transform, self.wanted.over) {
                (NumberTransform::Mean, _) => Some(0.0),
                _ => None,
            };
            let far = 3.0 * error.unwrap_or(0.0) + 2e-3;
            least
                .filter(|least| value < least - far)
                .map(|_| format!("{value:.4}, below 0 by more than its error"))
        } else {
            Some(format!(
                "the {} of a mean that is not above 0, or over one, at least in one of its leave-one-out ensembles: a spectrum of \
                 almost nothing takes more realisations, one of 0 no other transform than \"mean\"",
                transform.name()
            ))
        };
        reason.map(|reason| Withheld { number: self.wanted.name.clone(), reason })
    }
}

/// The numbers of a layer that is solved as a whole, and those that cannot be.
pub(super) fn numbers(
    study: &Study,
    seen: &Seen,
    uncertainty: &Uncertainty,
) -> (Vec<NumberNote>, Vec<Withheld>) {
    let mut notes = Vec::new();
    let mut withheld = Vec::new();
    let ink = seen.ink.as_ref().map_err(ToString::to_string);
    for wanted in &study.numbers {
        let spectra: Result<Vec<SummedSpectrum>, String> =
            wanted.spectra().map(|light| summed(light, study, (seen, &ink), uncertainty)).collect();
        let spectra = match spectra {
            Ok(spectra) => spectra,
            Err(reason) => {
                withheld.push(Withheld { number: wanted.name.clone(), reason });
                continue;
            }
        };
        let Some(asked) = AskedNumber::new(wanted, &spectra[0].wavelengths_nm) else { continue };
        let (note, reason) = note(&asked, &spectra, seen, uncertainty);
        notes.push(note);
        withheld.extend(reason);
    }
    (notes, withheld)
}

/// The sums of a weighted number of all solves together, without errors.
///
/// # Errors
/// The layer has no such spectrum.
pub fn sums_of_run(wanted: &WantedNumber, study: &Study, seen: &Seen) -> Result<Vec<f64>, String> {
    sums_of(wanted, study, seen, seen.ink.as_ref().map_err(ToString::to_string))
}

/// As [`sums_of_run`], of the layer of `seen` on another paper.
///
/// # Errors
/// The layer has no such spectrum.
pub fn sums_of_ink(
    wanted: &WantedNumber,
    study: &Study,
    seen: &Seen,
    ink: &InkOnPaper,
) -> Result<Vec<f64>, String> {
    sums_of(wanted, study, seen, Ok(ink))
}

fn sums_of(
    wanted: &WantedNumber,
    study: &Study,
    seen: &Seen,
    ink: Result<&InkOnPaper, String>,
) -> Result<Vec<f64>, String> {
    let grid = GridPart::Estimated(GridError::default());
    let exact = Uncertainty { grid, residual: 0.0, missing_cells: 0.0, certain: true };
    let spectra: Vec<SummedSpectrum> =
        wanted.spectra().map(|light| summed(light, study, (seen, &ink), &exact)).collect::<Result<_, _>>()?;
    let asked = AskedNumber::new(wanted, &spectra[0].wavelengths_nm).ok_or("its weights are unknown")?;
    let corrections = corrections(&asked, &spectra);
    let values: Vec<&[f64]> = spectra.iter().map(|spectrum| spectrum.values.as_slice()).collect();
    let mut sums = asked.sums_of(&values);
    sums.iter_mut().zip(&corrections).for_each(|(sum, by)| *sum += by.first().copied().unwrap_or(0.0));
    Ok(sums)
}

/// Spectra of a study's coherent film that weighted numbers take, at wavelengths within its range,
/// nm: \[spectrum\]\[wavelength\].
///
/// # Errors
/// As [`InkOnPaper::homogeneous`].
pub fn film_spectra(
    study: &Study,
    lights: &[SeenLight],
    wavelengths_nm: &[f64],
) -> Result<Vec<Vec<f64>>, InkError> {
    let needs_paper = lights.iter().any(|light| light.on_paper());
    let ink = if needs_paper { Some(film_at(study, wavelengths_nm)?) } else { None };
    let is_on_paper = lights.iter().all(|light| light.on_paper());
    let alone = if is_on_paper { Vec::new() } else { film_totals_at(study, wavelengths_nm) };
    let of = |light: &SeenLight| -> Result<Vec<f64>, InkError> {
        let total = |total: Total| alone.iter().map(|totals| totals[total as usize]).collect();
        match (light, &ink) {
            (SeenLight::Reflectance, _) => Ok(total(Total::Reflectance)),
            (SeenLight::Absorptance, _) => Ok(total(Total::Absorptance)),
            (SeenLight::Transmittance | SeenLight::CoherentTransmittance, _) => {
                Ok(total(Total::Transmittance))
            }
            (_, Some(ink)) if light.on_paper() => {
                let conditions = Conditions::new(ink, sky_of(*light, study))?;
                Ok(ink.spectrum(|layer| on_paper_value(*light, &conditions, layer, UNMOVED)).values)
            }
            // a film scatters nothing
            _ => Ok(vec![0.0; wavelengths_nm.len()]),
        }
    };
    lights.iter().map(of).collect()
}

/// A number with its error.
fn note(
    asked: &AskedNumber,
    spectra: &[SummedSpectrum],
    seen: &Seen,
    uncertainty: &Uncertainty,
) -> (NumberNote, Option<Withheld>) {
    let corrections = corrections(asked, spectra);
    let sums = |place: usize, values: &dyn Fn(&SummedSpectrum) -> Vec<f64>| -> Sums {
        let all: Vec<Vec<f64>> = spectra.iter().map(values).collect();
        let mut sums = asked.sums_of(&all.iter().map(Vec::as_slice).collect::<Vec<_>>());
        sums.iter_mut().zip(&corrections).for_each(|(sum, by)| *sum += by.get(place).copied().unwrap_or(0.0));
        sums
    };
    let whole = sums(0, &|spectrum| spectrum.values.clone());
    let value = asked.number(&whole);
    let replicates: Vec<f64> = (0..spectra[0].replicates.len())
        .map(|r| asked.number(&sums(r + 1, &|spectrum| spectrum.replicates[r].clone())))
        .collect();
    let changed = |changes: &dyn Fn(&SummedSpectrum) -> &[Vec<f64>]| -> f64 {
        let count = spectra.iter().map(|spectrum| changes(spectrum).len()).max().unwrap_or(0);
        let number = |part: usize| {
            let moved = |spectrum: &SummedSpectrum| -> Vec<f64> {
                let Some(by) = changes(spectrum).get(part) else { return spectrum.values.clone() };
                spectrum.values.iter().zip(by).map(|(value, by)| value + by).collect()
            };
            asked.number(&sums(0, &moved)) - value
        };
        (0..count).map(number).fold(0.0, f64::hypot)
    };
    let values: Vec<&[f64]> = spectra.iter().map(|spectrum| spectrum.values.as_slice()).collect();
    let guides: Vec<Option<&Guide>> = spectra.iter().map(|spectrum| spectrum.guide.as_ref()).collect();
    let is_sampled = spectra[0].is_sampled;
    let grid = changed(&|spectrum| &spectrum.shared);
    let wavelengths = asked.wavelength_error(&values, &guides, is_sampled);
    let inputs = changed(&|spectrum| &spectrum.inputs);
    let shared = grid.hypot(wavelengths).hypot(inputs);
    let scattered = uncertainty.widen(Estimate::jackknife(value, &replicates), 0.0).standard_error;
    let estimate = uncertainty.widen(Estimate::jackknife(value, &replicates), shared);
    let impossible = asked.impossible(value, estimate.standard_error);
    let deviations = jackknife_deviations(&replicates.iter().map(|x| [*x]).collect::<Vec<_>>());
    let chance = scattered.unwrap_or(0.0);
    let parts = NumberParts { chance, grid, wavelengths, inputs, ..NumberParts::default() };
    let note = NumberNote {
        name: asked.wanted.name.clone(),
        thickness_um: None,
        value: impossible.is_none().then_some(value),
        standard_error: estimate.standard_error.filter(|_| impossible.is_none()),
        parts: if impossible.is_none() { parts } else { NumberParts::default() },
        deviations: seen.cells.iter().copied().zip(deviations.into_iter().map(|[by]| by)).collect(),
        about: asked.wanted.in_words(),
    };
    (note, impossible)
}

/// What each sum lacks: \[sum\]\[whole ensemble, then each realisation left out\].
fn corrections(asked: &AskedNumber, spectra: &[SummedSpectrum]) -> Vec<Vec<f64>> {
    let of = |spectrum: &SummedSpectrum, table: usize| {
        let table = &asked.weights.tables[table];
        let total = table.total();
        let band = |from: f64, to: f64| table.within([from, to]).map_or(0.0, |part| part.total() / total);
        spectrum.residuals.sums(&band)
    };
    let first = (0..asked.sums.len()).map(|table| of(&spectra[0], table));
    first.chain(spectra.get(1).map(|second| of(second, 0))).collect()
}

/// A spectrum of a layer that is solved as a whole, and of its ink on paper.
fn summed(
    light: SeenLight,
    study: &Study,
    (seen, ink): (&Seen, &Result<&InkOnPaper, String>),
    uncertainty: &Uncertainty,
) -> Result<SummedSpectrum, String> {
    if !light.on_paper() {
        let layer = seen.layer.as_ref().ok_or("no realisation is complete yet")?;
        return layer.summed(light, seen.inputs.as_ref(), uncertainty);
    }
    let ink = ink.clone()?;
    let conditions = Conditions::new(ink, sky_of(light, study)).map_err(|error| error.to_string())?;
    Ok(on_paper(ink, uncertainty, &|layer, by| on_paper_value(light, &conditions, layer, by)))
}

/// The sky under which a spectrum on paper is seen.
fn sky_of(light: SeenLight, study: &Study) -> MirroredSky {
    if light == SeenLight::Albedo { MirroredSky::Included } else { study.output.mirrored_sky }
}

/// A spectrum on paper at one of its wavelengths, shifted by errors of R and T.
fn on_paper_value(light: SeenLight, conditions: &Conditions, layer: &LayerOnPaper, by: Shift) -> f64 {
    match light {
        SeenLight::LitAt45 => conditions.lit_at_45(layer, by),
        _ => conditions.natural_light(layer, by),
    }
}

/// A quantity of the layer on its paper, shifted by errors of R and T.
fn on_paper(
    ink: &InkOnPaper,
    uncertainty: &Uncertainty,
    quantity: &dyn Fn(&LayerOnPaper, Shift) -> f64,
) -> SummedSpectrum {
    let moved: Vec<_> = (0..uncertainty.parts())
        .map(|part| {
            move |layer: &LayerOnPaper| quantity(layer, uncertainty.shift(part, ink.wavelength_nm(layer)))
        })
        .collect();
    let moved: Vec<&dyn Fn(&LayerOnPaper) -> f64> = moved.iter().map(|number| number as _).collect();
    ink.summed(&|layer| quantity(layer, UNMOVED), &moved)
}

#[cfg(test)]
#[path = "numbers_tests.rs"]
mod tests;
