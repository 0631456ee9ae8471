//! Prints on the study's paper besides the solid under daylight: in dots, and under the lights of
//! instruments where the paper fluoresces. Layers that are solved as a whole and composed ones are
//! seen alike: as [`AreaOptics`] at the study's wavelengths.

use crate::appearance::bare_paper::{BareSurface, PaperGeometry};
use crate::appearance::fluorescence::{CUT_NM, summed_nm};
use crate::appearance::halftone::{murray_davies, physical_coverage, spread_share, yule_nielsen};
use crate::appearance::paper::Coupling;
use crate::appearance::paper_series::{AreaMix, AreaOptics, LayerOptics};
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::appearance::viewing::{ColourError, Summation, Viewing};
use crate::input::measured::MeasuredCondition;
use crate::input::study::{Dots, MixedAreas, MixedPrint, Paper, Study};
use serde::Serialize;

/// Micrometres of a centimetre.
const UM_PER_CM: f64 = 1e4;

/// A brightened paper under a light.
#[derive(Clone, Debug)]
pub struct Brightened {
    /// Wavelengths of the sum over excitation.
    grid_nm: Vec<f64>,
    albedos: Vec<f64>,
    light: Vec<f64>,
    matrix: Vec<Vec<f64>>,
}

/// What the paper below every kind of area emits, against wavelength.
pub struct EmittedLight<'a> {
    brightened: &'a Brightened,
    /// \[wavelength\]\[kind of area\]
    emitted: Vec<Vec<f64>>,
}

/// Share of the paper's luminance that a solid must take for coverages to be read from it: faces of
/// the solid and of bare paper differ in polarisation by more than rounding, but hardly.
const NO_INK: f64 = 0.01;

impl Brightened {
    /// The paper under the light of an instrument, or under an illuminant; `None` if it does not
    /// fluoresce.
    ///
    /// # Errors
    /// An illuminant that is not known.
    pub fn under(
        paper: &Paper,
        wavelengths_nm: &[f64],
        condition: Option<MeasuredCondition>,
        illuminant: &Viewing,
    ) -> Result<Option<Self>, ColourError> {
        let of = |name: &str| Viewing::new(name, "2", Summation::Plain);
        let (lamp, cut_nm) = match condition {
            None => (illuminant.clone(), 0.0),
            Some(MeasuredCondition::M0) => (of("A")?, 0.0),
            Some(MeasuredCondition::M1) => (of("D50")?, 0.0),
            // polarised light has no ultraviolet either
            Some(MeasuredCondition::M2 | MeasuredCondition::M3) => (of("D50")?, CUT_NM),
        };
        Ok(Self::new(paper, wavelengths_nm, &lamp, cut_nm))
    }

    /// The paper under an illuminant, at wavelengths from below `cut_nm` of which there is no
    /// light; `None` if it does not fluoresce.
    pub fn new(paper: &Paper, wavelengths_nm: &[f64], viewing: &Viewing, cut_nm: f64) -> Option<Self> {
        let fluorescence = paper.fluorescence.as_ref()?;
        let grid_nm = summed_nm(*wavelengths_nm.first()?, *wavelengths_nm.last()?);
        let power = |&nm: &f64| if nm < cut_nm { 0.0 } else { viewing.power(nm) };
        let albedo = |&nm: &f64| paper.albedo.at(nm).unwrap_or(f64::NAN);
        Some(Self {
            albedos: grid_nm.iter().map(albedo).collect(),
            light: grid_nm.iter().map(power).collect(),
            matrix: fluorescence.matrix(&grid_nm),
            grid_nm,
        })
    }

    /// What is emitted below kinds of area that are known at these wavelengths.
    pub fn below(&self, mix: &AreaMix, kinds: &[&[AreaOptics]], wavelengths_nm: &[f64]) -> EmittedLight<'_> {
        let at = |&nm: &f64| kinds.iter().map(|kind| AreaOptics::at(kind, wavelengths_nm, nm)).collect();
        let areas: Vec<Vec<AreaOptics>> = self.grid_nm.iter().map(at).collect();
        let emitted = mix.emitted(&areas, &self.albedos, &self.light, &self.matrix);
        EmittedLight { brightened: self, emitted }
    }
}

impl EmittedLight<'_> {
    /// S_k/E at a wavelength; nothing where there is no light to compare with.
    pub fn relative(&self, nm: f64) -> Vec<f64> {
        let Brightened { grid_nm, light, .. } = self.brightened;
        let after = grid_nm.partition_point(|&x| x < nm).min(grid_nm.len().saturating_sub(1));
        let below =
            if grid_nm.get(after).is_some_and(|&x| x <= nm) { after } else { after.saturating_sub(1) };
        let (Some(from), Some(to)) = (grid_nm.get(below), grid_nm.get(after)) else { return Vec::new() };
        let share = if to > from { ((nm - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        let mix = |low: f64, high: f64| low + share * (high - low);
        let power = mix(light[below], light[after]);
        let kinds = self.emitted[below].iter().zip(&self.emitted[after]);
        kinds.map(|(low, high)| if power > 0.0 { mix(*low, *high) / power } else { 0.0 }).collect()
    }
}

/// One print.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PrintedTint {
    /// Light of the instrument, where the paper fluoresces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<MeasuredCondition>,
    /// Coverage as it was asked for; 0 is bare paper, 1 the solid.
    pub nominal: f64,
    /// Coverage with the physical gain.
    pub coverage: f64,
    /// Share of the light that the paper spreads over all areas alike.
    pub spread: f64,
    /// Nominal coverages of the inks, or of the areas with layers of other runs; empty where this
    /// study's layer is printed alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inks: Vec<InkCoverage>,
    /// Shares of this study's layer, of the layers of other runs, and of bare paper.
    #[serde(skip)]
    pub shares: Vec<f64>,
}

impl PrintedTint {
    /// The prints of several kinds of area.
    fn all_of(dots: &Dots, mixed: &MixedAreas) -> Vec<Self> {
        let print = |(&nominal, print): (&f64, &MixedPrint)| {
            let inks = mixed.names.iter().zip(&print.nominal);
            let coverage: f64 = print.shares.iter().sum();
            let bare = (1.0 - coverage).max(0.0);
            Self {
                condition: None,
                nominal,
                coverage,
                spread: print.spread,
                inks: inks.map(|(name, &coverage)| InkCoverage { name: name.clone(), coverage }).collect(),
                shares: print.shares.iter().copied().chain([bare]).collect(),
            }
        };
        dots.nominal.iter().zip(&mixed.prints).map(print).collect()
    }
}

/// The nominal coverage of an ink.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InkCoverage {
    /// Its name in the study.
    pub name: String,
    /// Its coverage, 0 to 1.
    pub coverage: f64,
}

/// What of a print its bars are made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PrintNumbers<T> {
    /// L*, a*, b* at 45:0.
    pub lab: [T; 3],
    /// Coverage by Murray and Davies from Y: what a densitometer calls it. NaN without ink.
    pub apparent: T,
    /// Visual density over the paper, −log₁₀(Y/Y of the paper).
    pub density: T,
    /// Of an overprint of solids, its density over the sum of those of its inks: 1 where densities
    /// add up. NaN of other prints, and where an ink's solid is not among the prints.
    pub additivity: T,
    /// Radiance factor at 45:0, wavelength by wavelength.
    pub factors: Vec<T>,
}

impl<T> PrintNumbers<T> {
    /// New numbers, each from this one.
    pub fn map<U>(self, number: &impl Fn(T) -> U) -> PrintNumbers<U> {
        PrintNumbers {
            lab: self.lab.map(number),
            apparent: number(self.apparent),
            density: number(self.density),
            additivity: number(self.additivity),
            factors: self.factors.into_iter().map(number).collect(),
        }
    }

    /// New numbers, each from those of its place here and in `other`.
    pub fn zipped<V, U>(self, other: PrintNumbers<V>, number: &impl Fn(T, V) -> U) -> PrintNumbers<U> {
        let [l, a, b] = self.lab;
        let [other_l, other_a, other_b] = other.lab;
        PrintNumbers {
            lab: [number(l, other_l), number(a, other_a), number(b, other_b)],
            apparent: number(self.apparent, other.apparent),
            density: number(self.density, other.density),
            additivity: number(self.additivity, other.additivity),
            factors: self.factors.into_iter().zip(other.factors).map(|(x, y)| number(x, y)).collect(),
        }
    }
}

/// The density of an overprint of solids over the sum of those of its inks.
fn additivity(prints: &[PrintedTint], k: usize, density: impl Fn(usize) -> f64) -> f64 {
    let inks = &prints[k].inks;
    let count = inks.iter().filter(|ink| ink.coverage == 1.0).count();
    if count < 2 || inks.iter().any(|ink| ink.coverage != 0.0 && ink.coverage != 1.0) {
        return f64::NAN;
    }
    let mut sum = 0.0;
    for (number, _) in inks.iter().enumerate().filter(|(_, ink)| ink.coverage == 1.0) {
        let is_alone = |print: &PrintedTint| {
            let mut own = print.inks.iter().enumerate();
            !print.inks.is_empty() && own.all(|(i, ink)| ink.coverage == f64::from(i == number))
        };
        match prints.iter().position(is_alone) {
            Some(solid) => sum += density(solid),
            None => return f64::NAN,
        }
    }
    density(k) / sum
}

/// Bare paper with this contact, as light at 45:0 meets it.
fn bare_area(coupling: Coupling) -> AreaOptics {
    let surface = BareSurface::new(coupling);
    let [entering, leaving] = surface.passed(PaperGeometry::LitAt45);
    AreaOptics { own: 0.0, entering, leaving, lost: surface.escaping() }
}

/// Radiance factors of a study's bare paper at 45:0 under D65, at the study's wavelengths.
pub(super) fn bare_factors(study: &Study) -> Vec<f64> {
    let nm = &study.wavelengths_nm;
    let bare = vec![bare_area(study.paper.coupling); nm.len()];
    let mix = AreaMix::whole();
    let daylight = Brightened::new(&study.paper, nm, &Viewing::default(), 0.0);
    let emitted = daylight.as_ref().map(|light| light.below(&mix, &[&bare], nm));
    let factor = |(&nm, area): (&f64, &AreaOptics)| {
        let emitted = emitted.as_ref().map_or(Vec::new(), |emitted| emitted.relative(nm));
        mix.factor(&[*area], study.paper.albedo.at(nm).unwrap_or(f64::NAN), &emitted)
    };
    nm.iter().zip(&bare).map(factor).collect()
}

/// The prints of a study.
pub struct PrintTask<'a> {
    study: &'a Study,
    /// In the order of their results: by condition, then by coverage from bare to solid.
    pub prints: Vec<PrintedTint>,
    /// The eye that sums their colours.
    pub eye: Colorimeter,
    /// Name of illuminant and observer.
    pub viewing: String,
    /// Bare paper at 45:0.
    bare: AreaOptics,
    /// Layers of other runs that some areas bear.
    others: &'a [LayerOptics],
    albedos: Vec<f64>,
    /// The paper under the light of every condition; one without a light if it does not fluoresce.
    lights: Vec<(Option<MeasuredCondition>, Option<Brightened>)>,
}

impl<'a> PrintTask<'a> {
    /// The prints of a study; `None` where there is a solid alone on paper without a brightener,
    /// and where its wavelengths carry no colour.
    pub fn new(study: &'a Study) -> Option<Self> {
        let Paper { fluorescence, dots, coupling, albedo, .. } = &study.paper;
        if fluorescence.is_none() && dots.is_none() {
            return None;
        }
        let nm = &study.wavelengths_nm;
        let daylight = Viewing::new("D50", "2", Summation::Plain).ok()?;
        let viewing = if fluorescence.is_some() { daylight.clone() } else { study.judgement.viewing.clone() };
        let lit = |condition| {
            let light = Brightened::under(&study.paper, nm, Some(condition), &viewing);
            (Some(condition), light.ok().flatten())
        };
        let lights = match fluorescence {
            None => vec![(None, None)],
            Some(_) => {
                vec![lit(MeasuredCondition::M0), lit(MeasuredCondition::M1), lit(MeasuredCondition::M2)]
            }
        };
        let tints = dots.iter().flat_map(|dots| {
            dots.nominal.iter().map(move |&nominal| {
                let coverage = physical_coverage(nominal, dots.physical_gain);
                let ruling_per_um = dots.ruling_per_cm / UM_PER_CM;
                let spread = spread_share(coverage, ruling_per_um, dots.spread_um);
                PrintedTint { condition: None, nominal, coverage, spread, ..PrintedTint::default() }
            })
        });
        let mixed = dots.as_ref().and_then(|dots| Some((dots, dots.mixed.as_ref()?)));
        let tints: Vec<PrintedTint> = match mixed {
            Some((dots, mixed)) => PrintedTint::all_of(dots, mixed),
            None => tints.collect(),
        };
        let alone =
            |nominal: f64| PrintedTint { nominal, coverage: nominal, spread: 1.0, ..PrintedTint::default() };
        let ramp: Vec<PrintedTint> = [alone(0.0)].into_iter().chain(tints).chain([alone(1.0)]).collect();
        let prints = lights.iter().flat_map(|(condition, _)| {
            ramp.iter().map(move |print| PrintedTint { condition: *condition, ..print.clone() })
        });
        Some(Self {
            study,
            prints: prints.collect(),
            eye: Colorimeter::under(&nm[visible(nm)], &viewing).ok()?,
            viewing: viewing.name(),
            others: mixed.map_or(&[][..], |(_, mixed)| mixed.layers.as_slice()),
            bare: bare_area(*coupling),
            albedos: nm.iter().map(|&nm| albedo.at(nm).unwrap_or(f64::NAN)).collect(),
            lights,
        })
    }

    /// The layers of other runs that some areas bear.
    pub fn others(&self) -> &[LayerOptics] {
        self.others
    }

    /// All prints of a layer that is known at the study's wavelengths.
    pub fn numbers(&self, layer: &[AreaOptics]) -> Vec<PrintNumbers<f64>> {
        let others: Vec<&[AreaOptics]> = self.others.iter().map(|other| other.whole.as_slice()).collect();
        self.numbers_beside(layer, &others)
    }

    /// All prints as if the layer's optics that excite the paper were known at every second
    /// wavelength only; `None` if the paper does not fluoresce. Between wavelengths they are taken
    /// as linear, so that the difference is three times the error of all wavelengths.
    pub fn coarsely_excited(&self, layer: &[AreaOptics]) -> Option<Vec<PrintNumbers<f64>>> {
        self.lights.iter().find(|(_, light)| light.is_some())?;
        let nm = &self.study.wavelengths_nm;
        let even: Vec<usize> = (0..nm.len()).filter(|i| i % 2 == 0 || i + 1 == nm.len()).collect();
        let kept_nm: Vec<f64> = even.iter().map(|&i| nm[i]).collect();
        let kept: Vec<AreaOptics> = even.iter().map(|&i| layer[i]).collect();
        let coarse: Vec<AreaOptics> = nm.iter().map(|&nm| AreaOptics::at(&kept, &kept_nm, nm)).collect();
        let others: Vec<&[AreaOptics]> = self.others.iter().map(|other| other.whole.as_slice()).collect();
        Some(self.numbers_lit(&coarse, layer, &others))
    }

    /// All prints, with these values of the layers of other runs.
    pub fn numbers_beside(&self, layer: &[AreaOptics], others: &[&[AreaOptics]]) -> Vec<PrintNumbers<f64>> {
        self.numbers_lit(layer, layer, others)
    }

    /// All prints; `exciting` is the layer through which light excites the paper.
    fn numbers_lit(
        &self,
        exciting: &[AreaOptics],
        layer: &[AreaOptics],
        others: &[&[AreaOptics]],
    ) -> Vec<PrintNumbers<f64>> {
        let each = self.prints.len() / self.lights.len();
        let mut all = Vec::new();
        for ((_, light), prints) in self.lights.iter().zip(self.prints.chunks(each)) {
            let factors: Vec<Vec<f64>> = prints
                .iter()
                .map(|print| self.factors([exciting, layer], others, print, light.as_ref()))
                .collect();
            let luminances: Vec<f64> = factors.iter().map(|factors| self.luminance(factors)).collect();
            let paper = luminances[0];
            let solid = luminances[each - 1];
            let density = |luminance: f64| -(luminance / paper).log10();
            for (k, factors) in factors.into_iter().enumerate() {
                let inked = k > 0 && paper - solid > NO_INK * paper && self.others.is_empty();
                let apparent = if inked { murray_davies(paper, luminances[k], solid) } else { f64::NAN };
                all.push(PrintNumbers {
                    lab: self.lab(&factors),
                    apparent,
                    density: density(luminances[k]),
                    additivity: additivity(prints, k, |k| density(luminances[k])),
                    factors,
                });
            }
        }
        all
    }

    /// Radiance factors of one print at 45:0; the layer as it excites the paper, and as it is seen.
    fn factors(
        &self,
        [exciting, layer]: [&[AreaOptics]; 2],
        others: &[&[AreaOptics]],
        print: &PrintedTint,
        light: Option<&Brightened>,
    ) -> Vec<f64> {
        let nm = &self.study.wavelengths_nm;
        let bare = vec![self.bare; nm.len()];
        let shares = match print.shares.is_empty() {
            true => vec![print.coverage, 1.0 - print.coverage],
            false => print.shares.clone(),
        };
        let elsewhere = others.iter().copied().filter(|_| !print.shares.is_empty());
        let kinds: Vec<&[AreaOptics]> =
            [layer].into_iter().chain(elsewhere).chain([bare.as_slice()]).collect();
        let mix = AreaMix { shares, spread: print.spread };
        let emitted = light.map(|light| {
            let exciting: Vec<&[AreaOptics]> =
                [exciting].into_iter().chain(kinds[1..].iter().copied()).collect();
            light.below(&mix, &exciting, nm)
        });
        let factor = |(i, &nm): (usize, &f64)| {
            let emitted = emitted.as_ref().map_or(Vec::new(), |emitted| emitted.relative(nm));
            let areas: Vec<AreaOptics> = kinds.iter().map(|kind| kind[i]).collect();
            mix.factor(&areas, self.albedos[i], &emitted)
        };
        nm.iter().enumerate().map(factor).collect()
    }

    /// The factors that the eye sums.
    pub fn seen<'f>(&self, factors: &'f [f64]) -> &'f [f64] {
        &factors[visible(&self.study.wavelengths_nm)]
    }

    fn luminance(&self, factors: &[f64]) -> f64 {
        self.eye.xyz(self.seen(factors)).map_or(f64::NAN, |xyz| xyz[1])
    }

    fn lab(&self, factors: &[f64]) -> [f64; 3] {
        self.eye.colour(self.seen(factors)).map_or([f64::NAN; 3], |colour| colour.lab)
    }

    /// n of Yule and Nielsen for the luminance of each print, where there is one.
    pub fn yule_nielsen(&self, numbers: &[PrintNumbers<f64>]) -> Vec<Option<f64>> {
        let each = self.prints.len() / self.lights.len();
        let luminances: Vec<f64> = numbers.iter().map(|print| self.luminance(&print.factors)).collect();
        let n = |(k, print): (usize, &PrintedTint)| {
            if !self.others.is_empty() {
                return None;
            }
            let first = k / each * each;
            yule_nielsen(print.coverage, luminances[first], luminances[k], luminances[first + each - 1])
        };
        self.prints.iter().enumerate().map(n).collect()
    }
}
