//! Tables that others published.

use crate::claim::{Claim, Findings, Level, Table, short};
use crate::vector::solve_to;
use inkwave::input::case::Case;
use inkwave::wave::FarField;
use serde::Deserialize;
use serde_json::Value;

pub const CLAIM: Claim = Claim {
    id: "29-published-tables",
    statement: "Published tables of crossed gratings: every efficiency of Li's checkerboard and of his cylindrical pillars is met within what the tables themselves are worth.",
    because: "Tables computed elsewhere. Mirror images must be equal; by how much they differ in a table is a measure of its own error, which comes from its truncated orders.",
    file: file!(),
    measure,
};

/// One published table with its geometry; see validation/data/published.json.
#[derive(Deserialize)]
struct Published {
    id: String,
    inputs: Value,
    /// Side, polarisation, order and efficiency.
    efficiencies: Vec<(String, String, i32, i32, f64)>,
}

#[derive(Deserialize)]
struct File {
    tables: Vec<Published>,
}

fn measure(level: Level, findings: &mut Findings) {
    let text = include_str!("../data/published.json");
    let file: File = serde_json::from_str(text).expect("published.json lists tables");
    let accuracy = level.pick(2e-3, 5e-4);
    for table in file.tables {
        check(&table, accuracy, findings);
    }
}

fn check(table: &Published, accuracy: f64, findings: &mut Findings) {
    let id = &table.id;
    let case = Case::parse(&table.inputs.to_string(), false).unwrap_or_else(|e| panic!("{id}: {e}"));
    let solved = solve_to(&case, accuracy).unwrap_or_else(|e| panic!("{id}: {e}"));
    let mut rows = Vec::new();
    let mut worst = 0.0f64;
    let mut squares = 0.0f64;
    let mut asymmetry = 0.0f64;
    let mut own_asymmetry = 0.0f64;
    for entry in &table.efficiencies {
        let (side, polarisation, m, n, published) = entry;
        let own = efficiency(&solved.far_fields, side, polarisation, [*m, *n]);
        worst = worst.max((own - published).abs());
        squares += (own - published).powi(2);
        for (p, image) in images(id, polarisation, [*m, *n]) {
            let partner =
                table.efficiencies.iter().find(|e| (&e.0, e.1.as_str(), [e.2, e.3]) == (side, p, image));
            asymmetry = asymmetry.max(partner.map_or(0.0, |e| (e.4 - published).abs()));
            own_asymmetry = own_asymmetry.max((efficiency(&solved.far_fields, side, p, image) - own).abs());
        }
        let order = format!("{side} {polarisation} ({m}, {n})");
        rows.push(vec![order, published.to_string(), format!("{own:.6}"), short((own - published).abs())]);
    }
    // dη = 2 √η |dA| with η ≤ 0.18 and a flux factor up to the exit's index.
    let ours = 2.0 * (0.18f64 * 1.6).sqrt() * solved.error_estimate;
    // Half of the last digit of five.
    let allowed = asymmetry + ours + 5e-6;
    let rms = (squares / table.efficiencies.len() as f64).sqrt();
    let because = "mirror images in the table differ by this; our error estimate; half of the last digit";
    findings.promise(format!("{id}: rms difference, as a share"), rms / allowed, 1.0, because);
    let because = "three times that: errors that mirror images share do not show in their difference";
    findings.promise(format!("{id}: largest difference, as a share"), worst / (3.0 * allowed), 1.0, because);
    let because = "the amplitudes' error estimate: the grid and the cell have these mirrors";
    findings.promise(format!("{id}: mirror images here"), own_asymmetry, 2.0 * ours, because);
    let columns = ["order", "published", "here", "difference"].map(String::from).to_vec();
    findings.tables.push(Table { title: format!("{id}, error estimate {}", short(ours)), columns, rows });
}

/// The order that a mirror of the structure and its light carries this one into.
fn images<'a>(id: &str, polarisation: &'a str, [m, n]: [i32; 2]) -> Vec<(&'a str, [i32; 2])> {
    if id == "checkerboard" {
        let swapped = if polarisation == "s" { "p" } else { "s" };
        return vec![(polarisation, [-m, n]), (polarisation, [m, -n]), (swapped, [n, m])];
    }
    // The plane of incidence is a mirror of the hexagonal lattice: m₁ ↔ m₂ with (m, n) = (m₂, 2 m₁ − m₂).
    let m1 = (n + m) / 2;
    let m2 = m;
    vec![(polarisation, [m1, 2 * m2 - m1])]
}

fn efficiency(far: &[FarField], side: &str, polarisation: &str, [m, n]: [i32; 2]) -> f64 {
    let orders = &far[usize::from(polarisation == "p")].orders;
    let order = orders.iter().find(|o| (o.m, o.n) == (m, n)).unwrap_or_else(|| panic!("no order ({m}, {n})"));
    if side == "R" { order.reflected_efficiency } else { order.transmitted_efficiency }
}
