//! Ink on Lambertian paper against closed forms.

use crate::claim::{Bound, Claim, Findings, Level, Reason, Table, short};
use crate::formulas::films::{Film, amplitudes};
use inkwave::appearance::film::Profile;
use inkwave::appearance::paper::{Albedo, Coupling, MirroredSky, Substrate};
use inkwave::evaluate::films::Films;
use inkwave::evaluate::ink::{InkInputs, InkOnPaper, SolvedLayer};
use inkwave::evaluate::layer::LayerEnsemble;
use inkwave::evaluate::samples::{SolvedDirection, SolvedRealisation, SolvedWavelength};
use inkwave::evaluate::wavelengths::SpectralBasis;
use inkwave::input::variation::{ThicknessShare, stratified_deg};
use inkwave::wave::Wave;
use num_complex::Complex64;
use serde_json::Value;
use std::f64::consts::PI;

pub const CLAIM: Claim = Claim {
    id: "13-paper",
    statement: "Homogeneous layers on paper have the reflectances, distributions and albedos of the closed forms, with a gap and in optical contact; few shifted directions find them about the film of another index.",
    because: "Light going back and forth is a geometric series (P1 (1)–(8)); Williams and Clapper 1953 for contact; 12 digits by quadrature. Strata shifted evenly give unbiased means; the fit has to carry what the wrong film leaves.",
    file: file!(),
    measure,
};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

const OUTPUT_NM: f64 = 550.0;

/// A homogeneous layer of one case on its paper. The cases scale with H/λ, so the wavelength is always 550 nm.
fn ink(case: &Value, index: Complex64, coupling: Coupling, solved: Option<usize>) -> InkOnPaper {
    let number = |key: &str| case[key].as_f64().expect("a number");
    let thickness_um = case.get("H_um").map_or(1.0, |h| h.as_f64().expect("a number"));
    let wavelength_um = case.get("lambda_um").map_or(0.55, |l| l.as_f64().expect("a number"));
    let thickness_um = thickness_um * 1e-3 * OUTPUT_NM / wavelength_um;
    let indices = |_: f64| (vec![index], Vec::new());
    let index_out = coupling.index_out();
    let films = Films {
        profile: Profile::homogeneous(),
        indices: &indices,
        thicknesses: ThicknessShare::even(thickness_um),
        index_out,
        wave: Wave::Scalar,
    };
    let substrate = Substrate { albedo: Albedo::Constant(number("rho")), coupling };
    let inputs = InkInputs { films: &films, substrate: &substrate, outputs_nm: &[OUTPUT_NM] };
    let Some(strata) = solved else { return InkOnPaper::homogeneous(&inputs).expect("a layer") };
    let film = Film { index: Complex64::new(number("n"), number("kappa")), thickness_um };
    let ensemble: Vec<SolvedRealisation> = (0..REALISATIONS).map(|r| by_formula(&film, strata, r)).collect();
    let layer = LayerEnsemble::new(&ensemble, SpectralBasis::Listed(vec![OUTPUT_NM]), &films, &[0.0, 45.0]);
    InkOnPaper::new(SolvedLayer { ensemble: layer, solved: &ensemble }, None, &inputs).expect("a layer")
}

/// Realisations of the interpolation's test.
const REALISATIONS: usize = 16;
/// Error of the film's index that the fit has to make good: that of a film of the mean η² under strong scattering.
const WRONG_INDEX: Complex64 = Complex64::new(0.02, 0.004);

/// What solves of a homogeneous layer say, by Fresnel's formulas.
fn by_formula(film: &Film, strata: usize, r: usize) -> SolvedRealisation {
    let at = |&deg: &f64| {
        let [r, t] = amplitudes(1.0, &[*film], 1.0.into(), 1e-3 * OUTPUT_NM, deg).map(|a| a.norm_sqr());
        SolvedDirection {
            polar_deg: deg,
            reflectance: r,
            specular_reflectance: r,
            transmittance: t,
            specular_transmittance: t,
            unscattered: Default::default(),
            absorptance: 1.0 - r - t,
            absorbed: Vec::new(),
            order_area: 0.0,
            scattered: Vec::new(),
        }
    };
    let shift = (r as f64 + 0.5) / REALISATIONS as f64;
    let wavelength = SolvedWavelength {
        wavelength_nm: OUTPUT_NM,
        exact: [0.0, 45.0].iter().map(at).collect(),
        strata: stratified_deg(strata, shift).iter().map(at).collect(),
        exit: Vec::new(),
    };
    SolvedRealisation { thickness_um: film.thickness_um, wavelengths: vec![wavelength] }
}

fn index_of(case: &Value) -> Complex64 {
    Complex64::new(case["n"].as_f64().expect("a number"), case["kappa"].as_f64().expect("a number"))
}

/// Largest errors of one case with a gap: of the means and natural light at the normal, and of everything up to 60°.
fn gap_errors(case: &Value, ink: &InkOnPaper) -> [f64; 2] {
    let number = |key: &str| case[key].as_f64().expect("a number");
    let paper = &ink.layers()[0];
    let angles: Vec<_> =
        numbers(&case["angles_deg"]).iter().map(|&a| ink.at(a).expect("below 90°")).collect();
    let mut means = (paper.mean_reflectance_exit() - number("R_diffuse")).abs();
    means = means.max((paper.mean_transmittance() - number("T_diffuse")).abs());
    let mut curves: f64 = 0.0;
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
            curves = curves.max((got - numbers(&case[key])[i]).abs());
        }
    }
    [means, curves]
}

/// π × BRDF of a clear film in contact with the paper against Williams and Clapper.
fn contact_error(case: &Value) -> f64 {
    let index = case["n"].as_f64().expect("a number");
    let ink = ink(case, index.into(), Coupling::OpticalContact { index }, None);
    let paper = &ink.layers()[0];
    let normal = ink.at(0.0).expect("0°");
    let angles = numbers(&case["angles_deg"]);
    let want = numbers(&case["radiance_factor_from0"]);
    let error = |(deg, want): (&f64, &f64)| {
        (PI * paper.brdf(&normal, &ink.at(*deg).expect("up to 60°")) - want).abs()
    };
    angles.iter().zip(&want).map(error).fold(0.0, f64::max)
}

/// Largest error of R(θ) and T(θ) from 0° to 60° between the directions solved: of the fit about a film of the wrong index, and of
/// that film alone.
fn curve_errors(index: Complex64, thickness_um: f64) -> [f64; 2] {
    let truth = Film { index, thickness_um };
    let wrong = Film { index: index + WRONG_INDEX, thickness_um };
    let indices = |_: f64| (vec![wrong.index], Vec::new());
    let films = Films {
        profile: Profile::homogeneous(),
        indices: &indices,
        thicknesses: ThicknessShare::even(thickness_um),
        index_out: 1.0,
        wave: Wave::Scalar,
    };
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
    let inputs = InkInputs { films: &films, substrate: &substrate, outputs_nm: &[OUTPUT_NM] };
    let ensemble: Vec<SolvedRealisation> = (0..REALISATIONS).map(|r| by_formula(&truth, 2, r)).collect();
    let layer = LayerEnsemble::new(&ensemble, SpectralBasis::Listed(vec![OUTPUT_NM]), &films, &[0.0, 45.0]);
    let ink =
        InkOnPaper::new(SolvedLayer { ensemble: layer, solved: &ensemble }, None, &inputs).expect("a layer");
    let of = |film: &Film, deg: f64| {
        amplitudes(1.0, &[*film], 1.0.into(), 1e-3 * OUTPUT_NM, deg).map(|a| a.norm_sqr())
    };
    let mut errors = [0.0_f64; 2];
    for deg in (0..=60).step_by(5).map(f64::from) {
        let at = ink.at(deg).expect("up to 60°");
        let truth = of(&truth, deg);
        let alone = of(&wrong, deg);
        let fitted = [ink.layers()[0].reflectance(&at), ink.layers()[0].transmittance(&at)];
        for i in 0..2 {
            errors[0] = errors[0].max((fitted[i] - truth[i]).abs());
            errors[1] = errors[1].max((alone[i] - truth[i]).abs());
        }
    }
    errors
}

/// Curves between the angles solved. What a wrong film leaves is smooth where it turns by less than a fringe from 0° to 60°, which
/// half a micrometre keeps; a clear layer twice as thick does not, and is listed separately.
fn curves(findings: &mut Findings) {
    let inks = [(1.558, 0.0), (1.558, 0.05), (1.4, 0.1), (1.4, 0.3)].map(|(n, k)| Complex64::new(n, k));
    let mut rows = Vec::new();
    let mut largest = 0.0_f64;
    for thickness_um in [0.2, 0.3, 0.5, 1.0] {
        for index in inks {
            let [fitted, alone] = curve_errors(index, thickness_um);
            if thickness_um <= 0.5 {
                largest = largest.max(fitted / alone);
            }
            let numbers = [thickness_um.to_string(), index.to_string()];
            rows.push(numbers.into_iter().chain([short(fitted), short(alone)]).collect());
        }
    }
    let because = "an independent calculation with the same functions leaves at most 0.21; without the values at 0° and 45°, or with \
                   wrong shares of them, nothing of the film's error goes away";
    let what = "gap, wrong film: share of its error in R(θ), T(θ) up to 60° that 4 directions leave, layers to 0.5 µm";
    findings.check(what, largest, Bound::AtMost(0.25), Reason::Promise, because);
    let columns = ["thickness, µm", "index", "error with the fit", "error of the wrong film alone"];
    findings.tables.push(Table {
        title: "Curves over the angle about a film of the wrong index".into(),
        columns: columns.map(String::from).to_vec(),
        rows,
    });
}

fn measure(level: Level, findings: &mut Findings) {
    let file: Value = serde_json::from_str(include_str!("../data/paper.json")).expect("JSON");
    let list = |key: &str| file[key].as_array().expect("cases").clone();
    // A layer of index 1 reflects nothing at grazing and is no ink.
    let inks: Vec<Value> = list("coherent").into_iter().filter(|c| c["n"] != 1.0).collect();
    let worst = |errors: &dyn Fn(&Value) -> [f64; 2]| {
        inks.iter().map(errors).fold([0.0_f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])])
    };
    let exact = worst(&|c| gap_errors(c, &ink(c, index_of(c), Coupling::Gap, None)));
    let because = "12 printed digits; a homogeneous layer is its own film";
    findings.identity("gap, closed forms", exact[0].max(exact[1]), 2e-12, because);
    // The film is wrong on purpose: what is left is the directions' and the fit's.
    let wrong = |strata: usize| {
        worst(&|c| gap_errors(c, &ink(c, index_of(c) + WRONG_INDEX, Coupling::Gap, Some(strata))))
    };
    let few = wrong(2);
    let many = wrong(level.pick(6, 12));
    let because =
        "16 shifts of each stratum are a fine sum over the hemisphere: a midpoint rule of 32 points";
    findings.promise("gap, wrong film, 4 directions: means", few[0], 2e-3, because);
    let because = "six times the directions sharpen the sum over the hemisphere, so the means come nearer";
    findings.check(
        "gap, wrong film: error of the means, 4 directions over many",
        few[0] / many[0],
        Bound::AtLeast(2.0),
        Reason::Order,
        because,
    );
    curves(findings);
    let clear = list("williams_clapper").into_iter().filter(|c| c["tau"] == 0.0 && c["surface"] == "s");
    let error = clear.map(|c| contact_error(&c)).fold(0.0, f64::max);
    findings.identity(
        "optical contact, clear film",
        error,
        2e-12,
        "12 printed digits; one interface has no fringes",
    );
}
