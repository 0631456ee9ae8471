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

/// x̄, ȳ, z̄ of an observer (`2`, `10`, `2015_2` or `2015_10`) at a whole number of nm; `None` for
/// unknown names and outside 380 to 780 nm.
pub(super) fn matching_functions(observer: &str, nm: usize) -> Option<[f64; 3]> {
    let function = |letter: char| OBSERVERS.value(&format!("{letter}_{observer}"), nm);
    Some([function('x')?, function('y')?, function('z')?])
}

#[cfg(test)]
mod tests {
    use super::*;

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
