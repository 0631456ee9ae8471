//! The CIE's tables, one row a nanometre from 380 to 780 nm: relative spectral power of the
//! standard illuminants (CIE 15:2018) and colour-matching functions of the standard observers.

use std::sync::LazyLock;

/// First wavelength of the tables, nm.
const FIRST_NM: usize = 380;

/// Columns of numbers below their names.
struct CieTable {
    names: Vec<&'static str>,
    rows: Vec<Vec<f64>>,
}

impl CieTable {
    /// Reads a file of this program: remarks, names, numbers. What is no number becomes NaN, which
    /// a test excludes.
    fn read(text: &'static str) -> Self {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let names = lines.next().unwrap_or_default().split(',').skip(1).collect();
        let numbers = |line: &str| line.split(',').skip(1).map(|x| x.parse().unwrap_or(f64::NAN)).collect();
        Self { names, rows: lines.map(numbers).collect() }
    }

    /// Value of a column at a whole number of nm; `None` outside the table.
    fn value(&self, name: &str, nm: usize) -> Option<f64> {
        let column = self.names.iter().position(|known| *known == name)?;
        self.rows.get(nm.checked_sub(FIRST_NM)?)?.get(column).copied()
    }
}

static ILLUMINANTS: LazyLock<CieTable> =
    LazyLock::new(|| CieTable::read(include_str!("cie/illuminants.csv")));
static OBSERVERS: LazyLock<CieTable> = LazyLock::new(|| CieTable::read(include_str!("cie/observers.csv")));

/// Names of the illuminants, such as `D65`, in the order in which they are offered.
pub(super) fn illuminant_names() -> &'static [&'static str] {
    &ILLUMINANTS.names
}

/// Relative spectral power of an illuminant at a whole number of nm; `None` for unknown names and
/// outside 380 to 780 nm.
pub(super) fn illuminant(name: &str, nm: usize) -> Option<f64> {
    ILLUMINANTS.value(name, nm)
}

/// Daylight from 300 to 380 nm in steps of 5 nm (CIE 15:2018): D65 and D50.
const DAYLIGHT_UV: [[f64; 2]; 17] = [
    [0.0341, 0.02],
    [1.6643, 1.03],
    [3.2945, 2.05],
    [11.7652, 4.91],
    [20.236, 7.78],
    [28.6447, 11.26],
    [37.0535, 14.75],
    [38.5011, 16.35],
    [39.9488, 17.95],
    [42.4302, 19.48],
    [44.9117, 21.01],
    [45.775, 22.48],
    [46.6383, 23.94],
    [49.3637, 25.45],
    [52.0891, 26.96],
    [51.0323, 25.72],
    [49.9755, 24.4875],
];

/// Relative spectral power of an illuminant at any wavelength from 300 to 780 nm, in the unit of
/// [`illuminant`]; 0 outside. Below 380 nm daylight is tabulated, A follows Planck's law, E is
/// even, and lamps, for which the CIE states nothing, count as dark.
pub(super) fn power(name: &str, nm: f64) -> f64 {
    let between = |low: f64, high: f64, share: f64| low + share * (high - low);
    if (380.0..=780.0).contains(&nm) {
        let below = (nm.floor() as usize).min(779);
        let at = |nm: usize| illuminant(name, nm).unwrap_or(0.0);
        return between(at(below), at(below + 1), nm - below as f64);
    }
    if !(300.0..380.0).contains(&nm) {
        return 0.0;
    }
    let daylight = |column: usize| {
        let place = (nm - 300.0) / 5.0;
        let below = (place.floor() as usize).min(DAYLIGHT_UV.len() - 2);
        between(DAYLIGHT_UV[below][column], DAYLIGHT_UV[below + 1][column], place - below as f64)
    };
    match name {
        "D65" => daylight(0),
        "D50" => daylight(1),
        "E" => 1.0,
        "A" => {
            let planck = |nm: f64| nm.powi(-5) / ((1.435e7 / (2848.0 * nm)).exp() - 1.0);
            100.0 * planck(nm) / planck(560.0)
        }
        _ => 0.0,
    }
}

/// x̄, ȳ, z̄ of an observer (`2`, `10`, `2015_2` or `2015_10`) at a whole number of nm; `None` for
/// unknown names and outside 380 to 780 nm.
pub(super) fn matching_functions(observer: &str, nm: usize) -> Option<[f64; 3]> {
    let function = |letter: char| OBSERVERS.value(&format!("{letter}_{observer}"), nm);
    Some([function('x')?, function('y')?, function('z')?])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Daylight below 380 nm is that of the CIE's three components (CIE 15:2018, table T.2), which
    /// it is made of: M₁, M₂ of D65 and D50. *Planted*: the columns changed round.
    #[test]
    fn ultraviolet_daylight_is_the_sum_of_its_components() {
        let components = [
            [310.0, 6.0, 4.5, 2.0],
            [320.0, 29.6, 22.4, 4.0],
            [330.0, 55.3, 42.0, 8.5],
            [340.0, 57.3, 40.6, 7.8],
            [350.0, 61.8, 41.6, 6.7],
            [360.0, 61.5, 38.0, 5.3],
            [370.0, 68.8, 42.4, 6.1],
        ];
        for [nm, mean, first, second] in components {
            let of = |m1: f64, m2: f64| mean + m1 * first + m2 * second;
            // M₁ and M₂ are rounded to three digits: half of the last one times the components
            assert!((power("D65", nm) - of(-0.296, -0.688)).abs() < 0.06, "{nm}");
            assert!((power("D50", nm) - of(-1.040, 0.367)).abs() < 0.06, "{nm}");
        }
        // Planck's law joins the table of A
        assert!((power("A", 379.999) - 9.7951).abs() < 0.001);
        assert_eq!((power("D65", 380.0), power("D65", 380.5)), (49.9755, 0.5 * (49.9755 + 50.4428)));
        assert_eq!((power("F11", 350.0), power("D65", 299.0)), (0.0, 0.0));
    }

    /// Every table has its 401 rows of finite numbers, and columns are where their names say: D65
    /// and A are 100 at 560 nm, and the photopic eye is most sensitive at 555 nm. *Planted*: a row
    /// that lacks a number.
    #[test]
    fn tables_are_complete() {
        for table in [&ILLUMINANTS, &OBSERVERS] {
            assert_eq!(table.rows.len(), 401);
            let width = table.names.len();
            assert!(table.rows.iter().all(|row| row.len() == width && row.iter().all(|x| x.is_finite())));
        }
        assert_eq!(illuminant_names().len(), 39);
        assert_eq!(illuminant("D65", 560), Some(100.0));
        assert_eq!(illuminant("A", 560), Some(100.0));
        assert_eq!(matching_functions("2", 555), Some([0.5120501, 1.0, 0.005749999]));
        assert_eq!((illuminant("D65", 379), illuminant("D65", 781)), (None, None));
        assert_eq!(matching_functions("4", 555), None);
    }
}
