//! What an answer is worth: its largest error, or why it has none.

use super::protocol::AnsweredSide::{Reflected, Transmitted};
use super::protocol::{Answer, AnsweredAmplitude, AnsweredOrder, AnsweredSide, quoted};
use crate::wave::{FarField, Order};
use num_complex::Complex64;
use std::collections::HashMap;

/// An order that propagates, as it is expected of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedOrder {
    /// Index along x.
    pub m: i32,
    /// Index along y.
    pub n: i32,
    /// Where it leaves the layer.
    pub side: AnsweredSide,
    /// The amplitude of the scalar wave; of the vector wave s → s, s → p, p → s and p → p.
    pub amplitudes: Vec<Complex64>,
}

/// All orders that propagate, of the scalar wave or of s and p light.
pub fn expected(truth: &[FarField]) -> Vec<ExpectedOrder> {
    let mut all = Vec::new();
    for o in truth.first().iter().flat_map(|far| &far.orders) {
        let same = |far: &'_ FarField| far.orders.iter().find(|p| (p.m, p.n) == (o.m, o.n)).copied();
        let polarised: Vec<Order> = truth.iter().filter_map(same).collect();
        let sides = [(Reflected, o.reflected_propagates), (Transmitted, o.transmitted_propagates)];
        for (place, (side, _)) in sides.into_iter().enumerate().filter(|(_, (_, travels))| *travels) {
            all.push(ExpectedOrder { m: o.m, n: o.n, side, amplitudes: amplitudes(&polarised, place) });
        }
    }
    all
}

/// Amplitudes on one side, 0 reflected and 1 transmitted, of one order of every polarisation.
fn amplitudes(orders: &[Order], side: usize) -> Vec<Complex64> {
    let pair = |o: &Order| [0, 1].map(|k| o.amplitudes().nth(k).unwrap_or_default()[side]);
    match orders.iter().map(pair).collect::<Vec<_>>()[..] {
        [[ss, sp], [pp, ps]] => vec![ss, sp, ps, pp],
        ref one => one.iter().map(|pair| pair[0]).collect(),
    }
}

/// An answer that could be read: its orders, and what the program measured of itself.
#[derive(Clone, Debug, Default)]
pub struct ReadAnswer {
    orders: HashMap<(i32, i32, AnsweredSide), Vec<Complex64>>,
    /// The program's own seconds.
    pub seconds: Option<f64>,
}

impl ReadAnswer {
    /// Reads what a program printed for the case of a name.
    ///
    /// # Errors
    /// No JSON, a refusal, another case, orders that are twice there or not finite.
    pub fn of(output: &[u8], case: &str) -> Result<ReadAnswer, String> {
        let answer: Answer = serde_json::from_slice(output).map_err(|error| unreadable(output, &error))?;
        if let Some(reason) = answer.refusal {
            return Err(format!("refused: {}", quoted(&reason)));
        }
        if let Some(other) = answer.case.filter(|other| other != case) {
            return Err(format!("the answer is to another case, {:?} instead of {case:?}", quoted(&other)));
        }
        if let Some(seconds) = answer.seconds.filter(|s| !(s.is_finite() && *s >= 0.0)) {
            return Err(format!("`seconds` is {seconds}; allowed is a finite number from 0 on"));
        }
        let mut read = ReadAnswer { seconds: answer.seconds, ..ReadAnswer::default() };
        for order in answer.orders.ok_or("the answer has neither `orders` nor `refusal`")? {
            let AnsweredOrder { m, n, side, amplitude } = order;
            let amplitudes = numbers(&amplitude);
            if !amplitudes.iter().all(|a| a.is_finite()) {
                return Err(format!("the amplitude of order ({m}, {n}) is not finite"));
            }
            if read.orders.insert((m, n, side), amplitudes).is_some() {
                return Err(format!("order ({m}, {n}) is answered twice on one side"));
            }
        }
        Ok(read)
    }

    /// The largest error of any amplitude that is expected.
    ///
    /// # Errors
    /// Orders that are missing, or have amplitudes of the other wave.
    pub fn error(&self, expected: &[ExpectedOrder]) -> Result<f64, String> {
        let mut error = 0.0;
        for order in expected {
            let side = format!("{:?}", order.side).to_lowercase();
            let name = || format!("the {side} order ({}, {})", order.m, order.n);
            let found = self.orders.get(&(order.m, order.n, order.side));
            let found = found.ok_or_else(|| format!("{} propagates and is not answered", name()))?;
            let has = found.len();
            let needs = order.amplitudes.len();
            if has != needs {
                return Err(format!("{} has {has} complex amplitude(s) instead of {needs}", name()));
            }
            error = found.iter().zip(&order.amplitudes).map(|(a, b)| (a - b).norm()).fold(error, f64::max);
        }
        if error < f64::INFINITY { Ok(error) } else { Err("an amplitude is beyond all bounds".into()) }
    }
}

fn numbers(amplitude: &AnsweredAmplitude) -> Vec<Complex64> {
    let number = |[re, im]: [f64; 2]| Complex64::new(re, im);
    match amplitude {
        AnsweredAmplitude::Scalar(one) => vec![number(*one)],
        AnsweredAmplitude::Vector { s, p } => [s.s, s.p, p.s, p.p].map(number).to_vec(),
    }
}

fn unreadable(output: &[u8], error: &serde_json::Error) -> String {
    if output.is_empty() {
        return "the program answered nothing".into();
    }
    format!("the answer is not as `inkwave schema external` says: {error} in {:?}", words(output))
}

/// Characters of an answer that a reason quotes.
const QUOTED: usize = 60;

/// The beginning of some output, without what a terminal would act upon.
pub(super) fn words(output: &[u8]) -> String {
    quoted(&String::from_utf8_lossy(&output[..output.len().min(4 * QUOTED)])).chars().take(QUOTED).collect()
}
