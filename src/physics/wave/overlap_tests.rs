use super::*;
use crate::ink::Sphere;

fn scene(shapes: &[BodyShape]) -> Scene {
    let body = |shape: &BodyShape| Body::new(shape.clone(), 0);
    Scene::layer([1.0, 1.5], 2.0, shapes.iter().map(body).collect())
}

fn ball(x: f64, y: f64, z: f64, radius_um: f64) -> BodyShape {
    BodyShape::Balls(vec![Sphere { center_um: [x, y, z], radius_um }])
}

fn disc(x_um: f64, z_um: f64, radius_um: f64) -> BodyShape {
    BodyShape::CylinderY { x_um, z_um, radius_um }
}

fn bar(x_um: [f64; 2], z_um: [f64; 2]) -> BodyShape {
    BodyShape::BarY { x_um, z_um }
}

impl Scene {
    /// Rejects bodies that overlap each other, except those given as around each other.
    fn check_overlaps(&self) -> Result<(), WaveError> {
        let hosts = self.hosts()?;
        let stray = |&body: &usize| hosts[body].is_some() && self.bodies[body].within != hosts[body];
        let Some(second) = (0..hosts.len()).find(stray) else { return Ok(()) };
        let [lo, hi] = self.bodies[second].extent_um();
        Err(WaveError::Overlap { first: hosts[second].unwrap_or_default(), second, overlap_um: hi - lo })
    }
}

#[test]
fn bodies_of_unlike_kinds_are_seen_through_the_boundary() {
    for (one, other, depth) in [
        (ball(0.95, 0.1, 0.5, 0.1), ball(0.06, 1.45, 0.5, 0.1), 0.2 - 0.11f64.hypot(0.15)),
        (ball(0.95, 0.1, 0.5, 0.1), disc(0.05, 0.5, 0.1), 0.1),
        (disc(0.5, 0.5, 0.2), bar([0.65, 0.9], [0.4, 0.6]), 0.05),
        (disc(0.5, 0.5, 0.1), bar([0.2, 0.8], [0.3, 0.7]), 0.3),
        (ball(0.02, 0.7, 0.5, 0.1), bar([0.8, 0.95], [0.2, 0.8]), 0.03),
        (ball(0.02, 0.7, 0.5, 0.1), BodyShape::Sheet { z_um: [0.55, 0.7] }, 0.05),
    ] {
        let both = scene(&[one.clone(), other.clone()]);
        match both.check_overlaps() {
            Err(WaveError::Overlap { overlap_um, .. }) => {
                assert!((overlap_um - depth).abs() < 1e-12, "{one:?} {other:?}: {overlap_um}");
            }
            found => panic!("{one:?} {other:?}: {found:?}"),
        }
    }
}

#[test]
fn touching_and_near_bodies_pass() {
    for (one, other) in [
        (ball(0.25, 0.5, 0.5, 0.25), ball(0.75, 0.5, 0.5, 0.25)),
        (ball(0.25, 0.5, 0.5, 0.25), disc(0.75, 0.5, 0.25)),
        (disc(0.25, 0.5, 0.25), bar([0.5, 1.0], [0.0, 1.0])),
        // The corner is nearer along each axis than it is.
        (disc(0.2, 0.2, 0.14), bar([0.3, 0.6], [0.3, 0.6])),
    ] {
        scene(&[one.clone(), other.clone()])
            .check_overlaps()
            .unwrap_or_else(|e| panic!("{one:?} {other:?}: {e}"));
    }
}

/// The plainest loop over all pairs and images finds an overlap exactly where the cells do.
#[test]
fn cells_miss_nothing_that_all_pairs_find() {
    let mut number = 7u64;
    let mut random = || {
        number = number.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (number >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut hits = 0;
    for _ in 0..400 {
        let balls: Vec<[f64; 4]> = (0..12)
            .map(|_| [4.0 * random() - 2.0, random(), 0.3 + 1.4 * random(), 0.02 + 0.13 * random()])
            .collect();
        let overlaps = |a: &[f64; 4], b: &[f64; 4]| {
            (-5..=5).any(|i| {
                (-2..=2).any(|j| {
                    let (dx, dy) = (a[0] - b[0] + f64::from(i), a[1] - b[1] + 1.5 * f64::from(j));
                    let apart = dx.hypot(dy).hypot(a[2] - b[2]);
                    apart < a[3] + b[3] && apart > (a[3] - b[3]).abs()
                })
            })
        };
        let expected = (0..12).any(|i| (0..i).any(|j| overlaps(&balls[i], &balls[j])));
        let shapes: Vec<BodyShape> = balls.iter().map(|b| ball(b[0], b[1], b[2], b[3])).collect();
        assert_eq!(scene(&shapes).nested().is_err(), expected, "{balls:?}");
        hits += usize::from(expected);
    }
    assert!((40..360).contains(&hits), "both answers occur: {hits} of 400");
}

/// Spheres inside each other, one of them across the boundary, each know the smallest around
/// them; unless they are nested, they overlap.
#[test]
fn spheres_inside_others_are_nested() {
    let shapes = [
        ball(0.03, 0.75, 1.0, 0.1),
        ball(0.98, 0.75, 1.0, 0.3),
        ball(0.9, 0.75, 1.15, 0.02),
        ball(0.05, 2.25, 1.0, 0.05),
        ball(0.5, 0.75, 1.0, 0.15),
    ];
    let nested = scene(&shapes).nested().unwrap();
    let within: Vec<_> = nested.bodies.iter().map(|b| b.within).collect();
    assert_eq!(within, [Some(1), None, Some(1), Some(0), None]);
    assert!(nested.check_overlaps().is_ok());
    assert!(matches!(scene(&shapes).check_overlaps(), Err(WaveError::Overlap { .. })));
    // The same sphere twice, and one that reaches out of the other.
    for inner in [ball(0.5, 0.75, 1.0, 0.3), ball(0.7, 0.75, 1.0, 0.2)] {
        assert!(scene(&[ball(0.5, 0.75, 1.0, 0.3), inner]).nested().is_err());
    }
}

#[test]
fn a_hundred_thousand_spheres_take_no_time() {
    let share = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
    let (n, m, k) = (50, 50, 40);
    let shapes: Vec<BodyShape> = (0..n * m * k)
        .map(|i| ball(share(i % n, n), 1.5 * share(i / n % m, m), 2.0 * share(i / n / m, k), 0.0099))
        .collect();
    let clock = std::time::Instant::now();
    scene(&shapes).check_overlaps().unwrap();
    // All pairs took half a minute; this takes a tenth of a second.
    assert!(clock.elapsed().as_secs_f64() < 5.0);
}
