//! The main numbers of a print, as sweeps and designs read them, whichever evaluator made them: the
//! layer on its paper; of a composed study, the layer of the first thickness.

use super::{ColourNote, Manifest, NATURAL_LIGHT, PublishedColours, PublishedSpectra, SpectrumRow};
use crate::appearance::colour::Colour;
use crate::evaluate::ink_maker::Target;
use crate::evaluate::manifest::composed::{ComposedColours, ComposedRow, MediumRow};
use crate::evaluate::published::ErrorParts;
use crate::numerics::estimate::Estimate;
use serde::{Deserialize, Serialize};

/// Contributions of the realisations to a number, by the number of the realisation.
pub type Deviations<T> = Vec<(usize, T)>;

/// The main numbers of a print. Numbers of the same realisations have correlated errors; those of a
/// composed layer, whose slabs have realisations of their own, count as independent of others.
#[derive(Clone, Debug, Default)]
pub struct MainNumbers {
    /// Number of complete realisations, of the slab that has fewest where the layer is composed.
    pub realisations: usize,
    /// Colour under natural light, viewed along the normal.
    pub colour: Option<Colour>,
    /// Contribution of each realisation to its Lab.
    pub lab_deviations: Deviations<[f64; 3]>,
    /// Contrast ratio (Y over black divided by Y over white), with the contribution of each
    /// realisation.
    pub contrast: Option<(Estimate, Deviations<f64>)>,
    /// The difference to the study's target colour.
    pub target: Option<Target>,
    /// `#rrggbb` of the layer on its paper, as screens show it.
    pub hex: Option<String>,
    /// One row per wavelength and angle.
    pub spectra: Vec<PrintRow>,
    /// The packed medium at every wavelength, of a composed layer.
    pub medium: Vec<MediumRow>,
    /// Thickness that hides, µm, of a composed layer.
    pub hiding_thickness_um: Option<Estimate>,
}

/// A print at one wavelength and angle of incidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PrintRow {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Polar angle, degrees.
    pub polar_deg: f64,
    /// R of the layer without paper.
    pub reflectance: Estimate,
    /// T of the layer without paper.
    pub transmittance: Estimate,
    /// On the paper under a uniform sky, viewed along the normal (white diffuser: 1).
    pub natural_light: Option<Estimate>,
    /// On the paper, π × BRDF lit at 45° and viewed along the normal.
    pub lit_at_45: Option<Estimate>,
    /// Contribution of each realisation to R and T.
    pub deviations: Deviations<[f64; 2]>,
}

impl Manifest<'_> {
    /// The main numbers of the print.
    pub fn main_numbers(&self) -> MainNumbers {
        let maker = self.ink_maker.as_ref();
        let slabs = self.slabs.as_ref();
        let of_colours = match &self.colours {
            PublishedColours::Whole(notes) => {
                let natural = notes.iter().find(|note| note.conditions == NATURAL_LIGHT);
                natural.map(MainNumbers::of_note).unwrap_or_default()
            }
            PublishedColours::Composed(all) => all.first().map(MainNumbers::of_first).unwrap_or_default(),
        };
        let contrast = maker.map(|maker| (maker.contrast_ratio, maker.contrast_deviations.clone()));
        MainNumbers {
            realisations: self.realisations(),
            contrast: contrast.or(of_colours.contrast),
            target: maker.and_then(|maker| maker.target.clone()),
            hex: maker.map(|maker| maker.print.hex.clone()).or(of_colours.hex),
            spectra: self.print_rows(),
            medium: slabs.map(|slabs| slabs.medium.clone()).unwrap_or_default(),
            hiding_thickness_um: slabs.and_then(|slabs| Some(slabs.hiding_thickness_um?.estimate())),
            ..of_colours
        }
    }

    fn realisations(&self) -> usize {
        let of_ensemble = self.ensemble.as_ref().map(|ensemble| ensemble.realisations.finished);
        of_ensemble.or(self.slabs.as_ref().map(|slabs| slabs.realisations)).unwrap_or(0)
    }

    fn print_rows(&self) -> Vec<PrintRow> {
        match &self.spectra {
            PublishedSpectra::Whole(rows) => rows.iter().map(PrintRow::of_whole).collect(),
            PublishedSpectra::Composed(rows) => {
                let first = rows.first().map(|row| row.thickness_um);
                let of_first = rows.iter().take_while(|row| Some(row.thickness_um) == first);
                of_first.filter_map(PrintRow::of_composed).collect()
            }
        }
    }
}

impl MainNumbers {
    fn of_note(note: &ColourNote) -> Self {
        Self { colour: Some(note.colour), lab_deviations: note.deviations.clone(), ..Self::default() }
    }

    fn of_first(colours: &ComposedColours) -> Self {
        let contrast = colours.contrast_ratio.map(|ratio| (ratio.estimate(), Vec::new()));
        Self { colour: colours.colour, contrast, hex: colours.hex.clone(), ..Self::default() }
    }
}

impl PrintRow {
    fn of_whole(row: &SpectrumRow) -> Self {
        Self {
            wavelength_nm: row.wavelength_nm,
            polar_deg: row.polar_deg,
            reflectance: row.reflectance,
            transmittance: row.transmittance,
            natural_light: row.natural_light,
            lit_at_45: row.lit_at_45,
            deviations: row.deviations.clone(),
        }
    }

    /// At 0°; `None` where R or T is withheld.
    fn of_composed(row: &ComposedRow) -> Option<Self> {
        let estimate = |number: Option<ErrorParts>| number.map(|number| number.estimate());
        Some(Self {
            wavelength_nm: row.wavelength_nm,
            polar_deg: 0.0,
            reflectance: estimate(row.layer.reflectance_normal)?,
            transmittance: estimate(row.layer.transmittance_normal)?,
            natural_light: estimate(row.layer.natural_light),
            lit_at_45: estimate(row.layer.lit_at_45),
            deviations: Vec::new(),
        })
    }
}
