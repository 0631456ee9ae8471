//! The record of one solve: its propagating orders, its energy balance and its cost.

use super::store::Record;
use crate::wave::FURTHER;
use crate::wave::maxwell::Polarisation;
use crate::wave::{FarField, Incidence, Order};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// One finished point: a realisation at one wavelength and direction.
///
/// Lengths in nm and µm, angles in degrees, efficiencies relative to the incident power. Amplitudes
/// follow the conventions of [`Order`]; evanescent orders are not stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointRecord {
    /// Content hash of everything the numbers depend on; also the record's key.
    pub key: String,
    /// The build that computed it: program, version and, where known, commit.
    pub build: String,
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// Wavelength, direction and side of the light.
    pub incidence: Incidence,
    /// Lateral periods, µm.
    pub period_um: [f64; 2],
    /// Reflectance R.
    pub reflectance: f64,
    /// Transmittance T.
    pub transmittance: f64,
    /// Absorptance A.
    pub absorptance: f64,
    /// What of A is absorbed in every layer of a stack; empty for one layer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub absorbed: Vec<f64>,
    /// Cost of the solve.
    pub account: SolveAccount,
    /// The propagating orders.
    pub orders: Vec<OrderRecord>,
    /// Polarisation of the light; `None` for the scalar wave.
    pub polarisation: Option<Polarisation>,
}

impl Record for PointRecord {
    const KIND: &'static str = "point";

    fn numbers(self) -> Self {
        Self { build: String::new(), account: SolveAccount { seconds: 0.0, ..self.account.clone() }, ..self }
    }
}

impl Record for FailureRecord {
    const KIND: &'static str = "failure";
}

/// Record of a solve, packing or grid without a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailureRecord {
    /// Name of the variant; empty for a single study.
    pub variant: String,
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// The failed solve; `None` if the packing or the grid failed.
    pub incidence: Option<Incidence>,
    /// The error message.
    pub reason: String,
}

/// Cost and final residual of a solve.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveAccount {
    /// Name of the strategy.
    pub solver: String,
    /// Number of iterations.
    pub steps: usize,
    /// Operator applications.
    pub operator_applications: usize,
    /// Relative residual of the discrete problem.
    pub residual: f64,
    /// Wall time, s.
    pub seconds: f64,
}

/// One propagating order; field names are short because there are thousands of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrderRecord {
    /// Index along x.
    pub m: i32,
    /// Index along y.
    pub n: i32,
    /// (kx, ky)/k0.
    #[serde(rename = "k")]
    pub direction: [f64; 2],
    /// Whether the order propagates in reflection and in transmission.
    #[serde(rename = "p")]
    pub propagates: [bool; 2],
    /// Reflected and transmitted amplitude.
    #[serde(rename = "a")]
    pub amplitudes: [Complex64; 2],
    /// Reflected and transmitted efficiencies.
    #[serde(rename = "e")]
    pub efficiencies: [f64; 2],
    /// Reflected and transmitted amplitudes in the other polarisation; `None` for the scalar wave.
    #[serde(rename = "x", default, skip_serializing_if = "Option::is_none")]
    pub crossed: Option<[Complex64; 2]>,
}

impl OrderRecord {
    fn new(order: &Order, polarisation: Option<Polarisation>) -> Self {
        Self {
            m: order.m,
            n: order.n,
            direction: order.direction,
            propagates: [order.reflected_propagates, order.transmitted_propagates],
            amplitudes: [order.reflected, order.transmitted],
            efficiencies: [order.reflected_efficiency, order.transmitted_efficiency],
            crossed: polarisation.map(|_| order.further[0]),
        }
    }

    /// Converts back to an order.
    fn order(&self) -> Order {
        let mut further = <[[Complex64; 2]; FURTHER]>::default();
        further[0] = self.crossed.unwrap_or_default();
        Order {
            m: self.m,
            n: self.n,
            direction: self.direction,
            reflected_propagates: self.propagates[0],
            transmitted_propagates: self.propagates[1],
            reflected: self.amplitudes[0],
            transmitted: self.amplitudes[1],
            reflected_efficiency: self.efficiencies[0],
            transmitted_efficiency: self.efficiencies[1],
            further,
        }
    }

    fn is_finite(&self) -> bool {
        let amplitudes = self.amplitudes.iter().chain(self.crossed.iter().flatten());
        amplitudes.into_iter().all(|a| a.is_finite()) && self.efficiencies.iter().all(|e| e.is_finite())
    }
}

/// A far field contains NaN or infinity, so it is not a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the far field holds a number that is not finite")]
pub struct NotFinite;

impl PointRecord {
    /// Records the far field for one polarisation, or for the scalar wave. Fails if any number is
    /// not finite.
    pub fn new(
        key: String,
        realisation: usize,
        polarisation: Option<Polarisation>,
        far_field: &FarField,
        account: SolveAccount,
    ) -> Result<Self, NotFinite> {
        let kept = far_field.orders.iter().filter(|o| o.reflected_propagates || o.transmitted_propagates);
        let record = Self {
            key,
            build: super::identity::build().to_owned(),
            realisation,
            incidence: far_field.incidence,
            period_um: far_field.period_um,
            reflectance: far_field.reflectance,
            transmittance: far_field.transmittance,
            absorptance: far_field.absorptance,
            absorbed: far_field.absorbed.clone(),
            account,
            orders: kept.map(|order| OrderRecord::new(order, polarisation)).collect(),
            polarisation,
        };
        if record.is_finite() { Ok(record) } else { Err(NotFinite) }
    }

    /// The far field without its evanescent orders.
    pub fn far_field(&self) -> FarField {
        FarField {
            incidence: self.incidence,
            period_um: self.period_um,
            orders: self.orders.iter().map(OrderRecord::order).collect(),
            reflectance: self.reflectance,
            transmittance: self.transmittance,
            absorptance: self.absorptance,
            absorbed: self.absorbed.clone(),
        }
    }

    /// R + T + A − 1.
    pub fn energy_error(&self) -> f64 {
        self.reflectance + self.transmittance + self.absorptance - 1.0
    }

    fn is_finite(&self) -> bool {
        let totals = [self.reflectance, self.transmittance, self.absorptance, self.account.residual];
        totals.iter().chain(&self.absorbed).all(|value| value.is_finite())
            && self.orders.iter().all(OrderRecord::is_finite)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::store::Store;
    use crate::wave::Side;

    /// A far field with two orders, one of them evanescent, whose numbers need all their digits.
    pub(crate) fn two_orders() -> FarField {
        let order = |m, propagates| Order {
            m,
            n: 0,
            direction: [0.1 + f64::from(m), 1.0 / 3.0],
            reflected_propagates: propagates,
            transmitted_propagates: propagates,
            reflected: Complex64::new(0.1, -0.2),
            transmitted: Complex64::new(2.0_f64.sqrt() / 2.0, 1e-300),
            reflected_efficiency: 0.05,
            transmitted_efficiency: 0.5,
            further: Default::default(),
        };
        FarField {
            incidence: Incidence {
                wavelength_um: 0.55,
                polar_deg: 12.3,
                azimuth_deg: 0.0,
                from: Side::Incident,
            },
            period_um: [2.0, 1.5],
            orders: vec![order(0, true), order(9, false)],
            reflectance: 0.05,
            transmittance: 0.5,
            absorptance: 0.45,
            absorbed: vec![0.125, 0.325],
        }
    }

    pub(crate) fn account() -> SolveAccount {
        let solver = "krylov".to_owned();
        SolveAccount { solver, steps: 9, operator_applications: 11, residual: 1e-7, seconds: 0.1 }
    }

    #[test]
    fn a_record_reads_back_bit_for_bit() {
        let record = PointRecord::new("k".into(), 3, None, &two_orders(), account()).unwrap();
        let store = Store::in_memory().unwrap();
        store.put("k", &record).unwrap();
        let back: PointRecord = store.get("k").unwrap();
        assert_eq!(back, record);
        assert_eq!(back.far_field().orders, two_orders().orders[..1]);
    }

    #[test]
    fn crossed_amplitudes_read_back_for_polarised_light() {
        let mut far_field = two_orders();
        far_field.orders[0].further[0] = [Complex64::new(0.01, 0.02), Complex64::new(1.0 / 3.0, -0.5)];
        let record = PointRecord::new("k".into(), 3, Some(Polarisation::P), &far_field, account()).unwrap();
        let store = Store::in_memory().unwrap();
        store.put("k", &record).unwrap();
        let back: PointRecord = store.get("k").unwrap();
        assert_eq!(back.polarisation, Some(Polarisation::P));
        assert_eq!(back.far_field().orders, far_field.orders[..1]);
        far_field.orders[0].further[0][1].re = f64::NAN;
        let refused = PointRecord::new("k".into(), 3, Some(Polarisation::P), &far_field, account());
        assert_eq!(refused, Err(NotFinite));
    }

    #[test]
    fn a_number_that_is_not_finite_makes_no_record() {
        let mut far_field = two_orders();
        far_field.orders[0].transmitted.im = f64::NAN;
        assert_eq!(PointRecord::new("k".into(), 0, None, &far_field, account()), Err(NotFinite));
    }
}
