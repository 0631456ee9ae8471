//! The numbers of a composed layer from the flux matrices of its slabs, before their error bars: at
//! every wavelength, as colours and as weighted numbers, of all thicknesses that a study requests.

mod stack;

use super::between::{FilmLayer, FilmStack, Fringes};
use super::distribution::distribution;
use super::layer::ComposedLayer;
use super::level::{Change, Level, Slabs};
use super::medium::medium_numbers;
use super::spectral::{SpectralLayer, brightened, spectral};
use super::stacked::{StackTask, slabs_in};
use crate::appearance::composed::stack::PlateStack;
use crate::appearance::paper::MirroredSky;
use crate::appearance::paper_series::AreaOptics;
use crate::appearance::tristimulus::{Colorimeter, EmissionWeights, Guide, visible};
use crate::appearance::viewing::Viewing;
use crate::evaluate::ink_maker::in_light_of;
use crate::evaluate::numbers::AskedNumber;
use crate::evaluate::prints::{Brightened, PrintTask};
use crate::evaluate::quantities::{
    ColourNumbers, ComposedNumbers, HidingNumbers, LayerNumbers, ThicknessNumbers,
};
use crate::input::file::SeenLight;
use crate::input::study::{Composed, Study};
use std::ops::Range;

/// Contrast ratio that counts as hiding.
const HIDING: f64 = 0.98;

/// What is evaluated of a composed layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LayerExtent {
    /// All that is published; colours under D65.
    Published,
    /// The requested thicknesses on their paper alone, under the study's own light and observer or
    /// under D65.
    Print { own_light: bool },
}

/// What is requested of the slabs of either thickness.
pub struct LayerTask<'a> {
    /// The study.
    pub study: &'a Study,
    /// Its composed layer.
    pub composed: &'a Composed,
    /// The stack, if it is one.
    pub stack: Option<StackTask<'a>>,
    /// Albedos of the paper at every wavelength.
    pub albedos: Vec<f64>,
    /// Indices of the wavelengths that colours can take.
    pub visible: Range<usize>,
    /// The eye, where these wavelengths carry a colour.
    pub colorimeter: Option<Colorimeter>,
    /// The weighted numbers that the study asks for.
    pub weighted: Vec<AskedNumber<'a>>,
    /// Its prints, where there are any besides the solid on plain paper.
    pub prints: Option<PrintTask<'a>>,
    /// The paper under D65, where it fluoresces.
    pub daylight: Option<Brightened>,
    /// How the eye sums what the paper emits under a lamp with lines.
    emission: Option<EmissionWeights>,
    /// Thicknesses of the curve, µm.
    pub curve_um: Vec<f64>,
    /// The thicknesses of whole slabs on both sides of the one that hides, µm; none if none does.
    pub around_hiding_um: Option<[f64; 2]>,
    extent: LayerExtent,
}

impl<'a> LayerTask<'a> {
    /// What a study asks of its composed layer.
    ///
    /// # Errors
    /// A layer that is not composed, paper without an albedo.
    pub fn new(study: &'a Study) -> Result<Self, String> {
        Self::under(study, &Viewing::default(), LayerExtent::Published)
    }

    /// What designs ask: the requested thicknesses on their paper alone, under the study's own
    /// light and observer (`own_light`) or under D65, as weighted numbers are.
    ///
    /// # Errors
    /// As [`LayerTask::new`].
    pub fn of_print(study: &'a Study, own_light: bool) -> Result<Self, String> {
        let daylight = Viewing::default();
        let viewing = if own_light { &study.judgement.viewing } else { &daylight };
        let task = Self::under(study, viewing, LayerExtent::Print { own_light })?;
        let light = if own_light { in_light_of(study).map_err(|e| e.to_string())? } else { task.daylight };
        let light_and_eye = light.as_ref().zip(task.colorimeter.as_ref());
        let emission = light_and_eye.and_then(|(light, eye)| light.emission(eye, &study.wavelengths_nm));
        Ok(Self { prints: None, daylight: light, emission, ..task })
    }

    fn under(study: &'a Study, viewing: &Viewing, extent: LayerExtent) -> Result<Self, String> {
        let composed = study.composed().ok_or("the layer is not composed")?;
        let albedo = |&nm: &f64| study.paper.albedo.at(nm).map_err(|error| error.to_string());
        let visible = visible(&study.wavelengths_nm);
        Ok(Self {
            study,
            composed,
            stack: StackTask::new(study),
            albedos: study.wavelengths_nm.iter().map(albedo).collect::<Result<_, _>>()?,
            colorimeter: Colorimeter::under(&study.wavelengths_nm[visible.clone()], viewing).ok(),
            visible,
            weighted: study
                .numbers
                .iter()
                .filter_map(|wanted| AskedNumber::new(wanted, &study.wavelengths_nm))
                .collect(),
            prints: PrintTask::new(study),
            daylight: Brightened::new(&study.paper, &study.wavelengths_nm, viewing, 0.0),
            emission: None,
            curve_um: Vec::new(),
            around_hiding_um: None,
            extent,
        })
    }

    /// What this asks, of the layer of another study that differs in its indices alone.
    ///
    /// # Errors
    /// Those of [`LayerTask::new`].
    pub fn of_study<'b>(&self, study: &'b Study) -> Result<LayerTask<'b>, String> {
        let task = match self.extent {
            LayerExtent::Published => LayerTask::new(study)?,
            LayerExtent::Print { own_light } => LayerTask::of_print(study, own_light)?,
        };
        let curve_um = self.curve_um.clone();
        Ok(LayerTask { curve_um, around_hiding_um: self.around_hiding_um, ..task })
    }

    /// All numbers, of slabs of either thickness.
    pub fn numbers(&self, level: &Level, change: Change) -> ComposedNumbers<f64> {
        if let Some(stack) = &self.stack {
            return self.numbers_of_stack(stack, level, change);
        }
        let slabs = level.slabs(change);
        let per_h = (self.composed.slab_um / level.slab_um).round();
        let requested_um = &self.composed.thicknesses_um;
        let layers = |all_um: &[f64]| all_um.iter().map(|um| self.layer(&slabs, *um, per_h)).collect();
        let distributions = |um: &f64| {
            let count = self.slab_count(*um) * per_h;
            slabs
                .iter()
                .map(|slabs| distribution(&slabs.layer(count), [&slabs.media[0], &slabs.media[2]]))
                .collect()
        };
        if self.extent != LayerExtent::Published {
            return ComposedNumbers::of_requested(layers(requested_um));
        }
        ComposedNumbers {
            requested: layers(requested_um),
            curve: layers(&self.curve_um),
            hiding: self.around_hiding_um.map(|around_um| self.hiding(&slabs, around_um, per_h)),
            medium: slabs.iter().map(|slabs| medium_numbers(slabs, level.slab_um)).collect(),
            distributions: requested_um.iter().map(distributions).collect(),
            absorbed: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// A layer or stack of one thickness as light between it and its paper meets it, at every
    /// wavelength; `None` where a stack lacks a portion.
    pub(super) fn optics(&self, level: &Level, change: Change, thickness_um: f64) -> Option<Vec<AreaOptics>> {
        let wave = self.study.wave;
        let sky = self.study.output.mirrored_sky;
        let at_45 = |layer: &ComposedLayer, albedo: f64| spectral(layer, wave, sky, albedo).at_45;
        let Some(task) = &self.stack else {
            let per_h = (self.composed.slab_um / level.slab_um).round();
            let count = self.slab_count(thickness_um) * per_h;
            let slabs = level.slabs(change);
            let of_slabs =
                |(slabs, albedo): (&Slabs, &f64)| at_45(&ComposedLayer::new(slabs, count, wave), *albedo);
            return Some(slabs.iter().zip(&self.albedos).map(of_slabs).collect());
        };
        let stacks = task.stacks(level, thickness_um, change).ok()?;
        let of_stack = |(stack, albedo): (&PlateStack, &f64)| {
            let film = stack.film(change.fewer_directions);
            at_45(&ComposedLayer::of_stack(stack, &film, wave), *albedo)
        };
        Some(stacks.iter().zip(&self.albedos).map(of_stack).collect())
    }

    /// A layer of one thickness; `per_h` of the slabs have the thickness h.
    fn layer(&self, slabs: &[Slabs], thickness_um: f64, per_h: f64) -> ThicknessNumbers<f64> {
        self.coloured(self.with_optics(slabs, thickness_um, per_h))
    }

    /// Spectra with their colours, weighted numbers and prints.
    fn coloured(&self, all: Vec<SpectralLayer>) -> ThicknessNumbers<f64> {
        let optics: Vec<AreaOptics> = all.iter().map(|layer| layer.at_45).collect();
        let seen = &all[self.visible.clone()];
        let colours = self
            .colorimeter
            .as_ref()
            .map(|eye| colours_of(eye, self.emission.as_ref(), seen).unwrap_or(ColourNumbers::unknown()));
        let spectra: Vec<LayerNumbers<f64>> = all.into_iter().map(|layer| layer.numbers).collect();
        let weighted = self.weighted.iter().map(|asked| self.weighted_number(asked, &spectra)).collect();
        let prints = self.prints.as_ref().map_or(Vec::new(), |prints| prints.numbers(&optics));
        ThicknessNumbers { spectra, colours, weighted, prints }
    }

    /// A weighted number of the layer.
    fn weighted_number(&self, asked: &AskedNumber, rows: &[LayerNumbers<f64>]) -> f64 {
        let spectra = self.weighted_spectra(asked, rows);
        asked.of(&spectra.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// Even films in place of the layer or stack, of which one layer may have several thicknesses.
    pub(super) fn films(&self, thickness_um: f64) -> FilmStack {
        let Study { wave, layer, output, .. } = self.study;
        let layers = match &self.stack {
            Some(stack) => stack.films(thickness_um),
            None => {
                let index = |nm: &f64| self.study.embedding_index(1e-3 * nm);
                let indices = self.study.wavelengths_nm.iter().map(index).collect();
                vec![FilmLayer { indices, thickness_um }]
            }
        };
        FilmStack {
            layers,
            index_out: layer.index_out,
            wave: *wave,
            excludes_mirrored: output.mirrored_sky == MirroredSky::Excluded,
        }
    }

    /// What fringes change of the spectra that a weighted number takes, for films a quarter of a
    /// fringe apart.
    pub(super) fn weighted_films(&self, asked: &AskedNumber, fringes: &Fringes) -> [Vec<Guide>; 2] {
        let is_excluded = self.study.output.mirrored_sky == MirroredSky::Excluded;
        let all = 0..self.study.wavelengths_nm.len();
        let guides = |light: SeenLight| fringes.guides(all.clone(), |row| row.seen(light, is_excluded));
        asked.wanted.spectra().map(guides).map(|[film, quarter]| (film, quarter)).unzip().into()
    }

    /// The spectra that a weighted number takes.
    pub(super) fn weighted_spectra(&self, asked: &AskedNumber, rows: &[LayerNumbers<f64>]) -> Vec<Vec<f64>> {
        let is_excluded = self.study.output.mirrored_sky == MirroredSky::Excluded;
        let of = |light: SeenLight| rows.iter().map(|row| row.seen(light, is_excluded)).collect();
        asked.wanted.spectra().map(of).collect()
    }

    /// Its numbers with what light between the layer and its paper meets, and what the paper emits.
    fn with_optics(&self, slabs: &[Slabs], thickness_um: f64, per_h: f64) -> Vec<SpectralLayer> {
        let count = self.slab_count(thickness_um) * per_h;
        let Study { wave, output, .. } = self.study;
        let at_wavelength = |(slabs, albedo): (&Slabs, &f64)| {
            spectral(&ComposedLayer::new(slabs, count, *wave), *wave, output.mirrored_sky, *albedo)
        };
        self.brightened(slabs.iter().zip(&self.albedos).map(at_wavelength).collect())
    }

    /// Layers at every wavelength, with what the paper below them emits.
    fn brightened(&self, all: Vec<SpectralLayer>) -> Vec<SpectralLayer> {
        match &self.daylight {
            Some(daylight) => brightened(all, daylight, &self.study.wavelengths_nm, &self.albedos),
            None => all,
        }
    }

    /// The layers on both sides of the thickness that hides, and that thickness, where the contrast
    /// ratio passes what counts as hiding; 1 less it falls as an exponential.
    fn hiding(&self, slabs: &[Slabs], [from_um, to_um]: [f64; 2], per_h: f64) -> HidingNumbers<f64> {
        let below = self.layer(slabs, from_um, per_h);
        let above = self.layer(slabs, to_um, per_h);
        let exponent = |layer: &ThicknessNumbers<f64>| {
            let contrast_ratio = layer.colours.map_or(f64::NAN, |colours| colours.contrast_ratio);
            (1.0 - contrast_ratio).max(f64::MIN_POSITIVE).ln()
        };
        let at_from = exponent(&below);
        let at_to = exponent(&above);
        let thickness_um = from_um + (to_um - from_um) * ((1.0 - HIDING).ln() - at_from) / (at_to - at_from);
        HidingNumbers { below, above, thickness_um }
    }

    /// Whether a layer of this number of slabs hides; `None` if it has no colour.
    pub fn does_hide(&self, slabs: &[Slabs], count: usize) -> Option<bool> {
        let layer = self.with_optics(slabs, count as f64 * self.composed.slab_um, 1.0);
        let seen = &layer[self.visible.clone()];
        Some(colours_of(self.colorimeter.as_ref()?, None, seen)?.contrast_ratio >= HIDING)
    }

    /// Slabs of h in a thickness: a whole number but for rounding, or any.
    pub(super) fn slab_count(&self, thickness_um: f64) -> f64 {
        slabs_in(thickness_um, self.composed.slab_um)
    }
}

impl LayerNumbers<f64> {
    /// What a weighted number takes of the layer; `is_excluded` if natural light lacks what the
    /// layer mirrors.
    fn seen(&self, light: SeenLight, is_excluded: bool) -> f64 {
        match light {
            SeenLight::Albedo if is_excluded => self.natural_light + self.mirrored,
            SeenLight::Albedo | SeenLight::NaturalLight => self.natural_light,
            SeenLight::LitAt45 => self.lit_at_45,
            SeenLight::Reflectance => self.reflectance_normal,
            SeenLight::Transmittance => self.transmittance_normal,
            SeenLight::Absorptance => 1.0 - self.reflectance_normal - self.transmittance_normal,
            SeenLight::CoherentTransmittance => self.coherent_transmittance,
            SeenLight::ScatteredTransmittance => self.transmittance_normal - self.coherent_transmittance,
        }
    }
}

/// Colours of a layer from its visible spectra; `None` if one of them has none. `emission` is how
/// light is summed that the paper emits under a lamp with lines.
pub(super) fn colours_of(
    eye: &Colorimeter,
    emission: Option<&EmissionWeights>,
    seen: &[SpectralLayer],
) -> Option<ColourNumbers<f64>> {
    let xyz_of = |spectrum: &dyn Fn(&SpectralLayer) -> f64| {
        eye.xyz(&seen.iter().map(spectrum).collect::<Vec<_>>()).ok()
    };
    let beyond = |light: usize| {
        let Some(weights) = emission else { return Some([0.0; 3]) };
        let part = |layer: &SpectralLayer| layer.emitted[light];
        let whole = weights.xyz(&seen.iter().map(part).collect::<Vec<_>>());
        let as_factors = xyz_of(&part)?;
        Some(std::array::from_fn(|c| whole[c] - as_factors[c]))
    };
    let beyond_factors: [[f64; 3]; 2] = [beyond(0)?, beyond(1)?];
    let lab =
        |[x, y, z]: [f64; 3], [by_x, by_y, by_z]: [f64; 3]| eye.colour_of([x + by_x, y + by_y, z + by_z]).lab;
    let over_black = xyz_of(&|layer| layer.numbers.over_black)?;
    let over_white = xyz_of(&|layer| layer.numbers.over_white)?;
    Some(ColourNumbers {
        natural_light: lab(xyz_of(&|layer| layer.numbers.natural_light)?, beyond_factors[0]),
        lit_at_45: lab(xyz_of(&|layer| layer.numbers.lit_at_45)?, beyond_factors[1]),
        over_black: eye.colour_of(over_black).lab,
        contrast_ratio: over_black[1] / over_white[1],
        beyond_factors,
    })
}
