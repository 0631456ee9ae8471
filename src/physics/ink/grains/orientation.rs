//! Alignment of the axes of elongated grains.

use crate::numerics::Draws;
use crate::numerics::allowed::Allowed;
#[cfg(feature = "schema")]
use crate::numerics::files::also_by_name;
#[cfg(feature = "serde")]
use crate::numerics::files::no_keys;
use crate::numerics::vector::{V3, add, cross, dot, scale, unit};

/// Concentration parameter κ of the Watson distribution.
const STRENGTH: Allowed = Allowed::between(0.0, f64::MAX, "");

/// Alignment of the axes u of a pigment's grains by a field. A finite `strength` κ gives the Watson
/// distribution exp(± κ (u·n)²) (+ along a direction, − in a plane); without it the initial
/// alignment is perfect.
///
/// The same field gives the torque ± (u·n)(u × n) of the relaxation (P1 section 3: the "magnetic"
/// field) and the Boltzmann weight of the Monte Carlo moves. The torque acts only while the
/// pigment's order is below that of the distribution, and ramps down, so that it does not prevent
/// convergence. Contacts rotate grains out of alignment, so the packing reports the tensor
/// achieved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(transform = also_by_name))]
pub enum Orientation {
    /// Isotropic, no field.
    #[default]
    #[cfg_attr(feature = "serde", serde(deserialize_with = "no_keys"))]
    Random,
    /// Axes in the plane of the layer.
    InPlane {
        /// κ of the Watson distribution, at least 0; perfect alignment without it.
        #[cfg_attr(feature = "schema", schemars(transform = STRENGTH.mark(), example = 8.0))]
        strength: Option<f64>,
    },
    /// Axes along z.
    Perpendicular {
        /// κ of the Watson distribution, at least 0; perfect alignment without it.
        #[cfg_attr(feature = "schema", schemars(transform = STRENGTH.mark(), example = 8.0))]
        strength: Option<f64>,
    },
    /// Axes along any direction.
    Along {
        /// Direction of alignment, of any length above 0; z points from the incident to the exit
        /// side.
        #[cfg_attr(feature = "schema", schemars(example = (0.0, 0.0, 1.0)))]
        direction: [f64; 3],
        /// κ of the Watson distribution, at least 0; perfect alignment without it.
        #[cfg_attr(feature = "schema", schemars(transform = STRENGTH.mark(), example = 8.0))]
        strength: Option<f64>,
    },
}

/// The aligning field as numbers: weight exp(κ (u·n)²), κ < 0 for a plane, ± ∞ for perfect
/// alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisField {
    /// Unit vector n of the field.
    pub axis: V3,
    /// Concentration κ: positive along a direction, negative in a plane.
    pub kappa: f64,
}

impl Orientation {
    /// Direction and strength of the field, and 1 along the direction or −1 across it.
    fn parts(&self) -> Option<(V3, Option<f64>, f64)> {
        let z = [0.0, 0.0, 1.0];
        match *self {
            Self::Random => None,
            Self::InPlane { strength } => Some((z, strength, -1.0)),
            Self::Perpendicular { strength } => Some((z, strength, 1.0)),
            Self::Along { direction, strength } => Some((direction, strength, 1.0)),
        }
    }

    /// The first invalid number, if any: field, value found, allowed range.
    pub fn defect(&self) -> Option<(&'static str, String, &'static str)> {
        let (direction, strength, _) = self.parts()?;
        if let Some(wrong) = strength.filter(|k| !STRENGTH.holds(*k)) {
            return Some(("orientation.strength", wrong.to_string(), "finite, 0 or above"));
        }
        let length = dot(direction, direction);
        (!(length.is_finite() && length > 0.0))
            .then(|| ("orientation.direction", format!("{direction:?}"), "a vector that is not zero"))
    }

    pub(crate) fn field(&self) -> Option<AxisField> {
        let (direction, strength, sign) = self.parts()?;
        Some(AxisField { axis: unit(direction), kappa: sign * strength.unwrap_or(f64::INFINITY) })
    }
}

impl AxisField {
    /// An axis drawn from exp(κ (u·n)²).
    pub fn draw_axis(&self, draws: &mut Draws) -> V3 {
        let cosine = self.draw_cosine(draws);
        let planar = (1.0 - cosine * cosine).max(0.0).sqrt();
        draws.rotation_with_axis(self.axis).turn([planar, 0.0, cosine])
    }

    fn draw_cosine(&self, draws: &mut Draws) -> f64 {
        let sign = if draws.uniform() < 0.5 { -1.0 } else { 1.0 };
        match self.kappa {
            f64::INFINITY => sign,
            f64::NEG_INFINITY => 0.0,
            kappa if kappa > 0.0 => sign * near_pole(kappa, draws),
            kappa => sign * near_plane(-kappa, draws),
        }
    }

    /// ⟨(u·n)²⟩ of the distribution: the order of a finite strength (midpoint rule, 1e-6).
    pub fn mean_square(&self) -> f64 {
        if self.kappa.is_infinite() {
            return if self.kappa > 0.0 { 1.0 } else { 0.0 };
        }
        let squares = (0..10_000).map(|i| ((f64::from(i) + 0.5) * 1e-4).powi(2));
        // Relative to the maximum of the exponent, so that a strong field cannot overflow.
        let weights = squares.map(|square| (square, (self.kappa * square - self.kappa.max(0.0)).exp()));
        let [top, bottom] = weights.fold([0.0; 2], |[top, bottom], (q, w)| [top + w * q, bottom + w]);
        top / bottom
    }

    /// Whether axes of mean (u·n)² `mean_square` are less ordered than the distribution.
    pub fn wants_more(&self, mean_square: f64) -> bool {
        if self.kappa > 0.0 { mean_square < self.mean_square() } else { mean_square > self.mean_square() }
    }

    /// Torque per unit field strength, summed over the axes: towards n for κ > 0, away for κ < 0.
    pub fn torque(&self, axes: impl Iterator<Item = V3>) -> V3 {
        let sign = self.kappa.signum();
        axes.fold([0.0; 3], |sum, u| add(sum, scale(cross(u, self.axis), sign * dot(u, self.axis))))
    }

    /// Exponent of the Boltzmann weight, κ Σ (u·n)².
    pub fn exponent(&self, axes: impl Iterator<Item = V3>) -> f64 {
        axes.map(|u| dot(u, self.axis).powi(2)).sum::<f64>() * self.kappa
    }
}

/// Draws |cos θ| from exp(κ c²) on [0, 1]: inversion of the steeper exp(κ c), acceptance exp(κ (c²
/// − c)).
fn near_pole(kappa: f64, draws: &mut Draws) -> f64 {
    loop {
        let u = draws.uniform();
        let steep = || 1.0 + (u * (1.0 - (-kappa).exp()) + (-kappa).exp()).ln() / kappa;
        let c = if kappa > 1e-9 { steep() } else { u }.clamp(0.0, 1.0);
        if draws.uniform() < (kappa * (c * c - c)).exp() {
            return c;
        }
    }
}

/// Draws |cos θ| from exp(−κ c²) on [0, 1]: plain rejection for small κ, a truncated normal
/// otherwise.
fn near_plane(kappa: f64, draws: &mut Draws) -> f64 {
    loop {
        let c = if kappa > 1.0 { draws.normal().abs() / (2.0 * kappa).sqrt() } else { draws.uniform() };
        if c <= 1.0 && (kappa > 1.0 || draws.uniform() < (-kappa * c * c).exp()) {
            return c;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_the_watson_distribution_has_its_limits() {
        let order = |kappa: f64| AxisField { axis: [0.0, 0.0, 1.0], kappa }.mean_square();
        // Orders: 1/3 + 4κ/45 for weak fields, 1/(2|κ|) in a strong plane, 1 − 1/κ along a strong
        // axis.
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
