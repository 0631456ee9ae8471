//! The numbers of a composed layer from the flux matrices of its slabs, before their error bars.

use super::layer::{ComposedLayer, OnPaper, polarised, ratio};
use super::level::{Change, Level, Slabs};
use super::stacked::{KeptLayers, StackTask, slabs_in};
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::plate::{Plate, total};
use crate::appearance::composed::stack::{PlateStack, StackElement};
use crate::appearance::composed::transport::{Transport, extinction_per_um, two_flux};
use crate::appearance::paper::{MirroredSky, PRINT_DEG};
use crate::appearance::paper_series::{AreaMix, AreaOptics};
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::appearance::viewing::Viewing;
use crate::evaluate::ink_maker::{BLACK, WHITE, in_light_of};
use crate::evaluate::numbers::AskedNumber;
use crate::evaluate::prints::{Brightened, PrintTask};
use crate::evaluate::quantities::{
    ColourNumbers, ComposedNumbers, DensityNumbers, Distribution, HidingNumbers, LayerNumbers,
    LeftOutNumbers, MediumNumbers, ThicknessNumbers,
};
use crate::input::file::SeenLight;
use crate::input::study::{Composed, Study};
use crate::wave::Wave;
use faer::Mat;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// Contrast ratio that counts as hiding.
pub const HIDING: f64 = 0.98;
/// Most slabs of a layer that is tried for hiding.
pub const MOST_SLABS: usize = 1024;

/// A stack of one thickness.
struct StackNumbers {
    thickness: ThicknessNumbers<f64>,
    /// \[wavelength\]
    distributions: Vec<Distribution<f64>>,
    /// \[wavelength\]\[layer\]
    absorbed: Vec<Vec<f64>>,
}

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
        Ok(Self { prints: None, daylight: light, ..task })
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
            medium: slabs.iter().map(|slabs| coefficients(slabs, level.slab_um)).collect(),
            distributions: requested_um.iter().map(distributions).collect(),
            absorbed: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// All numbers of a stack.
    fn numbers_of_stack(&self, task: &StackTask, level: &Level, change: Change) -> ComposedNumbers<f64> {
        let mut numbers = ComposedNumbers::of_requested(Vec::new());
        for um in &self.composed.thicknesses_um {
            // joints and portions are those of the report's first look at them
            let layers = task.layers(level, *um, change).unwrap_or_default();
            let of = |kept: KeptLayers| self.of_stack(task, kept, &layers, change);
            let all = of(KeptLayers::All);
            if self.extent != LayerExtent::Published {
                numbers.requested.push(all.thickness);
                continue;
            }
            numbers.left_out.extend(self.left_out(&all.thickness.spectra, |kept| of(kept).thickness));
            numbers.requested.push(all.thickness);
            numbers.distributions.push(all.distributions);
            numbers.absorbed.push(all.absorbed);
        }
        numbers
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

    /// The numbers of some of a stack's layers.
    fn of_stack(
        &self,
        task: &StackTask,
        kept: KeptLayers,
        layers: &[Vec<Vec<StackElement>>],
        change: Change,
    ) -> StackNumbers {
        let stacks = task.joined(kept, layers).unwrap_or_default();
        let Study { wave, output, .. } = self.study;
        let at_wavelength = |(stack, albedo): (&PlateStack, &f64)| {
            let film = stack.film(change.fewer_directions);
            let layer = ComposedLayer::of_stack(stack, &film, *wave);
            let own = spectral(&layer, *wave, output.mirrored_sky, *albedo);
            let absorbed = match kept {
                KeptLayers::All => absorbed_by_layers(stack, *wave, &own.numbers),
                _ => Vec::new(),
            };
            (own, distribution(&layer.plate, layer.media), absorbed)
        };
        let all = stacks.par_iter().zip(&self.albedos).map(at_wavelength).collect::<Vec<_>>();
        let mut layers = Vec::new();
        let mut distributions = Vec::new();
        let mut absorbed = Vec::new();
        for (own, distribution, shares) in all {
            layers.push(own);
            distributions.push(distribution);
            absorbed.push(shares);
        }
        StackNumbers { thickness: self.coloured(self.brightened(layers)), distributions, absorbed }
    }

    /// What a stack of several layers is without each of them, and each by itself, where it has
    /// these spectra and `of` gives some of its layers.
    fn left_out(
        &self,
        stack: &[LayerNumbers<f64>],
        of: impl Fn(KeptLayers) -> ThicknessNumbers<f64>,
    ) -> Option<LeftOutNumbers<f64>> {
        let layers = self.study.stack.len();
        // plates of a library are no print: what any stack of them is, `inkwave compose` tells
        if layers < 2 || self.composed.joint_index.is_some() {
            return None;
        }
        let without: Vec<_> = (0..layers).map(|layer| of(KeptLayers::AllBut(layer))).collect();
        let alone: Vec<_> = match layers {
            2 => without.iter().rev().cloned().collect(),
            _ => (0..layers).map(|layer| of(KeptLayers::Only(layer))).collect(),
        };
        let bare = of(KeptLayers::None).spectra;
        let densities = stack.iter().zip(&bare).enumerate().map(|(w, (stack, bare))| {
            let density = |layer: &LayerNumbers<f64>| -(layer.lit_at_45 / bare.lit_at_45).log10();
            let layers: f64 = alone.iter().map(|layer| density(&layer.spectra[w])).sum();
            DensityNumbers { stack: density(stack), layers, ratio: density(stack) / layers }
        });
        let densities = densities.collect();
        Some(LeftOutNumbers { without, alone, densities })
    }

    /// A layer of one thickness; `per_h` of the slabs have the thickness h.
    fn layer(&self, slabs: &[Slabs], thickness_um: f64, per_h: f64) -> ThicknessNumbers<f64> {
        self.coloured(self.with_optics(slabs, thickness_um, per_h))
    }

    /// Spectra with their colours, weighted numbers and prints.
    fn coloured(&self, all: Vec<SpectralLayer>) -> ThicknessNumbers<f64> {
        let optics: Vec<AreaOptics> = all.iter().map(|layer| layer.at_45).collect();
        let spectra: Vec<LayerNumbers<f64>> = all.into_iter().map(|layer| layer.numbers).collect();
        let seen = &spectra[self.visible.clone()];
        let colours = self.colorimeter.as_ref();
        let colours = colours.map(|eye| colours_of(eye, seen).unwrap_or(ColourNumbers::unknown()));
        let weighted = self.weighted.iter().map(|asked| self.weighted_number(asked, &spectra)).collect();
        let prints = self.prints.as_ref().map_or(Vec::new(), |prints| prints.numbers(&optics));
        ThicknessNumbers { spectra, colours, weighted, prints }
    }

    /// A weighted number of the layer.
    fn weighted_number(&self, asked: &AskedNumber, rows: &[LayerNumbers<f64>]) -> f64 {
        let spectra = self.weighted_spectra(asked, rows);
        asked.of(&spectra.iter().map(Vec::as_slice).collect::<Vec<_>>())
    }

    /// The spectra that a weighted number takes.
    pub(super) fn weighted_spectra(&self, asked: &AskedNumber, rows: &[LayerNumbers<f64>]) -> Vec<Vec<f64>> {
        let is_excluded = self.study.output.mirrored_sky == MirroredSky::Excluded;
        let of = |light: SeenLight| rows.iter().map(|row| row.seen(light, is_excluded)).collect();
        asked.wanted.spectra().map(of).collect()
    }

    /// Its numbers at every wavelength.
    fn spectra(&self, slabs: &[Slabs], thickness_um: f64, per_h: f64) -> Vec<LayerNumbers<f64>> {
        self.with_optics(slabs, thickness_um, per_h).into_iter().map(|layer| layer.numbers).collect()
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
        let spectra = self.spectra(slabs, count as f64 * self.composed.slab_um, 1.0);
        let seen = &spectra[self.visible.clone()];
        Some(colours_of(self.colorimeter.as_ref()?, seen)?.contrast_ratio >= HIDING)
    }

    /// Slabs of h in a thickness: a whole number but for rounding, or any.
    pub(super) fn slab_count(&self, thickness_um: f64) -> f64 {
        slabs_in(thickness_um, self.composed.slab_um)
    }
}

/// Layers at every wavelength on paper of these albedos, with what the paper emits under a light.
pub(super) fn brightened(
    mut all: Vec<SpectralLayer>,
    light: &Brightened,
    wavelengths_nm: &[f64],
    albedos: &[f64],
) -> Vec<SpectralLayer> {
    let at_45: Vec<AreaOptics> = all.iter().map(|layer| layer.at_45).collect();
    let of_sky =
        |layer: &SpectralLayer| AreaOptics { entering: layer.numbers.transmittance_diffuse, ..layer.at_45 };
    let natural: Vec<AreaOptics> = all.iter().map(of_sky).collect();
    let mix = AreaMix::whole();
    let lit = light.below(&mix, &[&at_45], wavelengths_nm);
    let sky = light.below(&mix, &[&natural], wavelengths_nm);
    for ((layer, &nm), albedo) in all.iter_mut().zip(wavelengths_nm).zip(albedos) {
        let leaving = layer.at_45.leaving / ((1.0 - albedo) + albedo * layer.at_45.lost);
        layer.numbers.lit_at_45 += leaving * lit.relative(nm).iter().sum::<f64>();
        layer.numbers.natural_light += leaving * sky.relative(nm).iter().sum::<f64>();
    }
    all
}

/// Shares of light at 0° that the layers of a stack absorb, without paper: what fluxes without
/// interference say, in proportion, of what R and T with interference leave.
fn absorbed_by_layers(stack: &PlateStack, wave: Wave, numbers: &LayerNumbers<f64>) -> Vec<f64> {
    let light = &lights(stack.before(), wave)[0];
    let nothing = Plate::lambertian(0.0, &stack.behind().weights());
    let each = stack.absorbed(light, &nothing);
    let sum: f64 = each.iter().sum();
    let all = 1.0 - numbers.reflectance_normal - numbers.transmittance_normal;
    each.into_iter().map(|share| share * ratio(all, sum)).collect()
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

/// Colours of a layer from its visible spectra; `None` if one of them has none.
pub(super) fn colours_of(eye: &Colorimeter, spectra: &[LayerNumbers<f64>]) -> Option<ColourNumbers<f64>> {
    let colour = |spectrum: fn(&LayerNumbers<f64>) -> f64| {
        eye.colour(&spectra.iter().map(spectrum).collect::<Vec<_>>()).ok()
    };
    let over_black = colour(|layer| layer.over_black)?;
    let over_white = colour(|layer| layer.over_white)?;
    Some(ColourNumbers {
        natural_light: colour(|layer| layer.natural_light)?.lab,
        lit_at_45: colour(|layer| layer.lit_at_45)?.lab,
        over_black: over_black.lab,
        contrast_ratio: over_black.xyz[1] / over_white.xyz[1],
    })
}

/// A layer or a stack at one wavelength.
pub struct SpectralLayer {
    /// Its numbers.
    pub numbers: LayerNumbers<f64>,
    /// As light at 45:0 and light between it and the paper meet it.
    pub(super) at_45: AreaOptics,
}

/// A layer or a stack at one wavelength, alone and on paper of this albedo.
pub fn spectral(layer: &ComposedLayer, wave: Wave, sky: MirroredSky, albedo: f64) -> SpectralLayer {
    let [before, behind] = layer.media;
    let oblique = before.ordinates.index * PRINT_DEG.to_radians().sin();
    let [at_normal, at_45, of_diffuse] = lights(before, wave);
    let normal = layer.of_light(&at_normal);
    let normal_changed = normal.changed(layer.change(0.0));
    let slanted = layer.of_light(&at_45).changed(layer.change_of_shared(oblique));
    let diffuse = layer.of_light(&of_diffuse).changed(layer.change_of_diffuse());
    let beam = layer.change_of_beam();
    let straight = layer.plate.transmission[0][(0, 0)] + beam.transmitted;
    let mirrored = layer.plate.reflection[0][(0, 0)] + beam.reflected;
    let mirrored = mirrored.max(0.0).min(normal_changed.reflected);
    // what returns from the paper has passed at 0°, and passes at 45°
    let through_normal = ratio(normal_changed.transmitted, normal.transmitted);
    let through_45 = ratio(slanted.transmitted, layer.transmitted_by_nodes(oblique));
    let paper = layer.on(albedo);
    let returned = total(&(&paper.plate.reflection[0] * &at_normal)) - normal.reflected;
    let natural = normal_changed.reflected + through_normal * paper.returned * paper.leaving * returned;
    let excluded = if sky == MirroredSky::Excluded { mirrored } else { 0.0 };
    let alone = lit_at_45(&layer.plate, before, wave);
    let lit = |on: &OnPaper| {
        let returned = lit_at_45(&on.plate, before, wave) - alone;
        alone + through_normal * through_45 * on.returned * returned
    };
    let on_paper = lit(&paper);
    let at_45 = AreaOptics {
        own: alone,
        entering: slanted.transmitted,
        leaving: normal_changed.transmitted / behind.ordinates.index.powi(2),
        lost: 1.0 - paper.back,
    };
    // fluxes go through the nodes, means do not: as a solid, dots give what the fluxes give
    let series = at_45.entering * at_45.leaving * albedo / ((1.0 - albedo) + albedo * at_45.lost);
    let at_45 = AreaOptics { leaving: at_45.leaving * ratio(on_paper - alone, series), ..at_45 };
    let numbers = LayerNumbers {
        reflectance_normal: normal_changed.reflected,
        transmittance_normal: normal_changed.transmitted,
        reflectance_45: slanted.reflected,
        transmittance_45: slanted.transmitted,
        reflectance_diffuse: diffuse.reflected,
        transmittance_diffuse: diffuse.transmitted,
        absorptance_behind: paper.absorbed,
        coherent_transmittance: straight.max(0.0).min(normal_changed.transmitted),
        mirrored,
        natural_light: natural - excluded,
        lit_at_45: on_paper,
        over_black: lit(&layer.on(BLACK)),
        over_white: lit(&layer.on(WHITE)),
    };
    SpectralLayer { numbers, at_45 }
}

/// BRDF and BTDF of light at 0° in the directions of the media in front and behind, per steradian.
/// The mirrored and the straight beam are left out, and what interference changes.
fn distribution(layer: &Plate, [before, behind]: [&Hemisphere; 2]) -> Distribution<f64> {
    let per_sr = |fluxes: &Mat<f64>, medium: &Hemisphere| {
        let flux =
            |node| (0..medium.polarisations).map(|p| fluxes[(medium.state(node + 1, p), 0)]).sum::<f64>();
        (0..medium.ordinates.count()).map(|node| flux(node) / projected_sr(medium, node)).collect()
    };
    Distribution {
        reflected: per_sr(&layer.reflection[0], before),
        transmitted: per_sr(&layer.transmission[0], behind),
    }
}

/// Projected solid angle that a node stands for, ∫ cos θ dω, sr.
pub fn projected_sr(medium: &Hemisphere, node: usize) -> f64 {
    PI * medium.ordinates.weights[node] / medium.ordinates.index.powi(2)
}

/// Unit fluxes of light at 0°, at 45° and of diffuse light.
pub fn lights(medium: &Hemisphere, wave: Wave) -> [Mat<f64>; 3] {
    let shares = polarised(medium, wave);
    let mut all: [Mat<f64>; 3] = std::array::from_fn(|_| Mat::zeros(medium.states(), 1));
    all[0][(0, 0)] = 1.0;
    let nodes = medium.ordinates.count();
    let sum = medium.ordinates.weights.iter().sum::<f64>();
    for (polarisation, share) in shares.into_iter().enumerate() {
        if medium.oblique_deg.is_some() {
            all[1][(medium.state(nodes + 1, polarisation), 0)] = share;
        }
        for node in 0..nodes {
            all[2][(medium.state(node + 1, polarisation), 0)] = share * medium.ordinates.weights[node] / sum;
        }
    }
    all
}

/// π × BRDF at 45:0, by reciprocity: light at 0° that leaves at 45°.
fn lit_at_45(plate: &Plate, medium: &Hemisphere, wave: Wave) -> f64 {
    let sine = medium.ordinates.index * PRINT_DEG.to_radians().sin();
    let shares = polarised(medium, wave);
    let brdf = |(node, share): (usize, f64)| {
        let flux = |p: usize| plate.reflection[0][(medium.state(node + 1, p), 0)];
        let reflected: f64 = shares.iter().enumerate().map(|(p, s)| shares.len() as f64 * s * flux(p)).sum();
        share * reflected / medium.ordinates.weights[node]
    };
    medium.ordinates.shares(sine).into_iter().map(brdf).sum()
}

/// What the medium of the slabs is to light. NaN for what these realisations do not determine.
fn coefficients(slabs: &Slabs, slab_um: f64) -> MediumNumbers<f64> {
    let medium = &slabs.media[1];
    let transport = Transport::of_slab(&slabs.inner, medium, slab_um);
    let of_transport = |get: fn(&Transport) -> f64| transport.as_ref().map_or(f64::NAN, get);
    let munk = two_flux(&slabs.inner, medium, slab_um);
    let index = mean_wave_index(slabs, slab_um);
    // Diffuse light is counted in the half-spaces. Of the same radiance, a medium of index n holds
    // light in proportion to n²: it absorbs so much more, and so much more passes a thick layer.
    let more = (index / medium.ordinates.index).powi(2);
    MediumNumbers {
        effective_index: index,
        coherent_path_um: extinction_per_um(&slabs.inner, slab_um).map_or(f64::NAN, f64::recip),
        scattering_per_um: of_transport(|t| t.scattering_per_um),
        absorption_per_um: of_transport(|t| t.absorption_per_um),
        asymmetry: of_transport(|t| t.asymmetry),
        transport_path_um: of_transport(Transport::mean_free_path_um),
        kubelka_munk_absorption_per_um: munk.map_or(f64::NAN, |m| m.absorption_per_um / more),
        kubelka_munk_scattering_per_um: munk.map_or(f64::NAN, |m| m.scattering_per_um * more),
    }
}

/// Index of the mean wave at 0°: that of the half-spaces, and what the wave's phase behind an inner
/// slab is beyond theirs.
fn mean_wave_index(slabs: &Slabs, slab_um: f64) -> f64 {
    let embedding = slabs.media[1].ordinates.index;
    let wavenumber = TAU / slabs.film.wavelength_um;
    let even = Complex64::from_polar(1.0, wavenumber * embedding * slab_um);
    // of an inner slab lit from in front at 0°, for each polarisation: transmitted
    let passed = &slabs.film.slabs[1][0][0];
    let phases = passed.iter().map(|[_, transmitted]| (transmitted / even).arg());
    embedding + phases.sum::<f64>() / passed.len() as f64 / (wavenumber * slab_um)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::composed::level::tests::{even_plate, slabs_of};

    /// Slabs of the same fluxes whose mean wave has another index than their half-spaces: of the
    /// same radiance they hold n² times the light, so that K is smaller and S larger by that.
    /// *Planted*: K and S counted in the half-spaces.
    #[test]
    fn kubelka_and_munk_count_light_in_the_medium() {
        let of_index = |index: f64| {
            let mut slabs = slabs_of(even_plate(0.0, 1.0), even_plate(0.2, 0.7), even_plate(0.0, 1.0));
            let passed = Complex64::from_polar(0.5, TAU / slabs.film.wavelength_um * index);
            slabs.film.slabs[1][0] = vec![vec![[Complex64::ZERO, passed]]];
            coefficients(&slabs, 1.0)
        };
        let [alike, denser] = [of_index(1.5), of_index(1.65)];
        assert!((denser.effective_index - 1.65).abs() < 1e-12, "{}", denser.effective_index);
        let square = (1.65_f64 / 1.5).powi(2);
        let scattering = denser.kubelka_munk_scattering_per_um / alike.kubelka_munk_scattering_per_um;
        let absorption = denser.kubelka_munk_absorption_per_um / alike.kubelka_munk_absorption_per_um;
        // the fluxes are the same: rounding
        assert!((scattering - square).abs() < 1e-12, "{scattering}");
        assert!((absorption - 1.0 / square).abs() < 1e-12, "{absorption}");
    }
}
