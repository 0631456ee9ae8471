//! The scattering matrix is symmetric.

use crate::cells::{Cell, Direction, solve};
use crate::claim::{Claim, Findings, Level};
use inkwave::solve::Gmres;
use inkwave::wave::{FarField, Order, Side};
use num_complex::Complex64;

pub const CLAIM: Claim = Claim {
    id: "04-reciprocity",
    statement: "Light takes every way back: amplitudes from any order into any other are those of the reversed way.",
    because: "The scalar wave operator is complex symmetric, with and without absorption (Lorentz reciprocity), and so is its discrete form.",
    file: file!(),
    measure,
};

const TOLERANCE: f64 = 1e-11;

fn far_field(cell: &Cell, from: Direction) -> FarField {
    let problem = cell.problem(from);
    let field = solve(&Gmres::default(), &problem, TOLERANCE).expect("a small cell converges").field;
    problem.far_field(&field)
}

/// Polar and azimuth of light that comes in along a direction (k_x, k_y)/k₀, reversed, in a half-space of that index.
fn reversed(direction: [f64; 2], index: f64) -> [f64; 2] {
    let sine = direction[0].hypot(direction[1]) / index;
    [sine.asin().to_degrees(), (-direction[1]).atan2(-direction[0]).to_degrees()]
}

/// κ/k₀ of a direction in a half-space.
fn normal(direction: [f64; 2], index: f64) -> f64 {
    (index * index - direction[0].powi(2) - direction[1].powi(2)).sqrt()
}

/// Largest |κ_b a(b ← a) − κ_a a(−a ← −b)|/k₀ over the propagating orders of one direction of incidence.
fn asymmetry(cell: &Cell, from: Direction, most: usize) -> f64 {
    let forward = far_field(cell, from);
    let index = |side: Side| if side == Side::Incident { 1.0 } else { 1.3 };
    let entry = from.2;
    let exit = if from.2 == Side::Incident { Side::Exit } else { Side::Incident };
    let incident = forward.specular().direction;
    let both = |o: &Order| {
        [(o.reflected_propagates, o.reflected, entry), (o.transmitted_propagates, o.transmitted, exit)]
    };
    let mut largest = 0.0f64;
    for order in
        forward.orders.iter().filter(|o| o.transmitted_propagates || o.reflected_propagates).take(most)
    {
        for (propagates, amplitude, side) in both(order) {
            // Within 1° of grazing the angle no longer says the direction to the digits needed.
            if !propagates || normal(order.direction, index(side)) < 0.02 {
                continue;
            }
            let [polar, azimuth] = reversed(order.direction, index(side));
            let backward = far_field(cell, (polar, azimuth, side));
            let back: Option<Complex64> = backward
                .orders
                .iter()
                .find(|o| (o.m, o.n) == (order.m, order.n))
                .map(|o| if side == entry { o.reflected } else { o.transmitted });
            let back =
                back.unwrap_or_else(|| panic!("order ({}, {}) is missing on the way back", order.m, order.n));
            let there = normal(order.direction, index(side));
            let here = normal(incident, index(entry));
            largest = largest.max((there * amplitude - here * back).norm());
        }
    }
    largest
}

fn measure(level: Level, findings: &mut Findings) {
    let directions: &[Direction] = level.pick(
        &[(30.0, 25.0, Side::Incident)],
        &[
            (0.0, 0.0, Side::Incident),
            (30.0, 25.0, Side::Incident),
            (55.0, 70.0, Side::Exit),
            (75.0, 0.0, Side::Incident),
        ],
    );
    for (kappa, points) in [(0.0, [11, 9]), (0.1, [12, 10])] {
        let cell = Cell::new(kappa, points, 6);
        let error =
            directions.iter().map(|&d| asymmetry(&cell, d, level.pick(6, usize::MAX))).fold(0.0, f64::max);
        findings.identity(
            format!("κ = {kappa}, {} × {} points", points[0], points[1]),
            error,
            100.0 * TOLERANCE,
            "the residual 1e-11 of two solves, amplified by trapped waves, and the angles' rounding",
        );
    }
}
