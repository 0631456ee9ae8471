//! A checked study: the only input of a run.

mod composed;
mod given_grid;
mod kind;
mod moved;
mod number;
mod parts;
mod scalar_surface;
mod stack;
mod substack;
mod written;

pub use super::file::TargetColour;
pub use composed::{Composed, LayerPlates, Portion, Position, StackMedia, StackedPortion};
pub use kind::StudyKind;
pub use moved::InputMove;
pub use number::{WantedNumber, WantedWeights};
pub use parts::{Angles, Dissolved, Dots, IndexSpectrum, Judgement, Layer, MeasuredPaper, MixedAreas};
pub use parts::{MixedPrint, Paper};
pub use parts::{Pigment, StackLayer, WantedResolution};
pub use scalar_surface::{PaperFactors, ScalarSurface};
pub use substack::Substack;
pub use written::WrittenAngles;

use super::file::OutputTable;
use super::variation::{CellRule, Draw, LightRule, Variation, signs, stratified_deg};
use crate::ink::PackingRequest;
use crate::solve::{Goal, SolverChoice};
use crate::store::identity::Key;
use crate::wave::Wave;
use crate::wave::maxwell::Polarisation;
use crate::wave::{Incidence, Media, Side};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Everything that was requested, checked; only [`super::check`] creates it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "written::WrittenStudy", into = "written::WrittenStudy")]
pub struct Study {
    /// Title of the report.
    pub title: String,
    /// What is computed of the layer.
    pub kind: StudyKind,
    /// The layer and its surroundings; of a stack the whole of it, with the binder of the first.
    pub layer: Layer,
    /// The layers of a stack, in the order of the light; empty for a single layer.
    pub stack: Vec<StackLayer>,
    /// Whether the stack is also solved without each of its layers, and each layer alone
    /// ([`Study::substacks`]).
    pub without_layers: bool,
    /// The pigments with grains, in order.
    pub pigments: Vec<Pigment>,
    /// Pigments without grains (`diameter_nm = "molecular"`), which are included in the index of
    /// `layer.binder`.
    pub dissolved: Vec<Dissolved>,
    /// The packing of the nominal cell; realisations differ in their cell and random stream.
    pub packing: PackingRequest,
    /// The paper under the layer.
    pub paper: Paper,
    /// Vacuum wavelengths, nm, increasing.
    pub wavelengths_nm: Vec<f64>,
    /// The equation to solve, and the polarisation of the light.
    pub wave: Wave,
    /// Directions of the light.
    pub angles: Angles,
    /// Maximum number of packings.
    pub realisations: usize,
    /// The run may end once the 95 % interval of the colours is below this, ΔE₀₀.
    pub target_delta_e: Option<f64>,
    /// Colours to which the target applies.
    pub target_colour: TargetColour,
    /// Largest share of packings that may have no room; no solve depends on it.
    pub failed_packings: f64,
    /// How realisations vary.
    pub variation: Variation,
    /// The requested grid or accuracy.
    pub resolution: WantedResolution,
    /// The strategy with its settings.
    pub solver: SolverChoice,
    /// Residual to reach, and maximum number of operator applications.
    pub goal: Goal,
    /// Folder and pictures.
    pub output: OutputTable,
    /// Conditions and measurements that the prediction is compared with; no solve depends on them.
    pub judgement: Judgement,
    /// Weighted numbers of the spectra; no solve depends on them.
    pub numbers: Vec<WantedNumber>,
    /// Remarks for the user on what the file leaves open, one line each; they are not written.
    pub remarks: Vec<String>,
}

/// Minimum number of realisations for cells to be shared in pairs. The scatter of fewer than four
/// pairs is too uncertain, and chance moves the mean of so few cells more than their constant
/// volume fraction does.
const FEWEST_PAIRED: usize = 8;

/// One solve of the study.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// Index of the wavelength among those of the realisation.
    pub wavelength: usize,
    /// Wavelength, direction and side of the light.
    pub incidence: Incidence,
    /// Its polarisation; `None` for the scalar wave.
    pub polarisation: Option<Polarisation>,
}

impl Study {
    /// Content hash of everything the results depend on: all but the title and the form of the
    /// output.
    pub fn key(&self) -> Key {
        let whole = self.key_of_layer();
        match self.portion() {
            Some(portion) => Key::of("portion", &(portion, whole)),
            None if self.without_layers => Key::of("study with substacks", &whole),
            None => whole,
        }
    }

    /// The content hash without what distinguishes the slabs of a composed layer.
    fn key_of_layer(&self) -> Key {
        let ensemble =
            (self.written_layer(), &self.pigments, &self.packing, self.realisations, &self.variation);
        let ends = (self.target_delta_e, self.target_colour);
        let light = (self.wave, &self.paper, &self.wavelengths_nm, self.written_angles());
        Key::of("study", &(ensemble, ends, light, &self.resolution, &self.solver, &self.goal))
    }

    /// The packing of a realisation, with its own cell and its own random stream.
    pub fn packing_request(&self, realisation: usize) -> PackingRequest {
        let draw = self.draw(realisation);
        let whole = PackingRequest {
            stream: realisation as u64,
            period_um: draw.period_um,
            thickness_um: draw.thickness_um,
            ..self.packing.clone()
        };
        let signs = self.partner(realisation).map(|_| signs(realisation, self.pigments.len()));
        if !self.stack.is_empty() {
            return self.stacked(whole, signs.as_deref());
        }
        let request = if let Some(portion) = self.portion() { portion.packed(whole) } else { whole };
        signs.map_or_else(|| request.clone(), |signs| request.fluctuating(&signs))
    }

    /// The other realisation in the same cell, whose pigment volumes deviate from the requested
    /// ones by the opposite amounts, as in windows of a wide layer
    /// ([`PackingRequest::fluctuating`]); `None` for cells that do not vary, without grains, for
    /// fewer than eight realisations, and for the last of an odd number.
    pub fn partner(&self, realisation: usize) -> Option<usize> {
        let other = realisation ^ 1;
        (self.pairs_cells() && other < self.realisations).then_some(other)
    }

    /// Whether a realisation is also solved on a finer grid, as a check on the coarse one that all
    /// are solved on: four of the first eight where `target_delta_e` is all that is wanted, one of
    /// each pair, more pigment and less in turn.
    pub fn is_checked(&self, realisation: usize) -> bool {
        self.has_two_levels() && realisation < 8 && matches!(realisation % 4, 0 | 3)
    }

    /// Whether some realisations are also solved on a finer grid.
    pub fn has_two_levels(&self) -> bool {
        let chosen = matches!(self.resolution, WantedResolution::Accuracy { .. });
        let plain = matches!(self.kind, StudyKind::InkOnPaper | StudyKind::LayerAlone(_));
        self.target_delta_e.is_some() && chosen && plain && self.pairs_cells()
    }

    /// Why there is no ink on paper: directions are missing, or each realisation of grains has a
    /// single wavelength of a range, which tells nothing of the spectrum's slope.
    pub fn no_ink(&self) -> Option<String> {
        let single = matches!(self.variation.light, LightRule::Shifted { strata: 1, .. });
        let words = "light.step_nm and light.per_realisation give 1 wavelength per realisation of a range: a colour needs at \
                     least 2, better 10; step_nm = 20 is usual";
        let colourless = (single && !self.pigments.is_empty()).then(|| words.to_owned());
        self.no_paper().map(str::to_owned).or(colourless)
    }

    /// Whether realisations share cells in pairs.
    pub(super) fn pairs_cells(&self) -> bool {
        self.variation.cell == CellRule::Varied
            && !self.pigments.is_empty()
            && self.realisations >= FEWEST_PAIRED
    }

    /// Content hash of everything that the packings of all realisations depend on. The first
    /// packing is not enough: cells are drawn to hold whole grains, so two nominal periods may
    /// agree in one realisation and differ in the next.
    pub fn packings_key(&self) -> Key {
        let (layer, variation) = (&self.layer, &self.variation);
        let cell = (layer.period_um, layer.thickness_um, variation.cell, variation.thickness_std_um);
        match self.portion() {
            None => Key::of("packings", &(&self.packing, cell)),
            Some(portion) => Key::of("packings of a slab", &(&self.packing, cell, portion.packing_place())),
        }
    }

    /// Materials of the grains in the order of [`Media::inclusions`]: the pigments' own (the core's
    /// in grains with layers), then all layers, from the core outwards.
    pub fn materials(&self) -> impl Iterator<Item = &IndexSpectrum> {
        self.pigments.iter().map(|p| &p.material).chain(self.pigments.iter().flat_map(|p| &p.shell))
    }

    /// Indices of the extraordinary rays of birefringent pigments, in order; in
    /// [`Media::inclusions`] they stand behind those of all materials.
    pub fn extraordinary_indices(&self) -> impl Iterator<Item = &IndexSpectrum> {
        self.pigments.iter().filter_map(|pigment| pigment.extraordinary.as_ref())
    }

    /// Fractions of these materials of the volume of the layer that holds them.
    pub fn material_shares(&self) -> Vec<f64> {
        let (mut cores, mut layers) = (Vec::new(), Vec::new());
        for grains in self.pigments.iter().map(|p| &p.grains) {
            let mut shares = grains.layer_shares().into_iter().map(|s| s * grains.volume_fraction);
            cores.extend(shares.next());
            layers.extend(shares);
        }
        cores.into_iter().chain(layers).collect()
    }

    /// Names of these materials.
    pub fn material_names(&self) -> Vec<String> {
        let layer = |p: &Pigment, i: usize| match p.shell.len() {
            1 => format!("{} shell", p.name),
            _ => format!("{} shell {}", p.name, i + 1),
        };
        let layers = self.pigments.iter().flat_map(|p| (0..p.shell.len()).map(move |i| layer(p, i)));
        self.pigments.iter().map(|p| p.name.clone()).chain(layers).collect()
    }

    /// Indices at one wavelength; the inclusions are those of [`Study::materials`], then the
    /// extraordinary indices of birefringent ones.
    pub fn media(&self, wavelength_um: f64) -> Media {
        let mut media = self.mean_media(wavelength_um);
        for (number, pigment) in self.pigments.iter().enumerate() {
            let Some(extraordinary) = &pigment.extraordinary else { continue };
            media.inclusions[number] = pigment.material.index_at(wavelength_um);
            media.inclusions.push(extraordinary.index_at(wavelength_um));
        }
        media
    }

    /// Indices at one wavelength; the inclusions are those of [`Study::materials`], with the mean
    /// over all directions of the axis for birefringent ones.
    pub fn mean_media(&self, wavelength_um: f64) -> Media {
        let (backgrounds, inclusions) = self.binders_and_pigments(wavelength_um);
        let [incident, exit] = self.outer_indices(wavelength_um).map(Complex64::from);
        Media { incident, exit, backgrounds, inclusions }
    }

    /// Indices within a single layer at one wavelength, means for birefringent pigments.
    pub(super) fn binder_and_pigments(&self, wavelength_um: f64) -> (Complex64, Vec<Complex64>) {
        let (backgrounds, inclusions) = self.binders_and_pigments(wavelength_um);
        (backgrounds[0], inclusions)
    }

    /// Indices of all media for a content hash: incident side, exit side, binder, pigments.
    pub fn indices(&self, wavelength_um: f64) -> Vec<Complex64> {
        let Media { incident, exit, backgrounds, inclusions } = self.media(wavelength_um);
        [incident, exit].into_iter().chain(backgrounds).chain(inclusions).collect()
    }

    /// The wave if it satisfies Maxwell's equations, for content hashes.
    pub fn vector_wave(&self) -> Option<Wave> {
        self.wave.is_vector().then_some(self.wave)
    }

    /// Polarisations in which every direction is solved; a single `None` for the scalar wave. Paper
    /// depolarises: light returned by it through the layer is unpolarised, so ink on paper needs
    /// both polarisations, whatever the illumination.
    pub fn polarisations(&self) -> &'static [Option<Polarisation>] {
        const BOTH: [Option<Polarisation>; 2] = [Some(Polarisation::S), Some(Polarisation::P)];
        let on_paper = self.no_paper().is_none();
        match self.wave {
            Wave::Scalar => &[None],
            Wave::S if !on_paper => &BOTH[..1],
            Wave::P if !on_paper => &BOTH[1..],
            Wave::S | Wave::P | Wave::Unpolarised => &BOTH,
        }
    }

    /// All solves of one realisation, in order: wavelength; exact angles, strata, strata from the
    /// exit side; polarisation.
    pub fn points(&self, realisation: usize) -> Vec<Point> {
        let draw = self.draw(realisation);
        let mut points = Vec::new();
        for (wavelength, nm) in self.solved_wavelengths_nm(&draw).into_iter().enumerate() {
            for incidence in self.incidences(&draw, wavelength, nm) {
                let point = |&polarisation: &_| Point { realisation, wavelength, incidence, polarisation };
                points.extend(self.polarisations().iter().map(point));
            }
        }
        points
    }

    /// All directions of a realisation at the wavelength with this index: exact angles, strata,
    /// strata from the exit side.
    fn incidences(&self, draw: &Draw, wavelength: usize, nm: f64) -> Vec<Incidence> {
        let Angles { exact_deg, strata, exit_strata, .. } = &self.angles;
        // Slabs are turned by the wavelength itself: a part of the list keeps its solves.
        let turns = if self.portion().is_some() { nm.round() as usize } else { wavelength };
        let (azimuth_deg, direction) = self.turn(draw, turns);
        if let Some(sides) = self.sides(nm * 1e-3) {
            return composed::portion_incidences(&sides, nm * 1e-3, azimuth_deg);
        }
        let incident = exact_deg.iter().copied().chain(stratified_deg(*strata, direction));
        let incident = incident.map(|deg| (Side::Incident, deg));
        let exit = stratified_deg(*exit_strata, direction).into_iter().map(|deg| (Side::Exit, deg));
        let lit = |(from, polar_deg)| Incidence { wavelength_um: nm * 1e-3, polar_deg, azimuth_deg, from };
        incident.chain(exit).map(lit).collect()
    }

    /// Volume of the nominal cell, µm³.
    pub fn volume_um3(&self) -> f64 {
        self.layer.period_um[0] * self.layer.period_um[1] * self.layer.thickness_um
    }

    /// Number of solves of one realisation on one grid.
    pub fn solves_each(&self) -> usize {
        if self.portion().is_some() {
            return self.points(0).len();
        }
        self.solved_wavelengths() * self.angles.count() * self.polarisations().len()
    }

    /// Number of solves of the whole study, those of its [`Study::substacks`] included.
    pub fn solves(&self) -> usize {
        if self.composed().is_some() {
            return self.portions().iter().map(Study::solves).sum();
        }
        let of_substacks: usize = self.substacks().iter().map(|part| part.study.solves()).sum();
        self.own_solves() + of_substacks
    }

    /// Number of solves of the layer or stack that is solved as a whole.
    pub fn own_solves(&self) -> usize {
        (0..self.realisations).map(|r| self.solves_of(r)).sum()
    }

    /// Number of solves of a realisation: on both grids if it is checked, and with the tables of
    /// indices moved by their errors.
    pub fn solves_of(&self, realisation: usize) -> usize {
        self.solves_each()
            * (1 + usize::from(self.is_checked(realisation)) + self.moves_of(realisation).len())
    }
}
