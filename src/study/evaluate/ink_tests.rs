//! Homogeneous inks (no solves) and synthetic ensembles.

#[path = "ink_made_up_tests.rs"]
pub mod made_up;

use super::*;
use crate::appearance::colour::Colour;
use crate::appearance::film::Profile;
use crate::appearance::paper::{Albedo, Coupling, MirroredSky};
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::samples::SolvedDirection;
use crate::input::variation::ThicknessShare;
use crate::material::mixing::molecular_mixture;
use crate::material::spectra::Spectrum;
use crate::wave::Wave;
use made_up::{MadeUp, RANGE_NM, truth};
use num_complex::Complex64;

/// A molecular mixture of a synthetic pigment in the papers' binder, 1 µm, on paper of albedo 0.9.
pub fn molecular_ink(pigment: &str, share: f64, coupling: Coupling) -> InkOnPaper {
    let outputs_nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
    let spectrum = Spectrum::synthetic(pigment).unwrap();
    let index = |nm: f64| molecular_mixture(1.558.into(), &[(share, spectrum.index(1e-3 * nm).unwrap())]);
    let indices = |nm: f64| (vec![index(nm)], Vec::new());
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling };
    let films = films(&indices, coupling.index_out());
    InkOnPaper::homogeneous(&InkInputs { films: &films, substrate: &substrate, outputs_nm: &outputs_nm })
        .unwrap()
}

fn films<'a>(indices: &'a super::super::films::Indices<'a>, index_out: f64) -> Films<'a> {
    Films {
        profile: Profile::homogeneous(),
        indices,
        thicknesses: ThicknessShare::even(1.0),
        index_out,
        wave: Wave::Scalar,
    }
}

#[test]
fn a_yellow_ink_is_yellow_and_red_is_red() {
    for coupling in [Coupling::Gap, Coupling::OpticalContact { index: 1.558 }] {
        for (pigment, hues) in
            [("yellow", 80.0..110.0), ("red", 320.0..360.0), ("blue", 190.0..290.0), ("green", 100.0..160.0)]
        {
            let ink = molecular_ink(pigment, 0.3, coupling);
            let view = ink.at(0.0).unwrap();
            let colour = ink.colour(|l| l.natural_light(&view, MirroredSky::Excluded)).unwrap();
            let chroma = colour.chroma().value;
            let hue = colour.hue_deg().value;
            assert!(chroma > 30.0 && hues.contains(&hue), "{pigment}: C* {chroma}, h {hue}");
        }
    }
}

#[test]
fn chroma_grows_with_concentration() {
    let chroma = |share| {
        let ink = molecular_ink("yellow", share, Coupling::Gap);
        let view = ink.at(0.0).unwrap();
        ink.colour(|l| l.natural_light(&view, MirroredSky::Excluded)).unwrap().chroma().value
    };
    assert!(chroma(0.05) < chroma(0.15) && chroma(0.15) < chroma(0.3));
}

/// The specular order of a small cell contains diffuse light; the mirror reflection of a print does
/// not.
#[test]
fn the_mirror_part_is_without_the_diffuse_light_of_its_order() {
    let made = MadeUp { films: films(&yellow, 1.0), strata: 3, wavelengths: 15, noise: 0.0 };
    let (ink, _) = made.ink(6, 5);
    for (layer, &nm) in ink.layers().iter().zip(ink.wavelengths_nm()) {
        for deg in [0.0, PRINT_DEG] {
            let angle = ink.at(deg).unwrap();
            let want = made.films.at(nm).reflectance_transmittance(deg)[0];
            // λ² with splines of 20 nm: the penalty on roughness
            assert!(
                (layer.mirrored(&angle) - want).abs() < 1e-5,
                "{nm}, {deg}°: {} {want}",
                layer.mirrored(&angle)
            );
            // planted: the whole order
            assert!(layer.specular(&angle) - want > 5e-4, "the check is empty");
            let excluded = layer.natural_light(&angle, MirroredSky::Excluded);
            assert!(
                (layer.albedo(&angle) - excluded - want).abs() < 1e-5,
                "an instrument without the mirror"
            );
        }
    }
}

/// A renderer's T has the measured mean over the hemisphere, and its values at 0° and 45° are
/// unchanged.
#[test]
fn a_curve_that_is_bent_has_the_mean_measured() {
    let made = MadeUp { films: films(&yellow, 1.0), strata: 3, wavelengths: 15, noise: 0.01 };
    let (ink, _) = made.ink(6, 5);
    let squares = (0..200).map(|k| (f64::from(k) + 0.5) / 200.0);
    let around: Vec<_> =
        squares.map(|u| (ink.at(u.sqrt().acos().to_degrees()).unwrap(), 1.0 / 200.0)).collect();
    let mut most: f64 = 0.0;
    for layer in ink.layers() {
        let lacking = layer.lacking_bends(&around);
        let mean = |bent: f64| -> f64 {
            let t = |(angle, weight): &(PolarAngle, f64)| {
                weight * (layer.transmittance(angle) + bent * angle.bent(&lacking))
            };
            around.iter().map(t).sum()
        };
        // rounding of 200 terms; without the correction it has the fit's mean
        assert!((mean(1.0) - layer.mean_transmittance()).abs() < 1e-12);
        most = most.max((mean(0.0) - layer.mean_transmittance()).abs());
        assert!(
            [0.0, PRINT_DEG].map(|deg| ink.at(deg).unwrap().bent(&lacking)).iter().all(|b| b.abs() < 1e-14)
        );
    }
    assert!(most > 1e-4, "the check is empty: {most}");
}

/// A renderer sees that the layer scatters forward, as prescribed; colours use the mean over the
/// azimuth.
#[test]
fn the_brdf_depends_on_the_azimuth_as_the_orders_do() {
    let made = MadeUp { films: films(&yellow, 1.0), strata: 3, wavelengths: 5, noise: 0.0 };
    let (ink, _) = made.ink(6, 5);
    let layer = &ink.layers()[7];
    for (lit, seen, cosine) in [(0.7, 0.6, 1.0), (0.7, 0.6, -1.0), (0.3, 0.8, 0.2), (1.0, 0.4, 1.0)] {
        let squares = (1.0f64 - lit * lit) * (1.0 - seen * seen);
        let s = squares.sqrt() * cosine;
        let want = 0.02 * s - 0.01 * s * (lit + seen) + 0.005 * (2.0 * s * s - squares);
        // the orders have exactly the form of the fit; its ridge and the penalty on roughness
        // remain
        let got = layer.azimuthal_brdf(lit, seen, cosine);
        assert!((got - want).abs() < 1e-6, "{lit} {seen} {cosine}: {got} {want}");
    }
    // never negative, and the azimuthal mean is that of the colours
    for (lit, seen) in [(0.7, 0.6), (0.2, 0.3), (0.9, 0.1)] {
        let around = (0..36).map(|k| (10.0 * f64::from(k)).to_radians().cos());
        let all: Vec<f64> = around.map(|cosine| layer.directional_brdf(lit, seen, cosine)).collect();
        let mean = layer.diffuse_brdf_at(lit, seen);
        // rounding of 36 terms
        assert!((all.iter().sum::<f64>() / 36.0 - mean).abs() < 1e-12);
        assert!(mean < 0.0 || all.iter().all(|f| *f > -1e-12), "{lit} {seen}: {all:?}");
    }
}

/// A made-up layer of yellow ink, for tests of other modules.
pub(crate) fn yellow_made_up(noise: f64) -> MadeUp<'static> {
    MadeUp { films: films(&yellow, 1.0), strata: 3, wavelengths: 15, noise }
}

fn yellow(nm: f64) -> (Vec<Complex64>, Vec<Complex64>) {
    let eta = Spectrum::synthetic("yellow").unwrap().index(1e-3 * nm).unwrap();
    (vec![molecular_mixture(1.558.into(), &[(0.3, eta)])], Vec::new())
}

/// Without noise, a few shifted directions and wavelengths reproduce the spectrum and the colour of
/// dense sums.
#[test]
fn smooth_differences_are_found_from_few_solves() {
    let films = films(&yellow, 1.0);
    let made = MadeUp { films, strata: 3, wavelengths: 15, noise: 0.0 };
    let (ink, _) = made.ink(16, 5);
    let view = ink.at(0.0).unwrap();
    let natural = |l: &LayerOnPaper| l.natural_light(&view, MirroredSky::Included);
    let spectrum = ink.spectrum(natural);
    for (nm, value) in ink.wavelengths_nm().iter().zip(&spectrum.values) {
        // a band of 60 nm with splines of 20 nm, a cubic curve for the prescribed quadratic one:
        // both errors are small
        let want = truth(&made.films, *nm);
        assert!((value - want).abs() < 2e-3, "{nm}: {value} {want}");
    }
    let fine: Vec<f64> = (0..=60).map(|k| 400.0 + 5.0 * f64::from(k)).collect();
    let want: Vec<f64> = fine.iter().map(|&nm| truth(&made.films, nm)).collect();
    let want = Colorimeter::new(&fine).unwrap().colour(&want).unwrap();
    let got = ink.colour(natural).unwrap();
    let off: f64 = got.lab.iter().zip(want.lab).map(|(a, b)| (a - b).powi(2)).sum();
    assert!(off.sqrt() < 0.05, "{:?} {:?}", got.lab, want.lab);
}

/// Over many seeds the deviations of L*, a*, b* from their mean agree with the jackknife: χ² of 40
/// seeds within its 99.9 % range.
#[test]
fn jackknife_errors_are_calibrated() {
    let films = films(&yellow, 1.0);
    let made = MadeUp { films, strata: 3, wavelengths: 10, noise: 0.01 };
    let colours: Vec<Colour> = (0..40)
        .map(|seed| {
            let (ink, _) = made.ink(12, seed);
            let view = ink.at(0.0).unwrap();
            ink.colour(|l| l.natural_light(&view, MirroredSky::Included)).unwrap()
        })
        .collect();
    for i in 0..3 {
        let mean = colours.iter().map(|c| c.lab[i]).sum::<f64>() / 40.0;
        let spread = colours.iter().map(|c| (c.lab[i] - mean).powi(2)).sum::<f64>() / 39.0;
        let said = colours.iter().map(|c| c.lab_covariance.unwrap()[i][i]).sum::<f64>() / 40.0;
        // 39 degrees of freedom: χ²/39 is between 0.42 and 1.87 with 99.9 %; the jackknife of 12
        // adds a scatter of 20 %
        let ratio = spread / said;
        assert!((0.4..2.0).contains(&ratio), "coordinate {i}: {ratio}");
    }
}

/// A lossless layer with scattering and noise on perfectly white paper: exactly 1, whatever the
/// directions.
#[test]
fn the_furnace_is_exact() {
    let clear = |_: f64| (vec![Complex64::from(1.5)], Vec::new());
    for index_out in [1.0, 1.5] {
        let films = films(&clear, index_out);
        let made = MadeUp { films, strata: 2, wavelengths: 6, noise: 0.02 };
        let mut draws = crate::numerics::Draws::new(9, 0);
        let mut solved: Vec<_> = (0..5)
            .map(|r| made.realisation([0.1 * r as f64, 0.9 - 0.15 * r as f64], || draws.normal()))
            .collect();
        for w in solved.iter_mut().flat_map(|r| &mut r.wavelengths) {
            let lossless =
                |s: &mut SolvedDirection| (s.absorptance, s.reflectance) = (0.0, 1.0 - s.transmittance);
            w.exact.iter_mut().chain(&mut w.strata).for_each(lossless);
            if index_out > 1.0 {
                w.exit = w.strata.clone();
            }
        }
        let basis = SpectralBasis::Splines { range_nm: RANGE_NM, intervals: 6 };
        let layer = LayerEnsemble::new(&solved, basis, &made.films, &[0.0, PRINT_DEG]);
        let coupling =
            if index_out > 1.0 { Coupling::OpticalContact { index: index_out } } else { Coupling::Gap };
        let substrate = Substrate { albedo: Albedo::Constant(1.0), coupling };
        let inputs =
            InkInputs { films: &made.films, substrate: &substrate, outputs_nm: &[450.0, 550.0, 650.0] };
        let ink = InkOnPaper::new(SolvedLayer { ensemble: layer, solved: &solved }, None, &inputs).unwrap();
        for deg in [0.0, 20.0, 45.0, 70.0] {
            let view = ink.at(deg).unwrap();
            for layer in ink.layers() {
                // identity: rounding and the fit's ridge
                assert!(
                    (layer.albedo(&view) - 1.0).abs() < 1e-9,
                    "{index_out}, {deg}°: {}",
                    layer.albedo(&view)
                );
            }
        }
    }
}

#[test]
fn angles_that_cannot_carry_paper_are_refused() {
    let films = films(&yellow, 1.0);
    let basis = SpectralBasis::Listed(vec![500.0]);
    let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
    let inputs = InkInputs { films: &films, substrate: &substrate, outputs_nm: &[500.0] };
    let layer = LayerEnsemble::new(&[], basis, &films, &[0.0, 30.0]);
    assert_eq!(
        InkOnPaper::new(SolvedLayer { ensemble: layer, solved: &[] }, None, &inputs).unwrap_err(),
        InkError::AnglesMissing
    );
}

/// Mean reflectance over the hemisphere above a backing, as in Kubelka and Munk.
fn over_backing(layer: &LayerOnPaper, around: &[PolarAngle], backing: f64) -> f64 {
    let layer = layer.over(backing);
    around.iter().map(|angle| layer.albedo(angle)).sum::<f64>() / around.len() as f64
}

/// K and S from the layer over black and over white predict it over grey, within the noise.
/// *Planted*: linear interpolation between black and white, without multiple reflections, is wrong
/// by 20 standard errors.
#[test]
fn kubelka_and_munk_predict_a_third_backing_within_its_bar() {
    use crate::appearance::kubelka_munk::KubelkaMunk;
    let made = MadeUp { films: films(&yellow, 1.0), strata: 3, wavelengths: 15, noise: 2e-3 };
    let (ink, _) = made.ink(24, 11);
    // equal steps of μ², whose plain mean is the hemispherical one
    let squares = (0..30).map(|k| (f64::from(k) + 0.5) / 30.0);
    let around: Vec<PolarAngle> = squares.map(|u| ink.at(u.sqrt().acos().to_degrees()).unwrap()).collect();
    let over_backings =
        |layer: &LayerOnPaper| [0.0, 0.4, 0.8].map(|backing| over_backing(layer, &around, backing));
    let predicted = ink.spectrum(|layer| {
        let [black, _, white] = over_backings(layer);
        KubelkaMunk::from_backings([0.0, black], [0.8, white], 1.0).unwrap().over(0.4, 1.0)
    });
    let mut worst = 0.0f64;
    let mut straight = 0.0f64;
    for (estimate, layer) in predicted.estimates().iter().zip(ink.layers()) {
        let [black, grey, white] = over_backings(layer);
        let bar = estimate.standard_error.unwrap();
        worst = worst.max((estimate.value - grey).abs() / bar);
        straight = straight.max((0.5 * (black + white) - grey).abs() / bar);
    }
    assert!(worst < 2.0 && straight > 2.0, "{worst} {straight}");
}
