//! Derivatives of the far field with respect to an index η = n + iκ.
//!
//! *Tangent*: (1 + A⁻¹V) u′ = r′ with r(η) = A⁻¹(b − M(η) u), differenced at fixed u; u is
//! holomorphic in η, so one solve gives d/dn and d/dκ = i d/dn of every amplitude, for the scalar
//! and for the vector wave. *Adjoint*: M(−q) w̃ = J g gives a weighted sum of efficiencies its
//! derivative with respect to any number of media.

use super::accuracy::AccuracyError;
use super::{Goal, Ledger, SolveError, Solver, Watch};
use crate::wave::{FarField, Field, Medium, Order, Problem, Side, System, WaveError};
use num_complex::Complex64;

/// Derivatives with respect to n and κ.
pub type Slopes = [f64; 2];

/// Derivatives of one order, which is that of the same place in the far field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderSlopes {
    /// Derivatives d/dη of the reflected and the transmitted amplitude, and of the crossed ones.
    pub amplitudes: [[Complex64; 2]; 2],
    /// Of the reflected efficiency.
    pub reflected: Slopes,
    /// Of the transmitted efficiency.
    pub transmitted: Slopes,
}

/// Derivatives of a far field with respect to one index.
#[derive(Clone, Debug, PartialEq)]
pub struct FarSlopes {
    /// Of every order, in the order of the far field.
    pub orders: Vec<OrderSlopes>,
    /// Of R.
    pub reflectance: Slopes,
    /// Of T.
    pub transmittance: Slopes,
    /// Of A: −d(R + T), as the discrete waves conserve energy. Differences of A itself would need
    /// steps far below the width of every guided resonance.
    pub absorptance: Slopes,
}

/// A system at a neighbouring index, and the step that leads to it. Steps are equally long and
/// evenly spread over the circle: ±h, or ±h and ±ih.
pub struct Neighbour {
    /// η of the system less η.
    pub step: Complex64,
    /// The system there.
    pub system: Box<dyn System>,
}

/// Derivatives of the far field of `u`, the solution of `system`, by one further solve.
///
/// # Errors
/// The strategy does not reach the goal.
pub fn tangent(
    system: &dyn System,
    u: &Field,
    neighbours: &[Neighbour],
    solver: &dyn Solver,
    goal: Goal,
    watch: &mut dyn Watch,
) -> Result<FarSlopes, SolveError> {
    let share = 1.0 / neighbours.len() as f64;
    let mut source = Field::zeros(system.shape());
    let mut residual = Field::zeros(system.shape());
    for Neighbour { step, system } in neighbours {
        system.residual(&system.background_wave(), u, &mut residual);
        source.scaled_add(share / step, &residual);
    }
    let slope = if source.iter().all(|z| z.norm_sqr() == 0.0) {
        source // nothing depends on this index
    } else {
        solver.run(Ledger::new(solver.name(), system, goal, watch).with_source(source), None)?.field
    };
    let moved = |n: &Neighbour| n.system.far_field(&(u + &slope.mapv(|z| n.step * z)));
    let moved: Vec<FarField> = neighbours.iter().map(moved).collect();
    let steps: Vec<Complex64> = neighbours.iter().map(|n| n.step).collect();
    Ok(slopes(&system.far_field(u), &moved, &steps))
}

/// Derivatives from far fields at neighbouring indices.
fn slopes(far: &FarField, moved: &[FarField], steps: &[Complex64]) -> FarSlopes {
    let share = 1.0 / steps.len() as f64;
    let along = |amplitude: &dyn Fn(&FarField) -> Complex64| -> Complex64 {
        moved.iter().zip(steps).map(|(far, step)| share * amplitude(far) / step).sum()
    };
    let slope = |k: usize, i: usize, side: usize| along(&|far| amplitude(&far.orders[k], i, side));
    let amplitudes = |k: usize| [0, 1].map(|i| [0, 1].map(|side| slope(k, i, side)));
    let of_order = |(k, order): (usize, &Order)| {
        let amplitudes = amplitudes(k);
        let reflected = efficiency(order, &amplitudes, 0);
        let transmitted = efficiency(order, &amplitudes, 1);
        OrderSlopes { amplitudes, reflected, transmitted }
    };
    let orders: Vec<OrderSlopes> = far.orders.iter().enumerate().map(of_order).collect();
    let total =
        |side: fn(&OrderSlopes) -> Slopes| [0, 1].map(|i| orders.iter().map(|o| side(o)[i]).sum::<f64>());
    let reflectance = total(|o| o.reflected);
    let transmittance = total(|o| o.transmitted);
    let absorptance = [0, 1].map(|i| -reflectance[i] - transmittance[i]);
    FarSlopes { orders, reflectance, transmittance, absorptance }
}

/// An amplitude of an order: own (0) or crossed (1) polarisation, reflected (0) or transmitted (1).
fn amplitude(order: &Order, polarisation: usize, side: usize) -> Complex64 {
    order.amplitudes().nth(polarisation).map_or(Complex64::ZERO, |pair| pair[side])
}

/// Derivatives of an efficiency: twice the real part of its flux factor times a* a′, with a′ times
/// i for κ. The flux factor is the efficiency over |a|².
fn efficiency(order: &Order, slopes: &[[Complex64; 2]; 2], side: usize) -> Slopes {
    let amplitudes = [0, 1].map(|i| amplitude(order, i, side));
    let power: f64 = amplitudes.iter().map(|a| a.norm_sqr()).sum();
    let efficiency = [order.reflected_efficiency, order.transmitted_efficiency][side];
    if power == 0.0 {
        return [0.0; 2];
    }
    let product: Complex64 = (0..2).map(|i| amplitudes[i].conj() * slopes[i][side]).sum();
    [2.0 * efficiency / power * product.re, -2.0 * efficiency / power * product.im]
}

/// The adjoint field of c_R R + c_T T, with `weights` = \[c_R, c_T\], for the solution `u`: its
/// product with ∂M/∂η u is the derivative, see [`sensitivity`].
///
/// # Errors
/// The strategy does not reach the goal, or the opposite direction is refused.
pub fn adjoint(
    problem: &Problem,
    u: &Field,
    weights: [f64; 2],
    solver: &dyn Solver,
    goal: Goal,
    watch: &mut dyn Watch,
) -> Result<Field, AccuracyError> {
    let reversed = problem.reversed()?;
    let mut source = Field::zeros(problem.shape());
    let last = problem.shape().0 - 1;
    let exit_first = usize::from(problem.incidence.from == Side::Exit);
    for (side, row) in [(0, 0), (1, last)] {
        for (i, kappa) in problem.kappa[side].iter().enumerate() {
            let weight = weights[side ^ exit_first] * kappa.re / problem.incident_kappa();
            let lit = side == exit_first && i == problem.incident_harmonic;
            source[[row, i]] += weight * (u[[row, i]] - if lit { 1.0 } else { 0.0 }).conj();
        }
    }
    let mut background = problem.opposite(&source);
    reversed.mean.inverse.solve(&mut background);
    let ledger = Ledger::new(solver.name(), &reversed, goal, watch).with_source(background);
    Ok(problem.opposite(&solver.run(ledger, None)?.field))
}

/// Derivatives with respect to n and κ of one medium from the [`adjoint`] field of a functional.
///
/// # Errors
/// A neighbouring index is refused.
pub fn sensitivity(
    problem: &Problem,
    u: &Field,
    adjoint: &Field,
    medium: Medium,
) -> Result<Slopes, WaveError> {
    let moved = problem.derivative(u, medium)?;
    let z: Complex64 = -2.0 * adjoint.iter().zip(&moved).map(|(w, m)| w * m).sum::<Complex64>();
    Ok([z.re, -z.im])
}

#[cfg(test)]
#[path = "gradient_tests.rs"]
mod tests;
