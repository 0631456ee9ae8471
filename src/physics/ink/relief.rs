//! Micro-relief: the binder's surface below the tops of the grains (P1 section 3, "микрорельеф"),
//! or that of a rough paper below them.
//!
//! Grains are packed between the paper (z = H) and the top (z = 0). The dry ink, pigment plus
//! binder, has the volume A (H − depth), of which the pigment takes the requested fraction exactly
//! as in a flat layer. As grains protrude from it, the binder sinks: its level follows from
//! conservation of its volume. On the exit side the same holds upside down: what is not ink there
//! is the medium of that side.

use super::error::PackError;
use crate::numerics::allowed::Allowed;
use crate::numerics::interpolate::bilinear;

/// Depths and lengths of a relief; a depth stays below the layer's thickness.
const LENGTH_UM: Allowed = Allowed::between(0.0, f64::MAX, "µm");
/// Degree to which a surface follows the grains.
const FOLLOW: Allowed = Allowed::between(0.0, 1.0, "");

/// Request for the binder's surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReliefRequest {
    /// Thickness difference between the layer of grains, H, and the levelled dry ink: the volume
    /// fractions refer to the dry volume, area × (H − depth).
    #[cfg_attr(feature = "schema", schemars(transform = LENGTH_UM.mark(), example = 0.15))]
    pub depth_um: f64,
    /// The surface's shape.
    #[cfg_attr(feature = "serde", serde(default))]
    pub rule: ReliefRule,
    /// The side of the layer that is rough.
    #[cfg_attr(feature = "serde", serde(default))]
    pub face: RoughFace,
}

/// A face of the layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum RoughFace {
    /// z = 0: the print's surface.
    #[default]
    Incident,
    /// z = H: the paper's surface, where the medium of the exit side fills what is not ink.
    Exit,
}

/// The shape of the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ReliefRule {
    /// One level everywhere.
    #[default]
    Flat,
    /// Level + `follow` × (T − ⟨T⟩), with T the height of the outermost pigment over each point,
    /// smoothed by a Gaussian of standard deviation `smoothing_um`: surface tension levels shorter
    /// structures. Never above the layer.
    Following {
        /// Degree to which the surface follows the grains: 0 (flat) to 1.
        #[cfg_attr(feature = "schema", schemars(transform = FOLLOW.mark(), example = 0.5))]
        follow: f64,
        /// Standard deviation of the smoothing, µm, at least 0.
        #[cfg_attr(feature = "schema", schemars(transform = LENGTH_UM.mark(), example = 0.1))]
        smoothing_um: f64,
    },
    /// Level + a height of its own in every realisation: Gaussian, with the autocorrelation
    /// exp(−r²/ℓ²). Valleys bare the grains below.
    Random {
        /// Standard deviation of the height, µm, at most half of `depth_um`.
        #[cfg_attr(feature = "schema", schemars(transform = LENGTH_UM.mark(), example = 0.05))]
        rms_um: f64,
        /// Correlation length ℓ, µm: at least √2 rms_um (slopes of 45°), at most a fifth of the
        /// period.
        #[cfg_attr(feature = "schema", schemars(transform = LENGTH_UM.mark(), example = 0.2))]
        correlation_um: f64,
    },
}

/// Largest root mean square slope of a random surface, √2 rms/ℓ: steeper ones are steps for the
/// columns in which heights are given.
const STEEPEST: f64 = 1.0;
/// Standard deviations of height below the top of the layer, where a surface is cut off.
const HEADROOM: f64 = 2.0;
/// Correlation lengths in a period, so that a surface does not meet its own image.
const LENGTHS: f64 = 5.0;

impl ReliefRequest {
    pub(crate) fn check(&self, thickness_um: f64, period_um: [f64; 2], walls: bool) -> Result<(), PackError> {
        let remedy = "set walls = true, or remove the relief";
        PackError::unless(walls, "relief", "with walls = false", "relief between walls only", remedy)?;
        let sound = self.depth_um >= 0.0 && self.depth_um < thickness_um;
        let allowed = format!("0 up to the thickness, {thickness_um} µm");
        PackError::unless(sound, "relief.depth_um", self.depth_um, allowed, "lower the depth")?;
        match self.rule {
            ReliefRule::Flat => Ok(()),
            ReliefRule::Following { follow, smoothing_um } => {
                let field = "relief.rule.follow";
                let sound = FOLLOW.holds(follow);
                PackError::unless(sound, field, follow, "0 (flat) to 1", "lower it")?;
                let field = "relief.rule.smoothing_um";
                let sound = LENGTH_UM.holds(smoothing_um);
                PackError::unless(sound, field, smoothing_um, "finite, at least 0", "about one grain radius")
            }
            ReliefRule::Random { rms_um, correlation_um } => {
                self.check_random(rms_um, correlation_um, period_um[0].min(period_um[1]))
            }
        }
    }

    /// Height of pigment and binder when levelled.
    pub(crate) fn dry_um(&self, thickness_um: f64) -> f64 {
        thickness_um - self.depth_um
    }

    fn check_random(&self, rms_um: f64, correlation_um: f64, period_um: f64) -> Result<(), PackError> {
        let highest = self.depth_um / HEADROOM;
        let sound = (0.0..=highest).contains(&rms_um);
        let allowed = format!("0 … {highest} µm, half of the depth above which grains end");
        PackError::unless(sound, "relief.rule.rms_um", rms_um, allowed, "raise relief.depth_um")?;
        let least = std::f64::consts::SQRT_2 * rms_um / STEEPEST;
        let most = period_um / LENGTHS;
        let sound = (least..=most).contains(&correlation_um) && correlation_um > 0.0;
        let allowed = format!("{least:.4} … {most:.4} µm, for slopes up to 45° and cells of 5 lengths");
        let remedy = "lower rms_um, or raise layer.period_um";
        PackError::unless(sound, "relief.rule.correlation_um", correlation_um, allowed, remedy)
    }
}

/// The binder's surface as heights above the opposite face on a periodic grid, with its volume
/// balance.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    pub(super) heights_um: Vec<f64>,
    /// Height of the free surface, the higher of binder and grains, at the grid points.
    pub(super) surface_um: Vec<f64>,
    /// Points of the height grid along x and y.
    pub count: [usize; 2],
    pub(super) period_um: [f64; 2],
    /// The requested rule.
    pub rule: ReliefRule,
    /// The rough face.
    pub face: RoughFace,
    /// Fraction of the pigment's volume above the binder's surface.
    pub protruding_share: f64,
    /// Volume fraction of pigment below the binder's surface (the request refers to the dry volume
    /// instead).
    pub fraction_below: f64,
    /// Height of pigment and binder when levelled, the reference of the volume fractions.
    pub dry_height_um: f64,
    /// Relative error of the pigment's volume on the grid of columns: the accuracy of the volume
    /// balance.
    pub balance_error: f64,
}

impl Relief {
    /// Height of the binder above the opposite face at (x, y): bilinear between the points of the
    /// grid.
    pub fn height_um(&self, x_um: f64, y_um: f64) -> f64 {
        bilinear(&self.heights_um, self.count, self.period_um, [x_um, y_um])
    }

    /// The surface on a layer that lies on `by_um` of other layers, opposite to the rough face.
    pub(super) fn raised(&self, by_um: f64) -> Self {
        let mut raised = self.clone();
        raised.heights_um.iter_mut().chain(&mut raised.surface_um).for_each(|height| *height += by_um);
        raised.dry_height_um += by_um;
        raised
    }

    /// Mean height of the binder above the opposite face, µm.
    pub fn mean_height_um(&self) -> f64 {
        mean(&self.heights_um)
    }

    /// Root mean square deviation of the binder's height from its mean, µm.
    pub fn rms_height_um(&self) -> f64 {
        rms(&self.heights_um)
    }

    /// Root mean square deviation of the free surface: the higher of binder and grains.
    pub fn rms_surface_um(&self) -> f64 {
        rms(&self.surface_um)
    }
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn rms(values: &[f64]) -> f64 {
    let centre = mean(values);
    (values.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}
