//! Options of `inkwave solve`: about the light, directions of the lattice, and a lit square of
//! finite size; and `inkwave solve STUDY.toml --realisation N`, one realisation of a study, packed
//! or read from its files, as a case.

use super::diagnostics::{case_report, mixed_up_report};
use clap::Args;
use inkwave::appearance::bdf::Lobe;
use inkwave::appearance::finite_area::{FiniteArea, FiniteAreaError};
use inkwave::input::case::Case;
use inkwave::input::load::load;
use inkwave::input::study::Study;
use inkwave::input::wave_kind::WaveKind;
use inkwave::run::point::pack_realisation;
use inkwave::wave::{FarField, Incidence, Media, Scene, Side};
use miette::{IntoDiagnostic, Result};
use serde_json::{Value, json};
use std::path::Path;

/// Default spacing of the directions, degrees.
const STEP_DEG: f64 = 5.0;
/// Allowed spacings of the directions, degrees; half a degree gives 130 000 directions.
const STEPS_DEG: std::ops::RangeInclusive<f64> = 0.5..=45.0;

/// Options about the light.
#[derive(Args)]
pub struct LightArgs {
    /// Snap the light to the nearest direction whose (kx, ky) is a multiple of 2π/L, for comparison
    /// with programs that solve only these
    ///
    /// Without this option any direction is solved, through its Bloch vector. `snapped` in the
    /// output holds the direction solved, `polar_deg`, `azimuth_deg` and `vector` [m, n] with kx =
    /// 2πm/Lx and ky = 2πn/Ly, and the requested one, `asked`.
    #[arg(long)]
    snap: bool,
    /// Add `finite_area`, the light per steradian from an illuminated square of this side, µm
    /// (scalar wave)
    ///
    /// Every order becomes a lobe of finite width. `finite_area` has `side_um`; `polar_deg`, from
    /// the layer's normal on the side that the light leaves to; `azimuth_deg`, of the direction of
    /// propagation, from the x axis; and for `reflected` and `transmitted` (null where that
    /// half-space absorbs): `per_sr`, rows by polar angle, columns by azimuth, as share per
    /// steradian of the light on the square; `total`, its integral over the hemisphere, which tends
    /// to R_total or T_total as 1/SIDE; `diffuse_per_sr` and `diffuse_total`, the same without the
    /// specular order; `first_zero_deg`, from the middle of a lobe at the normal to its first zero.
    /// SIDE may be one period to a thousand wavelengths; the square is centred on x = y = 0.
    #[arg(long, value_name = "SIDE", allow_negative_numbers = true)]
    illuminated_um: Option<f64>,
    /// Spacing of the directions of `finite_area` in polar angle and azimuth, degrees (default: 5)
    #[arg(long, value_name = "DEGREES", requires = "illuminated_um", allow_negative_numbers = true)]
    illuminated_step_deg: Option<f64>,
}

impl LightArgs {
    /// Checks the options before anything is solved.
    pub fn check(&self, case: &Case, vector: bool) -> Result<()> {
        let Some(side) = self.illuminated_um else { return Ok(()) };
        if vector {
            miette::bail!(
                "--illuminated-um is given with the vector wave; the lobes of a lit square are computed for the scalar wave only: \
                 leave it out, or take --wave scalar"
            );
        }
        let step = self.step_deg();
        if !STEPS_DEG.contains(&step) {
            miette::bail!("--illuminated-step-deg is {step}; allowed is 0.5 … 45: try {STEP_DEG}");
        }
        FiniteArea::check_side(side, case.scene.period_um, case.incidence.wavelength_um).into_diagnostic()
    }

    /// The light to solve, snapped if requested, and the entry `snapped` of the output.
    pub fn snapped(&self, case: &Case, requested: Incidence) -> Result<(Incidence, Option<Value>)> {
        if !self.snap {
            return Ok((requested, None));
        }
        let snapped = requested.snapped(case.scene.period_um, &case.media).into_diagnostic()?;
        let light = snapped.incidence;
        let entry = json!({
            "polar_deg": light.polar_deg,
            "azimuth_deg": light.azimuth_deg,
            "vector": snapped.vector,
            "asked": { "polar_deg": requested.polar_deg, "azimuth_deg": requested.azimuth_deg },
        });
        Ok((light, Some(entry)))
    }

    /// Adds `finite_area` if requested; returns the angle from the middle of a lobe to its first
    /// zero, degrees, or infinity.
    pub fn add_area(&self, far: &FarField, media: &Media, report: &mut Value) -> Result<f64> {
        let Some(side) = self.illuminated_um else { return Ok(f64::INFINITY) };
        let polar = self.angles(90.0, true);
        let azimuth = self.angles(360.0, false);
        let mut first_zero_deg = f64::INFINITY;
        let mut area = json!({ "side_um": side, "polar_deg": polar, "azimuth_deg": azimuth });
        for (name, lobe) in [("reflected", Lobe::Reflected), ("transmitted", Lobe::Transmitted)] {
            let lit = FiniteArea::new(far, media, lobe, side);
            if matches!(lit, Err(FiniteAreaError::Absorber { .. })) {
                area[name] = Value::Null;
                continue;
            }
            let lit = lit.into_diagnostic()?;
            first_zero_deg = first_zero_deg.min(lit.first_zero_deg());
            area[name] = lobes(&lit, &polar, &azimuth).into_diagnostic()?;
        }
        report["finite_area"] = area;
        Ok(first_zero_deg)
    }

    /// Warns if directions are so far apart that they miss lobes.
    pub fn warn_of_step(&self, first_zero_deg: f64) {
        let step = self.step_deg();
        let finest = *STEPS_DEG.start();
        if step <= first_zero_deg {
            return;
        }
        let finer = format!("--illuminated-step-deg {}", (first_zero_deg / finest).floor() * finest);
        let remedy = if first_zero_deg < finest { "a smaller square" } else { &finer };
        note!(
            "warning: directions are {step}° apart, and a lobe's first zero lies {first_zero_deg:.2}° from its middle: most \
             lobes fall between directions (the totals include them all); try {remedy}"
        );
    }

    fn step_deg(&self) -> f64 {
        self.illuminated_step_deg.unwrap_or(STEP_DEG)
    }

    /// 0, step, 2 step, … up to `end`, which is included if `closed`.
    fn angles(&self, end: f64, closed: bool) -> Vec<f64> {
        let step = self.step_deg();
        // Rounding of the step must not add or lose the last direction.
        let slack = if closed { 1e-9 } else { -1e-9 };
        (0..).map(|i| step * f64::from(i)).take_while(|a| *a < end + slack).map(|a| a.min(end)).collect()
    }
}

/// One side: tables over the directions, and their integrals.
fn lobes(lit: &FiniteArea, polar: &[f64], azimuth: &[f64]) -> Result<Value, FiniteAreaError> {
    let table = |lit: &FiniteArea| -> Result<Vec<Vec<f64>>, FiniteAreaError> {
        polar.iter().map(|&p| azimuth.iter().map(|&a| lit.at(p, a)).collect()).collect()
    };
    let diffuse = lit.without_specular();
    Ok(json!({
        "per_sr": table(lit)?,
        "total": lit.total(),
        "diffuse_per_sr": table(&diffuse)?,
        "diffuse_total": diffuse.total(),
        "first_zero_deg": lit.first_zero_deg(),
    }))
}

/// Options of a solve that a study describes.
#[derive(Args)]
pub struct StudyPoint {
    /// Solve this realisation of a study, counted from 1: CASE is then a file for `inkwave run`,
    /// and its grains are packed, or read from the files of its microstructure
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
    /// The case in a file, or the realisation of the study in it, and its wave.
    pub fn case(&self, path: &Path) -> Result<(Case, WaveKind)> {
        let Some(number) = self.realisation else {
            let case = Case::read(path).map_err(|error| case_report(error, path))?;
            return Ok((case, WaveKind::Scalar));
        };
        let study = load(path).map_err(|error| mixed_up_report(error, "study"))?;
        let all = study.realisations;
        if !(1..=all).contains(&number) {
            miette::bail!("--realisation is {number}; allowed is 1 … {all}, the realisations of the study");
        }
        if study.composed().is_some() {
            miette::bail!("--realisation: a composed layer has many slabs; remove [layer.composed]");
        }
        let packing = pack_realisation(&study, number - 1, &()).into_diagnostic()?;
        let incidence = self.incidence(&study, number - 1)?;
        incidence.check().into_diagnostic()?;
        let media = study.media(incidence.wavelength_um);
        let wave = if study.wave.is_vector() { WaveKind::Vector } else { WaveKind::Scalar };
        let scene = Scene::from_packing(&packing);
        Ok((Case { scene, media, incidence, directions: Vec::new(), remarks: Vec::new() }, wave))
    }

    fn incidence(&self, study: &Study, realisation: usize) -> Result<Incidence> {
        let all = &study.wavelengths_nm;
        let first = all[0];
        let last = all[all.len() - 1];
        let nm = self.wavelength_nm.unwrap_or(first);
        if !(first..=last).contains(&nm) {
            miette::bail!(
                "--wavelength-nm is {nm}; allowed is {first} … {last}, where the study knows its materials"
            );
        }
        let polar_deg = self.polar_deg.unwrap_or(study.angles.exact_deg[0]);
        let azimuth_deg = study.draw(realisation).azimuth_deg;
        Ok(Incidence { wavelength_um: 1e-3 * nm, polar_deg, azimuth_deg, from: Side::Incident })
    }
}
