//! Opaque paints of listed materials beside measured ones.

use crate::claim::{Bound, Claim, Findings, Level, Reason, Table};
use crate::formulas::opaque::seen_through_a_face;
use crate::measured::{COMPARISONS, Compared, Comparison, ratios, spread};
use inkwave::material::named::NamedMaterial;
use std::f64::consts::FRAC_1_SQRT_2;

pub const CLAIM: Claim = Claim {
    id: "47-masstones",
    statement: "The black pigment of the list has the colour of measured paints, and the list says what paints of its materials look like.",
    because: "Measured masstones (data/measured) beside Mie's theory with adding and doubling; the tolerance is what the makers differ by among themselves.",
    file: file!(),
    measure,
};

/// What the Mars blacks of seven makers, of which two are in the excerpt, differ by, ΔE₀₀.
const BLACKS_DIFFER: f64 = 5.0;

fn measure(_: Level, findings: &mut Findings) {
    let known = isotropic(0.99);
    let got = seen_through_a_face(0.99, &|_| 1.0, 1.0, 3e3);
    findings.identity(
        "adding and doubling for isotropic scattering, relative to Chandrasekhar's H",
        got / known - 1.0,
        1e-3,
        "16 directions, and layers of optical thickness 1e-6 to begin with",
    );
    let mut rows = Vec::new();
    for comparison in COMPARISONS {
        let paints = comparison.compared();
        rows.extend(paints.iter().map(|paint| row(comparison, paint, spread(&paints))));
        judge(comparison, &paints, findings);
    }
    let columns = [
        "paint",
        "material",
        "measured L*, a*, b*",
        "estimated",
        "ΔE₀₀",
        "surface",
        "ΔE₀₀ with it",
        "makers differ by",
        "why",
    ];
    findings.tables.push(Table {
        title: "Masstones, D50, 2°, 45:0".into(),
        columns: columns.map(str::to_owned).into(),
        rows,
    });
    for (column, material, diameter_um) in
        [("Red_Oxide", "haematite (Longtin)", 0.2), ("Red_Oxide", "haematite (Querry)", 0.2)]
    {
        let rows = ratios(column, material, diameter_um).into_iter().step_by(5);
        findings.tables.push(Table {
            title: format!("K/S of {column} (Okumura 2005) and of {material}"),
            columns: ["nm", "measured", "estimated"].map(str::to_owned).into(),
            rows: rows
                .map(|[nm, a, b]| vec![format!("{nm:.0}"), format!("{a:.3}"), format!("{b:.3}")])
                .collect(),
        });
    }
}

/// The black must be the paints'; what the list says of colours must be what the estimate gives.
fn judge(comparison: &Comparison, paints: &[Compared], findings: &mut Findings) {
    let furthest = paints.iter().map(|paint| paint.with_surface).fold(0.0, f64::max);
    match comparison.material {
        "magnetite (Jena)" => findings.promise(
            "magnetite (Jena) with the light of the paints' surfaces: ΔE₀₀ to the Mars black furthest from it",
            furthest,
            BLACKS_DIFFER,
            "seven makers' Mars blacks differ by 5 among themselves",
        ),
        "magnetite (Querry)" => findings.check(
            "magnetite (Querry) likewise, which the list says is not the black pigment",
            furthest,
            Bound::AtLeast(2.0 * BLACKS_DIFFER),
            Reason::Promise,
            "a record twice as far from the paints as they are from each other is of something else",
        ),
        _ => {}
    }
    let listed = NamedMaterial::find(comparison.material).and_then(|material| material.grade.masstone);
    let Some(listed) = listed.filter(|listed| comparison.paints.1.starts_with(listed.paints_named)) else {
        return;
    };
    let estimated = paints[0].estimated_lab;
    let off = (0..3).map(|i| (listed.lab[i] - estimated[i]).abs()).fold(0.0, f64::max);
    findings.identity(
        format!("listed masstone of {}: L*, a*, b*", comparison.material),
        off,
        0.06,
        "one printed decimal",
    );
    let range = paints.iter().fold([f64::INFINITY, 0.0], |[lo, hi], paint| {
        [f64::min(lo, paint.delta_e), f64::max(hi, paint.delta_e)]
    });
    let off = (0..2).map(|i| (listed.delta_e_2000[i] - range[i]).abs()).fold(0.0, f64::max);
    findings.identity(format!("listed ΔE₀₀ of {}", comparison.material), off, 0.06, "one printed decimal");
}

fn row(comparison: &Comparison, paint: &Compared, makers: f64) -> Vec<String> {
    let lab = |[l, a, b]: [f64; 3]| format!("{l:.1}, {a:.1}, {b:.1}");
    vec![
        paint.paint.clone(),
        format!("{}, {:.0} nm", comparison.material, 1e3 * comparison.diameter_um),
        lab(paint.measured_lab),
        lab(paint.estimated_lab),
        format!("{:.1}", paint.delta_e),
        format!("{:.4}", paint.surface),
        format!("{:.1}", paint.with_surface),
        format!("{makers:.1}"),
        comparison.reason.to_owned(),
    ]
}

/// Reflectance factor of a half-space of isotropic scatterers without a face, lit at 45°, seen along the normal:
/// ϖ H(μ)H(μ₀)/4(μ + μ₀), with 1/H(μ) = √(1 − ϖ) + ϖ/2 ∫ x H(x)/(x + μ) dx (Chandrasekhar, Radiative Transfer, 1950, V).
fn isotropic(albedo: f64) -> f64 {
    const POINTS: usize = 2000;
    let x: Vec<f64> = (0..POINTS).map(|i| (i as f64 + 0.5) / POINTS as f64).collect();
    let mut h = vec![1.0; POINTS];
    let at = |h: &[f64], mu: f64| {
        let sum: f64 = x.iter().zip(h).map(|(x, h)| x * h / (x + mu)).sum();
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * sum / POINTS as f64)
    };
    for _ in 0..100 {
        h = x.iter().map(|mu| at(&h, *mu)).collect();
    }
    albedo * at(&h, 1.0) * at(&h, FRAC_1_SQRT_2) / (4.0 * (1.0 + FRAC_1_SQRT_2))
}
