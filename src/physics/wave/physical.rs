//! Physical checks that every far field must pass before it becomes a result.
//!
//! For any passive layer R, T and A = 1 − R − T lie between 0 and 1. A discretisation too coarse
//! for its contrast violates this: the band-limited contrast rings, and where it rings below zero
//! it amplifies light.

use super::FarField;
use thiserror::Error;

/// Largest error of a total that is accepted, whatever the error estimate.
const LARGEST: f64 = 0.02;
/// Ratio of the error of totals to that of every amplitude: R = Σ |r|² changes by 2 |r| δ per
/// order, with independent signs; this is three standard deviations of the sum.
const TOTAL_OF_AMPLITUDE: f64 = 6.0;
/// Ratio of the error of totals to the relative residual: trapped waves amplify it about tenfold.
const TOTAL_OF_RESIDUAL: f64 = 30.0;
/// Tolerated error of R + T + A as a fraction of the errors of R and T: metals amplify a residual
/// by 32 and more, and a deviation negligible beside the grid's error must not reject a result.
const BALANCE_SHARE: f64 = 0.05;
/// Rounding error of sums over orders and nodes.
const ROUNDING: f64 = 1e-9;

/// Tolerated errors of the totals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TotalErrors {
    /// Error of R.
    pub reflectance: f64,
    /// Error of T.
    pub transmittance: f64,
    /// Error of R + T + A: the solver's, since the discrete system conserves energy, or a small
    /// fraction of the others.
    pub balance: f64,
}

impl TotalErrors {
    /// Errors from the estimated error of every complex amplitude, and the relative residual.
    pub fn of_amplitudes(error: f64, residual: f64) -> Self {
        Self::of_totals([TOTAL_OF_AMPLITUDE * error; 2], residual)
    }

    /// Errors from estimated errors of R and T, and the relative residual.
    pub fn of_totals([reflectance, transmittance]: [f64; 2], residual: f64) -> Self {
        let solver = ROUNDING + TOTAL_OF_RESIDUAL * residual;
        let balance = solver + BALANCE_SHARE * (reflectance + transmittance);
        // Not `min`, which ignores NaN.
        let bounded = |error: f64| if error > LARGEST { LARGEST } else { error };
        let reflectance = bounded(reflectance + solver);
        let transmittance = bounded(transmittance + solver);
        Self { reflectance, transmittance, balance: bounded(balance) }
    }
}

/// Why a far field is not a valid result.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Unphysical {
    /// A number is NaN or infinite: lengths and indices too far apart for double precision.
    #[error(
        "{quantity} is {value}: no result. Lengths or indices are too far apart for double precision; give the \
         wavelength and lengths in µm and refractive indices of matter"
    )]
    NotFinite {
        /// Name of the quantity.
        quantity: &'static str,
        /// NaN or an infinity.
        value: f64,
    },
    /// A total that no passive layer can have.
    #[error(
        "{quantity} is {value:.4}; allowed is 0 … 1 within {error:.1e}: no result. The grid is too coarse for these \
         indices; take more points and cells, or give an accuracy instead of a grid"
    )]
    OutOfRange {
        /// R, T or A.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// Tolerated error of the total.
        error: f64,
    },
    /// Energy is not conserved.
    #[error(
        "R + T + A is {sum:.6}; allowed is 1 within {error:.1e}: no result. Ask for a smaller residual (tolerance), \
         or take more points and cells"
    )]
    OutOfBalance {
        /// Value of R + T + A.
        sum: f64,
        /// Tolerated error of the sum.
        error: f64,
    },
}

impl FarField {
    /// The far field if it has finite numbers only, with R, T and A from 0 to 1 and their sum 1,
    /// all within the `errors` that its totals may have.
    ///
    /// # Errors
    /// [`Unphysical`]: the law that is violated.
    pub fn judged(self, errors: TotalErrors) -> Result<FarField, Unphysical> {
        finite(&self, &errors)?;
        let TotalErrors { reflectance, transmittance, balance } = errors;
        let errors = [reflectance, transmittance, (reflectance + transmittance).min(LARGEST)];
        let mut totals = self.totals().into_iter().zip(errors);
        let wrong = totals.find(|((_, value), error)| !(-error..=1.0 + error).contains(value));
        if let Some(((quantity, value), error)) = wrong {
            return Err(Unphysical::OutOfRange { quantity, value, error });
        }
        let sum = 1.0 + self.energy_error();
        if (sum - 1.0).abs() > balance {
            return Err(Unphysical::OutOfBalance { sum, error: balance });
        }
        Ok(self)
    }

    fn totals(&self) -> [(&'static str, f64); 3] {
        [("R", self.reflectance), ("T", self.transmittance), ("A", self.absorptance)]
    }
}

fn finite(far: &FarField, errors: &TotalErrors) -> Result<(), Unphysical> {
    let of_pair = |pair: [num_complex::Complex64; 2]| {
        ["an amplitude R", "an amplitude T"].into_iter().zip(pair).flat_map(|(q, z)| [(q, z.re), (q, z.im)])
    };
    let of_order = move |o: &super::Order| {
        let efficiencies = [o.reflected_efficiency, o.transmitted_efficiency].map(|e| ("an efficiency", e));
        o.amplitudes().flat_map(of_pair).chain(efficiencies)
    };
    let mut all = far.totals().into_iter().chain(far.orders.iter().flat_map(of_order));
    if let Some((quantity, value)) = all.find(|(_, value)| !value.is_finite()) {
        return Err(Unphysical::NotFinite { quantity, value });
    }
    let TotalErrors { reflectance, transmittance, balance } = errors;
    if [reflectance, transmittance, balance].iter().any(|e| !e.is_finite()) {
        return Err(Unphysical::NotFinite { quantity: "the error estimate", value: f64::NAN });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wave::{Incidence, Order, Side};
    use num_complex::Complex64;

    fn far(reflectance: f64, transmittance: f64, absorptance: f64) -> FarField {
        let order = Order {
            m: 0,
            n: 0,
            direction: [0.0; 2],
            reflected_propagates: true,
            transmitted_propagates: true,
            reflected: Complex64::new(0.3, 0.1),
            transmitted: Complex64::new(0.3, 0.1),
            reflected_efficiency: reflectance,
            transmitted_efficiency: transmittance,
            further: Default::default(),
        };
        let incidence =
            Incidence { wavelength_um: 0.5, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
        FarField {
            incidence,
            period_um: [1.0; 2],
            orders: vec![order],
            reflectance,
            transmittance,
            absorptance,
            absorbed: Vec::new(),
        }
    }

    fn judged(r: f64, t: f64, a: f64, error: f64) -> Result<FarField, Unphysical> {
        far(r, t, a).judged(TotalErrors::of_amplitudes(error, 1e-8))
    }

    #[test]
    fn what_is_physical_within_its_error_passes() {
        for (r, t, a) in [(0.3, 0.4, 0.3), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.6, 0.403, -0.003)] {
            assert!(judged(r, t, a, 1e-3).is_ok(), "{r} {t} {a}");
        }
    }

    #[test]
    fn what_is_not_is_refused_however_large_its_error() {
        for (r, t, a) in [(29.6, 17.4, -46.0), (1.1, 0.0, -0.1), (0.0, 1.1, -0.1), (0.6, 0.6, -0.2)] {
            for error in [1e-3, 1.0, 1e6] {
                assert!(matches!(judged(r, t, a, error), Err(Unphysical::OutOfRange { .. })), "{r} {t} {a}");
            }
        }
        assert!(matches!(judged(0.6, 0.403, -0.003, 1e-5), Err(Unphysical::OutOfRange { .. })));
        assert!(matches!(judged(0.3, 0.3, 0.3, 1.0), Err(Unphysical::OutOfBalance { .. })));
        assert!(matches!(judged(0.3, 0.4, 0.299, 1e-3), Err(Unphysical::OutOfBalance { .. })));
        // What a metal's residual of 6e-7 does, for an accuracy of 4e-4.
        assert!(judged(0.3, 0.4, 0.299_982, 4e-4).is_ok());
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let none = f64::NAN;
        for (r, t, a, error) in [
            (none, 0.5, 0.5, 0.1),
            (0.5, f64::INFINITY, 0.5, 0.1),
            (0.5, 0.5, none, 0.1),
            (0.5, 0.5, 0.0, none),
        ] {
            assert!(
                matches!(judged(r, t, a, error), Err(Unphysical::NotFinite { .. })),
                "{r} {t} {a} {error}"
            );
        }
        let mut hidden = far(0.3, 0.4, 0.3);
        hidden.orders[0].transmitted.im = none;
        assert!(hidden.judged(TotalErrors::of_amplitudes(0.1, 0.0)).is_err());
    }
}
