//! Stacks of a library's plates on paper, composed without a solve.
//!
//! ```text
//! air | face | plate | plate | … | (face) | paper
//! ```
//!
//! The plates lie in the joint's medium, plane faces lead from there to the air in front and to the
//! gap behind; a paper in optical contact has the joint's index. Everything else is what a run
//! makes of a composed stack: the same fluxes, the same mean wave, the same series of the paper and
//! the same bars.

use super::errors::judged;
use super::gate::{LayerInColour, rows};
use super::layer::ComposedLayer;
use super::level::{Change, KeptPortion, Level};
use super::library::Library;
use super::numbers::{colours_of, spectral};
use super::stacked::{between_faces, slab_elements};
use crate::appearance::bare_paper::{BareSurface, PaperGeometry};
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::stack::PlateStack;
use crate::appearance::halftone::{murray_davies, spread_share};
use crate::appearance::paper::{Albedo, Coupling, MirroredSky, PRINT_DEG};
use crate::appearance::paper_series::{AreaMix, AreaOptics};
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::appearance::viewing::{Summation, Viewing};
use crate::evaluate::manifest::composed::{ComposedColours, ComposedRow};
use crate::evaluate::prints::PrintNumbers;
use crate::evaluate::published::{ErrorParts, Withheld};
use crate::evaluate::quantities::{ColourNumbers, ComposedNumbers, LayerNumbers, ThicknessNumbers};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Micrometres of a centimetre.
const UM_PER_CM: f64 = 1e4;

/// A stack of plates on paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Composition {
    /// The layers in the order of the light: the first one is on top.
    pub layers: Vec<CompositionLayer>,
    /// The paper.
    #[serde(default)]
    pub paper: CompositionPaper,
    /// Dots that the stack is printed in, besides the solid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dots: Option<CompositionDots>,
    /// Illuminant of the colours.
    #[serde(default = "daylight")]
    pub illuminant: String,
    /// Observer of the colours: `2` or `10`.
    #[serde(default = "standard")]
    pub observer: String,
}

/// One layer of a composition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompositionLayer {
    /// Name of a plate.
    pub plate: String,
    /// Thickness, µm; of plates in slabs any from two slabs on (default), else the solved one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness_um: Option<f64>,
}

/// The paper of a composition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompositionPaper {
    /// Share of the light that it returns, 0 to 1: a number, or rows of nm and share.
    #[schemars(with = "serde_json::Value")]
    pub albedo: Albedo,
    /// Whether it touches the stack, in a medium of the joint's index; else there is a thin gap.
    pub contact: bool,
}

/// Dots of a composition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompositionDots {
    /// Share of the area that the stack covers, 0 to 1; the rest is bare paper.
    pub coverage: f64,
    /// Dots per cm.
    pub ruling_per_cm: f64,
    /// Length over which the paper spreads light, µm.
    pub spread_um: f64,
}

impl Default for CompositionPaper {
    fn default() -> Self {
        Self { albedo: Albedo::Constant(0.9), contact: false }
    }
}

fn daylight() -> String {
    "D65".to_owned()
}

fn standard() -> String {
    "2".to_owned()
}

/// What a composition looks like.
#[derive(Clone, Debug, Serialize)]
pub struct ComposedStack {
    /// What was composed.
    pub composition: Composition,
    /// Thickness of all layers, µm.
    pub thickness_um: f64,
    /// \[wavelength\]
    pub spectra: Vec<ComposedRow>,
    /// Colours for the composition's illuminant and observer; `None` where the wavelengths carry
    /// none.
    pub colours: Option<ComposedColours>,
    /// The print in dots, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dots: Option<PrintNumbers<ErrorParts>>,
    /// Numbers that cannot be, with the reason.
    pub withheld: Vec<Withheld>,
}

/// A composition of a library's plates, ready to be evaluated.
struct CompositionTask<'a> {
    library: &'a Library,
    /// Number of the plate and count of slabs of every layer.
    layers: Vec<(usize, f64)>,
    coupling: Coupling,
    albedos: Vec<f64>,
    eye: Option<Colorimeter>,
    dots: Option<CompositionDots>,
}

/// Composes a stack of a library's plates.
///
/// # Errors
/// Plates, thicknesses, papers and conditions that there are not.
pub fn compose(library: &Library, composition: &Composition) -> Result<ComposedStack, String> {
    let (task, thickness_um) = CompositionTask::new(library, composition)?;
    let whole = task.level(false)?;
    let half = task.level(true)?;
    // what cannot be joined is said once
    for level in [&whole, &half] {
        (0..library.wavelengths_nm.len())
            .try_for_each(|w| task.stack(level, w, Change::default()).map(drop))?;
    }
    let numbers = judged(&|level, change| task.numbers(level, change), [&whole, &half], None).numbers;
    let layer = numbers.requested.into_iter().next().ok_or("nothing composed")?;
    let row = |(&wavelength_nm, numbers): (&f64, &LayerNumbers<ErrorParts>)| ComposedRow {
        thickness_um,
        wavelength_nm,
        layer: numbers.map(Some),
    };
    let all: Vec<ComposedRow> = library.wavelengths_nm.iter().zip(&layer.spectra).map(row).collect();
    let mut kept = all.clone();
    let mut withheld = rows(&mut kept, false);
    let mut colours = None;
    if let Some((eye, numbers)) = task.eye.as_ref().zip(layer.colours.as_ref()) {
        let seen = visible(&library.wavelengths_nm);
        let in_colour = LayerInColour { eye, all: &all[seen.clone()], kept: &kept[seen] };
        let (found, without) = in_colour.colours(numbers);
        colours = Some(found);
        withheld.extend(without);
    }
    let dots = layer.prints.into_iter().next();
    let composition = composition.clone();
    Ok(ComposedStack { composition, thickness_um, spectra: kept, colours, dots, withheld })
}

impl<'a> CompositionTask<'a> {
    /// With the thickness of all layers, µm.
    fn new(library: &'a Library, composition: &Composition) -> Result<(Self, f64), String> {
        let Composition { layers, paper, dots, illuminant, observer } = composition;
        if layers.is_empty() {
            return Err("layers: found none; allowed is one or more: name a plate of the library".to_owned());
        }
        let mut placed = Vec::new();
        let mut thickness_um = 0.0;
        for (number, layer) in layers.iter().enumerate() {
            let at = |error: String| format!("layers[{number}].{error}");
            let plate = library.plate(&layer.plate).map_err(at)?;
            let count = library.plates[plate].count(layer.thickness_um).map_err(at)?;
            thickness_um += count * library.plates[plate].thickness_um;
            placed.push((plate, count));
        }
        if let Some(dots) = dots {
            dots.check()?;
        }
        let nm = &library.wavelengths_nm;
        let albedo = |nm: &f64| paper.albedo.at(*nm).map_err(|error| format!("paper.albedo: {error}"));
        let viewing =
            Viewing::new(illuminant, observer, Summation::Plain).map_err(|error| error.to_string())?;
        let coupling = match paper.contact {
            true => Coupling::OpticalContact { index: library.joint.index },
            false => Coupling::Gap,
        };
        let task = Self {
            library,
            layers: placed,
            coupling,
            albedos: nm.iter().map(albedo).collect::<Result<_, _>>()?,
            eye: Colorimeter::under(&nm[visible(nm)], &viewing).ok(),
            dots: *dots,
        };
        Ok((task, thickness_um))
    }

    /// The portions of every plate that is used, once.
    fn level(&self, halved: bool) -> Result<Level, String> {
        let mut plates: Vec<usize> = self.layers.iter().map(|(plate, _)| *plate).collect();
        plates.sort_unstable();
        plates.dedup();
        let mut portions: Vec<KeptPortion> = Vec::new();
        for plate in plates {
            portions.extend(self.library.portions_of(plate, halved)?);
        }
        let wavelengths_um = self.library.wavelengths_nm.iter().map(|nm| 1e-3 * nm).collect();
        Level::of_library(portions, halved, wavelengths_um)
            .ok_or_else(|| "a library without plates".to_owned())
    }

    /// The stack at one wavelength.
    fn stack(&self, level: &Level, wavelength: usize, change: Change) -> Result<PlateStack, String> {
        let Library { joint, plates, wavelengths_nm, .. } = self.library;
        let mut elements = Vec::new();
        for (layer, &(number, count)) in self.layers.iter().enumerate() {
            let plate = &plates[number];
            let mean = |position| level.mean([number, wavelength], position, change);
            let own = slab_elements(mean, level.halved, count, plate.within[wavelength], layer);
            let lacks = || format!("plate {:?}: lacks a portion; gather the library again", plate.name);
            elements.extend(own.ok_or_else(lacks)?);
        }
        let before = Hemisphere { oblique_deg: Some(PRINT_DEG), ..joint.medium(1.0) };
        let within = joint.hemisphere();
        let behind = joint.medium(self.coupling.index_out());
        between_faces(elements, [&before, &within, &behind], 1e-3 * wavelengths_nm[wavelength])
    }

    /// All numbers of the composition.
    fn numbers(&self, level: &Level, change: Change) -> ComposedNumbers<f64> {
        let mut spectra = Vec::new();
        let mut optics = Vec::new();
        for (wavelength, albedo) in self.albedos.iter().enumerate() {
            // joined before: an error is impossible here
            let Ok(stack) = self.stack(level, wavelength, change) else { continue };
            let film = stack.film(change.fewer_directions);
            let layer = ComposedLayer::of_stack(&stack, &film, self.library.wave);
            let own = spectral(&layer, self.library.wave, MirroredSky::Included, *albedo);
            optics.push(own.at_45);
            spectra.push(own.numbers);
        }
        let colours = self.eye.as_ref().map(|eye| {
            let seen = visible(&self.library.wavelengths_nm);
            colours_of(eye, &spectra[seen]).unwrap_or(ColourNumbers::unknown())
        });
        let prints = self.dots.iter().map(|dots| self.print(*dots, &optics)).collect();
        ComposedNumbers {
            requested: vec![ThicknessNumbers { spectra, colours, weighted: Vec::new(), prints }],
            curve: Vec::new(),
            hiding: None,
            medium: Vec::new(),
            distributions: Vec::new(),
            absorbed: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// The print in dots at 45:0.
    fn print(&self, dots: CompositionDots, optics: &[AreaOptics]) -> PrintNumbers<f64> {
        let surface = BareSurface::new(self.coupling);
        let [entering, leaving] = surface.passed(PaperGeometry::LitAt45);
        let bare = AreaOptics { own: 0.0, entering, leaving, lost: surface.escaping() };
        let spread = spread_share(dots.coverage, dots.ruling_per_cm / UM_PER_CM, dots.spread_um);
        let factors = |coverage: f64| -> Vec<f64> {
            let mix = AreaMix { shares: vec![coverage, 1.0 - coverage], spread };
            let factor = |(area, albedo): (&AreaOptics, &f64)| mix.factor(&[*area, bare], *albedo, &[]);
            optics.iter().zip(&self.albedos).map(factor).collect()
        };
        let colour = |factors: &[f64]| {
            let seen = &factors[visible(&self.library.wavelengths_nm)];
            self.eye.as_ref().and_then(|eye| eye.colour(seen).ok())
        };
        let luminance = |coverage: f64| colour(&factors(coverage)).map_or(f64::NAN, |colour| colour.xyz[1]);
        let printed = factors(dots.coverage);
        let lab = colour(&printed).map_or([f64::NAN; 3], |colour| colour.lab);
        let [paper, tint] = [luminance(0.0), luminance(dots.coverage)];
        let apparent = murray_davies(paper, tint, luminance(1.0));
        // of one ink there is no sum of densities to compare with
        PrintNumbers {
            lab,
            apparent,
            density: -(tint / paper).log10(),
            additivity: f64::NAN,
            factors: printed,
        }
    }
}

impl CompositionDots {
    fn check(&self) -> Result<(), String> {
        let judge = |field: &str, value: f64, from: f64, to: f64| {
            let words = format!("dots.{field}: found {value}; allowed {from} to {to}");
            (from..=to).contains(&value).then_some(()).ok_or(words)
        };
        judge("coverage", self.coverage, 0.0, 1.0)?;
        judge("ruling_per_cm", self.ruling_per_cm, 1.0, 1000.0)?;
        judge("spread_um", self.spread_um, 0.0, 10_000.0)
    }
}
