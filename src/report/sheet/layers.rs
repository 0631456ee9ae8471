//! What the page of a stack has beside others: what its layers are and absorb, and what it is
//! without each of them, whichever evaluator made the numbers.

use super::figures::{Drawing, WAVELENGTH, at_angle, shares, shown_nm};
use super::words::{lab_of, words_of};
use crate::draw::DrawResult;
use crate::draw::chart::{Chart, Curve, Style};
use crate::draw::page::Figure;
use crate::evaluate::manifest::composed::ComposedColours;
use crate::evaluate::manifest::left_out::{DensityRow, LeftOutColours, LeftOutRow};
use crate::evaluate::manifest::{Manifest, SpectrumRow};
use crate::evaluate::published::ErrorParts;
use crate::input::study::{StackLayer, Study};
use crate::numerics::estimate::Estimate;
use serde::Serialize;

/// The layers in words, in the order of the light; none of a single layer.
pub(super) fn in_words(manifest: &Manifest) -> Vec<String> {
    let study = manifest.study;
    let ranges = study.pigments_of_layers();
    let words = |(number, layer): (usize, &StackLayer)| {
        let share = |k: usize| {
            let pigment = &study.pigments[k];
            let share = format!("{:.1}", 100.0 * pigment.grains.volume_fraction);
            format!("{} % {}", share.trim_end_matches(".0"), pigment.name)
        };
        let grains: Vec<String> = ranges[number].clone().map(share).collect();
        let grains = if grains.is_empty() { "no grains".to_owned() } else { grains.join(", ") };
        let um = thickness_in_words(manifest, number);
        format!("{} ({um} µm, {grains} in {})", layer.name, layer.binder.source)
    };
    study.stack.iter().enumerate().map(words).collect()
}

/// The thickness of a layer of a stack, or all that are asked for.
fn thickness_in_words(manifest: &Manifest, layer: usize) -> String {
    let StackLayer { thickness_um, thickness_std_um, .. } = &manifest.study.stack[layer];
    if varied(manifest.study) == Some(layer) {
        return manifest.thicknesses_um().iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    }
    match *thickness_std_um > 0.0 {
        true => format!("{thickness_um} ± {thickness_std_um}"),
        false => thickness_um.to_string(),
    }
}

/// The layer of a stack that has several thicknesses.
fn varied(study: &Study) -> Option<usize> {
    study.composed().and_then(|composed| composed.varied)
}

/// What a stack or a layer of this thickness is called on the page; nothing where there is one.
pub(super) fn called(manifest: &Manifest, thickness_um: f64) -> String {
    let study = manifest.study;
    match varied(study) {
        Some(layer) => format!("{} {thickness_um} µm", study.stack[layer].name),
        None if study.stack.is_empty() => format!("{thickness_um} µm"),
        None => String::new(),
    }
}

/// A name of a curve or a row, with the thickness that it is of.
fn of(name: &str, called: &str) -> String {
    if called.is_empty() { name.to_owned() } else { format!("{name}, {called}") }
}

/// Plots of a stack; none of a single layer.
pub(super) fn figures(manifest: &Manifest) -> DrawResult<Vec<Figure>> {
    let all = [
        absorbed_by_layers(manifest),
        flux_through_layers(manifest),
        without_layers(manifest),
        densities(manifest),
    ];
    all.into_iter().flatten().map(|(heading, plot, caption)| Figure::new(heading, &plot, caption)).collect()
}

/// What a layer of a stack absorbs.
struct Absorbed<'a> {
    layer: &'a str,
    wavelength_nm: f64,
    absorptance: Estimate,
}

/// What every layer absorbs of light along the normal, of the first thickness.
fn absorbed<'a>(manifest: &'a Manifest) -> Vec<Absorbed<'a>> {
    let angle = manifest.absorbed.first().map(|row| row.polar_deg);
    let whole = manifest.absorbed.iter().filter(|row| Some(row.polar_deg) == angle).map(|row| Absorbed {
        layer: &row.layer,
        wavelength_nm: row.wavelength_nm,
        absorptance: row.absorptance,
    });
    let of_slabs = manifest.slabs.iter().flat_map(|slabs| &slabs.absorbed);
    let first_um = manifest.thicknesses_um().first().copied();
    let of_slabs = of_slabs.filter(|row| Some(row.thickness_um) == first_um).map(|row| Absorbed {
        layer: &row.layer,
        wavelength_nm: row.wavelength_nm,
        absorptance: row.absorptance_normal.estimate(),
    });
    whole.chain(of_slabs).collect()
}

/// What every layer of a stack absorbs of light along the normal, with the list of layers.
fn absorbed_by_layers(manifest: &Manifest) -> Drawing {
    let study = manifest.study;
    let rows = absorbed(manifest);
    let angle = manifest.absorbed.first().map_or(0.0, |row| row.polar_deg);
    let curve = |layer: &StackLayer| {
        let own = rows.iter().filter(|row| row.layer == layer.name);
        let points = own.map(|row| (row.wavelength_nm, row.absorptance));
        Curve::measured(layer.name.as_str(), points).asked_at(&study.wavelengths_nm)
    };
    let curves = study.stack.iter().map(curve).collect();
    let first = manifest.thicknesses_um().first().map(|um| called(manifest, *um)).unwrap_or_default();
    let has_parts = !manifest.left_out.rows.is_empty();
    let caption = format!(
        "The layers in the order of the light: {}. Shown is what each of them absorbs without paper, lit at {angle:.0}°{}; \
         together they absorb what is neither reflected nor transmitted.{}",
        in_words(manifest).join("; "),
        if first.is_empty() { first } else { format!(" ({first})") },
        if has_parts {
            ""
        } else {
            " With stack.without_layers = true the page also tells what the stack is without each of them."
        }
    );
    Some(("The layers", shares(WAVELENGTH, "share of the light", curves)?, caption))
}

/// The net flux at every face of a stack that is solved as a whole, lit along the normal.
fn flux_through_layers(manifest: &Manifest) -> Drawing {
    let study = manifest.study;
    let angle = manifest.absorbed.first()?.polar_deg;
    let rows: Vec<SpectrumRow> = at_angle(manifest.spectra.whole(), angle);
    let solved: Vec<f64> = rows.iter().map(|row| row.wavelength_nm).collect();
    let absorbed = absorbed(manifest);
    let curve = |nm: f64| {
        let row = rows.iter().find(|row| row.wavelength_nm == nm)?;
        let mut flux = 1.0 - row.reflectance.value;
        let mut depth_um = 0.0;
        let mut points = vec![(depth_um, flux)];
        let here = absorbed.iter().filter(|part| part.wavelength_nm == nm);
        for (layer, part) in study.stack.iter().zip(here) {
            flux -= part.absorptance.value;
            depth_um += layer.thickness_um;
            points.push((depth_um, flux));
        }
        Some(Curve::new(format!("{nm:.0} nm"), Style::Data, points))
    };
    let curves = shown_nm(&solved).into_iter().filter_map(curve).collect();
    let caption = format!(
        "Net flux of light at the faces of the layers without paper, lit at {angle:.0}°: what is not reflected enters, and \
         falls by what each layer absorbs to what the stack transmits."
    );
    Some(("Through the layers", shares("depth, µm", "share of the light", curves)?, caption))
}

/// The stack of the first thickness on its paper, and what it is without each of its layers.
fn without_layers(manifest: &Manifest) -> Drawing {
    let study = manifest.study;
    let um = *manifest.thicknesses_um().first()?;
    let rows = || manifest.left_out.rows.iter().filter(move |row| row.thickness_um == um);
    rows().next()?;
    let normal = manifest.spectra.whole().iter().filter(|row| row.polar_deg == 0.0);
    let whole = normal.filter_map(|row| Some((row.wavelength_nm, row.lit_at_45?)));
    let slabs = manifest.spectra.composed().iter().filter(|row| row.thickness_um == um);
    let slabs = slabs.filter_map(|row| Some((row.wavelength_nm, row.layer.lit_at_45?.estimate())));
    let mut curves = vec![Curve::measured("all layers", whole.chain(slabs)).asked_at(&study.wavelengths_nm)];
    let part = |name: String, layer: &StackLayer, number: fn(&LeftOutRow) -> Option<ErrorParts>| {
        let own = rows().filter(|row| row.layer == layer.name);
        let points = own.filter_map(|row| Some((row.wavelength_nm, number(row)?.estimate())));
        Curve::measured(name, points).asked_at(&study.wavelengths_nm)
    };
    for layer in &study.stack {
        curves.push(part(format!("without {}", layer.name), layer, |row| row.lit_at_45_without));
    }
    // of two layers each is what is left without the other
    for (k, layer) in study.stack.iter().enumerate().filter(|_| study.stack.len() > 2) {
        let only = part(format!("only {}", layer.name), layer, |row| row.lit_at_45_alone);
        curves.push(only.looking(k + 1, k + 1).dashed(1));
    }
    curves.retain(Curve::has_points);
    let first = called(manifest, um);
    let caption = format!(
        "At 45:0, as a share of a perfect white: all layers on the paper{}, and the same without each of them, its \
         neighbours meeting at a plane face{} (left-out.csv, also under natural light).",
        if first.is_empty() { first } else { format!(" ({first})") },
        if study.stack.len() > 2 { "; dashed: each layer alone" } else { "" },
    );
    let chart = Chart::linear("", WAVELENGTH, "share of a perfect white", curves);
    Some(("Without each layer", Chart { from_zero: true, ..chart }, caption))
}

/// Densities of the stack and of its layers, of every thickness.
fn densities(manifest: &Manifest) -> Drawing {
    let mut curves = Vec::new();
    for um in manifest.thicknesses_um() {
        let curve = |name: &str, density: fn(&DensityRow) -> Option<ErrorParts>| {
            let rows = manifest.left_out.densities.iter().filter(|row| row.thickness_um == um);
            let points = rows.filter_map(|row| Some((row.wavelength_nm, density(row)?.estimate())));
            let name = of(name, &called(manifest, um));
            Curve::measured(name, points).asked_at(&manifest.study.wavelengths_nm)
        };
        curves.push(curve("stack", |row| row.density_of_stack));
        curves.push(curve("sum of layers", |row| row.density_of_layers));
    }
    curves.retain(Curve::has_points);
    let chart = Chart::linear("", WAVELENGTH, "density", curves);
    let caption = "Densities at 45:0 of the stack, and the sum of those of its layers, each alone on the paper \
                   (densities.csv has their quotient). Layers that only filter each other's light have one density.";
    (!chart.curves.is_empty()).then(|| ("Densities", Chart { from_zero: true, ..chart }, caption.to_owned()))
}

/// A line of the table of a stack without its layers.
#[derive(Serialize)]
pub(super) struct PartLine {
    /// Which layers, of which thickness.
    name: String,
    /// As screens show it under natural light.
    hex: Option<String>,
    lit_at_45: String,
    contrast_ratio: String,
}

/// The table of a stack without each of its layers, and of each alone.
pub(super) fn parts(manifest: &Manifest) -> Vec<PartLine> {
    let line = |name: String, colours: &ComposedColours| PartLine {
        name,
        hex: colours.hex.clone(),
        lit_at_45: lab_of(colours.lit_at_45),
        contrast_ratio: words_of(colours.contrast_ratio, 3),
    };
    let stack = &manifest.study.stack;
    let mut lines = Vec::new();
    for LeftOutColours { layer: name, without, alone } in &manifest.left_out.colours {
        let is_varied = varied(manifest.study).is_some_and(|k| stack[k].name == *name);
        let is_first =
            |colours: &&ComposedColours| manifest.thicknesses_um().first() == Some(&colours.thickness_um);
        // without the varied layer there is one print, and of others alone there is one thickness
        if let Some(colours) = without.as_ref().filter(|colours| !is_varied || is_first(colours)) {
            let of_others = if is_varied { String::new() } else { called(manifest, colours.thickness_um) };
            let other = stack.iter().find(|layer| stack.len() == 2 && layer.name != *name);
            let only = other.map(|other| format!(": only {}", other.name)).unwrap_or_default();
            lines.push(line(of(&format!("without {name}{only}"), &of_others), colours));
        }
        if let Some(colours) = alone.as_ref().filter(|colours| is_varied || is_first(colours))
            && stack.len() > 2
        {
            let um = if is_varied { format!("{} µm", colours.thickness_um) } else { String::new() };
            lines.push(line(of(&format!("only {name}"), &um), colours));
        }
    }
    lines
}
