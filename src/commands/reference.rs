//! What the program has to look up: `inkwave schema`, JSON Schemas and commented examples of the
//! input files; `inkwave materials`, the measured materials that come with it; `inkwave completions
//! SHELL` and `inkwave man FOLDER`, generated from the definitions behind `--help`.

use super::terminal::say;
use clap::{Args, Command};
use clap_complete::Shell;
use inkwave::material::named::{MATERIALS, Masstone, NamedMaterial};
use inkwave::schema::Document;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::path::PathBuf;

/// Print the JSON Schema of an input file, for editors, or a commented file with every key
#[derive(Args)]
pub struct SchemaArgs {
    /// Kind of input file
    #[arg(value_enum, default_value_t = Document::Study)]
    kind: Document,
    /// Print a commented file with every key, its meaning, range and default instead of the schema
    #[arg(long)]
    annotated: bool,
}

/// Prints the schema or the commented file.
pub fn schema(args: &SchemaArgs) -> Result<()> {
    if args.annotated {
        return say(args.kind.every_key().trim_end());
    }
    say(serde_json::to_string_pretty(&args.kind.schema()).into_diagnostic()?)
}

/// List the measured materials for `index = { material = "…" }`: use, range, index at 550 nm, what
/// was measured, and the colour of a paint beside measured ones
#[derive(Args)]
pub struct MaterialsArgs {
    /// Show only this material, with its grade, its seams and its sources
    pub name: Option<String>,
}

/// Prints the list, or one material.
pub fn materials(args: &MaterialsArgs) -> Result<()> {
    let Some(name) = &args.name else {
        return MATERIALS.iter().try_for_each(|material| say(row(material)));
    };
    let Some(known) = NamedMaterial::find(name) else {
        let names = MATERIALS.iter().map(|material| material.name).collect::<Vec<_>>().join(", ");
        let alike = NamedMaterial::with_words(name);
        let help = match alike.as_slice() {
            [] => "no open collection of indices holds organic pigments: give measured n and κ as index = { csv = \"…\" }".to_owned(),
            alike => format!("did you mean {}?", alike.join(" or ")),
        };
        return Err(miette!(help = help, "no material {name:?}; known are {names}"));
    };
    say(row(known))?;
    grade(known)?;
    for source in known.sources() {
        say!("  {}\n  {}", source.reference, source.comment)?;
    }
    if known.is_birefringent() {
        say!("  Birefringent: the waves see the orientation average of ε, such as (2 ε_o + ε_e)/3.")?;
    }
    if known.is_uniaxial() {
        say!(
            "  Both rays, with Maxwell's equations: index = {{ material = {:?}, birefringent = true }}",
            known.name
        )?;
    }
    known.origins().try_for_each(|line| say!("  {line}"))
}

/// What was measured, where κ is known, where records are joined, and what a paint looks like.
fn grade(material: &NamedMaterial) -> Result<()> {
    if let Some(former) = material.former.first() {
        say!("  formerly: {former}, which is still read")?;
    }
    say!("  sample: {}", material.grade.sample)?;
    say!("  κ: {}", material.grade.kappa)?;
    for [end, start] in material.index().seams_nm() {
        say!("  seam: two records, straight from {end:.0} to {start:.0} nm")?;
    }
    let Some(Masstone { lab: [l, a, b], diameter_nm, paints, delta_e_2000: [least, most], verdict, .. }) =
        material.grade.masstone
    else {
        return say!("  masstone: compared with no measured paint");
    };
    say!(
        "  masstone: L* {l:.0}, a* {a:.0}, b* {b:.0} with grains of {diameter_nm:.0} nm; ΔE₀₀ {least:.1} to {most:.1} from {paints}"
    )?;
    say!("  {verdict}")
}

fn row(material: &NamedMaterial) -> String {
    let NamedMaterial { name, what, .. } = material;
    let index = material.index();
    let [from, to] = index.range_nm();
    let eta = index.index(0.55);
    let sample = material.grade.sample;
    let mut row = format!(
        "{name:<20} {what:<48} {from:>4.0}–{to:.0} nm   {:.3} + {:.4}i at 550 nm   {sample}",
        eta.re, eta.im
    );
    if let Some(Masstone { lab: [l, a, b], delta_e_2000: [least, most], .. }) = material.grade.masstone {
        row += &format!("; masstone {l:.0}, {a:.0}, {b:.0}, ΔE₀₀ {least:.1} to {most:.1} from paints");
    }
    row
}

/// Print the completion script for a shell
///
/// For example: inkwave completions bash > ~/.local/share/bash-completion/completions/inkwave
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// Shell to complete for
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Write the man pages, one per command, to a folder
#[derive(Debug, Args)]
pub struct ManArgs {
    /// Output folder (created if missing)
    pub folder: PathBuf,
}

/// Prints the completions.
pub fn completions(args: &CompletionsArgs, mut command: Command) -> Result<()> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "inkwave", &mut text);
    say(String::from_utf8_lossy(&text).trim_end())
}

/// Writes the pages.
pub fn man(args: &ManArgs, command: Command) -> Result<()> {
    let cannot = || format!("cannot write to {}", args.folder.display());
    std::fs::create_dir_all(&args.folder).into_diagnostic().wrap_err_with(cannot)?;
    clap_mangen::generate_to(command, &args.folder).into_diagnostic().wrap_err_with(cannot)?;
    say!("man pages: {}", args.folder.display())
}
