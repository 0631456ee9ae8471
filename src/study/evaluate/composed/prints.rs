//! The prints of a composed layer, as they are published.

use super::between::Fringes;
use super::level::{Change, Level};
use super::numbers::LayerTask;
use crate::appearance::bare_paper::PaperGeometry;
use crate::appearance::paper_series::AreaOptics;
use crate::evaluate::printed::{Prints, beside};
use crate::evaluate::prints::{PrintNumbers, PrintTask};
use crate::evaluate::published::ErrorParts;
use crate::evaluate::quantities::{LayerNumbers, ThicknessNumbers};
use crate::numerics::estimate::Estimate;
use std::collections::HashMap;

/// The prints of layers of some thicknesses, µm, whose numbers have their bars; `None` where there
/// is only a solid on plain paper.
pub(super) fn prints(
    task: &LayerTask,
    layers: &[(f64, &ThicknessNumbers<ErrorParts>)],
    level: &Level,
) -> Option<Prints> {
    let of_layer = task;
    let task = task.prints.as_ref()?;
    let mut prints = Vec::new();
    for (um, layer) in layers {
        let beside = of_others(task, || of_layer.optics(level, Change::default(), *um));
        // of the solid under the light of a print
        let fringes_of = |solid: usize| {
            let seen = layer.spectra.iter().zip(&layer.prints[solid].factors).map(|(row, factor)| {
                LayerNumbers { lit_at_45: factor.value, ..row.map(|number| number.value) }
            });
            of_layer.films(*um).fringes(&of_layer.study.wavelengths_nm, &seen.collect::<Vec<_>>())
        };
        let mut fringes: HashMap<usize, Option<Fringes>> = HashMap::new();
        let mut plain: Vec<PrintNumbers<f64>> = Vec::new();
        let mut bars: Vec<PrintNumbers<Estimate>> = Vec::new();
        for (k, print) in layer.prints.iter().enumerate() {
            let values = print.clone().map(&|parts: ErrorParts| parts.value);
            let mut estimates = print.clone().map(&|parts: ErrorParts| parts.estimate());
            let share = task.prints[k].share_of_layer();
            let solid = task.solid_of(k);
            let films = fringes.entry(solid).or_insert_with(|| fringes_of(solid)).as_ref();
            let films = films.map(|fringes| fringes.of_print(of_layer.visible.clone(), share));
            let open = task.between_wavelengths(&values.factors, films.as_ref());
            let paper = task.open_of_paper(k);
            for (c, lab) in estimates.lab.iter_mut().enumerate() {
                let beside = open[c].hypot(paper[c]);
                lab.standard_error = lab.standard_error.map(|error| error.hypot(beside));
            }
            if let Some(variances) = beside.get(k) {
                estimates = estimates.zipped(variances.clone(), &|estimate, variance: f64| Estimate {
                    standard_error: estimate.standard_error.map(|error| error.hypot(variance.sqrt())),
                    ..estimate
                });
            }
            plain.push(values);
            bars.push(estimates);
        }
        prints.extend(task.notes(Some(*um), &plain, &bars));
    }
    Some(Prints { conditions: task.viewing.clone(), geometry: PaperGeometry::LitAt45.name(), prints })
}

/// Variances of all prints by the layers of other runs that some areas bear; none without such.
fn of_others(task: &PrintTask, layer: impl FnOnce() -> Option<Vec<AreaOptics>>) -> Vec<PrintNumbers<f64>> {
    let Some(layer) = (!task.others().is_empty()).then(layer).flatten() else { return Vec::new() };
    let whole = task.numbers(&layer);
    let mut variances: Vec<PrintNumbers<f64>> =
        whole.iter().map(|print| print.clone().map(&|_| 0.0)).collect();
    let mut add = |centre: &[PrintNumbers<f64>], changed: &[PrintNumbers<f64>], weight: f64| {
        for ((sum, there), here) in variances.iter_mut().zip(changed).zip(centre) {
            let square = there.clone().zipped(here.clone(), &|there, here| weight * (there - here).powi(2));
            *sum = sum.clone().zipped(square, &|sum, square: f64| sum + square);
        }
    };
    for replicates in beside(task, &layer, |layer| &layer.replicates).iter().filter(|all| all.len() > 1) {
        let n = replicates.len() as f64;
        let nothing: Vec<PrintNumbers<f64>> = whole.iter().map(|print| print.clone().map(&|_| 0.0)).collect();
        let mean = replicates.iter().fold(nothing, |mean, prints| {
            let sum = |(mean, print): (PrintNumbers<f64>, &PrintNumbers<f64>)| {
                mean.zipped(print.clone(), &|mean, print| mean + print / n)
            };
            mean.into_iter().zip(prints).map(sum).collect()
        });
        replicates.iter().for_each(|prints| add(&mean, prints, (n - 1.0) / n));
    }
    for moved in beside(task, &layer, |layer| &layer.moved).iter().flatten() {
        add(&whole, moved, 1.0);
    }
    variances
}
