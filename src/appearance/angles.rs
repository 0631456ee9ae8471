//! Which polar angles to solve for: quadrature nodes for hemispherical means, interpolation between them.

#[cfg(doc)]
use super::paper::LayerOptics;
use super::paper::{Coupling, PaperError};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// Most nodes of a rule; more would be nearer to grazing than any solve can go.
const MOST_POINTS: usize = 64;
/// Slack of angle comparisons, degrees: a node at acos(1/2) is not exactly 60.
const ANGLE_SLACK_DEG: f64 = 1e-9;

/// A polar angle to solve for and its weight in the hemispherical mean 2∫₀¹ f(μ) μ dμ ≈ Σ weight · f.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AngleNode {
    pub polar_deg: f64,
    pub weight: f64,
}

/// Angles for light from above (in vacuum) and from below (in the medium there).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AngleRule {
    /// Nodes for T(θ) and R(θ); the first is normal incidence, angles increase.
    pub above: Vec<AngleNode>,
    /// Nodes for R_b(θ), θ inside the lower half-space.
    pub below: Vec<AngleNode>,
    pub coupling: Coupling,
}

/// A polar angle of the picture with its interpolation weights on the rule's nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct PolarAngle {
    pub polar_deg: f64,
    /// Polynomial through the nodes.
    pub(super) shares: Vec<f64>,
    /// Polynomial through the nodes that vanishes at grazing: for differences from a baseline.
    pub(super) shares_of_difference: Vec<f64>,
}

impl AngleRule {
    /// `points` angles from above; from below the same for a gap, twice as many (cone and total internal
    /// reflection) for optical contact.
    ///
    /// # Errors
    /// As [`angle_rule`] and [`internal_angle_rule`].
    pub fn new(points: usize, picture_max_deg: f64, coupling: Coupling) -> Result<Self, PaperError> {
        let above = angle_rule(points, picture_max_deg)?;
        let below = match coupling {
            Coupling::Gap => above.clone(),
            Coupling::OpticalContact { index } => internal_angle_rule(points, points, index)?,
        };
        Ok(Self { above, below, coupling })
    }

    /// Interpolation at a viewing or illumination angle: the polynomial in μ = cos θ through all nodes (differences
    /// from a [`Slab`](super::slab::Slab) vanish at grazing, where every layer reflects all: one point more).
    ///
    /// # Errors
    /// Angles outside 0° to the rule's largest node (extrapolation towards grazing is not offered).
    pub fn at(&self, polar_deg: f64) -> Result<PolarAngle, PaperError> {
        let largest = self.above.last().map_or(0.0, |n| n.polar_deg);
        if !(0.0..=largest + ANGLE_SLACK_DEG).contains(&polar_deg) {
            return Err(PaperError::AngleOutOfRange { value: polar_deg, largest });
        }
        let mut mu: Vec<f64> = self.above.iter().map(|n| n.polar_deg.to_radians().cos()).collect();
        let at = polar_deg.to_radians().cos();
        let shares = lagrange(&mu, at);
        mu.push(0.0);
        let mut shares_of_difference = lagrange(&mu, at);
        shares_of_difference.pop();
        Ok(PolarAngle { polar_deg, shares, shares_of_difference })
    }
}

impl AngleRule {
    /// Interpolation weights at node `k` from all other nodes (and zero at grazing, for differences).
    pub(super) fn shares_without(&self, k: usize, zero_at_grazing: bool) -> Vec<f64> {
        let mut mu: Vec<f64> = self.above.iter().map(|n| n.polar_deg.to_radians().cos()).collect();
        let at = mu.remove(k);
        if zero_at_grazing {
            mu.push(0.0);
        }
        let mut shares = lagrange(&mu, at);
        shares.truncate(self.above.len() - 1);
        shares.insert(k, 0.0);
        shares
    }
}

/// Σ weight · value: the mean over the hemisphere, 2∫₀¹ f μ dμ.
pub fn hemispherical_mean(nodes: &[AngleNode], values: &[f64]) -> f64 {
    nodes.iter().zip(values).map(|(n, v)| n.weight * v).sum()
}

/// Gauss–Lobatto rule in μ = cos θ on [0, 1] for 2∫₀¹ f(μ) μ dμ, without its grazing node, whose weight is zero.
///
/// Normal incidence (which every picture needs) is a node, the weights are positive and sum to 1, and
/// polynomials in μ up to degree 2·points − 2 are integrated exactly. T and R of a layer are smooth in μ (not in
/// μ²). *Measured* on six layers (H = 1 µm, n = 1.4–1.558, κ = 0–0.3, λ = 0.45–0.65 µm; `validation/data/paper.json`)
/// that scatter by a model (κ of the coherent wave raised by 0.005 or 0.02, what it loses re-appears diffusely): largest
/// error of T̄ and R̄_b, and of natural light and π f in 0–60°, without a baseline, with the slab of √⟨η²⟩, and with the
/// slab fitted to the specular R and T ([`LayerOptics::fit_baseline`], what
/// [`InkOnPaper`](super::ink_on_paper::InkOnPaper) does). The worst layer is the clear film with strong fringes; strongly
/// absorbing ones are orders better. In this model the coherent wave sees exactly a slab, which favours the fit; layers
/// of grains have not been measured yet. A layer that does not scatter is exact with any number of angles.
///
#[doc = include_str!("angle_errors.md")]
///
/// # Errors
/// No points or more than 64; a picture that needs an angle beyond the largest node.
pub fn angle_rule(points: usize, picture_max_deg: f64) -> Result<Vec<AngleNode>, PaperError> {
    if !(1..=MOST_POINTS).contains(&points) {
        return Err(PaperError::Points { value: points, most: MOST_POINTS });
    }
    let node = |(x, weight): (f64, f64)| {
        let mu = (1.0 + x) / 2.0;
        AngleNode { polar_deg: mu.acos().to_degrees(), weight: mu * weight }
    };
    let nodes: Vec<AngleNode> = lobatto(points + 1).into_iter().take(points).map(node).collect();
    let largest = nodes[points - 1].polar_deg;
    if !(0.0..=largest + ANGLE_SLACK_DEG).contains(&picture_max_deg) {
        return Err(PaperError::PictureAngle { value: picture_max_deg, largest, points });
    }
    Ok(nodes)
}

/// Rule for 2∫₀¹ R_b(μ') μ' dμ' inside a medium of index n > 1 that touches the layer (optical contact).
///
/// Split at the critical angle, where R_b has a square-root kink. Inside the escape cone the variable is the
/// vacuum cosine (n² μ' dμ' = μ dμ: the rule of [`angle_rule`] over n²); beyond it μ' = μ_c cos t, Gauss–Legendre
/// in t, in which the evanescent decay √(μ_c² − μ'²) = μ_c sin t is smooth. The weights sum to 1.
///
/// # Errors
/// Index not above 1, or numbers of points outside 1–64.
pub fn internal_angle_rule(
    cone_points: usize,
    beyond_points: usize,
    index: f64,
) -> Result<Vec<AngleNode>, PaperError> {
    if !(index.is_finite() && index > 1.0) {
        return Err(PaperError::ContactIndex { value: index });
    }
    if !(1..=MOST_POINTS).contains(&beyond_points) {
        return Err(PaperError::Points { value: beyond_points, most: MOST_POINTS });
    }
    let refract = |n: AngleNode| AngleNode {
        polar_deg: (n.polar_deg.to_radians().sin() / index).asin().to_degrees(),
        weight: n.weight / (index * index),
    };
    let mut nodes: Vec<AngleNode> = angle_rule(cone_points, 0.0)?.into_iter().map(refract).collect();
    nodes.extend(beyond_critical(beyond_points, index));
    Ok(nodes)
}

/// Nodes beyond the critical angle; weights scaled so that they sum to 1 − 1/n² exactly.
fn beyond_critical(points: usize, index: f64) -> Vec<AngleNode> {
    let critical_mu = (1.0 - 1.0 / (index * index)).sqrt();
    let mut nodes: Vec<AngleNode> = legendre_nodes(points)
        .into_iter()
        .map(|(x, w)| {
            let t = FRAC_PI_2 * (1.0 + x) / 2.0;
            AngleNode { polar_deg: (critical_mu * t.cos()).acos().to_degrees(), weight: w * (2.0 * t).sin() }
        })
        .collect();
    let scale = critical_mu * critical_mu / nodes.iter().map(|n| n.weight).sum::<f64>();
    nodes.iter_mut().for_each(|n| n.weight *= scale);
    nodes
}

/// Lagrange basis of the nodes at a point.
fn lagrange(nodes: &[f64], at: f64) -> Vec<f64> {
    let factor = |j: usize, k: usize| (at - nodes[k]) / (nodes[j] - nodes[k]);
    let basis = |j| (0..nodes.len()).filter(|&k| k != j).map(|k| factor(j, k)).product();
    (0..nodes.len()).map(basis).collect()
}

/// Gauss–Lobatto nodes and weights on [−1, 1], from +1 downwards: zeros of (1 − x²) P'_{n−1}.
fn lobatto(n: usize) -> Vec<(f64, f64)> {
    let last = n - 1;
    let node = |k: usize| {
        let mut x = (PI * k as f64 / last as f64).cos();
        for _ in 0..50 {
            // Newton on q = (1 − x²) P'_last = last (P_{last−1} − x P_last), q' = −last (last + 1) P_last
            let (p, before) = legendre(last, x);
            let step = (x * p - before) / ((last + 1) as f64 * p);
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        let (p, _) = legendre(last, x);
        (x, 2.0 / ((n * last) as f64 * p * p))
    };
    (0..n).map(node).collect()
}

/// Gauss–Legendre nodes and weights on [−1, 1], from +1 downwards.
fn legendre_nodes(n: usize) -> Vec<(f64, f64)> {
    let node = |k: usize| {
        let mut x = (PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let derivative = |x: f64, (p, before): (f64, f64)| n as f64 * (before - x * p) / (1.0 - x * x);
        for _ in 0..50 {
            let values = legendre(n, x);
            let step = values.0 / derivative(x, values);
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        let slope = derivative(x, legendre(n, x));
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

/// (P_n, P_{n−1}) at x, n ≥ 1.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut p, mut before) = (x, 1.0);
    for k in 2..=n {
        let next = ((2 * k - 1) as f64 * x * p - (k - 1) as f64 * before) / k as f64;
        (before, p) = (p, next);
    }
    (p, before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_for_polynomials_up_to_its_degree() {
        for points in 1..=16 {
            let nodes = angle_rule(points, 0.0).unwrap();
            assert_eq!(nodes[0].polar_deg, 0.0);
            for degree in 0..=2 * points - 2 {
                let values: Vec<f64> =
                    nodes.iter().map(|n| n.polar_deg.to_radians().cos().powi(degree as i32)).collect();
                // identity: 2∫μ^{d+1} dμ = 2/(d + 2), rounding of the sum and of acos/cos
                let exact = 2.0 / (degree as f64 + 2.0);
                assert!((hemispherical_mean(&nodes, &values) - exact).abs() < 1e-13, "{points}, {degree}");
            }
        }
    }

    #[test]
    fn the_internal_rule_covers_the_hemisphere_and_converges() {
        for index in [1.2, 1.558, 2.0] {
            let mean = |points, f: &dyn Fn(f64) -> f64| {
                let nodes = internal_angle_rule(points, points, index).unwrap();
                let at: Vec<f64> = nodes.iter().map(|n| f(n.polar_deg.to_radians().cos())).collect();
                hemispherical_mean(&nodes, &at)
            };
            assert!((mean(1, &|_| 1.0) - 1.0).abs() < 1e-14);
            assert!((mean(20, &|mu| mu) - 2.0 / 3.0).abs() < 1e-10);
            let kink = 1.0 - 1.0 / (index * index);
            let beyond = |mu: f64| if mu * mu < kink { (kink - mu * mu).sqrt() } else { 0.0 };
            assert!((mean(20, &beyond) - 2.0 / 3.0 * kink.powf(1.5)).abs() < 1e-13);
        }
    }

    #[test]
    fn interpolation_passes_through_the_nodes_and_reproduces_polynomials() {
        let rule = AngleRule::new(6, 60.0, Coupling::Gap).unwrap();
        for polar_deg in [0.0, 7.0, 31.0, 60.0, rule.above[2].polar_deg] {
            let angle = rule.at(polar_deg).unwrap();
            let cubic = |deg: f64| 0.3 - deg.to_radians().cos().powi(3);
            let value: f64 = rule.above.iter().zip(&angle.shares).map(|(n, s)| s * cubic(n.polar_deg)).sum();
            assert!((value - cubic(polar_deg)).abs() < 1e-14);
        }
    }

    #[test]
    fn impossible_rules_are_refused() {
        assert!(angle_rule(0, 0.0).is_err() && angle_rule(65, 60.0).is_err());
        let message = angle_rule(1, 60.0).unwrap_err().to_string();
        assert!(message.contains("60") && message.contains("more points"), "{message}");
        assert!(angle_rule(2, 60.0).is_ok() && angle_rule(3, f64::NAN).is_err());
        assert!(internal_angle_rule(4, 4, 1.0).is_err() && internal_angle_rule(4, 0, 1.5).is_err());
        let rule = AngleRule::new(3, 60.0, Coupling::Gap).unwrap();
        assert!(rule.at(-1.0).is_err() && rule.at(89.0).is_err() && rule.at(f64::NAN).is_err());
    }
}
