//! Pairs of grain centres: pair correlation g(r) and nearest neighbours.

use crate::ink::packing::cell::{Buckets, CellBox};
use crate::ink::{Grain, Packing};
use crate::numerics::vector::{V3, norm};
use std::f64::consts::PI;

/// Pair counts of one packing in shells of equal width, with those of an ideal gas.
#[derive(Clone, Debug, PartialEq)]
pub struct PairStatistics {
    /// Shell edges, µm.
    pub edges_um: Vec<f64>,
    /// Number of pairs of centres in each shell.
    pub counts: Vec<f64>,
    /// Expected counts for the same number of uniformly distributed points (between the walls, if
    /// any).
    pub ideal: Vec<f64>,
    /// Distance from each centre to its nearest neighbour, µm.
    pub nearest_um: Vec<f64>,
}

impl PairStatistics {
    /// Pair correlation g in each shell, averaged over the shell's volume.
    pub fn g(&self) -> Vec<f64> {
        self.counts.iter().zip(&self.ideal).map(|(c, i)| if *i > 0.0 { c / i } else { 0.0 }).collect()
    }

    /// Mean distance from a centre to its nearest neighbour, µm.
    pub fn mean_nearest_um(&self) -> f64 {
        self.nearest_um.iter().sum::<f64>() / self.nearest_um.len().max(1) as f64
    }
}

/// Mean diameter of the spheres of equal volume, µm: the length unit of the shells.
pub fn mean_diameter_um(packing: &Packing) -> f64 {
    let n = packing.grains().len().max(1) as f64;
    packing.grains().iter().map(|g| (6.0 * g.volume_um3 / PI).cbrt()).sum::<f64>() / n
}

/// Pair statistics in shells of `width` up to `furthest`, both in mean diameters, at most half the
/// period.
pub fn pair_statistics_to(packing: &Packing, width: f64, furthest: f64) -> PairStatistics {
    let d = mean_diameter_um(packing);
    pair_statistics(packing, width * d, furthest * d)
}

/// Pair statistics in shells given in µm, comparable between realisations of different grains.
pub fn pair_statistics(packing: &Packing, width_um: f64, furthest_um: f64) -> PairStatistics {
    let cell = CellBox::new(packing.period_um(), packing.thickness_um(), packing.walls());
    let half = (0..3).filter(|a| cell.periodic(*a)).map(|a| 0.5 * cell.size[a]).fold(f64::MAX, f64::min);
    // The small addition keeps rounding from losing the last shell of 3.0 / 0.02.
    let shells = (half.min(furthest_um) / width_um + 1e-9).floor() as usize;
    let edges_um: Vec<f64> = (0..=shells).map(|i| i as f64 * width_um).collect();
    let centres: Vec<V3> = packing.grains().iter().map(|g| cell.wrap(g.centre_um())).collect();
    let (counts, nearest_um) = count(&cell, &centres, &edges_um, width_um);
    let n = centres.len() as f64;
    let expected = ideal_share(packing, &edges_um);
    let ideal = expected.windows(2).map(|w| 0.5 * n * (n - 1.0) * (w[1] - w[0])).collect();
    PairStatistics { edges_um, counts, ideal, nearest_um }
}

fn count(cell: &CellBox, centres: &[V3], edges: &[f64], width: f64) -> (Vec<f64>, Vec<f64>) {
    let furthest = edges.last().copied().unwrap_or(0.0).max(width);
    let mut counts = vec![0.0; edges.len().saturating_sub(1)];
    let mut nearest = vec![f64::INFINITY; centres.len()];
    let mut grid = Buckets::new(cell, furthest, centres.len());
    for (i, p) in centres.iter().enumerate() {
        for j in grid.around(grid.cell_of(*p)) {
            let r = norm(cell.delta(*p, centres[j]));
            nearest[i] = nearest[i].min(r);
            nearest[j] = nearest[j].min(r);
            if let Some(slot) = counts.get_mut((r / width) as usize) {
                *slot += 1.0;
            }
        }
        grid.insert(i, *p);
    }
    for i in 0..centres.len() {
        if nearest[i] > furthest && centres.len() > 1 {
            let others = (0..centres.len()).filter(|j| *j != i);
            nearest[i] = others.map(|j| norm(cell.delta(centres[i], centres[j]))).fold(f64::MAX, f64::min);
        }
    }
    (counts, nearest)
}

/// Probability that two independent uniform points are closer than each edge.
///
/// Between walls w apart (for centres: H less twice the smallest thickest radius) their distance
/// across the layer has density 2(w − u)/w², and ∫₀^min(r,w) 2(w − u)/w² · π(r² − u²)/A du is a
/// polynomial.
fn ideal_share(packing: &Packing, edges: &[f64]) -> Vec<f64> {
    let area = packing.period_um()[0] * packing.period_um()[1];
    if !packing.walls() {
        let volume = area * packing.thickness_um();
        return edges.iter().map(|r| 4.0 / 3.0 * PI * r.powi(3) / volume).collect();
    }
    let widest = |g: &Grain| g.spheres.iter().map(|s| s.radius_um).fold(0.0, f64::max);
    let thickest = |g: &Grain| g.solid.as_ref().map_or_else(|| widest(g), |s| s.form.thin_um());
    let margin = packing.grains().iter().map(thickest).fold(f64::MAX, f64::min);
    let w = packing.thickness_um() - 2.0 * margin;
    if w <= 1e-9 * packing.thickness_um() {
        return edges.iter().map(|r| PI * r * r / area).collect();
    }
    let share = |r: &f64| {
        let m = r.min(w);
        let integral = w * (r * r * m - m.powi(3) / 3.0) - (0.5 * r * r * m * m - 0.25 * m.powi(4));
        2.0 * PI / (area * w * w) * integral
    };
    edges.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::Sphere;
    use crate::numerics::Draws;

    /// Uniform random points between walls have g = 1: a test of the normalisation.
    #[test]
    fn an_ideal_gas_between_walls_has_no_correlation() {
        let mut draws = Draws::new(2, 0);
        let (radius_um, n) = (1e-5, 4000);
        let mut point = |_| {
            let center_um = [draws.between(0.0, 2.0), draws.between(0.0, 2.0), draws.between(2e-5, 0.29998)];
            Grain::new(vec![Sphere { center_um, radius_um }], 0)
        };
        let packing = Packing::from_grains([2.0, 2.0], 0.3, true, (0..n).map(&mut point).collect()).unwrap();
        let pairs = pair_statistics_to(&packing, 2500.0, 45_000.0);
        assert_eq!(pairs.counts.len(), 18);
        for (counted, ideal) in pairs.counts.iter().zip(&pairs.ideal) {
            // Significance: 18 shells, four standard deviations of a count that is Poisson.
            assert!((counted - ideal).abs() < 4.0 * ideal.sqrt(), "{counted} {ideal}");
        }
    }
}
