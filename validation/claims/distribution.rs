//! The bidirectional distribution: sums, limits, symmetry and error bars.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::ensemble::Layers;
use inkwave::appearance::bdf::{Bdf, Lobe, suggested_bandwidth};
use inkwave::draw::chart::{Chart, Curve, Style};
use inkwave::numerics::Draws;
use inkwave::wave::{FarField, Incidence, Order, Side};
use num_complex::Complex64;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use std::f64::consts::PI;

pub const CLAIM: Claim = Claim {
    id: "12-distribution",
    statement: "The BDF integrates to the albedo, is 1/π times the albedo for a Lambertian layer, isotropic for isotropic packings, and its standard errors tell the scatter of repeated ensembles, falling as 1/√realisations.",
    because: "f λ²/(Lx Ly) sums the efficiencies by definition; realisations are independent (P1 section 4).",
    file: file!(),
    measure,
};

fn measure(level: Level, findings: &mut Findings) {
    let layers =
        Layers { grains: 56, kappa: 0.02, polar_deg: 0.0, seed: 12, realisations: level.pick(48, 192) };
    let fields = layers.solved();
    sums(&fields, findings);
    lambertian(findings);
    calibration(level, findings);
    azimuth(&fields, findings);
    scatter(&fields, findings);
}

fn sums(fields: &[FarField], findings: &mut Findings) {
    let bdf = Bdf::from_ensemble(fields).expect("one ensemble");
    let cell: f64 = bdf.spacing().iter().product();
    let mut error = 0.0f64;
    for (lobe, albedo) in [
        (Lobe::Reflected, fields.iter().map(|f| f.reflectance).sum::<f64>()),
        (Lobe::Transmitted, fields.iter().map(|f| f.transmittance).sum::<f64>()),
    ] {
        let integral: f64 = bdf.orders(lobe).iter().map(|o| o.bdf.value * cell).sum();
        error = error.max((integral - albedo / fields.len() as f64).abs());
    }
    findings.identity("∫ f cos θ dω − albedo", error, 1e-13, "rounding of a sum of some hundred orders");
}

/// A reflecting layer by the efficiency of each of its propagating orders.
fn reflecting(wavelength_um: f64, side: f64, mut efficiency: impl FnMut() -> f64) -> FarField {
    let reach = (side / wavelength_um) as i32;
    let mut orders = Vec::new();
    for m in -reach..=reach {
        for n in -reach..=reach {
            let direction = [m, n].map(|i| f64::from(i) * wavelength_um / side);
            let propagates = direction[0].hypot(direction[1]) < 1.0;
            let efficiency = if propagates { efficiency() } else { 0.0 };
            orders.push(Order {
                m,
                n,
                direction,
                reflected_propagates: propagates,
                transmitted_propagates: false,
                reflected: Complex64::from(efficiency.sqrt()),
                transmitted: Complex64::ZERO,
                reflected_efficiency: efficiency,
                transmitted_efficiency: 0.0,
                further: Default::default(),
            });
        }
    }
    let reflectance: f64 = orders.iter().map(|o| o.reflected_efficiency).sum();
    let incidence = Incidence { wavelength_um, polar_deg: 0.0, azimuth_deg: 0.0, from: Side::Incident };
    let absorptance = 1.0 - reflectance;
    let absorbed = Vec::new();
    FarField {
        incidence,
        period_um: [side; 2],
        orders,
        reflectance,
        transmittance: 0.0,
        absorptance,
        absorbed,
    }
}

/// f = albedo/π everywhere, e = f cos θ dω = (albedo/π) dα dβ, makes a Lambertian layer of albedo 0.8.
fn lambertian(findings: &mut Findings) {
    let wavelength_um = 0.5;
    let side = 20.0;
    let albedo = 0.8;
    let field = reflecting(wavelength_um, side, || albedo / PI * (wavelength_um / side).powi(2));
    let bdf = Bdf::from_ensemble(&[field]).expect("one field");
    let reflectance = bdf.totals(Lobe::Reflected).total.value;
    let bandwidth = suggested_bandwidth(wavelength_um, [side; 2]);
    let error = [[0.0, 0.0], [0.3, 0.1], [-0.5, 0.6], [0.9, 0.0]].map(|direction| {
        let f = bdf.at(Lobe::Reflected, direction, bandwidth).expect("orders are near").bdf.value;
        (f - albedo / PI).abs()
    });
    let error = error.into_iter().fold(0.0, f64::max);
    findings.identity("Lambertian: f − albedo/π", error, 1e-13, "rounding; smoothing keeps a constant");
    // Gauss's circle problem: the number of lattice points in a disc of 40 spacings, ± 2 × 40^(2/3).
    let lattice = 2.0 * 40f64.powf(2.0 / 3.0) / (PI * 1600.0);
    findings.order_of_smallness(
        "Lambertian: |R/albedo − 1|",
        (reflectance / albedo - 1.0).abs(),
        lattice,
        "lattice points in a disc of 40 spacings",
    );
}

/// Synthetic speckle of known mean: squares of (mean − truth)/error follow Student's distribution.
fn calibration(level: Level, findings: &mut Findings) {
    const REALISATIONS: usize = 16;
    let mut draws = Draws::new(12, 1);
    let repeats = level.pick(400, 4000);
    let power = 1e-3;
    let mut sum = 0.0;
    for _ in 0..repeats {
        // Efficiencies of speckle are exponentially distributed.
        let mut speckle = || reflecting(0.5, 1.7, || -power * (1.0 - draws.uniform()).ln());
        let fields: Vec<FarField> = (0..REALISATIONS).map(|_| speckle()).collect();
        let bdf = Bdf::from_ensemble(&fields).expect("one ensemble");
        let orders = bdf.orders(Lobe::Reflected).len() - 1;
        let diffuse = bdf.totals(Lobe::Reflected).diffuse;
        let error = diffuse.standard_error.expect("several");
        sum += ((diffuse.value - orders as f64 * power) / error).powi(2);
    }
    // t² with ν degrees of freedom: mean ν/(ν − 2), variance 2ν²(ν − 1)/((ν − 2)²(ν − 4)).
    let nu = (REALISATIONS - 1) as f64;
    let mean = nu / (nu - 2.0);
    let variance = 2.0 * nu * nu * (nu - 1.0) / ((nu - 2.0).powi(2) * (nu - 4.0));
    let off = (sum / repeats as f64 - mean).abs() / (variance / repeats as f64).sqrt();
    findings.significance(
        "calibration of the standard error on synthetic speckle, in standard errors",
        off,
        4.0,
        "mean of t² over many ensembles, nearly normal: probability 1e-4",
    );
}

/// Transmittance into four quadrants that the symmetry of isotropic packings makes equal in the mean.
fn azimuth(fields: &[FarField], findings: &mut Findings) {
    let quadrant = |f: &FarField, k: usize| -> f64 {
        let inside = |o: &&Order| {
            let [a, b] = o.direction;
            match k {
                0 => a > b.abs(),
                1 => b > a.abs(),
                2 => -a > b.abs(),
                _ => -b > a.abs(),
            }
        };
        f.orders.iter().filter(inside).map(|o| o.transmitted_efficiency).sum()
    };
    // Contrasts between quadrants: opposite pairs, and the two axes.
    let contrasts: [fn([f64; 4]) -> f64; 3] =
        [|q| q[0] - q[2], |q| q[1] - q[3], |q| q[0] + q[2] - q[1] - q[3]];
    let mut largest = 0.0f64;
    for contrast in contrasts {
        let values: Vec<f64> =
            fields.iter().map(|f| contrast(std::array::from_fn(|k| quadrant(f, k)))).collect();
        largest = largest.max((mean(&values) / (variance(&values) / values.len() as f64).sqrt()).abs());
    }
    findings.significance(
        "anisotropy of transmission in standard errors",
        largest,
        3.9,
        "three contrasts, |t| of 47 degrees of freedom: probability 1e-3",
    );
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn variance(values: &[f64]) -> f64 {
    let m = mean(values);
    values.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (values.len() - 1) as f64
}

/// Splits the ensemble into groups: the scatter of their means against their own standard errors.
fn scatter(fields: &[FarField], findings: &mut Findings) {
    let mut points = Vec::new();
    for size in [2, 4, 8] {
        let groups: Vec<Bdf> =
            fields.chunks_exact(size).map(|g| Bdf::from_ensemble(g).expect("one ensemble")).collect();
        let diffuse = |b: &Bdf| b.totals(Lobe::Reflected).diffuse;
        let means: Vec<f64> = groups.iter().map(|b| diffuse(b).value).collect();
        let squares: Vec<f64> =
            groups.iter().map(|b| diffuse(b).standard_error.expect("several").powi(2)).collect();
        points.push([size as f64, mean(&squares).sqrt(), 0.0]);
        if size > 4 {
            continue;
        }
        // For normal means the ratio follows the F distribution; sums of many orders are nearly normal.
        let degrees = [groups.len() - 1, fields.len() - groups.len()].map(|d| d as f64);
        let f = FisherSnedecor::new(degrees[0], degrees[1]).expect("positive");
        findings.check(
            format!("variance of means of {size} over their squared errors"),
            variance(&means) / mean(&squares),
            Bound::Within([1e-4, 1.0 - 1e-4].map(|p| f.inverse_cdf(p))),
            Reason::Significance,
            "F distribution, probability 1e-4 on either side",
        );
    }
    let ratio = points[0][1] / points[2][1];
    let relative = 4.0 * (2.0 / (fields.len() as f64 / 2.0)).sqrt() / 2.0;
    findings.significance(
        "error of 2 over error of 8, off from 2 by a share of",
        (ratio / 2.0 - 1.0).abs(),
        relative.min(0.25),
        "four standard errors of a variance from half as many groups as fields, never half of what no fall would give",
    );
    let measured = Curve::with_bars("diffuse reflectance", Style::Data, points);
    let guide = Curve::guide("1/√n", &measured, -0.5);
    findings.plots.push(Chart::log_log(
        "Standard error against realisations",
        "realisations n",
        "standard error of the diffuse reflectance",
        vec![measured, guide],
    ));
}
