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
