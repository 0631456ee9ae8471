//! The prints of a study with their error bars, as they are published.

use super::ink::{InkError, InkOnPaper};
use super::on_paper::LayerOnPaper;
use super::prints::{InkCoverage, PrintNumbers, PrintTask, PrintedTint};
use super::uncertainty::{Shift, UNMOVED, Uncertainty};
use crate::appearance::bare_paper::PaperGeometry;
use crate::appearance::paper::PRINT_DEG;
use crate::appearance::paper_series::{AreaOptics, LayerOptics};
use crate::appearance::tristimulus::{Colorimeter, Guide};
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use serde::Serialize;
use std::f64::consts::FRAC_1_SQRT_2;

/// Prints on the study's paper.
#[derive(Clone, Debug, Serialize)]
pub struct Prints {
    /// Illuminant and observer of the colours.
    pub conditions: String,
    /// Directions of light and view.
    pub geometry: &'static str,
    /// One print each, from bare paper to the solid, for every condition and thickness.
    pub prints: Vec<PrintNote>,
}

/// A print with its errors.
#[derive(Clone, Debug, Serialize)]
pub struct PrintNote {
    /// Which print it is.
    #[serde(flatten)]
    pub print: PrintedTint,
    /// Thickness of a composed layer, µm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness_um: Option<f64>,
    /// As screens show it, `#rrggbb`.
    pub hex: String,
    /// L*, a*, b*.
    pub lab: [Estimate; 3],
    /// Coverage by Murray and Davies from Y.
    pub apparent_coverage: Option<Estimate>,
    /// Visual density over the paper, −log₁₀(Y/Y of the paper).
    pub density: Estimate,
    /// Of an overprint of solids: its density over the sum of those of its inks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub additivity: Option<Estimate>,
    /// Coverage with the physical gain, less the nominal one.
    pub physical_gain: f64,
    /// Coverage by Murray and Davies, less that with the physical gain: what spreading adds.
    pub optical_gain: Option<Estimate>,
    /// n of Yule and Nielsen that would give Y of this print.
    pub yule_nielsen: Option<f64>,
    /// Radiance factor at every wavelength of the study; above 1 where the paper emits.
    pub factors: Vec<Estimate>,
}

impl PrintNote {
    /// Condition and coverage in words.
    pub fn name(&self) -> String {
        let of_ink =
            |ink: &InkCoverage| format!("{} {:.4} %", ink.name, 100.0 * ink.coverage).replace(".0000", "");
        let inks: Vec<String> = self.print.inks.iter().filter(|ink| ink.coverage > 0.0).map(of_ink).collect();
        let what = match self.print.nominal {
            _ if !inks.is_empty() => inks.join(", "),
            0.0 => "bare paper".to_owned(),
            1.0 => "solid".to_owned(),
            nominal => format!("{:.4} %", 100.0 * nominal).replace(".0000", ""),
        };
        self.print.condition.map_or(what.clone(), |condition| format!("{}, {what}", condition.name()))
    }
}

impl PrintTask<'_> {
    /// Prints with their errors.
    pub(super) fn notes(
        &self,
        thickness_um: Option<f64>,
        numbers: &[PrintNumbers<f64>],
        with_errors: &[PrintNumbers<Estimate>],
    ) -> Vec<PrintNote> {
        let n = self.yule_nielsen(numbers);
        let mut notes = Vec::new();
        for (k, print) in self.prints.iter().enumerate() {
            if !numbers[k].xyz.iter().all(|number| number.is_finite()) {
                continue;
            }
            let [r, g, b] = self.eye.colour_of(numbers[k].xyz).srgb8;
            let bars = &with_errors[k];
            let is_tint = print.nominal > 0.0 && print.nominal < 1.0;
            let apparent = Some(bars.apparent).filter(|apparent| is_tint && apparent.value.is_finite());
            notes.push(PrintNote {
                print: print.clone(),
                thickness_um,
                hex: format!("#{r:02x}{g:02x}{b:02x}"),
                lab: bars.lab,
                apparent_coverage: apparent,
                density: bars.density,
                additivity: Some(bars.additivity).filter(|additivity| additivity.value.is_finite()),
                physical_gain: print.coverage - print.nominal,
                optical_gain: apparent
                    .map(|apparent| Estimate { value: apparent.value - print.coverage, ..apparent }),
                yule_nielsen: n[k].filter(|_| is_tint),
                factors: bars.factors.clone(),
            });
        }
        notes
    }

    /// What the wavelengths leave open of L*, a*, b* of a print with these factors; `films` are as
    /// of [`Colorimeter::spacing_of_films`].
    pub(super) fn between_wavelengths(&self, factors: &[f64], films: Option<&[Guide; 2]>) -> [f64; 3] {
        open_between(&self.eye, self.seen(factors), films)
    }
}

/// What the wavelengths leave open of L*, a*, b* of a spectrum at those of the eye; `films` are as
/// of [`Colorimeter::spacing_of_films`].
pub(super) fn open_between(eye: &Colorimeter, seen: &[f64], films: Option<&[Guide; 2]>) -> [f64; 3] {
    let Ok(xyz) = eye.xyz(seen) else { return [0.0; 3] };
    let mut shifts = eye.spacing_of_films(seen, xyz, films);
    shifts.extend(eye.beyond(seen, xyz));
    std::array::from_fn(|c| shifts.iter().fold(0.0, |sum: f64, shift| sum.hypot(shift[c])))
}

/// The prints of an ink that is solved as a whole; `None` where there is only a solid on plain
/// paper.
///
/// # Errors
/// None: 45° and 0° are within the hemisphere.
pub(super) fn ink_prints(
    study: &Study,
    ink: &InkOnPaper,
    uncertainty: &Uncertainty,
) -> Result<Option<Prints>, InkError> {
    let Some(task) = PrintTask::new(study) else { return Ok(None) };
    let light = ink.at(PRINT_DEG)?;
    let view = ink.at(0.0)?;
    let optics = |layer: &LayerOnPaper, by: Shift| moved_optics(layer.optics(&light, &view), layer, by);
    let areas = |layers: &[LayerOnPaper], by: &dyn Fn(&LayerOnPaper) -> Shift| -> Vec<AreaOptics> {
        layers.iter().map(|layer| optics(layer, by(layer))).collect()
    };
    let unmoved = areas(ink.layers(), &|_| UNMOVED);
    let whole = task.numbers(&unmoved);
    let replicates: Vec<_> =
        ink.layers_of_replicates().map(|l| task.numbers(&areas(l, &|_| UNMOVED))).collect();
    let mut moved = uncertainty.moved(ink, |by| Ok(task.numbers(&areas(ink.layers(), by))))?;
    let of_others = beside(&task, &unmoved, |layer| &layer.replicates);
    moved.extend(beside(&task, &unmoved, |layer| &layer.moved).into_iter().flatten());
    let scaled = moved.len();
    moved.extend(moved_by_inputs(ink, &unmoved, |layer| optics(layer, UNMOVED)).map(|o| task.numbers(&o)));
    let coarse = task.coarsely_excited(&unmoved);
    let mut bars = Vec::new();
    for (k, print) in whole.iter().enumerate() {
        let open = task.between_wavelengths(&print.factors, None);
        let excited = |get: &dyn Fn(&PrintNumbers<f64>) -> f64| {
            coarse.as_ref().map_or(0.0, |coarse| (get(&coarse[k]) - get(print)) / 3.0)
        };
        let estimate = |get: &dyn Fn(&PrintNumbers<f64>) -> f64, open: f64| {
            let value = get(print);
            let without_each: Vec<f64> = replicates.iter().map(|all| get(&all[k])).collect();
            // every table is moved to both sides
            let weight = |i: usize| if i < scaled { 1.0 } else { FRAC_1_SQRT_2 };
            let by_parts = moved.iter().enumerate().map(|(i, all)| weight(i) * (get(&all[k]) - value));
            let chances = of_others.iter().filter_map(|replicates| {
                let without_each: Vec<f64> = replicates.iter().map(|all| get(&all[k])).collect();
                Estimate::jackknife(value, &without_each).standard_error
            });
            let shared = by_parts.chain(chances).chain([excited(get)]).fold(open, f64::hypot);
            uncertainty.widen(Estimate::jackknife(value, &without_each), shared)
        };
        bars.push(PrintNumbers {
            lab: std::array::from_fn(|c| estimate(&|print| print.lab[c], open[c])),
            xyz: std::array::from_fn(|c| estimate(&|print| print.xyz[c], 0.0)),
            apparent: estimate(&|print| print.apparent, 0.0),
            density: estimate(&|print| print.density, 0.0),
            additivity: estimate(&|print| print.additivity, 0.0),
            factors: (0..print.factors.len()).map(|w| estimate(&|print| print.factors[w], 0.0)).collect(),
        });
    }
    let prints = task.notes(None, &whole, &bars);
    Ok(Some(Prints { conditions: task.viewing.clone(), geometry: PaperGeometry::LitAt45.name(), prints }))
}

/// Prints with the layer of one other run after the other changed in each of its ways.
pub(super) fn beside(
    task: &PrintTask,
    layer: &[AreaOptics],
    changed: impl Fn(&LayerOptics) -> &Vec<Vec<AreaOptics>>,
) -> Vec<Vec<Vec<PrintNumbers<f64>>>> {
    let whole: Vec<&[AreaOptics]> = task.others().iter().map(|other| other.whole.as_slice()).collect();
    let of_other = |(number, other): (usize, &LayerOptics)| {
        let with = |rows: &Vec<AreaOptics>| {
            let mut others = whole.clone();
            others[number] = rows.as_slice();
            task.numbers_beside(layer, &others)
        };
        changed(other).iter().map(with).collect()
    };
    task.others().iter().enumerate().map(of_other).collect()
}

/// An ink that is solved as a whole, at 45:0, as prints of other studies take it.
///
/// # Errors
/// None: 45° and 0° are within the hemisphere.
pub(super) fn ink_optics(
    study: &Study,
    ink: &InkOnPaper,
    uncertainty: &Uncertainty,
) -> Result<LayerOptics, InkError> {
    let light = ink.at(PRINT_DEG)?;
    let view = ink.at(0.0)?;
    let areas = |layers: &[LayerOnPaper], by: &dyn Fn(&LayerOnPaper) -> Shift| -> Vec<AreaOptics> {
        layers.iter().map(|layer| moved_optics(layer.optics(&light, &view), layer, by(layer))).collect()
    };
    let whole = areas(ink.layers(), &|_| UNMOVED);
    let mut moved = uncertainty.moved(ink, |by| Ok(areas(ink.layers(), by)))?;
    let by_inputs = moved_by_inputs(ink, &whole, |layer| layer.optics(&light, &view));
    // every table is moved to both sides
    moved.extend(by_inputs.map(|all| {
        let part = |(there, here): (AreaOptics, &AreaOptics)| AreaOptics {
            own: here.own + FRAC_1_SQRT_2 * (there.own - here.own),
            entering: here.entering + FRAC_1_SQRT_2 * (there.entering - here.entering),
            leaving: here.leaving + FRAC_1_SQRT_2 * (there.leaving - here.leaving),
            lost: here.lost + FRAC_1_SQRT_2 * (there.lost - here.lost),
        };
        all.into_iter().zip(&whole).map(part).collect()
    }));
    Ok(LayerOptics {
        index_out: study.layer.index_out,
        wavelengths_nm: study.wavelengths_nm.clone(),
        replicates: ink.layers_of_replicates().map(|layers| areas(layers, &|_| UNMOVED)).collect(),
        whole,
        moved,
    })
}

/// A layer's optics where R and T are off by this.
fn moved_optics(here: AreaOptics, layer: &LayerOnPaper, [r, t]: Shift) -> AreaOptics {
    AreaOptics {
        own: here.own + r,
        entering: here.entering + t,
        leaving: here.leaving + t / layer.index_out.powi(2),
        lost: here.lost - r,
    }
}

/// The layer with every table of indices moved by its error.
fn moved_by_inputs(
    ink: &InkOnPaper,
    unmoved: &[AreaOptics],
    optics: impl Fn(&LayerOnPaper) -> AreaOptics,
) -> impl Iterator<Item = Vec<AreaOptics>> {
    let changes =
        |part: fn(&AreaOptics) -> f64| ink.input_changes(0..unmoved.len(), |layer| part(&optics(layer)));
    let own = changes(|area| area.own);
    let entering = changes(|area| area.entering);
    let leaving = changes(|area| area.leaving);
    let lost = changes(|area| area.lost);
    let moved = |k: usize| {
        let change = |(i, area): (usize, &AreaOptics)| AreaOptics {
            own: area.own + own[k][i],
            entering: area.entering + entering[k][i],
            leaving: area.leaving + leaving[k][i],
            lost: area.lost + lost[k][i],
        };
        unmoved.iter().enumerate().map(change).collect()
    };
    (0..own.len()).map(moved).collect::<Vec<_>>().into_iter()
}
