//! The error bars of a composed layer's numbers.
//!
//! Every number is a function of the ensemble-mean flux matrices of all portions, so all of them
//! are evaluated again for every change of these, and compared name by name. The errors of tables
//! of indices are changes of whole slabs in a few realisations.

use super::level::{Change, Level};
use super::numbers::LayerTask;
use crate::evaluate::published::ErrorParts;
use crate::evaluate::quantities::{
    ColourNumbers, ComposedNumbers, DensityNumbers, Distribution, HidingNumbers, LayerNumbers,
    LeftOutNumbers, MediumNumbers, ThicknessNumbers,
};
use crate::input::study::Study;

/// Wavelengths on either side over which the squared error of composing is averaged: that error is
/// smooth, and chance is not.
const NEIGHBOURS: usize = 2;
/// What slabs of half the thickness change, over the error of whole ones, which is a third or less
/// of theirs.
// *Measured* on coherent stacks of 4 to 16 µm: 1.4 to 1.9 % with slabs of 1 µm, 0.4 to 0.6 % of
// 2 µm, at most 0.03 % of 4 µm.
pub(super) const HALVED: f64 = 2.0;
/// What scattered light changes without the highest moment that its directions resolve, over what
/// more directions would change.
// *Measured* with 5 + 5 in place of 3 + 3 directions in the same cells of five layers and stacks:
// at 45:0 a fifth of it in a white, in thin inks nothing beyond chance.
pub(super) const THINNED: f64 = 3.0;

/// The numbers of a layer from all realisations of a portion but one, for each of these.
pub type PortionReplicates = ComposedNumbers<Vec<f64>>;

/// All numbers with their bars, and the jackknife replicates behind their chance.
#[derive(Clone, Debug)]
pub struct JudgedNumbers {
    /// The numbers with the parts of their errors.
    pub numbers: ComposedNumbers<ErrorParts>,
    /// \[portion of whole slabs with more than one realisation\]
    pub replicates: Vec<PortionReplicates>,
}

/// Whole slabs of a few realisations, from which all errors due to tables of indices follow.
pub struct MovedLevels {
    /// As they are.
    pub unmoved: Level,
    /// With every move of a table by one standard error, to either side, and the study so moved.
    pub moved: Vec<(Study, Level)>,
}

/// All numbers with their bars: from slabs of h and of h/2 (`levels`).
///
/// # Errors
/// Those of [`LayerTask::new`].
pub fn with_errors(
    task: &LayerTask,
    levels: [&Level; 2],
    moved: Option<&MovedLevels>,
) -> Result<JudgedNumbers, String> {
    let of_inputs = moved.map(|moved| input_variances(task, moved)).transpose()?;
    Ok(judged(&|level, change| task.numbers(level, change), levels, of_inputs))
}

/// Numbers from the portions of one thickness, with what is changed of them.
pub type NumbersOf<'a> = &'a dyn Fn(&Level, Change) -> ComposedNumbers<f64>;

/// As [`with_errors`], of whatever is evaluated; `of_inputs` are variances due to tables of
/// indices.
pub fn judged(
    evaluated: NumbersOf,
    levels: [&Level; 2],
    of_inputs: Option<ComposedNumbers<f64>>,
) -> JudgedNumbers {
    let [whole, half] = levels;
    let numbers = evaluated(whole, Change::default());
    let change =
        |other: ComposedNumbers<f64>| other.zipped(numbers.clone(), |changed, number| changed - number);
    let by_halving = change(evaluated(half, Change::default()));
    let by_grid = change(evaluated(whole, Change { grid: true, ..Change::default() }));
    let by_fringes = change(evaluated(whole, Change { fewer_directions: true, ..Change::default() }));
    let by_moments = change(evaluated(whole, Change { without_highest_moment: true, ..Change::default() }));
    let by_directions = by_fringes.zipped(by_moments, |fringes, moments| fringes.hypot(moments / THINNED));
    let squares = by_directions.clone().map(|change| change.powi(2));
    // at single wavelengths fringes change nothing by accident
    let by_directions = by_directions.zipped(over_wavelengths(&squares, root_of_mean), f64::max);
    let of_whole = replicates(evaluated, whole);
    let chance = variances(&of_whole, &numbers);
    let chance_of_half = variances(&replicates(evaluated, half), &numbers);
    // a single realisation tells nothing about chance
    let is_known = whole.realisations().into_iter().chain(half.realisations()).all(|count| count > 1);
    let chance_of_halving =
        chance.clone().zipped(chance_of_half, |whole, half| if is_known { whole + half } else { 0.0 });
    let model = errors_of_composing(by_halving, chance_of_halving);
    let of_inputs = of_inputs.unwrap_or_else(|| numbers.clone().map(|_| 0.0));
    let numbers = numbers
        .map(|value| ErrorParts { value, ..ErrorParts::default() })
        .zipped(chance, |parts, variance| ErrorParts { chance: variance.sqrt(), ..parts })
        .zipped(model, |parts, model| ErrorParts { model, ..parts })
        .zipped(by_grid, |parts, change| ErrorParts { grid: change.abs(), ..parts })
        .zipped(by_directions, |parts, change| ErrorParts { directions: change, ..parts })
        .zipped(of_inputs, |parts, inputs| ErrorParts { inputs: inputs.sqrt(), ..parts })
        .map(ErrorParts::summed);
    JudgedNumbers { numbers, replicates: of_whole }
}

/// Variances due to the errors of tables of indices. Moves to both sides are among those given, so
/// that half of the sum of the squares of what they change is the variance.
fn input_variances(task: &LayerTask, levels: &MovedLevels) -> Result<ComposedNumbers<f64>, String> {
    let unmoved = task.numbers(&levels.unmoved, Change::default());
    let mut sum = unmoved.clone().map(|_| 0.0);
    for (study, level) in &levels.moved {
        let changed = task.of_study(study)?.numbers(level, Change::default());
        let squares = changed.zipped(unmoved.clone(), |changed, number| 0.5 * (changed - number).powi(2));
        sum = sum.zipped(squares, |sum, square| sum + square);
    }
    Ok(sum)
}

/// The numbers without each realisation, portion by portion; portions of one realisation have none.
fn replicates(evaluated: NumbersOf, level: &Level) -> Vec<PortionReplicates> {
    let mut all = Vec::new();
    for (portion, count) in level.realisations().into_iter().enumerate().filter(|(_, count)| *count > 1) {
        let without =
            |r: usize| evaluated(level, Change { left_out: Some([portion, r]), ..Change::default() });
        all.extend(ComposedNumbers::gathered((0..count).map(without).collect()));
    }
    all
}

/// Jackknife variances, added over the portions.
fn variances(replicates: &[PortionReplicates], numbers: &ComposedNumbers<f64>) -> ComposedNumbers<f64> {
    let nothing = numbers.clone().map(|_| 0.0);
    replicates.iter().fold(nothing, |sum, of_portion| {
        sum.zipped(of_portion.clone().map(jackknife_variance), |sum, variance| sum + variance)
    })
}

/// Jackknife variance (n − 1)/n Σ_r (x_r − x̄)² of a number from its n leave-one-out replicates.
fn jackknife_variance(replicates: Vec<f64>) -> f64 {
    let n = replicates.len() as f64;
    let mean = replicates.iter().sum::<f64>() / n;
    (n - 1.0) / n * replicates.iter().map(|x| (x - mean).powi(2)).sum::<f64>()
}

/// The errors of composing, from what slabs of half the thickness change and the variances that
/// this has by chance: of its square beyond them, the mean over a quantity's neighbours in
/// wavelength.
fn errors_of_composing(
    changes: ComposedNumbers<f64>,
    by_chance: ComposedNumbers<f64>,
) -> ComposedNumbers<f64> {
    let beyond = changes.zipped(by_chance, |change, by_chance| change.powi(2) - by_chance);
    over_wavelengths(&beyond, error_of_composing)
}

/// An error from the squares of a quantity at the wavelengths near.
type ErrorNear = fn(&[f64]) -> f64;

/// The errors of all quantities, each from its squares at the wavelengths near; of what has no
/// wavelength from its own alone.
fn over_wavelengths(squares: &ComposedNumbers<f64>, error: ErrorNear) -> ComposedNumbers<f64> {
    let of_thickness = |numbers: &ThicknessNumbers<f64>| thickness_errors(numbers, error);
    let absorbed =
        |all: &Vec<Vec<f64>>| over_neighbours(all, |near, here| absorbed_errors(near, here.len(), error));
    let distributed = |all: &Vec<Distribution<f64>>| {
        over_neighbours(all, |near, here| distribution_errors(near, here, error))
    };
    ComposedNumbers {
        requested: squares.requested.iter().map(of_thickness).collect(),
        curve: squares.curve.iter().map(of_thickness).collect(),
        hiding: squares.hiding.as_ref().map(|hiding| HidingNumbers {
            below: of_thickness(&hiding.below),
            above: of_thickness(&hiding.above),
            thickness_um: error(&[hiding.thickness_um]),
        }),
        medium: over_neighbours(&squares.medium, |near, _| MediumNumbers::combined(near, error)),
        distributions: squares.distributions.iter().map(distributed).collect(),
        absorbed: squares.absorbed.iter().map(absorbed).collect(),
        left_out: squares.left_out.iter().map(|numbers| left_out_errors(numbers, error)).collect(),
    }
}

fn left_out_errors(beyond: &LeftOutNumbers<f64>, error: ErrorNear) -> LeftOutNumbers<f64> {
    let of_number = |near: &[DensityNumbers<f64>], number: fn(&DensityNumbers<f64>) -> f64| {
        error(&near.iter().map(number).collect::<Vec<_>>())
    };
    let of_thickness = |numbers: &ThicknessNumbers<f64>| thickness_errors(numbers, error);
    LeftOutNumbers {
        without: beyond.without.iter().map(of_thickness).collect(),
        alone: beyond.alone.iter().map(of_thickness).collect(),
        densities: over_neighbours(&beyond.densities, |near, _| DensityNumbers {
            stack: of_number(near, |densities| densities.stack),
            layers: of_number(near, |densities| densities.layers),
            ratio: of_number(near, |densities| densities.ratio),
        }),
    }
}

fn thickness_errors(beyond: &ThicknessNumbers<f64>, error: ErrorNear) -> ThicknessNumbers<f64> {
    let alone = |beyond: f64| error(&[beyond]);
    ThicknessNumbers {
        spectra: over_neighbours(&beyond.spectra, |near, _| LayerNumbers::combined(near, error)),
        colours: beyond.colours.map(|colours: ColourNumbers<f64>| colours.map(alone)),
        weighted: beyond.weighted.iter().map(|beyond| alone(*beyond)).collect(),
        prints: beyond.prints.iter().map(|print| print.clone().map(&alone)).collect(),
    }
}

/// A distribution's errors: every node's from those of its number at the wavelengths near.
fn distribution_errors(
    near: &[Distribution<f64>],
    here: &Distribution<f64>,
    error_near: ErrorNear,
) -> Distribution<f64> {
    let errors = |lobe: fn(&Distribution<f64>) -> &[f64]| {
        let error = |node: usize| {
            let values = near.iter().filter_map(|other| lobe(other).get(node).copied());
            error_near(&values.collect::<Vec<_>>())
        };
        (0..lobe(here).len()).map(error).collect()
    };
    Distribution { reflected: errors(|all| &all.reflected), transmitted: errors(|all| &all.transmitted) }
}

/// The errors of what layers absorb, each from those of its layer at the wavelengths near.
fn absorbed_errors(near: &[Vec<f64>], layers: usize, error_near: ErrorNear) -> Vec<f64> {
    let error = |layer: usize| {
        let values = near.iter().filter_map(|other| other.get(layer).copied());
        error_near(&values.collect::<Vec<_>>())
    };
    (0..layers).map(error).collect()
}

/// A new row for each, from the rows of the wavelengths near and its own.
fn over_neighbours<R>(rows: &[R], new: impl Fn(&[R], &R) -> R) -> Vec<R> {
    let near = |w: usize| &rows[w.saturating_sub(NEIGHBOURS)..rows.len().min(w + NEIGHBOURS + 1)];
    rows.iter().enumerate().map(|(w, row)| new(near(w), row)).collect()
}

/// The error of composing from squares of changes, chance taken off.
fn error_of_composing(beyond: &[f64]) -> f64 {
    root_of_mean(beyond) / HALVED
}

fn root_of_mean(squares: &[f64]) -> f64 {
    (squares.iter().sum::<f64>() / squares.len() as f64).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of 20 wavelengths, of which two quantities differ from 0.
    fn numbers(pair: impl Fn(usize) -> [f64; 2]) -> ComposedNumbers<f64> {
        let row = |w: usize| {
            let [reflectance_normal, over_white] = pair(w);
            LayerNumbers { reflectance_normal, over_white, ..LayerNumbers::default() }
        };
        let spectra = (0..20).map(row).collect();
        let weighted = Vec::new();
        let prints = Vec::new();
        ComposedNumbers::of_requested(vec![ThicknessNumbers { spectra, colours: None, weighted, prints }])
    }

    /// What is chance alone adds little to a bar; a change that chance does not explain adds half
    /// of it, at all wavelengths near it. *Planted*: chance not taken off.
    #[test]
    fn the_error_of_composing_is_what_chance_does_not_explain() {
        // differences of two means with a standard error of 0.01 each: a variance of 2e-4
        let chance = |k: usize| 0.01 * 2.0 * ((7 * k + 3) as f64).sin();
        let errors = |shift: f64| {
            let changes = numbers(|w| [chance(2 * w) + shift, chance(2 * w + 1)]);
            let errors = errors_of_composing(changes, numbers(|_| [2e-4; 2]));
            errors.requested.into_iter().next().unwrap().spectra
        };
        let alone = errors(0.0);
        let squares = alone.iter().map(|row| row.reflectance_normal.powi(2) + row.over_white.powi(2));
        let typical = (squares.sum::<f64>() / 40.0).sqrt();
        assert!(typical < 0.004, "{typical}");
        // one quantity is off by 0.06 besides
        for (shifted, alone) in errors(0.06).iter().zip(&alone) {
            assert!((0.02..0.04).contains(&shifted.reflectance_normal), "{shifted:?}");
            assert_eq!(shifted.over_white, alone.over_white);
        }
    }

    /// The jackknife of numbers by name is that of each. *Planted*: the numbers of two replicates
    /// changed round.
    #[test]
    fn the_jackknife_keeps_numbers_apart() {
        let samples = [0.3, 1.7, -0.4, 2.2];
        let sum: f64 = samples.iter().sum();
        let replicate = |x: &f64| numbers(|w| [(sum - x) / 3.0, w as f64 * (sum - x) / 3.0]);
        let replicates = ComposedNumbers::gathered(samples.iter().map(replicate).collect()).unwrap();
        let variances = replicates.map(jackknife_variance).requested.remove(0).spectra;
        let mean = sum / 4.0;
        // that of a mean: s²/n
        let expected = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 3.0 / 4.0;
        for (w, row) in variances.iter().enumerate() {
            assert!((row.reflectance_normal - expected).abs() < 1e-12 * expected);
            let larger = (w * w) as f64 * expected;
            assert!((row.over_white - larger).abs() <= 1e-12 * larger);
            assert_eq!(row.mirrored, 0.0);
        }
    }
}
