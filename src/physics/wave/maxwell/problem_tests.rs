//! Refusals, each with its reason.

use super::*;
use crate::ink::Sphere;
use crate::solve::{Gmres, Goal, Silent, Solver};
use crate::wave::{Body, BodyShape, FarField, Resolution, Scene, Scheme, Side};

fn problem(pigment: Complex64, scheme: Scheme) -> Result<Arc<VectorProblem>, WaveError> {
    let ball = Sphere { center_um: [0.1, 0.13, 0.08], radius_um: 0.07 };
    let scene = Scene::layer([0.3, 0.26], 0.16, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
    let one = Complex64::ONE;
    let media =
        Media { incident: one, exit: one, backgrounds: vec![1.558.into()], inclusions: vec![pigment] };
    let incidence = Incidence { wavelength_um: 0.9, polar_deg: 20.0, azimuth_deg: 0.0, from: Side::Incident };
    let moments = NormalMoments::new(&scene, Resolution { nx: 5, ny: 5, cells: 3, scheme })?;
    VectorProblem::new(&Arc::new(moments), &media, &incidence, Mean::default(), Averaging::Normal)
}

#[test]
fn metals_and_other_schemes_are_refused_with_a_reason() {
    let metal = problem(Complex64::new(0.2, 3.0), Scheme::Quadratic).err().expect("a metal is refused");
    assert!(metal.to_string().contains("singular"), "{metal}");
    // The scalar wave knows no surface charges: for metals it is no remedy.
    assert!(!metal.to_string().contains("or the scalar wave"), "{metal}");
    let cubic = problem(1.4.into(), Scheme::Cubic).err().expect("another scheme is refused");
    assert!(cubic.to_string().contains("two moments"), "{cubic}");
    assert!(problem(1.4.into(), Scheme::Quadratic).is_ok());
}

/// Identity: A is computed independently of R and T, so that lost light shows up in the sum;
/// otherwise far less than 1e-6 is missing.
#[test]
fn a_loss_of_a_millionth_is_seen() {
    let problem = problem(Complex64::new(1.4, 0.1), Scheme::Quadratic).expect("a problem");
    let goal = Goal { tolerance: 1e-10, ..Goal::default() };
    for polarisation in Polarisation::BOTH {
        let system = problem.polarised(polarisation);
        let solution = Gmres::default().solve(&system, goal, &mut Silent).expect("a solution");
        let sound = problem.far_field(&solution.field, polarisation);
        assert!(sound.absorptance > 1e-3 && sound.energy_error().abs() < 10.0 * goal.tolerance, "{sound:?}");
        let lossy = FarField { reflectance: sound.reflectance - 1e-6, ..sound };
        let error = lossy.energy_error();
        assert!((error + 1e-6).abs() < 1e-8, "{error:.2e}");
    }
}

/// What two strata absorb adds up to A, with a ball across their joint, and a stratum that absorbs
/// nothing has none of it.
#[test]
fn strata_absorb_what_is_lost() {
    let ball = Sphere { center_um: [0.1, 0.13, 0.08], radius_um: 0.05 };
    let media = |binders: [Complex64; 2], ball: Complex64| Media {
        incident: Complex64::ONE,
        exit: 1.5.into(),
        backgrounds: binders.to_vec(),
        inclusions: vec![ball],
    };
    let strata = [0, 1].map(|background| crate::wave::Stratum { thickness_um: 0.08, background }).to_vec();
    let bodies = vec![Body::new(BodyShape::Balls(vec![ball]), 0)];
    let scene = Scene { period_um: [0.3, 0.26], strata, bodies, cut: false };
    let incidence = Incidence { wavelength_um: 0.9, polar_deg: 20.0, azimuth_deg: 0.0, from: Side::Incident };
    let grid = Resolution { nx: 5, ny: 5, cells: 6, scheme: Scheme::Quadratic };
    let moments = Arc::new(NormalMoments::new(&scene, grid).expect("moments"));
    let goal = Goal { tolerance: 1e-10, ..Goal::default() };
    let absorbed = |media: &Media, polarisation: Polarisation| {
        let problem = VectorProblem::new(&moments, media, &incidence, Mean::default(), Averaging::Normal);
        let problem = problem.expect("a problem");
        let system = problem.polarised(polarisation);
        let solution = Gmres::default().solve(&system, goal, &mut Silent).expect("a solution");
        let far = problem.far_field(&solution.field, polarisation);
        assert!((far.absorbed.iter().sum::<f64>() - far.absorptance).abs() < 1e-14, "{far:?}");
        far.absorbed
    };
    for polarisation in Polarisation::BOTH {
        let both = media([Complex64::new(1.5, 0.05), Complex64::new(1.6, 0.02)], Complex64::new(1.4, 0.1));
        assert!(absorbed(&both, polarisation).iter().all(|share| *share > 1e-3));
        let second = media([1.5.into(), Complex64::new(1.6, 0.02)], 1.4.into());
        let [first, second] = absorbed(&second, polarisation)[..] else { panic!("two strata") };
        assert!(first.abs() < 1e-13 && second > 1e-3, "{first} {second}");
    }
}
