//! A larger period changes the ensemble's means by no more than their error bars.

use crate::claim::{Claim, Findings, Level};
use crate::ensemble::Layers;
use crate::figure::{Curve, LogPlot, Style};
use inkwave::appearance::bdf::{Bdf, Lobe};
use inkwave::appearance::estimate::Estimate;
use statrs::distribution::{ContinuousCDF, StudentsT};

pub const CLAIM: Claim = Claim {
    id: "16-cell-size",
    statement: "Doubling the period changes reflectance, transmittance, the diffuse parts and the BTDF by less than their error bars allow.",
    because: "Packings decorrelate within some diameters, so cells of several diameters sample the infinite layer; what is left is speckle.",
    file: file!(),
    measure,
};

type Quantity = (&'static str, fn(&Bdf) -> Estimate);

const SIGNIFICANCE: f64 = 1e-3;
/// The same cone around the normal for every cell: half the hemisphere's directions.
const BANDWIDTH: f64 = 0.45;

const QUANTITIES: [Quantity; 5] = [
    ("reflectance", |b| b.totals(Lobe::Reflected).total),
    ("transmittance", |b| b.totals(Lobe::Transmitted).total),
    ("diffuse reflectance", |b| b.totals(Lobe::Reflected).diffuse),
    ("diffuse transmittance", |b| b.totals(Lobe::Transmitted).diffuse),
    ("BTDF at 30°, azimuthal mean, 1/sr", |b| {
        b.azimuthal_mean(Lobe::Transmitted, 30.0, BANDWIDTH).expect("orders are near").bdf
    }),
];

fn measure(level: Level, findings: &mut Findings) {
    let sides: &[(f64, u64)] =
        level.pick(&[(1.6, 32), (3.2, 12)], &[(1.2, 96), (1.6, 64), (2.4, 32), (3.2, 24), (4.8, 12)]);
    let ensembles: Vec<(f64, Bdf)> = sides
        .iter()
        .map(|&(side_um, realisations)| {
            let layers = Layers { side_um, kappa: 0.02, polar_deg: 0.0, seed: 16, realisations };
            (side_um, Bdf::from_ensemble(&layers.solved()).expect("one ensemble"))
        })
        .collect();
    let judged: Vec<&(f64, Bdf)> = ensembles.iter().filter(|e| e.0 >= 1.6).collect();
    let (largest, others) = judged.split_last().expect("several sides");
    for (name, quantity) in QUANTITIES {
        let of = |b: &Bdf| quantity(b);
        for (side, bdf) in others {
            let (a, b) = (of(bdf), of(&largest.1));
            let bar = a.standard_error.expect("several").hypot(b.standard_error.expect("several"));
            let fewest = bdf.realisations().min(largest.1.realisations()) as f64;
            let student = StudentsT::new(0.0, 1.0, fewest - 1.0).expect("several");
            findings.significance(
                format!("{name}, {side} against {} µm, in standard errors", largest.0),
                (a.value - b.value).abs() / bar,
                student.inverse_cdf(1.0 - 0.5 * SIGNIFICANCE),
                "|t| with the smaller ensemble's degrees of freedom: probability 1e-3",
            );
        }
        findings.plots.push(plot(name, &ensembles, quantity));
    }
}

fn plot(name: &str, ensembles: &[(f64, Bdf)], quantity: fn(&Bdf) -> Estimate) -> LogPlot {
    let points = ensembles.iter().map(|(side, bdf)| {
        let value = quantity(bdf);
        [*side, value.value, value.standard_error.unwrap_or(0.0)]
    });
    let title = format!("Cell size: {name}");
    LogPlot::linear(
        &title,
        "period L, µm",
        name,
        vec![Curve::with_bars("mean ± standard error", Style::Data, points)],
    )
}
