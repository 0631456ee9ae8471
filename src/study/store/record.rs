//! What is kept of one solve: its propagating orders, its energy receipt and its account.

use super::store::Record;
use crate::wave::maxwell::Polarisation;
use crate::wave::{FarField, Incidence, Order};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// One finished point: a realisation under one wavelength and direction.
///
/// Lengths in nm and µm, angles in degrees, efficiencies as shares of the incident flux. Amplitudes follow
/// [`Order`]'s conventions; evanescent orders are not kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointRecord {
    /// Content hash of everything the numbers depend on; also the record's name.
    pub key: String,
    /// The build that made it: program, version and, where known, commit.
    pub build: String,
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// Wavelength, direction and side of the light.
    pub incidence: Incidence,
    /// Lateral periods, µm.
    pub period_um: [f64; 2],
    /// Reflected share of the incident power.
    pub reflectance: f64,
    /// Transmitted share.
    pub transmittance: f64,
    /// Absorbed share.
    pub absorptance: f64,
    /// What the solve took.
    pub account: SolveAccount,
    /// All orders listed.
    pub orders: Vec<OrderRow>,
    /// Polarisation of the light; `None` for the scalar wave.
    #[serde(default)]
    pub polarisation: Option<Polarisation>,
    /// Re r, Im r, Re t, Im t of every order into the other polarisation; empty for the scalar wave.
    #[serde(default)]
    pub crossed: Vec<[f64; 4]>,
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

/// What is kept of a solve, packing or grid that ended without a result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailureRecord {
    /// Name of the variant; empty for a study of its own.
    pub variant: String,
    /// Number of the realisation, from 0.
    pub realisation: usize,
    /// The solve; `None` where the packing or the grid failed before any solve.
    pub incidence: Option<Incidence>,
    /// The error's message.
    pub reason: String,
}

/// What the solve took and how well it ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolveAccount {
    /// Name of the strategy.
    pub solver: String,
    /// Steps taken.
    pub steps: usize,
    /// Operator applications.
    pub operator_applications: usize,
    /// Relative residual of the discrete problem.
    pub residual: f64,
    /// Wall time, s.
    pub seconds: f64,
}

/// One propagating order as a row of numbers, in the order of the tuple below.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Row", into = "Row")]
pub struct OrderRow(pub Order);

/// m, n, kx/k0, ky/k0, reflected propagates, transmitted propagates, Re r, Im r, Re t, Im t, e_R, e_T.
type Row = (i32, i32, f64, f64, bool, bool, f64, f64, f64, f64, f64, f64);

impl From<OrderRow> for Row {
    fn from(OrderRow(o): OrderRow) -> Row {
        let ([kx, ky], r, t) = (o.direction, o.reflected, o.transmitted);
        let efficiencies = (o.reflected_efficiency, o.transmitted_efficiency);
        let (up, down) = (o.reflected_propagates, o.transmitted_propagates);
        (o.m, o.n, kx, ky, up, down, r.re, r.im, t.re, t.im, efficiencies.0, efficiencies.1)
    }
}

impl From<Row> for OrderRow {
    fn from((m, n, kx, ky, up, down, r_re, r_im, t_re, t_im, e_r, e_t): Row) -> Self {
        OrderRow(Order {
            m,
            n,
            direction: [kx, ky],
            reflected_propagates: up,
            transmitted_propagates: down,
            reflected: Complex64::new(r_re, r_im),
            transmitted: Complex64::new(t_re, t_im),
            reflected_efficiency: e_r,
            transmitted_efficiency: e_t,
            further: Default::default(),
        })
    }
}

/// A number of a far field is NaN or infinite, so it is no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the far field holds a number that is not finite")]
pub struct NotFinite;

/// Amplitudes and efficiencies of an order.
fn amplitudes(order: &Order) -> [f64; 6] {
    let (r, t) = (order.reflected, order.transmitted);
    [r.re, r.im, t.re, t.im, order.reflected_efficiency, order.transmitted_efficiency]
}

fn crossed(order: &Order) -> [f64; 4] {
    let [r, t] = order.further[0];
    [r.re, r.im, t.re, t.im]
}

impl PointRecord {
    /// Keeps what a solve found for light of one polarisation, or the scalar wave. Fails when any number is not finite.
    pub fn new(
        key: String,
        realisation: usize,
        polarisation: Option<Polarisation>,
        far_field: &FarField,
        account: SolveAccount,
    ) -> Result<Self, NotFinite> {
        let propagates = |o: &&Order| o.reflected_propagates || o.transmitted_propagates;
        let record = Self {
            key,
            build: super::build::build().to_owned(),
            realisation,
            incidence: far_field.incidence,
            period_um: far_field.period_um,
            reflectance: far_field.reflectance,
            transmittance: far_field.transmittance,
            absorptance: far_field.absorptance,
            account,
            orders: far_field.orders.iter().filter(propagates).copied().map(OrderRow).collect(),
            polarisation,
            crossed: match polarisation {
                None => Vec::new(),
                Some(_) => far_field.orders.iter().filter(propagates).map(crossed).collect(),
            },
        };
        if record.is_finite() { Ok(record) } else { Err(NotFinite) }
    }

    /// The far field again, without its evanescent orders.
    pub fn far_field(&self) -> FarField {
        FarField {
            incidence: self.incidence,
            period_um: self.period_um,
            orders: self.orders.iter().enumerate().map(|(i, row)| self.order(i, row.0)).collect(),
            reflectance: self.reflectance,
            transmittance: self.transmittance,
            absorptance: self.absorptance,
        }
    }

    /// An order with its crossed amplitudes.
    fn order(&self, i: usize, order: Order) -> Order {
        let mut full = order;
        if let Some([r, r_im, t, t_im]) = self.crossed.get(i) {
            full.further[0] = [Complex64::new(*r, *r_im), Complex64::new(*t, *t_im)];
        }
        full
    }

    /// R + T + A − 1.
    pub fn energy_error(&self) -> f64 {
        self.reflectance + self.transmittance + self.absorptance - 1.0
    }

    fn is_finite(&self) -> bool {
        let totals = [self.reflectance, self.transmittance, self.absorptance, self.account.residual];
        let amplitudes = self.orders.iter().flat_map(|row| amplitudes(&row.0));
        let crossed = self.crossed.iter().flatten().copied();
        totals.into_iter().chain(amplitudes).chain(crossed).all(f64::is_finite)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::store::Store;
    use crate::wave::Side;

    /// A far field of two orders, one of them evanescent, with numbers that need all their digits.
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
        assert_eq!((back.polarisation, back.crossed.len()), (Some(Polarisation::P), 1));
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
