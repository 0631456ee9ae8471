//! Hypotheses of the theory as full matrices on a tiny grid, and refusals.

use super::*;
use crate::ink::Sphere;
use crate::wave::{Body, BodyShape, Resolution, Scheme, Side, System};

const SCHEMES: [Scheme; 5] =
    [Scheme::SecondDifference, Scheme::Tents, Scheme::Quadratic, Scheme::Cubic, Scheme::Quartic];

fn scene() -> Scene {
    let ball = Sphere { center_um: [0.1, 0.13, 0.08], radius_um: 0.07 };
    Scene::layer([0.3, 0.26], 0.16, vec![Body::new(BodyShape::Balls(vec![ball]), 0)])
}

fn media(pigment: Complex64) -> Media {
    let one = Complex64::ONE;
    Media { incident: one, exit: one, backgrounds: vec![1.558.into()], inclusions: vec![pigment] }
}

fn incidence(polar_deg: f64, azimuth_deg: f64) -> Incidence {
    Incidence { wavelength_um: 0.9, polar_deg, azimuth_deg, from: Side::Incident }
}

fn problem(scheme: Scheme, pigment: Complex64, polar: f64, azimuth: f64) -> Problem {
    let resolution = Resolution { nx: 5, ny: 4, cells: 2, scheme };
    Problem::from_scene(&scene(), &media(pigment), &incidence(polar, azimuth), resolution, Mean::default())
        .expect("a valid problem")
}

/// A + V as a full matrix: [row][column].
fn assemble(problem: &Problem) -> Vec<Vec<Complex64>> {
    let columns = (0..problem.unknowns()).map(|j| {
        let mut unit = Field::zeros(problem.shape());
        unit.as_slice_mut().expect("contiguous")[j] = Complex64::ONE;
        problem.applied(&unit).into_raw_vec_and_offset().0
    });
    let columns: Vec<Vec<Complex64>> = columns.collect();
    (0..columns.len()).map(|i| columns.iter().map(|c| c[i]).collect()).collect()
}

#[test]
fn transposition_turns_the_bloch_vector_around() {
    // (A + V)ᵀ at q is A + V at −q with harmonics (m, n) ↔ (−m, −n): the ground of reciprocity.
    for scheme in SCHEMES {
        let pigment = Complex64::new(1.4, 0.3);
        let [one, other] = [problem(scheme, pigment, 35.0, 20.0), problem(scheme, pigment, 35.0, 200.0)];
        let (a, b) = (assemble(&one), assemble(&other));
        let width = one.harmonics.len();
        let mirrored = |i: usize| {
            let [m, n] = one.harmonics.orders[i % width];
            i / width * width + one.harmonics.find(-m, -n).expect("the set is symmetric")
        };
        let size = a.iter().flatten().map(|z| z.norm()).fold(0.0, f64::max);
        for i in 0..a.len() {
            for j in 0..a.len() {
                let difference = (a[i][j] - b[mirrored(j)][mirrored(i)]).norm();
                // Identity: transforms of 20 points.
                assert!(difference < 1e-13 * size, "{scheme:?} ({i}, {j}): {difference:e}");
            }
        }
    }
}

#[test]
fn lossless_interior_is_hermitian_and_absorption_dissipates() {
    for scheme in SCHEMES {
        let problem = problem(scheme, Complex64::from(1.4), 35.0, 20.0);
        let noise = Field::from_shape_fn(problem.shape(), |(r, c)| {
            Complex64::new((r as f64 * 1.3 + c as f64).sin(), (r as f64 + 2.1 * c as f64).cos())
        });
        let size: f64 = noise.iter().map(|z| z.norm_sqr()).sum();
        // Identity: the quadratic form of a Hermitian matrix is real; some 100 terms of size 1/h.
        let absorbed = problem.absorptance(&noise) / size;
        assert!(absorbed.abs() < 1e-12, "{scheme:?}: {absorbed:e}");
        // Band-limited contrast rings, so dissipation holds for waves, not for noise on the grid's
        // own scale.
        let absorbing = self::problem(scheme, Complex64::new(1.4, 0.1), 35.0, 20.0);
        assert!(absorbing.absorptance(&absorbing.background_wave()) > 0.0, "{scheme:?}");
    }
}

#[test]
fn residual_of_the_background_wave_is_minus_its_scattered_wave() {
    let problem = problem(Scheme::Cubic, Complex64::new(1.4, 0.1), 10.0, 0.0);
    let background = problem.background_wave();
    let mut residual = Field::zeros(problem.shape());
    let mut scattered = Field::zeros(problem.shape());
    problem.residual(&background, &background, &mut residual);
    problem.scatter(&background, &mut scattered);
    assert!((&residual + &scattered).iter().all(|z| z.norm() < 1e-15 * 4.0));
}

#[test]
fn means_differ_but_the_layer_is_the_same() {
    // Whatever is taken into the mean is left out of the contrast: A + V differs only by
    // discretisation.
    let build = |mean: Mean| {
        let resolution = Resolution { nx: 5, ny: 5, cells: 2, scheme: Scheme::Cubic };
        Problem::from_scene(
            &scene(),
            &media(Complex64::new(1.4, 0.2)),
            &incidence(0.0, 0.0),
            resolution,
            mean,
        )
    };
    for depends_on_z in [false, true] {
        for absorbing in [false, true] {
            let problem = build(Mean { depends_on_z, absorbing }).expect("a valid problem");
            assert!(problem.has_contrast());
            let loads = assemble(&problem);
            assert!(loads.iter().flatten().all(|z| z.is_finite()));
        }
    }
}

#[test]
fn what_cannot_be_solved_is_refused_with_a_remedy() {
    let refusal = |media: Media, light: Incidence, resolution: Resolution| {
        Problem::from_scene(&scene(), &media, &light, resolution, Mean::default())
            .err()
            .expect("a refusal")
            .to_string()
    };
    let fine = Resolution { nx: 5, ny: 5, cells: 2, scheme: Scheme::Cubic };
    let pigment = Complex64::new(1.4, 0.1);
    let light = incidence(0.0, 0.0);
    let shorter = Incidence { wavelength_um: 0.1, ..light };
    for (message, words) in [
        (refusal(media(pigment), Incidence { polar_deg: 90.0, ..light }, fine), "polar angle"),
        (refusal(media(pigment), Incidence { wavelength_um: f64::NAN, ..light }, fine), "wavelength"),
        (refusal(media(pigment), Incidence { azimuth_deg: f64::NAN, ..light }, fine), "azimuth"),
        (refusal(media(pigment), shorter, Resolution { cells: 40, ..fine }), "use at least 7 points"),
        (refusal(media(pigment), shorter, Resolution { nx: 20, ny: 20, ..fine }), "use at least"),
        (refusal(media(Complex64::new(1.4, -0.1)), light, fine), "inclusion 0"),
        (refusal(media(Complex64::new(f64::NAN, 0.0)), light, fine), "inclusion 0"),
        (refusal(Media { incident: Complex64::new(1.0, 0.2), ..media(pigment) }, light, fine), "transparent"),
        (refusal(media(pigment), light, Resolution { nx: 0, ..fine }), "nx is 0"),
        (refusal(media(pigment), light, Resolution { cells: 0, ..fine }), "nz (cells) is 0"),
    ] {
        assert!(message.contains(words), "{message}");
    }
}
