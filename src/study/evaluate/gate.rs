//! Withholds impossible numbers of the ink on its paper, with the reason.
//!
//! Totals of the layer have checks of their own ([`crate::wave::physical`],
//! [`super::manifest::Manifest::unphysical`]). Curves fitted to few directions and cells may still
//! overshoot where a colour or a BRDF is derived from them.

use super::ink_maker::{InkMaker, Swatch};
use super::manifest::{ColourNote, SpectrumRow, Withheld};
use crate::appearance::colour::Colour;
use crate::numerics::estimate::Estimate;

/// Tolerance of factors and ratios, and of X, Y, Z relative to white: noise of the darkest prints,
/// far below what is visible.
const SLACK: f64 = 2e-3;
/// Tolerance of L*: that of Y at white.
const LIGHTNESS_SLACK: f64 = 0.1;
/// Tolerance if a single realisation leaves the error unknown.
const UNKNOWN: f64 = 0.02;
/// A reflectance factor or ratio with a larger standard error is meaningless: its scale is 0 to 1.
const MOST_ERROR: f64 = 0.5;
/// Largest meaningful standard error of L*, a* and b*.
const MOST_LAB_ERROR: f64 = 50.0;

/// Largest overshoot of a total that its error may account for: twice the overshoot observed with
/// splines through six wavelengths.
const MOST_OVERSHOOT: f64 = 0.1;

/// Removes impossible colours and gives the reasons.
pub(super) fn colours(notes: Vec<ColourNote>) -> (Vec<ColourNote>, Vec<Withheld>) {
    let (mut kept, mut withheld) = (Vec::new(), Vec::new());
    for note in notes {
        match impossible_colour(&note.colour, note.lab_standard_error) {
            None => kept.push(note),
            Some(reason) => {
                withheld.push(Withheld { number: format!("colour under {}", note.conditions), reason });
            }
        }
    }
    (kept, withheld)
}

/// The first impossible number for the ink maker.
pub(super) fn ink_maker(maker: &InkMaker) -> Option<Withheld> {
    let swatches = [
        ("on its paper", &maker.print),
        ("under natural light", &maker.natural_light),
        ("over black", &maker.over_black),
        ("over white", &maker.over_white),
    ];
    let colour = swatches.into_iter().find_map(|(name, Swatch { colour, lab_standard_error, .. })| {
        let reason = impossible_colour(colour, *lab_standard_error)?;
        Some(Withheld { number: format!("colour {name}"), reason })
    });
    colour.or_else(|| {
        Some(Withheld { number: "contrast ratio".into(), reason: impossible_share(maker.contrast_ratio)? })
    })
}

/// Removes impossible reflectance factors and gives the reason for the first of each kind.
pub(super) fn spectra(rows: &mut [SpectrumRow]) -> Vec<Withheld> {
    let natural = first("reflectance factor under natural light", rows, |row| &mut row.natural_light);
    natural.into_iter().chain(first("reflectance factor at 45°:0°", rows, |row| &mut row.lit_at_45)).collect()
}

fn first(
    name: &str,
    rows: &mut [SpectrumRow],
    of: fn(&mut SpectrumRow) -> &mut Option<Estimate>,
) -> Option<Withheld> {
    let (mut count, mut found) = (0, None);
    for row in rows {
        let wavelength_nm = row.wavelength_nm;
        let number = of(row);
        if let Some(reason) = (*number).and_then(impossible_factor) {
            *number = None;
            count += 1;
            found = found.or(Some(format!("{reason} at {wavelength_nm} nm")));
        }
    }
    let reason = format!("{}; {count} of its wavelengths are left out", found?);
    Some(Withheld { number: name.to_owned(), reason })
}

/// Limits a total of the layer to 0–1. Curves through few wavelengths and cells overshoot: the
/// overshoot is added to the error. A larger overshoot than [`MOST_OVERSHOOT`] is left unchanged
/// and makes the results invalid.
pub(super) fn bounded(e: Estimate) -> Estimate {
    let value = e.value.clamp(0.0, 1.0);
    let overshoot = (e.value - value).abs();
    if overshoot == 0.0 || overshoot > MOST_OVERSHOOT {
        return e;
    }
    Estimate { value, standard_error: e.standard_error.map(|error| error.hypot(overshoot)) }
}

/// Why a directional reflectance factor is impossible; it may exceed 1, but not be negative.
fn impossible_factor(e: Estimate) -> Option<String> {
    let error = e.standard_error.unwrap_or(UNKNOWN);
    let words = || format!("{} ± {}", shown(e.value), e.standard_error.map_or("unknown".into(), shown));
    if !e.value.is_finite() || !error.is_finite() || error > MOST_ERROR {
        return Some(format!("{}, an error too large for a meaningful result", words()));
    }
    (e.value < -error - SLACK).then(|| format!("{}, below 0 by more than its error", words()))
}

/// Why a ratio is impossible: as for a factor, and if it exceeds 1.
fn impossible_share(e: Estimate) -> Option<String> {
    let error = e.standard_error.unwrap_or(UNKNOWN);
    let above = || format!("{} ± {}, above 1 by more than its error", shown(e.value), shown(error));
    impossible_factor(e).or_else(|| (e.value > 1.0 + error + SLACK).then(above))
}

fn shown(value: f64) -> String {
    let decimals = if value.abs() < 10.0 { 3 } else { 0 };
    format!("{value:.decimals$}").replace('-', "−")
}

/// Why a colour is impossible.
fn impossible_colour(colour: &Colour, error: Option<[f64; 3]>) -> Option<String> {
    let lab = colour.lab.map(shown).join(", ");
    if !colour.lab.iter().chain(error.iter().flatten()).all(|x| x.is_finite()) {
        return Some(format!("Lab ({lab}) is not a number"));
    }
    if let Some(c) = (0..3).find(|c: &usize| colour.xyz[*c] < -SLACK * colour.white_xyz[*c]) {
        let (name, value) = (["X", "Y", "Z"][c], shown(colour.xyz[c]));
        return Some(format!("Lab ({lab}) has {name} = {value}, below 0"));
    }
    let lightness_error = error.map_or(100.0 * UNKNOWN, |e| e[0]);
    if colour.lab[0] > 100.0 + lightness_error + LIGHTNESS_SLACK {
        return Some(format!(
            "Lab ({lab}) is lighter than white by more than its error, {}",
            shown(lightness_error)
        ));
    }
    let worst = error?.into_iter().fold(0.0, f64::max);
    (worst > MOST_LAB_ERROR).then(|| format!("Lab ({lab}) ± {} is not meaningful", shown(worst)))
}

#[cfg(test)]
#[path = "gate_tests.rs"]
mod tests;
