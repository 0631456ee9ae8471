//! Moments of convex bodies against closed forms, other descriptions of the same body, and brute
//! force.

use crate::ink::Sphere;
use crate::ink::grains::contact::contains;
use crate::ink::{Form, Solid};
use crate::numerics::{Draws, vector::Rotation};
use crate::wave::maxwell::NormalMoments;
use crate::wave::{Body, BodyShape, Coverage, Resolution, Scene, Scheme};
use num_complex::Complex64;
use std::f64::consts::TAU;

const PERIOD: [f64; 2] = [0.8, 1.1];
const HEIGHT: f64 = 0.6;

fn scene(shape: BodyShape) -> Scene {
    Scene::layer(PERIOD, HEIGHT, vec![Body::new(shape, 0)])
}

fn coverage(shape: BodyShape, n: usize, cells: usize, scheme: Scheme) -> Coverage {
    Coverage::new(&scene(shape), Resolution { nx: n, ny: n, cells, scheme }).expect("a coverage")
}

fn forms() -> Vec<Form> {
    let corners_um = vec![[-0.12, -0.1], [0.18, -0.1], [-0.06, 0.2]];
    vec![
        Form::Ellipsoid { semi_axes_um: [0.25, 0.15, 0.1] },
        Form::Disc { radius_um: 0.2, half_length_um: 0.06 },
        Form::Disc { radius_um: 0.06, half_length_um: 0.2 },
        Form::cuboid([0.3, 0.2, 0.15]),
        Form::Prism { corners_um, half_length_um: 0.12 },
    ]
}

fn rotations() -> [Rotation; 4] {
    let quarter = Rotation::by([0.0, std::f64::consts::FRAC_PI_2, 0.0]);
    [Rotation::IDENTITY, quarter, Rotation::by([0.3, 0.5, 0.2]), Rotation::by([1e-5, 1.2, -0.7])]
}

/// Bodies that cross the period's boundary, upright, lying and tilted.
fn solids() -> impl Iterator<Item = Solid> {
    let placed = |form: Form| {
        rotations().map(|rotation| Solid { form: form.clone(), center_um: [0.75, 0.5, 0.28], rotation })
    };
    forms().into_iter().flat_map(placed)
}

#[test]
fn volumes_are_exact_in_every_orientation() {
    for solid in solids() {
        let volume = solid.form.volume_um3();
        let shape = BodyShape::Solid(solid.clone());
        let c = coverage(shape.clone(), 9, 4, Scheme::Cubic);
        let moments = NormalMoments::new(
            &scene(shape),
            Resolution { nx: 9, ny: 9, cells: 4, scheme: Scheme::Quadratic },
        )
        .expect("moments");
        for fractions in [&c.fractions[0], &moments.fractions[0]] {
            let found = fractions.iter().map(|f| f * 0.15).sum::<f64>() * PERIOD[0] * PERIOD[1];
            // Quadrature in z is stated to 1e-10 of the cell.
            assert!((found - volume).abs() < 1e-9 * HEIGHT, "{solid:?}: {found} {volume}");
        }
    }
}

#[test]
fn an_ellipsoid_of_equal_axes_is_a_ball() {
    let center_um = [0.1, 0.5, 0.31];
    let radius_um = 0.22;
    let form = Form::Ellipsoid { semi_axes_um: [radius_um; 3] };
    let rotation = Rotation::by([0.3, -0.4, 1.0]);
    let shapes = [
        BodyShape::Balls(vec![Sphere { center_um, radius_um }]),
        BodyShape::Solid(Solid { form, center_um, rotation }),
    ];
    let [ball, solid] = shapes.clone().map(|shape| coverage(shape, 9, 3, Scheme::Cubic));
    for (a, b) in [(&ball.moments[0], &solid.moments[0]), (&ball.folded[0], &solid.folded[0])] {
        let off = (a - b).fold(0.0, |e: f64, d| e.max(d.abs()));
        assert!(off < 1e-9, "{off:e}");
    }
    let resolution = Resolution { nx: 9, ny: 9, cells: 3, scheme: Scheme::Quadratic };
    let [ball, solid] = shapes.map(|shape| NormalMoments::new(&scene(shape), resolution).expect("moments"));
    for (a, b) in ball.planes.iter().flatten().zip(solid.planes.iter().flatten()) {
        for (a, b) in a.fields.iter().flatten().zip(b.fields.iter().flatten()) {
            assert!((a - b).abs() < 1e-8, "{a} {b}");
        }
    }
}

#[test]
fn a_box_that_fills_the_cell_is_a_film() {
    let solid = Solid::upright(Form::cuboid([PERIOD[0], PERIOD[1], 0.34]), [0.3, 0.2, 0.3]);
    let [filled, film] = [BodyShape::Solid(solid), BodyShape::Sheet { z_um: [0.13, 0.47] }]
        .map(|shape| coverage(shape, 8, 5, Scheme::Cubic));
    let off = filled.moments[0].indexed_iter().map(|((plane, _), m)| m - film.moments[0][[plane, 0]]);
    let worst = off.fold(0.0, |e: f64, d| e.max(d.abs()));
    assert!(worst < 1e-9, "{worst:e}");
}

/// Coefficients of the scalar and the vector wave against a plain sum over voxels.
#[test]
fn coefficients_agree_with_a_fine_voxel_sum() {
    let orders = [[0, 0], [1, 0], [0, 1], [-2, 3], [3, -2]];
    let n = 96;
    for solid in solids() {
        let shape = BodyShape::Solid(solid.clone());
        let c = coverage(shape.clone(), 8, 1, Scheme::Tents);
        let resolution = Resolution { nx: 8, ny: 8, cells: 1, scheme: Scheme::Quadratic };
        let vector = NormalMoments::new(&scene(shape), resolution).expect("moments");
        let sums = voxel_sums(&solid, n, &orders);
        for (s, [m, k]) in orders.into_iter().enumerate() {
            let tents = [0, 1].map(|plane| coefficient(c.moments[0].row(plane).to_vec(), m, k) / HEIGHT);
            let chi = |plane: usize| vector.planes[plane][0].fields.iter().map(|f| f[0]).collect();
            let gauss = [0, 1].map(|plane| coefficient(chi(plane), m, k));
            // Significance: some 10⁴ surface voxels of 9·10⁵, each uncertain by a half: 6e-5.
            for (found, brute) in [(tents[0] + tents[1], sums[s]), (0.5 * (gauss[0] + gauss[1]), sums[s])] {
                assert!((found - brute).norm() < 3e-4, "{solid:?} ({m}, {k}): {found} {brute}");
            }
        }
    }
}

fn voxel_sums(solid: &Solid, n: usize, orders: &[[i32; 2]]) -> Vec<Complex64> {
    let mut sums = vec![Complex64::default(); orders.len()];
    let mut draws = Draws::new(3, 0);
    for i in 0..n * n * n {
        // A random point of each voxel: faces along the axes then cause no bias.
        let [x, y, z] = [i % n, i / n % n, i / n / n].map(|i| (i as f64 + draws.uniform()) / n as f64);
        // The body lies within half a period of its centre, which is near the upper end of x.
        let point = [if x < 0.4 { x + 1.0 } else { x } * PERIOD[0], y * PERIOD[1], z * HEIGHT];
        if contains(solid, point) {
            let wave = |o: &[i32; 2]| Complex64::cis(-TAU * (f64::from(o[0]) * x + f64::from(o[1]) * y));
            sums.iter_mut().zip(orders).for_each(|(sum, o)| *sum += wave(o) / (n * n * n) as f64);
        }
    }
    sums
}

/// Coefficient (m, n) of values on 8 × 8 points.
fn coefficient(values: Vec<f64>, m: i32, n: i32) -> Complex64 {
    let point = |(i, v): (usize, &f64)| {
        let phase = f64::from(m) * (i % 8) as f64 + f64::from(n) * (i / 8) as f64;
        v * Complex64::cis(-TAU * phase / 8.0) / 64.0
    };
    values.iter().enumerate().map(point).sum()
}
