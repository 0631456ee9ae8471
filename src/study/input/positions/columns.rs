//! The columns of a table of spheres, and the values of its rows.

use super::Positions;
use crate::ink::Sphere;
use crate::ink::packing::sizes::MOST_GRAINS;

/// A column of lengths: µm = `offset_um` + `factor_um` × value.
#[derive(Clone, Copy)]
pub(super) struct LengthColumn {
    pub column: usize,
    pub factor_um: f64,
    pub offset_um: f64,
}

impl LengthColumn {
    pub(super) fn new(column: usize, factor_um: f64) -> Self {
        Self { column, factor_um, offset_um: 0.0 }
    }

    fn read(&self, words: &[impl AsRef<str>], line: usize) -> Result<f64, String> {
        let word = words[self.column].as_ref();
        let value = word.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| format!("line {line}: {word:?} where a number is needed"))?;
        Ok(self.offset_um + self.factor_um * value)
    }
}

/// Where the numbers of a row are.
pub(super) struct PositionColumns {
    /// Number of columns that the file names.
    pub count: usize,
    /// Columns of x, y and z.
    pub center: [LengthColumn; 3],
    pub radius: LengthColumn,
    pub pigment: Option<usize>,
    pub grain: Option<usize>,
    /// Whether grain 0 means none, as molecule 0 of a dump does.
    pub zero_is_alone: bool,
}

impl PositionColumns {
    /// The values of a row, whose number must be that of the columns.
    pub(super) fn read(
        &self,
        words: &[impl AsRef<str>],
        line: usize,
        into: &mut Positions,
    ) -> Result<(), String> {
        if words.len() != self.count {
            return Err(format!(
                "line {line}: {} values where {} columns are named",
                words.len(),
                self.count
            ));
        }
        let [x, y, z] = self.center;
        let center_um = [x.read(words, line)?, y.read(words, line)?, z.read(words, line)?];
        let radius_um = self.radius.read(words, line)?;
        if radius_um <= 0.0 {
            return Err(format!("line {line}: a sphere of radius {radius_um} µm"));
        }
        if into.spheres.len() >= MOST_GRAINS {
            return Err(format!("line {line}: more than {MOST_GRAINS} spheres in one cut"));
        }
        into.spheres.push(Sphere { center_um, radius_um });
        let word = |column: usize| words[column].as_ref().to_owned();
        into.pigments.extend(self.pigment.map(word));
        if let Some(grain) = self.grain.map(word) {
            let is_alone = self.zero_is_alone && grain == "0";
            into.grains.push(if is_alone { format!("line {line}") } else { grain });
        }
        Ok(())
    }
}
