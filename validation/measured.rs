//! Opaque paints that were measured, beside what Mie's theory and radiative transfer say of the listed materials. Both tell
//! the record from the solver: where this estimate misses a paint, the record, the grains or the surface do.

use crate::formulas::opaque::OpaquePaint;
use inkwave::appearance::colour::ciede2000;
use inkwave::appearance::tristimulus::Colorimeter;
use inkwave::appearance::viewing::{Summation, Viewing};
use inkwave::material::spectra::Spectrum;
use rayon::prelude::*;

/// Binder of all paints here: acrylic and oil have 1.48 to 1.52.
const BINDER: f64 = 1.5;
/// Standard deviation of the logarithm of the grains' diameters.
const SPREAD: f64 = 0.3;
/// Optical thickness of all paints here.
const OPAQUE: f64 = 500.0;
/// Saunderson's two numbers in Okumura's thesis.
const SAUNDERSON: [f64; 2] = [0.0308, 0.606];

/// One group of paints with a listed material that may be their pigment.
#[derive(Clone, Copy, Debug)]
pub struct Comparison {
    /// Material of the program's list.
    pub material: &'static str,
    /// Median diameter of its grains, µm.
    pub diameter_um: f64,
    /// Table, and the beginning of the names of its columns.
    pub paints: (&'static str, &'static str),
    /// What the comparison shows.
    pub reason: &'static str,
}

/// All comparisons of colours.
pub const COMPARISONS: &[Comparison] = &[
    Comparison {
        material: "magnetite (Jena)",
        diameter_um: 0.2,
        paints: (MASSTONES, "PBk11"),
        reason: "surface: paints return 1 to 2 % that no smooth face does; with it the record is as neutral as they are",
    },
    Comparison {
        material: "magnetite (Querry)",
        diameter_um: 0.2,
        paints: (MASSTONES, "PBk11"),
        reason: "record: κ of 0.03 at 450 nm, a thirtieth of the other one, makes it blue-violet",
    },
    Comparison {
        material: "haematite (Longtin)",
        diameter_um: 0.2,
        paints: (MASSTONES, "PR101"),
        reason: "record: κ beyond 600 nm (0.001 at 694) is too small: K/S at 700 nm of a red oxide is 0.16, here 0.009; an orange",
    },
    Comparison {
        material: "haematite (Querry)",
        diameter_um: 0.2,
        paints: (MASSTONES, "PR101"),
        reason: "record: κ beyond 600 nm (0.03 at 700) is too large: K/S at 700 nm of a red oxide is 0.16, here 0.78; a brown",
    },
    Comparison {
        material: "CdS",
        diameter_um: 0.3,
        paints: (MASSTONES, "PY35"),
        reason: "pigment: PY35 holds zinc, which moves the edge to the blue, 30 nm further in the second paint",
    },
    Comparison {
        material: "TiO2 rutile",
        diameter_um: 0.25,
        paints: (KIMERA, "white"),
        reason: "record: κ from 400 to 420 nm, which makes whites a little yellow, is in none of the three; thickness not stated",
    },
    Comparison {
        material: "haematite (Longtin)",
        diameter_um: 0.2,
        paints: (KIMERA, "red_oxide"),
        reason: "record: as for PR101",
    },
    Comparison {
        material: "haematite (Querry)",
        diameter_um: 0.2,
        paints: (KIMERA, "red_oxide"),
        reason: "record: as for PR101",
    },
];

/// Reflectances of masstones.
pub const MASSTONES: &str = include_str!("data/measured/masstones.csv");
/// Masstones and tints of one maker.
pub const KIMERA: &str = include_str!("data/measured/kimera.csv");
/// K and S of paints in units of the S of titanium white.
pub const OKUMURA: &str = include_str!("data/measured/okumura.csv");

/// Columns of a table: wavelengths in nm, and the spectra by name.
pub struct SpectraTable {
    pub nm: Vec<f64>,
    pub spectra: Vec<(String, Vec<f64>)>,
}

/// Reads a table of spectra.
pub fn table(text: &str) -> SpectraTable {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let names: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let rows: Vec<Vec<f64>> = reader
        .records()
        .map(|row| row.expect("a row").iter().map(|cell| cell.parse().expect("a number")).collect())
        .collect();
    let column = |i: usize| rows.iter().map(|row| row[i]).collect::<Vec<f64>>();
    let spectra = names.iter().cloned().enumerate().skip(1).map(|(i, name)| (name, column(i)));
    SpectraTable { nm: column(0), spectra: spectra.collect() }
}

/// One paint beside the estimate.
#[derive(Clone, Debug)]
pub struct Compared {
    pub paint: String,
    pub measured_lab: [f64; 3],
    pub estimated_lab: [f64; 3],
    /// ΔE₀₀ of both.
    pub delta_e: f64,
    /// Light from the paint's surface: the measured excess where the estimate is darkest.
    pub surface: f64,
    /// ΔE₀₀ once the estimate has that light at every wavelength.
    pub with_surface: f64,
    /// Measured and estimated reflectance factors.
    pub measured: Vec<f64>,
    pub estimated: Vec<f64>,
}

/// L*, a*, b* under D50 for 2°.
fn lab(nm: &[f64], values: &[f64]) -> [f64; 3] {
    let viewing = Viewing::new("D50", "2", Summation::E308).expect("known names");
    Colorimeter::under(nm, &viewing).and_then(|meter| meter.colour(values)).expect("a colour").lab
}

/// The estimate's reflectance factors at 45:0.
pub fn estimate(material: &str, diameter_um: f64, nm: &[f64]) -> Vec<f64> {
    let spectrum = Spectrum::material(material).expect("a listed material");
    let paint = OpaquePaint { diameter_um, spread: SPREAD, binder: BINDER };
    let at = |nm: &f64| {
        let index = spectrum.index(1e-3 * nm).expect("a wavelength of the record");
        paint.reflectance(index, 1e-3 * nm, OPAQUE)
    };
    nm.par_iter().map(at).collect()
}

impl Comparison {
    /// Every paint of the group.
    pub fn compared(&self) -> Vec<Compared> {
        let (text, start) = self.paints;
        let SpectraTable { nm, spectra } = table(text);
        let own = |name: &str| name == start || (start.starts_with('P') && name.starts_with(start));
        let estimated = estimate(self.material, self.diameter_um, &nm);
        let estimated_lab = lab(&nm, &estimated);
        let darkest = (0..nm.len()).min_by(|&i, &j| estimated[i].total_cmp(&estimated[j])).expect("rows");
        let of = |(paint, measured): (String, Vec<f64>)| {
            let measured_lab = lab(&nm, &measured);
            let surface = (measured[darkest] - estimated[darkest]).max(0.0);
            let raised: Vec<f64> = estimated.iter().map(|r| r + surface * (1.0 - r)).collect();
            Compared {
                delta_e: ciede2000(measured_lab, estimated_lab),
                with_surface: ciede2000(measured_lab, lab(&nm, &raised)),
                estimated: estimated.clone(),
                paint,
                measured_lab,
                estimated_lab,
                surface,
                measured,
            }
        };
        spectra.into_iter().filter(|(name, _)| own(name)).map(of).collect()
    }
}

/// The largest ΔE₀₀ between two of some paints; 0 for a single one.
pub fn spread(paints: &[Compared]) -> f64 {
    let pairs =
        paints.iter().flat_map(|a| paints.iter().map(move |b| ciede2000(a.measured_lab, b.measured_lab)));
    pairs.fold(0.0, f64::max)
}

/// K/S of an opaque paint by Saunderson's correction, for a reflectance without the gloss.
pub fn k_over_s(reflectance: f64) -> f64 {
    let [k1, k2] = SAUNDERSON;
    let inside = reflectance / ((1.0 - k1) * (1.0 - k2) + k2 * reflectance);
    (1.0 - inside).powi(2) / (2.0 * inside)
}

/// K/S as measured and as estimated, at every wavelength: nm, measured, estimated.
pub fn ratios(column: &str, material: &str, diameter_um: f64) -> Vec<[f64; 3]> {
    let SpectraTable { nm, spectra } = table(OKUMURA);
    let of = |start: &str| {
        &spectra.iter().find(|(name, _)| *name == format!("{start}_{column}")).expect("a column").1
    };
    let estimated = estimate(material, diameter_um, &nm);
    let k = of("K");
    let s = of("S");
    (0..nm.len()).map(|i| [nm[i], k[i] / s[i], k_over_s(estimated[i])]).collect()
}

/// The index that `inkwave fit` found from one masstone, and the tint that `inkwave run` makes of it.
pub const FITTED: &str = include_str!("data/measured/red_oxide_fit.csv");
/// Parts of weight of red and white in the tint.
const TINT: [f64; 2] = [0.20, 0.35];

/// A measured tint beside two predictions from the masstones.
pub struct PredictedTint {
    pub nm: Vec<f64>,
    /// By name: measured and fitted masstone, κ with its error, measured and predicted tint.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Kubelka and Munk's.
    pub two_fluxes: Vec<f64>,
    /// ΔE₀₀ of the wave's and of Kubelka and Munk's to the measured tint.
    pub delta_e: [f64; 2],
}

/// The tint of red oxide with white at the wavelengths of the fit. Kubelka and Munk have both masstones: K/S of the mixture is
/// the mean by weight, as if both paints scattered alike.
pub fn predicted_tint() -> PredictedTint {
    let (kimera, fitted) = (table(KIMERA), table(FITTED));
    let column = |of: &SpectraTable, start: &str| -> Vec<f64> {
        of.spectra.iter().find(|(name, _)| name.starts_with(start)).expect("a column").1.clone()
    };
    let on_grid = |nm: f64| kimera.nm.iter().position(|own| *own == nm).expect("a wavelength of the paints");
    let places: Vec<usize> = fitted.nm.iter().map(|nm| on_grid(*nm)).collect();
    let measured = |name: &str| -> Vec<f64> {
        let all = column(&kimera, name);
        places.iter().map(|&place| all[place]).collect()
    };
    let all_two_fluxes: Vec<f64> = column(&kimera, "red_oxide")
        .iter()
        .zip(column(&kimera, "white"))
        .map(|(red, white)| {
            let [a, b] = TINT;
            of_k_over_s((a * k_over_s(*red) + b * k_over_s(white)) / (a + b))
        })
        .collect();
    let tint = column(&kimera, "red_oxide_white");
    let predicted = column(&fitted, "tint_predicted");
    // between the wavelengths of the fit the ratio to the measured tint is linear
    let ratio: Vec<[f64; 2]> = places
        .iter()
        .zip(&predicted)
        .map(|(&place, value)| [kimera.nm[place], value / tint[place]])
        .collect();
    let at = |nm: f64| {
        let after = ratio.partition_point(|row| row[0] < nm).clamp(1, ratio.len() - 1);
        let ([x, a], [y, b]) = (ratio[after - 1], ratio[after]);
        a + ((nm - x) / (y - x)).clamp(0.0, 1.0) * (b - a)
    };
    let wave: Vec<f64> = kimera.nm.iter().zip(&tint).map(|(nm, value)| value * at(*nm)).collect();
    let of_tint = lab(&kimera.nm, &tint);
    let mut columns = vec![
        ("masstone measured".to_owned(), measured("red_oxide")),
        ("tint measured".to_owned(), measured("red_oxide_white")),
    ];
    columns.extend(fitted.spectra);
    PredictedTint {
        two_fluxes: places.iter().map(|&place| all_two_fluxes[place]).collect(),
        delta_e: [&wave, &all_two_fluxes].map(|values| ciede2000(of_tint, lab(&kimera.nm, values))),
        nm: fitted.nm,
        columns,
    }
}

/// Reflectance without the gloss of an opaque paint of this K/S, by Saunderson's correction.
fn of_k_over_s(ratio: f64) -> f64 {
    let [k1, k2] = SAUNDERSON;
    let inside = 1.0 + ratio - (ratio * ratio + 2.0 * ratio).sqrt();
    (1.0 - k1) * (1.0 - k2) * inside / (1.0 - k2 * inside)
}
