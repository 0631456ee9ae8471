//! The cases of a comparison: the one that is named, or all pigments and periods of a matrix.

use super::file::ComparisonFile;
use crate::compare::error::CompareError;
use crate::compare::row::Varied;
use crate::compare::subject::Packed;
use crate::input::case::Case;
use crate::numerics::files;
use crate::wave::Media;

/// A case before it is packed.
pub(super) struct Subject {
    pub varied: Option<Varied>,
    geometry: CaseGeometry,
}

enum CaseGeometry {
    Packed(Box<Packed>),
    /// A case file, and the amplitudes that it has.
    Written(Box<Case>, Option<serde_json::Value>),
}

impl Subject {
    /// Reads or packs the geometry.
    pub fn case(&self) -> Result<Case, CompareError> {
        match &self.geometry {
            CaseGeometry::Packed(packed) => packed.case(),
            CaseGeometry::Written(case, _) => Ok(Case::clone(case)),
        }
    }

    /// The indices of all media; a study is checked for it.
    pub fn media(&self) -> Result<Media, CompareError> {
        match &self.geometry {
            CaseGeometry::Packed(packed) => packed.media(),
            CaseGeometry::Written(case, _) => Ok(case.media.clone()),
        }
    }

    /// Period of a case of a matrix, µm.
    pub fn period_um(&self) -> Option<f64> {
        self.varied.map(|varied| varied.period_um)
    }

    /// Amplitudes that a case file brings along.
    pub fn known(&self) -> Option<&[serde_json::Value]> {
        match &self.geometry {
            CaseGeometry::Written(_, known) => known.as_ref()?.as_array().map(Vec::as_slice),
            CaseGeometry::Packed(_) => None,
        }
    }

    /// What errors are measured against.
    pub fn reference(&self) -> &'static str {
        match self.known() {
            Some(_) => "the case file's own amplitudes",
            None => "krylov's on cubic cells, with half as many points and cells again as the finest grid",
        }
    }
}

impl ComparisonFile {
    /// Every case, the study as it stands when nothing varies.
    pub(super) fn subjects(&self) -> Result<Vec<Subject>, CompareError> {
        if let Some(path) = &self.case {
            let path = self.folder().join(path);
            let case = Box::new(Case::read(&path)?);
            let json = files::read_text(&path, files::CASE).ok();
            let json: Option<serde_json::Value> = json.and_then(|text| serde_json::from_str(&text).ok());
            let known = json.and_then(|json| json.pointer("/outputs/orders").cloned());
            return Ok(vec![Subject { varied: None, geometry: CaseGeometry::Written(case, known) }]);
        }
        let packed = self.packed()?;
        let packing = |packed| CaseGeometry::Packed(Box::new(packed));
        let Some(matrix) = &self.matrix else {
            return Ok(vec![Subject { varied: None, geometry: packing(packed) }]);
        };
        let subject = |varied: Varied| {
            let geometry = packing(packed.varied(varied.period_um, varied.pigment)?);
            Ok(Subject { varied: Some(varied), geometry })
        };
        matrix.cases().map(subject).collect()
    }
}
