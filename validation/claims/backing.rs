//! What a print lies on: measured paper, brightened paper, dots.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::formulas::halftone::{Area, Screen, Uniform};
use crate::formulas::returns::{Returns, behind_face};
use inkwave::appearance::bare_paper::{BareSurface, PaperGeometry};
use inkwave::appearance::fluorescence::{Fluorescence, standard_excitation, summed_nm};
use inkwave::appearance::halftone::spread_share;
use inkwave::appearance::paper::{Albedo, Coupling, returned};
use inkwave::appearance::paper_series::{AreaMix, AreaOptics};
use inkwave::appearance::tristimulus::{Colorimeter, visible};
use inkwave::appearance::viewing::{Summation, Viewing};
use inkwave::evaluate::prints::{Brightened, LitAreas, PrintTask};
use inkwave::input::check::check;
use inkwave::input::study::{Paper, Study};
use std::cmp::Ordering;

pub const MEASURED: Claim = Claim {
    id: "40-measured-paper",
    statement: "The albedo behind a measured factor is the one whose bare paper reads that factor, through a surface of Fresnel's formulas, return by return; a study returns its measured paper.",
    because: "Bare paper in its medium of index n is the series of a layer that is its surface alone (Saunderson 1942).",
    file: file!(),
    measure: measured,
};

pub const BRIGHTENED: Claim = Claim {
    id: "41-brightened-paper",
    statement: "Paper that fluoresces sends up what light going back and forth return by return excites; without a brightener nothing changes in any digit; no quanta are made; a pair of measurements with and without ultraviolet light is returned; under lamps with lines and smooth lights its colour is that of a sum over every nanometre.",
    because: "The returns are a geometric series in Donaldson's matrix, which is triangular: one pass over rising wavelengths sums it. Without returns it is Hersch's relation (2008). What is emitted has no lines where a lamp has: the observer alone weighs it.",
    file: file!(),
    measure: brightened,
};

pub const DOTS: Claim = Claim {
    id: "42-dots",
    statement: "Dots on paper that spreads no light are Neugebauer's average, on paper that spreads it far Clapper and Yule's formula, in between light followed return by return; full coverage is the solid.",
    because: "The series over kinds of area has both limits in closed form.",
    file: file!(),
    measure: dots,
};

pub const LATTICE: Claim = Claim {
    id: "43-dot-lattice",
    statement: "Reflectances of a lattice of dots over paper that spreads light as exp(-r/l) are those of rays followed one by one, for five rulings.",
    because: "The share of light that leaves under the other kind of area follows from the screen's Fourier coefficients and the transform of the spread.",
    file: file!(),
    measure: lattice,
};

const INK: Area = Area { entering: 0.35, leaving: 0.35 / 2.25, back: 0.55 };
const BARE: Area = Area { entering: 0.95, leaving: 0.96 / 2.25, back: 0.596 };

fn optics(area: Area) -> AreaOptics {
    AreaOptics { own: 0.0, entering: area.entering, leaving: area.leaving, lost: 1.0 - area.back }
}

/// A study of a clear film in contact with its paper, with files beside it.
fn study(paper: &str, files: &[(&str, String)], light: &str) -> Study {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let text = format!(
        "[layer]\nthickness_um = 1\nbinder.index = 1.5\nindex_out = 1.5\n[paper]\ncoupling = 'optical_contact'\n{paper}\n\
         [light]\n{light}\n[dots]\nruling_per_cm = 60\nspread_um = 40\n[[area]]\ncoverage = 0.5\n"
    );
    let file = toml::from_str(&text).expect("a study file");
    check(&file, folder.path(), "claim").unwrap_or_else(|faults| panic!("{faults:?}"))
}

fn table(rows: impl Iterator<Item = (f64, f64)>) -> String {
    let lines: String = rows.map(|(nm, value)| format!("{nm},{value}\n")).collect();
    format!("wavelength_nm,reflectance\n{lines}")
}

fn measured(_: Level, findings: &mut Findings) {
    let mut error: f64 = 0.0;
    for (albedo, index) in [(0.3, 1.5), (0.9, 1.5), (0.955, 1.55), (1.0, 1.33)] {
        let surface = BareSurface::new(Coupling::OpticalContact { index });
        error =
            error.max((surface.albedo(behind_face(albedo, index), PaperGeometry::LitAt45) - albedo).abs());
    }
    let because = "a dense sum over the hemisphere, whose integrand has a root at grazing incidence";
    findings.promise("albedo behind a factor of known paper", error, 1e-6, because);
    let factor = |nm: f64| 0.8 + 1e-4 * (nm - 400.0);
    let rows = table((0..=30).map(|k| 400.0 + 10.0 * f64::from(k)).map(|nm| (nm, factor(nm))));
    let light = "from_nm = 400\nto_nm = 700\nstep_nm = 10";
    let study = study(
        "measured = { csv = 'paper.csv', geometry = '45:0', unit = 'factor' }",
        &[("paper.csv", rows)],
        light,
    );
    let task = PrintTask::new(&study).expect("prints");
    let layer = vec![optics(INK); study.wavelengths_nm.len()];
    let bare = &task.numbers(&layer)[0];
    let error = study
        .wavelengths_nm
        .iter()
        .zip(&bare.factors)
        .map(|(nm, x)| (x - factor(*nm)).abs())
        .fold(0.0, f64::max);
    findings.identity(
        "bare paper of a study against its file",
        error,
        1e-12,
        "the inverse of the same series",
    );
}

/// A brightener whose emission reaches into its excitation.
fn brightener(quantum_yield: f64) -> Fluorescence {
    let emission = vec![[400.0, 0.0], [440.0, 1.0], [470.0, 0.5], [540.0, 0.0]];
    Fluorescence::Bands { excitation: standard_excitation(), emission, quantum_yield }
}

fn brightened(_: Level, findings: &mut Findings) {
    let nm = summed_nm(300.0, 700.0);
    let light: Vec<f64> = nm.iter().map(|nm| 20.0 + 0.2 * (nm - 300.0)).collect();
    let albedos: Vec<f64> = nm.iter().map(|&nm| 0.93 * (1.0 - brightener(0.0).absorbed(nm))).collect();
    let shift = |area: Area, nm: f64| Area { entering: area.entering * nm / 700.0, ..area };
    let areas: Vec<Vec<Area>> = nm.iter().map(|&nm| vec![shift(INK, nm), shift(BARE, nm)]).collect();
    let seen: Vec<Vec<AreaOptics>> =
        areas.iter().map(|kinds| kinds.iter().copied().map(optics).collect()).collect();
    let factors = |fluorescence: &Fluorescence, mix: &AreaMix, seen: &[Vec<AreaOptics>]| -> Vec<f64> {
        let emitted = mix.emitted(seen, &albedos, &light, &fluorescence.matrix(&nm));
        let relative = |w: usize| emitted[w].iter().map(|s| s / light[w]).collect::<Vec<f64>>();
        (0..nm.len()).map(|w| mix.factor(&seen[w], albedos[w], &relative(w))).collect()
    };
    let whole = |fluorescence: &Fluorescence| -> Vec<Vec<f64>> {
        let mut matrix = fluorescence.matrix(&nm);
        for (w, row) in matrix.iter_mut().enumerate() {
            row.push(albedos[w]);
            row.resize(nm.len(), 0.0);
        }
        matrix
    };
    let mut error: f64 = 0.0;
    for spread in [0.0, 0.6, 1.0] {
        let mix = AreaMix { shares: vec![0.4, 0.6], spread };
        let paper = whole(&brightener(0.8));
        let truth =
            Returns { areas: &areas, shares: &mix.shares, spread, paper: &paper, light: &light }.factors(200);
        let got = factors(&brightener(0.8), &mix, &seen);
        error = got.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(error, f64::max);
    }
    findings.identity(
        "ink dots on brightened paper against the sum of its returns",
        error,
        1e-11,
        "200 returns of at most 0.56 each",
    );
    let mix = AreaMix::whole();
    let one: Vec<Vec<AreaOptics>> = seen.iter().map(|kinds| vec![kinds[0]]).collect();
    let dark = factors(&brightener(0.0), &mix, &one);
    let plain = |w: usize| mix.factor(&one[w], albedos[w], &[]);
    let differing = (0..nm.len()).filter(|&w| dark[w].to_bits() != plain(w).to_bits()).count();
    let because = "a count: adding nothing changes no digit";
    findings.identity("digits that a brightener without yield changes", differing as f64, 0.5, because);
    // without returns: Hersch's relation
    let open: Vec<Vec<AreaOptics>> = one.iter().map(|k| vec![AreaOptics { lost: 1.0, ..k[0] }]).collect();
    let matrix = brightener(0.8).matrix(&nm);
    let mut error: f64 = 0.0;
    for (w, got) in factors(&brightener(0.8), &mix, &open).into_iter().enumerate() {
        let excited: f64 = (0..w).map(|j| matrix[w][j] * open[j][0].entering * light[j]).sum();
        let area = &open[w][0];
        error = error.max((got - area.leaving * (albedos[w] * area.entering + excited / light[w])).abs());
    }
    findings.identity("Hersch's relation without returns", error, 1e-14, "rounding of a sum of 80 terms");
    let most = brightener(1.0).most_quanta(|nm| 1.0 - brightener(1.0).absorbed(nm), &summed_nm(300.0, 780.0));
    let because = "each absorbed quantum gives one at most; rounding";
    let what = "quanta sent up per quantum, yield 1 on a white paper";
    findings.check(what, most, Bound::AtMost(1.0 + 1e-12), Reason::Identity, because);
    pair(findings);
    lamps(findings);
}

/// Lamps with lines and smooth lights, with the first wavelength at which they have light, nm.
const LIGHTS: [(&str, u32); 8] = [
    ("F2", 380),
    ("F11", 380),
    ("F12", 380),
    ("F3_8", 380),
    ("LED_V1", 380),
    ("A", 300),
    ("D50", 300),
    ("D65", 300),
];

/// Colours under lamps with lines and smooth lights, of bare paper and through an ink that takes violet light.
fn lamps(findings: &mut Findings) {
    let ink = |nm: f64| {
        let taken = 0.5 * (-0.5 * ((nm - 425.0) / 30.0).powi(2)).exp();
        Area { entering: 0.9 * (1.0 - taken), leaving: 0.4 * (1.0 - taken), back: 0.5 * (1.0 - taken) }
    };
    let bare = |_: f64| BARE;
    let kinds: [&dyn Fn(f64) -> Area; 2] = [&bare, &ink];
    let mut errors = [0.0_f64; 2];
    let mut least = f64::INFINITY;
    for (name, from_nm) in LIGHTS {
        let lamp = Viewing::new(name, "2", Summation::Plain).expect("a light");
        for area in kinds {
            let [dark, truth] = [0.0, 0.8].map(|quanta| every_nanometre((&lamp, from_nm), area, quanta));
            least = least.min(distance(dark, truth));
            for (error, step) in errors.iter_mut().zip([5, 10]) {
                *error = error.max(distance(truth, in_steps((&lamp, from_nm), area, step)));
            }
        }
    }
    let because = "a tenth of what the brightener does through the ink under F11, the least of all";
    findings.promise(
        "ΔE*ab under F2, F11, F12, F3_8, LED_V1, A, D50 and D65 in steps of 5 nm",
        errors[0],
        0.05,
        because,
    );
    let because = "bands of 30 nm bend within 10 nm, those of the paper and of the ink alike";
    findings.promise("the same in steps of 10 nm", errors[1], 0.2, because);
    let what = "least ΔE*ab that the brightener makes there";
    findings.check(what, least, Bound::AtLeast(0.5), Reason::Promise, "else there were nothing to compare");
}

/// L*, a*, b* of a kind of area over the brightened paper, by sums over every nanometre, return by return.
fn every_nanometre(
    (lamp, from_nm): (&Viewing, u32),
    area: &dyn Fn(f64) -> Area,
    quantum_yield: f64,
) -> [f64; 3] {
    let nm: Vec<f64> = (from_nm..=730).map(f64::from).collect();
    let light: Vec<f64> = nm.iter().map(|&nm| lamp.power(nm)).collect();
    let dark = brightener(0.0);
    let taken = |nm: f64| dark.absorbed(nm);
    // the emission of [`brightener`] and its area, that of three trapezia
    let emission = |nm: f64| match nm {
        400.0..440.0 => (nm - 400.0) / 40.0,
        440.0..470.0 => 1.0 - 0.5 * (nm - 440.0) / 30.0,
        470.0..540.0 => 0.5 * (540.0 - nm) / 70.0,
        _ => 0.0,
    };
    let sent = |to: f64, from: f64| quantum_yield / 60.0 * emission(to) * taken(from) * from / to;
    let row = |(w, &to): (usize, &f64)| {
        let from = |(v, &from): (usize, &f64)| match v.cmp(&w) {
            Ordering::Less => sent(to, from),
            Ordering::Equal => 0.9 * (1.0 - taken(to)),
            Ordering::Greater => 0.0,
        };
        nm.iter().enumerate().map(from).collect()
    };
    let paper: Vec<Vec<f64>> = nm.iter().enumerate().map(row).collect();
    let areas: Vec<Vec<Area>> = nm.iter().map(|&nm| vec![area(nm)]).collect();
    let returns = Returns { areas: &areas, shares: &[1.0], spread: 1.0, paper: &paper, light: &light };
    // the light is 0.54 of its own a return later: rounding after forty
    let factors = returns.factors(40);
    let seen = visible(&nm);
    Colorimeter::under(&nm[seen.clone()], lamp).expect("an eye").colour(&factors[seen]).expect("a colour").lab
}

/// L*, a*, b* of a kind of area over the brightened paper as the program sums them over equal steps.
fn in_steps((lamp, from_nm): (&Viewing, u32), area: &dyn Fn(f64) -> Area, step: usize) -> [f64; 3] {
    let nm: Vec<f64> = (from_nm..=730).step_by(step).map(f64::from).collect();
    let fluorescence = brightener(0.8);
    let albedo = fluorescence.left_of(&Albedo::Constant(0.9), &nm);
    let albedos: Vec<f64> = nm.iter().map(|&nm| albedo.at(nm).expect("in range")).collect();
    let coupling = Coupling::OpticalContact { index: 1.5 };
    let source = String::new();
    let fluorescence = Some(fluorescence);
    let paper = Paper { source, albedo, coupling, measured: None, fluorescence, dots: None };
    let mix = AreaMix::whole();
    let kind: Vec<AreaOptics> = nm.iter().map(|&nm| optics(area(nm))).collect();
    let kinds: [&[AreaOptics]; 1] = [&kind];
    let light = Brightened::new(&paper, &nm, lamp, 0.0).expect("a brightener");
    let emitted = light.below(&mix, &kinds, &nm);
    let lit = LitAreas {
        mix: &mix,
        kinds: &kinds,
        albedos: &albedos,
        emitted: Some(&emitted),
        wavelengths_nm: &nm,
    };
    let eye = Colorimeter::under(&nm[visible(&nm)], lamp).expect("an eye");
    let xyz = lit.xyz(&eye, light.emission(&eye, &nm).as_ref()).expect("factors");
    eye.colour_of(xyz).lab
}

fn distance(one: [f64; 3], other: [f64; 3]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// A paper measured with and without ultraviolet light.
fn pair(findings: &mut Findings) {
    let m2 = |nm: f64| 0.90 + 0.02 * ((nm - 400.0) / 300.0);
    let fluorescence = |nm: f64| 0.13 * (-0.5 * ((nm - 440.0) / 25.0_f64).powi(2)).exp();
    let nm = || (0..=32).map(|k| 400.0 + 10.0 * f64::from(k));
    let files = [
        ("m1.csv", table(nm().map(|nm| (nm, m2(nm) + fluorescence(nm))))),
        ("m2.csv", table(nm().map(|nm| (nm, m2(nm))))),
    ];
    let paper = "fluorescence = { m1_csv = 'm1.csv', m2_csv = 'm2.csv', unit = 'factor' }";
    let study = study(paper, &files, "from_nm = 300\nto_nm = 720\nstep_nm = 10");
    let task = PrintTask::new(&study).expect("prints");
    let layer = vec![optics(INK); study.wavelengths_nm.len()];
    let all = task.numbers(&layer);
    let each = all.len() / 3;
    let error = |number: usize, expected: &dyn Fn(f64) -> f64| {
        let measured = study.wavelengths_nm.iter().zip(&all[number].factors).filter(|(nm, _)| **nm >= 400.0);
        measured.map(|(nm, factor)| (factor - expected(*nm)).abs()).fold(0.0, f64::max)
    };
    let because = "emission at every wavelength is what the pair leaves over";
    findings.promise(
        "bare paper under M1 against its measurement",
        error(each, &|nm| m2(nm) + fluorescence(nm)),
        1e-3,
        because,
    );
    findings.promise("bare paper under M2 against its measurement", error(2 * each, &m2), 1e-3, because);
    let top = all[each].factors.iter().copied().fold(0.0, f64::max);
    let because = "brightened paper returns more than comes in: the measurement reaches 1.03";
    let what = "largest factor of the bare paper under M1";
    findings.check(what, top, Bound::AtLeast(1.02), Reason::Promise, because);
}

fn dots(_: Level, findings: &mut Findings) {
    let mut limits: f64 = 0.0;
    let mut between: f64 = 0.0;
    let mut solid: f64 = 0.0;
    for (coverage, albedo) in [(0.1, 0.9), (0.37, 0.955), (0.5, 0.6), (0.8, 1.0)] {
        let factor = |spread: f64, coverage: f64| {
            let mix = AreaMix { shares: vec![coverage, 1.0 - coverage], spread };
            mix.factor(&[optics(INK), optics(BARE)], albedo, &[])
        };
        let alone = |area: &Area| area.entering * area.leaving * albedo / (1.0 - albedo * area.back);
        let mean = |part: fn(&Area) -> f64| coverage * part(&INK) + (1.0 - coverage) * part(&BARE);
        let neugebauer = coverage * alone(&INK) + (1.0 - coverage) * alone(&BARE);
        let entering = mean(|x| x.entering);
        let leaving = mean(|x| x.leaving);
        let back = mean(|x| x.back);
        let clapper_yule = albedo * entering * leaving / (1.0 - albedo * back);
        limits = limits
            .max((factor(0.0, coverage) - neugebauer).abs())
            .max((factor(1.0, coverage) - clapper_yule).abs());
        let areas = [vec![INK, BARE]];
        let shares = [coverage, 1.0 - coverage];
        let paper = [vec![albedo]];
        let truth = Returns { areas: &areas, shares: &shares, spread: 0.4, paper: &paper, light: &[1.0] };
        between = between.max((factor(0.4, coverage) - truth.factors(400)[0]).abs());
        let scalar =
            INK.entering * INK.leaving * returned(albedo, 1.0 - INK.back, 0.0, 1.0).unwrap_or(f64::NAN);
        for spread in [0.0, 0.3, 0.7, 1.0] {
            solid = solid.max((factor(spread, 1.0) - scalar).abs());
        }
    }
    findings.identity("dots without and with full spread against closed forms", limits, 1e-12, "rounding");
    findings.identity(
        "dots with a spread of 0.4 against the sum of their returns",
        between,
        1e-12,
        "400 returns of at most 0.6 each",
    );
    findings.identity(
        "full coverage against the formula of the solid",
        solid,
        2e-16,
        "one unit in the last place",
    );
}

fn lattice(level: Level, findings: &mut Findings) {
    let spread_um = 40.0;
    let mut error: f64 = 0.0;
    let mut random = Uniform(7);
    for coverage in [0.25, 0.5, 0.75] {
        for per_cm in [20.0, 40.0, 60.0, 100.0, 200.0] {
            let ruling_per_um = 1e-4 * per_cm;
            let screen = Screen {
                coverage,
                pitch_by_spread: 1.0 / (ruling_per_um * spread_um),
                ink: INK,
                bare: BARE,
                albedo: 0.93,
            };
            let rays = screen.factor(level.pick(100_000, 2_000_000), &mut random);
            let spread = spread_share(coverage, ruling_per_um, spread_um);
            let mix = AreaMix { shares: vec![coverage, 1.0 - coverage], spread };
            error = error.max((mix.factor(&[optics(INK), optics(BARE)], 0.93, &[]) - rays).abs());
        }
    }
    let because = "places within dots that light has come back to are taken as even; chance is 0.001 at the quick level";
    findings.promise("factor of a lattice of dots, five rulings, three coverages", error, 5e-3, because);
}
