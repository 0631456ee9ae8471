//! Evaluates the finished solves: spectra of the layer, its distributions, and the ink on its
//! paper.

mod sums;

use super::coherent::CoherentLight;
use super::film::{Profile, ProfileLayer};
use super::films::{FilmAt, Films, Indices};
use super::ink::{InkError, InkInputs, InkOnPaper, SolvedLayer};
use super::layer::{LayerEnsemble, SpectrumEstimate, Total, film_totals};
use super::levels::{Checked, GridCorrection, GridPart};
use super::prints::Brightened;
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};
use super::summed::sum_wavelengths_nm;
use super::wavelengths::{SpectralBasis, nearest};
use crate::appearance::bdf::{Bdf, BdfError};
use crate::appearance::paper::Substrate;
use crate::appearance::viewing::Viewing;
use crate::input::study::{Angles, StackLayer, Study};
use crate::input::variation::{CellRule, LightRule};
use crate::numerics::estimate::Estimate;
use crate::run::{Collected, Realisation};
use crate::store::record::PointRecord;
use crate::wave::{FarField, Wave};
use num_complex::Complex64;

/// The appearance, as far as the finished solves allow.
#[derive(Debug)]
pub struct Seen {
    /// Numbers of the realisations that enter every result.
    pub realisations: Vec<usize>,
    /// The first realisation of every cell: packings that share one are one sample of the layer.
    pub cells: Vec<usize>,
    /// The solves of every cell, corrected for the grid where two were used.
    pub solved: Vec<SolvedRealisation>,
    /// Errors of R and T due to the grid.
    pub grid: GridPart,
    /// The layer without paper, once a realisation is complete.
    pub layer: Option<LayerSeen>,
    /// The layer's distributions at the exact angles, wavelength by wavelength.
    pub bdfs: Vec<Bdf>,
    /// The ink on its paper, or why there is none.
    pub ink: Result<InkOnPaper, NoInk>,
    /// The layer with tables of indices moved by their errors, once the solves for it are there.
    pub(super) inputs: Option<MovedLayers>,
}

/// The layer of a few packings as the study describes it, and with tables of indices moved by
/// their errors.
#[derive(Debug)]
pub(super) struct MovedLayers {
    few: LayerSeen,
    moved: Vec<LayerSeen>,
}

impl MovedLayers {
    /// Standard error of a total at one of the exact angles due to the tables' errors, against the
    /// study's wavelengths.
    pub fn errors(&self, angle: usize, total: Total) -> Vec<f64> {
        self.errors_of(|layer| layer.spectrum(angle, total).values)
    }

    /// Standard error of what a layer of a stack absorbs, as of totals.
    pub fn absorbed_errors(&self, angle: usize, layer: usize) -> Vec<f64> {
        self.errors_of(|seen| seen.absorbed(angle, layer).values)
    }

    /// Standard errors of any spectrum due to the tables' errors.
    fn errors_of(&self, spectrum: impl Fn(&LayerSeen) -> Vec<f64>) -> Vec<f64> {
        let unmoved = spectrum(&self.few);
        let mut squares = vec![0.0; unmoved.len()];
        for moved in &self.moved {
            let there = spectrum(moved);
            let changes = there.iter().zip(&unmoved).map(|(there, unmoved)| there - unmoved);
            squares.iter_mut().zip(changes).for_each(|(sum, change)| *sum += 0.5 * change * change);
        }
        squares.into_iter().map(f64::sqrt).collect()
    }
}

/// The layer without paper at the study's wavelengths.
#[derive(Debug)]
pub struct LayerSeen {
    /// The fits behind the numbers.
    pub(super) ensemble: LayerEnsemble,
    /// The coherent film at each wavelength.
    films: Vec<FilmAt>,
    pub(super) wavelengths_nm: Vec<f64>,
    /// The coherent film at each wavelength over which weighted numbers are summed.
    sum_films: Vec<FilmAt>,
    coherent: Option<CoherentLight>,
}

/// Why there is no ink on paper.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum NoInk {
    /// The study's angles or wavelengths do not suffice.
    #[error("{0}")]
    Missing(String),
    /// No cell is complete yet.
    #[error("no cell has every wavelength and angle of all packings that share it")]
    Unfinished,
    /// The paper or the angles were refused.
    #[error(transparent)]
    Refused(#[from] InkError),
}

impl LayerSeen {
    /// The coherent film at the study's wavelength nearest to `nm`.
    pub fn film(&self, nm: f64) -> &FilmAt {
        &self.films[nearest(self.wavelengths_nm.iter().copied(), nm)]
    }

    /// A total at one of the exact angles against the study's wavelengths.
    pub fn spectrum(&self, angle: usize, total: Total) -> SpectrumEstimate {
        let ensemble = &self.ensemble;
        let deg = self.ensemble.exact_deg[angle];
        let film: Vec<f64> = self.films.iter().map(|film| film_totals(film, deg)[total as usize]).collect();
        let column = ensemble.column(angle, total);
        SpectrumEstimate {
            values: self.beyond(&film, None, column),
            replicates: (0..ensemble.replicates()).map(|r| self.beyond(&film, Some(r), column)).collect(),
        }
    }

    /// What a layer of a stack absorbs at one of the exact angles, against the study's wavelengths.
    pub fn absorbed(&self, angle: usize, layer: usize) -> SpectrumEstimate {
        let ensemble = &self.ensemble;
        let deg = ensemble.exact_deg[angle];
        let film: Vec<f64> = self.films.iter().map(|film| film.absorbed(deg)[layer]).collect();
        let column = ensemble.absorbed_column(angle, layer);
        SpectrumEstimate {
            values: self.beyond(&film, None, column),
            replicates: (0..ensemble.replicates()).map(|r| self.beyond(&film, Some(r), column)).collect(),
        }
    }

    /// |⟨t⟩|² at one of the exact angles against the study's wavelengths, if all is of one
    /// thickness.
    pub fn coherent_transmittance(&self, angle: usize) -> Option<Vec<Estimate>> {
        let deg = self.ensemble.exact_deg[angle];
        let coherent = self.coherent.as_ref()?;
        Some(coherent.transmittance(angle, &self.films, deg, &self.wavelengths_nm))
    }

    /// Values of the film plus the fitted differences from it.
    fn beyond(&self, film: &[f64], left_out: Option<usize>, column: usize) -> Vec<f64> {
        let LayerEnsemble { basis, .. } = &self.ensemble;
        let fitted = |nm: f64| self.ensemble.fitted(left_out, &basis.weights(nm), column);
        film.iter().zip(&self.wavelengths_nm).map(|(film, &nm)| film + fitted(nm)).collect()
    }
}

impl Study {
    /// Wavelengths at which the spectra that weighted numbers take are known, nm: those of a list,
    /// or of the sums where realisations have their own.
    pub fn number_wavelengths_nm(&self) -> Vec<f64> {
        match self.variation.light {
            LightRule::Listed => self.wavelengths_nm.clone(),
            LightRule::Shifted { .. } => self.sum_wavelengths_nm(),
        }
    }

    /// Wavelengths over which weighted numbers are summed, nm; none without any.
    fn sum_wavelengths_nm(&self) -> Vec<f64> {
        let ends = self.wavelengths_nm.first().zip(self.wavelengths_nm.last());
        let ends = ends.filter(|_| !self.numbers.is_empty());
        ends.map_or(Vec::new(), |(&from, &to)| sum_wavelengths_nm([from, to]))
    }
}

/// The ink on its paper alone, from the complete realisations.
///
/// # Errors
/// None is complete, or as [`NoInk`] says.
pub fn ink(study: &Study, collected: &Collected) -> Result<InkOnPaper, NoInk> {
    CompleteCells::new(study, collected).appearance().ink
}

/// The ink as its coherent film, with the requested volume fractions in every plane.
///
/// # Errors
/// As [`InkOnPaper::homogeneous`].
pub fn film_alone(study: &Study) -> Result<InkOnPaper, InkError> {
    film_at(study, &study.wavelengths_nm)
}

/// The ink as its coherent film at other wavelengths within the study's range, nm.
pub(super) fn film_at(study: &Study, outputs_nm: &[f64]) -> Result<InkOnPaper, InkError> {
    let indices = |nm: f64| indices(study, nm);
    let films = films(study, requested_profile(study), &indices);
    let substrate = substrate(study);
    let ink = InkOnPaper::homogeneous(&InkInputs { films: &films, substrate: &substrate, outputs_nm })?;
    in_daylight(study, ink)
}

/// Totals of the coherent film alone for light along the normal, at wavelengths within the study's
/// range, nm: in the order of [`Total`].
pub(super) fn film_totals_at(study: &Study, wavelengths_nm: &[f64]) -> Vec<Vec<f64>> {
    let indices = |nm: f64| indices(study, nm);
    let films = films(study, requested_profile(study), &indices);
    wavelengths_nm.iter().map(|&nm| film_totals(&films.at(nm), 0.0).to_vec()).collect()
}

/// The ink under D65, on whose ultraviolet light depends what its paper emits.
fn in_daylight(study: &Study, ink: InkOnPaper) -> Result<InkOnPaper, InkError> {
    match Brightened::new(&study.paper, &study.wavelengths_nm, &Viewing::default(), 0.0) {
        Some(brightened) => Ok(ink.lit_by(&brightened)?),
        None => Ok(ink),
    }
}

/// The requested volume fractions, one slice a layer.
fn requested_profile(study: &Study) -> Profile {
    let shares = study.material_shares();
    let of_layers = study.layers_of_materials();
    let slice = |layer: usize| {
        let own = shares.iter().zip(&of_layers).map(|(&share, &of)| if of == layer { share } else { 0.0 });
        own.collect()
    };
    let count = study.stack.len().max(1);
    Profile { fractions: (0..count).map(slice).collect(), layers: profile_layers(study) }
}

/// The layers of a study's stack, as their film sees them.
fn profile_layers(study: &Study) -> Vec<ProfileLayer> {
    let layer = |layer: &StackLayer| ProfileLayer {
        thickness_um: layer.thickness_um,
        is_uneven: layer.thickness_std_um > 0.0,
    };
    study.stack.iter().map(layer).collect()
}

/// The coherent film of a study's layer.
fn films<'a>(study: &Study, profile: Profile, indices: &'a Indices<'a>) -> Films<'a> {
    Films {
        profile,
        indices,
        thicknesses_um: study.thicknesses_um(),
        index_out: study.layer.index_out,
        wave: study.wave,
    }
}

fn substrate(study: &Study) -> Substrate {
    Substrate { albedo: study.paper.albedo.clone(), coupling: study.paper.coupling }
}

/// Evaluates all complete realisations.
///
/// # Errors
/// The records do not match, because of a bug or a damaged store.
pub fn see(study: &Study, collected: &Collected) -> Result<Seen, BdfError> {
    let cells = CompleteCells::new(study, collected);
    let mut seen = cells.appearance();
    if !cells.cells.is_empty() {
        seen.bdfs = cells.distributions()?;
    }
    Ok(seen)
}

/// The complete realisations of a study, cell by cell.
struct CompleteCells<'a> {
    study: &'a Study,
    collected: &'a Collected,
    cells: Vec<Vec<&'a Realisation>>,
}

impl<'a> CompleteCells<'a> {
    fn new(study: &'a Study, collected: &'a Collected) -> Self {
        Self { study, collected, cells: complete_cells(study, collected) }
    }

    /// The appearance without the distributions.
    fn appearance(&self) -> Seen {
        let study = self.study;
        let complete = self.cells.concat();
        let (solved, grid) = self.solved(study.wave);
        let mut seen = Seen {
            realisations: complete.iter().map(|r| r.packing.realisation).collect(),
            cells: self.cells.iter().map(|cell| cell[0].packing.realisation).collect(),
            solved,
            grid,
            layer: None,
            bdfs: Vec::new(),
            ink: Err(NoInk::Unfinished),
            inputs: None,
        };
        if complete.is_empty() {
            return seen;
        }
        let indices = |nm: f64| indices(study, nm);
        let films = films(study, mean_profile(study, &complete), &indices);
        let basis = basis(study, self.cells.len());
        let mut ensemble = LayerEnsemble::new(&seen.solved, basis, &films, &study.angles.exact_deg);
        ensemble.sums_nm = study.sum_wavelengths_nm();
        seen.ink = self.on_paper(&ensemble, &seen.solved, &films);
        let wavelengths_nm = study.wavelengths_nm.clone();
        let coherent = CoherentLight::new(&seen.solved, &ensemble.basis, &films, &study.angles.exact_deg);
        let sum_films = ensemble.sums_nm.iter().map(|&nm| films.at(nm)).collect();
        let films = wavelengths_nm.iter().map(|&nm| films.at(nm)).collect();
        seen.layer = Some(LayerSeen { ensemble, films, wavelengths_nm, sum_films, coherent });
        self.move_inputs(&mut seen);
        seen
    }

    /// Evaluates the solves with tables of indices moved by their errors, beside those of the same
    /// packings as they are.
    fn move_inputs(&self, seen: &mut Seen) {
        let moves = self.study.input_moves();
        let Some(solves) = self.collected.moved_solves(moves.len()) else { return };
        let unmoved = CompleteCells::new(self.study, &solves.unmoved).appearance();
        let mut all = Vec::new();
        for (by, solves) in moves.iter().zip(&solves.moved) {
            all.push(CompleteCells::new(&self.study.moved(by), solves).appearance());
        }
        if let (Ok(ink), Ok(few)) = (&mut seen.ink, &unmoved.ink)
            && let Ok(moved) = all.iter().map(|seen| seen.ink.as_ref()).collect::<Result<Vec<_>, _>>()
        {
            ink.keep_moved(few, &moved);
        }
        let moved = all.into_iter().map(|seen| seen.layer).collect::<Option<Vec<_>>>();
        seen.inputs = unmoved.layer.zip(moved).map(|(few, moved)| MovedLayers { few, moved });
    }

    /// The solves of every cell in one light, corrected by those on a finer grid as far as there
    /// are any.
    fn solved(&self, wave: Wave) -> (Vec<SolvedRealisation>, GridPart) {
        let mean = |cell: &Vec<&Realisation>| {
            let packings = cell.iter().map(|r| solved(self.study, r, &r.points, wave));
            packings.reduce(|first, second| first.mean_with(&second)).expect("a cell has a packing")
        };
        let mut solved: Vec<SolvedRealisation> = self.cells.iter().map(mean).collect();
        let resolved = &self.collected.resolved;
        let angles_deg = &self.study.angles.exact_deg;
        let checked = self.checked(wave);
        let basis = basis(self.study, 1);
        let Some(correction) = GridCorrection::new(&checked, &basis, resolved.refinement(), angles_deg)
        else {
            return (solved, GridPart::Estimated(resolved.grid_error));
        };
        solved.iter_mut().for_each(|cell| correction.apply(cell));
        (solved, GridPart::Corrected(Box::new(correction)))
    }

    /// The realisations with all solves on both grids.
    fn checked(&self, wave: Wave) -> Vec<Checked> {
        let complete = |r: &&&Realisation| !r.finer.is_empty() && r.finer.iter().all(Option::is_some);
        let both = |r: &&Realisation| Checked {
            coarse: solved(self.study, r, &r.points, wave),
            finer: solved(self.study, r, &r.finer, wave),
        };
        self.cells.iter().flatten().filter(complete).map(both).collect()
    }

    /// The ink on its paper. Where polarised light comes in, the paper gives back other light.
    fn on_paper(
        &self,
        ensemble: &LayerEnsemble,
        solved: &[SolvedRealisation],
        films: &Films,
    ) -> Result<InkOnPaper, NoInk> {
        let study = self.study;
        if let Some(reason) = study.no_ink() {
            return Err(NoInk::Missing(reason));
        }
        let inputs = InkInputs { films, substrate: &substrate(study), outputs_nm: &study.wavelengths_nm };
        let wave = study.wave.returned();
        let back = (wave != study.wave).then(|| self.solved(wave).0);
        let returned = back.as_ref().map(|solved| {
            let basis = ensemble.basis.clone();
            let exact_deg = &study.angles.exact_deg;
            let ensemble = LayerEnsemble::new(solved, basis, &films.returned(), exact_deg);
            SolvedLayer { ensemble, solved }
        });
        let ink = InkOnPaper::new(SolvedLayer { ensemble: ensemble.clone(), solved }, returned, &inputs)?;
        Ok(in_daylight(study, ink)?)
    }

    /// Distributions at every exact angle, one per stratum of wavelengths, from the far fields in
    /// all realisations.
    fn distributions(&self) -> Result<Vec<Bdf>, BdfError> {
        let Study { variation, angles, .. } = self.study;
        let fields = self.cells.iter().flatten().map(|r| far_fields(self.study, &r.points, self.study.wave));
        let fields: Vec<Vec<FarField>> = fields.collect();
        let alike = variation.cell == CellRule::Fixed
            && variation.light == LightRule::Listed
            && variation.thickness_std_um == 0.0;
        let exact = angles.exact_deg.len();
        let each = angles.count();
        let mut all = Vec::new();
        for place in (0..self.study.solved_wavelengths() * exact).map(|k| k / exact * each + k % exact) {
            let ensemble: Vec<FarField> = fields.iter().map(|fields| fields[place].clone()).collect();
            all.push(match alike {
                true => Bdf::from_ensemble(&ensemble)?,
                false => Bdf::from_varied_cells(&ensemble, self.study.layer.period_um)?,
            });
        }
        Ok(all)
    }
}

/// The realisations of which every solve is there, cell by cell. One of a pair alone holds too much
/// pigment or too little, and is left out.
pub(super) fn complete_cells<'a>(study: &Study, collected: &'a Collected) -> Vec<Vec<&'a Realisation>> {
    let all: Vec<&Realisation> = collected.complete().collect();
    let find = |number: usize| all.iter().copied().find(|r| r.packing.realisation == number);
    let cell = |r: &&'a Realisation| match study.partner(r.packing.realisation) {
        Some(other) if other > r.packing.realisation => find(other).map(|second| vec![*r, second]),
        Some(_) => None,
        None => Some(vec![*r]),
    };
    all.iter().filter_map(cell).collect()
}

/// Far fields of complete solves for one polarisation of the light, direction by direction.
fn far_fields(study: &Study, points: &[Option<PointRecord>], wave: Wave) -> Vec<FarField> {
    let records: Vec<&PointRecord> = points.iter().flatten().collect();
    records.chunks(study.polarisations().len()).map(|records| in_light(records, wave)).collect()
}

/// The far field of one direction for one polarisation of the light, from the records of its
/// components.
fn in_light(records: &[&PointRecord], wave: Wave) -> FarField {
    match (records, wave) {
        ([s, p], Wave::Unpolarised) => FarField::unpolarised(&s.far_field(), &p.far_field()),
        ([_, p], Wave::P) => p.far_field(),
        (records, _) => records[0].far_field(),
    }
}

/// Functions of the wavelength that this number of cells determines.
fn basis(study: &Study, cells: usize) -> SpectralBasis {
    match study.variation.light {
        LightRule::Listed => SpectralBasis::Listed(study.wavelengths_nm.clone()),
        LightRule::Shifted { range_nm, strata } => SpectralBasis::splines(range_nm, strata, cells),
    }
}

/// The solves of a realisation in their order: wavelength; exact angles, strata, strata from the
/// exit side.
fn solved(study: &Study, r: &Realisation, points: &[Option<PointRecord>], wave: Wave) -> SolvedRealisation {
    let angles = &study.angles;
    let fields = far_fields(study, points, wave);
    let wavelengths = fields.chunks(angles.count()).map(|fields| solved_at(angles, fields)).collect();
    SolvedRealisation { thickness_um: r.packing.thickness_um, wavelengths }
}

/// The solves of one wavelength: exact angles, strata, strata from the exit side.
fn solved_at(angles: &Angles, fields: &[FarField]) -> SolvedWavelength {
    let all: Vec<SolvedDirection> = fields.iter().map(SolvedDirection::from).collect();
    let (exact, rest) = all.split_at(angles.exact_deg.len());
    let (strata, exit) = rest.split_at(angles.strata);
    SolvedWavelength {
        wavelength_nm: 1e3 * fields[0].incidence.wavelength_um,
        exact: exact.to_vec(),
        strata: strata.to_vec(),
        exit: exit.to_vec(),
    }
}

/// Indices of the backgrounds, the inclusions, and last of the space beyond a relief.
fn indices(study: &Study, nm: f64) -> (Vec<Complex64>, Vec<Complex64>) {
    let media = study.mean_media(1e-3 * nm);
    let beyond = study.packing.relief.map_or(media.incident, |relief| media.index_of(relief.face.into()));
    (media.backgrounds, media.inclusions.into_iter().chain([beyond]).collect())
}

fn mean_profile(study: &Study, complete: &[&Realisation]) -> Profile {
    let mut fractions = complete[0].packing.profile.clone();
    for realisation in &complete[1..] {
        let others = realisation.packing.profile.iter().flatten();
        fractions.iter_mut().flatten().zip(others).for_each(|(sum, other)| *sum += other);
    }
    fractions.iter_mut().flatten().for_each(|share| *share /= complete.len() as f64);
    Profile { fractions, layers: profile_layers(study) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::check::check;
    use std::path::Path;

    /// The coherent film's last medium. *Planted*: that of the incident side, whichever face is
    /// rough.
    #[test]
    fn beyond_a_relief_there_is_the_medium_of_its_side() {
        for (face, expected) in [("incident", 1.0), ("exit", 1.4)] {
            let text = format!(
                "[layer]\nthickness_um = 1\nbinder.index = 1.5\nindex_out = 1.4\n\
                 relief = {{ depth_um = 0.1, face = '{face}' }}\n[paper]\ncoupling = 'optical_contact'\n"
            );
            let file = toml::from_str(&text).expect("a study file");
            let study = check(&file, Path::new("."), "test").expect("a study");
            assert_eq!(indices(&study, 550.0).1, [Complex64::from(expected)]);
        }
    }
}
