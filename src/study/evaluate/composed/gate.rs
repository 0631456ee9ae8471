//! Numbers of a composed layer that cannot be are withheld, with the reason.

use super::between::Fringes;
use crate::appearance::colour::Colour;
use crate::appearance::tristimulus::{Colorimeter, Guide};
use crate::evaluate::gate::{Brightest, impossible, impossible_colour, withhold};
use crate::evaluate::manifest::composed::{ComposedColours, ComposedRow, independent};
use crate::evaluate::published::{ErrorParts, PublishedRow, Quantity, Withheld};
use crate::evaluate::quantities::{ColourNumbers, Lab, LayerNumbers};
use crate::numerics::estimate::Estimate;
use std::ops::Range;

/// R and T of one kind of light, which add up to 1 at most.
struct LightTotals {
    names: &'static str,
    reflectance: fn(&mut ComposedRow) -> &mut Option<ErrorParts>,
    transmittance: fn(&mut ComposedRow) -> &mut Option<ErrorParts>,
}

const TOTALS: [LightTotals; 3] = [
    LightTotals {
        names: "reflectance_normal and transmittance_normal",
        reflectance: |row| &mut row.layer.reflectance_normal,
        transmittance: |row| &mut row.layer.transmittance_normal,
    },
    LightTotals {
        names: "reflectance_45 and transmittance_45",
        reflectance: |row| &mut row.layer.reflectance_45,
        transmittance: |row| &mut row.layer.transmittance_45,
    },
    LightTotals {
        names: "reflectance_diffuse and transmittance_diffuse",
        reflectance: |row| &mut row.layer.reflectance_diffuse,
        transmittance: |row| &mut row.layer.transmittance_diffuse,
    },
];

/// Withholds what cannot be of the rows of one thickness; on paper that fluoresces factors may be
/// above 1.
pub fn rows(rows: &mut [ComposedRow], fluoresces: bool) -> Vec<Withheld> {
    let mut withheld = Vec::new();
    let Some(first) = rows.first() else { return withheld };
    let um = first.thickness_um;
    for (k, number) in first.numbers().into_iter().enumerate() {
        let brightened = fluoresces && number.name == "natural_light";
        let quantity = if brightened { Quantity::Factor } else { number.quantity };
        let reason = |row: &mut ComposedRow| impossible(quantity, row.numbers()[k].estimate?);
        let title = format!("{} of {um} µm", number.in_words);
        withheld.extend(withhold(rows, title, reason, |row| row.layer.withhold(number.name)));
    }
    for LightTotals { names, reflectance, transmittance } in TOTALS {
        let reason = |row: &mut ComposedRow| {
            let r = (*reflectance(row))?;
            let t = (*transmittance(row))?;
            let error = r.standard_error.hypot(t.standard_error);
            let sum = Estimate { value: r.value + t.value, standard_error: Some(error) };
            Some(format!("R + T = {}", impossible(Quantity::Share, sum)?))
        };
        let remove = |row: &mut ComposedRow| {
            *reflectance(row) = None;
            *transmittance(row) = None;
        };
        withheld.extend(withhold(rows, format!("{names} of {um} µm"), reason, remove));
    }
    withheld
}

/// A spectrum of a layer.
#[derive(Clone, Copy)]
struct LayerSpectrum {
    /// Of its rows; `None` where it is withheld.
    rows: fn(&ComposedRow) -> Option<ErrorParts>,
    /// Of its numbers.
    of: fn(&LayerNumbers<f64>) -> f64,
}

const OVER_BLACK: LayerSpectrum =
    LayerSpectrum { rows: |row| row.layer.over_black, of: |layer| layer.over_black };
const OVER_WHITE: LayerSpectrum =
    LayerSpectrum { rows: |row| row.layer.over_white, of: |layer| layer.over_white };

/// A colour that can be, with the bars of its L*, a*, b*.
struct JudgedColour {
    colour: Colour,
    lab: Lab<ErrorParts>,
}

/// What a colour owes to the paper alone.
#[derive(Clone, Copy, Default)]
struct SeenPaper {
    /// What it leaves open of L*, a*, b* between the wavelengths.
    open: [f64; 3],
    /// X, Y, Z beyond those of the factors ([`ColourNumbers::beyond_factors`]).
    beyond: [f64; 3],
}

/// The rows of one thickness and the eye that sums them to colours.
pub struct LayerInColour<'a> {
    /// The eye.
    pub eye: &'a Colorimeter,
    /// The rows before the gate.
    pub all: &'a [ComposedRow],
    /// The rows after the gate.
    pub kept: &'a [ComposedRow],
    /// What the paper does between the wavelengths, of L*, a*, b* of the bare paper.
    pub paper: [f64; 3],
    /// Whether the paper fluoresces, so that prints may be lighter than white.
    pub fluoresces: bool,
    /// What fringes change at the wavelengths of the layer and between them, and the places of the
    /// rows among these wavelengths.
    pub fringes: Option<(&'a Fringes, Range<usize>)>,
}

impl LayerInColour<'_> {
    /// The colours with the bars that the wavelengths give them, as far as they can be.
    pub fn colours(&self, numbers: &ColourNumbers<ErrorParts>) -> (ComposedColours, Vec<Withheld>) {
        let thickness_um = self.all.first().map_or(f64::NAN, |row| row.thickness_um);
        let mut withheld = Vec::new();
        let mut keep = |judged: Result<JudgedColour, String>, name: &str| match judged {
            Ok(judged) => Some(judged),
            Err(reason) => {
                let number = format!("colour of {thickness_um} µm {name}");
                withheld.push(Withheld { number, reason });
                None
            }
        };
        let sky = Brightest::under_sky(self.fluoresces);
        let one_side = Brightest::AboveWhite;
        let [natural_beyond, lit_beyond] =
            numbers.beyond_factors.map(|xyz| SeenPaper { open: self.paper, beyond: xyz.map(|c| c.value) });
        let no_paper = SeenPaper::default();
        let natural_light =
            LayerSpectrum { rows: |row| row.layer.natural_light, of: |layer| layer.natural_light };
        let natural_light = self.judged(natural_light, numbers.natural_light, (sky, natural_beyond));
        let natural_light = keep(natural_light, "under natural light");
        let lit_at_45 = LayerSpectrum { rows: |row| row.layer.lit_at_45, of: |layer| layer.lit_at_45 };
        let lit_at_45 = self.judged(lit_at_45, numbers.lit_at_45, (one_side, lit_beyond));
        let lit_at_45 = keep(lit_at_45, "at 45:0");
        let over_black = self.judged(OVER_BLACK, numbers.over_black, (one_side, no_paper));
        let over_black = keep(over_black, "at 45:0 over black");
        let contrast_ratio = match self.contrast_ratio(numbers.contrast_ratio) {
            Ok(ratio) => Some(ratio),
            Err(reason) => {
                withheld.push(Withheld { number: format!("contrast ratio of {thickness_um} µm"), reason });
                None
            }
        };
        let hex = natural_light.as_ref().map(|judged| {
            let [r, g, b] = judged.colour.srgb8;
            format!("#{r:02x}{g:02x}{b:02x}")
        });
        let lab = |judged: Option<JudgedColour>| Some(judged?.lab);
        let colours = ComposedColours {
            thickness_um,
            hex,
            colour: natural_light
                .as_ref()
                .map(|judged| Colour { lab_covariance: Some(independent(judged.lab)), ..judged.colour }),
            natural_light: lab(natural_light),
            lit_at_45: lab(lit_at_45),
            over_black: lab(over_black),
            contrast_ratio,
        };
        (colours, withheld)
    }

    /// The colour of a spectrum, whose Lab has these bars but for what the wavelengths leave open;
    /// the reason if it cannot be.
    fn judged(
        &self,
        spectrum: LayerSpectrum,
        lab: Lab<ErrorParts>,
        (brightest, paper): (Brightest, SeenPaper),
    ) -> Result<JudgedColour, String> {
        let values = self.values(spectrum);
        let factors = self.eye.xyz(&values).map_err(|error| error.to_string())?;
        let colour = self.eye.colour_of(std::array::from_fn(|c| factors[c] + paper.beyond[c]));
        let films = self.guides(spectrum);
        let mut shifts = self.eye.spacing_of_films(&values, colour.xyz, films.as_ref());
        shifts.extend(self.eye.beyond(&values, colour.xyz));
        shifts.push(paper.open);
        let lab: Lab<ErrorParts> = std::array::from_fn(|c| {
            let wavelengths = shifts.iter().fold(0.0, |sum: f64, shift| sum.hypot(shift[c]));
            ErrorParts { wavelengths, ..lab[c] }.summed()
        });
        if self.lacks(spectrum) {
            return Err("its spectrum has numbers that are withheld".to_owned());
        }
        match impossible_colour(&colour, Some(lab.map(|part| part.standard_error)), brightest) {
            Some(reason) => Err(reason),
            None => Ok(JudgedColour { colour, lab }),
        }
    }

    /// The contrast ratio with what the wavelengths leave open; the reason if it cannot be.
    fn contrast_ratio(&self, ratio: ErrorParts) -> Result<ErrorParts, String> {
        let white = self.values(OVER_WHITE);
        let error = |spectrum: LayerSpectrum| {
            let values = self.values(spectrum);
            let spacing = match self.guides(spectrum) {
                Some([film, quarter]) => {
                    let spacing = self.eye.spacing_luminance(&values, Some(&film));
                    spacing.hypot(self.eye.missed_luminance(&quarter))
                }
                None => self.eye.spacing_luminance(&values, None),
            };
            spacing.hypot(self.eye.beyond_luminance(&values))
        };
        let bright = self.eye.xyz(&white).map_or(f64::NAN, |xyz| xyz[1]);
        let wavelengths = error(OVER_BLACK).hypot(ratio.value * error(OVER_WHITE)) / bright;
        let ratio = ErrorParts { wavelengths, ..ratio }.summed();
        if self.lacks(OVER_BLACK) || self.lacks(OVER_WHITE) {
            return Err("its spectra have numbers that are withheld".to_owned());
        }
        impossible(Quantity::Share, ratio.estimate()).map_or(Ok(ratio), Err)
    }

    /// What fringes change of a spectrum at the wavelengths and between them.
    fn guides(&self, spectrum: LayerSpectrum) -> Option<[Guide; 2]> {
        let (fringes, seen) = self.fringes.as_ref()?;
        Some(fringes.guides(seen.clone(), spectrum.of))
    }

    /// The values of a spectrum before the gate.
    fn values(&self, spectrum: LayerSpectrum) -> Vec<f64> {
        self.all.iter().map(|row| (spectrum.rows)(row).map_or(f64::NAN, |number| number.value)).collect()
    }

    /// Whether the gate has left out a number of a spectrum.
    fn lacks(&self, spectrum: LayerSpectrum) -> bool {
        self.kept.iter().any(|row| (spectrum.rows)(row).is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(value: f64, error: f64) -> Option<ErrorParts> {
        Some(ErrorParts { value, chance: error, ..ErrorParts::default() }.summed())
    }

    /// A row whose numbers are all the same.
    fn row(wavelength_nm: f64, share: Option<ErrorParts>) -> ComposedRow {
        let layer = LayerNumbers::<Option<ErrorParts>>::default().map(|_| share);
        ComposedRow { thickness_um: 3.0, wavelength_nm, layer }
    }

    #[test]
    fn numbers_that_cannot_be_are_withheld_and_others_stay() {
        let mut all = [450.0, 550.0, 650.0].map(|nm| row(nm, number(0.3, 0.01)));
        assert!(rows(&mut all, false).is_empty());
        all[1].layer.reflectance_45 = number(-0.05, 1e-4);
        all[2].layer.reflectance_45 = number(f64::NAN, 1e-4);
        all[0].layer.lit_at_45 = number(8.3, 0.08);
        all[0].layer.natural_light = number(1.2, 0.01);
        all[2].layer.transmittance_diffuse = number(0.8, 0.01);
        let withheld = rows(&mut all, false);
        let words: Vec<_> = withheld.iter().map(Withheld::in_words).collect();
        assert_eq!(words.len(), 4, "{words:?}");
        assert!(words[0].starts_with("reflectance_45 of 3 µm") && words[0].contains("2 of its"), "{words:?}");
        assert!(words[1].starts_with("natural_light") && words[1].contains("above 1"), "{words:?}");
        assert!(words[2].starts_with("lit_at_45") && words[2].contains("450 nm"), "{words:?}");
        assert!(words[3].contains("R + T = 1.1"), "{words:?}");
        let [first, second, third] = all.map(|row| row.layer);
        assert_eq!([second.reflectance_45, third.transmittance_diffuse, first.lit_at_45], [None; 3]);
        assert!(second.transmittance_45.is_some() && first.over_black.is_some());
    }

    /// Three wavelengths 120 nm apart say little about a colour, and a withheld number takes its
    /// colour along.
    #[test]
    fn colours_hold_what_the_wavelengths_leave_open() {
        let error = |nm: &[f64]| {
            let eye = Colorimeter::new(nm).unwrap();
            let rising = |nm: f64| row(nm, number(0.2 + 0.6 * (nm - 400.0) / 300.0, 1e-3));
            let rows: Vec<_> = nm.iter().map(|nm| rising(*nm)).collect();
            let mut kept = rows.clone();
            let numbers = ColourNumbers::unknown().map(|_| number(0.5, 0.1).unwrap());
            let (colours, withheld) = LayerInColour {
                eye: &eye,
                all: &rows,
                kept: &kept,
                paper: [0.0; 3],
                fluoresces: false,
                fringes: None,
            }
            .colours(&numbers);
            assert!(withheld.is_empty(), "{withheld:?}");
            kept[1].layer.natural_light = None;
            let (less, withheld) = LayerInColour {
                eye: &eye,
                all: &rows,
                kept: &kept,
                paper: [0.0; 3],
                fluoresces: false,
                fringes: None,
            }
            .colours(&numbers);
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
