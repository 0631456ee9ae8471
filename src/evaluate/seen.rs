//! What the finished solves say: spectra of the layer, its distributions, and the ink on its paper.

use crate::appearance::bdf::{Bdf, BdfError, Lobe, Totals, suggested_bandwidth};
use crate::appearance::ink_on_paper::{InkError, InkOnPaper};
use crate::appearance::paper::{LayerOptics, Substrate};
use crate::appearance::slab::Slab;
use crate::input::study::Study;
use crate::material::spectra::molecular_mixture;
use crate::numerics::estimate::Estimate;
use crate::run::runner::{Collected, Realisation};
use crate::store::record::PointRecord;
use crate::wave::FarField;

/// Large cells have orders enough for this bandwidth.
const LEAST_BANDWIDTH: f64 = 0.1;

/// The appearance as far as the finished solves allow.
#[derive(Debug)]
pub struct Seen {
    /// Realisations in every number.
    pub realisations: usize,
    /// Finished wavelengths, and the layer alone at each of them.
    pub layer: Vec<LayerSeen>,
    /// The ink on its paper, once every wavelength is finished, or why there is none.
    pub ink: Result<InkOnPaper, NoInk>,
}

/// The layer alone at one wavelength: one distribution for each incidence, in the order of the study's angles.
#[derive(Clone, Debug)]
pub struct LayerSeen {
    pub wavelength_nm: f64,
    pub bdfs: Vec<Bdf>,
    /// A at the first angle.
    pub absorptance: Estimate,
}

/// Why there is no ink on paper.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum NoInk {
    #[error("the angles were listed: colour and picture need quadrature angles (angles.count)")]
    ListedAngles,
    #[error("not every wavelength and angle of a realisation is finished")]
    Unfinished,
    #[error(transparent)]
    Refused(#[from] InkError),
}

impl LayerSeen {
    /// Totals at the first (smallest) angle from above.
    pub fn totals(&self, lobe: Lobe) -> Totals {
        self.bdfs[0].totals(lobe)
    }
}

/// Bandwidth of the study's diffuse distributions at a wavelength, in direction cosines.
pub fn bandwidth(study: &Study, wavelength_nm: f64) -> f64 {
    suggested_bandwidth(wavelength_nm * 1e-3, study.layer.period_um).max(LEAST_BANDWIDTH)
}

/// Everything that follows from the solves that are there.
///
/// # Errors
/// Records that do not belong together, which is a fault of the program or of the store.
pub fn see(study: &Study, collected: &Collected) -> Result<Seen, BdfError> {
    let complete: Vec<&Realisation> = collected.complete().collect();
    let used: Vec<&Realisation> =
        if complete.is_empty() { collected.realisations.iter().take(1).collect() } else { complete.clone() };
    let wavelengths = 0..study.wavelengths_nm.len();
    let layer = wavelengths.filter_map(|w| layer_seen(study, &used, w).transpose());
    Ok(Seen {
        realisations: used.len(),
        layer: layer.collect::<Result<_, _>>()?,
        ink: if complete.is_empty() { Err(NoInk::Unfinished) } else { on_paper(study, &complete) },
    })
}

/// The records of one realisation at one wavelength: from above, then from below.
fn records(study: &Study, realisation: &Realisation, wavelength: usize) -> Option<Vec<PointRecord>> {
    let each = study.angles.above.len() + study.angles.below.len();
    realisation.points[wavelength * each..(wavelength + 1) * each].iter().cloned().collect()
}

/// `None` when a solve of this wavelength is missing.
fn layer_seen(
    study: &Study,
    used: &[&Realisation],
    wavelength: usize,
) -> Result<Option<LayerSeen>, BdfError> {
    let all: Option<Vec<Vec<PointRecord>>> = used.iter().map(|r| records(study, r, wavelength)).collect();
    let Some(all) = all else { return Ok(None) };
    let each = study.angles.above.len() + study.angles.below.len();
    let ensemble = |k: usize| all.iter().map(|records| records[k].far_field()).collect::<Vec<FarField>>();
    let bdfs = (0..each).map(|k| Bdf::from_ensemble(&ensemble(k))).collect::<Result<_, _>>()?;
    let absorbed: Vec<f64> = all.iter().map(|records| records[0].absorptance).collect();
    let absorptance = Estimate::of_mean(&absorbed);
    Ok(Some(LayerSeen { wavelength_nm: study.wavelengths_nm[wavelength], bdfs, absorptance }))
}

fn on_paper(study: &Study, complete: &[&Realisation]) -> Result<InkOnPaper, NoInk> {
    let rule = study.angles.rule.clone().ok_or(NoInk::ListedAngles)?;
    let wavelengths = 0..study.wavelengths_nm.len();
    let layers = wavelengths.map(|w| complete.iter().map(|r| optics(study, r, w)).collect());
    let layers = layers.collect::<Result<Vec<Vec<LayerOptics>>, NoInk>>()?;
    let substrate = Substrate { albedo: study.paper.albedo.clone(), coupling: study.paper.coupling };
    Ok(InkOnPaper::new(rule, &study.wavelengths_nm, &layers, &substrate)?)
}

fn optics(study: &Study, realisation: &Realisation, wavelength: usize) -> Result<LayerOptics, NoInk> {
    let rule = study.angles.rule.as_ref().ok_or(NoInk::ListedAngles)?;
    let records = records(study, realisation, wavelength).ok_or(NoInk::Unfinished)?;
    let fields: Vec<FarField> = records.iter().map(PointRecord::far_field).collect();
    let (above, below) = fields.split_at(study.angles.above.len());
    let below = (!below.is_empty()).then_some(below);
    let smoothing = bandwidth(study, study.wavelengths_nm[wavelength]);
    let baseline = Some(mixture(study, realisation, wavelength));
    Ok(LayerOptics::from_far_fields(rule, above, below, baseline, smoothing)?)
}

/// The homogeneous layer of the same mean η²: the first guess of the fringes.
fn mixture(study: &Study, realisation: &Realisation, wavelength: usize) -> Slab {
    let shares = study.pigments.iter().zip(&realisation.packing.shares);
    let shares: Vec<_> = shares.map(|(p, s)| (s.achieved_fraction, p.material.index[wavelength])).collect();
    Slab {
        index: molecular_mixture(study.layer.binder.index[wavelength], &shares),
        thickness_um: study.layer.thickness_um,
        wavelength_um: study.wavelengths_nm[wavelength] * 1e-3,
    }
}
