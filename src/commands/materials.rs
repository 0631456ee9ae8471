//! Lists the measured materials that come with the program.

use clap::Args;
use inkwave::material::named::{MATERIALS, NamedMaterial};

/// List the materials for index = { material = "…" }: use, range, index at 550 nm, source
#[derive(Args)]
pub struct MaterialsArgs {
    /// Only this material, with its comment
    pub name: Option<String>,
}

pub fn run(args: &MaterialsArgs) -> miette::Result<()> {
    let Some(name) = &args.name else {
        return MATERIALS.iter().try_for_each(|material| say!("{}", row(material)));
    };
    let Some(known) = NamedMaterial::find(name) else {
        let names = MATERIALS.iter().map(|material| material.name).collect::<Vec<_>>().join(", ");
        let help = "organic pigments are in no open collection of indices: give measured n and κ as csv";
        return Err(miette::miette!(help = help, "no material {name:?}; known are {names}"));
    };
    say!("{}", row(known))?;
    for source in known.sources() {
        say!("  {}\n  {}", source.reference, source.comment)?;
    }
    if known.is_birefringent() {
        say!("  Birefringent: the waves see the orientation average, ε = (2 ε_o + ε_e)/3.")?;
    }
    say!("  From the refractiveindex.info database, CC0 1.0.")
}

fn row(material: &NamedMaterial) -> String {
    let index = material.index();
    let [from, to] = index.range_nm();
    let eta = index.index(0.55);
    let NamedMaterial { name, what, .. } = material;
    format!("{name:<14} {what:<38} {from:.0}–{to:.0} nm   {:.3} + {:.4}i at 550 nm", eta.re, eta.im)
}
