//! Stacks of a library's plates on paper, composed without a solve.
//!
//! ```text
//! air | face | plate | plate | … | (face) | paper
//! ```
//!
//! The plates lie in the joint's medium, plane faces lead from there to the air in front and to the
//! gap behind; a paper in optical contact has the joint's index. Everything else is what a run
//! makes of a composed stack: the same fluxes, the same mean wave, the same series of the paper and
//! the same bars. Of layers in dots every overprint is composed as a stack of its own.

mod dots;
mod paper;

use super::between::{FilmLayer, FilmStack, Fringes};
use super::errors::judged;
use super::gate::{LayerInColour, rows};
use super::layer::ComposedLayer;
use super::level::{Change, KeptPortion, Level};
use super::library::Library;
use super::numbers::colours_of;
use super::spectral::{SpectralLayer, brightened, spectral};
use super::stacked::{between_faces, slab_elements};
use crate::appearance::bare_paper::{BareSurface, PaperGeometry};
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::stack::PlateStack;
use crate::appearance::halftone::murray_davies;
use crate::appearance::paper::{Coupling, MirroredSky, PRINT_DEG};
use crate::appearance::paper_series::{AreaMix, AreaOptics};
use crate::appearance::tristimulus::{Colorimeter, EmissionWeights, visible};
use crate::appearance::viewing::{Summation, Viewing};
use crate::evaluate::manifest::composed::{ComposedColours, ComposedRow};
use crate::evaluate::printed::open_between;
use crate::evaluate::prints::{Brightened, LitAreas, PrintNumbers, paper_between};
use crate::evaluate::published::{ErrorParts, Withheld};
use crate::evaluate::quantities::{ColourNumbers, ComposedNumbers, LayerNumbers, ThicknessNumbers};
use crate::input::measured::MeasuredCondition;
use crate::input::study::ScalarSurface;
use crate::wave::Wave;
use dots::KindsOfArea;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use dots::CompositionDots;
pub use paper::{CompositionFluorescence, CompositionPaper};

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
    /// Illuminant of the colours: any of a study's `colour.illuminant`, such as `D50`, `A`, `F11`
    /// or `LED_B3`.
    #[serde(default = "daylight")]
    pub illuminant: String,
    /// Observer of the colours: `2`, `10`, `2015_2` or `2015_10`.
    #[serde(default = "standard")]
    pub observer: String,
    /// Light that excites the paper's brightener: M0 (a lamp), M1 (D50) or M2 (D50 without
    /// ultraviolet); that of the illuminant when left out. M3 is refused.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<MeasuredCondition>,
}

/// One layer of a composition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompositionLayer {
    /// Name of a plate.
    pub plate: String,
    /// Thickness, µm: of plates in slabs any from two slabs on (two when left out), of others the
    /// solved one alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thickness_um: Option<f64>,
    /// Share of the area that it covers in dots, 0 to 1, in a composition with `dots`; all of it
    /// when left out. Up to six layers may have one; they lie over each other at random (Demichel).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage: Option<f64>,
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
    /// What the scalar wave makes of the surface of the paper between the dots.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scalar_surface: Option<ScalarSurface>,
}

/// A composition of a library's plates, ready to be evaluated.
struct CompositionTask<'a> {
    library: &'a Library,
    /// Number of the plate and count of slabs of every layer.
    layers: Vec<(usize, f64)>,
    coupling: Coupling,
    albedos: Vec<f64>,
    eye: Option<Colorimeter>,
    /// The paper under the light that excites it, where it fluoresces.
    light: Option<Brightened>,
    /// How the eye sums what the paper emits under a lamp with lines.
    emission: Option<EmissionWeights>,
    /// What the paper does of L*, a*, b* between the wavelengths, bare.
    paper: [f64; 3],
    /// The print in dots, if it is one.
    areas: Option<KindsOfArea>,
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
            .try_for_each(|w| task.stack(level, w, Change::default(), &task.layers).map(drop))?;
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
    // what is emitted may exceed what came in
    let fluoresces = task.light.is_some();
    let mut withheld = rows(&mut kept, fluoresces);
    let mut colours = None;
    let values: Vec<LayerNumbers<f64>> =
        layer.spectra.iter().map(|row| row.map(|number| number.value)).collect();
    let fringes = task.films().fringes(&library.wavelengths_nm, &values);
    if let Some((eye, numbers)) = task.eye.as_ref().zip(layer.colours.as_ref()) {
        let seen = visible(&library.wavelengths_nm);
        let paper = task.paper;
        let in_colour = LayerInColour {
            eye,
            all: &all[seen.clone()],
            kept: &kept[seen.clone()],
            paper,
            fluoresces,
            fringes: fringes.as_ref().map(|fringes| (fringes, seen)),
        };
        let (found, without) = in_colour.colours(numbers);
        colours = Some(found);
        withheld.extend(without);
    }
    let print = layer.prints.into_iter().next();
    let dots = print.map(|print| task.between_wavelengths(print, fringes.as_ref()));
    let scalar_surface = task.scalar_surface();
    let composition = composition.clone();
    Ok(ComposedStack { composition, thickness_um, spectra: kept, colours, dots, withheld, scalar_surface })
}

impl<'a> CompositionTask<'a> {
    /// With the thickness of all layers, µm.
    fn new(library: &'a Library, composition: &Composition) -> Result<(Self, f64), String> {
        let Composition { layers, paper, dots, illuminant, observer, condition } = composition;
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
        if let (None, Some(number)) = (dots, layers.iter().position(|layer| layer.coverage.is_some())) {
            return Err(format!(
                "layers[{number}].coverage: found one without a screen; allowed beside dots = {{ ruling_per_cm = 60, spread_um = 40 }}"
            ));
        }
        let areas = dots.as_ref().map(|dots| dots.areas(layers)).transpose()?;
        let nm = &library.wavelengths_nm;
        let viewing =
            Viewing::new(illuminant, observer, Summation::Plain).map_err(|error| error.to_string())?;
        let paper = paper.checked(library.joint.index, nm)?;
        let albedo = |nm: &f64| paper.albedo.at(*nm).map_err(|error| format!("paper.albedo: {error}"));
        let light = paper::lit(&paper, nm, *condition, &viewing)?;
        let eye = Colorimeter::under(&nm[visible(nm)], &viewing).ok();
        let emission = light.as_ref().zip(eye.as_ref()).and_then(|(light, eye)| light.emission(eye, nm));
        let task = Self {
            library,
            paper: paper_between(&paper, nm, light.as_ref(), &viewing),
            layers: placed,
            coupling: paper.coupling,
            albedos: nm.iter().map(albedo).collect::<Result<_, _>>()?,
            eye,
            light,
            emission,
            areas,
        };
        Ok((task, thickness_um))
    }

    /// Even films in place of the layers.
    fn films(&self) -> FilmStack {
        let film = |&(number, count): &(usize, f64)| {
            let plate = &self.library.plates[number];
            FilmLayer { indices: plate.within.clone(), thickness_um: count * plate.thickness_um }
        };
        let index_out = if let Coupling::OpticalContact { index } = self.coupling { index } else { 1.0 };
        FilmStack {
            layers: self.layers.iter().map(film).collect(),
            index_out,
            wave: self.library.wave,
            excludes_mirrored: false,
        }
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

    /// A stack of these layers at one wavelength.
    fn stack(
        &self,
        level: &Level,
        wavelength: usize,
        change: Change,
        layers: &[(usize, f64)],
    ) -> Result<PlateStack, String> {
        let Library { joint, plates, wavelengths_nm, .. } = self.library;
        let mut elements = Vec::new();
        for (layer, &(number, count)) in layers.iter().enumerate() {
            let plate = &plates[number];
            let mean = |position| level.mean([number, wavelength], position, change);
            let own = slab_elements(mean, level.halved, count, layer);
            let lacks = || format!("plate {:?}: lacks a portion; gather the library again", plate.name);
            elements.extend(own.ok_or_else(lacks)?);
        }
        let before = Hemisphere { oblique_deg: Some(PRINT_DEG), ..joint.medium(1.0) };
        let within = joint.hemisphere();
        let behind = joint.medium(self.coupling.index_out());
        between_faces(elements, [&before, &within, &behind], 1e-3 * wavelengths_nm[wavelength])
    }

    /// These layers on the paper at every wavelength.
    fn spectra(&self, level: &Level, change: Change, layers: &[(usize, f64)]) -> Vec<SpectralLayer> {
        let wave = self.library.wave;
        let mut all = Vec::new();
        for (wavelength, albedo) in self.albedos.iter().enumerate() {
            // joined before: an error is impossible here
            let Ok(stack) = self.stack(level, wavelength, change, layers) else { continue };
            let film = stack.film(change.fewer_directions);
            let layer = ComposedLayer::of_stack(&stack, &film, wave);
            all.push(spectral(&layer, wave, MirroredSky::Included, *albedo));
        }
        match &self.light {
            Some(light) => brightened(all, light, &self.library.wavelengths_nm, &self.albedos),
            None => all,
        }
    }

    /// All numbers of the composition.
    fn numbers(&self, level: &Level, change: Change) -> ComposedNumbers<f64> {
        let solid = self.spectra(level, change, &self.layers);
        let optics = |all: &[SpectralLayer]| -> Vec<AreaOptics> { all.iter().map(|own| own.at_45).collect() };
        let prints = self.areas.iter().map(|areas| {
            let kind = |layers: &Vec<usize>| match layers.len() {
                0 => vec![self.bare(); self.albedos.len()],
                count if count == self.layers.len() => optics(&solid),
                _ => {
                    let own: Vec<(usize, f64)> = layers.iter().map(|&layer| self.layers[layer]).collect();
                    optics(&self.spectra(level, change, &own))
                }
            };
            self.print(areas, &areas.kinds.iter().map(kind).collect::<Vec<_>>())
        });
        let prints = prints.collect();
        let colours = self.eye.as_ref().map(|eye| {
            let seen = visible(&self.library.wavelengths_nm);
            colours_of(eye, self.emission.as_ref(), &solid[seen]).unwrap_or(ColourNumbers::unknown())
        });
        let spectra: Vec<LayerNumbers<f64>> = solid.into_iter().map(|own| own.numbers).collect();
        ComposedNumbers::of_requested(vec![ThicknessNumbers {
            spectra,
            colours,
            weighted: Vec::new(),
            prints,
        }])
    }

    /// A print with what the wavelengths leave open of its L*, a*, b*.
    fn between_wavelengths(
        &self,
        print: PrintNumbers<ErrorParts>,
        fringes: Option<&Fringes>,
    ) -> PrintNumbers<ErrorParts> {
        let Some(eye) = &self.eye else { return print };
        let seen = visible(&self.library.wavelengths_nm);
        let inked = self.areas.as_ref().map_or(1.0, KindsOfArea::inked);
        let films = fringes.map(|fringes| fringes.of_print(seen.clone(), inked));
        let factors: Vec<f64> = print.factors.iter().map(|factor| factor.value).collect();
        let mut open = open_between(eye, &factors[seen], films.as_ref());
        open.iter_mut().zip(self.paper).for_each(|(open, paper)| *open = open.hypot(paper));
        let mut lab = print.lab;
        for (lab, wavelengths) in lab.iter_mut().zip(open) {
            *lab = ErrorParts { wavelengths, ..*lab }.summed();
        }
        PrintNumbers { lab, ..print }
    }

    /// What the scalar wave makes of paper that is seen bare between dots, in unpolarised light.
    fn scalar_surface(&self) -> Option<ScalarSurface> {
        let is_bare_seen = self.areas.is_some() && self.library.wave == Wave::Scalar;
        let rows = self.library.wavelengths_nm.iter().copied().zip(self.albedos.iter().copied());
        ScalarSurface::of_rows(rows.filter(|_| is_bare_seen), self.coupling)
    }

    /// Bare paper at 45:0.
    fn bare(&self) -> AreaOptics {
        let surface = BareSurface::new(self.coupling);
        let [entering, leaving] = surface.passed(PaperGeometry::LitAt45);
        AreaOptics { own: 0.0, entering, leaving, lost: surface.escaping() }
    }

    /// Factors of kinds of area at 45:0, and X, Y, Z, NaN where the wavelengths carry no colour.
    fn seen(&self, mix: &AreaMix, kinds: &[&[AreaOptics]]) -> (Vec<f64>, [f64; 3]) {
        let nm = &self.library.wavelengths_nm;
        let emitted = self.light.as_ref().map(|light| light.below(mix, kinds, nm));
        let lit =
            LitAreas { mix, kinds, albedos: &self.albedos, emitted: emitted.as_ref(), wavelengths_nm: nm };
        let xyz = self.eye.as_ref().and_then(|eye| lit.xyz(eye, self.emission.as_ref()).ok());
        (lit.factors(), xyz.unwrap_or([f64::NAN; 3]))
    }

    /// The print in dots at 45:0; `optics` are those of every kind of area, wavelength by
    /// wavelength.
    fn print(&self, areas: &KindsOfArea, optics: &[Vec<AreaOptics>]) -> PrintNumbers<f64> {
        let kinds: Vec<&[AreaOptics]> = optics.iter().map(Vec::as_slice).collect();
        let alone = |kind: usize| {
            let shares = (0..kinds.len()).map(|k| f64::from(u8::from(k == kind))).collect();
            self.seen(&AreaMix { shares, ..areas.mix.clone() }, &kinds).1[1]
        };
        let (printed, xyz) = self.seen(&areas.mix, &kinds);
        let lab = self.eye.as_ref().map_or([f64::NAN; 3], |eye| eye.colour_of(xyz).lab);
        let tint = xyz[1];
        let paper = alone(0);
        // several inks have no one coverage, and no solids of each to sum densities of
        let is_one = areas.inks == 1;
        let apparent = if is_one { murray_davies(paper, tint, alone(kinds.len() - 1)) } else { f64::NAN };
        PrintNumbers {
            lab,
            xyz,
            apparent,
            density: -(tint / paper).log10(),
            additivity: f64::NAN,
            factors: printed,
        }
    }
}
