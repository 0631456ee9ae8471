//! The cases of a comparison: the one that is named, or all pigments and periods of a matrix.

use super::file::{ComparedCase, ComparisonFile};
use crate::error::CompareResult;
use crate::ink::Sphere;
use crate::input::case::Case;
use crate::input::fault::Fault;
use crate::input::load::stem;
use crate::input::wave_kind::WaveKind;
use crate::numerics::files;
use crate::row::Varied;
use crate::subject::Packed;
use crate::wave::{BodyShape, Media};
use serde_json::{Value, json};
use std::path::Path;

/// A case before it is packed.
pub(super) struct Subject {
    pub varied: Option<Varied>,
    /// Its name where several files are compared.
    pub named: Option<String>,
    pub wave: WaveKind,
    geometry: CaseGeometry,
}

enum CaseGeometry {
    Packed(Box<Packed>),
    /// A case file, and its text as read.
    Written(Box<Case>, Value),
}

impl Subject {
    /// Reads or packs the geometry.
    pub fn case(&self) -> CompareResult<Case> {
        match &self.geometry {
            CaseGeometry::Packed(packed) => packed.case(),
            CaseGeometry::Written(case, _) => Ok(Case::clone(case)),
        }
    }

    /// The indices of all media; a study is checked for it.
    pub fn media(&self) -> CompareResult<Media> {
        match &self.geometry {
            CaseGeometry::Packed(packed) => packed.media(),
            CaseGeometry::Written(case, _) => Ok(case.media.clone()),
        }
    }

    /// Name, wave and reference of one of several cases, for the page.
    pub fn shown(&self) -> Option<[String; 3]> {
        Some([self.named.clone()?, self.wave.name().into(), self.reference().into()])
    }

    /// Whether this case has the packing of the one before.
    pub fn is_packed_like(&self, other: &Subject) -> bool {
        self.varied.zip(other.varied).is_some_and(|(own, other)| own.period_um == other.period_um)
    }

    /// Amplitudes of its wave given in a case file.
    pub fn known(&self) -> Option<&[Value]> {
        let CaseGeometry::Written(_, json) = &self.geometry else { return None };
        let orders = json.pointer("/outputs/orders")?.as_array()?;
        let of_both = orders.first().is_some_and(|order| order["R"].is_object());
        (of_both == (self.wave == WaveKind::Vector)).then_some(orders)
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
        match (self.known(), self.wave) {
            (Some(_), _) => "the case file's own amplitudes",
            (None, WaveKind::Scalar) => {
                "those of krylov on cubic cells, with 1.5 times as many points and cells as the finest grid"
            }
            (None, WaveKind::Vector) => {
                "those of krylov with 1.5 times as many points and cells as the finest grid"
            }
        }
    }
}

impl ComparisonFile {
    /// All cases; the study itself if nothing varies.
    pub(super) fn subjects(&self) -> CompareResult<Vec<Subject>> {
        if let Some(path) = &self.case {
            return Ok(vec![self.subject(None, self.written(path, None)?)]);
        }
        if !self.cases.is_empty() {
            return self.cases.iter().map(|table| self.listed_case(table)).collect();
        }
        let packed = self.packed()?;
        let Some(matrix) = &self.matrix else {
            return Ok(vec![self.subject(None, CaseGeometry::Packed(Box::new(packed)))]);
        };
        let all = matrix.cases().map(|v| Ok((v, CaseGeometry::Packed(Box::new(packed.varied(v)?)))));
        all.map(|case| case.map(|(varied, geometry)| self.subject(Some(varied), geometry))).collect()
    }

    fn subject(&self, varied: Option<Varied>, geometry: CaseGeometry) -> Subject {
        Subject { varied, named: None, wave: self.wave, geometry }
    }

    fn listed_case(&self, table: &ComparedCase) -> CompareResult<Subject> {
        let named = table.name.clone().or(table.id.clone()).unwrap_or_else(|| stem(&table.file));
        let subject = self.subject(None, self.written(&table.file, table.id.as_deref())?);
        Ok(Subject { named: Some(named), wave: table.wave.unwrap_or(self.wave), ..subject })
    }

    /// A case file with its text, or one of the cases that a file lists.
    fn written(&self, path: &Path, id: Option<&str>) -> CompareResult<CaseGeometry> {
        let path = self.folder().join(path);
        let text = files::read_text(&path, files::CASE).unwrap_or_default();
        let json =
            serde_json::from_str(&text).or_else(|_| toml::from_str::<Value>(&text)).unwrap_or_default();
        let Some(id) = id else { return one_direction(Case::read(&path)?, json) };
        let Some(case) = json["cases"].as_array().into_iter().flatten().find(|case| case["id"] == id) else {
            let allowed = format!("an `id` among the `cases` of {}", path.display());
            let remedy = "leave `id` out for a file with one case";
            return Err(Fault::new("cases.id", format!("{id:?}"), allowed, remedy).into());
        };
        one_direction(Case::parse(&case["inputs"].to_string(), false)?, case.clone())
    }
}

/// A case with its text, if it has a single direction.
fn one_direction(case: Case, text: Value) -> CompareResult<CaseGeometry> {
    if case.directions.is_empty() {
        return Ok(CaseGeometry::Written(Box::new(case), text));
    }
    let found = format!("a list of {}", case.directions.len());
    let remedy = "give `sigma_deg`, `phi_deg` and `from` instead of the list";
    Err(Fault::new("directions", found, "one direction in a comparison", remedy).into())
}

/// A packed layer of spheres with the keys of a case file.
fn inputs_of(case: &Case) -> Result<Value, String> {
    let scene = &case.scene;
    let media = &case.media;
    let [stratum] = &scene.strata[..] else { return Err(NO_CASE.into()) };
    let index = |eta: num_complex::Complex64| [eta.re, eta.im];
    let mut spheres = Vec::new();
    for body in &scene.bodies {
        let BodyShape::Balls(balls) = &body.shape else { return Err(NO_CASE.into()) };
        let [Sphere { center_um, radius_um }] = balls[..] else { return Err(NO_CASE.into()) };
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
