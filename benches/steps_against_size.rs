//! Operator applications of `krylov` against the cell's side: 30 % spheres of 250 nm, 1 µm thick, λ = 0.55 µm,
//! 12 points per µm and 9 cubic cells, residual 1e-6, with and without absorption and guided-mode correction.
//!
//! `cargo bench --bench steps_against_size [-- LARGEST_UM]` writes a table and a plot to reports/steps-against-size.

mod support;

use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::solve::{Gmres, Goal, GuidedModes, Silent, Solver};
use inkwave::wave::Mean;
use std::path::Path;

const SIDES: [f64; 6] = [1.2, 1.7, 2.4, 4.8, 7.0, 10.0];

fn main() {
    let largest = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(10.0);
    let settings =
        [("κ = 0.1", 0.1, true), ("κ = 0", 0.0, true), ("κ = 0, guided modes left alone", 0.0, false)];
    let mut curves: Vec<Curve> = settings.iter().map(|s| Curve::with_bars(s.0, Style::Data, [])).collect();
    let mut table = String::from("side_um,kappa,guided_modes,unknowns,applications,seconds\n");
    for side in SIDES.into_iter().filter(|&s| s <= largest) {
        let coverage = support::coverage(side, 1.0, 9);
        for ((_, kappa, guided), curve) in settings.iter().zip(&mut curves) {
            let problem = support::problem(&coverage, *kappa, Mean::default());
            let modes = GuidedModes { threshold: if *guided { 0.4 } else { 0.0 }, ..GuidedModes::default() };
            let solver = Gmres { guided_modes: modes, ..Gmres::default() };
            let account = solver.solve(&problem, Goal::default(), &mut Silent).expect("converges").account;
            let (steps, seconds) = (account.operator_applications, account.seconds);
            let line = format!("{side},{kappa},{guided},{},{steps},{seconds:.2}\n", problem.unknowns());
            print!("{line}");
            table += &line;
            curve.points.push([side, steps as f64, 0.0]);
        }
    }
    let line = [(1.2, 12.0), (largest, 10.0 * largest)];
    curves.push(Curve::new("proportional to the side", Style::Guide, line));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/steps-against-size");
    std::fs::create_dir_all(&folder).expect("a folder for the report");
    std::fs::write(folder.join("steps.csv"), table).expect("the table");
    let title = "krylov to 1e-6: work against the cell";
    let plot = Chart::log_log(title, "side of the cell, µm", "operator applications", curves);
    let png = plot.bitmap().expect("a plot").png(&[("Title", title)]).expect("a bitmap");
    std::fs::write(folder.join("steps.png"), png).expect("the plot's file");
}
