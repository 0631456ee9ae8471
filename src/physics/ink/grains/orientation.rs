//! How the axes of elongated grains are aligned.

use super::name_or_table;
use crate::numerics::Draws;
use crate::numerics::allowed::Allowed;
use crate::numerics::vector::{Rotation, V3, add, cross, dot, scale, unit};
use crate::numerics::written::also_by_name;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// κ of the Watson distribution.
const STRENGTH: Allowed = Allowed::between(0.0, f64::MAX, "");

/// The aligning field on the axes u of a pigment's grains. A finite `strength` κ asks for the Watson
/// distribution exp(± κ (u·n)²) (+ along a direction, − in a plane); without it the start is perfectly aligned.
///
/// The same field gives the torque ± (u·n)(u × n) of the relaxation (P1 section 3: the "magnetic" field) and
/// the Boltzmann weight of the Monte Carlo moves. The torque acts only while the pigment's order falls short of
/// the distribution's, and ramps down, so that it does not prevent convergence. Contacts turn grains away again, so the packing reports the
/// tensor that was achieved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[schemars(deny_unknown_fields, transform = also_by_name)]
pub enum Orientation {
    /// Isotropic, no field.
    #[default]
    Random,
    /// Axes in the plane of the layer.
    InPlane {
        /// κ of the Watson distribution, at least 0; perfect alignment without it.
        #[schemars(transform = STRENGTH.mark(), example = 8.0)]
        strength: Option<f64>,
    },
    /// Axes along z.
    Perpendicular {
        /// κ of the Watson distribution, at least 0; perfect alignment without it.
        #[schemars(transform = STRENGTH.mark(), example = 8.0)]
        strength: Option<f64>,
    },
    /// Axes along any direction.
    Along {
        /// Direction of alignment, of any length above 0; z points from the incident to the exit side.
        #[schemars(example = (0.0, 0.0, 1.0))]
        direction: [f64; 3],
        /// κ of the Watson distribution, at least 0; perfect alignment without it.
        #[schemars(transform = STRENGTH.mark(), example = 8.0)]
        strength: Option<f64>,
    },
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum OrientationWritten {
    Random {},
    InPlane { strength: Option<f64> },
    Perpendicular { strength: Option<f64> },
    Along { direction: [f64; 3], strength: Option<f64> },
}

impl<'de> Deserialize<'de> for Orientation {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match name_or_table::deserialize::<OrientationWritten, D>(deserializer)? {
            OrientationWritten::Random {} => Self::Random,
            OrientationWritten::InPlane { strength } => Self::InPlane { strength },
            OrientationWritten::Perpendicular { strength } => Self::Perpendicular { strength },
            OrientationWritten::Along { direction, strength } => Self::Along { direction, strength },
        })
    }
}

/// The field in numbers: weight exp(κ (u·n)²), κ < 0 for a plane, ± ∞ for perfect alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisField {
    /// n, a unit vector.
    pub axis: V3,
    /// κ; its sign tells a direction (> 0) from a plane (< 0).
    pub kappa: f64,
}

impl Orientation {
    /// What is wrong with the numbers, if anything: field, value found, allowed range.
    pub fn defect(&self) -> Option<(&'static str, String, &'static str)> {
        let (strength, direction) = match *self {
            Self::Random => (None, [0.0, 0.0, 1.0]),
            Self::InPlane { strength } | Self::Perpendicular { strength } => (strength, [0.0, 0.0, 1.0]),
            Self::Along { direction, strength } => (strength, direction),
        };
        if strength.is_some_and(|k| !STRENGTH.holds(k)) {
            return Some(("orientation.strength", format!("{strength:?}"), "finite, 0 or above"));
        }
        let length = dot(direction, direction);
        (!(length.is_finite() && length > 0.0))
            .then(|| ("orientation.direction", format!("{direction:?}"), "a vector that is not zero"))
    }

    pub(crate) fn field(&self) -> Option<AxisField> {
        let z = [0.0, 0.0, 1.0];
        let full = |strength: Option<f64>| strength.unwrap_or(f64::INFINITY);
        match *self {
            Self::Random => None,
            Self::InPlane { strength } => Some(AxisField { axis: z, kappa: -full(strength) }),
            Self::Perpendicular { strength } => Some(AxisField { axis: z, kappa: full(strength) }),
            Self::Along { direction, strength } => {
                Some(AxisField { axis: unit(direction), kappa: full(strength) })
            }
        }
    }
}

impl AxisField {
    /// An axis drawn from exp(κ (u·n)²).
    pub fn draw_axis(&self, draws: &mut Draws) -> V3 {
        let cosine = self.draw_cosine(draws);
        let turn = draws.rotation_with_axis(self.axis);
        let planar = (1.0 - cosine * cosine).max(0.0).sqrt();
        turn.turn([planar, 0.0, cosine])
    }

    fn draw_cosine(&self, draws: &mut Draws) -> f64 {
        let sign = if draws.uniform() < 0.5 { -1.0 } else { 1.0 };
        if self.kappa == f64::INFINITY {
            return sign;
        }
        if self.kappa == f64::NEG_INFINITY {
            return 0.0;
        }
        sign * if self.kappa > 0.0 { near_pole(self.kappa, draws) } else { near_plane(-self.kappa, draws) }
    }

    /// ⟨(u·n)²⟩ of the distribution: the order that a finite strength asks for (midpoint rule, 1e-6).
    pub fn mean_square(&self) -> f64 {
        if self.kappa.is_infinite() {
            return if self.kappa > 0.0 { 1.0 } else { 0.0 };
        }
        let (mut top, mut bottom) = (0.0, 0.0);
        for i in 0..10_000 {
            let square = ((f64::from(i) + 0.5) * 1e-4).powi(2);
            // Referred to the maximum of the exponent, so that a strong field cannot overflow.
            let weight = (self.kappa * square - self.kappa.max(0.0)).exp();
            top += weight * square;
            bottom += weight;
        }
        top / bottom
    }

    /// True when axes of mean (u·n)² `found` are less ordered than the field asks.
    pub fn wants_more(&self, found: f64) -> bool {
        if self.kappa > 0.0 { found < self.mean_square() } else { found > self.mean_square() }
    }

    /// Torque per unit field strength, Σ over the axes: towards n for κ > 0, away for κ < 0.
    pub fn torque(&self, axes: impl Iterator<Item = V3>) -> V3 {
        let sign = self.kappa.signum();
        axes.fold([0.0; 3], |sum, u| add(sum, scale(cross(u, self.axis), sign * dot(u, self.axis))))
    }

    /// κ Σ (u·n)²: the exponent of the Boltzmann weight.
    pub fn exponent(&self, axes: impl Iterator<Item = V3>) -> f64 {
        axes.map(|u| dot(u, self.axis).powi(2)).sum::<f64>() * self.kappa
    }
}

/// |cos θ| from exp(κ c²) on [0, 1]: inversion of the steeper exp(κ c) and acceptance exp(κ (c² − c)).
fn near_pole(kappa: f64, draws: &mut Draws) -> f64 {
    loop {
        let c = if kappa > 1e-9 {
            1.0 + (draws.uniform() * (1.0 - (-kappa).exp()) + (-kappa).exp()).ln() / kappa
        } else {
            draws.uniform()
        };
        let c = c.clamp(0.0, 1.0);
        if draws.uniform() < (kappa * (c * c - c)).exp() {
            return c;
        }
    }
}

/// |cos θ| from exp(−κ c²) on [0, 1]: plain rejection while κ is small, a cut normal otherwise.
fn near_plane(kappa: f64, draws: &mut Draws) -> f64 {
    loop {
        let c = if kappa > 1.0 { draws.normal().abs() / (2.0 * kappa).sqrt() } else { draws.uniform() };
        if c <= 1.0 && (kappa > 1.0 || draws.uniform() < (-kappa * c * c).exp()) {
            return c;
        }
    }
}

/// A uniform rotation, or one whose z axis follows the field.
pub(crate) fn draw_rotation(field: Option<&AxisField>, draws: &mut Draws) -> Rotation {
    let axis = match field {
        Some(field) => field.draw_axis(draws),
        None => draws.direction(),
    };
    draws.rotation_with_axis(axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_the_watson_distribution_has_its_limits() {
        let order = |kappa: f64| AxisField { axis: [0.0, 0.0, 1.0], kappa }.mean_square();
        // Orders: 1/3 + 4κ/45 for weak fields, 1/(2|κ|) in a strong plane, 1 − 1/κ along a strong axis.
        assert!((order(1e-3) - 1.0 / 3.0 - 4e-3 / 45.0).abs() < 1e-7);
        assert!((order(-200.0) - 1.0 / 400.0).abs() < 1e-6);
        assert!((order(500.0) - (1.0 - 1.0 / 500.0)).abs() < 1e-5);
    }

    #[test]
    fn drawn_axes_follow_the_watson_distribution() {
        let mut draws = Draws::new(11, 0);
        for kappa in [-20.0, -2.0, -0.5, 0.0, 0.5, 3.0, 30.0] {
            let field = AxisField { axis: unit([1.0, 2.0, -1.0]), kappa };
            let n = 20_000;
            let mean =
                (0..n).map(|_| dot(field.draw_axis(&mut draws), field.axis).powi(2)).sum::<f64>() / n as f64;
            // Significance: c² lies in [0, 1] with a deviation below 0.32; four standard errors.
            let bar = 4.0 * 0.32 / (n as f64).sqrt();
            assert!((mean - field.mean_square()).abs() < bar, "{kappa}: {mean} {}", field.mean_square());
        }
    }
}
