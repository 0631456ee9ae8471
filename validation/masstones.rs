//! Prints the page of `reports/measured`: measured paints beside Mie's theory and radiative transfer.

use inkwave::material::named::NamedMaterial;
use inkwave_validation::measured::{COMPARISONS, PredictedTint, predicted_tint, ratios, spread};

fn lab([l, a, b]: [f64; 3]) -> String {
    format!("{l:.1}, {a:.1}, {b:.1}")
}

fn colours() {
    println!(
        "| paint | material, median diameter | measured L\\*, a\\*, b\\* | estimated | ΔE₀₀ | surface | ΔE₀₀ with it | paints differ by | within | why |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for comparison in COMPARISONS {
        let paints = comparison.compared();
        let makers = spread(&paints);
        for paint in &paints {
            let within = if makers == 0.0 {
                "one paint"
            } else if paint.with_surface <= makers {
                "yes"
            } else {
                "no"
            };
            println!(
                "| {} | {}, {:.0} nm | {} | {} | {:.1} | {:.3} | {:.1} | {makers:.1} | {within} | {} |",
                paint.paint,
                comparison.material,
                1e3 * comparison.diameter_um,
                lab(paint.measured_lab),
                lab(paint.estimated_lab),
                paint.delta_e,
                paint.surface,
                paint.with_surface,
                comparison.reason,
            );
        }
    }
}

fn coefficients() {
    println!("| paint | material | nm | K/S measured | K/S estimated |\n|---|---|---|---|---|");
    for (paint, material) in [
        ("Red_Oxide", "haematite (Longtin)"),
        ("Red_Oxide", "haematite (Querry)"),
        ("Carbon_Black", "flame soot"),
    ] {
        let diameter_um = if paint == "Red_Oxide" { 0.2 } else { 0.08 };
        for [nm, measured, estimated] in ratios(paint, material, diameter_um).into_iter().step_by(5) {
            println!("| {paint} | {material} | {nm:.0} | {measured:.3} | {estimated:.3} |");
        }
    }
}

/// What the fit below is, and where it fails.
const FIT: &str = "`inkwave fit` of the Kimera red oxide, opaque, from its masstone alone; then `inkwave run` of its tint with white (0.20 to 0.35 by weight), beside\n\
         Kubelka and Munk from both masstones with equal scattering by weight. Lightened: the scalar wave, grids to 0.12, six realisations, six\n\
         wavelengths, 7 processor minutes; standard errors in the table. Assumed, since the maker does not say: 15 % of pigment by volume in both paints,\n\
         grains of 220 and 250 nm, n = 3.0 ± 0.1 at 589 nm, 0.034 of light from the face. n is not determined, and says so. What fails: the fitted\n\
         masstone is 0.02 to 0.03 too light up to 560 nm, so that κ is too small there (errors of the table's white nodes were taken for dark ones as\n\
         well, which has been mended since); the tint is a third too light at 640 nm, by two standard errors.";

fn tint() {
    println!("{FIT}\n");
    let PredictedTint { nm, columns, two_fluxes, delta_e } = predicted_tint();
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    println!("| nm | {} | tint by Kubelka–Munk |", names.join(" | ").replace('_', " "));
    println!("|---|{}", "---|".repeat(columns.len() + 1));
    for (row, nm) in nm.iter().enumerate() {
        let cells: Vec<String> = columns.iter().map(|(_, values)| format!("{:.3}", values[row])).collect();
        println!("| {nm:.0} | {} | {:.3} |", cells.join(" | "), two_fluxes[row]);
    }
    let [wave, munk] = delta_e;
    println!(
        "\nΔE₀₀ of the tint to the measured one: {wave:.1} from the fitted index, {munk:.1} by Kubelka and Munk."
    );
}

fn main() {
    println!("## Masstones\n");
    colours();
    println!("\n## K/S\n");
    coefficients();
    println!("\n## A masstone fitted, and its tint\n");
    tint();
    println!("\n## Listed materials without a measured paint here\n");
    let compared = |name: &str| COMPARISONS.iter().any(|comparison| comparison.material == name);
    let rest = inkwave::material::named::MATERIALS.iter().map(|material: &NamedMaterial| material.name);
    println!("{}.", rest.filter(|name| !compared(name)).collect::<Vec<_>>().join(", "));
}
