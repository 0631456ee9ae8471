//! Slabs of one thickness: their ensembles, and the mean flux matrices that layers are composed of.

use crate::appearance::composed::flux::{Coherent, Fluxes, Hemisphere, Lit, Sides};
use crate::appearance::composed::fringes::CoherentFilm;
use crate::appearance::composed::plate::Plate;
use crate::evaluate::seen::complete_cells;
use crate::input::study::{Position, Study};
use crate::run::{Collected, Realisation};
use crate::store::record::PointRecord;
use crate::wave::maxwell::Polarisation;
use crate::wave::{Order, Side};
use num_complex::Complex64;

/// A portion's study and what was solved of it.
pub type SolvedPortion = (Study, Collected);

/// One portion at all wavelengths.
struct Ensemble {
    /// Layer of a stack, from 0.
    layer: usize,
    position: Position,
    /// Thickness, µm.
    slab_um: f64,
    states: EnsembleStates,
    /// Expected error of R from the grid.
    grid_error: f64,
    /// Permittivity of its even medium, \[wavelength\].
    permittivities: Vec<Complex64>,
}

/// What is known of a portion at every wavelength.
enum EnsembleStates {
    /// Its media, and the fluxes of every cell.
    Solved(Vec<(Sides, Vec<Fluxes>)>),
    /// What a library keeps.
    Kept(Vec<KeptStates>),
}

/// Fluxes and amplitudes of a portion at one wavelength.
#[derive(Clone, Debug)]
pub struct PortionStates {
    /// Its fluxes.
    pub plate: Plate,
    /// Its mean amplitudes.
    pub coherent: Coherent,
}

/// The mean over an ensemble at one wavelength, and those that leave out one cell each.
#[derive(Clone, Debug)]
pub struct KeptStates {
    /// The media on its sides.
    pub media: [Hemisphere; 2],
    /// Of all cells.
    pub mean: PortionStates,
    /// \[cell that is left out\]
    pub replicates: Vec<PortionStates>,
}

/// A portion as a library keeps it.
#[derive(Clone, Debug)]
pub struct KeptPortion {
    /// Number of the plate that it is of, in place of the layer.
    pub layer: usize,
    /// Where it lies.
    pub position: Position,
    /// Thickness, µm.
    pub slab_um: f64,
    /// Expected error of R from the grid.
    pub grid_error: f64,
    /// Permittivity of its even medium, \[wavelength\].
    pub permittivities: Vec<Complex64>,
    /// \[wavelength\]
    pub states: Vec<KeptStates>,
}

impl Ensemble {
    /// Number of its cells.
    fn cells(&self) -> usize {
        match &self.states {
            EnsembleStates::Solved(all) => all.first().map_or(0, |(_, cells)| cells.len()),
            EnsembleStates::Kept(all) => all.first().map_or(0, |kept| kept.replicates.len()),
        }
    }

    /// The mean at one wavelength, with or without one of the cells.
    fn states(&self, wavelength: usize, left_out: Option<usize>) -> (PortionStates, [Hemisphere; 2]) {
        match &self.states {
            EnsembleStates::Solved(all) => {
                let (sides, cells) = &all[wavelength];
                let plate = sides.mean(cells, left_out);
                let coherent = sides.coherent(cells, left_out);
                (PortionStates { plate, coherent }, sides.media.clone())
            }
            EnsembleStates::Kept(all) => {
                let kept = &all[wavelength];
                let states = left_out.map_or(&kept.mean, |cell| &kept.replicates[cell]);
                (states.clone(), kept.media.clone())
            }
        }
    }
}

/// Mean fluxes and amplitudes of a portion.
pub(super) struct MeanSlab {
    /// Its fluxes.
    pub plate: Plate,
    /// Its mean amplitudes.
    pub coherent: Coherent,
    /// The media on its sides.
    pub media: [Hemisphere; 2],
    /// Permittivity of its even medium.
    pub permittivity: Complex64,
    /// Its thickness, µm.
    pub slab_um: f64,
}

/// All portions of one thickness.
pub struct Level {
    /// Thickness of a slab, µm.
    pub slab_um: f64,
    /// Whether slabs have half the thickness.
    pub halved: bool,
    portions: Vec<Ensemble>,
    wavelengths_um: Vec<f64>,
}

/// What is changed of the ensembles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Number of a portion and of its cell that is left out.
    pub left_out: Option<[usize; 2]>,
    /// Whether R is larger by the grid's error, at the cost of T.
    pub grid: bool,
    /// Whether fringes between the directions that are solved follow from fewer of them.
    pub fewer_directions: bool,
    /// Whether light that slabs scatter lacks the highest moment that its directions resolve.
    pub without_highest_moment: bool,
}

/// The slabs at one wavelength.
pub struct Slabs {
    front: Plate,
    /// One slab within the layer.
    pub inner: Plate,
    back: Plate,
    /// Media in front, within and behind.
    pub media: [Hemisphere; 3],
    /// The coherent light in them.
    pub film: CoherentFilm,
}

impl Level {
    /// The portions of one thickness; `None` unless each has realisations that are complete.
    pub fn new(portions: &[SolvedPortion], halved: bool) -> Option<Self> {
        let of_thickness = |(study, _): &&SolvedPortion| study.portion().is_some_and(|p| p.halved == halved);
        let solved: Vec<&SolvedPortion> = portions.iter().filter(of_thickness).collect();
        let slab_um = solved.first()?.0.layer.thickness_um;
        let wavelengths_um = solved[0].0.wavelengths_nm.iter().map(|nm| 1e-3 * nm).collect();
        let portions = solved.into_iter().map(ensemble).collect::<Option<Vec<_>>>()?;
        Some(Self { slab_um, halved, portions, wavelengths_um })
    }

    /// All portions of one thickness that a composed study has; `None` unless each of them has
    /// realisations that are complete: while it is solved, some may have none yet.
    pub fn complete(study: &Study, solved: &[SolvedPortion], halved: bool) -> Option<Self> {
        let is_of = |study: &Study| study.portion().is_some_and(|portion| portion.halved == halved);
        let wanted = study.portions().iter().filter(|study| is_of(study)).count();
        let found = solved.iter().filter(|(study, _)| is_of(study)).count();
        (found == wanted).then(|| Self::new(solved, halved))?
    }

    /// The portions that a library keeps of some plates, of which there is one or more.
    pub fn of_library(portions: Vec<KeptPortion>, halved: bool, wavelengths_um: Vec<f64>) -> Option<Self> {
        let slab_um = portions.first()?.slab_um;
        let ensemble = |kept: KeptPortion| Ensemble {
            layer: kept.layer,
            position: kept.position,
            slab_um: kept.slab_um,
            permittivities: kept.permittivities,
            states: EnsembleStates::Kept(kept.states),
            grid_error: kept.grid_error,
        };
        let portions = portions.into_iter().map(ensemble).collect();
        Some(Self { slab_um, halved, portions, wavelengths_um })
    }

    /// The means of all portions, without what their realisations are one by one.
    pub fn of_means(&self) -> Self {
        let states = |portion: &Ensemble, wavelength: usize| {
            let (mean, media) = portion.states(wavelength, None);
            KeptStates { media, mean, replicates: Vec::new() }
        };
        let all = 0..self.wavelengths_um.len();
        let mean = |portion: &Ensemble| Ensemble {
            states: EnsembleStates::Kept(all.clone().map(|wavelength| states(portion, wavelength)).collect()),
            permittivities: portion.permittivities.clone(),
            ..*portion
        };
        Self {
            portions: self.portions.iter().map(mean).collect(),
            wavelengths_um: self.wavelengths_um.clone(),
            ..*self
        }
    }

    /// All that a library keeps of the portions.
    pub fn kept(&self) -> Vec<KeptPortion> {
        let states = |portion: &Ensemble, wavelength: usize| {
            let (mean, media) = portion.states(wavelength, None);
            let replicates = (0..portion.cells()).map(|cell| portion.states(wavelength, Some(cell)).0);
            KeptStates { media, mean, replicates: replicates.collect() }
        };
        let kept = |portion: &Ensemble| KeptPortion {
            layer: portion.layer,
            position: portion.position,
            slab_um: portion.slab_um,
            grid_error: portion.grid_error,
            permittivities: portion.permittivities.clone(),
            states: (0..self.wavelengths_um.len()).map(|wavelength| states(portion, wavelength)).collect(),
        };
        self.portions.iter().map(kept).collect()
    }

    /// Numbers of complete cells of every portion.
    pub fn realisations(&self) -> Vec<usize> {
        self.portions.iter().map(Ensemble::cells).collect()
    }

    /// Of one portion of a layer at a wavelength; `None` where there is none at this position.
    pub(super) fn mean(
        &self,
        [layer, wavelength]: [usize; 2],
        position: Position,
        change: Change,
    ) -> Option<MeanSlab> {
        let k = self.portions.iter().position(|p| p.position == position && p.layer == layer)?;
        let portion = &self.portions[k];
        let left_out = change.left_out.filter(|out| out[0] == k).map(|out| out[1]);
        let (PortionStates { plate, coherent }, media) = portion.states(wavelength, left_out);
        let grid = if change.grid { portion.grid_error } else { 0.0 };
        let plate = plate.moved(grid);
        let plate = match change.without_highest_moment {
            true => plate.with_fewer_directions(&media, &coherent),
            false => plate,
        };
        let permittivity = portion.permittivities[wavelength];
        Some(MeanSlab { plate, coherent, media, permittivity, slab_um: portion.slab_um })
    }

    /// Mean flux matrices at every wavelength.
    pub fn slabs(&self, change: Change) -> Vec<Slabs> {
        (0..self.wavelengths_um.len()).map(|w| self.slabs_at(w, change)).collect()
    }

    fn slabs_at(&self, wavelength: usize, change: Change) -> Slabs {
        let mean = |position| self.mean([0, wavelength], position, change);
        let needed = |position| mean(position).expect("a layer has slabs within and in front");
        let MeanSlab { plate: inner, coherent: amplitudes, permittivity, .. } = needed(Position::Inner);
        let MeanSlab { plate: front, coherent: at_front, media: [before, within], .. } =
            needed(Position::Front);
        let turned = |[a, b]: Coherent| [b, a];
        let (back, at_back, behind) = match mean(Position::Back) {
            Some(MeanSlab { plate, coherent, media: [_, behind], .. }) => (plate, coherent, behind),
            None => (front.turned(), turned(at_front.clone()), before.clone()),
        };
        let film = CoherentFilm {
            slabs: [at_front, amplitudes, at_back],
            media: [before.clone(), within.clone(), behind.clone()],
            permittivity,
            slab_um: self.slab_um,
            wavelength_um: self.wavelengths_um[wavelength],
            fewer_directions: change.fewer_directions,
        };
        Slabs { front, inner, back, media: [before, within, behind], film }
    }
}

impl Slabs {
    /// A layer of this number of slabs, at least two: of a last inner slab there is a part only.
    pub fn layer(&self, count: f64) -> Plate {
        let inner = (count - 2.0).max(0.0);
        let (whole, part) = (inner.floor(), inner.fract());
        let most = self.front.then(&self.inner.repeated(whole as usize));
        if part == 0.0 {
            return most.then(&self.back);
        }
        // where a slab has no parts, there is one more or none
        let rounded = || self.inner.repeated(part.round() as usize);
        let fraction = self.inner.fraction(part, &self.media[1].weights()).unwrap_or_else(rounded);
        most.then(&fraction).then(&self.back)
    }

    /// What is in front of joint number `joint` (1 is the first), and what is behind it.
    pub fn parted(&self, count: usize, joint: usize) -> [Plate; 2] {
        let within = |slabs: usize| self.inner.repeated(slabs);
        [self.front.then(&within(joint - 1)), within(count - 1 - joint).then(&self.back)]
    }
}

/// The fluxes of all complete cells.
fn ensemble((study, collected): &SolvedPortion) -> Option<Ensemble> {
    let portion = study.portion()?;
    let (layer, position, slab_um) = (portion.layer(), portion.position, study.layer.thickness_um);
    let cells = complete_cells(study, collected);
    let solved = |nm: &f64| solved_at(study, &cells, 1e-3 * nm);
    let wavelengths = study.wavelengths_nm.iter().map(solved).collect::<Option<Vec<_>>>()?;
    let grid = collected.resolved.grid_error;
    let grid_error = grid.reflectance.max(grid.transmittance);
    let states = EnsembleStates::Solved(wavelengths);
    let permittivities = study.wavelengths_nm.iter().map(|nm| study.even_permittivity(1e-3 * nm)).collect();
    (!cells.is_empty()).then_some(Ensemble { layer, position, slab_um, states, permittivities, grid_error })
}

/// The media at one wavelength and the flux matrices of every cell.
fn solved_at(study: &Study, cells: &[Vec<&Realisation>], wavelength_um: f64) -> Option<(Sides, Vec<Fluxes>)> {
    let sides = study.sides(wavelength_um)?;
    let all = cells.iter().map(|cell| mean_fluxes(&sides, cell, wavelength_um)).collect();
    Some((sides, all))
}

/// The flux matrices of one cell at one wavelength, the mean over its packings.
fn mean_fluxes(sides: &Sides, cell: &[&Realisation], wavelength_um: f64) -> Fluxes {
    let all = cell.iter().map(|r| fluxes(sides, r, wavelength_um));
    all.reduce(|first, second| first.mean_with(&second)).expect("a cell has a packing")
}

/// The flux matrices of one realisation at one wavelength.
fn fluxes(sides: &Sides, realisation: &Realisation, wavelength_um: f64) -> Fluxes {
    let at_wavelength = |record: &&PointRecord| record.incidence.wavelength_um == wavelength_um;
    let records: Vec<&PointRecord> = realisation.points.iter().flatten().filter(at_wavelength).collect();
    let orders: Vec<Vec<Order>> = records.iter().map(|record| record.far_field().orders).collect();
    let polarisations = sides.media[0].polarisations;
    let first_behind = sides.media[0].directions_deg().len();
    let place = |k: usize, from: Side| k / polarisations - if from == Side::Exit { first_behind } else { 0 };
    sides.fluxes(records.iter().zip(&orders).enumerate().map(|(k, (record, orders))| Lit {
        from: record.incidence.from,
        direction: place(k, record.incidence.from),
        polarisation: usize::from(record.polarisation == Some(Polarisation::P)),
        absorptance: record.absorptance,
        orders,
    }))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::appearance::composed::ordinates::Ordinates;
    use faer::Mat;

    /// A slab that sends every one of its seven states back, and passes it on, in these shares.
    pub fn even_plate(reflected: f64, transmitted: f64) -> Plate {
        let diagonal = |x: f64| Mat::from_fn(7, 7, |i, j| if i == j { x } else { 0.0 });
        Plate {
            reflection: [diagonal(reflected), diagonal(reflected)],
            transmission: [diagonal(transmitted), diagonal(transmitted)],
        }
    }

    /// Slabs of 1 µm at 550 nm in and between media of index 1.5.
    pub fn slabs_of(front: Plate, inner: Plate, back: Plate) -> Slabs {
        let medium = || Hemisphere {
            ordinates: Ordinates::new(1.5, &[], [3, 3]),
            polarisations: 1,
            oblique_deg: None,
        };
        let film = CoherentFilm {
            slabs: Default::default(),
            media: [medium(), medium(), medium()],
            permittivity: (1.5 * 1.5).into(),
            slab_um: 1.0,
            wavelength_um: 0.55,
            fewer_directions: false,
        };
        Slabs { front, inner, back, media: [medium(), medium(), medium()], film }
    }

    /// Slabs that reflect nothing and pass 0.5, 0.8 and 0.9 of the light.
    #[test]
    fn a_layer_has_as_many_slabs_as_asked() {
        let slabs = slabs_of(even_plate(0.0, 0.5), even_plate(0.0, 0.8), even_plate(0.0, 0.9));
        let through = |count: f64| slabs.layer(count).transmission[0][(0, 0)];
        // a part of a slab: 0.45 √0.8
        assert!((through(2.5) - 0.45 * 0.8_f64.sqrt()).abs() < 1e-12, "{}", through(2.5));
        for (count, passed) in [(2, 0.45), (3, 0.36), (5, 0.2304)] {
            let got = through(count as f64);
            assert!((got - passed).abs() < 1e-12, "{count}: {got}");
            let [front, back] = slabs.parted(count, 1).map(|part| part.transmission[0][(0, 0)]);
            assert!((front * back - passed).abs() < 1e-12, "{count}: {front} {back}");
        }
    }
}
