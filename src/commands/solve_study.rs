//! `inkwave solve STUDY.toml --realisation N`: one realisation of a study, packed or read from its
//! files, as a case.

use clap::Args;
use inkwave::input::case::Case;
use inkwave::input::load::load;
use inkwave::input::study::Study;
use inkwave::run::point::pack_realisation;
use inkwave::wave::{Incidence, Scene, Side};
use miette::{IntoDiagnostic, Result};
use std::path::Path;

/// Options of a solve that a study describes.
#[derive(Args)]
pub struct StudyPoint {
    /// Solve this realisation of a study, counted from 1: CASE is then a file for `inkwave run`, and
    /// its grains are packed, or read from the files of its microstructure
    #[arg(long, value_name = "NUMBER")]
    realisation: Option<usize>,
    /// Vacuum wavelength of the realisation's light, nm (default: the study's first)
    #[arg(long, value_name = "NM", requires = "realisation", allow_negative_numbers = true)]
    wavelength_nm: Option<f64>,
    /// Polar angle of the realisation's light, degrees (default: the study's first)
    #[arg(long, value_name = "DEGREES", requires = "realisation", allow_negative_numbers = true)]
    polar_deg: Option<f64>,
}

impl StudyPoint {
    /// The case in a file, or the realisation of the study in it.
    pub fn case(&self, path: &Path) -> Result<Case> {
        let Some(number) = self.realisation else { return Case::read(path).into_diagnostic() };
        let study = load(path).into_diagnostic()?;
        let all = study.realisations;
        if !(1..=all).contains(&number) {
            miette::bail!("--realisation is {number}; allowed is 1 … {all}, the realisations of the study");
        }
        if study.layer.composed.is_some() {
            miette::bail!("--realisation: a composed layer has many slabs; remove [layer.composed]");
        }
        let packing = pack_realisation(&study, number - 1, &()).into_diagnostic()?;
        let incidence = self.incidence(&study, number - 1)?;
        incidence.check().into_diagnostic()?;
        let media = study.media(incidence.wavelength_um);
        Ok(Case { scene: Scene::from_packing(&packing), media, incidence })
    }

    fn incidence(&self, study: &Study, realisation: usize) -> Result<Incidence> {
        let all = &study.wavelengths_nm;
        let (first, last) = (all[0], all[all.len() - 1]);
        let nm = self.wavelength_nm.unwrap_or(first);
        if !(first..=last).contains(&nm) {
            miette::bail!(
                "--wavelength-nm is {nm}; allowed is {first} … {last}, where the study knows its materials"
            );
        }
        Ok(Incidence {
            wavelength_um: 1e-3 * nm,
            polar_deg: self.polar_deg.unwrap_or(study.angles.exact_deg[0]),
            azimuth_deg: study.draw(realisation).azimuth_deg,
            from: Side::Incident,
        })
    }
}
