//! Ink on Lambertian paper against closed forms.

use crate::claim::{Claim, Findings, Level};
use inkwave::appearance::angles::AngleRule;
use inkwave::appearance::paper::{Coupling, LayerOnPaper, LayerOptics, MirroredSky};
use inkwave::appearance::slab::Slab;
use num_complex::Complex64;
use serde_json::Value;
use std::f64::consts::PI;

pub const CLAIM: Claim = Claim {
    id: "13-paper",
    statement: "Homogeneous layers on paper have the reflectances, distributions and albedos of the closed forms, with a gap and in optical contact.",
    because: "Light going back and forth is a geometric series (P1 (1)–(8)); Williams and Clapper 1953 for contact; 12 digits by quadrature.",
    file: file!(),
    measure,
};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

/// Largest error of one case with a gap: means, distributions from 0° and backwards, albedo, natural light.
fn gap_error(case: &Value, points: usize) -> f64 {
    let number = |key: &str| case[key].as_f64().expect("a number");
    let slab = Slab {
        index: Complex64::new(number("n"), number("kappa")),
        thickness_um: number("H_um"),
        wavelength_um: number("lambda_um"),
    };
    let rule = AngleRule::new(points, 60.0, Coupling::Gap).expect("a rule");
    let paper =
        LayerOnPaper::new(&rule, &LayerOptics::homogeneous(&rule, slab), number("rho")).expect("a layer");
    let angles: Vec<_> =
        numbers(&case["angles_deg"]).iter().map(|&a| rule.at(a).expect("up to 60°")).collect();
    let mut error = (paper.mean_reflectance_below() - number("R_diffuse")).abs();
    error = error.max((paper.mean_transmittance() - number("T_diffuse")).abs());
    for (i, at) in angles.iter().enumerate() {
        let pairs = [
            (paper.brdf(&angles[0], at), "brdf_diffuse_from0"),
            (paper.brdf(at, at), "brdf_diffuse_retro"),
            (paper.albedo(at), "albedo_dirhemi_total"),
            (paper.specular(at), "R_specular"),
            (paper.natural_light(at, MirroredSky::Included), "diffuse_illum_factor_incl_specular"),
            (paper.natural_light(at, MirroredSky::Excluded), "diffuse_illum_factor_excl_specular"),
        ];
        for (got, key) in pairs {
            error = error.max((got - numbers(&case[key])[i]).abs());
        }
    }
    error
}

/// π × BRDF of a clear film in contact with the paper against Williams and Clapper.
fn contact_error(case: &Value) -> f64 {
    let number = |key: &str| case[key].as_f64().expect("a number");
    let index = number("n");
    let rule = AngleRule::new(4, 60.0, Coupling::OpticalContact { index }).expect("a rule");
    let slab = Slab { index: index.into(), thickness_um: 1.0, wavelength_um: 0.55 };
    let paper =
        LayerOnPaper::new(&rule, &LayerOptics::homogeneous(&rule, slab), number("rho")).expect("a layer");
    let normal = rule.at(0.0).expect("0°");
    let angles = numbers(&case["angles_deg"]);
    let want = numbers(&case["radiance_factor_from0"]);
    let error = |(deg, want): (&f64, &f64)| {
        (PI * paper.brdf(&normal, &rule.at(*deg).expect("up to 60°")) - want).abs()
    };
    angles.iter().zip(&want).map(error).fold(0.0, f64::max)
}

fn measure(level: Level, findings: &mut Findings) {
    let file: Value = serde_json::from_str(include_str!("../data/paper.json")).expect("JSON");
    let list = |key: &str| file[key].as_array().expect("cases").clone();
    for points in level.pick([3, 7], [2, 12]) {
        // A layer of index 1 reflects nothing at grazing and is no ink.
        let inks = list("coherent").into_iter().filter(|c| c["n"] != 1.0);
        let error = inks.map(|c| gap_error(&c, points)).fold(0.0, f64::max);
        findings.identity(
            format!("gap, {points} angles"),
            error,
            2e-12,
            "12 printed digits; homogeneous layers are their own baseline",
        );
    }
    let clear = list("williams_clapper").into_iter().filter(|c| c["tau"] == 0.0 && c["surface"] == "s");
    let error = clear.map(|c| contact_error(&c)).fold(0.0, f64::max);
    findings.identity(
        "optical contact, clear film",
        error,
        2e-12,
        "12 printed digits; one interface has no fringes",
    );
}
