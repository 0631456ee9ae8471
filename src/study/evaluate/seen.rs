//! Evaluates the finished solves: spectra of the layer, its distributions, and the ink on its
//! paper.

use super::film::Profile;
use super::films::{FilmAt, Films, Indices};
use super::ink::{InkError, InkInputs, InkOnPaper};
use super::layer::{LayerEnsemble, SpectrumEstimate, Total};
use super::levels::{Checked, GridCorrection, GridPart};
use super::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};
use super::wavelengths::SpectralBasis;
use crate::appearance::bdf::{Bdf, BdfError};
use crate::appearance::paper::Substrate;
use crate::input::study::{Angles, Study};
use crate::input::variation::{CellRule, LightRule};
use crate::run::{Collected, Realisation};
use crate::store::record::PointRecord;
use crate::wave::FarField;
use crate::wave::Wave;
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
}

/// The layer without paper at the study's wavelengths.
#[derive(Debug)]
pub struct LayerSeen {
    ensemble: LayerEnsemble,
    /// The coherent film at each wavelength.
    films: Vec<FilmAt>,
    pub(super) wavelengths_nm: Vec<f64>,
}

/// Why there is no ink on paper.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum NoInk {
    /// The study's angles do not suffice.
    #[error("{0}")]
    Angles(String),
    /// No realisation is complete yet.
    #[error("not every wavelength and angle of a realisation is finished")]
    Unfinished,
    /// The paper or the angles were refused.
    #[error(transparent)]
    Refused(#[from] InkError),
}

impl LayerSeen {
    /// Angles common to all realisations, degrees.
    pub fn angles_deg(&self) -> &[f64] {
        &self.ensemble.exact_deg
    }

    /// The fits behind the numbers.
    pub fn ensemble(&self) -> &LayerEnsemble {
        &self.ensemble
    }

    /// The coherent film at the study's wavelength nearest to `nm`.
    pub fn film(&self, nm: f64) -> &FilmAt {
        let distance = |&w: &usize| (self.wavelengths_nm[w] - nm).abs();
        let nearest = (0..self.films.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        &self.films[nearest.unwrap_or(0)]
    }

    /// Index of the half-space on the exit side.
    pub fn index_out(&self) -> Option<f64> {
        self.films.first().map(FilmAt::index_out)
    }

    /// A total at one of these angles against the study's wavelengths.
    pub fn spectrum(&self, angle: usize, total: Total) -> SpectrumEstimate {
        self.ensemble.spectrum(&self.films, &self.wavelengths_nm, angle, total)
    }
}

/// The ink on its paper alone, from the complete realisations.
///
/// # Errors
/// None is complete, or as [`NoInk`] says.
pub fn ink(study: &Study, collected: &Collected) -> Result<InkOnPaper, NoInk> {
    let cells = complete_cells(study, collected);
    if cells.is_empty() {
        return Err(NoInk::Unfinished);
    }
    let SolvedCells { solved, .. } = by_cell(study, collected, &cells, study.wave);
    let indices = |nm: f64| indices(study, nm);
    let films = films(study, mean_profile(&cells.concat()), &indices);
    let ensemble = LayerEnsemble::new(&solved, basis(study, solved.len()), &films, &study.angles.exact_deg);
    on_paper(study, (&ensemble, &solved), returned(study, collected, &cells).as_deref(), &films)
}

/// The ink as its coherent film, with the volume fractions asked for in every plane.
///
/// # Errors
/// As [`InkOnPaper::homogeneous`].
pub fn film_alone(study: &Study) -> Result<InkOnPaper, InkError> {
    let indices = |nm: f64| indices(study, nm);
    let films = films(study, Profile { fractions: vec![study.material_shares()] }, &indices);
    let substrate = Substrate { albedo: study.paper.albedo.clone(), coupling: study.paper.coupling };
    let outputs_nm = &study.wavelengths_nm;
    InkOnPaper::homogeneous(&InkInputs { films: &films, substrate: &substrate, outputs_nm })
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

/// Evaluates all complete realisations.
///
/// # Errors
/// The records do not match, because of a bug or a damaged store.
pub fn see(study: &Study, collected: &Collected) -> Result<Seen, BdfError> {
    let by_cells = complete_cells(study, collected);
    let complete = by_cells.concat();
    if complete.is_empty() {
        let (realisations, cells, solved, bdfs) = Default::default();
        let grid = GridPart::Estimated(collected.resolved.grid_error);
        let (layer, ink) = (None, Err(NoInk::Unfinished));
        return Ok(Seen { realisations, cells, solved, grid, layer, bdfs, ink });
    }
    let fields: Vec<Vec<FarField>> =
        complete.iter().map(|r| far_fields(study, &r.points, study.wave)).collect();
    let SolvedCells { solved, grid } = by_cell(study, collected, &by_cells, study.wave);
    let returned = returned(study, collected, &by_cells);
    let indices = |nm: f64| indices(study, nm);
    let films = films(study, mean_profile(&complete), &indices);
    let ensemble = LayerEnsemble::new(&solved, basis(study, solved.len()), &films, &study.angles.exact_deg);
    let ink = on_paper(study, (&ensemble, &solved), returned.as_deref(), &films);
    let wavelengths_nm = study.wavelengths_nm.clone();
    let at_outputs = wavelengths_nm.iter().map(|&nm| films.at(nm)).collect();
    let layer = Some(LayerSeen { ensemble, films: at_outputs, wavelengths_nm });
    let realisations: Vec<usize> = complete.iter().map(|r| r.packing.realisation).collect();
    let cells = by_cells.iter().map(|cell| cell[0].packing.realisation).collect();
    let bdfs = distributions(study, &fields)?;
    Ok(Seen { realisations, cells, bdfs, solved, grid, layer, ink })
}

/// The realisations of which every solve is there, cell by cell. One of a pair alone holds too much
/// pigment or too little, and is left out.
pub(in crate::evaluate) fn complete_cells<'a>(
    study: &Study,
    collected: &'a Collected,
) -> Vec<Vec<&'a Realisation>> {
    let all: Vec<&Realisation> = collected.complete().collect();
    let find = |number: usize| all.iter().copied().find(|r| r.packing.realisation == number);
    let cell = |r: &&'a Realisation| match study.partner(r.packing.realisation) {
        Some(other) if other > r.packing.realisation => find(other).map(|second| vec![*r, second]),
        Some(_) => None,
        None => Some(vec![*r]),
    };
    all.iter().filter_map(cell).collect()
}

/// The solves of all cells.
struct SolvedCells {
    solved: Vec<SolvedRealisation>,
    grid: GridPart,
}

/// The solves of every cell in one light, corrected by those on a finer grid as far as there are
/// any.
fn by_cell(study: &Study, collected: &Collected, cells: &[Vec<&Realisation>], wave: Wave) -> SolvedCells {
    let own = |r: &&Realisation| solved(study, r, &far_fields(study, &r.points, wave));
    let mean = |cell: &Vec<&Realisation>| {
        cell.iter().map(own).reduce(|first, second| first.mean_with(&second)).expect("a cell has a packing")
    };
    let mut solved: Vec<SolvedRealisation> = cells.iter().map(mean).collect();
    let checked = checked(study, cells, wave);
    let refinement = collected.resolved.refinement();
    let Some(correction) = GridCorrection::new(&checked, &basis(study, 1), refinement) else {
        return SolvedCells { solved, grid: GridPart::Estimated(collected.resolved.grid_error) };
    };
    solved.iter_mut().for_each(|cell| correction.apply(cell));
    let (correction, angles_deg) = (Box::new(correction), study.angles.exact_deg.clone());
    SolvedCells { solved, grid: GridPart::Corrected { correction, angles_deg } }
}

/// The realisations with all solves on both grids.
fn checked(study: &Study, cells: &[Vec<&Realisation>], wave: Wave) -> Vec<Checked> {
    let complete = |r: &&&Realisation| !r.finer.is_empty() && r.finer.iter().all(Option::is_some);
    let both = |r: &&Realisation| {
        let [coarse, finer] =
            [&r.points, &r.finer].map(|points| solved(study, r, &far_fields(study, points, wave)));
        Checked { coarse, finer }
    };
    cells.iter().flatten().filter(complete).map(both).collect()
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

/// The solves in the light that paper gives back, where polarised light comes in.
fn returned(
    study: &Study,
    collected: &Collected,
    cells: &[Vec<&Realisation>],
) -> Option<Vec<SolvedRealisation>> {
    let wave = study.wave.returned();
    let other = wave != study.wave && study.angles.no_paper.is_none();
    other.then(|| by_cell(study, collected, cells, wave).solved)
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
fn solved(study: &Study, realisation: &Realisation, fields: &[FarField]) -> SolvedRealisation {
    let angles = &study.angles;
    SolvedRealisation {
        thickness_um: realisation.packing.thickness_um,
        wavelengths: fields.chunks(angles.count()).map(|fields| solved_at(angles, fields)).collect(),
    }
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

/// Indices of the background, the inclusions, and last of the space beyond a relief.
fn indices(study: &Study, nm: f64) -> (Complex64, Vec<Complex64>) {
    let media = study.media(1e-3 * nm);
    let beyond = study.packing.relief.map_or(media.incident, |relief| media.index_of(relief.face.into()));
    (media.backgrounds[0], media.inclusions.into_iter().chain([beyond]).collect())
}

fn mean_profile(complete: &[&Realisation]) -> Profile {
    let mut fractions = complete[0].packing.profile.clone();
    for realisation in &complete[1..] {
        let other = &realisation.packing.profile;
        for (own, other) in fractions.iter_mut().zip(other) {
            own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
        }
    }
    fractions.iter_mut().flatten().for_each(|share| *share /= complete.len() as f64);
    Profile { fractions }
}

fn on_paper(
    study: &Study,
    (ensemble, solved): (&LayerEnsemble, &[SolvedRealisation]),
    returned: Option<&[SolvedRealisation]>,
    films: &Films,
) -> Result<InkOnPaper, NoInk> {
    if let Some(reason) = &study.angles.no_paper {
        return Err(NoInk::Angles(reason.clone()));
    }
    let substrate = Substrate { albedo: study.paper.albedo.clone(), coupling: study.paper.coupling };
    let inputs = InkInputs { films, substrate: &substrate, outputs_nm: &study.wavelengths_nm };
    let returned = returned.map(|solved| {
        let basis = ensemble.basis.clone();
        (LayerEnsemble::new(solved, basis, &films.returned(), &study.angles.exact_deg), solved)
    });
    Ok(InkOnPaper::new((ensemble.clone(), solved), returned, &inputs)?)
}

/// Distributions at every exact angle, one per stratum of wavelengths.
fn distributions(study: &Study, fields: &[Vec<FarField>]) -> Result<Vec<Bdf>, BdfError> {
    let each = study.angles.count();
    let places = (0..study.solved_wavelengths())
        .flat_map(|w| (0..study.angles.exact_deg.len()).map(move |a| w * each + a));
    let of = |place: usize| {
        let ensemble: Vec<FarField> = fields.iter().map(|fields| fields[place].clone()).collect();
        distribution(study, &ensemble)
    };
    places.map(of).collect()
}

/// The distribution of one direction and stratum of wavelengths, from its far fields in all
/// realisations.
fn distribution(study: &Study, ensemble: &[FarField]) -> Result<Bdf, BdfError> {
    let alike = study.variation.cell == CellRule::Fixed && study.variation.light == LightRule::Listed;
    match alike && study.variation.thickness_std_um == 0.0 {
        true => Bdf::from_ensemble(ensemble),
        false => Bdf::from_varied_cells(ensemble, study.layer.period_um),
    }
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
