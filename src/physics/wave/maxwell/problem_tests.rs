//! Refusals, each with its reason.

use super::*;
use crate::wave::{Ball, Body, Resolution, Scene, Scheme, Shape};

fn problem(pigment: Complex64, scheme: Scheme) -> Result<VectorProblem, WaveError> {
    let ball = Ball { center_um: [0.1, 0.13, 0.08], radius_um: 0.07 };
    let scene = Scene::layer([0.3, 0.26], 0.16, vec![Body::new(Shape::Balls(vec![ball]), 0)]);
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
    let cubic = problem(1.4.into(), Scheme::Cubic).err().expect("another scheme is refused");
    assert!(cubic.to_string().contains("two moments"), "{cubic}");
    assert!(problem(1.4.into(), Scheme::Quadratic).is_ok());
}
