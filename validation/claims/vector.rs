//! Maxwell's equations: the vector references at the accuracy asked for, and what the normal-field tensor is for.

use crate::claim::{Claim, Findings, Level, Table, short};
use crate::support::fitted_slope;
use crate::vector::{reference, references, solve, solve_as, solve_to};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::wave::Mean;
use inkwave::wave::maxwell::Averaging;

/// Accuracy in both polarisations.
pub const ACCURACY: Claim = Claim {
    id: "19-vector-references",
    statement: "Maxwell's equations: every amplitude in s and p is as accurate as asked, 1e-3 (nightly 1e-4) in ink, 1e-3 for indices up to 2.5, 5e-3 for 2.6; films are exact.",
    because: "Multilayers in 60 digits, finite elements, coupled waves and vector multipoles, made by methods that share nothing with this one.",
    file: file!(),
    measure: accuracy,
};

/// What the tensor is for.
pub const TENSOR: Claim = Claim {
    id: "20-normal-tensor",
    statement: "With the normal-field tensor errors across curved surfaces fall with order 3 in the plane, with plain averaging with order 1; energy is kept to the residual by both.",
    because: "E jumps across a surface and εE along its normal does not (Li, J. Opt. Soc. Am. A 13 (1996) 1870): a product of two jumps converges like the spacing, of one jump and a continuous field like its third power. Energy balance needs only a symmetric tensor, so it proves nothing about the order.",
    file: file!(),
    measure: tensor,
};

/// Cases of an ink's contrast, |η − 1.558| ≤ 0.25.
const INK: [&str; 8] = ["vink01", "vink02", "vsph01", "vsph02", "vsph03", "vsph04", "vlam01", "vcyl01"];
/// Pigments far from that, and the accuracy promised for them.
const PIGMENTS: [(&str, f64); 3] = [("vcyl02", 1e-3), ("vlam02", 1e-3), ("vsph05", 5e-3)];

fn accuracy(level: Level, findings: &mut Findings) {
    let films = references().iter().filter(|r| r.case.scene.uniform_in_plane());
    let worst = films.map(|r| r.error(&solve(&r.case, 1, 24, 1e-6).far)).fold(0.0, f64::max);
    findings.identity("films, s and p", worst, 1e-11, "the mean medium is exact per harmonic; rounding");
    let mut table = Table {
        title: "The vector wave against its references".to_string(),
        columns: ["case", "asked", "error", "estimate", "points", "cells"].map(String::from).to_vec(),
        rows: Vec::new(),
    };
    let ink = level.pick(&[1e-3][..], &[1e-3, 1e-4][..]);
    let ink = ink.iter().flat_map(|&accuracy| INK.map(|id| (id, accuracy)));
    let pigments = level.pick(&PIGMENTS[..0], &PIGMENTS[..]).iter().copied();
    let mut covered = Vec::new();
    for (id, asked) in ink.chain(pigments) {
        let reference = reference(id);
        let solved = solve_to(&reference.case, asked).unwrap_or_else(|e| panic!("{id}: {e}"));
        let error = reference.error(&solved.far_fields);
        findings.promise(format!("{id} at {}", short(asked)), error, asked, "the accuracy asked for");
        covered.push(error <= solved.error_estimate);
        let r = solved.system().grid().resolution;
        let row = [id.to_string(), short(asked), short(error), short(solved.error_estimate)];
        table.rows.push(row.into_iter().chain([r.nx.to_string(), r.cells.to_string()]).collect());
    }
    findings.tables.push(table);
    let missed = covered.iter().filter(|c| !**c).count() as f64 / covered.len() as f64;
    findings.promise("cases whose error exceeds its estimate", missed, 0.1, "nine of ten are covered");
}

fn tensor(level: Level, findings: &mut Findings) {
    let points: &[usize] = level.pick(&[9, 15, 21, 27], &[7, 9, 11, 15, 21, 27]);
    let mut curves = Vec::new();
    let orders = [
        ("normal-field tensor", Averaging::Normal, [2.5, 4.5], "3 ± the scatter of a line through few grids"),
        ("plain averaging", Averaging::Naive, [0.5, 1.5], "1 ± the scatter of a line through few grids"),
    ];
    for (name, averaging, range, because) in orders {
        let error = |&n: &usize| {
            let solved = solve_as(&reference("vcyl01").case, n, 80, 1e-8, Mean::default(), averaging);
            (n as f64, reference("vcyl01").errors(&solved.far)[1][1])
        };
        let errors: Vec<(f64, f64)> = points.iter().map(error).collect();
        findings.order(format!("p on a cylinder, {name}"), fitted_slope(&errors), range, because);
        curves.push(Curve::new(name, Style::Data, errors));
        let solved = solve_as(&reference("vsph05").case, 9, 12, 1e-10, Mean::default(), averaging);
        let balance = solved.far.iter().map(|far| far.energy_error().abs()).fold(0.0, f64::max);
        let because = "residual 1e-10, amplified some hundred times at index 2.6";
        findings.identity(format!("energy of a lossless cell, {name}"), balance, 1e-8, because);
    }
    let title = "Error of p light on a cylinder";
    findings.plots.push(Chart::log_log(title, "points per period", "largest amplitude error", curves));
}
