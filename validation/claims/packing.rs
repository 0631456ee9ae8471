//! Packings against independent truths: pair statistics, two-point probability, orientation, walls, highest shares.

mod highest;

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::ink::pack;
use inkwave::ink::statistics::{PairStatistics, orientation_tensor, pair_statistics_to, section_statistics};
use inkwave::ink::{
    EquilibrationSettings, Method, MethodChoice, Orientation, Packing, PackingRequest, PigmentGrains, Shape,
};
use inkwave::numerics::estimate::Estimate;
use rayon::prelude::*;
use serde_json::Value;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal};

pub const CLAIM: Claim = Claim {
    id: "11-packing",
    statement: "Packings have the statistics of their truths: sequential addition those of RSA, equilibrated ones those of the hard-sphere fluid, free grains no preferred direction, and walls are not crossed; the highest shares come near the published ones of random packings.",
    because: "RSA and Monte Carlo ensembles of independent programs; Verlet–Weis; exact relations of S2 (Torquato, Random Heterogeneous Materials, 2.2).",
    file: file!(),
    measure,
};

/// A true model fails one of these tests with this probability; the seeds are fixed, so it happens never or always.
const SIGNIFICANCE: f64 = 1e-3;
const DIAMETER_UM: f64 = 0.25;

fn table() -> Value {
    serde_json::from_str(include_str!("../data/packing.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Realisations in a cube that is periodic in z too.
fn ensemble(
    side_um: f64,
    fraction: f64,
    method: MethodChoice,
    sweeps: u64,
    realisations: u64,
) -> Vec<Packing> {
    let request = |stream| PackingRequest {
        period_um: [side_um, side_um],
        thickness_um: side_um,
        pigments: vec![PigmentGrains::spheres(1e3 * DIAMETER_UM, fraction)],
        method,
        walls: false,
        seed: 20,
        stream,
        equilibration: (sweeps > 0).then_some(EquilibrationSettings { sweeps }),
        ..Default::default()
    };
    (0..realisations).into_par_iter().map(|stream| pack(&request(stream), &mut ()).unwrap()).collect()
}

/// g with its standard error (scatter or counting error, whichever is larger) in the 100 bins from 1 to 3 d.
fn g_of(packings: &[Packing]) -> Vec<Estimate> {
    let pairs: Vec<PairStatistics> = packings.par_iter().map(|p| pair_statistics_to(p, 0.02, 3.0)).collect();
    let bin = |i: usize| {
        let values: Vec<f64> = pairs.iter().map(|p| p.counts[i] / p.ideal[i]).collect();
        let (counts, ideal) = pairs.iter().fold((0.0, 0.0), |(c, e), p| (c + p.counts[i], e + p.ideal[i]));
        Estimate::of_mean(&values).at_least(f64::sqrt(counts) / ideal)
    };
    // Nothing may lie below contact, up to the bin that rounding of the edge can touch.
    assert!(pairs.iter().all(|p| p.counts[..49].iter().all(|c| *c == 0.0)));
    (50..150).map(bin).collect()
}

/// χ² over all bins and the largest deviation, each over the limit that chance exceeds once in a thousand (the latter
/// with Bonferroni's factor for the number of bins); the larger of the two.
fn misfit(measured: &[Estimate], truth: &[f64], truth_error: &[f64]) -> f64 {
    let deviation =
        |((m, t), e): ((&Estimate, &f64), &f64)| (m.value - t) / m.standard_error.unwrap().hypot(*e);
    let z: Vec<f64> = measured.iter().zip(truth).zip(truth_error).map(deviation).collect();
    let n = z.len() as f64;
    let chi2: f64 = z.iter().map(|z| z * z).sum();
    let chi2_limit = ChiSquared::new(n).unwrap().inverse_cdf(1.0 - 0.5 * SIGNIFICANCE);
    let largest = z.iter().map(|z| z.abs()).fold(0.0, f64::max);
    let largest_limit = Normal::standard().inverse_cdf(1.0 - 0.25 * SIGNIFICANCE / n);
    (chi2 / chi2_limit).max(largest / largest_limit)
}

const CHANCE: &str = "χ² over 100 bins and the largest deviation, as shares of their limits at a nominal probability of 1e-3 together";

/// Largest deviation beyond the share of the truth that the formula itself is known to be off, in standard errors over
/// their limit for this number of bins.
fn excess(measured: &[Estimate], truth: &[f64], model_error: f64) -> f64 {
    let beyond = |(m, t): (&Estimate, &f64)| {
        ((m.value - t).abs() - model_error * t).max(0.0) / m.standard_error.unwrap()
    };
    let limit = Normal::standard().inverse_cdf(1.0 - 0.5 * SIGNIFICANCE / truth.len() as f64);
    measured.iter().zip(truth).map(beyond).fold(0.0, f64::max) / limit
}

/// g with bars of three standard errors against its truth with a band of three.
fn plot(title: String, measured: &[Estimate], truth: &[f64], truth_error: &[f64]) -> Chart {
    let x = |i: usize| 1.01 + 0.02 * i as f64;
    let bars = measured.iter().enumerate().map(|(i, g)| [x(i), g.value, 3.0 * g.standard_error.unwrap()]);
    let known = truth.iter().zip(truth_error).enumerate().map(|(i, (&g, e))| [x(i), g, 3.0 * e]);
    Chart::linear(
        &title,
        "distance of centres r/d",
        "pair correlation g(r)",
        vec![
            Curve::with_bars("truth ± 3 errors", Style::Guide, known),
            Curve::with_bars("measured ± 3 errors", Style::Points, bars),
        ],
    )
}

/// Verlet–Weis averaged over the bins by Simpson's rule; the middle of a bin by four-point interpolation.
fn verlet_weis(fraction: f64) -> Vec<f64> {
    let table = table();
    let entries = table["percus_yevick"].as_array().unwrap();
    let entry = entries.iter().find(|e| e["phi"].as_f64() == Some(fraction)).unwrap();
    let r = numbers(&entry["r_over_d"]);
    let g = numbers(&entry["g_VW"]);
    let middle = |i: usize| match i {
        0 => (5.0 * g[0] + 15.0 * g[1] - 5.0 * g[2] + g[3]) / 16.0,
        _ => (-g[i - 1] + 9.0 * g[i] + 9.0 * g[i + 1] - g[i + 2]) / 16.0,
    };
    let bin = |i: usize| {
        let a = r[i];
        let b = r[i + 1];
        let m = 0.5 * (a + b);
        let weighted = a * a * g[i] + 4.0 * m * m * middle(i) + b * b * g[i + 1];
        weighted / (a * a + 4.0 * m * m + b * b)
    };
    // The table is spaced 0.02 up to r = 3 at least (checked), as the bins are.
    assert!(r.windows(2).take(100).all(|w| (w[1] - w[0] - 0.02).abs() < 1e-9));
    (0..100).map(bin).collect()
}

fn measure(level: Level, findings: &mut Findings) {
    sequential(level, findings);
    fluid(level, findings);
    two_point(level, findings);
    orientation(level, findings);
    walls(findings);
    highest::measure(level, findings);
}

fn sequential(level: Level, findings: &mut Findings) {
    let table = table();
    for (key, fraction) in [("0.10", 0.10), ("0.20", 0.20), ("0.30", 0.30)] {
        let reference = &table["rsa"][key];
        let packings = ensemble(8.0, fraction, MethodChoice::SequentialAddition, 0, level.pick(6, 16));
        let g = g_of(&packings);
        let truth = numbers(&reference["g"]);
        let error = numbers(&reference["se"]);
        let misfit = misfit(&g, &truth, &error);
        findings.significance(format!("RSA, φ = {fraction}"), misfit, 1.0, CHANCE);
        findings.plots.push(plot(format!("Sequential addition, φ = {fraction}"), &g, &truth, &error));
        let nearest = |p: &Packing| pair_statistics_to(p, 0.02, 3.0).mean_nearest_um() / DIAMETER_UM;
        let mean = Estimate::of_mean(&packings.iter().map(nearest).collect::<Vec<_>>());
        let expected = reference["mean_nearest_neighbour_over_d"].as_f64().unwrap();
        let bar = mean.standard_error.unwrap().hypot(reference["mean_nn_se"].as_f64().unwrap());
        findings.significance(
            format!("RSA nearest neighbour, φ = {fraction}, in standard errors"),
            (mean.value - expected).abs() / bar,
            3.9,
            "|t| with five degrees of freedom or more: probability 1e-2",
        );
    }
}

/// An independent Monte Carlo (scripts/hard_sphere_monte_carlo.c) is the strict truth, Verlet–Weis the analytic one.
///
/// That Monte Carlo shows how far Verlet–Weis itself is off: at most 0.7, 1.3 and 3.9 % in a bin at φ = 0.15, 0.30 and
/// 0.45 (the last around r = 1.65 d). This share of g enters as the error of the formula.
fn fluid(level: Level, findings: &mut Findings) {
    let file: Value = serde_json::from_str(include_str!("../data/hard_sphere_monte_carlo.json")).unwrap();
    let realisations = level.pick(4, 10);
    // twelve diameters of the densest fluids hold 1500 grains, whose sweeps would take most of the quick level's time
    let dense_um = level.pick(3.0, 4.0);
    for (key, fraction, side_um, method, sweeps, model_error) in [
        ("0.15", 0.15, 4.0, MethodChoice::SequentialAddition, 100, Some(0.007)),
        ("0.30", 0.30, 4.0, MethodChoice::SequentialAddition, 250, Some(0.013)),
        ("0.45", 0.45, dense_um, MethodChoice::Relaxation, 1000, Some(0.039)),
        // Just below freezing, where the formula has no table here.
        ("0.49", 0.49, dense_um, MethodChoice::Relaxation, 3000, None),
    ] {
        let measured = g_of(&ensemble(side_um, fraction, method, sweeps, realisations));
        let truth = &file["by_fraction"][key];
        let known = numbers(&truth["g"]);
        let error = numbers(&truth["se"]);
        let strict = misfit(&measured, &known, &error);
        findings.significance(
            format!("equilibrium against Monte Carlo, φ = {fraction}"),
            strict,
            1.0,
            CHANCE,
        );
        match model_error {
            Some(model_error) => against_verlet_weis(fraction, &measured, model_error, findings),
            None => {
                let title = format!("Equilibrium and Monte Carlo, φ = {fraction}");
                findings.plots.push(plot(title, &measured, &known, &error));
            }
        }
    }
    // The power of the test: without equilibration the same criterion refuses.
    let truth = &file["by_fraction"]["0.30"];
    let sequential = (MethodChoice::SequentialAddition, Method::SequentialAddition);
    for (method, made) in [sequential, (MethodChoice::Relaxation, Method::Relaxation)] {
        let measured = g_of(&ensemble(4.0, 0.30, method, 0, realisations));
        let misfit = misfit(&measured, &numbers(&truth["g"]), &numbers(&truth["se"]));
        let what = format!("{} told from equilibrium, φ = 0.3", made.in_words());
        findings.check(
            what,
            misfit,
            Bound::AtLeast(1.0),
            Reason::Significance,
            "the power of the test above",
        );
    }
}

fn against_verlet_weis(fraction: f64, measured: &[Estimate], model_error: f64, findings: &mut Findings) {
    let formula = verlet_weis(fraction);
    let error: Vec<f64> = formula.iter().map(|g| model_error * g).collect();
    findings.significance(
        format!("equilibrium against Verlet–Weis, φ = {fraction}"),
        excess(measured, &formula, model_error),
        1.0,
        "the formula's known error, and chance beyond it in any of 100 bins with probability 1e-3",
    );
    let title = format!("Equilibrium and Verlet–Weis, φ = {fraction}");
    findings.plots.push(plot(title, measured, &formula, &error));
}

/// S2(0) = φ, −S2′(0) = s/4 = 3φ/(2 d), and S2 → φ² beyond the correlation.
fn two_point(level: Level, findings: &mut Findings) {
    let fraction = 0.3;
    let packings = ensemble(4.0, fraction, MethodChoice::SequentialAddition, 0, level.pick(4, 12));
    let section = |p: &Packing| section_statistics(p, 96, DIAMETER_UM / 12.0, DIAMETER_UM / 10.0, 1.8);
    let sections: Vec<_> = packings.par_iter().map(section).collect();
    let mean = |f: &dyn Fn(&inkwave::ink::statistics::SectionStatistics) -> f64| {
        sections.iter().map(f).sum::<f64>() / sections.len() as f64
    };
    let asked = packings.iter().map(|p| p.achieved_fraction(0)).sum::<f64>() / packings.len() as f64;
    findings.order_of_smallness(
        "S2(0) − φ",
        (mean(&|s| s.s2_x[0]) - asked).abs(),
        5e-4,
        "midpoint sums over 96 planes of some 150 lines",
    );
    let slope = mean(&|s| 0.5 * (s.chords_per_um[0] + s.chords_per_um[1]));
    let exact = 1.5 * asked / DIAMETER_UM;
    findings.order_of_smallness(
        "−S2′(0) d/(1.5 φ) − 1",
        (slope / exact - 1.0).abs(),
        5e-3,
        "chords counted on as many lines",
    );
    let last = sections[0].s2_x.len() - 1;
    let left = |s: &inkwave::ink::statistics::SectionStatistics| {
        0.5 * (s.s2_x[last] + s.s2_y[last]) - s.mean_square_profile
    };
    let left = Estimate::of_mean(&sections.iter().map(left).collect::<Vec<_>>());
    findings.significance(
        "S2(7 d) − ⟨φ(z)²⟩, in standard errors",
        left.value.abs() / left.standard_error.unwrap(),
        13.0,
        "correlations of RSA have died out by 7 diameters; |t| of three degrees of freedom or more, probability 1e-3",
    );
    let r = sections[0].r_um.clone();
    let points =
        r.iter().enumerate().map(|(i, r)| (r / DIAMETER_UM, mean(&|s| 0.5 * (s.s2_x[i] + s.s2_y[i]))));
    let measured = Curve::new("measured", Style::Data, points);
    let tangent = [0.0, 0.4].map(|t| (t, asked - exact * DIAMETER_UM * t));
    let limit = [0.0, r[r.len() - 1] / DIAMETER_UM].map(|t| (t, asked * asked));
    findings.plots.push(Chart::linear(
        "Two-point probability, sequential addition, φ = 0.3",
        "separation r/d",
        "S2(r)",
        vec![
            measured,
            Curve::new("slope −3φ/(2d)", Style::Guide, tangent),
            Curve::new("φ²", Style::Guide, limit),
        ],
    ));
}

/// Cylinders, six radii long: isotropic unless a field aligns them.
fn orientation(level: Level, findings: &mut Findings) {
    let tensors = |orientation: Orientation| -> Vec<[f64; 2]> {
        let cylinder = Shape::Cylinder { length_in_radii: 6.0, spheres: 5 };
        let grains = PigmentGrains { orientation, ..PigmentGrains::of(cylinder, 200.0, 0.15) };
        let request = |stream| PackingRequest {
            period_um: [3.0, 3.0],
            thickness_um: 3.0,
            pigments: vec![grains.clone()],
            walls: false,
            seed: 21,
            stream,
            ..Default::default()
        };
        let tensor = |stream| {
            let packing = pack(&request(stream), &mut ()).unwrap();
            let tensor = orientation_tensor(&packing, None).unwrap();
            [tensor.q[2][2], tensor.grains as f64]
        };
        (0..level.pick(3, 12)).into_par_iter().map(tensor).collect()
    };
    let free = tensors(Orientation::Random);
    let grains: f64 = free.iter().map(|t| t[1]).sum();
    let mean = free.iter().map(|t| t[0] * t[1]).sum::<f64>() / grains;
    findings.significance(
        "|Q_zz| of free cylinders, in standard errors",
        mean.abs() / (0.2 / grains).sqrt(),
        3.3,
        "variance 1/5 per grain: probability 1e-3",
    );
    let most =
        |orientation, want: f64| tensors(orientation).iter().map(|t| (t[0] - want).abs()).fold(0.0, f64::max);
    let why = "a dilute packing keeps the perfect alignment it starts from";
    findings.promise(
        "Q_zz − 1 of standing cylinders",
        most(Orientation::Perpendicular { strength: None }, 1.0),
        0.02,
        why,
    );
    findings.promise(
        "Q_zz + ½ of lying cylinders",
        most(Orientation::InPlane { strength: None }, -0.5),
        0.02,
        why,
    );
}

/// No grain beyond a wall, at any method; the profile touches zero there.
fn walls(findings: &mut Findings) {
    let mut beyond = f64::NEG_INFINITY;
    for (method, fraction) in [(MethodChoice::SequentialAddition, 0.2), (MethodChoice::Relaxation, 0.45)] {
        let request = PackingRequest {
            period_um: [3.0, 3.0],
            thickness_um: 1.0,
            pigments: vec![PigmentGrains::spheres(1e3 * DIAMETER_UM, fraction)],
            method,
            seed: 22,
            ..Default::default()
        };
        let packing = pack(&request, &mut ()).unwrap();
        let spheres = packing.grains().iter().flat_map(|g| &g.spheres);
        let over = spheres.map(|s| (s.radius_um - s.center_um[2]).max(s.center_um[2] + s.radius_um - 1.0));
        beyond = beyond.max(over.fold(f64::NEG_INFINITY, f64::max));
    }
    findings.identity(
        "grains beyond the walls, µm",
        beyond.max(0.0),
        1e-9,
        "walls are hard; rounding of the positions",
    );
}
