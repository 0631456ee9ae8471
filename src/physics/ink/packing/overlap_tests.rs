use super::*;
use crate::ink::Form;
use crate::numerics::Draws;
use crate::numerics::vector::Rotation;

/// All pairs in all their images near the cell: gaps of spheres in closed form.
fn all_pairs(size: [f64; 3], walls: bool, grains: &[Grain]) -> f64 {
    let images = if walls { 0..=0 } else { -1..=1 };
    let mut least = f64::INFINITY;
    for (i, a) in grains.iter().enumerate() {
        for (b, [x, y]) in
            grains[..i].iter().flat_map(|b| (-1..=1).flat_map(move |x| (-1..=1).map(move |y| (b, [x, y]))))
        {
            for z in images.clone() {
                let shift = [f64::from(x), f64::from(y), f64::from(z)];
                for (s, t) in a.spheres.iter().flat_map(|s| b.spheres.iter().map(move |t| (s, t))) {
                    let apart = [0, 1, 2].map(|k| s.center_um[k] - t.center_um[k] + shift[k] * size[k]);
                    least = least.min(norm(apart) - s.radius_um - t.radius_um);
                }
            }
        }
        for s in a.spheres.iter().filter(|_| walls) {
            least = least.min((s.center_um[2] - s.radius_um).min(size[2] - s.center_um[2] - s.radius_um));
        }
    }
    least
}

/// The smallest gap, or the deepest overlap, against all pairs, in cells of every shape with
/// sizes over three decades. *Planted*: cells of a class searched one too few, or without the
/// images across the period.
#[test]
fn the_smallest_gap_is_that_of_all_pairs() {
    let mut draws = Draws::new(5, 0);
    for trial in 0..200 {
        let size = [draws.between(0.5, 3.0), draws.between(0.5, 3.0), [0.4, 1.0, 3.0][trial % 3]];
        let walls = trial % 2 == 0;
        let spread = [0.0, 2.0, 6.0][trial / 2 % 3];
        let count = 2 + draws.below(60);
        let mut grain = |_| {
            let radius_um = 0.1 * draws.between(-spread, 0.0).exp();
            let margin = if walls { 0.1 } else { 0.0 };
            let z = draws.between(margin, size[2] - margin);
            let center_um = [draws.between(-size[0], 2.0 * size[0]), draws.between(0.0, size[1]), z];
            // the images near the cell are all that the other way counts
            let center_um = [center_um[0].rem_euclid(size[0]), center_um[1], center_um[2]];
            Grain::new(vec![Sphere { center_um, radius_um }], 0)
        };
        let grains: Vec<Grain> = (0..count).map(&mut grain).collect();
        let expected = all_pairs(size, walls, &grains);
        let largest = grains.iter().map(|g| g.spheres[0].radius_um).fold(0.0, f64::max);
        let found = match smallest_gap(size, walls, &grains) {
            Ok(gap) => gap.unwrap_or(f64::INFINITY),
            Err(PackError::Overlap { overlap_um, .. }) => -overlap_um,
            Err(other) => panic!("{other}"),
        };
        let expected = if expected > largest { f64::INFINITY } else { expected };
        // identity: the same distances, rounded
        assert!(found == expected || (found - expected).abs() < 1e-12, "{trial}: {found} {expected}");
        if walls {
            let mut deepest = 0.0;
            let mut overlaps = 0;
            let visited = each_overlap(size, &grains, |overlap| {
                (deepest, overlaps) = (overlap.depth_um.max(deepest), overlaps + 1);
                ControlFlow::Continue(())
            });
            visited.expect("sound numbers");
            assert!((deepest - (-expected).max(0.0)).abs() < 1e-12, "{trial}: {deepest} {expected}");
            assert_eq!(overlaps > 0, expected < -1e-13, "{trial}");
        }
    }
}

/// Long bodies, whose nearest surfaces are not where their centres are nearest.
#[test]
fn bodies_are_found_across_the_period() {
    let rod = |x: f64, y: f64| {
        let form = Form::cuboid([0.9, 0.02, 0.02]);
        let turned = Solid { center_um: [x, y, 0.5], form, rotation: Rotation::IDENTITY };
        Grain::convex(turned, 0)
    };
    let gap = smallest_gap([1.0, 1.0, 1.0], true, &[rod(0.05, 0.5), rod(0.95, 0.53)]);
    assert!((gap.expect("apart").expect("close") - 0.01).abs() < 1e-9);
}
