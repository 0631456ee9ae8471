//! Observed orders of convergence against the T-matrix references.

use crate::claim::{Claim, Findings, Level};
use crate::support::{fitted_slope, reference, solve_at};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::wave::Scheme;

pub const CLAIM: Claim = Claim {
    id: "07-orders",
    statement: "Errors fall with the orders that theory gives: 2, 4 and more across the layer, about 5 in the plane.",
    because: "Second differences and tents are of second order, Lobatto moments of degree p of order 2p until the grains' poles limit them; band-limited contrast with folding of the outer harmonics gives 5 in the plane (3 without).",
    file: file!(),
    measure,
};

const SCHEMES: [(&str, Scheme, [f64; 2]); 4] = [
    ("second differences", Scheme::SecondDifference, [1.7, 2.4]),
    ("tents", Scheme::Tents, [1.7, 2.4]),
    ("quadratic moments", Scheme::Quadratic, [3.5, 4.7]),
    // Where a pole falls within its cell varies from grid to grid and limits the order to 4 at last.
    ("cubic moments", Scheme::Cubic, [3.6, 6.0]),
];
const SCATTER: &str =
    "theory ± the scatter of a line through errors that depend on where poles fall within cells";

const LATERAL: &str = "5, seen with folded harmonics (3 without), ± the scatter of a line through few grids";

fn measure(level: Level, findings: &mut Findings) {
    across(level, findings);
    planes_saved(findings);
    in_the_plane(level, findings);
}

fn across(level: Level, findings: &mut Findings) {
    let cells: &[usize] = level.pick(&[8, 11, 16, 23], &[8, 11, 13, 16, 19, 23, 27, 32]);
    // The plane's own error is below 1e-6 with 48 points per µm.
    let points = level.pick(48, 57);
    let ink = reference("inka1");
    let mut curves = Vec::new();
    for (name, scheme, range) in SCHEMES {
        // Second differences leave their pre-asymptotic range late.
        let used = if scheme == Scheme::SecondDifference { &cells[1..] } else { cells };
        let error = |&n: &usize| {
            let solved = solve_at(&ink.case, ink.resolution(points, n, scheme), 1e-9);
            (n as f64, ink.largest_error(&solved.far))
        };
        let errors: Vec<(f64, f64)> = used.iter().map(error).collect();
        findings.order(format!("across, {name}"), fitted_slope(&errors), range, SCATTER);
        curves.push(Curve::new(name, Style::Data, errors));
    }
    // Quartic moments meet the references' and the plane's own errors within few grids: no slope, but never worse.
    let few = cells.len().min(3);
    let quartic = |&n: &usize| {
        let solved = solve_at(&ink.case, ink.resolution(points, n, Scheme::Quartic), 1e-9);
        (n as f64, ink.largest_error(&solved.far))
    };
    let errors: Vec<(f64, f64)> = cells[..few].iter().map(quartic).collect();
    let against_cubic = errors.iter().zip(&curves[3].points).map(|(q, c)| q.1 / c[1]).fold(0.0, f64::max);
    findings.order_of_smallness(
        "error of quartic over cubic moments",
        against_cubic,
        1.0,
        "a higher degree is never worse",
    );
    curves.push(Curve::new("quartic moments", Style::Data, errors));
    curves.push(Curve::guide("order 2", &curves[1], -2.0));
    curves.push(Curve::guide("order 4", &curves[2], -4.0));
    let title = "Error against cells, ink cell inka1";
    findings.plots.push(Chart::log_log(title, "cells across the layer N", "largest amplitude error", curves));
}

/// The claim behind the discretisation: with the same unknowns, a hundredth of the error and less.
fn planes_saved(findings: &mut Findings) {
    let ink = reference("inka1");
    let error =
        |scheme, cells| ink.largest_error(&solve_at(&ink.case, ink.resolution(24, cells, scheme), 1e-9).far);
    let ratio = error(Scheme::Cubic, 11) / error(Scheme::SecondDifference, 33);
    findings.promise(
        "error of cubic moments over second differences, 34 planes each",
        ratio,
        0.01,
        "what the exact scheme is for",
    );
}

fn in_the_plane(level: Level, findings: &mut Findings) {
    let cases: &[(&str, usize)] = level.pick(
        &[("inka1", 16), ("cyl01", 20)],
        &[("inka1", 20), ("sph10", 24), ("sph05", 24), ("cyl01", 24), ("inkb2", 20)],
    );
    let densities: &[f64] =
        level.pick(&[10.0, 12.0, 15.0, 18.0, 24.0], &[10.0, 12.0, 15.0, 18.0, 20.0, 24.0, 27.0]);
    let mut curves = Vec::new();
    for &(id, cells) in cases {
        let case = reference(id);
        let error = |per_um: &f64| {
            let points = (per_um * case.case.scene.period_um[0]).round() as usize;
            let solved = solve_at(&case.case, case.resolution(points, cells, Scheme::Quartic), 1e-9);
            (points as f64 / case.case.scene.period_um[0], case.largest_error(&solved.far))
        };
        let errors: Vec<(f64, f64)> = densities.iter().map(error).collect();
        findings.order(format!("plane, {id}"), fitted_slope(&errors), [3.5, 6.5], LATERAL);
        curves.push(Curve::new(id, Style::Data, errors));
    }
    curves.push(Curve::guide("order 5", &curves[0], -5.0));
    let title = "Error against points in the plane";
    findings.plots.push(Chart::log_log(title, "points per µm, 1/h", "largest amplitude error", curves));
}
