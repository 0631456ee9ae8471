//! Moments of the grains' indicator functions against closed forms and brute force.

use super::*;
use crate::ink::Sphere;
use crate::wave::{BodyShape, Scheme};
use gauss_quad::GaussLegendre;
use num_complex::Complex64;
use std::f64::consts::PI;

const PERIOD: [f64; 2] = [0.8, 1.1];
const HEIGHT: f64 = 0.6;

fn scene(shape: BodyShape) -> Scene {
    Scene::layer(PERIOD, HEIGHT, vec![Body::new(shape, 0)])
}

fn ball(center_um: [f64; 3], radius_um: f64) -> Sphere {
    Sphere { center_um, radius_um }
}

fn coverage(shape: BodyShape, nx: usize, ny: usize, cells: usize, scheme: Scheme) -> Coverage {
    Coverage::new(&scene(shape), Resolution { nx, ny, cells, scheme }).expect("a grain has a coverage")
}

fn volume(c: &Coverage) -> f64 {
    let cells = c.fractions[0].iter().enumerate();
    cells.map(|(j, f)| f * c.grid.height_um(j)).sum::<f64>() * PERIOD[0] * PERIOD[1]
}

/// Coefficient (m, n) of the moments on one plane, by a plain sum over the points.
fn coefficient(c: &Coverage, plane: usize, m: i32, n: i32) -> Complex64 {
    let r = c.grid.resolution;
    let point = |(i, &v): (usize, &f64)| {
        let [x, y] = [(i % r.nx) as f64 / r.nx as f64, (i / r.nx) as f64 / r.ny as f64];
        v * Complex64::cis(-TAU * (f64::from(m) * x + f64::from(n) * y))
    };
    c.moments[0].row(plane).iter().enumerate().map(point).sum::<Complex64>() / c.grid.points() as f64
}

/// J₁ from its integral over one period: the trapezoidal rule converges geometrically.
fn bessel_j1(x: f64) -> f64 {
    let count = 64_u32;
    let term = |i: usize| {
        let t = TAU * (i as f64 + 0.5) / f64::from(count);
        (t - x * t.sin()).cos()
    };
    (0..count as usize).map(term).sum::<f64>() / f64::from(count)
}

/// ∫ ψ_p(z) e^{−ik·c} 2πρ J₁(kρ)/k dz / (Lx Ly) for one ball: its discs' transforms, P1 section 4.
fn ball_moment(c: &Coverage, ball: &Sphere, plane: usize, [m, n]: [i32; 2]) -> Complex64 {
    let (kx, ky) = (TAU * f64::from(m) / PERIOD[0], TAU * f64::from(n) / PERIOD[1]);
    let k = kx.hypot(ky);
    let disc = |z: f64| {
        let rho = (ball.radius_um.powi(2) - (z - ball.center_um[2]).powi(2)).max(0.0).sqrt();
        if k == 0.0 { PI * rho * rho } else { TAU * rho * bessel_j1(k * rho) / k }
    };
    let rule = GaussLegendre::new(40).expect("at least two nodes");
    let degree = c.grid.element.degree;
    let in_cell = |j: usize| {
        let lo = c.grid.nodes_um[j].max(ball.center_um[2] - ball.radius_um);
        let hi = c.grid.nodes_um[j + 1].min(ball.center_um[2] + ball.radius_um);
        let shape = |z: f64| c.grid.element.shape_functions((z - c.grid.nodes_um[j]) / c.grid.height_um(j));
        match plane.checked_sub(degree * j) {
            Some(q) if q <= degree && hi > lo => rule.integrate(lo, hi, |z| shape(z)[q] * disc(z)),
            _ => 0.0,
        }
    };
    let sum: f64 = (0..c.grid.cells()).map(in_cell).sum();
    Complex64::cis(-kx * ball.center_um[0] - ky * ball.center_um[1]) * sum / (PERIOD[0] * PERIOD[1])
}

#[test]
fn bessel_function_is_right() {
    // Abramowitz and Stegun, table 9.1.
    for (x, value) in [(0.0, 0.0), (1.0, 0.440_050_585_744_933_5), (5.0, -0.327_579_137_591_465_2)] {
        assert!((bessel_j1(x) - value).abs() < 1e-15);
    }
}

#[test]
fn a_balls_fractions_are_its_segments_volumes() {
    let b = ball([0.1, 0.5, 0.31], 0.22);
    let primitive = |z: f64| {
        let t = (z - b.center_um[2]).clamp(-b.radius_um, b.radius_um);
        PI * (b.radius_um.powi(2) * t - t.powi(3) / 3.0)
    };
    let c = coverage(BodyShape::Balls(vec![b]), 9, 8, 5, Scheme::Cubic);
    for j in 0..5 {
        let (lo, hi) = (c.grid.nodes_um[j], c.grid.nodes_um[j + 1]);
        let exact = (primitive(hi) - primitive(lo)) / (PERIOD[0] * PERIOD[1] * (hi - lo));
        // Identity: Gauss quadrature of a polynomial; areas come from edge points, rounding only.
        assert!((c.fractions[0][j] - exact).abs() < 1e-13, "cell {j}");
    }
    assert!((volume(&c) - 4.0 / 3.0 * PI * b.radius_um.powi(3)).abs() < 1e-13);
}

#[test]
fn a_balls_coefficients_are_bessel_functions() {
    let b = ball([0.1, 0.5, 0.31], 0.22);
    for (scheme, cells) in
        [(Scheme::Tents, 6), (Scheme::Quadratic, 3), (Scheme::Cubic, 2), (Scheme::Quartic, 1)]
    {
        let c = coverage(BodyShape::Balls(vec![b]), 9, 8, cells, scheme);
        for plane in 0..c.grid.planes() {
            for order in [[0, 0], [1, 0], [0, -1], [-4, 3], [3, 2], [4, -3]] {
                let error = coefficient(&c, plane, order[0], order[1]) - ball_moment(&c, &b, plane, order);
                // Type-1 transform: 1e-10 of the edge's length; z quadrature is stated to 1e-10.
                assert!(error.norm() < 2e-10, "{scheme:?}, plane {plane}, {order:?}: {:e}", error.norm());
            }
        }
    }
}

/// Volume of the union of two balls: both less their lens (two spherical caps).
fn union_volume(r: f64, s: f64, d: f64) -> f64 {
    let lens = PI * (r + s - d).powi(2) * (d * d + 2.0 * d * (r + s) - 3.0 * (r - s).powi(2)) / (12.0 * d);
    4.0 / 3.0 * PI * (r.powi(3) + s.powi(3)) - lens
}

#[test]
fn overlapping_balls_of_one_grain_count_once() {
    let a = ball([0.35, 0.5, 0.28], 0.2);
    let offset = [0.12, -0.07, 0.09];
    let b = ball(std::array::from_fn(|i| a.center_um[i] + offset[i]), 0.15);
    let distance = offset.iter().map(|x| x * x).sum::<f64>().sqrt();
    let c = coverage(BodyShape::Balls(vec![a, b]), 12, 15, 7, Scheme::Cubic);
    // Quadrature in z is stated to about 1e-10 of the cell.
    assert!((volume(&c) - union_volume(0.2, 0.15, distance)).abs() < 1e-9);
    // A ball inside the other, and the same ball twice, add nothing.
    for inside in [ball([0.36, 0.5, 0.29], 0.05), a] {
        let c = coverage(BodyShape::Balls(vec![a, inside]), 12, 15, 7, Scheme::Cubic);
        assert!((volume(&c) - 4.0 / 3.0 * PI * 0.2f64.powi(3)).abs() < 1e-9);
    }
}

#[test]
fn a_unions_coefficients_agree_with_a_fine_voxel_sum() {
    let balls =
        vec![ball([0.75, 0.5, 0.2], 0.17), ball([0.88, 0.58, 0.3], 0.15), ball([0.7, 0.6, 0.35], 0.1)];
    let c = coverage(BodyShape::Balls(balls.clone()), 8, 9, 1, Scheme::Tents);
    let n = 160;
    let orders = [[0, 0], [1, 0], [0, 1], [-2, 3], [3, -4]];
    let mut sums = [[Complex64::default(); 5]; 2];
    for i in 0..n * n * n {
        let [x, y, z] = [i % n, i / n % n, i / n / n].map(|i| (i as f64 + 0.5) / n as f64);
        let nearest = |d: f64, period: f64| d - period * (d / period).round();
        let inside = |b: &Sphere| {
            let d =
                [x * PERIOD[0] - b.center_um[0], y * PERIOD[1] - b.center_um[1], z * HEIGHT - b.center_um[2]];
            nearest(d[0], PERIOD[0]).powi(2) + nearest(d[1], PERIOD[1]).powi(2) + d[2] * d[2]
                < b.radius_um.powi(2)
        };
        if balls.iter().any(inside) {
            for (s, [m, k]) in orders.iter().enumerate() {
                let wave = Complex64::cis(-TAU * (f64::from(*m) * x + f64::from(*k) * y));
                sums[0][s] += wave * (1.0 - z);
                sums[1][s] += wave * z;
            }
        }
    }
    for (plane, sums) in sums.iter().enumerate() {
        for (sum, [m, k]) in sums.iter().zip(orders) {
            let brute = sum * HEIGHT / (n * n * n) as f64;
            // Significance: some 3·10⁴ surface voxels of half a voxel's uncertainty: 100 voxels of
            // 4·10⁶.
            let error = (coefficient(&c, plane, m, k) - brute).norm();
            assert!(error < 3e-5 * HEIGHT, "plane {plane}, ({m}, {k}): {error:e}");
        }
    }
}

#[test]
fn grains_wrap_periodically() {
    let cluster = |x: f64, y: f64| {
        let balls = vec![ball([x, y, 0.3], 0.2), ball([x + 0.1, y, 0.35], 0.15)];
        coverage(BodyShape::Balls(balls), 10, 11, 4, Scheme::Quadratic)
    };
    let reference = cluster(0.0, 0.0);
    for (x, y) in [(PERIOD[0], -PERIOD[1]), (-2.0 * PERIOD[0], 3.0 * PERIOD[1])] {
        let wrapped = cluster(x, y);
        let error = (&wrapped.moments[0] - &reference.moments[0]).fold(0.0, |e: f64, d| e.max(d.abs()));
        assert!(error < 1e-10, "{error:e}");
    }
    // Moving by one grid spacing moves the moments by one point.
    let moved = cluster(PERIOD[0] / 10.0, 0.0);
    for plane in 0..reference.grid.planes() {
        for i in 0..110 {
            let target = i / 10 * 10 + (i + 1) % 10;
            let error = moved.moments[0][[plane, target]] - reference.moments[0][[plane, i]];
            assert!(error.abs() < 1e-10, "plane {plane}, point {i}");
        }
    }
}

#[test]
fn cylinders_bars_and_sheets_have_their_areas() {
    let area = |shape: BodyShape| volume(&coverage(shape, 9, 1, 5, Scheme::Cubic)) / PERIOD[1];
    let cylinder = BodyShape::CylinderY { x_um: 0.7, z_um: 0.3, radius_um: 0.21 };
    // Quadrature in z is stated to about 1e-10; bars and sheets are exact.
    assert!((area(cylinder) - PI * 0.21f64.powi(2)).abs() < 1e-9);
    assert!((area(BodyShape::BarY { x_um: [0.6, 1.0], z_um: [0.13, 0.47] }) - 0.4 * 0.34).abs() < 1e-14);
    assert!((area(BodyShape::Sheet { z_um: [0.13, 0.47] }) - 0.8 * 0.34).abs() < 1e-14);
}

#[test]
fn folded_harmonics_have_the_mean_that_partitioning_predicts() {
    // A bar of full height: moments factor into ∫ψ and sinc, so Σ_q |M_q|²/q² over the outer set is
    // explicit.
    let x0 = 0.2;
    let x1 = 0.55;
    let nx = 8;
    let c = coverage(BodyShape::BarY { x_um: [x0, x1], z_um: [0.0, HEIGHT] }, nx, 1, 1, Scheme::Tents);
    let weight = HEIGHT / 2.0;
    let outer = (4..=7).flat_map(|m| [m, -m]).map(|m: i32| {
        let k = TAU * f64::from(m) / PERIOD[0];
        let coefficient = (0.5 * k * (x1 - x0)).sin() * 2.0 / (k * PERIOD[0]);
        (weight * coefficient / k).powi(2) / weight
    });
    let expected: f64 = outer.sum();
    for plane in 0..2 {
        let mean = c.folded[0].row(plane).sum() / nx as f64;
        assert!((mean - expected).abs() < 1e-14 && expected > 1e-6, "{mean} against {expected}");
    }
}

#[test]
fn grains_of_different_media_and_strata_make_channels() {
    let stratum = |background| crate::wave::Stratum { thickness_um: 0.3, background };
    let body = |z: f64, inclusion| Body::new(BodyShape::Balls(vec![ball([0.4, 0.4, z], 0.1)]), inclusion);
    let scene = Scene {
        cut: false,
        period_um: PERIOD,
        strata: vec![stratum(0), stratum(1)],
        bodies: vec![body(0.3, 1), body(0.12, 0)],
    };
    let c = Coverage::new(&scene, Resolution { nx: 8, ny: 8, cells: 4, scheme: Scheme::Cubic })
        .expect("coverage");
    let pairs: Vec<_> = c.channels.iter().map(|c| (c.background, c.material)).collect();
    assert_eq!(pairs, [(0, 1), (1, 1), (0, 0)].map(|(b, i)| (b, crate::wave::Material::Inclusion(i))));
    let half = 2.0 / 3.0 * PI * 1e-3 / (PERIOD[0] * PERIOD[1]);
    for channel in 0..2 {
        let share: f64 = c.fractions[channel].iter().map(|f| f * 0.15).sum();
        assert!((share - half).abs() < 1e-13, "half of the ball on either side of the interface");
    }
}

/// A core takes its moments from the shell around it, plane by plane and cell by cell; a core of
/// the shell's material changes nothing.
/// *Planted*: without the sign the shell is the whole ball.
#[test]
fn a_core_takes_its_volume_from_the_shell() {
    let resolution = Resolution { nx: 12, ny: 15, cells: 7, scheme: Scheme::Cubic };
    let layered = |bodies: &[(f64, usize)]| {
        let body = |(i, &(radius, material)): (usize, &(f64, usize))| {
            let shape = BodyShape::Balls(vec![ball([0.1, 0.5, 0.31], radius)]);
            Body { within: i.checked_sub(1), ..Body::new(shape, material) }
        };
        let bodies = bodies.iter().enumerate().map(body).collect();
        Coverage::new(&Scene::layer(PERIOD, HEIGHT, bodies), resolution).expect("a coverage")
    };
    let [whole, core] = [[(0.22, 0)], [(0.15, 0)]].map(|one| layered(&one));
    let coated = layered(&[(0.22, 0), (0.15, 1)]);
    assert_eq!(coated.channels.len(), 2);
    let differ = |a: &Array2<f64>, b: &Array2<f64>| (a - b).iter().fold(0.0, |m: f64, d| m.max(d.abs()));
    // identity: sums of the same numbers
    assert!(differ(&coated.moments[0], &(&whole.moments[0] - &core.moments[0])) < 1e-14);
    assert!(differ(&coated.moments[1], &core.moments[0]) < 1e-14);
    assert!((volume(&coated) - volume(&whole) + volume(&core)).abs() < 1e-14);
    assert!(differ(&layered(&[(0.22, 0), (0.15, 0)]).moments[0], &whole.moments[0]) < 1e-14);
}
