//! Birefringent bodies: what holds exactly, and what is refused. Their amplitudes are those of claim 48.

use inkwave::input::case::Case;
use inkwave::wave::{FarField, Mean, Problem};
use inkwave_validation::vector::*;

/// A sphere, an ellipsoid and a film above them, each with these further keys.
fn case(keys: [&str; 3]) -> Case {
    let [sphere, body, film] = keys;
    let text = format!(
        "wavelength = 0.55\nsigma_deg = 30\nphi_deg = 20\nL = [0.5, 0.45]\n\
         [[spheres]]\ncenter = [0.12, 0.2, 0.2]\nradius = 0.11\neta = [2.3, 0.05]\n{sphere}\n\
         [[bodies]]\nshape = {{ kind = 'ellipsoid', axes = [0.16, 0.2, 0.24] }}\ncenter = [0.37, 0.3, 0.2]\naxis = [0.5, 0.2, 1.0]\n\
         eta = [1.9, 0.0]\n{body}\n\
         [[layers_from_z0]]\nthickness = 0.36\neta = [1.5, 0]\n\
         [[layers_from_z0]]\nthickness = 0.1\neta = [1.7, 0]\n{film}\n"
    );
    Case::parse(&text, true).unwrap_or_else(|e| panic!("{e}"))
}

fn bits(far: &[FarField; 2]) -> Vec<u64> {
    let parts = |far: &FarField| -> Vec<u64> {
        let pairs = far.orders.iter().flat_map(|order| order.amplitudes().collect::<Vec<_>>());
        pairs.flatten().flat_map(|z| [z.re.to_bits(), z.im.to_bits()]).collect()
    };
    far.iter().flat_map(parts).collect()
}

/// Identity: two equal indices are one, bit for bit, in grains and whatever the axis. (A film of a crystal is no film of the
/// mean medium, but filled by a body: the same to the residual.)
#[test]
fn equal_indices_are_one_bit_for_bit() {
    let axis = "optic_axis = [0.3, -0.5, 0.8]";
    let sphere = format!("eta_extraordinary = [2.3, 0.05]\n{axis}");
    let body = format!("eta_extraordinary = [1.9, 0.0]\n{axis}");
    let plain = solve(&case(["", "", ""]), 12, 12, 1e-9).far;
    let crystals = solve(&case([&sphere, &body, ""]), 12, 12, 1e-9).far;
    assert_eq!(bits(&plain), bits(&crystals));
    let film = solve(&case(["", "", "eta_extraordinary = [1.7, 0.0]"]), 12, 12, 1e-9).far;
    assert!(inkwave::solve::accuracy::largest_of_all(&plain, &film) < 1e-7);
}

/// Identity: the tensor is symmetric, so that lossless crystals keep the energy and lossy ones lose what their volume absorbs.
#[test]
fn crystals_keep_the_energy() {
    for (loss, absorbing) in [("0.0", false), ("0.04", true)] {
        let sphere = format!("eta_extraordinary = [2.6, {loss}]\noptic_axis = [0.3, -0.5, 0.8]");
        let body = format!("eta_extraordinary = [1.6, {loss}]\noptic_axis = [1, 0, 0]");
        let film = format!("eta_extraordinary = [2.0, {loss}]\noptic_axis = [0.6, 0, 0.8]");
        let mut case = case([&sphere, &body, &film]);
        if !absorbing {
            case.media.inclusions.iter_mut().for_each(|eta| eta.im = 0.0);
        }
        for far in solve(&case, 9, 12, 1e-10).far {
            assert!(far.energy_error().abs() < 1e-8, "{loss}: {:.1e}", far.energy_error());
            assert_eq!(far.absorptance.abs() > 1e-3, absorbing, "{}", far.absorptance);
        }
    }
}

/// The axis of a body turns with it, and that of a sphere is the one given.
#[test]
fn the_axis_of_a_body_turns_with_it() {
    let keys = "eta_extraordinary = [2.4, 0.0]\noptic_axis = [0, 0, 1]";
    let bodies = case([keys, keys, keys]).scene.bodies;
    let norm = (0.25f64 + 0.04 + 1.0).sqrt();
    let turned = [0.5 / norm, 0.2 / norm, 1.0 / norm];
    for (body, want) in bodies.iter().zip([[0.0, 0.0, 1.0], turned, [0.0, 0.0, 1.0]]) {
        assert!((0..3).all(|i| (body.optic_axis[i] - want[i]).abs() < 1e-12), "{body:?}");
    }
}

#[test]
fn what_crystals_cannot_be_is_refused() {
    let refusal = |text: &str| Case::parse(text, true).expect_err("refused").to_string();
    let head = "wavelength = 0.5\nL = 0.5\n";
    let crystal = "eta_extraordinary = [1.8, 0]\n";
    let sphere = "[[spheres]]\ncenter = [0.2, 0.2, 0.2]\nradius = 0.1\neta = [1.6, 0]\n";
    let film = "[[layers_from_z0]]\nthickness = 0.4\neta = [1.5, 0]\n";
    for (text, says) in [
        (
            format!("{head}{sphere}{film}{crystal}"),
            [
                "layers_from_z0[0].eta_extraordinary",
                "spheres[0] in the film",
                "without bodies",
                "give the film one index",
            ],
        ),
        (
            format!("{head}{sphere}optic_axis = [0, 0, 1]\n{film}"),
            ["spheres[0].optic_axis", "no eta_extraordinary", "two indices", "give eta_extraordinary"],
        ),
        (
            format!("{head}{sphere}{crystal}optic_axis = [0, 0, 0]\n{film}"),
            ["spheres[0].optic_axis", "[0.0, 0.0, 0.0]", "finite length", "give [x, y, z]"],
        ),
        (
            format!("{head}{sphere}eta_extraordinary = [1.8, -0.1]\n{film}"),
            ["spheres[0].eta_extraordinary", "-0.1", "absorbs", "change the sign"],
        ),
    ] {
        let said = refusal(&text);
        assert!(says.iter().all(|part| said.contains(part)), "{said}");
    }
    let one = Case::parse(&format!("{head}{sphere}{crystal}{film}"), true).expect("a case");
    let grid = resolution(&one, 8, 6);
    let scalar = Problem::from_scene(&one.scene, &one.media, &one.incidence, grid, Mean::default());
    let said = scalar.err().expect("refused").to_string();
    let says =
        ["wave: found the scalar wave", "extraordinary index", "--wave vector", "one index for both rays"];
    assert!(says.iter().all(|part| said.contains(part)), "{said}");
    let nested = format!(
        "{head}{sphere}{crystal}[[spheres]]\ncenter = [0.2, 0.2, 0.2]\nradius = 0.05\neta = [1.4, 0]\n{film}"
    );
    let nested = Case::parse(&nested, true).expect("a case");
    let moments = inkwave::wave::maxwell::NormalMoments::new(&nested.scene, resolution(&nested, 8, 6));
    let said = moments.err().expect("refused").to_string();
    assert!(said.contains("inside a birefringent one") && said.contains("one index"), "{said}");
}
