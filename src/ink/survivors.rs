//! What remains of a packing that was not reached: the bodies left when those that overlap most are taken out.

use super::bodies::Bodies;
use super::neighbours::Neighbours;
use super::sequential::MARGIN;
use super::vector::norm;
use std::collections::BTreeSet;

/// Greedy: the body with most overlaps goes first, until none overlaps another one or a wall.
pub(crate) fn without_overlap(bodies: &Bodies, list: &Neighbours) -> Vec<usize> {
    let mut against: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); bodies.placed];
    let mut gone = vec![false; bodies.placed];
    for s in 0..bodies.spheres() {
        let (b, p, r) = (bodies.owner[s] as usize, bodies.at[s], bodies.radius[s]);
        let to_wall = p[2].min(bodies.cell.size[2] - p[2]);
        gone[b] |= bodies.cell.walls && to_wall < r;
        for t in list.of(s).iter().map(|t| *t as usize) {
            let sum = r + bodies.radius[t];
            if norm(bodies.cell.delta(p, bodies.at[t])) < sum * (1.0 + MARGIN) {
                against[b].insert(bodies.owner[t] as usize);
            }
        }
    }
    (0..bodies.placed)
        .filter(|b| gone[*b])
        .collect::<Vec<_>>()
        .iter()
        .for_each(|b| take_out(*b, &mut against));
    // Keyed by the number of overlaps, so that the worst body is always last; ties by number.
    let mut queue: BTreeSet<(usize, usize)> = against.iter().enumerate().map(|(b, a)| (a.len(), b)).collect();
    while let Some((count, b)) = queue.pop_last() {
        if count == 0 {
            break;
        }
        gone[b] = true;
        for other in against[b].clone() {
            queue.remove(&(against[other].len(), other));
            against[other].remove(&b);
            queue.insert((against[other].len(), other));
        }
        against[b].clear();
    }
    (0..bodies.placed).filter(|b| !gone[*b]).collect()
}

fn take_out(b: usize, against: &mut [BTreeSet<usize>]) {
    for other in std::mem::take(&mut against[b]) {
        against[other].remove(&b);
    }
}
