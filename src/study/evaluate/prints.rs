//! Prints on the study's paper besides the solid under daylight: in dots, and under the lights of
//! instruments where the paper fluoresces. Layers that are solved as a whole and composed ones are
//! seen alike: as [`AreaOptics`] at the study's wavelengths.

mod between;
mod emission;
mod tint;

pub use emission::{Brightened, EmittedLight, LitAreas};
pub use tint::{InkCoverage, PrintedTint};

use crate::appearance::bare_paper::{BareSurface, PaperGeometry};
use crate::appearance::halftone::{murray_davies, yule_nielsen};
use crate::appearance::paper::Coupling;
use crate::appearance::paper_series::{AreaMix, AreaOptics, LayerOptics};
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::appearance::viewing::{Summation, Viewing};
use crate::input::measured::MeasuredCondition;
use crate::input::study::{Paper, Study};
use between::PaperBetween;
use serde::Serialize;
use tint::additivity;

/// Share of the paper's luminance that a solid must take for coverages to be read from it: faces of
/// the solid and of bare paper differ in polarisation by more than rounding, but hardly.
const NO_INK: f64 = 0.01;

/// What of a print its bars are made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PrintNumbers<T> {
    /// L*, a*, b* at 45:0.
    pub lab: [T; 3],
    /// X, Y, Z; those of a perfect white have Y = 100.
    pub xyz: [T; 3],
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
            xyz: self.xyz.map(number),
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
        let [x, y, z] = self.xyz;
        let [other_x, other_y, other_z] = other.xyz;
        PrintNumbers {
            lab: [number(l, other_l), number(a, other_a), number(b, other_b)],
            xyz: [number(x, other_x), number(y, other_y), number(z, other_z)],
            apparent: number(self.apparent, other.apparent),
            density: number(self.density, other.density),
            additivity: number(self.additivity, other.additivity),
            factors: self.factors.into_iter().zip(other.factors).map(|(x, y)| number(x, y)).collect(),
        }
    }
}

/// Bare paper with this contact, as light at 45:0 meets it.
fn bare_area(coupling: Coupling) -> AreaOptics {
    let surface = BareSurface::new(coupling);
    let [entering, leaving] = surface.passed(PaperGeometry::LitAt45);
    AreaOptics { own: 0.0, entering, leaving, lost: surface.escaping() }
}

/// Albedos of a paper, NaN where it has none.
fn albedos_at(paper: &Paper, wavelengths_nm: &[f64]) -> Vec<f64> {
    wavelengths_nm.iter().map(|&nm| paper.albedo.at(nm).unwrap_or(f64::NAN)).collect()
}

/// Radiance factors of a study's bare paper at 45:0 under D65, at the study's wavelengths.
pub(super) fn bare_factors(study: &Study) -> Vec<f64> {
    let nm = &study.wavelengths_nm;
    let bare = vec![bare_area(study.paper.coupling); nm.len()];
    let mix = AreaMix::whole();
    let daylight = Brightened::new(&study.paper, nm, &Viewing::default(), 0.0);
    let emitted = daylight.as_ref().map(|light| light.below(&mix, &[&bare], nm));
    let albedos = albedos_at(&study.paper, nm);
    let kinds: [&[AreaOptics]; 1] = [&bare];
    LitAreas { mix: &mix, kinds: &kinds, albedos: &albedos, emitted: emitted.as_ref(), wavelengths_nm: nm }
        .factors()
}

/// What bare paper does of L*, a*, b* at 45:0 between wavelengths, under a light where it
/// fluoresces.
pub(super) fn paper_between(
    paper: &Paper,
    nm: &[f64],
    light: Option<&Brightened>,
    viewing: &Viewing,
) -> [f64; 3] {
    let eye = Colorimeter::under(&nm[visible(nm)], viewing).ok();
    let Some((between, eye)) = PaperBetween::new(paper, nm, viewing).zip(eye) else { return [0.0; 3] };
    let bare = vec![bare_area(paper.coupling); nm.len()];
    let mix = AreaMix::whole();
    let kinds: [&[AreaOptics]; 1] = [&bare];
    let emitted = light.map(|light| light.below(&mix, &kinds, nm));
    let albedos = albedos_at(paper, nm);
    let lit = LitAreas {
        mix: &mix,
        kinds: &kinds,
        albedos: &albedos,
        emitted: emitted.as_ref(),
        wavelengths_nm: nm,
    };
    let emission = light.and_then(|light| light.emission(&eye, nm));
    let Ok(xyz) = lit.xyz(&eye, emission.as_ref()) else { return [0.0; 3] };
    let beyond = between.beyond(&lit, emission.as_ref());
    let coarse = eye.colour_of(xyz).lab;
    let fine = eye.colour_of(std::array::from_fn(|c| xyz[c] + beyond[c])).lab;
    std::array::from_fn(|i| fine[i] - coarse[i])
}

/// A print as it is seen at 45:0.
struct SeenPrint {
    /// Radiance factors at the study's wavelengths.
    factors: Vec<f64>,
    /// X, Y, Z, with what the paper does between these.
    xyz: [f64; 3],
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
    /// The paper between the wavelengths, of a layer that is solved as a whole.
    between: Option<PaperBetween>,
    /// What it does there of L*, a*, b* of the bare paper under each light, of a composed layer.
    open: Vec<[f64; 3]>,
    /// The paper under the light of every condition; one without a light if it does not fluoresce.
    lights: Vec<(Option<MeasuredCondition>, Option<Brightened>)>,
}

impl<'a> PrintTask<'a> {
    /// The prints of a study; `None` where there is a solid alone on paper without a brightener,
    /// and where its wavelengths carry no colour.
    pub fn new(study: &'a Study) -> Option<Self> {
        let Paper { fluorescence, dots, coupling, .. } = &study.paper;
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
        let is_composed = study.composed().is_some();
        let lit = lights.iter().filter(|_| is_composed);
        let open = lit.map(|(_, light)| paper_between(&study.paper, nm, light.as_ref(), &viewing)).collect();
        let mixed = dots.as_ref().and_then(|dots| Some((dots, dots.mixed.as_ref()?)));
        let tints: Vec<PrintedTint> = match mixed {
            Some((dots, mixed)) => PrintedTint::all_of(dots, mixed),
            None => dots.iter().flat_map(PrintedTint::ramp).collect(),
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
            between: if is_composed { None } else { PaperBetween::new(&study.paper, nm, &viewing) },
            open,
            viewing: viewing.name(),
            others: mixed.map_or(&[][..], |(_, mixed)| mixed.layers.as_slice()),
            bare: bare_area(*coupling),
            albedos: albedos_at(&study.paper, nm),
            lights,
        })
    }

    /// The solid of this study's layer under the light of a print.
    pub(super) fn solid_of(&self, print: usize) -> usize {
        let each = self.prints.len() / self.lights.len();
        print / each * each + each - 1
    }

    /// What the paper leaves open of L*, a*, b* of a print of a composed layer.
    pub(super) fn open_of_paper(&self, print: usize) -> [f64; 3] {
        let each = self.prints.len() / self.lights.len();
        self.open.get(print / each).copied().unwrap_or_default()
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
            let seen: Vec<SeenPrint> = prints
                .iter()
                .map(|print| self.print([exciting, layer], others, print, light.as_ref()))
                .collect();
            let luminances: Vec<f64> = seen.iter().map(|print| print.xyz[1]).collect();
            let paper = luminances[0];
            let solid = luminances[each - 1];
            let density = |luminance: f64| -(luminance / paper).log10();
            for (k, SeenPrint { factors, xyz }) in seen.into_iter().enumerate() {
                let inked = k > 0 && paper - solid > NO_INK * paper && self.others.is_empty();
                let apparent = if inked { murray_davies(paper, luminances[k], solid) } else { f64::NAN };
                all.push(PrintNumbers {
                    lab: self.eye.colour_of(xyz).lab,
                    xyz,
                    apparent,
                    density: density(luminances[k]),
                    additivity: additivity(prints, k, |k| density(luminances[k])),
                    factors,
                });
            }
        }
        all
    }

    /// One print at 45:0; the layer as it excites the paper, and as it is seen.
    fn print(
        &self,
        [exciting, layer]: [&[AreaOptics]; 2],
        others: &[&[AreaOptics]],
        print: &PrintedTint,
        light: Option<&Brightened>,
    ) -> SeenPrint {
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
        let lit = LitAreas {
            mix: &mix,
            kinds: &kinds,
            albedos: &self.albedos,
            emitted: emitted.as_ref(),
            wavelengths_nm: nm,
        };
        let factors = lit.factors();
        // lit by instruments, whose light is smooth
        let mut xyz = self.eye.xyz(self.seen(&factors)).unwrap_or([f64::NAN; 3]);
        if let Some(between) = &self.between {
            let beyond = between.beyond(&lit, None);
            xyz.iter_mut().zip(beyond).for_each(|(sum, beyond)| *sum += beyond);
        }
        SeenPrint { factors, xyz }
    }

    /// The factors that the eye sums.
    pub fn seen<'f>(&self, factors: &'f [f64]) -> &'f [f64] {
        &factors[visible(&self.study.wavelengths_nm)]
    }

    /// n of Yule and Nielsen for the luminance of each print, where there is one.
    pub fn yule_nielsen(&self, numbers: &[PrintNumbers<f64>]) -> Vec<Option<f64>> {
        let each = self.prints.len() / self.lights.len();
        let luminances: Vec<f64> = numbers.iter().map(|print| print.xyz[1]).collect();
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
