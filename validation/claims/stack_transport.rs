//! Adding of unlike layers against the multi-layer numbers of DISORT.

use crate::claim::{Claim, Findings, Level};
use inkwave::appearance::composed::flux::Hemisphere;
use inkwave::appearance::composed::fringes::stack_film::{Mirrors, SolvedElement};
use inkwave::appearance::composed::ordinates::Ordinates;
use inkwave::appearance::composed::plate::Plate;
use inkwave::appearance::composed::stack::{JointFlux, PlateStack, StackElement};
use inkwave::appearance::composed::transport::{Transport, diffuse};
use num_complex::Complex64;

pub const CLAIM: Claim = Claim {
    id: "38-stack-transport",
    statement: "Layers of unlike media added one to the next send back, pass and hold the fluxes that DISORT finds for them.",
    because: "Adding is exact for incoherent light; sixteen directions to a side leave some 1e-4 of DISORT's eight streams.",
    file: file!(),
    measure,
};

/// Fluxes \[down, up\] behind some layers, and the flux that the stack sends back.
struct Problem {
    name: &'static str,
    /// (optical thickness, single-scattering albedo) of every layer.
    layers: Vec<[f64; 2]>,
    reflected: f64,
    /// (number of layers in front, down, up)
    within: Vec<(usize, f64, f64)>,
}

/// K. Stamnes, S.-C. Tsay, W. Wiscombe and K. Jayaweera, Appl. Opt. 27 (1988) 2502: the test problems 8c and 9a of
/// DISORT, isotropic scattering in isotropic light of flux 1. The first follows M. Ozisik and S. Shouman, JQSRT 24
/// (1980) 441, the second C. Devaux and others, Astrophys. Space Sci. 62 (1979) 225.
fn problems() -> [Problem; 2] {
    [
        Problem {
            name: "8c, two layers",
            layers: vec![[1.0, 0.8], [2.0, 0.95]],
            reflected: 3.78578e-1,
            within: vec![(1, 4.86157e-1, 2.43397e-1), (2, 1.59984e-1, 0.0)],
        },
        Problem {
            name: "9a, six layers",
            layers: (1..=6).map(|k| [f64::from(k), 0.6 + 0.05 * f64::from(k)]).collect(),
            reflected: 2.27973e-1,
            within: vec![(3, 6.71445e-3, 2.19291e-3), (6, 6.16968e-7, 0.0)],
        },
    ]
}

fn measure(_: Level, findings: &mut Findings) {
    let medium =
        Hemisphere { ordinates: Ordinates::for_transfer(1.0, [16, 16]), polarisations: 1, oblique_deg: None };
    let light = diffuse(&medium);
    let black = Plate::lambertian(0.0, &medium.weights());
    for problem in problems() {
        let element = |(number, [depth, albedo]): (usize, &[f64; 2])| {
            let transport = Transport {
                scattering_per_um: depth * albedo,
                absorption_per_um: depth * (1.0 - albedo),
                asymmetry: 0.0,
            };
            let film = SolvedElement {
                amplitudes: Default::default(),
                between: [1.0; 2],
                index: 1.0,
                permittivity: Complex64::ONE,
                thickness_um: 1.0,
                mirrors: Mirrors::Nowhere,
                count: 1.0,
                part_first: false,
            };
            let plate = transport.layer(&medium, 1.0).expect("an optical thickness");
            StackElement::solved(plate, film, medium.clone(), number)
        };
        let elements = problem.layers.iter().enumerate().map(element).collect();
        let stack = PlateStack::new(elements, medium.clone(), 0.5).expect("one medium");
        let joints = stack.joints(&light, &black);
        let absorbed: f64 = stack.absorbed(&light, &black).iter().sum();
        let passed = joints[joints.len() - 1].down;
        let mut off = (1.0 - absorbed - passed - problem.reflected).abs();
        for (layers, down, up) in &problem.within {
            let JointFlux { down: own_down, up: own_up, .. } = joints[layers - 1];
            off = off.max((own_down - down).abs()).max((own_up - up).abs());
        }
        findings.promise(
            format!("DISORT's test problem {}: largest difference of a flux", problem.name),
            off,
            1e-3,
            "DISORT has four directions to a side, and prints six digits",
        );
        let (layers, down, _) = problem.within[problem.within.len() - 1];
        findings.promise(
            format!("DISORT's test problem {}: what passes all layers, relative", problem.name),
            (joints[layers - 1].down / down - 1.0).abs(),
            2e-2,
            "of 21 mean free paths the directions' errors are raised to the same power",
        );
    }
}
