//! The page and the pictures of a composed layer, beside its tables.

mod tables;

pub use tables::{coefficients, tables};

use super::page::{FailureRow, Figure, MakerBlock, Meant, Named, Page, Picture, Provenance, png_data};
use super::publish::{Pictures, PublishError, picture_angles};
use super::sheet;
use crate::draw::chart::{Chart, Curve, Style};
use crate::evaluate::composed::level::SolvedPortion;
use crate::evaluate::composed::manifest::{
    ComposedColours, ComposedManifest, ComposedRow, ErrorParts, MediumRow,
};
use crate::evaluate::composed::report::report;
use crate::evaluate::composed::view::ComposedView;
use crate::evaluate::ink::InkError;
use crate::evaluate::manifest::Status;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;
use crate::run::crew::processor_seconds;
use crate::store::folder::OutputFolder;
use tables::shares;

/// What was published of a composed layer.
#[derive(Clone, Debug, PartialEq)]
pub struct PublishedLayer {
    /// Whether anything is missing.
    pub status: Status,
    /// Its main results, one line each.
    pub lines: Vec<String>,
    /// The layer at every thickness asked for and wavelength.
    pub spectra: Vec<ComposedRow>,
    /// The medium at every wavelength.
    pub medium: Vec<MediumRow>,
    /// Thickness that hides, µm.
    pub hiding_thickness_um: Option<ErrorParts>,
    /// What to change.
    pub remarks: Vec<String>,
}

/// Writes `results.json`, tables and page.
///
/// # Errors
/// Slabs without a complete realisation; files that cannot be written.
pub fn publish(
    study: &Study,
    solved: &[SolvedPortion],
    folder: &OutputFolder,
) -> Result<PublishedLayer, PublishError> {
    let manifest = report(study, solved).map_err(PublishError::Slabs)?;
    let manifest = ComposedManifest { process_seconds: processor_seconds(), ..manifest };
    if let Some(row) = manifest.spectra.iter().find(|row| !is_physical(row)) {
        let place = format!("a share at {} µm and {} nm", row.thickness_um, row.wavelength_nm);
        return Err(PublishError::Unphysical(format!("{place} is not between 0 and 1")));
    }
    let pictures = pictures(&manifest, solved)?;
    let page = page(&manifest, pictures.first())?;
    folder.begin()?;
    for (k, (um, picture)) in pictures.iter().enumerate() {
        let of = if k == 0 { String::new() } else { format!("-{um}um") };
        folder.write(&format!("picture{of}.png"), &picture.plain)?;
        folder.write(&format!("picture{of}-with-axes.png"), &picture.labelled)?;
    }
    for (name, table, _) in tables(&manifest)? {
        folder.write(name, &table)?;
    }
    folder.write("results.json", &serde_json::to_vec_pretty(&manifest)?)?;
    folder.write("report.html", page.html()?.as_bytes())?;
    if manifest.status == Status::Complete {
        folder.complete()?;
    }
    Ok(PublishedLayer {
        status: manifest.status,
        lines: lines(&manifest),
        spectra: manifest.spectra,
        medium: manifest.medium,
        hiding_thickness_um: manifest.hiding_thickness_um,
        remarks: manifest.remarks,
    })
}

/// The picture of each thickness asked for, µm; none without a colour.
fn pictures(
    manifest: &ComposedManifest,
    solved: &[SolvedPortion],
) -> Result<Vec<(f64, Pictures)>, PublishError> {
    let (study, angles) = (manifest.study, picture_angles(manifest.study));
    let mut pictures = Vec::new();
    for &ComposedColours { thickness_um: um, .. } in &manifest.colours {
        let view = ComposedView::new(study, solved, um).map_err(PublishError::Slabs)?;
        let picture = view.picture(&angles, study.output.mirrored_sky).map_err(InkError::from)?;
        pictures.push((um, Pictures::new(&picture, study)?));
    }
    Ok(pictures)
}

/// Smaller errors are rounding, and are not shown.
const CERTAIN: f64 = 1e-6;
/// Largest overshoot of a share of light that its error can stand for.
const BEYOND: f64 = 0.03;

fn is_physical(row: &ComposedRow) -> bool {
    let shares = shares(row).into_iter().take(6);
    shares
        .into_iter()
        .all(|(_, j)| (-BEYOND..=1.0 + BEYOND).contains(&j.value) && j.standard_error.is_finite())
}

fn words(judged: &ErrorParts, decimals: usize) -> String {
    let certain = judged.standard_error < CERTAIN;
    let estimate = if certain { Estimate::unknown_error(judged.value) } else { judged.estimate() };
    estimate.in_words(decimals)
}

fn lab(judged: &[ErrorParts; 3]) -> String {
    let [l, a, b] = [0, 1, 2].map(|i| words(&judged[i], 2));
    format!("L* {l}, a* {a}, b* {b}")
}

/// The results in a line each.
fn lines(manifest: &ComposedManifest) -> Vec<String> {
    let colour = |c: &ComposedColours| {
        let [seen, ratio] = [lab(&c.natural_light), words(&c.contrast_ratio, 3)];
        format!("{} µm: {seen} under natural light, contrast ratio {ratio}", c.thickness_um)
    };
    let mut lines: Vec<String> = manifest.colours.iter().map(colour).collect();
    if lines.is_empty() {
        lines.extend(manifest.spectra.iter().map(spectral_line));
    }
    lines.extend(manifest.hiding_thickness_um.map(|um| format!("hides at {} µm", words(&um, 1))));
    lines
}

fn spectral_line(row: &ComposedRow) -> String {
    let [r, t] = [row.reflectance_normal, row.transmittance_normal].map(|j| words(&j, 4));
    let [dr, dt] = [row.reflectance_diffuse, row.transmittance_diffuse].map(|j| words(&j, 4));
    let (um, nm) = (row.thickness_um, row.wavelength_nm);
    format!("{um} µm, {nm} nm: at 0° R {r}, T {t}; diffuse light R {dr}, T {dt}")
}

fn page(manifest: &ComposedManifest, picture: Option<&(f64, Pictures)>) -> Result<Page, PublishError> {
    let study = manifest.study;
    let caption = |um: f64| {
        format!("The layer of {um} µm. {} All are means over the azimuth.", sheet::picture_caption(study))
    };
    let picture = picture.map(|(um, png)| Picture { data: png_data(&png.labelled), caption: caption(*um) });
    let failure = |reason: &String| FailureRow { point: String::new(), reason: reason.clone() };
    Ok(Page {
        title: study.title.clone(),
        summary: summary(manifest),
        partial: partial(manifest),
        picture,
        figures: figures(manifest)?,
        ink_maker: Some(maker(manifest)),
        certainty: certainty(manifest),
        asked: sheet::asked(study),
        failures: manifest.failures.iter().map(failure).collect(),
        limits: limits(manifest),
        provenance: Provenance {
            program: manifest.program.clone(),
            rows: vec![
                Named::code("study", manifest.study_hash.clone()),
                Named::new("program", format!("{}, method {}", manifest.program, manifest.method_version)),
                Named::new("solves made by", manifest.builds.iter().cloned().collect::<Vec<_>>().join(", ")),
                Named::new("seed", manifest.seed.to_string()),
                Named::new("wave", study.wave.in_words()),
                Named::new("solves", manifest.solves.finished.to_string()),
                Named::new("time of all solves", format!("{:.0} s", manifest.solve_seconds)),
            ],
        },
        ..Page::default()
    })
}

/// What is missing of an unfinished study.
fn partial(manifest: &ComposedManifest) -> Option<String> {
    let solves = manifest.solves;
    let words = format!(
        "{} of {} solves are finished. Run the study again to continue.",
        solves.finished, solves.asked
    );
    (manifest.status != Status::Complete).then_some(words)
}

fn summary(manifest: &ComposedManifest) -> String {
    let composed = manifest.composed;
    let all: Vec<String> = composed.thicknesses_um.iter().map(|um| format!("{um}")).collect();
    let whole = sheet::summary(manifest.study);
    format!(
        "{whole} Composed of slabs of {:.3} µm, for thicknesses of {} µm.",
        composed.slab_um,
        all.join(", ")
    )
}

/// Curves against thickness and depth, and spectra.
fn figures(manifest: &ComposedManifest) -> Result<Vec<Figure>, PublishError> {
    let mut all = vec![
        ("Against thickness", shares_chart(manifest), SHARES),
        ("The light's way", depth_chart(manifest), DEPTH),
        ("On the paper", spectra_chart(manifest), SPECTRA),
    ];
    if !manifest.curve_colours.is_empty() {
        all.insert(1, ("Hiding", hiding_chart(manifest), HIDING));
        all.insert(2, ("Colour", colour_chart(manifest), COLOUR));
    }
    let mut figures = Vec::new();
    for (heading, chart, caption) in all {
        figures.push(Figure::new(heading, &chart, caption.to_owned())?);
    }
    Ok(figures)
}

const SHARES: &str = "Diffuse light reflected (R) and transmitted (T) by the layer without paper, against its \
    thickness. Error bars are standard errors, the model's part included.";
const DEPTH: &str = "Fluxes towards the paper and back in the layer on its paper, lit at 0°, as shares of the \
    incident light. Where their difference falls, light is absorbed.";
const SPECTRA: &str = "Light that reaches the eye along the normal under natural light, as a share of that of a \
    perfect white, for every thickness asked for.";
const HIDING: &str = "Contrast ratio (Y over black by Y over white, 45:0) and L*/100 on the paper under natural \
    light, against the thickness. 0.98 counts as hiding.";

const COLOUR: &str = "Colour on the paper under natural light, seen along the normal, against the thickness.";

fn against_thickness(y_label: &str, curves: Vec<Curve>) -> Chart {
    let chart = Chart::linear("", "thickness, µm", y_label, curves);
    Chart { log: [true, false], y_range: Some([0.0, 1.0]), ..chart }
}

fn shares_chart(manifest: &ComposedManifest) -> Chart {
    let curve = |nm: f64, name: &str, of: fn(&ComposedRow) -> ErrorParts| {
        let rows = manifest.curve.iter().filter(move |row| row.wavelength_nm == nm);
        Curve::measured(format!("{name}, {nm:.0} nm"), rows.map(|row| (row.thickness_um, of(row).estimate())))
    };
    let both = |nm: f64| {
        [curve(nm, "R", |row| row.reflectance_diffuse), curve(nm, "T", |row| row.transmittance_diffuse)]
    };
    let shown = sheet::shown_nm(&manifest.study.wavelengths_nm);
    against_thickness("share of the light", shown.into_iter().flat_map(both).collect())
}

/// Points of a number of the colours against the thickness, over `by`.
fn colour_points(
    manifest: &ComposedManifest,
    of: fn(&ComposedColours) -> ErrorParts,
    by: f64,
) -> impl Iterator<Item = [f64; 3]> {
    manifest.curve_colours.iter().map(move |c| {
        let judged = of(c);
        [c.thickness_um, judged.value / by, judged.standard_error / by]
    })
}

fn hiding_chart(manifest: &ComposedManifest) -> Chart {
    let curves = vec![
        Curve::with_bars("contrast ratio", Style::Data, colour_points(manifest, |c| c.contrast_ratio, 1.0)),
        Curve::with_bars(
            "L*/100 on the paper",
            Style::Data,
            colour_points(manifest, |c| c.natural_light[0], 100.0),
        ),
        Curve::with_bars(
            "L*/100 over black",
            Style::Data,
            colour_points(manifest, |c| c.over_black[0], 100.0),
        ),
    ];
    against_thickness("contrast ratio, L*/100", curves)
}

fn colour_chart(manifest: &ComposedManifest) -> Chart {
    let curve = |name: &str, of: fn(&ComposedColours) -> ErrorParts| {
        Curve::with_bars(name, Style::Data, colour_points(manifest, of, 1.0))
    };
    let curves = vec![
        curve("L*", |c| c.natural_light[0]),
        curve("a*", |c| c.natural_light[1]),
        curve("b*", |c| c.natural_light[2]),
    ];
    let chart = Chart::linear("", "thickness, µm", "L*, a*, b*", curves);
    Chart { log: [true, false], ..chart }
}

fn depth_chart(manifest: &ComposedManifest) -> Chart {
    let curve = |name: &str, of: fn([f64; 2]) -> f64| {
        let points = manifest.depth.iter().map(|row| (row.depth_um, of([row.down, row.up])));
        Curve::new(format!("{name}, {:.0} nm", manifest.depth_nm), Style::Data, points)
    };
    let curves = vec![curve("down", |[d, _]| d), curve("up", |[_, u]| u), curve("net", |[d, u]| d - u)];
    Chart { from_zero: true, ..Chart::linear("", "depth, µm", "flux, share of the incident light", curves) }
}

fn spectra_chart(manifest: &ComposedManifest) -> Chart {
    let curve = |um: &f64| {
        let rows = manifest.spectra.iter().filter(|row| row.thickness_um == *um);
        Curve::measured(format!("{um} µm"), rows.map(|row| (row.wavelength_nm, row.natural_light.estimate())))
    };
    let curves = manifest.composed.thicknesses_um.iter().map(curve).collect();
    let chart = Chart::linear("", "wavelength, nm", "share of a perfect white", curves);
    Chart { y_range: Some([0.0, 1.0]), ..chart }
}

/// Colours, hiding and the medium's coefficients.
fn maker(manifest: &ComposedManifest) -> MakerBlock {
    let colours = || manifest.colours.iter();
    let swatches =
        colours().map(|c| Named::new(format!("{} µm on the paper", c.thickness_um), c.hex.clone()));
    let mut rows: Vec<Meant> = Vec::new();
    for c in colours() {
        let um = c.thickness_um;
        let lab = [
            ("natural light", &c.natural_light, "on the paper, seen along the normal"),
            ("45°:0°", &c.lit_at_45, "on the paper"),
            ("over black", &c.over_black, "at 45°:0°"),
        ];
        rows.extend(lab.map(|(name, of, place)| {
            let value = of.each_ref().map(|j| words(j, 2)).join(", ");
            Meant::new(&format!("{um} µm, {name}"), value, format!("L*, a*, b* {place}"))
        }));
        let ratio = words(&c.contrast_ratio, 3);
        rows.push(Meant::new(
            &format!("{um} µm, contrast ratio"),
            ratio,
            "Y over black by Y over white of albedo 0.8",
        ));
    }
    let hiding = manifest.hiding_thickness_um.map_or_else(|| "–".to_owned(), |um| words(&um, 1) + " µm");
    let meaning =
        manifest.no_hiding.clone().unwrap_or_else(|| "where the contrast ratio reaches 0.98".to_owned());
    rows.push(Meant::new("hiding thickness", hiding, meaning));
    if let Some(rate) = manifest.spreading_rate_m2_per_l {
        rows.push(Meant::new(
            "spreading rate",
            words(&rate, 1) + " m²/l",
            "area that a litre of the dry layer hides",
        ));
    }
    let nearest = sheet::shown_nm(&manifest.study.wavelengths_nm);
    for row in manifest.medium.iter().filter(|row| nearest.contains(&row.wavelength_nm)) {
        let nm = row.wavelength_nm;
        for (name, j) in coefficients(row) {
            let name = name.replace("_per_um", ", 1/µm").replace("_um", ", µm").replace('_', " ");
            rows.push(Meant::new(
                &format!("{name}, {nm:.0} nm"),
                words(&j, 3),
                "of the packed layer, surfaces off",
            ));
        }
    }
    MakerBlock { swatches: swatches.collect(), rows }
}

/// Largest parts of the bars of R and T.
fn certainty(manifest: &ComposedManifest) -> Vec<Meant> {
    let all = || manifest.spectra.iter().flat_map(|row| shares(row).into_iter().take(6).map(|(_, j)| j));
    let largest = |of: fn(ErrorParts) -> f64| format!("{:.4}", all().map(of).fold(0.0, f64::max));
    vec![
        Meant::new(
            "chance",
            largest(|j| j.chance),
            "largest standard error of R and T: jackknife over the realisations of each slab",
        ),
        Meant::new(
            "model",
            largest(|j| j.model),
            "largest change of R and T with slabs of half the thickness: the loss of interference between slabs",
        ),
        Meant::new(
            "grid",
            largest(|j| j.grid),
            "largest change of R and T when every slab reflects more by the grid's error",
        ),
    ]
}

fn limits(manifest: &ComposedManifest) -> Vec<String> {
    let mut lines = vec![
        "The wave equation is solved within slabs; between slabs light is composed incoherently, by flux matrices averaged over \
         the azimuth and over realisations."
            .to_owned(),
        "Distributions are means over the azimuth, between few directions. [compare], targets and polarised natural light are \
         those of thin layers."
            .to_owned(),
    ];
    lines.extend(manifest.remarks.iter().cloned());
    lines.extend(manifest.no_colour.iter().map(|reason| format!("There is no colour: {reason}.")));
    lines
}
