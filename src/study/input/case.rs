//! A single solve of an explicit geometry: the `inputs` object of a reference case, as JSON or
//! TOML.

pub use super::case_inputs::CaseError;
use super::case_inputs::{
    BarInput, CaseInputs, CrystalInput, DirectionInput, IndexInput, NamedBody, SublayerInput,
};
use super::fault::{Fault, Faults};
use super::read::read;
use super::tree::{Node, parse_json, parse_toml};
use crate::ink::Form;
use crate::numerics::files;
use crate::wave::{Body, BodyShape, Incidence, Media, Scene, Stratum, Uniaxial, WaveError};
use num_complex::Complex64;
use std::path::Path;

/// A checked case, ready to be discretised.
#[derive(Clone, Debug)]
pub struct Case {
    /// The geometry.
    pub scene: Scene,
    /// Indices of all media.
    pub media: Media,
    /// The incident light; of a list of directions the first.
    pub incidence: Incidence,
    /// The lights of a list of directions; empty for a single one.
    pub directions: Vec<Incidence>,
    /// What may be a mistake, in words.
    pub remarks: Vec<String>,
}

impl Case {
    /// Reads a case file: the inputs themselves, or an object that contains them as `inputs`.
    pub fn read(path: &Path) -> Result<Case, CaseError> {
        let name = path.display().to_string();
        let text = files::read_text(path, files::CASE)
            .map_err(|cause| CaseError::Read { path: name.clone(), cause })?;
        Case::parse(&text, path.extension().is_some_and(|e| e == "toml")).map_err(|error| match error {
            CaseError::Refused { reason, .. } => CaseError::Refused { path: name, reason },
            other => other,
        })
    }

    /// Parses JSON, or TOML if `toml` is set.
    pub fn parse(text: &str, toml: bool) -> Result<Case, CaseError> {
        let document = if toml { parse_toml(text).map(Node::from) } else { parse_json(text) };
        let document = document
            .map_err(|fault| CaseError::refused(format!("{}; {}", fault.in_words(text), fault.remedy)))?;
        Case::from_inputs(&read(inputs(document)?).map_err(Faults)?)
    }

    /// Checks the inputs and builds the scene.
    fn from_inputs(inputs: &CaseInputs) -> Result<Case, CaseError> {
        let faults = super::case_checks::check(inputs);
        if !faults.0.is_empty() {
            return Err(faults.into());
        }
        let mut backgrounds = Vec::new();
        let mut inclusions = Vec::new();
        let strata = strata(inputs, &mut backgrounds)?;
        let named = inputs.bodies().into_iter().chain(inputs.birefringent_films());
        let (names, bodies): (Vec<String>, Vec<Body>) =
            named.map(|named| named.into_body(&mut inclusions)).unzip();
        let bars = inputs.sublayers_from_z0.iter().flatten().flat_map(|sublayer| &sublayer.bars);
        bars.into_iter().try_for_each(|bar| check_bar(bar, inputs.period_um()[0]))?;
        let strata = split_at_flat_faces(strata, &bodies);
        let scene = Scene { period_um: inputs.period_um(), strata, bodies, cut: false };
        let media = Media {
            incident: half_space("n_in", inputs.n_in, inputs.eta_in)?,
            exit: half_space("n_out", inputs.n_out, inputs.eta_out)?,
            backgrounds,
            inclusions,
        };
        let directions = directions(inputs);
        let incidence = directions.first().copied().unwrap_or(incidence(inputs));
        scene.check(&media).map_err(|error| with_names(error, &names))?;
        incidence.check()?;
        check_thickness(inputs, &scene)?;
        let scene = scene.nested().map_err(|error| with_names(error, &names))?;
        Ok(Case { scene, media, incidence, directions, remarks: inputs.remarks() })
    }
}

/// The light of `sigma_deg`, `phi_deg` and `from`.
fn incidence(inputs: &CaseInputs) -> Incidence {
    Incidence {
        wavelength_um: inputs.vacuum_wavelength_um().unwrap_or(f64::NAN),
        polar_deg: inputs.sigma_deg,
        azimuth_deg: inputs.phi_deg,
        from: inputs.from,
    }
}

/// The lights of the list of directions.
fn directions(inputs: &CaseInputs) -> Vec<Incidence> {
    let usual = incidence(inputs);
    let light = |direction: &DirectionInput| Incidence {
        polar_deg: direction.sigma_deg.unwrap_or(usual.polar_deg),
        azimuth_deg: direction.phi_deg.unwrap_or(usual.azimuth_deg),
        from: direction.from.unwrap_or(usual.from),
        ..usual
    };
    inputs.directions.iter().flatten().map(light).collect()
}

impl NamedBody {
    /// The body with its name; its indices join `inclusions`.
    fn into_body(self, inclusions: &mut Vec<Complex64>) -> (String, Body) {
        let ordinary = index_of(inclusions, self.eta);
        let body = match self.crystal {
            Some(CrystalInput { eta_extraordinary, optic_axis }) => {
                let extraordinary = index_of(inclusions, eta_extraordinary);
                Body::crystal(self.shape, Uniaxial { ordinary, extraordinary }, optic_axis)
            }
            None => Body::new(self.shape, ordinary),
        };
        (self.name, body)
    }
}

/// The keys of the case: all of the document, or its `inputs`, beside which none of them may stand.
fn inputs(document: Node) -> Result<Node, Fault> {
    let Some(inputs) = document.get("inputs") else { return Ok(document) };
    let schema = schemars::schema_for!(CaseInputs);
    let known = schema.get("properties").and_then(serde_json::Value::as_object).into_iter().flatten();
    let allowed = "all keys of the case in `inputs`";
    let remedy = "move it into `inputs`, or remove it";
    match known.map(|(key, _)| key).find(|key| *key != "note" && document.get(key).is_some()) {
        Some(key) => Err(Fault::new(key, "a key beside `inputs`", allowed, remedy)),
        None => Ok(inputs.clone()),
    }
}

/// The layers, whose distinct indices join `backgrounds`.
fn strata(inputs: &CaseInputs, backgrounds: &mut Vec<Complex64>) -> Result<Vec<Stratum>, CaseError> {
    // a binder beside sublayers of the same background is redundant, not an error
    let same = |l: &SublayerInput| Some(l.eta_background) == inputs.eta_binder;
    let repeated = inputs.sublayers_from_z0.as_ref().is_some_and(|all| all.iter().all(same));
    let binder = inputs.eta_binder.filter(|_| !repeated);
    let described = [inputs.layers_from_z0.is_some(), inputs.sublayers_from_z0.is_some(), binder.is_some()];
    if described.iter().filter(|&&d| d).count() != 1 {
        let found = if described.contains(&true) { "two descriptions" } else { "nothing" };
        let allowed = "exactly one of `eta_binder`, `layers_from_z0` and `sublayers_from_z0`";
        return Err(Fault::new("the layer", found, allowed, "describe the layer in one way").into());
    }
    let mut parts: Vec<(f64, [f64; 2])> = Vec::new();
    if let Some(eta) = binder {
        let missing = Fault::new("H", "nothing", "a length", "give the layer's thickness in µm");
        parts.push((inputs.thickness.ok_or(missing)?, eta));
    }
    parts.extend(inputs.layers_from_z0.iter().flatten().map(|l| (l.thickness, l.eta)));
    parts.extend(inputs.sublayers_from_z0.iter().flatten().map(|l| (l.thickness, l.eta_background)));
    if parts.is_empty() {
        return Err(Fault::new("layers_from_z0", "none", "at least one", "add a layer").into());
    }
    // a film of zero thickness has no effect, and would need a cell of zero height
    let stratum = |(thickness_um, eta)| Stratum { thickness_um, background: index_of(backgrounds, eta) };
    let strata: Vec<Stratum> = parts.into_iter().filter(|p| p.0 != 0.0).map(stratum).collect();
    if strata.is_empty() {
        let remedy = "give the layer a thickness above 0";
        return Err(Fault::new("thickness", "0 everywhere", "above 0", remedy).into());
    }
    Ok(strata)
}

/// Most heights of flat faces at which strata are divided.
const MOST_FACES: usize = 16;

/// Divides strata at the horizontal faces of bodies, which then lie on nodes of every grid: the
/// fields, whose derivatives jump there, keep their order of convergence.
fn split_at_flat_faces(strata: Vec<Stratum>, bodies: &[Body]) -> Vec<Stratum> {
    let mut faces: Vec<f64> = bodies.iter().flat_map(flat_faces).collect();
    let total: f64 = strata.iter().map(|s| s.thickness_um).sum();
    faces.sort_by(f64::total_cmp);
    faces.dedup_by(|a, b| *a - *b < 1e-6 * total);
    if faces.len() > MOST_FACES {
        return strata;
    }
    let mut split = Vec::new();
    let mut bottom = 0.0;
    for stratum in strata {
        let top = bottom + stratum.thickness_um;
        let inner = faces.iter().filter(|&&z| z > bottom + 1e-6 * total && z < top - 1e-6 * total);
        let ends: Vec<f64> = [bottom].into_iter().chain(inner.copied()).chain([top]).collect();
        split.extend(ends.windows(2).map(|p| Stratum { thickness_um: p[1] - p[0], ..stratum }));
        bottom = top;
    }
    split
}

/// Heights of a body's horizontal ends.
fn flat_faces(body: &Body) -> Vec<f64> {
    let BodyShape::Solid(solid) = &body.shape else { return Vec::new() };
    let up = solid.rotation.turn([0.0, 0.0, 1.0])[2].abs();
    let flat = up > 1.0 - 1e-12 && !matches!(solid.form, Form::Ellipsoid { .. });
    if flat { solid.extent_um(2).to_vec() } else { Vec::new() }
}

fn index_of(list: &mut Vec<Complex64>, [re, im]: [f64; 2]) -> usize {
    let eta = Complex64::new(re, im);
    list.iter().position(|e| *e == eta).unwrap_or_else(|| {
        list.push(eta);
        list.len() - 1
    })
}

fn half_space(name: &str, n: Option<IndexInput>, eta: Option<[f64; 2]>) -> Result<Complex64, CaseError> {
    if n.is_some() && eta.is_some() {
        let other = name.replace("n_", "eta_");
        return Err(Fault::new(name, format!("{name} and {other}"), "one of them", "give one of them").into());
    }
    let [re, im] = n.map(IndexInput::parts).or(eta).unwrap_or([1.0, 0.0]);
    Ok(Complex64::new(re, im))
}

fn check_bar(bar: &BarInput, period: f64) -> Result<(), CaseError> {
    let width = bar.x1 - bar.x0;
    if width > 0.0 && width <= period * (1.0 + 1e-12) {
        return Ok(());
    }
    let found = format!("from x0 = {} to x1 = {} µm", bar.x0, bar.x1);
    let allowed = format!("x0 < x1 and a width of at most the period, {period} µm");
    Err(Fault::new("bars", found, allowed, "make it narrower, or repeat it in a longer period").into())
}

/// Checks that H, if given, is the sum of the layers.
fn check_thickness(inputs: &CaseInputs, scene: &Scene) -> Result<(), CaseError> {
    let total = scene.thickness_um();
    match inputs.thickness {
        Some(h) if (h - total).abs() > 1e-9 * total => {
            let allowed = format!("{total} µm, the sum of the layers");
            Err(Fault::new("H", format!("{h} µm"), allowed, "make them agree or leave H out").into())
        }
        _ => Ok(()),
    }
}

/// Replaces the numbers of bodies in a scene's error by their names in the file.
fn with_names(error: WaveError, names: &[String]) -> CaseError {
    let name = |body: usize| names.get(body).cloned().unwrap_or_else(|| format!("body {body}"));
    match error {
        WaveError::Overlap { first, second, overlap_um } => {
            let both = format!("{} and {}", name(first), name(second));
            let allowed = "bodies apart, or a sphere wholly inside another";
            Fault::new(both, format!("an overlap by {overlap_um:.3e} µm"), allowed, "move them apart").into()
        }
        WaveError::OverlapsImage { body, overlap_um } => {
            let found = format!("an overlap with its own periodic image by {overlap_um:.3e} µm");
            let remedy = "make the period L larger or the body smaller";
            Fault::new(name(body), found, "a body apart from its image", remedy).into()
        }
        WaveError::OutsideLayer { body, low_um, high_um, thickness_um } => {
            let found = format!("a body from z = {low_um} to {high_um} µm");
            let remedy = "move it, make it smaller, or make the layer thicker";
            Fault::new(name(body), found, format!("0 … {thickness_um} µm, the layer"), remedy).into()
        }
        other => other.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(bodies: &str) -> String {
        let text = format!("wavelength = 0.5\nL = 1.0\n{bodies}");
        Case::parse(&text, true).unwrap_err().to_string()
    }

    #[test]
    fn bodies_are_called_as_in_the_file() {
        let binder = "H = 1.0\neta_binder = [1.5, 0]\n";
        let cylinder = "[[cylinders]]\nx = 0.5\nz = 0.5\nradius = 0.2\neta = [1.4, 0]\n";
        let sphere = "[[spheres]]\ncenter = [0.6, 0.5, 0.5]\nradius = 0.2\neta = [1.4, 0]\n";
        let said = refusal(&format!("{binder}{sphere}{cylinder}"));
        assert!(said.contains("spheres[0] and cylinders[0]: found an overlap by 3.000e-1 µm"), "{said}");
        let film = "[[sublayers_from_z0]]\nthickness = 0\neta_background = [1.5, 0]\n\
            bars = [{ x0 = 0, x1 = 0.5, eta = [1.4, 0] }]\n";
        let bars = "[[sublayers_from_z0]]\nthickness = 0.5\neta_background = [1.5, 0]\n\
            bars = [{ x0 = 0, x1 = 0.5, eta = [1.4, 0] }, { x0 = 0.25, x1 = 0.7, eta = [1.4, 0] }]\n";
        let said = refusal(&format!("{film}{bars}"));
        assert!(said.contains("sublayers_from_z0[1].bars[0] and sublayers_from_z0[1].bars[1]:"), "{said}");
    }
}
