//! Bodies with the largest overlap.

use super::bodies::Bodies;
use super::neighbours::Neighbours;
use crate::numerics::vector::norm;

/// Overlap energy of each body.
pub(crate) fn strain(bodies: &Bodies) -> Vec<f64> {
    let list = Neighbours::new(bodies, 0.0, 0.0);
    let mut strain = vec![0.0; bodies.placed];
    for s in 0..bodies.spheres() {
        let (p, r) = (bodies.at[s], bodies.radius[s]);
        let mut push = |depth: f64| strain[bodies.owner[s] as usize] += depth.max(0.0).powi(2);
        if bodies.cell.walls {
            push(2.0 * (r - p[2].min(bodies.cell.size[2] - p[2])));
        }
        for t in list.of(s).iter().map(|t| *t as usize) {
            push(r + bodies.radius[t] - norm(bodies.cell.delta(p, bodies.at[t])));
        }
    }
    strain
}
