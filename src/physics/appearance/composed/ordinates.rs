//! Discrete directions of a half-space: Gaussian nodes in each zone between critical angles.
//!
//! A direction is named by its lateral wavenumber s = n sin θ (in units of k₀), which refraction
//! does not change. Zones end at the indices of the media around the layer, where total reflection
//! begins. With v = √(s₁² − s²) in a zone s₀ < s < s₁, its étendue is ∫ 2v dv, and light of any
//! direction is shared among the zone's nodes by Lagrange polynomials in v, which keeps its flux.
//! In air, v = cos θ.

use crate::numerics::interpolate::lagrange;
use crate::wave::grid::element::legendre;
use faer::Mat;
use gauss_quad::GaussLegendre;

/// Zones narrower than this in s are part of their neighbour.
pub(super) const NARROWEST: f64 = 1e-3;
/// Steps of the search for the roots of a polynomial of small degree.
const BISECTIONS: usize = 60;
/// Intervals in which sign changes are sought, for each node.
const BRACKETS: usize = 200;

/// One zone: its nodes in v and the place of the first among all nodes.
#[derive(Clone, Debug, PartialEq)]
struct Zone {
    from: f64,
    to: f64,
    nodes: Vec<f64>,
    first: usize,
}

/// Directions of a half-space between two critical angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DirectionZone {
    /// Lateral wavenumber at which it begins.
    pub from: f64,
    /// Lateral wavenumber at which it ends.
    pub to: f64,
    /// Place of its first node among all.
    pub first: usize,
    /// Number of its nodes.
    pub count: usize,
}

impl DirectionZone {
    /// v = √(s₁² − s²) of a lateral wavenumber s in the zone, which ends at s₁.
    pub(super) fn place(&self, sine: f64) -> f64 {
        (self.to * self.to - sine * sine).max(0.0).sqrt()
    }
}

/// Directions of a half-space with their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Ordinates {
    /// Real index of the medium.
    pub index: f64,
    /// Lateral wavenumbers s = n sin θ of the nodes, zone by zone.
    pub sines: Vec<f64>,
    /// Étendue of every node; the sum is the square of the index.
    pub weights: Vec<f64>,
    zones: Vec<Zone>,
}

impl Ordinates {
    /// Nodes in a medium of real index: `counts[0]` in the zone from which light reaches air,
    /// `counts[1]` in each zone beyond. Zones end at 1 and at the `borders`, other media's indices.
    pub fn new(index: f64, borders: &[f64], counts: [usize; 2]) -> Self {
        Self::by(gauss, index, borders, counts)
    }

    /// As [`Ordinates::new`], with nodes that suit radiative transfer, where sums over dv occur
    /// beside those over 2v dv: the zeros of Legendre polynomials.
    pub fn for_transfer(index: f64, counts: [usize; 2]) -> Self {
        Self::by(gauss_legendre, index, &[], counts)
    }

    /// Any nodes, for tests against other programs' discretisations.
    #[cfg(test)]
    pub fn listed(index: f64, cosines: &[f64], weights: Vec<f64>) -> Self {
        let sines = cosines.iter().map(|mu| index * (1.0 - mu * mu).sqrt()).collect();
        Self { index, sines, weights, zones: Vec::new() }
    }

    fn by(rule: Rule, index: f64, borders: &[f64], counts: [usize; 2]) -> Self {
        let inside = |s: &f64| *s > NARROWEST && *s < index - NARROWEST;
        let mut ends: Vec<f64> = [1.0].iter().chain(borders).copied().filter(inside).collect();
        ends.push(index);
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|b, a| *b - *a < NARROWEST);
        let mut all = Self { index, sines: Vec::new(), weights: Vec::new(), zones: Vec::new() };
        let mut from = 0.0;
        for to in ends {
            all.add_zone(from, to, rule(counts[usize::from(from > 0.0)]));
            from = to;
        }
        all
    }

    fn add_zone(&mut self, from: f64, to: f64, rule: Vec<(f64, f64)>) {
        let width = (to * to - from * from).sqrt();
        let first = self.sines.len();
        let mut nodes = Vec::new();
        // from the normal outwards
        for (v, weight) in rule.into_iter().rev() {
            nodes.push(width * v);
            self.sines.push((to * to - (width * v).powi(2)).sqrt());
            self.weights.push(weight * width * width);
        }
        self.zones.push(Zone { from, to, nodes, first });
    }

    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.sines.len()
    }

    /// Angle of a node from the normal, degrees.
    pub fn polar_deg(&self, node: usize) -> f64 {
        (self.sines[node] / self.index).asin().to_degrees()
    }

    /// Cosine of a node's angle.
    pub fn cosine(&self, node: usize) -> f64 {
        (1.0 - (self.sines[node] / self.index).powi(2)).sqrt()
    }

    /// Shares of the nodes in light of lateral wavenumber s, (node, share); they add up to 1 and
    /// may be negative.
    pub fn shares(&self, sine: f64) -> Vec<(usize, f64)> {
        let last = self.zones.len() - 1;
        let zone = &self.zones[self.zones.iter().position(|zone| sine < zone.to).unwrap_or(last)];
        let v = (zone.to * zone.to - sine * sine).max(0.0).sqrt();
        (zone.first..).zip(lagrange(&zone.nodes, v)).collect()
    }

    /// Fluxes of the nodes without the highest moment that they resolve: of each zone's light the
    /// part that varies as the polynomial of degree n − 1 in v orthogonal, with the étendues as
    /// weights, to those of lower degree. A zone of one node keeps its light.
    pub(super) fn without_highest_moment(&self) -> Mat<f64> {
        let mut filter = Mat::identity(self.count(), self.count());
        for Zone { nodes, first, .. } in self.zones.iter().filter(|zone| zone.nodes.len() > 1) {
            let weights = &self.weights[*first..first + nodes.len()];
            let polynomial: Vec<f64> = nodes
                .iter()
                .zip(weights)
                .map(|(v, weight)| {
                    let others = nodes.iter().filter(|other| *other != v);
                    1.0 / (weight * others.map(|other| v - other).product::<f64>())
                })
                .collect();
            let norm: f64 = polynomial.iter().zip(weights).map(|(p, weight)| weight * p * p).sum();
            for (i, weight) in weights.iter().enumerate() {
                for j in 0..nodes.len() {
                    filter[(first + i, first + j)] -= weight * polynomial[i] * polynomial[j] / norm;
                }
            }
        }
        filter
    }

    /// Lateral wavenumber at which the first zone ends.
    pub fn edge(&self) -> f64 {
        self.zones.first().map_or(self.index, |zone| zone.to)
    }

    /// The zones beyond the first, from which no light reaches air.
    pub(super) fn beyond_edge(&self) -> Vec<DirectionZone> {
        let beyond = self.zones.iter().filter(|zone| zone.from > 0.0);
        let zone = |&Zone { from, to, ref nodes, first }: &Zone| DirectionZone {
            from,
            to,
            first,
            count: nodes.len(),
        };
        beyond.map(zone).collect()
    }

    /// Nodes from which light reaches air: the first zone.
    pub fn escaping(&self) -> usize {
        self.zones.iter().filter(|zone| zone.from == 0.0).map(|zone| zone.nodes.len()).sum()
    }
}

/// Nodes and weights on 0 < v < 1 for a number of nodes.
type Rule = fn(usize) -> Vec<(f64, f64)>;

/// Zeros of Legendre polynomials on 0 < v < 1 with weights 2v dv, rising.
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let rule = GaussLegendre::new(count.max(2)).expect("two nodes or more");
    let mut pairs: Vec<_> = rule.iter().map(|&(x, w)| (0.5 * (1.0 + x), 0.5 * (1.0 + x) * w)).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs
}

/// Gaussian nodes and weights of ∫₀¹ 2v f(v) dv, rising: inner nodes of the Radau rule, the roots
/// of P_n + P_{n+1}, whose weights carry the factor v.
///
/// An own rule: `gauss_quad::GaussJacobi` (0.2.3) puts the middle one of an odd number of nodes at
/// x = 0, which is true of symmetric weights only (three nodes are −0.575, 0.181 and 0.823).
pub fn gauss(count: usize) -> Vec<(f64, f64)> {
    let f = |x: f64| legendre(count, x) + legendre(count + 1, x);
    let steps = BRACKETS * count.max(1);
    // evenly in the angle, as roots are
    let bound = |k: usize| -(std::f64::consts::PI * k as f64 / steps as f64).cos();
    let brackets = (1..steps).map(|k| [bound(k), bound(k + 1)]).filter(|&[a, b]| f(a) * f(b) <= 0.0);
    let size = (count + 1) as f64;
    let rule = brackets.map(|range| {
        let x = root(f, range);
        (0.5 * (1.0 + x), (1.0 - x) * (1.0 + x) / (2.0 * (size * legendre(count, x)).powi(2)))
    });
    rule.take(count).collect()
}

fn root(f: impl Fn(f64) -> f64, [mut a, mut b]: [f64; 2]) -> f64 {
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (a + b);
        *(if f(a) * f(middle) <= 0.0 { &mut b } else { &mut a }) = middle;
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Identity: n nodes integrate polynomials up to degree 2n − 1.
    #[test]
    fn the_rule_is_exact_to_its_degree() {
        for count in 1..9 {
            let rule = gauss(count);
            assert_eq!(rule.len(), count);
            for degree in 0..2 * count {
                let sum: f64 = rule.iter().map(|(v, w)| w * v.powi(degree as i32)).sum();
                assert!((sum - 2.0 / (degree as f64 + 2.0)).abs() < 1e-13, "{count} {degree} {sum}");
            }
        }
    }

    #[test]
    fn zones_end_at_critical_angles_and_shares_keep_the_flux() {
        let inner = Ordinates::new(1.7, &[1.5], [3, 2]);
        assert_eq!((inner.count(), inner.escaping()), (7, 3));
        assert!((inner.weights.iter().sum::<f64>() - 1.7 * 1.7).abs() < 1e-12);
        assert!(inner.sines.windows(2).all(|s| s[0] < s[1]));
        for (sine, nodes) in [(0.0, 0..3), (0.99, 0..3), (1.2, 3..5), (1.69, 5..7)] {
            let shares = inner.shares(sine);
            assert!((shares.iter().map(|s| s.1).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(shares.iter().all(|s| nodes.contains(&s.0)), "{sine}");
        }
        // flat and linear light stays, its flux in any case
        let filter = inner.without_highest_moment();
        let kept = |light: &dyn Fn(f64) -> f64, node: usize| -> f64 {
            let flux = |j: usize| inner.weights[j] * light(inner.sines[j]);
            (0..7).map(|j| filter[(node, j)] * flux(j)).sum::<f64>()
        };
        let v = |s: f64| (1.0 - s * s).max(0.0).sqrt();
        for node in 0..3 {
            let [own, weight] = [v(inner.sines[node]), inner.weights[node]];
            assert!((kept(&|s| 1.0 + v(s), node) / weight - 1.0 - own).abs() < 1e-12);
        }
        let squares: f64 = (0..3).map(|node| kept(&|s| v(s).powi(2), node)).sum();
        assert!((squares - 0.5).abs() < 1e-12 && (kept(&|s| v(s).powi(2), 0) - 0.5).abs() > 0.01);
        // a medium that is nearly air has no zone of its own beyond it
        assert_eq!(Ordinates::new(1.0005, &[1.0], [3, 3]).count(), 3);
    }
}
