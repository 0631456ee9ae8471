//! The complete realisations of a study, cell by cell, and what is evaluated of them.

use super::{LayerSeen, MovedLayers, NoInk, Seen, films, in_daylight, indices, profile_layers, substrate};
use crate::appearance::bdf::{Bdf, BdfError};
use crate::appearance::film::Profile;
use crate::evaluate::coherent::CoherentLight;
use crate::evaluate::films::Films;
use crate::evaluate::ink::{InkInputs, InkOnPaper, SolvedLayer};
use crate::evaluate::layer::LayerEnsemble;
use crate::evaluate::levels::{Checked, GridCorrection, GridPart};
use crate::evaluate::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};
use crate::evaluate::wavelengths::SpectralBasis;
use crate::input::study::{Angles, Study};
use crate::input::variation::{CellRule, LightRule};
use crate::run::{Collected, Realisation};
use crate::store::record::PointRecord;
use crate::wave::{FarField, Wave};

/// The complete realisations of a study, cell by cell.
pub(super) struct CompleteCells<'a> {
    study: &'a Study,
    collected: &'a Collected,
    pub cells: Vec<Vec<&'a Realisation>>,
}

impl<'a> CompleteCells<'a> {
    /// Of what is stored of a study.
    pub fn new(study: &'a Study, collected: &'a Collected) -> Self {
        Self { study, collected, cells: complete_cells(study, collected) }
    }

    /// The appearance without the distributions.
    pub fn appearance(&self) -> Seen {
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
    pub fn distributions(&self) -> Result<Vec<Bdf>, BdfError> {
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

/// The mean volume fractions of these realisations in every slice.
fn mean_profile(study: &Study, complete: &[&Realisation]) -> Profile {
    let mut fractions = complete[0].packing.profile.clone();
    for realisation in &complete[1..] {
        let others = realisation.packing.profile.iter().flatten();
        fractions.iter_mut().flatten().zip(others).for_each(|(sum, other)| *sum += other);
    }
    fractions.iter_mut().flatten().for_each(|share| *share /= complete.len() as f64);
    Profile { fractions, layers: profile_layers(study) }
}
