//! Ranges of a case's numbers, named as they are written in the file.

use super::case_inputs::{CaseError, CaseInputs, IndexInput};
use super::forms::Pair;

/// Refuses numbers out of range before they are combined into a scene.
pub fn check(inputs: &CaseInputs) -> Result<(), CaseError> {
    light(inputs)?;
    lengths(inputs)?;
    indices(inputs)?;
    grains(inputs)
}

fn range(field: &str, value: f64, good: bool, allowed: &str, remedy: &str) -> Result<(), CaseError> {
    if good {
        return Ok(());
    }
    let (field, allowed, remedy) = (field.into(), allowed.into(), remedy.into());
    Err(CaseError::Range { field, value, allowed, remedy })
}

fn positive(field: &str, value: f64) -> Result<(), CaseError> {
    range(field, value, value.is_finite() && value > 0.0, "above 0 and finite", "give it in µm")
}

fn finite(field: &str, value: f64, remedy: &str) -> Result<(), CaseError> {
    range(field, value, value.is_finite(), "any finite number", remedy)
}

fn light(inputs: &CaseInputs) -> Result<(), CaseError> {
    positive("wavelength", inputs.wavelength)?;
    let grazing = "grazing light carries no flux into the layer; use 89 or less";
    let sigma = inputs.sigma_deg;
    range("sigma_deg", sigma, (0.0..90.0).contains(&sigma), "0 ≤ sigma_deg < 90", grazing)?;
    finite("phi_deg", inputs.phi_deg, "give it in degrees")
}

fn lengths(inputs: &CaseInputs) -> Result<(), CaseError> {
    if inputs.period.is_none() && inputs.repeats() {
        let (found, remedy) = ("missing", "give the period of the grains or bars in µm, or [Lx, Ly]");
        return Err(CaseError::Field { field: "L".into(), found: found.into(), remedy: remedy.into() });
    }
    let [x, y] = inputs.period_um();
    positive("L", x)?;
    positive("Ly", y)?;
    if let (Some(Pair::Each(_)), Some(_)) = (inputs.period, inputs.period_y) {
        let (found, remedy) = ("given beside a pair L = [Lx, Ly]", "give one of them");
        return Err(CaseError::Field { field: "Ly".into(), found: found.into(), remedy: remedy.into() });
    }
    inputs.thickness.map_or(Ok(()), |h| positive("H", h))?;
    let thickness = |field: String, value: f64| {
        let good = value.is_finite() && value >= 0.0;
        range(&field, value, good, "0 or above and finite", "give it in µm")
    };
    for (i, layer) in inputs.layers_from_z0.iter().flatten().enumerate() {
        thickness(format!("layers_from_z0[{i}].thickness"), layer.thickness)?;
    }
    for (i, layer) in inputs.sublayers_from_z0.iter().flatten().enumerate() {
        thickness(format!("sublayers_from_z0[{i}].thickness"), layer.thickness)?;
    }
    Ok(())
}

fn indices(inputs: &CaseInputs) -> Result<(), CaseError> {
    let eta = |field: &str, value: Option<[f64; 2]>| value.map_or(Ok(()), |v| index(field, v));
    eta("n_in", inputs.n_in.map(IndexInput::parts))?;
    eta("n_out", inputs.n_out.map(IndexInput::parts))?;
    eta("eta_in", inputs.eta_in)?;
    eta("eta_out", inputs.eta_out)?;
    eta("eta_binder", inputs.eta_binder)?;
    for (i, s) in inputs.spheres.iter().flatten().enumerate() {
        index(&format!("spheres[{i}].eta"), s.eta)?;
    }
    for (i, c) in inputs.cylinders.iter().flatten().enumerate() {
        index(&format!("cylinders[{i}].eta"), c.eta)?;
    }
    for (i, l) in inputs.layers_from_z0.iter().flatten().enumerate() {
        index(&format!("layers_from_z0[{i}].eta"), l.eta)?;
    }
    for (i, l) in inputs.sublayers_from_z0.iter().flatten().enumerate() {
        index(&format!("sublayers_from_z0[{i}].eta_background"), l.eta_background)?;
        for (j, bar) in l.bars.iter().enumerate() {
            index(&format!("sublayers_from_z0[{i}].bars[{j}].eta"), bar.eta)?;
        }
    }
    Ok(())
}

fn index(field: &str, [re, im]: [f64; 2]) -> Result<(), CaseError> {
    let real = "the real part of an index is positive (a metal's may be small)";
    range(&format!("{field} (real part)"), re, re.is_finite() && re >= 0.0, "0 or above and finite", real)?;
    let sign = "0 or more absorbs; change the sign if it was given for e^(+iωt)";
    range(&format!("{field} (absorption)"), im, im.is_finite() && im >= 0.0, "0 or above and finite", sign)?;
    range(field, re, re > 0.0 || im > 0.0, "an index other than 0", "give [real part, absorption]")
}

fn grains(inputs: &CaseInputs) -> Result<(), CaseError> {
    let height = inputs.thickness.unwrap_or(f64::INFINITY);
    for (i, s) in inputs.spheres.iter().flatten().enumerate() {
        positive(&format!("spheres[{i}].radius"), s.radius)?;
        for (axis, value) in s.center.into_iter().enumerate() {
            finite(&format!("spheres[{i}].center[{axis}]"), value, "give it in µm")?;
        }
        within(&format!("spheres[{i}]"), s.center[2], s.radius, height)?;
    }
    for (i, c) in inputs.cylinders.iter().flatten().enumerate() {
        positive(&format!("cylinders[{i}].radius"), c.radius)?;
        finite(&format!("cylinders[{i}].x"), c.x, "give it in µm")?;
        finite(&format!("cylinders[{i}].z"), c.z, "give it in µm")?;
        within(&format!("cylinders[{i}]"), c.z, c.radius, height)?;
    }
    Ok(())
}

/// Grains lie inside the layer; touching a wall may exceed it by rounding.
fn within(grain: &str, z: f64, radius: f64, height: f64) -> Result<(), CaseError> {
    let slack = 1e-9 * height.min(radius);
    let (low, high) = (z - radius, z + radius);
    if low >= -slack && high <= height + slack {
        return Ok(());
    }
    Err(CaseError::Field {
        field: grain.into(),
        found: format!("reaches from z = {low:.6} to {high:.6} µm, but the layer is 0 … {height} µm"),
        remedy: "move it, make it smaller, or make the layer thicker".into(),
    })
}
