//! Films without each of them, against characteristic matrices.

use super::*;
use inkwave_validation::formulas::films::Film;
use inkwave_validation::formulas::stacks::totals;
use num_complex::Complex64;

/// Films in unlike, partly absorbing binders, without a grain.
const FILMS: &str = r#"
title = "Films"
[stack]
without_layers = true
[[layer]]
name = "front"
thickness_um = 0.31
binder.index = { n = 1.42, k = 0.03 }
[[layer]]
name = "middle"
thickness_um = 0.52
binder.index = { n = 1.65, k = 0.01 }
[[layer]]
name = "back"
thickness_um = 0.27
binder.index = 1.5
[paper]
albedo = 0.9
[light]
wavelengths_nm = [400, 420, 440, 460, 480, 500, 520, 540, 560, 580, 600, 620, 640, 660, 680, 700]
[output]
picture_pixels = 16
"#;

/// The film of a layer of [`FILMS`].
fn film(layer: &str) -> Film {
    let [n, k, thickness_um] = match layer {
        "front" => [1.42, 0.03, 0.31],
        "middle" => [1.65, 0.01, 0.52],
        _ => [1.5, 0.0, 0.27],
    };
    Film { index: Complex64::new(n, k), thickness_um }
}

/// Radiance factor at 45:0 of films over an air gap, by characteristic matrices: light that enters at 45°, returns from a
/// Lambertian paper many times, and leaves at 0°.
fn lit_at_45(films: &[Film], wavelength_um: f64) -> f64 {
    let at = |films: &[Film], polar_deg: f64| totals([1.0, 1.0], films, wavelength_um, polar_deg, false);
    let behind: Vec<Film> = films.iter().rev().copied().collect();
    // in equal steps of sin², as diffuse light is
    let count = 4000;
    let sine = |i: i32| ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
    let back =
        (0..count).map(|i| at(&behind, sine(i).asin().to_degrees())[0]).sum::<f64>() / f64::from(count);
    at(films, 45.0)[1] * at(films, 0.0)[1] * PAPER / (1.0 - PAPER * back)
}

/// Films without each of them, and each alone, are what characteristic matrices say, with their densities over the bare paper;
/// every number is, to rounding, that of a study without the layer. *Planted*: another layer left out, a layer alone in the
/// place of what is left without it, densities of the wrong sign.
#[test]
fn films_without_a_film_are_other_films() {
    let scratch = tempfile::tempdir().unwrap();
    let whole = results(&ran(scratch.path(), "whole", FILMS));
    let names = ["front", "middle", "back"];
    let nm = |row: &Value| row["wavelength_nm"].as_f64().unwrap();
    // the mean over directions of a film's reflection: the program's nodes, and these steps
    let close = |found: f64, truth: f64| assert!((found - truth).abs() < 2e-5, "{found} and {truth}");
    for layer in names {
        let others: Vec<Film> = names.into_iter().filter(|name| *name != layer).map(film).collect();
        let rows = left_out(&whole, layer);
        assert_eq!(rows.len(), 16);
        for row in rows {
            close(value(&row, "lit_at_45_without"), lit_at_45(&others, 1e-3 * nm(&row)));
            close(value(&row, "lit_at_45_alone"), lit_at_45(&[film(layer)], 1e-3 * nm(&row)));
        }
    }
    let density = |films: &[Film], nm: f64| -(lit_at_45(films, 1e-3 * nm) / PAPER).log10();
    let rows = whole["densities"].as_array().expect("densities");
    assert_eq!(rows.len(), 16);
    for row in rows {
        let own = density(&names.map(film), nm(row));
        let sum: f64 = names.iter().map(|name| density(&[film(name)], nm(row))).sum();
        close(value(row, "density_of_stack"), own);
        close(value(row, "density_of_layers"), sum);
        assert!((value(row, "density_ratio") - own / sum).abs() < 1e-3, "{row} {own} {sum}");
    }
    let block = |name: &str| {
        let from = FILMS.find(&format!("[[layer]]\nname = \"{name}\"")).unwrap();
        let length = FILMS[from + 1..].find("\n[").unwrap() + 2;
        from..from + length
    };
    let plain = FILMS.replace("without_layers = true", "");
    for layer in names {
        let text = plain.replace(&FILMS[block(layer)], "");
        let other = results(&ran(scratch.path(), layer, &text));
        for (row, print) in left_out(&whole, layer).iter().zip(printed(&other)) {
            for light in ["lit_at_45", "natural_light"] {
                let own = value(row, &format!("{light}_without"));
                assert!((own - value(&print, light)).abs() < 1e-12, "{row} {print}");
            }
        }
        assert_same_colours(&whole, layer, "without", &other);
    }
    let alone = plain.replace(&FILMS[block("front")], "").replace(&FILMS[block("back")], "");
    let other = results(&ran(scratch.path(), "alone", &alone));
    for (row, print) in left_out(&whole, "middle").iter().zip(printed(&other)) {
        assert!((value(row, "natural_light_alone") - value(&print, "natural_light")).abs() < 1e-12);
    }
    assert_same_colours(&whole, "middle", "alone", &other);
}
