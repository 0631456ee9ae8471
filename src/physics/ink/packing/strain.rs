//! Bodies with the largest overlap.

use super::bodies::Bodies;
use super::neighbours::Neighbours;

/// Overlap energy of each body.
pub(crate) fn strain(bodies: &Bodies) -> Vec<f64> {
    let list = Neighbours::new(bodies, 0.0, 0.0);
    let mut strain = vec![0.0; bodies.placed];
    for s in 0..bodies.spheres() {
        let p = bodies.at[s];
        let mut push = |depth: f64| strain[bodies.owner[s] as usize] += depth.max(0.0).powi(2);
        if bodies.cell.walls {
            let [low, high] = bodies.extent_z(s);
            push(-2.0 * (p[2] + low).min(bodies.cell.size[2] - p[2] - high));
        }
        for t in list.of(s).iter().map(|t| *t as usize) {
            let contact = bodies.contact(s, t, bodies.cell.delta(p, bodies.at[t]), 0.0);
            push(contact.map_or(0.0, |c| -c.gap_um));
        }
    }
    strain
}
