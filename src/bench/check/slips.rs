//! Common mistakes of programs, as changes of right answers, and of what a program reads, as right
//! answers to another case.

use crate::external::judge::ExpectedOrder;
use crate::external::protocol::AnsweredSide::{self, Reflected, Transmitted};
use num_complex::Complex64;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// What slips depend on, in units of the vacuum wavenumber; light comes from vacuum.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlipLight {
    /// Normal wavenumber of the incident light, the cosine of its polar angle.
    pub kappa: f64,
    /// Thickness of the layer.
    pub height: f64,
    /// Index of the exit side.
    pub exit: f64,
    /// Lateral wavevector of the incident light.
    pub lateral: [f64; 2],
    /// Distance of the orders along x and y.
    pub step: [f64; 2],
}

/// One order under a slip.
pub(super) struct SlipOrder {
    order: ExpectedOrder,
    /// Normal wavenumber in units of that of vacuum.
    kappa: f64,
    /// Index of its half-space.
    index: f64,
}

/// A slip: what it is called, what to do about it, and what becomes of what is right.
pub(super) struct Slip<A> {
    pub name: &'static str,
    pub remedy: &'static str,
    pub act: A,
}

/// A change of a right order.
pub(super) type OrderSlip = Slip<fn(&mut SlipOrder, &SlipLight)>;

/// Right orders as programs with these slips answer them.
pub fn changed(right: &[ExpectedOrder], slips: &[&OrderSlip], light: &SlipLight) -> Vec<ExpectedOrder> {
    let mut all = Vec::new();
    for order in right {
        let index = if order.side == Reflected { 1.0 } else { light.exit };
        let x = light.lateral[0] + f64::from(order.m) * light.step[0];
        let y = light.lateral[1] + f64::from(order.n) * light.step[1];
        let kappa = (index * index - x * x - y * y).max(0.0).sqrt();
        let mut slipped = SlipOrder { order: order.clone(), kappa, index };
        slips.iter().for_each(|slip| (slip.act)(&mut slipped, light));
        all.push(slipped.order);
    }
    all
}

impl SlipOrder {
    fn each(&mut self, change: impl Fn(Complex64) -> Complex64) {
        self.order.amplitudes.iter_mut().for_each(|a| *a = change(*a));
    }

    /// Changes every amplitude; `change` sees whether the incident and the outgoing light is p.
    fn each_pair(&mut self, change: impl Fn(Complex64, [bool; 2]) -> Complex64) {
        let amplitudes = self.order.amplitudes.iter_mut().enumerate();
        amplitudes.for_each(|(k, a)| *a = change(*a, [k / 2 == 1, k % 2 == 1]));
    }

    fn scale(&mut self, factor: f64) {
        self.each(|a| factor * a);
    }

    fn power(&mut self, factor: f64) {
        self.each(|a| (factor * a.norm_sqr()).into());
    }

    fn turn(&mut self, phase: f64) {
        self.each(|a| a * Complex64::cis(phase));
    }

    fn turn_on(&mut self, side: AnsweredSide, phase: f64) {
        if self.order.side == side {
            self.turn(phase);
        }
    }

    /// Multiplies amplitudes of outgoing p light, and divides those of incident p light.
    fn scale_p(&mut self, outgoing: f64, incident: f64) {
        self.each_pair(|a, [from, to]| {
            a * if to { outgoing } else { 1.0 } / if from { incident } else { 1.0 }
        });
    }

    fn swap(&mut self, from: [usize; 4]) {
        if self.order.amplitudes.len() == from.len() {
            self.order.amplitudes = from.map(|k| self.order.amplitudes[k]).to_vec();
        }
    }

    fn relabel(&mut self, m: i32, n: i32) {
        (self.order.m, self.order.n) = (m, n);
    }
}

fn turn_sides(o: &mut SlipOrder, _: &SlipLight) {
    o.order.side = if o.order.side == Transmitted { Reflected } else { Transmitted };
}

fn whole_field(o: &mut SlipOrder, _: &SlipLight) {
    if o.order.side == Reflected && (o.order.m, o.order.n) == (0, 0) {
        o.each_pair(|a, [from, to]| if from == to { a + 1.0 } else { a });
    }
}

fn p_turned(o: &mut SlipOrder, _: &SlipLight) {
    if o.order.side == Reflected {
        o.scale_p(-1.0, 1.0);
    }
}

pub(super) const fn slip<A: Copy>(name: &'static str, remedy: &'static str, act: A) -> Slip<A> {
    Slip { name, remedy, act }
}

/// All slips that change answers order by order.
#[rustfmt::skip]
pub(super) const SLIPS: [OrderSlip; 23] = [
    slip("complex conjugate", "its time factor is e^(+iωt): conjugate every amplitude", |o, _| o.each(|a| a.conj())),
    slip("transmitted phases referred to z = 0", "multiply transmitted amplitudes by e^(iκ′H)",
        |o, l| o.turn_on(Transmitted, -o.kappa * l.height)),
    slip("reflected phases referred to z = H", "multiply reflected amplitudes by e^(iκH)",
        |o, l| o.turn_on(Reflected, -o.kappa * l.height)),
    slip("transmitted phases referred to the incident wave at z = H", "multiply transmitted amplitudes by e^(iκ₀₀H)",
        |o, l| o.turn_on(Transmitted, -l.kappa * l.height)),
    slip("phases referred to the middle of the layer", "multiply amplitudes by e^(i(κ + κ₀₀)H/2)",
        |o, l| o.turn(-0.5 * (o.kappa + l.kappa) * l.height)),
    slip("phases referred to the middle of the cell", "multiply amplitudes by (−1)^(m + n), or set the origin to its corner",
        |o, _| o.turn(PI * f64::from(o.order.m + o.order.n))),
    slip("sides swapped", "exchange reflected and transmitted", turn_sides),
    slip("power instead of amplitude", "give complex amplitudes, not efficiencies", |o, l| o.power(o.kappa / l.kappa)),
    slip("power without the index of the exit medium", "give complex amplitudes, not efficiencies without n",
        |o, l| o.power(o.kappa / o.index / l.kappa)),
    slip("power not divided by the cosine of incidence", "give complex amplitudes, not powers", |o, _| o.power(o.kappa)),
    slip("squared modulus instead of amplitude", "give complex amplitudes", |o, _| o.power(1.0)),
    slip("modulus instead of amplitude", "give complex amplitudes with their phases", |o, _| o.each(|a| a.norm().into())),
    slip("amplitudes normalised by flux", "divide amplitudes by √(κ/κ₀₀): they are those of the field",
        |o, l| o.scale((o.kappa / l.kappa).sqrt())),
    slip("index left out of p light in the exit medium", "amplitudes of p are those of E: divide H by the index",
        |o, _| o.scale_p(o.index, 1.0)),
    slip("p light measured by its tangential field", "divide amplitudes of p by the cosine of their direction",
        |o, l| o.scale_p(o.kappa / o.index, l.kappa)),
    slip("s and p swapped", "s has E perpendicular to the plane of incidence", |o, _| o.swap([3, 2, 1, 0])),
    slip("incident and outgoing polarisation swapped", "the first key is the incident polarisation", |o, _| o.swap([0, 2, 1, 3])),
    slip("reflected p with the opposite sign", "E of p is along (∓κ p̂ − q ẑ)/k: turn its sign in reflection", p_turned),
    slip("s with the opposite sign", "s is along ẑ × k∥: turn the sign of s → p and p → s",
        |o, _| o.each_pair(|a, [from, to]| if from == to { a } else { -a })),
    slip("orders transposed", "m counts along x and n along y", |o, _| o.relabel(o.order.n, o.order.m)),
    slip("orders with the opposite sign", "kx = qx + 2πm/Lx, ky = qy + 2πn/Ly", |o, _| o.relabel(-o.order.m, -o.order.n)),
    slip("order m with the opposite sign", "kx = qx + 2πm/Lx", |o, _| o.relabel(-o.order.m, o.order.n)),
    slip("incident wave left in the reflected order (0, 0)", "subtract 1 from it", whole_field),
];

/// A change of the case that is read.
pub(super) type CaseSlip = Slip<fn(&mut Value)>;

/// All of them; the first one that explains the answers is named.
pub(super) const CASE_SLIPS: [CaseSlip; 7] = [
    slip("degrees read as radians", "`sigma_deg` and `phi_deg` are in degrees", both_as_radians),
    slip("polar angle in degrees read as radians", "`sigma_deg` is in degrees", polar_as_radians),
    slip("azimuth in degrees read as radians", "`phi_deg` is in degrees", azimuth_as_radians),
    slip("azimuth ignored", "kx = k sin σ cos φ and ky = k sin σ sin φ", |c| c["phi_deg"] = json!(0.0)),
    slip("exit medium ignored", "`n_out` is the index beyond z = H", |case| case["n_out"] = json!(1.0)),
    slip("absorption ignored", "indices are [re, im], and Im η > 0 absorbs", without_absorption),
    slip("layer upside down", "z points from the side of the light into the layer", upside_down),
];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_default()
}

/// The direction of light whose angle is a number of radians; sines below 0 turn the azimuth.
fn polar_as_radians(case: &mut Value) {
    let sine = number(&case["sigma_deg"]).sin();
    let turned = if sine < 0.0 { 180.0 } else { 0.0 };
    case["phi_deg"] = json!(number(&case["phi_deg"]) + turned);
    case["sigma_deg"] = json!(sine.abs().asin().to_degrees());
}

/// The azimuth first: the sign of the sine turns what it is then.
fn both_as_radians(case: &mut Value) {
    azimuth_as_radians(case);
    polar_as_radians(case);
}

fn azimuth_as_radians(case: &mut Value) {
    case["phi_deg"] = json!(number(&case["phi_deg"]).to_degrees());
}

/// Sets every imaginary part to 0.
fn without_absorption(value: &mut Value) {
    match value {
        Value::Object(keys) => {
            for (key, inner) in keys {
                if key.starts_with("eta") { inner[1] = json!(0.0) } else { without_absorption(inner) }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(without_absorption),
        _ => {}
    }
}

/// Mirrors the layer between its half-spaces.
fn upside_down(case: &mut Value) {
    let height = number(&case["H"]);
    for key in ["layers_from_z0", "sublayers_from_z0"] {
        if let Some(layers) = case.get_mut(key).and_then(Value::as_array_mut) {
            layers.reverse();
        }
    }
    for sphere in case.get_mut("spheres").and_then(Value::as_array_mut).into_iter().flatten() {
        sphere["center"][2] = json!(height - number(&sphere["center"][2]));
    }
}
