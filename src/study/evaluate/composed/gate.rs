//! Numbers of a composed layer that cannot be are withheld, with the reason.

use super::manifest::{ComposedColours, ComposedRow, ErrorParts};
use super::numbers::{COLOURS, SPECTRAL};
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::gate::{Quantity, impossible, impossible_colour};
use crate::evaluate::manifest::Withheld;
use crate::numerics::estimate::Estimate;

/// Places of R among a row's numbers; T follows each.
const REFLECTANCES: [usize; 3] = [0, 2, 4];
/// Place of the first reflectance factor at 45:0 among a row's numbers: the rest are shares.
const FIRST_FACTOR: usize = 9;
/// Places of the spectra that have a colour: natural light, 45:0 on the paper and over black.
const COLOURED: [(usize, &str); 3] =
    [(8, "under natural light"), (9, "at 45°:0°"), (10, "at 45°:0° over black")];
/// Places of the spectra over black and over white, of which the contrast ratio is made.
const BACKED: [usize; 2] = [10, 11];

/// The numbers of one thickness at all wavelengths, before the gate.
pub type LayerSpectra = Vec<[ErrorParts; SPECTRAL]>;

/// Withholds what cannot be of the rows of one thickness.
pub fn rows(rows: &mut [ComposedRow]) -> Vec<Withheld> {
    let mut withheld = Vec::new();
    let Some(um) = rows.first().map(|row| row.thickness_um) else { return withheld };
    for (k, name) in ComposedRow::NAMES.into_iter().enumerate() {
        let quantity = if k < FIRST_FACTOR { Quantity::Share } else { Quantity::Factor };
        let reason = |row: &ComposedRow| impossible(quantity, row.numbers()[k]?.estimate());
        withheld.extend(first(rows, &[k], format!("{name} of {um} µm"), reason));
    }
    for k in REFLECTANCES {
        let name = format!("{} and {} of {um} µm", ComposedRow::NAMES[k], ComposedRow::NAMES[k + 1]);
        let reason = |row: &ComposedRow| {
            let (r, t) = (row.numbers()[k]?, row.numbers()[k + 1]?);
            let error = r.standard_error.hypot(t.standard_error);
            let sum = Estimate { value: r.value + t.value, standard_error: Some(error) };
            Some(format!("R + T = {}", impossible(Quantity::Share, sum)?))
        };
        withheld.extend(first(rows, &[k, k + 1], name, reason));
    }
    withheld
}

/// Withholds some numbers of the rows that have a reason, and tells the first of these.
fn first(
    rows: &mut [ComposedRow],
    places: &[usize],
    number: String,
    reason: impl Fn(&ComposedRow) -> Option<String>,
) -> Option<Withheld> {
    let (mut count, mut found) = (0, None);
    for row in rows {
        let Some(reason) = reason(row) else { continue };
        places.iter().for_each(|k| *row.numbers_mut()[*k] = None);
        count += 1;
        found = found.or(Some(format!("{reason} at {} nm", row.wavelength_nm)));
    }
    let reason = format!("{}; {count} of its wavelengths are left out", found?);
    Some(Withheld { number, reason })
}

/// The colours of one thickness with the bars that the wavelengths give them, as far as they can
/// be: `all` are their numbers, `spectra` what they were summed from, `rows` the same after the
/// gate.
pub fn colours(
    eye: &Colorimeter,
    spectra: &LayerSpectra,
    rows: &[ComposedRow],
    all: &[ErrorParts; COLOURS],
) -> (ComposedColours, Vec<Withheld>) {
    let um = rows.first().map_or(f64::NAN, |row| row.thickness_um);
    let mut withheld = Vec::new();
    let mut hex = None;
    let mut seen = [None; 3];
    for (k, (place, name)) in COLOURED.into_iter().enumerate() {
        let values = values(spectra, place);
        let judged = eye.colour(&values).map_err(|error| error.to_string()).and_then(|colour| {
            let shifts = between(eye, &values, colour.xyz);
            let lab: [ErrorParts; 3] = std::array::from_fn(|c| {
                let wavelengths = shifts.iter().fold(0.0, |sum: f64, shift| sum.hypot(shift[c]));
                ErrorParts { wavelengths, ..all[3 * k + c] }.summed()
            });
            let left_out = rows.iter().any(|row| row.numbers()[place].is_none());
            let reason = if left_out {
                Some("its spectrum has numbers that are withheld".to_owned())
            } else {
                impossible_colour(&colour, Some(lab.map(|part| part.standard_error)))
            };
            reason.map_or(Ok((colour, lab)), Err)
        });
        match judged {
            Ok((colour, lab)) => {
                seen[k] = Some(lab);
                if k == 0 {
                    let [r, g, b] = colour.srgb8;
                    hex = Some(format!("#{r:02x}{g:02x}{b:02x}"));
                }
            }
            Err(reason) => withheld.push(Withheld { number: format!("colour of {um} µm {name}"), reason }),
        }
    }
    let [natural_light, lit_at_45, over_black] = seen;
    let contrast = contrast_ratio(eye, spectra, all[COLOURS - 1]);
    let left_out = rows.iter().any(|row| BACKED.iter().any(|k| row.numbers()[*k].is_none()));
    let reason = match left_out {
        true => Some("its spectra have numbers that are withheld".to_owned()),
        false => impossible(Quantity::Share, contrast.estimate()),
    };
    let contrast_ratio = reason.is_none().then_some(contrast);
    withheld.extend(reason.map(|reason| Withheld { number: format!("contrast ratio of {um} µm"), reason }));
    (
        ComposedColours { thickness_um: um, hex, natural_light, lit_at_45, over_black, contrast_ratio },
        withheld,
    )
}

fn values(spectra: &LayerSpectra, place: usize) -> Vec<f64> {
    spectra.iter().map(|numbers| numbers[place].value).collect()
}

/// Errors of Lab due to what a spectrum may be between its wavelengths and beyond them.
fn between(eye: &Colorimeter, values: &[f64], xyz: [f64; 3]) -> Vec<[f64; 3]> {
    let mut shifts = eye.spacing(values, xyz, None);
    shifts.extend(eye.beyond(values, xyz));
    shifts
}

/// The contrast ratio with that error.
fn contrast_ratio(eye: &Colorimeter, spectra: &LayerSpectra, own: ErrorParts) -> ErrorParts {
    let [black, white] = BACKED.map(|place| values(spectra, place));
    let error = |values: &[f64]| eye.spacing_luminance(values, None).hypot(eye.beyond_luminance(values));
    let bright = eye.xyz(&white).map_or(f64::NAN, |xyz| xyz[1]);
    let wavelengths = error(&black).hypot(own.value * error(&white)) / bright;
    ErrorParts { wavelengths, ..own }.summed()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: f64, error: f64) -> Option<ErrorParts> {
        Some(ErrorParts { value, chance: error, ..ErrorParts::default() }.summed())
    }

    fn row(wavelength_nm: f64) -> ComposedRow {
        let share = number(0.3, 0.01);
        ComposedRow {
            thickness_um: 3.0,
            wavelength_nm,
            reflectance_normal: share,
            transmittance_normal: share,
            reflectance_45: share,
            transmittance_45: share,
            reflectance_diffuse: share,
            transmittance_diffuse: share,
            coherent_transmittance: share,
            mirrored: share,
            natural_light: share,
            lit_at_45: share,
            over_black: share,
            over_white: share,
        }
    }

    #[test]
    fn numbers_that_cannot_be_are_withheld_and_others_stay() {
        let mut all = [450.0, 550.0, 650.0].map(row);
        assert!(rows(&mut all).is_empty());
        all[1].reflectance_45 = number(-0.05, 1e-4);
        all[2].reflectance_45 = number(f64::NAN, 1e-4);
        all[0].lit_at_45 = number(8.3, 0.08);
        all[0].natural_light = number(1.2, 0.01);
        all[2].transmittance_diffuse = number(0.8, 0.01);
        let withheld = rows(&mut all);
        let words: Vec<_> = withheld.iter().map(Withheld::in_words).collect();
        assert_eq!(words.len(), 4, "{words:?}");
        assert!(words[0].starts_with("reflectance_45 of 3 µm") && words[0].contains("2 of its"), "{words:?}");
        assert!(words[1].starts_with("natural_light") && words[1].contains("above 1"), "{words:?}");
        assert!(words[2].starts_with("lit_at_45") && words[2].contains("450 nm"), "{words:?}");
        assert!(words[3].contains("R + T = 1.1"), "{words:?}");
        assert_eq!([all[1].reflectance_45, all[2].transmittance_diffuse, all[0].lit_at_45], [None; 3]);
        assert!(all[1].transmittance_45.is_some() && all[0].over_black.is_some());
    }

    /// Three wavelengths 120 nm apart say little about a colour, and a withheld number takes its
    /// colour along.
    #[test]
    fn colours_hold_what_the_wavelengths_leave_open() {
        let error = |nm: &[f64]| {
            let eye = Colorimeter::new(nm).unwrap();
            let spectra: LayerSpectra = nm
                .iter()
                .map(|nm| std::array::from_fn(|_| number(0.2 + 0.6 * (nm - 400.0) / 300.0, 1e-3).unwrap()))
                .collect();
            let mut rows: Vec<_> = nm.iter().map(|nm| row(*nm)).collect();
            let all = std::array::from_fn(|_| number(0.5, 0.1).unwrap());
            let (colours, withheld) = super::colours(&eye, &spectra, &rows, &all);
            assert!(withheld.is_empty(), "{withheld:?}");
            rows[1].natural_light = None;
            let (less, withheld) = super::colours(&eye, &spectra, &rows, &all);
            assert!(less.natural_light.is_none() && less.hex.is_none() && less.lit_at_45.is_some());
            assert_eq!(withheld.len(), 1);
            assert!(colours.contrast_ratio.unwrap().wavelengths >= 0.0);
            let lab = colours.natural_light.unwrap();
            lab.iter().map(|part| part.wavelengths.powi(2)).sum::<f64>().sqrt()
        };
        let coarse = error(&[440.0, 560.0, 680.0]);
        let fine = error(&(0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect::<Vec<_>>());
        assert!(coarse > 2.0 && fine < 0.5, "{coarse} {fine}");
    }
}
