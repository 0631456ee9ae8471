//! Response surfaces: spectra of the layer over paper, black and white, less those of its coherent
//! film, as polynomials over the box.

use crate::appearance::colour::ciede2000;
use crate::appearance::paper::PRINT_DEG;
use crate::appearance::tristimulus::Colorimeter;
use crate::appearance::tristimulus::visible;
use crate::appearance::viewing::ColourError;
use crate::evaluate::ink::{InkError, InkOnPaper};
use crate::evaluate::ink_maker::{BLACK, WHITE, in_own_light};
use crate::evaluate::on_paper::LayerOnPaper;
use crate::input::fault::Fault;
use crate::input::measured::MeasuredSpectrum;
use crate::input::study::Study;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::f64::consts::PI;
use std::ops::Range;

/// Relative weight of the coefficients' own size: a guard against fewer data than coefficients.
const RIDGE: f64 = 1e-4;

/// Spectra over the paper, over black and over white, one after another.
pub type Spectra3 = Vec<f64>;

/// Coefficients of a surface: everything up to the second degree, and the cubes.
pub fn most_coefficients(variables: usize) -> usize {
    (variables + 1) * (variables + 2) / 2 + variables
}

/// The polynomials at a point of the box.
fn monomials(places: &[f64]) -> Vec<f64> {
    let x: Vec<f64> = places.iter().map(|p| 2.0 * p - 1.0).collect();
    let mut all = vec![1.0];
    all.extend(&x);
    for i in 0..x.len() {
        all.extend((i..x.len()).map(|j| x[i] * x[j]));
    }
    all.extend(x.iter().map(|x| x.powi(3)));
    all
}

/// Spectra of a study's ink lit at 45° and seen along the normal, under the study's own light where
/// its paper fluoresces.
///
/// # Errors
/// The ink on its paper has none.
pub fn spectra(study: &Study, ink: &InkOnPaper) -> Result<Spectra3, InkError> {
    let relit = in_own_light(study, ink)?;
    let ink = relit.as_ref().unwrap_or(ink);
    let (light, view) = (ink.at(PRINT_DEG)?, ink.at(0.0)?);
    let factor = |layer: &LayerOnPaper| PI * layer.brdf(&light, &view);
    let over = |albedo: f64| ink.spectrum(|layer| factor(&layer.over(albedo))).values;
    Ok([ink.spectrum(factor).values, over(BLACK), over(WHITE)].concat())
}

/// A measured target may begin here and end there, nm: its end values stand for what is missing
/// beyond, 3 to 6 % of Z and at most 2 % of X below and 0.6 % above. Instruments without
/// ultraviolet light (M2) begin at 420 nm.
const TARGET_NM: [f64; 2] = [420.0, 680.0];

/// The colour that a design aims at.
pub struct WantedColour {
    /// L*, a*, b*.
    pub lab: [f64; 3],
    /// What was taken for what its file lacks.
    pub remark: Option<String>,
}

impl WantedColour {
    /// That of a study, summed over those of the study's wavelengths that are seen.
    ///
    /// # Errors
    /// The study has none, or a spectrum that lacks too much of them.
    pub fn of(study: &Study) -> Result<Self, Vec<Fault>> {
        let judgement = &study.judgement;
        if let Some(lab) = judgement.target_lab {
            return Ok(Self { lab, remark: None });
        }
        let seen = &study.wavelengths_nm[visible(&study.wavelengths_nm)];
        let no_colour = |error: ColourError| {
            let remedy = "give [light] of the base 400 to 700 nm";
            vec![Fault::new("base.light", error, "wavelengths that carry a colour", remedy)]
        };
        let (Some(&first), Some(&last)) = (seen.first(), seen.last()) else {
            return Err(no_colour(ColourError::TooFewWavelengths { count: 0 }));
        };
        let covers = |m: &&MeasuredSpectrum| {
            let [from, to] = m.range_nm();
            from <= first.max(TARGET_NM[0]) && to >= last.min(TARGET_NM[1])
        };
        let Some(measured) = judgement.measured.as_ref().filter(covers) else {
            let range = |m: &MeasuredSpectrum| format!("{:?} nm", m.range_nm());
            let found = judgement.measured.as_ref().map_or("nothing".into(), range);
            let [from, to] = [first.max(TARGET_NM[0]), last.min(TARGET_NM[1])];
            let allowed = format!("a spectrum that covers {from} to {to} nm, or a colour");
            let remedy = "narrow [light] of the base, or give lab";
            return Err(vec![Fault::new("target.file", found, allowed, remedy)]);
        };
        let range_nm = [first, last];
        let colour = |m: &MeasuredSpectrum| m.colour(&judgement.viewing, range_nm).map_err(no_colour);
        let whole = colour(&measured.extended(range_nm))?;
        let [from, to] = measured.range_nm();
        let remark = if from <= first && to >= last {
            None
        } else {
            let moved = ciede2000(whole.lab, colour(measured)?.lab);
            Some(format!(
                "target.file: measured from {from} to {to} nm, and colours here are sums over {first} to {last} nm: its end values are \
                 taken beyond (ASTM E308); without these wavelengths the target would be {moved:.2} away (ΔE₀₀)"
            ))
        };
        Ok(Self { lab: whole.lab, remark })
    }
}

/// Light and observer, and the wavelengths that are summed over.
pub struct Eye {
    meter: Colorimeter,
    waves: usize,
    /// Those of the wavelengths that colours take.
    visible: Range<usize>,
}

impl Eye {
    /// That of a study.
    ///
    /// # Errors
    /// Wavelengths that carry no colour.
    pub fn new(study: &Study) -> Result<Self, ColourError> {
        let visible = visible(&study.wavelengths_nm);
        let meter = Colorimeter::under(&study.wavelengths_nm[visible.clone()], &study.judgement.viewing)?;
        Ok(Self { meter, waves: study.wavelengths_nm.len(), visible })
    }

    /// L*, a*, b* over the paper, and the contrast ratio.
    ///
    /// # Errors
    /// Values that are no numbers.
    pub fn sees(&self, spectra: &[f64]) -> Result<([f64; 3], f64), ColourError> {
        let spectrum = |k: usize| &spectra[k * self.waves..(k + 1) * self.waves];
        let colour = |k: usize| self.meter.colour(&spectrum(k)[self.visible.clone()]);
        let print = colour(0)?;
        let black = colour(1)?;
        let white = colour(2)?;
        Ok((print.lab, black.xyz[1] / white.xyz[1].max(1e-9)))
    }
}

/// Polynomials for every wavelength and backing.
pub struct Surfaces {
    coefficients: Mat<f64>,
    /// What the surfaces without a variant predict for it less what it has: variant → wavelength
    /// and backing.
    pub left_out: Vec<Spectra3>,
}

impl Surfaces {
    /// Fits differences from the film at points of the box.
    pub fn new(places: &[Vec<f64>], differences: &[Spectra3]) -> Option<Self> {
        let rows: Vec<Vec<f64>> = places.iter().map(|p| monomials(p)).collect();
        let count = rows.first()?.len();
        let columns = differences.first()?.len();
        let matrix = Mat::from_fn(rows.len(), count, |i, j| rows[i][j]);
        // a constant is the mean: nothing is interpolated
        let ridge = if count > 1 { RIDGE * rows.len() as f64 } else { 0.0 };
        let ridge = Mat::from_fn(count, count, |i, j| if i == j { ridge } else { 0.0 });
        let factors = (matrix.transpose() * &matrix + ridge).llt(Side::Lower).ok()?;
        let values = Mat::from_fn(rows.len(), columns, |i, j| differences[i][j]);
        let coefficients = factors.solve(matrix.transpose() * &values);
        let fitted = &matrix * &coefficients;
        let influence = &matrix * factors.solve(matrix.transpose());
        let left =
            |i: usize, j: usize| (fitted[(i, j)] - values[(i, j)]) / (1.0 - influence[(i, i)]).max(0.05);
        let left_out = (0..rows.len()).map(|i| (0..columns).map(|j| left(i, j)).collect()).collect();
        Some(Self { coefficients, left_out })
    }

    /// Differences from the film at a point of the box.
    pub fn at(&self, places: &[f64]) -> Spectra3 {
        let row = monomials(places);
        (0..self.coefficients.ncols())
            .map(|j| row.iter().enumerate().map(|(i, x)| x * self.coefficients[(i, j)]).sum())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_recovered_and_leaving_one_out_changes_nothing() {
        let f = |p: &[f64]| vec![1.0 + p[0] - 2.0 * p[0] * p[1], 3.0 * p[1] * p[1]];
        let places: Vec<Vec<f64>> =
            (0..20).map(|k| vec![(0.618 * f64::from(k)).fract(), (0.755 * f64::from(k)).fract()]).collect();
        let values: Vec<Spectra3> = places.iter().map(|p| f(p)).collect();
        let surfaces = Surfaces::new(&places, &values).unwrap();
        let here = surfaces.at(&[0.3, 0.8]);
        let there = f(&[0.3, 0.8]);
        // the guard against too few data pulls by its weight
        assert!(here.iter().zip(&there).all(|(a, b)| (a - b).abs() < 2e-3), "{here:?} {there:?}");
        assert!((0..20).all(|i| surfaces.left_out[i].iter().all(|e| e.abs() < 2e-2)));
        assert_eq!(monomials(&[0.1, 0.2, 0.3]).len(), most_coefficients(3));
    }
}
