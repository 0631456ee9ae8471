//! What `inkwave solve` is asked about the light: a direction of the lattice, and a lit square of finite size.

use super::say::note;
use clap::Args;
use inkwave::appearance::bdf::Lobe;
use inkwave::appearance::finite_area::{FiniteArea, FiniteAreaError};
use inkwave::input::case::Case;
use inkwave::wave::{FarField, Media};
use miette::{IntoDiagnostic, Result};
use serde_json::{Value, json};

/// Degrees between directions without `--illuminated-step-deg`.
const STEP_DEG: f64 = 5.0;
/// Degrees between directions that are allowed: half a degree gives 130 000 of them.
const STEPS_DEG: std::ops::RangeInclusive<f64> = 0.5..=45.0;

/// Options about the light.
#[derive(Args)]
pub struct LightArgs {
    /// Move the light onto the nearest direction whose (kx, ky) is a multiple of 2π/L, for comparison with programs that
    /// solve no other
    ///
    /// Every direction is solved without it, through its Bloch vector. The output's `snapped` says what was solved:
    /// `polar_deg`, `azimuth_deg`, `vector` [m, n] with kx = 2πm/Lx, ky = 2πn/Ly; and what was `asked`.
    #[arg(long)]
    snap: bool,
    /// Side of a lit square of the layer, µm: adds `finite_area`, its light per steradian (scalar wave)
    ///
    /// Every order becomes a lobe of finite width. `finite_area` has `side_um`; `polar_deg`, from the layer's normal on the
    /// side that the light leaves into; `azimuth_deg`, of the way the light goes, from the x axis; and for `reflected` and
    /// `transmitted` (null where that half-space absorbs): `per_sr`, rows by polar angle, columns by azimuth, as share of the
    /// light on the square per steradian; `total`, its integral over the hemisphere, which tends to R_total or T_total as
    /// 1/SIDE; `diffuse_per_sr` and `diffuse_total`, the same without the specular order; `first_zero_deg`, from the middle
    /// of a lobe at the normal to its first zero. From one period to a thousand wavelengths; the centre is x = y = 0.
    #[arg(long, value_name = "SIDE", allow_negative_numbers = true)]
    illuminated_um: Option<f64>,
    /// Degrees between the directions of `finite_area`, in polar angle and in azimuth (default 5)
    #[arg(long, value_name = "DEGREES", requires = "illuminated_um", allow_negative_numbers = true)]
    illuminated_step_deg: Option<f64>,
}

impl LightArgs {
    /// Refuses before anything is solved.
    pub fn check(&self, case: &Case, vector: bool) -> Result<()> {
        let Some(side) = self.illuminated_um else { return Ok(()) };
        if vector {
            miette::bail!(
                "--illuminated-um is given beside --wave vector; lobes of a lit square are those of the scalar wave: leave \
                 out one of them"
            );
        }
        let step = self.step_deg();
        if !STEPS_DEG.contains(&step) {
            miette::bail!("--illuminated-step-deg is {step}; allowed is 0.5 … 45: try {STEP_DEG}");
        }
        FiniteArea::check_side(side, case.scene.period_um, case.incidence.wavelength_um).into_diagnostic()
    }

    /// Moves the case's light where that was asked; what the output says about it.
    pub fn snap(&self, case: &mut Case) -> Result<Option<Value>> {
        if !self.snap {
            return Ok(None);
        }
        let asked = case.incidence;
        let snapped = asked.snapped(case.scene.period_um, &case.media).into_diagnostic()?;
        case.incidence = snapped.incidence;
        Ok(Some(json!({
            "polar_deg": case.incidence.polar_deg,
            "azimuth_deg": case.incidence.azimuth_deg,
            "vector": snapped.vector,
            "asked": { "polar_deg": asked.polar_deg, "azimuth_deg": asked.azimuth_deg },
        })))
    }

    /// Adds `finite_area` where that was asked.
    pub fn add_area(&self, far: &FarField, media: &Media, report: &mut Value) -> Result<()> {
        let Some(side) = self.illuminated_um else { return Ok(()) };
        let [polar, azimuth] = [(90.0, true), (360.0, false)].map(|(end, closed)| self.angles(end, closed));
        let mut first_zero_deg = f64::INFINITY;
        let mut side_of = |lobe: Lobe| -> Result<Value, FiniteAreaError> {
            let Some(lit) = lit_square(far, media, lobe, side)? else { return Ok(Value::Null) };
            first_zero_deg = first_zero_deg.min(lit.first_zero_deg());
            lobes(&lit, &polar, &azimuth)
        };
        report["finite_area"] = json!({
            "side_um": side,
            "polar_deg": polar,
            "azimuth_deg": azimuth,
            "reflected": side_of(Lobe::Reflected).into_diagnostic()?,
            "transmitted": side_of(Lobe::Transmitted).into_diagnostic()?,
        });
        self.warn_of_step(first_zero_deg);
        Ok(())
    }

    /// Directions further apart than a lobe is wide miss it.
    fn warn_of_step(&self, first_zero_deg: f64) {
        let (step, finest) = (self.step_deg(), *STEPS_DEG.start());
        if step <= first_zero_deg {
            return;
        }
        let finer = format!("--illuminated-step-deg {}", (first_zero_deg / finest).floor() * finest);
        let remedy = if first_zero_deg < finest { "a smaller square" } else { &finer };
        note(format_args!(
            "warning: directions are {step}° apart, and a lobe's first zero lies {first_zero_deg:.2}° from its middle: most \
             lobes fall between directions (the totals hold them all); try {remedy}"
        ));
    }

    fn step_deg(&self) -> f64 {
        self.illuminated_step_deg.unwrap_or(STEP_DEG)
    }

    /// 0, step, … to the end, which belongs to them or not.
    fn angles(&self, end: f64, closed: bool) -> Vec<f64> {
        let step = self.step_deg();
        let angles = (0..).map(|i| step * f64::from(i));
        // Rounding of the step must not add or lose the last direction.
        let slack = if closed { 1e-9 } else { -1e-9 };
        angles.take_while(|a| *a < end + slack).map(|a| a.min(end)).collect()
    }
}

/// The lit square seen from one side; `None` where that half-space absorbs.
fn lit_square(
    far: &FarField,
    media: &Media,
    lobe: Lobe,
    side: f64,
) -> Result<Option<FiniteArea>, FiniteAreaError> {
    match FiniteArea::new(far, media, lobe, side) {
        Err(FiniteAreaError::Absorber { .. }) => Ok(None),
        lit => lit.map(Some),
    }
}

/// One side: tables over the directions, and their integrals.
fn lobes(lit: &FiniteArea, polar: &[f64], azimuth: &[f64]) -> Result<Value, FiniteAreaError> {
    type Table = Result<Vec<Vec<f64>>, FiniteAreaError>;
    let row = |lit: &FiniteArea, p: f64| azimuth.iter().map(|&a| lit.at(p, a)).collect();
    let table = |lit: &FiniteArea| -> Table { polar.iter().map(|&p| row(lit, p)).collect() };
    let diffuse = lit.without_specular();
    let [per_sr, diffuse_per_sr] = [table(lit)?, table(&diffuse)?];
    Ok(json!({
        "per_sr": per_sr,
        "total": lit.total(),
        "diffuse_per_sr": diffuse_per_sr,
        "diffuse_total": diffuse.total(),
        "first_zero_deg": lit.first_zero_deg(),
    }))
}
