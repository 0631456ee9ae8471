//! The result of `inkwave solve` as JSON: the same keys for both waves, the vector wave's values by
//! polarisation.

use inkwave::run::crew::processor_seconds;
use inkwave::solve::accuracy::Estimated;
use inkwave::wave::{FarField, Grid, Order, Resolution, Wave};
use num_complex::Complex64;
use serde_json::{Value, json};

/// Orders, totals, errors and costs of a solve.
pub fn report(e: &Estimated, wave: Wave) -> Value {
    let (account, unknowns) = (e.account(), e.system().unknowns());
    let bytes = e.system().bytes() + account.bytes;
    let steps: Vec<usize> = e.solved.iter().map(|s| s.solution.account.steps).collect();
    let orders = 0..e.far_field().orders.len();
    json!({
        "wave": if wave.is_vector() { "vector" } else { "scalar" },
        "orders": orders.map(|i| order(&e.far_fields, i)).collect::<Vec<_>>(),
        "R_total": total(e, |far| far.reflectance),
        "T_total": total(e, |far| far.transmittance),
        "A_total": total(e, |far| far.absorptance),
        "error_estimate": e.error_estimate,
        "error_estimate_parts": { "plane": e.parts[0], "z": e.parts[1] },
        "energy_error": total(e, FarField::energy_error),
        "solver": account.solver,
        "residual": account.residual,
        "steps": by_polarisation(&steps),
        "operator_applications": account.operator_applications,
        "seconds": account.seconds,
        "seconds_setup": e.seconds_setup,
        "seconds_estimate": e.seconds_estimate,
        "unknowns": unknowns,
        // User and system time of the whole process: reading, grid search, comparison solves and
        // this solve.
        "process_seconds": processor_seconds(),
        "bytes": bytes,
        "bytes_per_unknown": bytes as f64 / unknowns as f64,
        "resolution": resolution_of(e.system().grid(), wave),
        "version": env!("CARGO_PKG_VERSION"),
    })
}

/// The grid: points, cells and planes, also per µm.
fn resolution_of(grid: &Grid, wave: Wave) -> Value {
    let Resolution { nx, ny, cells, scheme } = grid.resolution;
    json!({
        "nx": nx,
        "ny": ny,
        "cells": cells,
        "planes": if wave.is_vector() { 2 * cells } else { grid.planes() },
        "scheme": scheme,
        "points_per_um": [nx as f64 / grid.period_um[0], ny as f64 / grid.period_um[1]],
        "planes_per_um": (scheme.degree() * cells) as f64 / grid.nodes_um[grid.cells()],
    })
}

/// The scalar wave's value, or those of s and p light.
pub(super) fn by_polarisation<T: serde::Serialize>(values: &[T]) -> Value {
    match values {
        [s, p] => json!({ "s": s, "p": p }),
        other => json!(other[0]),
    }
}

/// [`by_polarisation`] with the mean of s and p beside them: unpolarised light.
fn total(e: &Estimated, of: impl Fn(&FarField) -> f64) -> Value {
    let values: Vec<f64> = e.far_fields.iter().map(of).collect();
    let mut total = by_polarisation(&values);
    if let [s, p] = values[..] {
        total["unpolarised"] = (0.5 * (s + p)).into();
    }
    total
}

/// Amplitudes of one side (0 reflected, 1 transmitted), of the vector wave by incident, then by
/// outgoing polarisation.
fn amplitudes(orders: &[&Order], side: usize) -> Value {
    let pair = |a: Complex64| [a.re, a.im];
    let [own, crossed] =
        [0, 1].map(|k| orders.iter().map(move |o| o.amplitudes().nth(k).expect("four")[side]));
    let (own, crossed): (Vec<_>, Vec<_>) = (own.map(pair).collect(), crossed.map(pair).collect());
    match (&own[..], &crossed[..]) {
        ([ss, pp], [sp, ps]) => json!({ "s": { "s": ss, "p": sp }, "p": { "s": ps, "p": pp } }),
        _ => json!(own[0]),
    }
}

/// One order of all polarisations.
fn order(far_fields: &[FarField], index: usize) -> Value {
    let orders: Vec<&Order> = far_fields.iter().map(|far| &far.orders[index]).collect();
    let efficiency = |of: fn(&&Order) -> f64| by_polarisation(&orders.iter().map(of).collect::<Vec<_>>());
    let o = orders[0];
    json!({
        "m": o.m,
        "n": o.n,
        "propagating": o.reflected_propagates || o.transmitted_propagates,
        "propagating_R": o.reflected_propagates,
        "propagating_T": o.transmitted_propagates,
        "R": amplitudes(&orders, 0),
        "T": amplitudes(&orders, 1),
        "eff_R": efficiency(|o| o.reflected_efficiency),
        "eff_T": efficiency(|o| o.transmitted_efficiency),
    })
}
