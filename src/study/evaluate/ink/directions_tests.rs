use super::*;
use crate::appearance::film::Profile;
use crate::appearance::paper::{Albedo, Coupling, MirroredSky, PRINT_DEG, Substrate};
use crate::evaluate::ink::tests::made_up::{MadeUp, RANGE_NM};
use crate::evaluate::ink::{InkInputs, SolvedLayer};
use crate::evaluate::layer::LayerEnsemble;
use crate::input::variation::ThicknessShare;
use crate::numerics::Sequence;
use crate::wave::Wave;
use num_complex::Complex64;

const CELLS: usize = 8;
const WAVELENGTHS: usize = 8;
const SEEDS: u64 = 96;

/// Absorptance of the made-up grains from the exit side, in which flat light has a longer way.
fn absorbed(nm: f64, mu: f64) -> f64 {
    (0.03 + 0.08 * (-((nm - 520.0) / 60.0).powi(2)).exp()) * mu * (1.6 - mu)
}

/// The solves of a seed, drawn as a study draws them ([`crate::input::study::Study::draw`]), with
/// a step of the directions from wavelength to wavelength.
fn solved(made: &MadeUp, seed: u64, step: f64) -> Vec<SolvedRealisation> {
    let sequence = Sequence::<6>::new(seed);
    let cell = |r: usize| {
        let [_, _, _, direction, wavelength, _] = sequence.point(r);
        let at = |j: usize| {
            let shift = (direction + j as f64 * step).fract();
            let mut one = made.realisation([wavelength, shift], || 0.0).wavelengths.swap_remove(j);
            if made.films.index_out > 1.0 {
                let film = made.films.at(one.wavelength_nm);
                let exit = |polar_deg: f64| {
                    let [r, t] = film.from(Side::Exit, polar_deg);
                    let mu = polar_deg.to_radians().cos();
                    let absorptance = 1.0 - r - t + absorbed(one.wavelength_nm, mu);
                    SolvedDirection { polar_deg, absorptance, reflectance: r, ..SolvedDirection::default() }
                };
                one.exit = stratified_deg(made.strata, shift).into_iter().map(exit).collect();
            }
            one
        };
        SolvedRealisation { thickness_um: 1.0, wavelengths: (0..WAVELENGTHS).map(at).collect() }
    };
    (0..CELLS).map(cell).collect()
}

fn ink(made: &MadeUp, solved: &[SolvedRealisation]) -> InkOnPaper {
    let basis = SpectralBasis::splines(RANGE_NM, WAVELENGTHS, CELLS);
    let ensemble = LayerEnsemble::new(solved, basis, &made.films, &[0.0, PRINT_DEG]);
    let outputs_nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
    let index = made.films.index_out;
    let coupling = if index > 1.0 { Coupling::OpticalContact { index } } else { Coupling::Gap };
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling };
    let inputs = InkInputs { films: &made.films, substrate: &substrate, outputs_nm: &outputs_nm };
    InkOnPaper::new(SolvedLayer { ensemble, solved }, None, &inputs).expect("an ink")
}

/// L* of natural light, and its squared errors by the jackknife and by what that does not see.
fn lightness(ink: &InkOnPaper) -> [f64; 3] {
    let view = ink.at(0.0).expect("an angle");
    let quantity = |layer: &LayerOnPaper| layer.natural_light(&view, MirroredSky::Included);
    let sight = ink.daylight().expect("daylight");
    let colour = ink.colour(quantity).expect("a colour");
    let unseen = ink.unseen_directions(&sight, colour.xyz, &quantity).expect("shifts");
    let unseen: f64 = unseen.iter().map(|by| by[0] * by[0]).sum();
    [colour.lab[0], colour.lab_covariance.expect("several cells")[0][0], unseen]
}

/// Scatter of L* over the seeds, over its printed error: of the jackknife alone, and of all.
fn ratios(strata: usize, index_out: f64, step: f64) -> [f64; 2] {
    let indices = |_: f64| (vec![Complex64::new(1.5, 0.001)], Vec::new());
    let profile = Profile::homogeneous();
    let wave = Wave::Scalar;
    let films = Films { profile, indices: &indices, thicknesses: ThicknessShare::even(1.0), index_out, wave };
    let made = MadeUp { films, strata, wavelengths: WAVELENGTHS, noise: 0.0 };
    let all: Vec<[f64; 3]> =
        (1..=SEEDS).map(|seed| lightness(&ink(&made, &solved(&made, seed, step)))).collect();
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| all.iter().map(of).sum::<f64>() / SEEDS as f64;
    let middle = mean(&|l| l[0]);
    let scatter = mean(&|l| (l[0] - middle).powi(2)) * SEEDS as f64 / (SEEDS - 1) as f64;
    [mean(&|l| l[1]), mean(&|l| l[1] + l[2])].map(|printed| (scatter / printed).sqrt())
}

/// Steps of the golden ratio between wavelengths and the sequence's step between cells leave an
/// error that all cells share; the bar holds it. Significance: the ratio of 96 seeds has a standard
/// error of at most 0.07, and a prototype of the same draws found 1.40 and 1.06. *Planted*: nothing
/// unseen.
#[test]
fn errors_of_directions_that_all_cells_share_are_in_the_bar() {
    let golden = 0.618_033_988_749_894_9;
    for index_out in [1.0, 1.5] {
        let [jackknife, all] = ratios(3, index_out, golden);
        assert!(jackknife > 1.2, "{index_out}: {jackknife} shows nothing to mend");
        assert!((0.8..1.2).contains(&all), "{index_out}: {all} with {jackknife} before");
        assert!(all < 0.9 * jackknife, "{index_out}: {all} with {jackknife} before");
    }
}

/// Where cells draw their directions apart from each other, nothing is added.
#[test]
fn what_the_jackknife_sees_is_not_counted_twice() {
    let [jackknife, all] = ratios(3, 1.0, 0.0);
    assert!(jackknife < 1.1 && (all / jackknife - 1.0).abs() < 0.05, "{all} with {jackknife} before");
}
