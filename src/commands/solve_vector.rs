//! The report of `inkwave solve --wave vector`: orders in both polarisations, as JSON.

use inkwave::run::crew::processor_seconds;
use inkwave::solve::accuracy::Estimated;
use inkwave::solve::accuracy::discretisation::joint_account;
use inkwave::wave::maxwell::{NormalMoments, VectorOrder};
use num_complex::Complex64;
use serde_json::{Value, json};

/// Everything that the scalar report has, with totals by incident polarisation.
pub fn report(e: &Estimated<NormalMoments>) -> Value {
    let (far, grid, account) = (&e.far_field, &e.problem.moments.grid, joint_account(&e.solution));
    let (rows, harmonics) = e.problem.shape();
    let (unknowns, bytes) = (rows * harmonics, e.problem.bytes() + account.bytes);
    json!({
        "wave": "vector",
        "orders": far.orders.iter().map(order).collect::<Vec<_>>(),
        "R_total": total(far.reflectance),
        "T_total": total(far.transmittance),
        "A_total": total(far.absorptance),
        "error_estimate": e.error_estimate,
        "error_estimate_parts": { "plane": e.parts[0], "z": e.parts[1] },
        "energy_error": total(far.energy_error()),
        "solver": account.solver,
        "residual": account.residual,
        "steps": by_polarisation([0, 1].map(|i| e.solution[i].account.steps)),
        "operator_applications": account.operator_applications,
        "seconds": account.seconds,
        "seconds_setup": e.seconds_setup,
        "seconds_estimate": e.seconds_estimate,
        "unknowns": unknowns,
        "process_seconds": processor_seconds(),
        "bytes": bytes,
        "bytes_per_unknown": bytes as f64 / unknowns as f64,
        "resolution": super::solve::resolution_of(grid, 2 * grid.cells()),
        "version": env!("CARGO_PKG_VERSION"),
    })
}

/// s, p, and their mean: unpolarised light.
fn total([s, p]: [f64; 2]) -> Value {
    json!({ "s": s, "p": p, "unpolarised": 0.5 * (s + p) })
}

fn by_polarisation<T: serde::Serialize>([s, p]: [T; 2]) -> Value {
    json!({ "s": s, "p": p })
}

/// Amplitudes by incident, then by outgoing polarisation.
fn pairs(amplitudes: [[Complex64; 2]; 2]) -> Value {
    by_polarisation(amplitudes.map(|out| by_polarisation(out.map(|a| [a.re, a.im]))))
}

fn order(o: &VectorOrder) -> Value {
    json!({
        "m": o.m,
        "n": o.n,
        "propagating": o.reflected_propagates || o.transmitted_propagates,
        "propagating_R": o.reflected_propagates,
        "propagating_T": o.transmitted_propagates,
        "R": pairs(o.reflected),
        "T": pairs(o.transmitted),
        "eff_R": by_polarisation(o.reflected_efficiency),
        "eff_T": by_polarisation(o.transmitted_efficiency),
    })
}
