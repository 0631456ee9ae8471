use super::*;
use crate::appearance::composed::fringes::stack_film::Mirrors;
use crate::appearance::composed::ordinates::Ordinates;

fn medium(index: f64, polarisations: usize) -> Hemisphere {
    let ordinates = Ordinates::new(index, &[1.4, 1.6, 2.0], [3, 2]);
    Hemisphere { ordinates, polarisations, oblique_deg: (index == 1.0).then_some(45.0) }
}

fn sums(plate: &Plate, side: usize) -> Vec<f64> {
    let all = [&plate.reflection[side], &plate.transmission[side]];
    let column = |j: usize| all.map(|m| (0..m.nrows()).map(|i| m[(i, j)]).sum::<f64>()).iter().sum();
    (0..all[0].ncols()).map(column).collect()
}

/// A face keeps all light, is reciprocal, and mirrors at 0° what Fresnel says; light beyond the
/// critical angle stays. *Planted*: transmissions from the two sides changed round.
#[test]
fn a_face_keeps_all_light_and_is_reciprocal() {
    for polarisations in [1, 2] {
        let media = [medium(1.0, polarisations), medium(1.6, polarisations)];
        let plate = face(&media[0], &media[1]);
        assert!((plate.reflection[0][(0, 0)] - (0.6_f64 / 2.6).powi(2)).abs() < 1e-15);
        for side in 0..2 {
            assert!(sums(&plate, side).iter().all(|sum| (sum - 1.0).abs() < 1e-12));
        }
        let [outer, inner] = media.each_ref().map(Hemisphere::weights);
        let nodes = polarisations * media[0].ordinates.count();
        for k in 1..=nodes {
            let onward = plate.transmission[0][(k, k)] / inner[k];
            assert!((onward - plate.transmission[1][(k, k)] / outer[k]).abs() < 1e-12, "{k}");
        }
        assert_eq!(plate.reflection[1][(nodes + 1, nodes + 1)], 1.0 - LEAST_LOSS);
    }
}

/// A joint without thickness that is denser than its neighbours is no layer: where no light arrives
/// between two totally reflecting faces there is none. *Planted*: faces that lose nothing.
#[test]
fn a_denser_joint_without_thickness_is_no_layer() {
    for polarisations in [1, 2] {
        let media = [medium(1.4, polarisations), medium(1.6, polarisations), medium(1.4, polarisations)];
        let plate = face(&media[0], &media[1]).then(&face(&media[1], &media[2]));
        for side in 0..2 {
            assert!(
                sums(&plate, side).iter().all(|sum| (sum - 1.0).abs() < 1e-9),
                "{:?}",
                sums(&plate, side)
            );
        }
    }
}

/// Media of a joint that differ in their zones are refused, and so is a stack of nothing.
#[test]
fn joints_have_the_same_states_on_both_sides() {
    let air = medium(1.0, 1);
    let varnish = medium(1.6, 1);
    let clear = |behind: &Hemisphere| StackElement::clear([&air, &varnish, behind], 1.6.into(), 1.0, 0.5, 0);
    assert!(PlateStack::new(clear(&medium(1.4, 1)), air.clone(), 0.5).is_ok());
    let ordinates = Ordinates::new(1.6, &[], [3, 3]);
    let other = Hemisphere { ordinates, ..varnish.clone() };
    let mut elements = clear(&varnish);
    elements.extend(StackElement::clear([&other, &other, &air], 1.6.into(), 1.0, 0.5, 1));
    let refusal = PlateStack::new(elements, air.clone(), 0.5).expect_err("other zones");
    assert!(refusal.contains("same zones"), "{refusal}");
    assert!(PlateStack::new(Vec::new(), air, 0.5).is_err());
}

/// A layer that was solved behind another medium than that of its joint is refused.
#[test]
fn neighbours_are_solved_in_the_medium_of_their_joint() {
    let air = Hemisphere { oblique_deg: None, ..medium(1.0, 1) };
    let film = SolvedElement {
        amplitudes: Default::default(),
        between: [1.4, 1.0],
        index: 1.0,
        permittivity: Complex64::ONE,
        thickness_um: 1.0,
        mirrors: Mirrors::Nowhere,
        count: 1.0,
        part_first: false,
    };
    let plate = Plate::nothing(air.states());
    let element = |between| {
        StackElement::solved(plate.clone(), SolvedElement { between, ..film.clone() }, air.clone(), 0)
    };
    assert!(PlateStack::new(vec![element([1.0; 2])], air.clone(), 0.5).is_ok());
    let refusal = PlateStack::new(vec![element([1.4, 1.0])], air.clone(), 0.5).expect_err("another medium");
    assert!(refusal.contains("index 1.4"), "{refusal}");
}

/// An absorbing film: what it absorbs at 0° is what its two faces and one way through it leave of
/// the light, and fluxes at the joints behind them are its own.
#[test]
fn a_film_absorbs_what_does_not_come_out() {
    let (air, film) = (medium(1.0, 1), medium(1.6, 1));
    let index = Complex64::new(1.6, 0.05);
    let elements = StackElement::clear([&air, &film, &air], index, 1.0, 0.5, 0);
    let stack = PlateStack::new(elements, air.clone(), 0.5).unwrap();
    let mut light = Mat::zeros(air.states(), 1);
    light[(0, 0)] = 1.0;
    let black = Plate::lambertian(0.0, &air.weights());
    let mirrored = (0.6_f64 / 2.6).powi(2);
    let way = (-2.0 * TAU / 0.5 * 0.05_f64).exp();
    let down = (1.0 - mirrored) / (1.0 - (mirrored * way).powi(2));
    let joints = stack.joints(&light, &black);
    assert!(
        (joints[0].down - down).abs() < 1e-12 && (joints[0].up - down * way * way * mirrored).abs() < 1e-12
    );
    assert!((joints[1].down - down * way).abs() < 1e-12);
    let absorbed = down * (1.0 - way) * (1.0 + way * mirrored);
    let [own] = stack.absorbed(&light, &black)[..] else { panic!("one layer") };
    assert!((own - absorbed).abs() < 1e-12, "{own} {absorbed}");
}

/// A repeated element is as many of it, a part of it less.
#[test]
fn elements_are_repeated() {
    let air = Hemisphere { oblique_deg: None, ..medium(1.0, 1) };
    let plate = even(&air, Complex64::new(1.0, 0.01), 1.0, 0.5);
    let film = |count| SolvedElement {
        amplitudes: Default::default(),
        between: [1.0; 2],
        index: 1.0,
        permittivity: Complex64::ONE,
        thickness_um: 1.0,
        mirrors: Mirrors::Nowhere,
        count,
        part_first: false,
    };
    let through = |count: f64| {
        let element = StackElement::solved(plate.clone(), film(count), air.clone(), 0);
        PlateStack::new(vec![element], air.clone(), 0.5).unwrap().plate().transmission[0][(0, 0)]
    };
    let once = through(1.0);
    assert!((through(3.0) - once.powi(3)).abs() < 1e-12);
    assert!((through(2.5) - once.powf(2.5)).abs() < 1e-9);
}
