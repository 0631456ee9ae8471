//! Homogeneous layers against Fresnel and Airy.

use super::layers::solved;
use crate::claim::{Claim, Findings, Level};
use crate::formulas::films::{Film, amplitudes};
use num_complex::Complex64;

pub const CLAIM: Claim = Claim {
    id: "01-slab",
    statement: "A homogeneous layer reflects and transmits as Fresnel and Airy say, at any angle, absorption and thickness.",
    because: "The mean operator solves each cell exactly, so no discretisation error is left (P2 section 3; Born and Wolf 1.6).",
    file: file!(),
    measure,
};

const WAVELENGTH_UM: f64 = 0.55;
/// Thickness in µm: from the thinnest that is allowed to opaque.
const THICKNESSES: [f64; 5] = [1e-6, 1e-3, 0.3, 2.0, 60.0];
const KAPPAS: [f64; 5] = [0.0, 1e-3, 0.1, 0.6, 1.0];

fn measure(level: Level, findings: &mut Findings) {
    let angles: &[f64] = level.pick(&[0.0, 35.0, 80.0], &[0.0, 10.0, 20.0, 35.0, 50.0, 65.0, 80.0, 89.0]);
    let mut largest = 0.0f64;
    let mut relative = 0.0f64;
    let mut opaque = 0.0f64;
    for &polar_deg in angles {
        for kappa in KAPPAS {
            for thickness_um in THICKNESSES {
                for below in [1.0, 1.5] {
                    let film = Film { index: Complex64::new(1.558, kappa), thickness_um };
                    let want = amplitudes(1.0, &[film], below.into(), WAVELENGTH_UM, polar_deg);
                    let got = solved([1.0, below], &[film], WAVELENGTH_UM, polar_deg);
                    let error = (got[0] - want[0]).norm().max((got[1] - want[1]).norm());
                    let rounding = f64::EPSILON * (1.0 + WAVELENGTH_UM / thickness_um);
                    largest = largest.max(error / rounding);
                    // Thinner films have the rounding above, and t near 1.
                    if want[1].norm() > 1e-280 && thickness_um >= 1e-3 {
                        relative = relative.max((got[1] - want[1]).norm() / want[1].norm());
                        opaque = opaque.max(-want[1].norm().log10());
                    }
                }
            }
        }
    }
    findings.identity(
        "largest error of r and t, in units of rounding",
        largest,
        1000.0,
        "2e-16 (1 + λ/H), as thin films are differences of large numbers, over some 100 operations and |k_z H| ≤ 1100",
    );
    findings.identity(
        format!("largest relative error of t, down to |t| = 1e-{opaque:.0}"),
        relative,
        1e-10,
        "the exponent's rounding, 2e-16 × |k_z H| ≤ 1100, some times over",
    );
}
