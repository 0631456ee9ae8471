//! Allowed ranges of a case's numbers, under the names of the file.

use super::case_inputs::{CaseInputs, IndexInput, MOST_DIRECTIONS, WAVELENGTHS};
use super::fault::{Allowed, Faults};
use super::forms::Pair;
use super::limits::{ABOVE_ZERO, LIGHT_NM, LIGHT_UM, NOT_NEGATIVE, POLAR_DEG};
use crate::numerics::allowed::shown;
use crate::numerics::vector::norm;
use crate::wave::Body;

/// Any finite number.
const FINITE: Allowed = Allowed::between(f64::MIN, f64::MAX, "");
/// Real or imaginary part of an index.
const INDEX_PART: Allowed = Allowed::between(0.0, f64::MAX, "");
const IN_UM: &str = "give it in µm";
const GRAZING: &str = "grazing light carries no flux into the layer; use 89 or less";

/// Finds numbers out of range before they are combined into a scene.
pub fn check(inputs: &CaseInputs) -> Faults {
    let mut faults = Faults::default();
    wavelength(inputs, &mut faults);
    faults.number("sigma_deg", inputs.sigma_deg, POLAR_DEG, GRAZING);
    faults.number("phi_deg", inputs.phi_deg, FINITE, "give it in degrees");
    directions(inputs, &mut faults);
    lengths(inputs, &mut faults);
    indices(inputs).iter().for_each(|(field, eta)| index(field, *eta, &mut faults));
    grains(inputs, &mut faults);
    bodies(inputs, &mut faults);
    crystals(inputs, &mut faults);
    faults
}

/// Checks the list of directions, if there is one.
fn directions(inputs: &CaseInputs, faults: &mut Faults) {
    let Some(listed) = &inputs.directions else { return };
    if !(1..=MOST_DIRECTIONS).contains(&listed.len()) {
        let allowed = format!("1 to {MOST_DIRECTIONS} entries");
        let remedy = "list directions such as { sigma_deg = 45 }, or leave the list out";
        faults.add("directions", format!("{} entries", listed.len()), allowed, remedy);
    }
    for (i, direction) in listed.iter().enumerate().take(MOST_DIRECTIONS) {
        let place = |key: &str| format!("directions[{i}].{key}");
        if let Some(polar) = direction.sigma_deg {
            faults.number(&place("sigma_deg"), polar, POLAR_DEG, GRAZING);
        }
        if let Some(azimuth) = direction.phi_deg {
            faults.number(&place("phi_deg"), azimuth, FINITE, "give it in degrees");
        }
    }
}

/// Checks that one key gives the wavelength, in its range.
fn wavelength(inputs: &CaseInputs, faults: &mut Faults) {
    let values = [inputs.wavelength, inputs.wavelength_um, inputs.wavelength_nm];
    let given: Vec<&str> =
        WAVELENGTHS.into_iter().zip(values).filter_map(|(key, value)| value.map(|_| key)).collect();
    if given.len() != 1 {
        let found = if given.is_empty() { "nothing".to_owned() } else { given.join(" and ") };
        faults.add(
            "wavelength",
            found,
            "one of `wavelength` (µm), `wavelength_um` and `wavelength_nm`",
            "give one",
        );
        return;
    }
    if let Some(um) = inputs.wavelength {
        let remedy = if um > 20.0 {
            format!(
                "if you meant nm, write {}, or wavelength_nm = {}; wavelength_um takes any wavelength in µm",
                shown(1e-3 * um),
                shown(um)
            )
        } else {
            format!("{IN_UM}; wavelength_um takes any wavelength in µm")
        };
        faults.number("wavelength", um, LIGHT_UM, &remedy);
    }
    if let Some(um) = inputs.wavelength_um {
        faults.number("wavelength_um", um, ABOVE_ZERO, IN_UM);
    }
    if let Some(nm) = inputs.wavelength_nm {
        let any = "wavelength_um takes any wavelength in µm";
        let remedy = match nm {
            _ if LIGHT_UM.holds(nm) => format!("if you meant µm, write wavelength = {}; {any}", shown(nm)),
            _ => format!("give it in nm; {any}"),
        };
        faults.number("wavelength_nm", nm, LIGHT_NM, &remedy);
    }
}

fn lengths(inputs: &CaseInputs, faults: &mut Faults) {
    if inputs.period.is_none() && !inputs.bodies().is_empty() {
        let remedy = "give the period of the grains or bars in µm";
        faults.add("L", "nothing", "a number or a pair [Lx, Ly]", remedy);
    }
    let [x, y] = inputs.period_um();
    faults.number("L", x, ABOVE_ZERO, IN_UM);
    faults.number("Ly", y, ABOVE_ZERO, IN_UM);
    if let (Some(Pair::Each(_)), Some(y)) = (inputs.period, inputs.period_y) {
        faults.add("Ly", y, "nothing beside a pair L = [Lx, Ly]", "give one of them");
    }
    if let Some(height) = inputs.thickness {
        faults.number("H", height, ABOVE_ZERO, IN_UM);
    }
    for (i, layer) in inputs.layers_from_z0.iter().flatten().enumerate() {
        faults.number(&format!("layers_from_z0[{i}].thickness"), layer.thickness, NOT_NEGATIVE, IN_UM);
    }
    for (i, layer) in inputs.sublayers_from_z0.iter().flatten().enumerate() {
        faults.number(&format!("sublayers_from_z0[{i}].thickness"), layer.thickness, NOT_NEGATIVE, IN_UM);
    }
}

/// All indices with their fields.
fn indices(inputs: &CaseInputs) -> Vec<(String, [f64; 2])> {
    let single = [
        ("n_in", inputs.n_in.map(IndexInput::parts)),
        ("n_out", inputs.n_out.map(IndexInput::parts)),
        ("eta_in", inputs.eta_in),
        ("eta_out", inputs.eta_out),
        ("eta_binder", inputs.eta_binder),
    ];
    let single = single.into_iter().filter_map(|(name, eta)| Some((name.to_owned(), eta?)));
    let mut all: Vec<_> = single.collect();
    all.extend(inputs.bodies().into_iter().map(|body| (format!("{}.eta", body.name), body.eta)));
    let crystals = inputs.crystals().into_iter();
    all.extend(crystals.filter_map(|(name, eta, _)| Some((format!("{name}.eta_extraordinary"), eta?))));
    let layers = inputs.layers_from_z0.iter().flatten().enumerate();
    all.extend(layers.map(|(i, l)| (format!("layers_from_z0[{i}].eta"), l.eta)));
    let layers = inputs.sublayers_from_z0.iter().flatten().enumerate();
    all.extend(layers.map(|(i, l)| (format!("sublayers_from_z0[{i}].eta_background"), l.eta_background)));
    all
}

fn index(field: &str, [re, im]: [f64; 2], faults: &mut Faults) {
    let real = "the real part of an index is positive (a metal's may be small)";
    faults.number(&format!("{field} (real part)"), re, INDEX_PART, real);
    let sign = "0 or more absorbs; change the sign if it was given for e^(+iωt)";
    faults.number(&format!("{field} (absorption)"), im, INDEX_PART, sign);
    if [re, im] == [0.0, 0.0] {
        faults.add(field, 0, "an index other than 0", "give [real part, absorption]");
    }
}

fn grains(inputs: &CaseInputs, faults: &mut Faults) {
    let height = inputs.thickness.unwrap_or(f64::INFINITY);
    for (i, s) in inputs.spheres.iter().flatten().enumerate() {
        faults.number(&format!("spheres[{i}].radius"), s.radius, ABOVE_ZERO, IN_UM);
        for (axis, value) in s.center.into_iter().enumerate() {
            faults.number(&format!("spheres[{i}].center[{axis}]"), value, FINITE, IN_UM);
        }
        within(format!("spheres[{i}]"), s.center[2], s.radius, height, faults);
    }
    for (i, c) in inputs.cylinders.iter().flatten().enumerate() {
        faults.number(&format!("cylinders[{i}].radius"), c.radius, ABOVE_ZERO, IN_UM);
        faults.number(&format!("cylinders[{i}].x"), c.x, FINITE, IN_UM);
        faults.number(&format!("cylinders[{i}].z"), c.z, FINITE, IN_UM);
        within(format!("cylinders[{i}]"), c.z, c.radius, height, faults);
    }
}

fn bodies(inputs: &CaseInputs, faults: &mut Faults) {
    for (i, body) in inputs.bodies.iter().flatten().enumerate() {
        let shape = format!("bodies[{i}].shape");
        if let Some((key, found, allowed)) = body.shape.defect() {
            faults.add(key.replacen("shape", &shape, 1), found, allowed, "give lengths in µm");
        } else if body.shape.form().is_none() {
            let allowed = "`ellipsoid`, `box`, `disc` or `prism`";
            faults.add(shape, body.shape.name(), allowed, "give single spheres as `spheres`");
        }
        for (axis, value) in body.center.into_iter().enumerate() {
            faults.number(&format!("bodies[{i}].center[{axis}]"), value, FINITE, IN_UM);
        }
        faults.number(&format!("bodies[{i}].turn_deg"), body.turn_deg, FINITE, "give it in degrees");
        let length = body.axis.map_or(1.0, norm);
        if !(length.is_finite() && length > 0.0) {
            let found = format!("{:?}", body.axis.unwrap_or_default());
            faults.add(format!("bodies[{i}].axis"), found, "a direction of finite length", "give [x, y, z]");
        }
    }
}

/// Checks optic axes, and that films of crystals hold no bodies.
fn crystals(inputs: &CaseInputs, faults: &mut Faults) {
    for (name, extraordinary, axis) in inputs.crystals() {
        let Some(axis) = axis else { continue };
        let length = norm(axis);
        if !(length.is_finite() && length > 0.0) {
            let found = format!("{axis:?}");
            faults.add(format!("{name}.optic_axis"), found, "a direction of finite length", "give [x, y, z]");
        }
        if extraordinary.is_none() {
            let allowed = "an axis of what has two indices";
            let remedy = "give eta_extraordinary, or remove optic_axis";
            faults.add(format!("{name}.optic_axis"), "no eta_extraordinary", allowed, remedy);
        }
    }
    let bodies = inputs.bodies();
    for film in inputs.birefringent_films() {
        let [low, high] = Body::new(film.shape, 0).extent_um();
        let inside = bodies.iter().find(|body| {
            let [from, to] = Body::new(body.shape.clone(), 0).extent_um();
            from < high && to > low
        });
        if let Some(body) = inside {
            let field = format!("{}.eta_extraordinary", film.name);
            let remedy = "move the body into another film, or give the film one index";
            faults.add(
                field,
                format!("{} in the film", body.name),
                "a birefringent film without bodies",
                remedy,
            );
        }
    }
}

/// Checks that a grain lies inside the layer, up to rounding.
fn within(grain: String, z: f64, radius: f64, height: f64, faults: &mut Faults) {
    let slack = 1e-9 * height.min(radius);
    let low = z - radius;
    let high = z + radius;
    if low < -slack || high > height + slack {
        let found = format!("a grain from z = {low:.6} to {high:.6} µm");
        let remedy = "move it, make it smaller, or make the layer thicker";
        let allowed = if height.is_finite() {
            format!("0 … {height} µm, the layer")
        } else {
            "0 µm or more, where the layers begin".to_owned()
        };
        faults.add(grain, found, allowed, remedy);
    }
}
