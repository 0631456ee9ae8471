//! A composed layer as prints of other studies take it: what light between the layer and its paper
//! meets, with its errors.
//!
//! All errors are changes of whole spectra, so that a print of several layers moves as a whole:
//! what every realisation contributes, the grid, the directions, composing, and tables of indices.

use super::errors::{HALVED, MovedLevels, THINNED};
use super::level::{Change, Level};
use super::numbers::LayerTask;
use crate::appearance::paper_series::{AreaOptics, LayerOptics};
use std::f64::consts::FRAC_1_SQRT_2;

/// A layer at every wavelength.
type OpticsRows = Vec<AreaOptics>;

/// The layer of the first thickness, from slabs of h and of h/2 (`levels`); `None` where a stack
/// lacks a portion.
pub(super) fn layer_optics(
    task: &LayerTask,
    [whole, half]: [&Level; 2],
    tables: Option<&MovedLevels>,
) -> Option<LayerOptics> {
    let um = *task.composed.thicknesses_um.first()?;
    let here = task.optics(whole, Change::default(), um)?;
    let of_whole = contributions(task, whole, um)?;
    let of_half = contributions(task, half, um)?;
    let halved = task.optics(half, Change::default(), um)?;
    let mut moved: Vec<OpticsRows> = of_whole.iter().map(|by| plus(&here, by, 1.0)).collect();
    for change in
        [Change { grid: true, ..Change::default() }, Change { fewer_directions: true, ..Change::default() }]
    {
        moved.push(task.optics(whole, change, um)?);
    }
    let thinned = Change { without_highest_moment: true, ..Change::default() };
    let by_moments = less(&task.optics(whole, thinned, um)?, &here);
    moved.push(plus(&here, &by_moments, 1.0 / THINNED));
    let by_halving = less(&halved, &here);
    let chance: f64 = of_whole.iter().chain(&of_half).map(|by| square(by)).sum();
    let change = square(&by_halving);
    // of what halving changes, the part that chance does not explain
    let beyond = if change > 0.0 { (1.0 - chance / change).max(0.0).sqrt() } else { 0.0 };
    moved.push(plus(&here, &by_halving, beyond / HALVED));
    for by in by_tables(task, tables, um)? {
        moved.push(plus(&here, &by, FRAC_1_SQRT_2));
    }
    Some(LayerOptics {
        index_out: task.study.layer.index_out,
        wavelengths_nm: task.study.wavelengths_nm.clone(),
        whole: here,
        replicates: Vec::new(),
        moved,
    })
}

/// What each realisation of each portion contributes: the roots of the sums of their squares are
/// the jackknife's standard errors.
fn contributions(task: &LayerTask, level: &Level, thickness_um: f64) -> Option<Vec<OpticsRows>> {
    let mut all = Vec::new();
    for (portion, count) in level.realisations().into_iter().enumerate().filter(|(_, count)| *count > 1) {
        let without = |r: usize| {
            let change = Change { left_out: Some([portion, r]), ..Change::default() };
            task.optics(level, change, thickness_um)
        };
        let replicates = (0..count).map(without).collect::<Option<Vec<OpticsRows>>>()?;
        let n = count as f64;
        let nothing =
            vec![AreaOptics { own: 0.0, entering: 0.0, leaving: 0.0, lost: 0.0 }; replicates[0].len()];
        let mean = replicates.iter().fold(nothing, |sum, rows| plus(&sum, rows, 1.0 / n));
        let weight = ((n - 1.0) / n).sqrt();
        all.extend(replicates.iter().map(|rows| scaled(&less(rows, &mean), weight)));
    }
    Some(all)
}

/// Changes by every move of a table of indices, to both sides.
fn by_tables(task: &LayerTask, tables: Option<&MovedLevels>, thickness_um: f64) -> Option<Vec<OpticsRows>> {
    let Some(tables) = tables else { return Some(Vec::new()) };
    let unmoved = task.optics(&tables.unmoved, Change::default(), thickness_um)?;
    let change = |(study, level): &(_, Level)| {
        let there = task.of_study(study).ok()?.optics(level, Change::default(), thickness_um)?;
        Some(less(&there, &unmoved))
    };
    tables.moved.iter().map(change).collect()
}

/// OpticsRows plus a multiple of others.
fn plus(rows: &[AreaOptics], by: &[AreaOptics], weight: f64) -> OpticsRows {
    let sum = |(here, by): (&AreaOptics, &AreaOptics)| AreaOptics {
        own: here.own + weight * by.own,
        entering: here.entering + weight * by.entering,
        leaving: here.leaving + weight * by.leaving,
        lost: here.lost + weight * by.lost,
    };
    rows.iter().zip(by).map(sum).collect()
}

fn less(rows: &[AreaOptics], others: &[AreaOptics]) -> OpticsRows {
    plus(rows, others, -1.0)
}

fn scaled(rows: &[AreaOptics], weight: f64) -> OpticsRows {
    plus(rows, rows, weight - 1.0)
}

/// Sum of the squares of all that rows hold.
fn square(rows: &[AreaOptics]) -> f64 {
    let of =
        |row: &AreaOptics| [row.own, row.entering, row.leaving, row.lost].map(|x| x * x).iter().sum::<f64>();
    rows.iter().map(of).sum()
}
