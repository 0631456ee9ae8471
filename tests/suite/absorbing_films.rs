//! Films that absorb, without grains to speak of, composed of plates: judged by the formula of films.

use super::run_support::{results, study, succeed, value};
use num_complex::Complex64;
use serde_json::Value;
use std::f64::consts::TAU;

/// An absorbing film in four slabs; its grains are of the binder itself but for the rounding of a file.
const ABSORBING: &str = r#"
title = "An absorbing film"
[stack]
period_um = 0.5
composed = { slab_um = 0.4 }
[[layer]]
name = "film"
thickness_um = [0.8, 1.6]
binder.index = { n = 1.5, k = 0.06 }
[[layer.pigment]]
name = "the binder again"
diameter_nm = 60
volume_fraction = 0.05
share = "scale_sizes"
index = { n = 1.50001, k = 0.06 }
[paper]
albedo = 0.85
[light]
wavelengths_nm = [560, 740]
[run]
realisations = 2
[resolution]
accuracy = 3e-2
"#;

/// A stack of one layer is composed where that is asked, at each of its thicknesses: R and T of a film that absorbs are those of
/// Airy's formula, though its slabs are solved between media that do not absorb. *Planted*: such a stack solved whole at its first
/// thickness; the steps to the slabs' half-spaces left in the front and back slabs (T off by 2 % at 740 nm).
#[test]
fn an_absorbing_film_in_slabs_is_the_film_of_its_formula() {
    let scratch = tempfile::tempdir().unwrap();
    let file = study(scratch.path(), ABSORBING);
    let output = scratch.path().join("out");
    succeed(&file, &output, &[]);
    let all = results(&output);
    let rows = all["spectra"].as_array().expect("rows");
    let place = |row: &Value, name: &str| row[name].as_f64().expect("a number");
    let found: Vec<[f64; 2]> =
        rows.iter().map(|row| [place(row, "thickness_um"), place(row, "wavelength_nm")]).collect();
    assert_eq!(found, [[0.8, 560.0], [0.8, 740.0], [1.6, 560.0], [1.6, 740.0]]);
    for row in rows {
        let index = Complex64::new(1.5, 0.06);
        let face = (1.0 - index) / (1.0 + index);
        let phase =
            Complex64::I * TAU / (1e-3 * place(row, "wavelength_nm")) * index * place(row, "thickness_um");
        let once = phase.exp();
        let many = 1.0 / (1.0 - face * face * once * once);
        let reflected = (face * (1.0 - once * once) * many).norm_sqr();
        let passed = ((1.0 - face * face) * once * many).norm_sqr();
        // the grid's own estimate of its error is 6e-6
        for (name, wanted) in [("reflectance_normal", reflected), ("transmittance_normal", passed)] {
            let found = value(row, name);
            assert!((found - wanted).abs() < 1e-5, "{name} {found} {wanted}: {row}");
        }
    }
}

/// A varnish without grains over a film in slabs, both of which absorb, in front of another such film that is solved as a whole.
const ABSORBING_STACK: &str = r#"
title = "Three absorbing films"
[stack]
period_um = 0.6
composed = { slab_um = 0.3 }
[[layer]]
name = "varnish"
thickness_um = 0.4
binder.index = { n = 1.65, k = 0.3 }
[[layer]]
name = "slabs"
thickness_um = 0.9
binder.index = { n = 1.4, k = 0.02 }
[[layer.pigment]]
name = "the binder again"
diameter_nm = 60
volume_fraction = 0.05
share = "scale_sizes"
index = { n = 1.40001, k = 0.02 }
[[layer]]
name = "whole"
thickness_um = 0.2
binder.index = { n = 2.0, k = 0.02 }
[[layer.pigment]]
name = "this binder again"
diameter_nm = 60
volume_fraction = 0.05
share = "scale_sizes"
index = { n = 2.00001, k = 0.02 }
[light]
wavelengths_nm = [420, 560, 740]
[run]
realisations = 2
[resolution]
accuracy = 3e-2
"#;

/// R, T and what every film absorbs of light at 0° in a row of films \[index, thickness in µm\], by the fields at their faces.
fn films(films: &[(Complex64, f64)], wavelength_um: f64) -> ([f64; 2], Vec<f64>) {
    // u and its slope over i k₀ behind the last film, then in front of every film
    let mut field = Complex64::ONE;
    let mut slope = Complex64::ONE;
    let flux = |field: Complex64, slope: Complex64| (field.conj() * slope).re;
    let mut fluxes = vec![flux(field, slope)];
    for (index, um) in films.iter().rev() {
        let phase = TAU / wavelength_um * index * um;
        let cosine = phase.cos();
        let sine = phase.sin();
        let before = cosine * field - Complex64::I * sine / index * slope;
        slope = cosine * slope - Complex64::I * sine * index * field;
        field = before;
        fluxes.push(flux(field, slope));
    }
    let incident = (0.5 * (field + slope)).norm_sqr();
    let reflected = (0.5 * (field - slope)).norm_sqr() / incident;
    fluxes.reverse();
    let absorbed = fluxes.windows(2).map(|pair| (pair[0] - pair[1]) / incident).collect();
    ([reflected, fluxes[fluxes.len() - 1] / incident], absorbed)
}

/// Layers of a composed stack that absorb mirror and absorb what the formula of films says, whether they hold no grains, are in
/// slabs, or solved as a whole. *Planted*: faces of a varnish as of an index without κ (R .057 for .073 at 400 nm); shares of the
/// loss without interference (.093 for .107).
#[test]
fn absorbing_layers_of_a_stack_are_films() {
    let scratch = tempfile::tempdir().unwrap();
    let output = scratch.path().join("out");
    succeed(&study(scratch.path(), ABSORBING_STACK), &output, &[]);
    let all = results(&output);
    let stack = [((1.65, 0.3), 0.4), ((1.4, 0.02), 0.9), ((2.0, 0.02), 0.2)]
        .map(|((n, k), um): ((f64, f64), f64)| (Complex64::new(n, k), um));
    let table = csv::Reader::from_path(output.join("absorbed.csv")).expect("a table").into_deserialize();
    let rows: Vec<std::collections::BTreeMap<String, String>> =
        table.collect::<Result<_, _>>().expect("rows");
    for (row, layers) in all["spectra"].as_array().expect("rows").iter().zip(rows.chunks(3)) {
        let nm = row["wavelength_nm"].as_f64().expect("a number");
        let ([reflected, passed], absorbed) = films(&stack, 1e-3 * nm);
        // the grid's own estimate of its error is 6e-6
        for (name, wanted) in [("reflectance_normal", reflected), ("transmittance_normal", passed)] {
            let found = value(row, name);
            assert!((found - wanted).abs() < 2e-5, "{nm} nm: {name} {found} {wanted}");
        }
        for (layer, wanted) in layers.iter().zip(absorbed) {
            let found: f64 = layer["absorptance_normal"].parse().expect("a number");
            assert!((found - wanted).abs() < 2e-5, "{nm} nm: {} {found} {wanted}", layer["layer"]);
        }
    }
}
