//! The result of one variant, finished or not.

use crate::appearance::colour::Colour;
use crate::appearance::picture::ScreenPicture;
use crate::evaluate::ink_maker::Target;
use crate::evaluate::manifest::composed::MediumRow;
use crate::evaluate::manifest::main_numbers::PrintRow;
use crate::evaluate::manifest::{Count, FailureNote, Manifest};
use crate::evaluate::published::NumberNote;
use crate::input::study::Study;
use crate::numerics::estimate::{Estimate, Linked};
use crate::sweep::definition::file::MeasuredQuantity;
use crate::sweep::definition::load::Sweep;
use crate::work::variant::Variant;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The numbers of a variant for tables and conclusions.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the variant.
    pub name: String,
    /// Captions of its settings on every axis.
    pub labels: Vec<String>,
    /// Requested and finished solves.
    pub solves: Count,
    /// Number of failures: solves, packings and grids.
    pub failures: usize,
    /// Why there are no results, if so.
    pub reason: Option<String>,
    /// Number of complete realisations.
    pub realisations: usize,
    /// True if there is no randomness, because there are no grains.
    pub certain: bool,
    /// Colour under natural light, viewed along the normal.
    pub colour: Option<Colour>,
    /// Contribution of each realisation to Lab, by its number.
    pub lab_deviations: BTreeMap<usize, [f64; 3]>,
    /// Contrast ratio (Y over black divided by Y over white), with the number and contribution of
    /// each realisation.
    pub contrast: Option<(Estimate, Vec<(usize, f64)>)>,
    /// Weighted numbers.
    pub numbers: Vec<NumberNote>,
    /// The target colour in words, if the study sets one.
    pub aim: Option<String>,
    /// The difference to it.
    pub target: Option<Target>,
    /// `#rrggbb` of the print, adapted to the illuminant.
    pub print_hex: Option<String>,
    /// One row per wavelength and angle.
    pub spectra: Vec<PrintRow>,
    /// The picture for contact sheets, where there is paper.
    pub picture: Option<ScreenPicture>,
    /// The packed medium at every wavelength, of a composed layer; not kept with its page.
    #[serde(skip)]
    pub medium: Vec<MediumRow>,
    /// Thickness that hides, µm, of a composed layer.
    pub hiding_thickness_um: Option<Estimate>,
}

impl Outcome {
    /// A variant without any results yet.
    pub fn nothing(sweep: &Sweep, number: usize) -> Self {
        let outline = &sweep.outline;
        let labels = outline.axes.iter().zip(&outline.variants[number].place);
        let labels = labels.map(|(axis, &k)| axis.labels[k].clone()).collect();
        Self::of_study(&sweep.variants[number], labels)
    }

    /// A study of these labels without any results yet.
    pub fn of_study(Variant { name, study }: &Variant, labels: Vec<String>) -> Self {
        Self {
            name: name.clone(),
            labels,
            solves: Count { asked: study.solves(), finished: 0 },
            failures: 0,
            reason: None,
            realisations: 0,
            certain: study.pigments.is_empty() && study.variation.thickness_std_um == 0.0,
            colour: None,
            lab_deviations: BTreeMap::new(),
            contrast: None,
            numbers: Vec::new(),
            aim: study.judgement.target_lab.map(|lab| target_in_words(lab, study)),
            target: None,
            print_hex: None,
            spectra: Vec::new(),
            picture: None,
            medium: Vec::new(),
            hiding_thickness_um: None,
        }
    }

    /// Whether every solve is finished.
    pub fn is_complete(&self) -> bool {
        self.solves.finished == self.solves.asked
    }

    /// Adds the numbers of a variant's manifest.
    pub fn with(self, manifest: &Manifest) -> Self {
        let main = manifest.main_numbers();
        Self {
            solves: manifest.solves,
            failures: manifest.failures.len(),
            reason: manifest.failures.first().map(FailureNote::reason).map(str::to_owned),
            realisations: main.realisations,
            colour: main.colour,
            lab_deviations: main.lab_deviations.into_iter().collect(),
            contrast: main.contrast,
            numbers: manifest.numbers.clone(),
            target: main.target,
            print_hex: main.hex,
            spectra: main.spectra,
            medium: main.medium,
            hiding_thickness_um: main.hiding_thickness_um,
            ..self
        }
    }

    /// One number, if available, with its error and the contribution of each realisation. An
    /// unfinished variant counts with its complete realisations; without uncertainty the number is
    /// exact.
    pub fn quantity(&self, quantity: MeasuredQuantity, wavelength_nm: Option<f64>) -> Option<Linked> {
        let of_lab = |estimate: Estimate, gradient: [f64; 3]| {
            let deviations = self.lab_deviations.iter();
            self.linked(estimate, deviations.map(|(&r, by)| (r, (0..3).map(|i| gradient[i] * by[i]).sum())))
        };
        let of_row = |number: fn(&PrintRow) -> Estimate, place: usize| {
            let row = self.row(wavelength_nm)?;
            Some(self.linked(number(row), row.deviations.iter().map(|(r, by)| (*r, by[place]))))
        };
        let colour = self.colour.as_ref();
        match quantity {
            MeasuredQuantity::Chroma => colour.map(|c| of_lab(c.chroma(), c.chroma_gradient())),
            MeasuredQuantity::Hue => colour.map(|c| of_lab(c.hue_deg(), c.hue_gradient())),
            MeasuredQuantity::Lightness => colour.map(|c| of_lab(lab(c, 0), [1.0, 0.0, 0.0])),
            MeasuredQuantity::Transmittance => of_row(|row| row.transmittance, 1),
            MeasuredQuantity::Reflectance => of_row(|row| row.reflectance, 0),
            MeasuredQuantity::ContrastRatio => {
                let (ratio, deviations) = self.contrast.as_ref()?;
                Some(self.linked(*ratio, deviations.iter().copied()))
            }
            MeasuredQuantity::DeltaEToTarget => self.to_target(),
            MeasuredQuantity::DeltaE | MeasuredQuantity::Number => None,
        }
    }

    /// The weighted number of this name, of a composed layer of its first thickness.
    pub fn weighted(&self, name: &str) -> Option<Linked> {
        let note = self.numbers.iter().find(|note| note.name == name)?;
        Some(self.linked(note.estimate()?, note.deviations.iter().copied()))
    }

    fn row(&self, wavelength_nm: Option<f64>) -> Option<&PrintRow> {
        let nm = wavelength_nm.filter(|_| self.realisations > 0)?;
        self.spectra.iter().find(|row| (row.wavelength_nm - nm).abs() < 1e-6)
    }

    /// ΔE₀₀ to the target colour.
    pub fn to_target(&self) -> Option<Linked> {
        let target = self.target.as_ref()?;
        Some(self.linked(target.delta_e_2000, target.deviations.iter().copied()))
    }

    fn linked(&self, estimate: Estimate, deviations: impl Iterator<Item = (usize, f64)>) -> Linked {
        let standard_error = estimate.standard_error.or(self.certain.then_some(0.0));
        Linked { estimate: Estimate { standard_error, ..estimate }, deviations: deviations.collect() }
    }

    /// Rows of the first angle, one per wavelength, as shown by curves.
    pub fn at_first_angle(&self) -> &[PrintRow] {
        let first = self.spectra.first().map(|row| row.polar_deg);
        &self.spectra[..self.spectra.iter().take_while(|row| Some(row.polar_deg) == first).count()]
    }

    /// ΔE₀₀ to another variant's colour. Realisations with the same number have the same cells,
    /// directions and wavelengths, and often the same packings, so their errors are correlated; a
    /// colour without uncertainty is exact.
    pub fn difference(&self, other: &Self) -> Option<Linked> {
        let colour = |o: &Self| {
            let exact = o.certain.then_some([[0.0; 3]; 3]);
            o.colour.map(|c| Colour { lab_covariance: c.lab_covariance.or(exact), ..c })
        };
        let here = colour(self)?;
        let there = colour(other)?;
        let [by_here, by_there] = here.delta_e_2000_gradients(&there);
        let mut common = [[0.0; 3]; 3];
        let mut deviations = BTreeMap::new();
        for realisation in self.lab_deviations.keys().chain(other.lab_deviations.keys()) {
            let deviation = |o: &Self| o.lab_deviations.get(realisation).copied().unwrap_or_default();
            let a = deviation(self);
            let b = deviation(other);
            deviations.insert(*realisation, (0..3).map(|i| by_here[i] * a[i] + by_there[i] * b[i]).sum());
        }
        for (realisation, a) in &self.lab_deviations {
            let b = other.lab_deviations.get(realisation).copied().unwrap_or_default();
            (0..9).for_each(|k| common[k / 3][k % 3] += a[k / 3] * b[k % 3]);
        }
        Some(Linked { estimate: here.delta_e_2000_among(&there, &common), deviations })
    }
}

/// L*, a* or b* (`i` = 0, 1, 2) with its error.
pub fn lab(colour: &Colour, i: usize) -> Estimate {
    Estimate { value: colour.lab[i], standard_error: colour.lab_standard_error().map(|e| e[i]) }
}

/// Formats a target: `L* 70, a* 5, b* −40 (D65, 2° observer)`.
fn target_in_words(lab: [f64; 3], study: &Study) -> String {
    let [l, a, b] = lab.map(|x| x.to_string().replace('-', "−"));
    format!("L* {l}, a* {a}, b* {b} ({})", study.judgement.viewing.name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::tristimulus::Colorimeter;

    /// A yellow with two realisations that move b* by ± `by`, and an independent variance of 0.01
    /// in L*.
    fn outcome(values: [f64; 4], by: f64) -> Outcome {
        let meter = Colorimeter::new(&[400.0, 500.0, 600.0, 700.0]).unwrap();
        let mut covariance = [[0.0; 3]; 3];
        (covariance[0][0], covariance[2][2]) = (0.01, 2.0 * by * by);
        let colour = Colour { lab_covariance: Some(covariance), ..meter.colour(&values).unwrap() };
        Outcome {
            name: "yellow".into(),
            labels: Vec::new(),
            solves: Count { asked: 2, finished: 2 },
            failures: 0,
            reason: None,
            realisations: 2,
            certain: false,
            colour: Some(colour),
            lab_deviations: [(0, [0.0, 0.0, by]), (1, [0.0, 0.0, -by])].into(),
            contrast: None,
            numbers: Vec::new(),
            aim: None,
            target: None,
            print_hex: None,
            spectra: Vec::new(),
            picture: None,
            medium: Vec::new(),
            hiding_thickness_um: None,
        }
    }

    #[test]
    fn realisations_in_common_move_both_colours() {
        let (pale, deep) = ([0.5, 0.8, 0.9, 0.9], [0.2, 0.6, 0.9, 0.9]);
        let error = |a: &Outcome, b: &Outcome| a.difference(b).unwrap().estimate.standard_error.unwrap();
        let [together, apart] = [0.3, -0.3].map(|by| error(&outcome(pale, 0.3), &outcome(deep, by)));
        let other_draws = Outcome { lab_deviations: BTreeMap::new(), ..outcome(deep, 0.3) };
        let independent = error(&outcome(pale, 0.3), &other_draws);
        assert!(
            together < 0.5 * independent && independent < 0.8 * apart,
            "{together} {independent} {apart}"
        );
        // the realisations contribute all of the error except L*'s own part
        let linked = outcome(pale, 0.3).difference(&outcome(deep, -0.3)).unwrap();
        let own = apart * apart - linked.chance_variance();
        assert!(own > 0.0 && own < 0.02 && linked.deviations.len() == 2, "{own}");
    }

    #[test]
    fn chroma_and_hue_have_the_errors_of_their_colour() {
        let yellow = outcome([0.5, 0.8, 0.9, 0.9], 0.3);
        for quantity in [MeasuredQuantity::Chroma, MeasuredQuantity::Hue] {
            let number = yellow.quantity(quantity, None).unwrap();
            let error = number.estimate.standard_error.unwrap();
            // without the error of L* the realisations contribute all of it; gradients are accurate
            // to 1e-6
            assert!((number.chance_variance().sqrt() / error - 1.0).abs() < 1e-5, "{quantity:?} {number:?}");
        }
        let lightness = yellow.quantity(MeasuredQuantity::Lightness, None).unwrap();
        assert_eq!((lightness.chance_variance(), lightness.estimate.standard_error), (0.0, Some(0.1)));
    }
}
