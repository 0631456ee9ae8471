//! The cases of a comparison: the one that is named, or all pigments and periods of a matrix.

use super::file::ComparisonFile;
use crate::compare::error::CompareError;
use crate::compare::row::Varied;
use crate::compare::subject::Packed;
use crate::input::case::Case;
use crate::numerics::files;
use crate::wave::{Ball, BodyShape, Media};
use serde_json::{Value, json};

/// A case before it is packed.
pub(super) struct Subject {
    pub varied: Option<Varied>,
    geometry: CaseGeometry,
}

enum CaseGeometry {
    Packed(Box<Packed>),
    /// A case file, and its text as read.
    Written(Box<Case>, Value),
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

    /// Amplitudes given in a case file.
    pub fn known(&self) -> Option<&[Value]> {
        match &self.geometry {
            CaseGeometry::Written(_, json) => json.pointer("/outputs/orders")?.as_array().map(Vec::as_slice),
            CaseGeometry::Packed(_) => None,
        }
    }

    /// The keys of a case file for programs that are asked to solve it.
    ///
    /// # Errors
    /// Shapes that case files do not have.
    pub fn inputs(&self, case: &Case) -> Result<Value, String> {
        match &self.geometry {
            CaseGeometry::Written(_, json) => Ok(json.get("inputs").unwrap_or(json).clone()),
            CaseGeometry::Packed(_) => inputs_of(case),
        }
    }

    /// Reference of the errors, in words.
    pub fn reference(&self) -> &'static str {
        match self.known() {
            Some(_) => "the case file's own amplitudes",
            None => {
                "those of krylov on cubic cells, with 1.5 times as many points and cells as the finest grid"
            }
        }
    }
}

impl ComparisonFile {
    /// All cases; the study itself if nothing varies.
    pub(super) fn subjects(&self) -> Result<Vec<Subject>, CompareError> {
        if let Some(path) = &self.case {
            let path = self.folder().join(path);
            let case = Box::new(Case::read(&path)?);
            let text = files::read_text(&path, files::CASE).unwrap_or_default();
            let json = serde_json::from_str(&text).or_else(|_| toml::from_str(&text));
            let geometry = CaseGeometry::Written(case, json.unwrap_or_default());
            return Ok(vec![Subject { varied: None, geometry }]);
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

/// A packed layer of spheres with the keys of a case file.
fn inputs_of(case: &Case) -> Result<Value, String> {
    let (scene, media) = (&case.scene, &case.media);
    let [stratum] = &scene.strata[..] else { return Err(NO_CASE.into()) };
    let index = |eta: num_complex::Complex64| [eta.re, eta.im];
    let mut spheres = Vec::new();
    for body in &scene.bodies {
        let BodyShape::Balls(balls) = &body.shape else { return Err(NO_CASE.into()) };
        let [Ball { center_um, radius_um }] = balls[..] else { return Err(NO_CASE.into()) };
        let eta = index(media.index_of(body.material));
        spheres.push(json!({ "center": center_um, "radius": radius_um, "eta": eta }));
    }
    Ok(json!({
        "wavelength": case.incidence.wavelength_um,
        "sigma_deg": case.incidence.polar_deg,
        "phi_deg": case.incidence.azimuth_deg,
        "from": case.incidence.from,
        "L": scene.period_um,
        "H": stratum.thickness_um,
        "n_in": index(media.incident),
        "n_out": index(media.exit),
        "eta_binder": index(media.backgrounds[stratum.background]),
        "spheres": spheres,
    }))
}

/// Why a packed layer cannot be put to programs.
const NO_CASE: &str = "not asked: case files have single spheres in one layer, and this one has other grains";
