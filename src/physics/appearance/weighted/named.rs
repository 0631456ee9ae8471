//! Tables of weights by name: the sun, sunburn, densitometers, and the CIE's illuminants with its
//! observers.

use super::table::WeightTable;
use super::{WeightedSum, WhitePoint};
use crate::appearance::cie;
use crate::appearance::tristimulus::TABLE_RANGE_NM;
use crate::appearance::viewing::{Summation, Viewing};
use std::sync::LazyLock;

/// A file of this program: columns of weights below their names.
struct WeightFile {
    names: Vec<&'static str>,
    rows: Vec<Vec<f64>>,
}

impl WeightFile {
    /// Reads it: remarks, names, numbers. What is no number becomes NaN, which a test excludes.
    fn read(text: &'static str) -> Self {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let names = lines.next().unwrap_or_default().split(',').skip(1).collect();
        let numbers = |line: &str| line.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect();
        Self { names, rows: lines.map(numbers).collect() }
    }

    /// Rows of wavelength and weight of a column.
    fn column(&self, name: &str) -> Option<Vec<[f64; 2]>> {
        let column = 1 + self.names.iter().position(|known| *known == name)?;
        Some(self.rows.iter().map(|row| [row[0], row[column]]).collect())
    }
}

static SOLAR: LazyLock<WeightFile> = LazyLock::new(|| WeightFile::read(include_str!("../weights/solar.csv")));
static DENSITY: LazyLock<WeightFile> =
    LazyLock::new(|| WeightFile::read(include_str!("../weights/density.csv")));
static ILLUMINANT_C: LazyLock<WeightFile> =
    LazyLock::new(|| WeightFile::read(include_str!("../weights/illuminant_c.csv")));

/// Weights of the skin under the sun: `solar_g173` times the erythemal action spectrum.
const ERYTHEMA: &str = "erythema_g173";

/// Names of all single tables. Weights of an observer are written as illuminant and observer, such
/// as `D65/10`.
pub fn weight_names() -> Vec<&'static str> {
    [&SOLAR.names[..], &[ERYTHEMA], &DENSITY.names].concat()
}

/// Erythemal action spectrum of the skin, ISO/CIE 17166:2019, relative.
fn erythema(nm: f64) -> f64 {
    match nm {
        _ if nm <= 298.0 => 1.0,
        _ if nm <= 328.0 => 10.0_f64.powf(0.094 * (298.0 - nm)),
        _ if nm <= 400.0 => 10.0_f64.powf(0.015 * (140.0 - nm)),
        _ => 0.0,
    }
}

/// Weights by name: one table, or those of X, Y, Z.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedWeights {
    /// The name in the form of the lists.
    pub name: String,
    /// One table, or those of X, Y, Z.
    pub tables: Vec<WeightTable>,
    /// The perfect white, of X, Y, Z.
    pub white: Option<WhitePoint>,
}

impl NamedWeights {
    /// The weights of a name; `None` if it is unknown.
    pub fn find(name: &str) -> Option<Self> {
        let name = name.trim();
        if let Some((illuminant, observer)) = name.split_once('/') {
            return Self::of_observer(illuminant.trim(), observer.trim());
        }
        let name = weight_names().into_iter().find(|known| known.eq_ignore_ascii_case(name))?;
        let rows = match name {
            ERYTHEMA => {
                let sun = SOLAR.column("solar_g173")?.into_iter().take_while(|row| row[0] <= 400.0);
                sun.map(|[nm, weight]| [nm, weight * erythema(nm)]).collect()
            }
            _ => SOLAR.column(name).or_else(|| DENSITY.column(name))?,
        };
        let table = WeightTable::new(rows).ok()?;
        Some(Self { name: name.to_owned(), tables: vec![table], white: None })
    }

    /// Illuminant times matching functions, nm by nm.
    fn of_observer(illuminant: &str, observer: &str) -> Option<Self> {
        let is_c = illuminant.eq_ignore_ascii_case("C");
        let viewing = Viewing::new(if is_c { "E" } else { illuminant }, observer, Summation::Plain).ok()?;
        let table_c = WeightTable::new(ILLUMINANT_C.column("C")?).ok()?;
        let [lo, hi] = TABLE_RANGE_NM.map(|nm| nm as usize);
        let light = |nm: usize| match is_c {
            true => Some(table_c.at(nm as f64)),
            false => cie::illuminant(viewing.illuminant(), nm),
        };
        let channel = |c: usize| {
            let row = |nm: usize| {
                Some([nm as f64, light(nm)? * cie::matching_functions(viewing.observer(), nm)?[c].max(0.0)])
            };
            WeightTable::new((lo..=hi).map(row).collect::<Option<Vec<_>>>()?).ok()
        };
        let tables = (0..3).map(channel).collect::<Option<Vec<_>>>()?;
        let luminous = tables[1].total();
        let illuminant = if is_c { "C" } else { viewing.illuminant() }.to_owned();
        let observer = viewing.observer().to_owned();
        let name = format!("{illuminant}/{observer}");
        let xyz = std::array::from_fn(|c| 100.0 * tables[c].total() / luminous);
        Some(Self { name, tables, white: Some(WhitePoint { xyz, illuminant, observer }) })
    }

    /// The sums of all tables over a grid of wavelengths, nm.
    pub fn sums(&self, wavelengths_nm: &[f64]) -> Vec<WeightedSum> {
        self.tables.iter().map(|table| WeightedSum::new(wavelengths_nm, table)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every name has its table; the sun's has the irradiance of its range, 992.6 W/m² of 1000.4
    /// up to 4000 nm. *Planted*: the direct column for the global one, a row that lacks a number.
    #[test]
    fn tables_are_complete() {
        for name in weight_names() {
            assert!(NamedWeights::find(name).is_some(), "{name}");
        }
        let total = |name: &str| NamedWeights::find(name).unwrap().tables[0].total();
        assert!((total("solar_g173") - 992.579).abs() < 0.001, "{}", total("solar_g173"));
        assert!((total("solar_g173_direct") - 892.6).abs() < 1.0, "{}", total("solar_g173_direct"));
        for (file, count) in [(&SOLAR, 1702), (&DENSITY, 43), (&ILLUMINANT_C, 81)] {
            assert!(file.rows.iter().flatten().all(|x| x.is_finite()) && file.rows.len() == count);
        }
        assert_eq!(NamedWeights::find("status_x_red"), None);
        assert_eq!(NamedWeights::find("D65/3"), None);
    }

    /// Whites of CIE 15: D65 (95.047, 108.883) and, for 10°, (94.811, 107.304); C (98.074,
    /// 118.232).
    #[test]
    fn whites_are_the_published_ones() {
        for (name, x, z) in
            [("D65/2", 95.047, 108.883), ("D65/10", 94.811, 107.304), ("c/2", 98.074, 118.232)]
        {
            let white = NamedWeights::find(name).unwrap().white.unwrap();
            // published ones are sums every 5 nm
            assert!((white.xyz[0] - x).abs() < 0.02 && (white.xyz[2] - z).abs() < 0.1, "{name}: {white:?}");
        }
    }
}
