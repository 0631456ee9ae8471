//! The thickness that hides black from white, and how far paint of that thickness goes.

use super::rows::ThicknessRows;
use crate::evaluate::composed::level::Slabs;
use crate::evaluate::composed::numbers::LayerTask;
use crate::evaluate::published::ErrorParts;
use crate::evaluate::quantities::{HidingNumbers, ThicknessNumbers};
use crate::numerics::allowed::brief;

/// Slabs of the curve against thickness, up to a layer that practically no light passes.
const CURVE: [usize; 16] = [2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 256, 1024, 4096];
/// Most slabs of a layer that is tried for hiding.
const MOST_SLABS: usize = 1024;

/// Sets the thicknesses of the curve, and those around the one that hides; a reason where there is
/// none.
pub(super) fn set_curve(task: &mut LayerTask, slabs: &[Slabs]) -> Result<(), String> {
    if task.stack.is_some() {
        return Err("of a stack there is the contrast ratio of every thickness".to_owned());
    }
    task.curve_um = CURVE.map(|count| count as f64 * task.composed.slab_um).to_vec();
    find_hiding(task, slabs)
}

/// Finds the two thicknesses around the one that hides; the reason if there is none.
fn find_hiding(task: &mut LayerTask, slabs: &[Slabs]) -> Result<(), String> {
    let hides = |count: usize| task.does_hide(slabs, count);
    let reason = "no contrast ratio without a colour";
    if hides(2).ok_or(reason)? {
        return Err(format!("two slabs, {} µm, hide already", brief(2.0 * task.composed.slab_um)));
    }
    let mut most = 4;
    while !hides(most).ok_or(reason)? {
        if most >= MOST_SLABS {
            return Err(format!("{} µm do not hide", brief(MOST_SLABS as f64 * task.composed.slab_um)));
        }
        most *= 2;
    }
    let counts: Vec<usize> = (most / 2 + 1..most).collect();
    let first = most / 2 + 1 + counts.partition_point(|&count| hides(count) == Some(false));
    task.around_hiding_um = Some([first - 1, first].map(|count| count as f64 * task.composed.slab_um));
    Ok(())
}

/// The hiding thickness with what the wavelengths leave open of the contrast ratios around it.
pub(super) fn hiding_thickness(
    task: &LayerTask,
    [below_um, above_um]: [f64; 2],
    hiding: &HidingNumbers<ErrorParts>,
) -> ErrorParts {
    let contrast_ratio = |um: f64, layer: &ThicknessNumbers<ErrorParts>| {
        let mut rows = ThicknessRows::default();
        rows.add(task, um, layer);
        rows.colours.first()?.contrast_ratio
    };
    let below = contrast_ratio(below_um, &hiding.below);
    let above = contrast_ratio(above_um, &hiding.above);
    let Some((from, to)) = below.zip(above) else {
        return ErrorParts { value: f64::NAN, ..hiding.thickness_um };
    };
    let per_um = (to.value - from.value) / (above_um - below_um);
    ErrorParts { wavelengths: from.wavelengths / per_um.abs(), ..hiding.thickness_um }.summed()
}

/// 1000/H m² a litre.
pub(super) fn spreading_rate(hiding: ErrorParts) -> ErrorParts {
    let value = 1e3 / hiding.value;
    let relative = |error: f64| value * error / hiding.value;
    ErrorParts {
        value,
        standard_error: relative(hiding.standard_error),
        chance: relative(hiding.chance),
        model: relative(hiding.model),
        grid: relative(hiding.grid),
        directions: relative(hiding.directions),
        wavelengths: relative(hiding.wavelengths),
        inputs: relative(hiding.inputs),
    }
}
