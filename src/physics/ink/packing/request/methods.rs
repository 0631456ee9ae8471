//! Methods of packing, and their settings.

use crate::ink::PackError;
use crate::numerics::allowed::Allowed;

/// Choice of the packing method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MethodChoice {
    /// Sequential addition up to 0.22 of the accessible volume, relaxation above.
    #[default]
    Auto,
    /// Random sequential addition only (P1 section 3, the dilute case).
    SequentialAddition,
    /// Relaxation of overlaps only (P1 section 3, the dense case).
    Relaxation,
}

/// P1 section 3 calls < 30 % dilute for spheres; elongated grains jam earlier, hence the margin.
pub const AUTO_LIMIT: f64 = 0.22;

/// Limits of random sequential addition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SequentialSettings {
    /// Attempts for one grain before the packing counts as blocked.
    pub attempts_per_grain: u64,
}

impl Default for SequentialSettings {
    fn default() -> Self {
        Self { attempts_per_grain: 200_000 }
    }
}

/// Fraction of an overlap that a sphere moves per step.
const STEP: Allowed = Allowed::between(0.01, 1.0, "");
/// Largest displacement per step.
const STEP_LIMIT_RADII: Allowed = Allowed::between(0.001, 1.0, "");
/// Distance before contact at which forces act.
const INFLATION: Allowed = Allowed::between(1e-6, 0.05, "");
/// Number of batches of grains.
const BATCHES: Allowed = Allowed::between(1.0, 1000.0, "");
/// Number of relaxation steps.
const MAX_STEPS: Allowed = Allowed::between(1.0, 1e9, "");
/// Relative viscosity.
const VISCOSITY: Allowed = Allowed::between(0.1, 100.0, "");
/// Rotation per step.
const ALIGNING_DEG: Allowed = Allowed::between(0.0, 20.0, "°");

/// Relaxation of overlaps (P1 section 3), first-order dynamics μ v = F, J ω = M with Euler steps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RelaxationSettings {
    /// Fraction of an overlap by which each of two free spheres moves in one step: time step ×
    /// stiffness / μ.
    #[cfg_attr(feature = "schema", schemars(transform = STEP.mark()))]
    pub step: f64,
    /// Largest displacement of a sphere in one step, in radii (P1: 0.2).
    #[cfg_attr(feature = "schema", schemars(transform = STEP_LIMIT_RADII.mark()))]
    pub step_limit_radii: f64,
    /// Relative distance before contact at which forces start to act.
    #[cfg_attr(feature = "schema", schemars(transform = INFLATION.mark()))]
    pub inflation: f64,
    /// Number of equal batches in which grains are added, each relaxed before the next.
    #[cfg_attr(feature = "schema", schemars(transform = BATCHES.mark()))]
    pub batches: usize,
    /// Largest number of steps before the relaxation is abandoned.
    #[cfg_attr(feature = "schema", schemars(transform = MAX_STEPS.mark()))]
    pub max_steps: u64,
    /// Viscosity of translation, μ, relative to the time scale of `step`.
    #[cfg_attr(feature = "schema", schemars(transform = VISCOSITY.mark()))]
    pub translational_viscosity: f64,
    /// Viscosity of rotation, J, relative to μ times the square of the grain's longest arm.
    #[cfg_attr(feature = "schema", schemars(transform = VISCOSITY.mark()))]
    pub rotational_viscosity: f64,
    /// Aligning torque at the start of a batch: degrees per step of a freely rotating grain at 45°
    /// to the field.
    #[cfg_attr(feature = "schema", schemars(transform = ALIGNING_DEG.mark()))]
    pub aligning_deg_per_step: f64,
    /// Steps over which the aligning torque ramps down to zero.
    pub aligning_steps: u64,
}

impl Default for RelaxationSettings {
    fn default() -> Self {
        Self {
            step: 0.5,
            step_limit_radii: 0.2,
            inflation: 0.005,
            batches: 1,
            max_steps: 20_000,
            translational_viscosity: 1.0,
            rotational_viscosity: 2.0,
            aligning_deg_per_step: 3.0,
            aligning_steps: 100,
        }
    }
}

impl RelaxationSettings {
    pub(super) fn check(&self) -> Result<(), PackError> {
        let ranges = [
            ("relaxation.step", self.step, STEP),
            ("relaxation.step_limit_radii", self.step_limit_radii, STEP_LIMIT_RADII),
            ("relaxation.inflation", self.inflation, INFLATION),
            ("relaxation.batches", self.batches as f64, BATCHES),
            ("relaxation.max_steps", self.max_steps as f64, MAX_STEPS),
            ("relaxation.translational_viscosity", self.translational_viscosity, VISCOSITY),
            ("relaxation.rotational_viscosity", self.rotational_viscosity, VISCOSITY),
            ("relaxation.aligning_deg_per_step", self.aligning_deg_per_step, ALIGNING_DEG),
        ];
        ranges.into_iter().try_for_each(|(field, value, allowed)| {
            PackError::unless(allowed.holds(value), field, value, allowed, "leave it out for the default")
        })
    }
}

/// Hard-body Monte Carlo after the packing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct EquilibrationSettings {
    /// One sweep tries one move per grain. Spheres at 30 % need about 200, at 50 % about 2500.
    #[cfg_attr(feature = "schema", schemars(example = 250))]
    pub sweeps: u64,
}
