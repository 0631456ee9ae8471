//! The nearest vector against a search of all of them; what stays, and what is refused.

use crate::wave::bloch::*;
use proptest::prelude::*;

fn media(index: f64) -> Media {
    Media { incident: index.into(), exit: 1.3.into(), backgrounds: vec![1.5.into()], inclusions: vec![] }
}

fn light(polar_deg: f64, azimuth_deg: f64, from: Side) -> Incidence {
    Incidence { wavelength_um: 0.5, polar_deg, azimuth_deg, from }
}

/// Distance of the nearest vector of the lattice among all that propagate.
fn least_distance(whole: [f64; 2], step: [f64; 2], k: f64) -> f64 {
    let most = step.map(|s| (k / s) as i32 + 1);
    let all = (-most[0]..=most[0]).flat_map(|m| (-most[1]..=most[1]).map(move |n| lateral([m, n], step)));
    let propagating = all.filter(|[x, y]| x.hypot(*y) <= REACH * k);
    propagating.map(|[x, y]| (x - whole[0]).hypot(y - whole[1])).fold(f64::INFINITY, f64::min)
}

proptest! {
    #[test]
    fn the_direction_is_the_nearest_of_the_lattice_that_propagates(
        polar in 0.0..89.99f64, azimuth in -400.0..400.0f64, index in 1.0..2.0f64,
        x in 0.1..6.0f64, y in 0.1..6.0f64, exit in any::<bool>(),
    ) {
        let from = if exit { Side::Exit } else { Side::Incident };
        let requested = light(polar, azimuth, from);
        let media = media(index);
        let step = [TAU / x, TAU / y];
        let k = TAU / 0.5 * if exit { 1.3 } else { index };
        let snapped = requested.snapped([x, y], &media).expect("a direction");
        snapped.incidence.check().expect("not grazing");
        prop_assert!(snapped.incidence.polar_deg < 89.95);
        prop_assert!((snapped.incidence.azimuth_deg - azimuth).abs() <= 180.0 + 1e-9);
        let lateral_of = |light: Incidence| light.lateral_wavevector(&media).expect("transparent");
        let whole = lateral_of(requested);
        let found = lateral_of(snapped.incidence);
        let meant = lateral(snapped.vector, step);
        let between = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        // Identity: a sine of an arcsine.
        prop_assert!(between(found, meant) < 1e-13 * k, "{found:?} is not {meant:?}");
        // Identity, but for the slack of a tie.
        let least = least_distance(whole, step, k);
        prop_assert!(between(meant, whole) <= least + 1e-8 * step[0].max(step[1]), "{meant:?}: {least}");
        // A direction of the lattice stays where it is.
        let again = snapped.incidence.snapped([x, y], &media).expect("a direction");
        prop_assert_eq!(again.vector, snapped.vector);
        prop_assert!((again.incidence.azimuth_deg - snapped.incidence.azimuth_deg).abs() < 1e-9);
    }
}

#[test]
fn light_along_the_normal_stays_as_it_is() {
    let normal = light(0.0, 77.0, Side::Incident);
    let snapped = normal.snapped([0.7, 3.0], &media(1.0)).expect("a direction");
    assert_eq!(snapped, Snapped { incidence: normal, vector: [0, 0] });
}

/// Directions lie 0.5 apart; the nearest to 80° is the grazing one (2, 0), to be passed over, also
/// by light between two.
#[test]
fn grazing_vectors_are_passed_over_and_ties_go_to_the_normal() {
    let vector = |polar, azimuth| {
        let requested = light(polar, azimuth, Side::Incident);
        requested.snapped([1.0, 1.0], &media(1.0)).expect("a direction").vector
    };
    assert_eq!(vector(80.0, 0.0), [1, 0]);
    assert_eq!(vector(80.0, 90.0), [0, 1]);
    assert_eq!(vector(80.0, 180.0), [-1, 0]);
    assert_eq!(vector(80.0, 45.0), [1, 1]);
    let half = 0.25f64.asin().to_degrees();
    assert_eq!([0.0, 90.0, 180.0, 270.0].map(|azimuth| vector(half, azimuth)), [[0, 0]; 4]);
}

#[test]
fn what_has_no_lattice_or_no_direction_is_refused() {
    let good = light(20.0, 0.0, Side::Incident);
    for period in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
        let message = good.snapped([1.0, period], &media(1.0)).expect_err("no period").to_string();
        assert!(message.contains("period (µm) is") && message.contains("do not snap"), "{message}");
    }
    assert!(light(90.0, 0.0, Side::Incident).snapped([1.0; 2], &media(1.0)).is_err());
    let absorber = Media { incident: num_complex::Complex64::new(1.0, 0.1), ..media(1.0) };
    assert!(good.snapped([1.0; 2], &absorber).is_err());
}
