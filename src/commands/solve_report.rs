//! The result of `inkwave solve` as JSON: the same keys for both waves, the vector wave's values by
//! polarisation; and `inkwave solve --gradient`, derivatives of orders and totals with respect to
//! every index.

use inkwave::run::crew::processor_seconds;
use inkwave::solve::accuracy::{AccuracyError, Estimated, Solved, Task};
use inkwave::solve::gradient::{FarSlopes, Neighbour, Slopes, tangent};
use inkwave::solve::{Goal, Silent};
use inkwave::wave::{
    DIRECTIONS, FarField, Grid, Incidence, Media, Medium, Order, Resolution, Wave, WaveError,
};
use num_complex::Complex64;
use serde_json::{Value, json};

/// Light, orders, totals, errors and costs of a solve.
pub fn report(e: &Estimated, wave: Wave, light: &Incidence) -> Value {
    let account = e.account();
    let unknowns = e.system().unknowns();
    let bytes = e.system().bytes() + account.bytes;
    let steps: Vec<usize> = e.solved.iter().map(|s| s.solution.account.steps).collect();
    let orders = 0..e.far_field().orders.len();
    json!({
        "wave": wave_name(wave),
        // without the rounding of µm to nm
        "wavelength_nm": (1e12 * light.wavelength_um).round() / 1e9,
        "polar_deg": light.polar_deg,
        "azimuth_deg": light.azimuth_deg,
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
        "polarisations": if wave.is_vector() { POLARISATIONS } else { "none: the scalar wave" },
    })
}

/// The wave's name in the options.
pub(super) fn wave_name(wave: Wave) -> &'static str {
    if wave.is_vector() { "vector" } else { "scalar" }
}

/// What the keys of polarised amplitudes mean.
pub(super) const POLARISATIONS: &str = "R and T of an order by incident, then by outgoing polarisation: R.s.p is the amplitude of \
    the p light that leaves where s light of amplitude 1 arrives. All others by incident polarisation.";

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
fn total(e: &Estimated, share: impl Fn(&FarField) -> f64) -> Value {
    let values: Vec<f64> = e.far_fields.iter().map(share).collect();
    let mut total = by_polarisation(&values);
    if let [s, p] = values[..] {
        total["unpolarised"] = (0.5 * (s + p)).into();
    }
    total
}

/// Amplitudes of one side (0 reflected, 1 transmitted), of the vector wave by incident, then by
/// outgoing polarisation.
fn amplitudes(orders: &[&Order], side: usize) -> Value {
    let pairs = |k: usize| -> Vec<[f64; 2]> {
        let amplitudes = orders.iter().map(|o| o.amplitudes().nth(k).expect("four")[side]);
        amplitudes.map(|a| [a.re, a.im]).collect()
    };
    let same = pairs(0);
    let crossed = pairs(1);
    match (&same[..], &crossed[..]) {
        ([ss, pp], [sp, ps]) => json!({ "s": { "s": ss, "p": sp }, "p": { "s": ps, "p": pp } }),
        _ => json!(same[0]),
    }
}

/// One order of all polarisations.
fn order(far_fields: &[FarField], index: usize) -> Value {
    let orders: Vec<&Order> = far_fields.iter().map(|far| &far.orders[index]).collect();
    let efficiency = |lobe: fn(&&Order) -> f64| by_polarisation(&orders.iter().map(lobe).collect::<Vec<_>>());
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

/// Step in an index; the error of four neighbours is its fourth power.
const STEP: f64 = 1e-4;
/// Largest residual of the solutions that are differentiated.
const RESIDUAL: f64 = 1e-8;

/// In an absorbing half-space the fluxes of s and p light have different factors, which a far field
/// does not keep apart.
const ABSORBING_EXIT: WaveError = WaveError::NotInVectorMode {
    what: "the gradient with an absorbing half-space",
    reason: "the fluxes of s and p light into it are not kept apart",
    remedy: "give the half-space k = 0, leave out --gradient, or use the scalar wave",
};

/// The derivatives with respect to one medium, one entry for each polarisation.
pub struct Gradient {
    medium: Medium,
    index: Complex64,
    slopes: Vec<FarSlopes>,
}

/// Derivatives with respect to all media of a case, on the grid of its solution.
///
/// # Errors
/// A solve does not reach the residual.
pub fn gradients(task: &Task, e: &Estimated) -> Result<Vec<Gradient>, AccuracyError> {
    let Media { backgrounds, inclusions, .. } = task.media;
    let backgrounds = backgrounds.iter().enumerate().map(|(i, &index)| (Medium::Background(i), index));
    let inclusions = inclusions.iter().enumerate().map(|(i, &index)| (Medium::Inclusion(i), index));
    let goal = Goal { tolerance: task.goal.tolerance.min(RESIDUAL), ..task.goal };
    let task = Task { goal, ..*task };
    if e.system().polarisation().is_some()
        && [task.media.incident, task.media.exit].iter().any(|eta| eta.im > 0.0)
    {
        return Err(ABSORBING_EXIT.into());
    }
    let (sharper, _) = task.solve(e.system().grid().resolution, &mut Silent)?;
    let media = backgrounds.chain(inclusions);
    media
        .map(|(medium, index)| Ok(Gradient { medium, index, slopes: slopes(&task, &sharper, medium)? }))
        .collect()
}

/// Derivatives with respect to one medium, from solves with its index moved in four directions.
fn slopes(task: &Task, solved: &[Solved], medium: Medium) -> Result<Vec<FarSlopes>, AccuracyError> {
    let geometry = task.coverages.at(solved[0].system.grid().resolution)?;
    let mut moved = Vec::new();
    for step in DIRECTIONS.map(|direction| STEP * direction) {
        let systems = geometry.systems(&task.media.moved(medium, step), task.incidence, task.mean)?;
        moved.push((step, systems.into_iter()));
    }
    let mut slopes = Vec::new();
    for Solved { system, solution } in solved {
        let neighbours = moved.iter_mut();
        let neighbours: Vec<Neighbour> = neighbours
            .filter_map(|(step, systems)| Some(Neighbour { step: *step, system: systems.next()? }))
            .collect();
        let field = &solution.field;
        slopes.push(tangent(&**system, field, &neighbours, task.solver, task.goal, &mut Silent)?);
    }
    Ok(slopes)
}

impl Gradient {
    fn name(&self) -> String {
        match self.medium {
            Medium::Background(i) => format!("background {i}"),
            Medium::Inclusion(i) => format!("inclusion {i}"),
        }
    }

    /// As an entry of the result; `orders` are those of the first polarisation.
    pub fn json(&self, orders: &[Order]) -> Value {
        let total = |share: fn(&FarSlopes) -> Slopes| self.by_polarisation(|s| pair(share(s)));
        json!({
            "medium": self.name(),
            "index": [self.index.re, self.index.im],
            "R_total": total(|s| s.reflectance),
            "T_total": total(|s| s.transmittance),
            "A_total": total(|s| s.absorptance),
            "orders": orders.iter().enumerate().map(|(k, order)| self.order(k, order)).collect::<Vec<_>>(),
        })
    }

    fn order(&self, k: usize, order: &Order) -> Value {
        let amplitude = |side: usize| {
            self.by_polarisation(|s| {
                let z = s.orders[k].amplitudes[0][side];
                json!([z.re, z.im])
            })
        };
        json!({
            "m": order.m,
            "n": order.n,
            "R": amplitude(0),
            "T": amplitude(1),
            "eff_R": self.by_polarisation(|s| pair(s.orders[k].reflected)),
            "eff_T": self.by_polarisation(|s| pair(s.orders[k].transmitted)),
        })
    }

    fn by_polarisation(&self, entry: impl Fn(&FarSlopes) -> Value) -> Value {
        by_polarisation(&self.slopes.iter().map(entry).collect::<Vec<_>>())
    }

    /// The totals' derivatives as lines of a table.
    pub fn text(&self) -> String {
        let mut lines = format!("{} (n = {}, k = {})\n", self.name(), self.index.re, self.index.im);
        for (slopes, light) in self.slopes.iter().zip(["s", "p"]) {
            let light = if self.slopes.len() == 1 { "" } else { light };
            let totals = [("R", slopes.reflectance), ("T", slopes.transmittance), ("A", slopes.absorptance)];
            for (name, [dn, dk]) in totals {
                lines += &format!("  {name} {light:1}  d/dn {dn:+.8e}  d/dk {dk:+.8e}\n");
            }
        }
        lines
    }
}

fn pair([dn, dk]: Slopes) -> Value {
    json!({ "dn": dn, "dk": dk })
}
