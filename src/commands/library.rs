//! `inkwave library FOLDER…`: solved layers as plates. `inkwave compose FILE --library FILE`: a
//! stack of them on paper, without a solve.

use super::diagnostics::mixed_up_report;
use clap::Args;
use inkwave::evaluate::composed::composition::{ComposedStack, Composition, compose as composed};
use inkwave::evaluate::composed::library::Library;
use inkwave::input::load::read_toml_or_json;
use inkwave::library::gather::{GatherError, from_file, gather};
use inkwave::library::page::page;
use inkwave::numerics::allowed::brief;
use inkwave::numerics::estimate::Estimate;
use inkwave::store::safely;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::{Path, PathBuf};

/// Gather solved layers as plates, from which stacks in any order are composed without a solve
#[derive(Debug, Args)]
pub struct LibraryArgs {
    /// Folders of finished runs and sweeps of stacks with `stack.composed.joint_index`, and libraries
    #[arg(required = true)]
    pub sources: Vec<PathBuf>,
    /// The library
    #[arg(long, short, value_name = "FILE", default_value = "library.json")]
    pub output: PathBuf,
    /// Also write a page on which its plates are composed
    #[arg(long, value_name = "FILE")]
    pub page: Option<PathBuf>,
}

/// Compose plates of a library to a stack on paper
#[derive(Debug, Args)]
pub struct ComposeArgs {
    /// The composition (TOML or JSON): layers, paper, dots, illuminant, observer
    pub composition: PathBuf,
    /// The library
    #[arg(long, value_name = "FILE", default_value = "library.json")]
    pub library: PathBuf,
    /// Write all numbers as JSON
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Gathers and writes the library.
pub fn library(args: &LibraryArgs) -> Result<()> {
    let gathered = gather(&args.sources).map_err(refusal)?;
    let library = &gathered.library;
    write(&args.output, &serde_json::to_string(library).into_diagnostic()?)?;
    for plate in &library.plates {
        let um = brief(plate.thickness_um);
        let kind = match plate.slabs {
            true => format!("cut into slabs of {um} µm"),
            false => format!("solved whole, {um} µm"),
        };
        let cells = plate.portions.first().and_then(|p| p.states.first()).map_or(0, |s| s.replicates.len());
        say!("{}: {kind}, means over {cells} realisations (cells of random grains)", plate.name)?;
    }
    for words in &gathered.left_out {
        say!("{words}")?;
    }
    say!("Library: {}", args.output.display())?;
    if let Some(path) = &args.page {
        write(path, &page(&gathered, "Library of plates").into_diagnostic()?)?;
        say!("Page: {}", path.display())?;
    }
    Ok(())
}

/// Composes and prints the colours.
pub fn compose(args: &ComposeArgs) -> Result<()> {
    let library = from_file(&args.library).map_err(refusal)?;
    let composition: Composition =
        read_toml_or_json(&args.composition).map_err(|error| mixed_up_report(error, "composition"))?;
    let found = composed(&library, &composition);
    let found = found.map_err(|reason| {
        let plates: Vec<&str> = library.plates.iter().map(|plate| plate.name.as_str()).collect();
        let plates = plates.join(", ");
        let help = format!("`inkwave schema composition` has every key; plates of this library: {plates}");
        miette!(help = help, "{}: {reason}", args.composition.display())
    })?;
    if let Some(path) = &args.output {
        write(path, &serde_json::to_string_pretty(&found).into_diagnostic()?)?;
    }
    tell(&library, &found)
}

fn tell(library: &Library, found: &ComposedStack) -> Result<()> {
    let names: Vec<&str> = found.composition.layers.iter().map(|layer| layer.plate.as_str()).collect();
    let stack = names.join(" on ");
    let lab = |[l, a, b]: [Estimate; 3]| {
        format!("L* {}, a* {}, b* {}", l.in_words(2), a.in_words(2), b.in_words(2))
    };
    let lit = found.colours.as_ref().and_then(|colours| colours.lit_at_45);
    let natural = found.colours.as_ref().and_then(|colours| colours.natural_light);
    if let Some(all) = natural {
        say!("{stack}: {} under natural light", lab(all.map(|part| part.estimate())))?;
    }
    if let Some(all) = lit {
        say!("{stack}: {} at 45:0", lab(all.map(|part| part.estimate())))?;
    }
    if let Some(ratio) = found.colours.as_ref().and_then(|colours| colours.contrast_ratio) {
        say!("{stack}: contrast ratio {}", ratio.estimate().in_words(3))?;
    }
    if let Some(dots) = &found.dots {
        let all = [dots.lab[0].estimate(), dots.lab[1].estimate(), dots.lab[2].estimate()];
        say!("{stack}: {} in dots at 45:0", lab(all))?;
    }
    for reason in &found.withheld {
        say!("{stack}: no result: {}", reason.in_words())?;
    }
    if let Some(surface) = &found.scalar_surface {
        say!("{stack}: {}", surface.in_words())?;
    }
    if found.colours.is_none() {
        let nm = library.wavelengths_nm.len();
        say!("{stack}: no colour: the library has {nm} wavelengths, which do not cover 400 to 700 nm")?;
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    safely::write(path, text.as_bytes()).into_diagnostic().wrap_err_with(|| path.display().to_string())
}

fn refusal(error: GatherError) -> miette::Report {
    let help = "a library is made of folders of `inkwave run` whose stacks have stack.composed.joint_index";
    miette!(help = help, "{error}")
}
