//! What leaves the layer: complex amplitudes and efficiencies of every order.

use super::Incidence;
use num_complex::Complex64;

/// One diffraction order (m, n).
///
/// `direction` is (kx, ky)/k0, the direction cosines when the half-space is vacuum. The reflected amplitude
/// refers to the face the light enters by, the transmitted one to the opposite face; the reflected (0, 0)
/// amplitude is u₀₀ − 1 (P2 (4.10) corrected). Efficiencies are Re κ_mn/κ₀₀ |·|², zero for evanescent orders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    pub m: i32,
    pub n: i32,
    pub direction: [f64; 2],
    pub reflected_propagates: bool,
    pub transmitted_propagates: bool,
    pub reflected: Complex64,
    pub transmitted: Complex64,
    pub reflected_efficiency: f64,
    pub transmitted_efficiency: f64,
}

/// All orders of one solve with their receipt: R + T + A = 1, A from the discrete quadratic form.
#[derive(Clone, Debug, PartialEq)]
pub struct FarField {
    pub incidence: Incidence,
    pub period_um: [f64; 2],
    pub orders: Vec<Order>,
    pub reflectance: f64,
    pub transmittance: f64,
    pub absorptance: f64,
}

impl FarField {
    /// R + T + A − 1: zero to the solver's residual at any resolution.
    pub fn energy_error(&self) -> f64 {
        self.reflectance + self.transmittance + self.absorptance - 1.0
    }

    /// The specular order (0, 0).
    pub fn specular(&self) -> &Order {
        let is_specular = |o: &&Order| o.m == 0 && o.n == 0;
        self.orders.iter().find(is_specular).expect("order (0, 0) is always kept")
    }
}
