//! Spectra that an instrument would measure on the print, every 10 nm, with the Lab that these have
//! under the study's light.

use super::request::{ExportError, ExportResult};
use crate::appearance::colour::Colour;
use crate::appearance::tristimulus::Colorimeter;
use crate::appearance::tristimulus::lagrange_shares;
use crate::appearance::tristimulus::visible;
use crate::appearance::viewing::Viewing;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;

/// Step of exported spectra: with 20 nm the summation rules of other programs move Lab by ΔE 0.15.
const STEP_NM: f64 = 10.0;
/// Wavelengths nearer than this to a multiple of the step count as that multiple.
const SLACK_NM: f64 = 1e-6;

/// Illumination and viewing of the print.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InstrumentGeometry {
    /// Lit at 45°, seen along the normal (ISO 13655).
    LitAt45,
    /// Under a uniform sky, seen along the normal.
    NaturalLight,
}

/// One spectrum of reflectance factors (perfect white diffuser: 1).
#[derive(Clone, Debug)]
pub struct PrintSpectrum {
    /// Light and view.
    pub geometry: InstrumentGeometry,
    /// One value per wavelength, with its standard error where it is known.
    pub values: Vec<Estimate>,
    /// Covariance of their Lab.
    pub lab_covariance: Option<[[f64; 3]; 3]>,
    /// Colour of these values under the study's light, if they suffice for one.
    pub colour: Option<Colour>,
    /// Lab of the study's own page under the same light.
    pub page_lab: Option<[f64; 3]>,
}

/// All spectra of a print, and where they come from.
#[derive(Clone, Debug)]
pub struct Print {
    /// The study's heading.
    pub title: String,
    /// Content hash of the study.
    pub study_hash: String,
    /// Date and time of the export, RFC 3339.
    pub created: String,
    /// Light, observer and rule of summation of the colours.
    pub viewing: Viewing,
    /// The light that excites the paper, where it fluoresces.
    pub exciting: Option<String>,
    /// True where the spectra were interpolated to the grid, and not evaluated on it.
    pub interpolated: bool,
    /// A uniform grid, nm.
    pub wavelengths_nm: Vec<u32>,
    /// The spectra on that grid.
    pub spectra: Vec<PrintSpectrum>,
}

impl InstrumentGeometry {
    /// Both of them.
    pub const ALL: [Self; 2] = [Self::LitAt45, Self::NaturalLight];

    /// What belongs to this geometry.
    pub fn of<T>(self, lit_at_45: T, natural_light: T) -> T {
        match self {
            Self::LitAt45 => lit_at_45,
            Self::NaturalLight => natural_light,
        }
    }

    /// Name for readers.
    pub fn name(self) -> &'static str {
        self.of("45:0", "uniform sky, 0")
    }

    /// Name for identifiers.
    pub fn id(self) -> &'static str {
        self.of("lit_at_45", "natural_light")
    }
}

/// Largest difference of L*, a* or b* between file and page that needs no explanation: the page's
/// rounding.
const ROUNDING: f64 = 0.005;

impl Print {
    /// A study's spectra on the grid of `bands`, with the colours of their own values.
    pub(super) fn new(study: &Study, created: &str, bands: Bands, print: PrintSpectra) -> Self {
        let PrintSpectra { mut spectra, interpolated, has_colours } = print;
        let meter = bands.meter.filter(|_| has_colours);
        for spectrum in &mut spectra {
            let reflectance: Vec<f64> = spectrum.values.iter().map(|e| e.value).collect();
            let colour = meter.as_ref().and_then(|meter| meter.colour(&reflectance).ok());
            spectrum.colour = colour.map(|c| Colour { lab_covariance: spectrum.lab_covariance, ..c });
        }
        Self {
            title: study.title.clone(),
            study_hash: study.key().to_string(),
            created: created.to_owned(),
            viewing: study.judgement.viewing.clone(),
            exciting: study.paper.fluorescence.as_ref().map(|_| Viewing::default().illuminant().to_owned()),
            interpolated,
            wavelengths_nm: bands.wavelengths_nm,
            spectra,
        }
    }

    /// Where the spectra of the file come from.
    pub fn spectra_from(&self) -> &'static str {
        match self.interpolated {
            true => {
                "interpolated to every 10 nm from the study's listed wavelengths (four points, ASTM E2022)"
            }
            false => "evaluated every 10 nm from the fitted spectra, not interpolated",
        }
    }

    /// Why Lab of the file differs from that of the study's page, and the page's values; or that
    /// both round alike.
    pub fn lab_note(&self) -> String {
        let pages: Vec<String> = self.spectra.iter().filter_map(PrintSpectrum::page_lab_if_other).collect();
        if pages.is_empty() {
            return "as on the study's page".to_owned();
        }
        let sums = match self.interpolated {
            true => "the study's own wavelengths",
            false => "all solves, including what their fitted spectra smooth out,",
        };
        format!(
            "Lab is computed from the spectrum in this file, every 10 nm, so that other programs find the same; the study's \
             page sums {sums} and has {}",
            pages.join("; ")
        )
    }
}

impl PrintSpectrum {
    fn page_lab_if_other(&self) -> Option<String> {
        let in_file = self.colour.as_ref()?.lab;
        let page = self.page_lab?;
        let other = (0..3).any(|i| (in_file[i] - page[i]).abs() > ROUNDING);
        let [l, a, b] = page;
        other.then(|| format!("L* {l:.2} a* {a:.2} b* {b:.2} ({})", self.geometry.name()))
    }
}

/// The spectra of a print on the wavelengths of its file.
pub(super) struct PrintSpectra {
    /// Without colours yet.
    pub spectra: Vec<PrintSpectrum>,
    /// Whether they were interpolated to these wavelengths.
    pub interpolated: bool,
    /// Whether the study's numbers hold colours.
    pub has_colours: bool,
}

/// Wavelengths of a file, and the colorimeter that sums over them, if they suffice for colours.
pub(super) struct Bands {
    /// A uniform grid, nm.
    pub wavelengths_nm: Vec<u32>,
    /// Sums spectra on that grid to colours.
    pub meter: Option<Colorimeter>,
}

impl Bands {
    /// Every 10 nm inside those of a study's wavelengths that colours can take.
    pub fn new(study: &Study, format: &str) -> ExportResult<Self> {
        let seen = &study.wavelengths_nm[visible(&study.wavelengths_nm)];
        let wavelengths_nm = uniform_grid(seen);
        if wavelengths_nm.len() < 2 || seen.len() < 2 {
            let needed =
                "needs at least two multiples of 10 nm inside the study's wavelengths, within 380 to 780 nm";
            return Err(ExportError::Refused(format!("{format} {needed}")));
        }
        let nm: Vec<f64> = wavelengths_nm.iter().map(|&nm| f64::from(nm)).collect();
        let meter = Colorimeter::under(&nm, &study.judgement.viewing).ok();
        Ok(Self { wavelengths_nm, meter })
    }
}

/// Multiples of 10 nm inside a grid of rising wavelengths.
fn uniform_grid(wavelengths_nm: &[f64]) -> Vec<u32> {
    let (Some(first), Some(last)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
        return Vec::new();
    };
    let from = ((first - SLACK_NM) / STEP_NM).ceil() as u32;
    let to = ((last + SLACK_NM) / STEP_NM).floor() as u32;
    (from..=to).map(|k| k * STEP_NM as u32).collect()
}

/// Resamples a spectrum: values by the rule that colours use (four points, ASTM E2022), standard
/// errors linearly, since statistical errors at neighbouring wavelengths of one packing are
/// correlated. Where the rule leads below zero beside a steep edge, the least of the four points
/// stands, with what was left out as an error.
pub fn resample(wavelengths_nm: &[f64], values: &[Estimate], grid: &[u32]) -> Vec<Estimate> {
    grid.iter()
        .map(|&nm| {
            let shares = lagrange_shares(wavelengths_nm, f64::from(nm));
            let value: f64 = shares.iter().map(|&(j, share)| share * values[j].value).sum();
            let standard_error = error_between(wavelengths_nm, values, f64::from(nm));
            let least = shares.iter().fold(f64::INFINITY, |least, &(j, _)| values[j].value.min(least));
            if value >= 0.0 || least < 0.0 {
                return Estimate { value, standard_error };
            }
            let beside = least - value;
            Estimate { value: least, standard_error: standard_error.map(|error| error.hypot(beside)) }
        })
        .collect()
}

fn error_between(wavelengths_nm: &[f64], values: &[Estimate], nm: f64) -> Option<f64> {
    let after = wavelengths_nm.partition_point(|&x| x < nm).clamp(1, wavelengths_nm.len() - 1);
    let lo = wavelengths_nm[after - 1];
    let hi = wavelengths_nm[after];
    let t = ((nm - lo) / (hi - lo)).clamp(0.0, 1.0);
    Some((1.0 - t) * values[after - 1].standard_error? + t * values[after].standard_error?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_of_20_nm_becomes_one_of_10_and_keeps_its_values() {
        let nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
        let cubic = |x: f64| 1e-6 * (x - 550.0).powi(3) / 100.0 + 0.4;
        let values: Vec<Estimate> =
            nm.iter().map(|&x| Estimate { value: cubic(x), standard_error: Some(x * 1e-5) }).collect();
        let grid = uniform_grid(&nm);
        assert_eq!((grid[0], grid[1], grid.len()), (400, 410, 31));
        let fine = resample(&nm, &values, &grid);
        assert_eq!(fine[2], values[1]);
        // inside, four points carry a cubic: rounding alone
        assert!((fine[7].value - cubic(470.0)).abs() < 1e-14);
        assert!((fine[7].standard_error.unwrap() - 470.0e-5).abs() < 1e-12);
    }

    /// Beside a steep edge nothing is below zero. *Planted*: the rule's value there.
    #[test]
    fn a_dark_spectrum_stays_above_zero_beside_an_edge() {
        let nm: Vec<f64> = (0..6).map(|i| 440.0 + 20.0 * f64::from(i)).collect();
        let dark = |value: f64| Estimate { value, standard_error: Some(1e-4) };
        let values = [0.004, 0.003, 0.003, 0.005, 0.4, 0.8].map(dark);
        let fine = resample(&nm, &values, &[490, 510]);
        assert_eq!(fine[0].value, 0.003);
        assert!(fine[0].standard_error.unwrap() > 0.01 && fine[1].value > 0.0, "{fine:?}");
    }

    #[test]
    fn wavelengths_off_the_grid_are_not_extrapolated() {
        assert_eq!(uniform_grid(&[405.0, 500.0, 691.0]), (41..=69).map(|k| 10 * k).collect::<Vec<u32>>());
        assert_eq!(uniform_grid(&[]), Vec::<u32>::new());
    }
}
