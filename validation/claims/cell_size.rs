//! A larger period changes the ensemble's means by no more than their error bars.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::ensemble::Layers;
use inkwave::appearance::bdf::{Bdf, Lobe};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::numerics::estimate::Estimate;
use inkwave::wave::FarField;
use std::f64::consts::PI;

pub const CLAIM: Claim = Claim {
    id: "16-cell-size",
    statement: "From 2.4 µm on, the period changes R and T of an absorbing layer (κ = 0.1) and their incoherent parts by less than 0.0049, what moves L* of a middle grey by 0.3, and the BTDF by less than that over π.",
    because: "Packings decorrelate within some diameters, and the power of guided waves decays within 1/(2 k Im n), 1.6 µm here, so wider cells sample the infinite layer. Narrower ones do not (plots), and by the same length clearer layers need more, which is not measured here (examples/paper-study-errors.toml doubles the period of one ink).",
    file: file!(),
    measure,
};

/// Name, the difference that is allowed, and the number.
type Quantity = (&'static str, f64, fn(&Bdf) -> f64);

/// Grains of the narrowest cell that is judged, 2.4 µm wide.
const FEWEST_GRAINS: usize = 127;
/// The same cone around the normal for every cell: half the hemisphere's directions.
const BANDWIDTH: f64 = 0.45;

/// A change of a reflectance of 0.5 that moves its L* by 0.3, the finest target of colour in the studies here:
/// 0.3 / (116/3 × 0.5^(−2/3)).
const SEEN: f64 = 0.3 / 61.38;

/// The incoherent parts, because the share of scattered light that the specular order takes shrinks with the cell.
const QUANTITIES: [Quantity; 5] = [
    ("reflectance", SEEN, |b| b.totals(Lobe::Reflected).total.value),
    ("transmittance", SEEN, |b| b.totals(Lobe::Transmitted).total.value),
    ("incoherent reflectance", SEEN, |b| incoherent(b, Lobe::Reflected)),
    ("incoherent transmittance", SEEN, |b| incoherent(b, Lobe::Transmitted)),
    ("BTDF at 30°, azimuthal mean, 1/sr", SEEN / PI, |b| {
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
    let judged: Vec<usize> = (0..solved.len()).filter(|&i| ensembles[i].0 >= FEWEST_GRAINS).collect();
    for (name, allowed, quantity) in QUANTITIES {
        let values: Vec<(f64, Estimate)> =
            solved.iter().map(|(side, f)| (*side, estimate(f, quantity))).collect();
        let apart = |i: usize, j: usize| {
            let a = values[i].1;
            let b = values[j].1;
            let bar = a.standard_error.expect("several").hypot(b.standard_error.expect("several"));
            ((a.value - b.value).abs(), bar)
        };
        let pairs = judged.iter().flat_map(|&i| judged.iter().filter(move |&&j| j > i).map(move |&j| (i, j)));
        let largest = pairs.map(|(i, j)| apart(i, j)).map(|(d, bar)| d + 2.0 * bar).fold(0.0, f64::max);
        let because = "what moves L* of a grey of 0.5 by 0.3; a half-space filled with a BTDF transmits π times it; two standard errors are added, so that noise cannot hide a difference";
        findings.promise(
            format!("{name}: largest difference from 2.4 µm on, + 2 errors"),
            largest,
            allowed,
            because,
        );
        if level == Level::Full && name == "transmittance" {
            let (difference, bar) = apart(0, judged[0]);
            let because = "the power of the comparison: a cell of 1.2 µm is distinguished from one of 2.4 µm";
            let what = "transmittance, 1.2 against 2.4 µm, in standard errors";
            findings.check(what, difference / bar, Bound::AtLeast(4.0), Reason::Significance, because);
        }
        let points = values.iter().map(|(side, v)| [*side, v.value, v.standard_error.unwrap_or(0.0)]);
        let curve = Curve::with_bars("mean ± standard error", Style::Data, points);
        findings.plots.push(Chart::linear(&format!("Cell size: {name}"), "period L, µm", name, vec![curve]));
    }
}
