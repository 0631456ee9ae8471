//! The gate that every published number passes: withholds impossible ones, with the reason.
//!
//! Totals of the layer have further checks of their own ([`crate::wave::Unphysical`],
//! [`super::manifest::Manifest::unphysical`]). Curves fitted to few directions and cells may still
//! overshoot where a colour or a BRDF is derived from them.

use super::ink_maker::{InkMaker, Swatch};
use super::manifest::{ColourNote, LIT_AT_45, NATURAL_LIGHT, SpectrumRow};
use super::published::{PublishedRow, Quantity, Withheld};
use crate::appearance::colour::Colour;
use crate::numerics::estimate::Estimate;

/// Tolerance of factors and ratios, and of X, Y, Z relative to white: noise of the darkest prints,
/// far below what is visible.
const SLACK: f64 = 2e-3;
/// Tolerance of L*: that of Y at white.
const LIGHTNESS_SLACK: f64 = 0.1;
/// Largest Y, over that of a perfect white, of a print that is lit from one direction. Behind a
/// plane face of index 1.5 a perfect white has T(45°) T(0°)/T̄: 1.004, and 1.05 in p light. The
/// rest is for layers that send more light towards the normal than to other directions.
const MOST_LUMINANCE: f64 = 1.2;
/// Tolerance if a single realisation leaves the error unknown.
const UNKNOWN: f64 = 0.02;
/// A reflectance factor or ratio with a larger standard error is meaningless: its scale is 0 to 1.
const MOST_ERROR: f64 = 0.5;
/// Largest meaningful standard error of L*, a* and b*.
const MOST_LAB_ERROR: f64 = 50.0;

/// Largest overshoot of a total that its error may account for: twice the overshoot observed with
/// splines through six wavelengths.
const MOST_OVERSHOOT: f64 = 0.1;

/// Largest reflectance factor in one direction: a perfect white has 1, and fringes of clear films
/// of high index on white paper reach 1.5 at single wavelengths.
const MOST_FACTOR: f64 = 2.0;

/// Rounding of quantities with a unit, such as the absorption of a layer that absorbs nothing.
const ROUNDING: f64 = 1e-6;

/// Why a number cannot be published; `None` if it can. An unknown error counts as 0.02 for shares
/// and factors, and as 0 for quantities with a unit.
pub fn impossible(quantity: Quantity, number: Estimate) -> Option<String> {
    match quantity {
        Quantity::Share => impossible_share(number),
        Quantity::Factor => impossible_factor(number),
        Quantity::Size | Quantity::Positive => impossible_size(quantity, number),
        Quantity::Cosine => {
            let error = number.standard_error.unwrap_or(UNKNOWN);
            let beyond = number.value.abs() > 1.0 + error + SLACK;
            not_determined(number)
                .or_else(|| beyond.then(|| format!("{}, beyond ±1 by more than its error", in_words(number))))
        }
    }
}

/// How light a print can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Brightest {
    /// Under a uniform sky: as a perfect white, since no more light leaves than comes in.
    White,
    /// Lit from one direction, or on paper that fluoresces: lighter, but not by much.
    AboveWhite,
}

impl Brightest {
    /// Under a uniform sky, on paper that fluoresces or not.
    pub fn under_sky(fluoresces: bool) -> Self {
        if fluoresces { Self::AboveWhite } else { Self::White }
    }

    /// Largest Y over that of a perfect white.
    fn luminance(self) -> f64 {
        match self {
            Self::White => 1.0,
            Self::AboveWhite => MOST_LUMINANCE,
        }
    }

    fn in_words(self) -> String {
        match self {
            Self::White => "white".to_owned(),
            Self::AboveWhite => format!("{MOST_LUMINANCE} times white"),
        }
    }
}

/// Removes impossible colours and gives the reasons.
pub(super) fn colours(notes: Vec<ColourNote>, fluoresces: bool) -> (Vec<ColourNote>, Vec<Withheld>) {
    let mut kept = Vec::new();
    let mut withheld = Vec::new();
    for note in notes {
        let brightest = match note.conditions == NATURAL_LIGHT {
            true => Brightest::under_sky(fluoresces),
            false => Brightest::AboveWhite,
        };
        match impossible_colour(&note.colour, note.lab_standard_error, brightest) {
            None => kept.push(note),
            Some(reason) => {
                withheld.push(Withheld { number: colour_under(&note.conditions), reason });
            }
        }
    }
    (kept, withheld)
}

/// The first impossible number for the ink maker.
pub(super) fn ink_maker(maker: &InkMaker, fluoresces: bool) -> Option<Withheld> {
    let swatches = [
        ("on its paper", &maker.print, Brightest::AboveWhite),
        ("under natural light", &maker.natural_light, Brightest::under_sky(fluoresces)),
        ("over black", &maker.over_black, Brightest::AboveWhite),
        ("over white", &maker.over_white, Brightest::AboveWhite),
    ];
    let colour = swatches.into_iter().find_map(|(name, swatch, brightest)| {
        let Swatch { colour, lab_standard_error, .. } = swatch;
        let reason = impossible_colour(colour, *lab_standard_error, brightest)?;
        Some(Withheld { number: format!("colour {name}"), reason })
    });
    colour.or_else(|| {
        Some(Withheld { number: "contrast ratio".into(), reason: impossible_share(maker.contrast_ratio)? })
    })
}

/// What is withheld instead of a colour.
pub(super) fn colour_under(conditions: &str) -> String {
    format!("colour under {conditions}")
}

/// A spectrum of the ink on its paper: the conditions of its colour, and where it stands.
type PrintColumn = (&'static str, fn(&mut SpectrumRow) -> &mut Option<Estimate>);

/// The spectra of the ink on its paper.
const OF_PRINT: [PrintColumn; 2] =
    [(NATURAL_LIGHT, |row| &mut row.natural_light), (LIT_AT_45, |row| &mut row.lit_at_45)];

/// A further number of a row: its name in words, its kind, and where it stands.
type FurtherColumn = (&'static str, Quantity, fn(&mut SpectrumRow) -> &mut Option<Estimate>);

/// What instruments of diffuse light read of the print, and numbers of the layer that may be
/// missing.
const FURTHER: [FurtherColumn; 6] = [
    ("reflectance factor d:8", Quantity::Factor, |row| &mut row.sphere_at_8),
    ("reflectance factor d:8 without mirrored light", Quantity::Factor, |row| &mut row.sphere_at_8_excluded),
    ("reflectance factor d:0", Quantity::Factor, |row| &mut row.diffuse_normal),
    ("transmittance of diffuse light", Quantity::Share, |row| &mut row.transmittance_diffuse),
    ("absorptance of diffuse light from behind", Quantity::Share, |row| &mut row.absorptance_behind),
    ("coherent transmittance", Quantity::Share, |row| &mut row.coherent_transmittance),
];

/// Removes impossible numbers of the spectra and gives the reason for the first of each kind; where
/// the colour that a whole spectrum makes is among those `withheld`, removes that spectrum.
pub(super) fn spectra(rows: &mut [SpectrumRow], withheld: &[Withheld]) -> Vec<Withheld> {
    let mut reasons = Vec::new();
    for (conditions, column) in OF_PRINT {
        let number = format!("reflectance factor under {conditions}");
        if withheld.iter().any(|other| other.number == colour_under(conditions)) {
            rows.iter_mut().for_each(|row| *column(row) = None);
            reasons.push(Withheld { number, reason: "it makes an impossible colour".to_owned() });
        } else {
            let reason = |row: &mut SpectrumRow| column(row).and_then(impossible_factor);
            reasons.extend(withhold(rows, number, reason, |row| *column(row) = None));
        }
    }
    for (name, quantity, column) in FURTHER {
        let reason = |row: &mut SpectrumRow| column(row).and_then(|number| impossible(quantity, number));
        reasons.extend(withhold(rows, name.to_owned(), reason, |row| *column(row) = None));
    }
    reasons
}

/// Removes impossible coefficients of Kubelka and Munk, and says so.
pub(super) fn kubelka_munk(maker: &mut InkMaker) {
    let mut first_reason = None;
    maker.kubelka_munk.retain(|row| {
        let both = [("K", row.absorption_per_um), ("S", row.scattering_per_um)];
        let reason = both.into_iter().find_map(|(name, number)| {
            Some(format!("{name} at {} nm is {}", row.wavelength_nm, impossible(Quantity::Size, number)?))
        });
        let kept = reason.is_none();
        first_reason = first_reason.take().or(reason);
        kept
    });
    maker.no_kubelka_munk = maker.no_kubelka_munk.take().or(first_reason);
}

/// Withholds `number` in the rows that have a reason, and tells how many these are and the first
/// reason.
pub(super) fn withhold<R: PublishedRow>(
    rows: &mut [R],
    number: String,
    reason: impl Fn(&mut R) -> Option<String>,
    remove: impl Fn(&mut R),
) -> Option<Withheld> {
    let mut count = 0;
    let mut first = None;
    for row in rows {
        let Some(reason) = reason(row) else { continue };
        remove(row);
        count += 1;
        first = first.or(Some(format!("{reason} at {} nm", row.wavelength_nm())));
    }
    let reason = format!("{}; {count} of its wavelengths are left out", first?);
    Some(Withheld { number, reason })
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

/// Why a directional reflectance factor is impossible: it may exceed 1, but not by much.
fn impossible_factor(e: Estimate) -> Option<String> {
    let error = e.standard_error.unwrap_or(UNKNOWN);
    let above =
        || format!("{}, above {MOST_FACTOR} (a perfect white has 1) by more than its error", in_words(e));
    impossible_ratio(e).or_else(|| (e.value > MOST_FACTOR + error).then(above))
}

/// Why a share of the light is impossible.
fn impossible_share(e: Estimate) -> Option<String> {
    let error = e.standard_error.unwrap_or(UNKNOWN);
    let above = || format!("{}, above 1 by more than its error", in_words(e));
    impossible_ratio(e).or_else(|| (e.value > 1.0 + error + SLACK).then(above))
}

/// Why a number on a scale of 0 to 1 or so is impossible, whatever its upper end.
fn impossible_ratio(e: Estimate) -> Option<String> {
    let error = e.standard_error.unwrap_or(UNKNOWN);
    let meaningless = || format!("{}, an error too large for a meaningful result", in_words(e));
    let below = || format!("{}, below 0 by more than its error", in_words(e));
    not_determined(e)
        .or_else(|| (error > MOST_ERROR).then(meaningless))
        .or_else(|| (e.value < -error - SLACK).then(below))
}

/// Why a quantity with a unit is impossible.
fn impossible_size(quantity: Quantity, e: Estimate) -> Option<String> {
    let error = e.standard_error.unwrap_or(0.0);
    let meaningless = || format!("{}, no more than its error", in_words(e));
    let below = || format!("{}, below 0 by more than three times its error", in_words(e));
    let lost = quantity == Quantity::Positive && e.value <= error;
    not_determined(e)
        .or_else(|| (e.value < -3.0 * error - ROUNDING).then(below))
        .or_else(|| lost.then(meaningless))
}

/// Says so if a number or its error is none: it follows from something that these realisations do
/// not determine, such as the logarithm of a mean that is not above 0.
fn not_determined(e: Estimate) -> Option<String> {
    let determined = e.value.is_finite() && e.standard_error.is_none_or(f64::is_finite);
    (!determined).then(|| "not determined by these realisations".to_owned())
}

/// A number with its error.
fn in_words(e: Estimate) -> String {
    format!("{} ± {}", shown(e.value), e.standard_error.map_or("unknown".into(), shown))
}

fn shown(value: f64) -> String {
    let decimals = if value.abs() < 10.0 { 3 } else { 0 };
    format!("{value:.decimals$}").replace('-', "−")
}

/// Why a colour is impossible.
pub(super) fn impossible_colour(
    colour: &Colour,
    error: Option<[f64; 3]>,
    brightest: Brightest,
) -> Option<String> {
    let lab = colour.lab.map(shown).join(", ");
    if !colour.lab.iter().chain(error.iter().flatten()).all(|x| x.is_finite()) {
        return Some(format!("Lab ({lab}) is not a number"));
    }
    if let Some(c) = (0..3).find(|c: &usize| colour.xyz[*c] < -SLACK * colour.white_xyz[*c]) {
        let name = ["X", "Y", "Z"][c];
        let value = shown(colour.xyz[c]);
        return Some(format!("Lab ({lab}) has {name} = {value}, below 0"));
    }
    let lightness_error = error.map_or(100.0 * UNKNOWN, |e| e[0]);
    let lightest = 116.0 * brightest.luminance().cbrt() - 16.0;
    if colour.lab[0] > lightest + lightness_error + LIGHTNESS_SLACK {
        return Some(format!(
            "Lab ({lab}) is lighter than {} by more than its error, {}",
            brightest.in_words(),
            shown(lightness_error)
        ));
    }
    let worst = error?.into_iter().fold(0.0, f64::max);
    (worst > MOST_LAB_ERROR).then(|| format!("Lab ({lab}) ± {} is not meaningful", shown(worst)))
}

#[cfg(test)]
#[path = "gate_tests.rs"]
mod tests;
