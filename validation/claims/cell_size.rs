//! A larger period changes the ensemble's means by no more than their error bars.

use crate::claim::{Claim, Findings, Level};
use crate::ensemble::Layers;
use crate::figure::{Curve, LogPlot, Style};
use inkwave::appearance::bdf::{Bdf, Lobe};
use inkwave::appearance::estimate::Estimate;
use inkwave::wave::FarField;
use statrs::distribution::{ContinuousCDF, StudentsT};

pub const CLAIM: Claim = Claim {
    id: "16-cell-size",
    statement: "From 2.4 µm on, doubling the period changes reflectance, transmittance, the incoherent parts and the BTDF by less than their error bars allow.",
    because: "Packings decorrelate within some diameters and guided waves decay within 1/(k Im n), 1.5 µm here, so wider cells sample the infinite layer. Narrower ones do not: at 1.2 and 1.6 µm transmittance is lower by 2 and 1 %, as the plots show.",
    file: file!(),
    measure,
};

type Quantity = (&'static str, fn(&Bdf) -> f64);

/// Grains of the narrowest cell that is judged, 2.4 µm wide.
const FEWEST_GRAINS: usize = 127;
/// Of all comparisons together; each gets its share.
const SIGNIFICANCE: f64 = 1e-3;
/// The same cone around the normal for every cell: half the hemisphere's directions.
const BANDWIDTH: f64 = 0.45;

/// The incoherent parts, because the share of scattered light that the specular order takes shrinks with the cell.
const QUANTITIES: [Quantity; 5] = [
    ("reflectance", |b| b.totals(Lobe::Reflected).total.value),
    ("transmittance", |b| b.totals(Lobe::Transmitted).total.value),
    ("incoherent reflectance", |b| incoherent(b, Lobe::Reflected)),
    ("incoherent transmittance", |b| incoherent(b, Lobe::Transmitted)),
    ("BTDF at 30°, azimuthal mean, 1/sr", |b| {
        b.azimuthal_mean(Lobe::Transmitted, 30.0, BANDWIDTH).expect("orders are near").bdf.value
    }),
];

fn incoherent(bdf: &Bdf, lobe: Lobe) -> f64 {
    let totals = bdf.totals(lobe);
    totals.total.value - totals.coherent.expect("several realisations").value
}

/// Whole ensemble with the jackknife's error.
fn estimate(fields: &[FarField], quantity: fn(&Bdf) -> f64) -> Estimate {
    let of = |fields: &[FarField]| quantity(&Bdf::from_ensemble(fields).expect("one ensemble"));
    let without = |r: usize| {
        let others: Vec<FarField> = [&fields[..r], &fields[r + 1..]].concat();
        of(&others)
    };
    Estimate::jackknife(of(fields), &(0..fields.len()).map(without).collect::<Vec<_>>())
}

fn measure(level: Level, findings: &mut Findings) {
    // Grains that fill 30 % exactly, so that cells differ in nothing but size: 1.2, 1.6, 2.4, 3.2, 4.8 and 6.4 µm.
    let ensembles: &[(usize, u64)] =
        level.pick(&[(127, 24), (507, 8)], &[(32, 96), (56, 64), (127, 48), (225, 32), (507, 20), (901, 12)]);
    let solved: Vec<(f64, Vec<FarField>)> = ensembles
        .iter()
        .map(|&(grains, realisations)| {
            let layers = Layers { grains, kappa: 0.1, polar_deg: 0.0, seed: 16, realisations };
            (layers.side_um(), layers.solved())
        })
        .collect();
    let doubled: Vec<(usize, usize)> = (0..solved.len())
        .flat_map(|i| (0..solved.len()).map(move |j| (i, j)))
        .filter(|&(i, j)| ensembles[i].0 >= FEWEST_GRAINS && (solved[j].0 / solved[i].0 - 2.0).abs() < 0.01)
        .collect();
    let comparisons = QUANTITIES.len() * doubled.len();
    for (name, quantity) in QUANTITIES {
        let values: Vec<(f64, Estimate)> =
            solved.iter().map(|(side, f)| (*side, estimate(f, quantity))).collect();
        for &(i, j) in &doubled {
            let [(narrow, a), (wide, b)] = [values[i], values[j]];
            let bar = a.standard_error.expect("several").hypot(b.standard_error.expect("several"));
            let fewest = ensembles[i].1.min(ensembles[j].1) as f64;
            let student = StudentsT::new(0.0, 1.0, fewest - 1.0).expect("several");
            findings.significance(
                format!("{name}, {narrow:.1} against {wide:.1} µm, in standard errors"),
                (a.value - b.value).abs() / bar,
                student.inverse_cdf(1.0 - 0.5 * SIGNIFICANCE / comparisons as f64),
                "|t| with the smaller ensemble's degrees of freedom: probability 1e-3 for all comparisons together",
            );
        }
        let points = values.iter().map(|(side, v)| [*side, v.value, v.standard_error.unwrap_or(0.0)]);
        let curve = Curve::with_bars("mean ± standard error", Style::Data, points);
        findings.plots.push(LogPlot::linear(
            &format!("Cell size: {name}"),
            "period L, µm",
            name,
            vec![curve],
        ));
    }
}
