//! Made-up results that tests of the library's last folders draw and write.

use inkwave::appearance::film::Profile;
use inkwave::appearance::paper::{Albedo, Coupling, Substrate};
use inkwave::evaluate::films::Films;
use inkwave::evaluate::ink::{InkInputs, InkOnPaper};
use inkwave::input::variation::ThicknessShare;
use inkwave::material::mixing::molecular_mixture;
use inkwave::material::spectra::Spectrum;
use inkwave::wave::Wave;
use inkwave::wave::{FarField, Incidence, Order, Side};
use num_complex::Complex64;

/// A molecular mixture of a synthetic pigment in the papers' binder, 1 µm, on paper 0.9.
pub fn molecular_ink(pigment: &str, share: f64, coupling: Coupling) -> InkOnPaper {
    let outputs_nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
    let spectrum = Spectrum::synthetic(pigment).expect("a synthetic pigment");
    let index = |nm: f64| {
        molecular_mixture(1.558.into(), &[(share, spectrum.index(1e-3 * nm).expect("a visible wavelength"))])
    };
    let indices = |nm: f64| (vec![index(nm)], Vec::new());
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling };
    let films = Films {
        profile: Profile::homogeneous(),
        indices: &indices,
        thicknesses: ThicknessShare::even(1.0),
        index_out: coupling.index_out(),
        wave: Wave::Scalar,
    };
    InkOnPaper::homogeneous(&InkInputs { films: &films, substrate: &substrate, outputs_nm: &outputs_nm })
        .expect("a film has a colour")
}

/// A far field of two orders, one of them evanescent.
pub fn two_orders() -> FarField {
    let order = |m, propagates| Order {
        m,
        n: 0,
        direction: [0.1 + f64::from(m), 1.0 / 3.0],
        reflected_propagates: propagates,
        transmitted_propagates: propagates,
        reflected: Complex64::new(0.1, -0.2),
        transmitted: Complex64::new(0.7, 0.0),
        reflected_efficiency: 0.05,
        transmitted_efficiency: 0.5,
        further: Default::default(),
    };
    FarField {
        incidence: Incidence { wavelength_um: 0.55, polar_deg: 12.3, azimuth_deg: 0.0, from: Side::Incident },
        period_um: [2.0, 1.5],
        orders: vec![order(0, true), order(9, false)],
        reflectance: 0.05,
        transmittance: 0.5,
        absorptance: 0.45,
        absorbed: Vec::new(),
    }
}
