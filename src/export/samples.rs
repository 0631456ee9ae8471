//! Tables for the material: its BRDF at sample directions, for independent checks, and the mirror
//! part that it leaves out.

use super::request::ExportResult;
use crate::draw::cell::table;
use crate::evaluate::directional::{Direction, DirectionalPrint};

/// Columns of `specular.csv`.
const SPECULAR: [&str; 8] = [
    "wavelength_nm",
    "polar_deg",
    "specular_reflectance",
    "albedo_without_specular",
    "albedo_of_brdf",
    "difference_standard_error",
    "difference_by_chance",
    "difference_of_fits",
];
/// Directions in `brdf-samples.csv`.
const SAMPLES: usize = 256;
/// Smallest cosines sampled: grazing directions carry little light.
const LEAST_COSINE: f64 = 0.1;
/// Step of `specular.csv`, degrees.
const STEP_DEG: f64 = 5.0;

/// f(i, o) in 1/sr at directions spread over both hemispheres, for every wavelength. Azimuth 0 is
/// forward, where the mirror image lies; the mirror part itself is left out.
///
/// # Errors
/// What [`csv`] refuses.
pub fn brdf(ink: &dyn DirectionalPrint) -> csv::Result<Vec<u8>> {
    let rows = directions(ink).into_iter().flat_map(|(light_deg, view)| {
        let waves = ink.wavelengths_nm().iter();
        let place = (light_deg, view.polar_deg, view.azimuth_deg);
        waves.enumerate().map(move |(w, nm)| (nm, place, ink.brdf(w, light_deg, view)))
    });
    table(["wavelength_nm", "light_polar_deg", "view_polar_deg", "azimuth_deg", "brdf_per_sr"], rows)
}

/// The Halton sequence in both cosines and the azimuth (0–180°: the other half is its mirror
/// image).
fn directions(ink: &dyn DirectionalPrint) -> Vec<(f64, Direction)> {
    let largest = ink.nodes_deg().last().copied().unwrap_or(0.0);
    let polar = |u: f64| (LEAST_COSINE + (1.0 - LEAST_COSINE) * u).acos().to_degrees();
    (1..=SAMPLES)
        .map(|k| {
            let u = halton(k, 2);
            let v = halton(k, 3);
            let w = halton(k, 5);
            (polar(u).min(largest), Direction { polar_deg: polar(v), azimuth_deg: 180.0 * w })
        })
        .collect()
}

/// The radical inverse of `k`: its digits in `base`, mirrored at the point.
fn halton(mut k: usize, base: usize) -> f64 {
    let mut value = 0.0;
    let mut digit = 1.0;
    while k > 0 {
        digit /= base as f64;
        value += digit * (k % base) as f64;
        k /= base;
    }
    value
}

/// The mirror part R_s(θ, λ) that the material leaves out; the albedo of the material, from the
/// totals R and T and as the integral of its BRDF; and the standard error of the difference, with
/// its two parts: chance, and what the fits of both differ by beyond it. Fits that fall below 0, at
/// grazing light, count as 0.
///
/// # Errors
/// What [`DirectionalPrint::disagreement`] refuses.
pub fn specular(ink: &dyn DirectionalPrint) -> ExportResult<Vec<u8>> {
    let largest = ink.nodes_deg().last().copied().unwrap_or(0.0);
    let mut rows = Vec::new();
    for deg in (0..).map(|k| STEP_DEG * f64::from(k)).take_while(|&deg| deg <= largest) {
        for (w, (nm, apart)) in ink.wavelengths_nm().iter().zip(ink.disagreement(deg)?).enumerate() {
            let mirrored = ink.specular(w, deg).max(0.0);
            let albedo = ink.diffuse_albedo(w, deg).max(0.0);
            let errors = (apart.standard_error(), apart.chance, apart.of_fits);
            rows.push((nm, deg, mirrored, albedo, (albedo + apart.value).max(0.0), errors));
        }
    }
    Ok(table(SPECULAR, rows)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::directional::Disagreement;
    use crate::evaluate::ink::InkError;

    /// A print with an albedo of 0.3, whose BRDF integrates to 0.02 more.
    struct Excessive;

    impl DirectionalPrint for Excessive {
        fn wavelengths_nm(&self) -> &[f64] {
            &[550.0]
        }

        fn brdf(&self, _: usize, _: f64, _: Direction) -> f64 {
            0.0
        }

        fn specular(&self, _: usize, _: f64) -> f64 {
            0.04
        }

        fn diffuse_albedo(&self, _: usize, _: f64) -> f64 {
            0.3
        }

        fn disagreement(&self, _: f64) -> Result<Vec<Disagreement>, InkError> {
            Ok(vec![Disagreement { value: 0.02, chance: Some(0.003), of_fits: 0.004 }])
        }
    }

    #[test]
    fn the_albedo_of_the_brdf_is_the_albedo_and_the_difference() {
        let table = specular(&Excessive).unwrap();
        let mut reader = csv::Reader::from_reader(table.as_slice());
        let rows: Vec<[f64; 8]> = reader.deserialize().collect::<Result<_, _>>().unwrap();
        assert_eq!(rows.len(), 18, "every 5° up to 85°");
        for [nm, _, mirrored, albedo, of_brdf, error, chance, of_fits] in rows {
            assert_eq!((nm, mirrored, albedo, error), (550.0, 0.04, 0.3, 0.005));
            assert_eq!((chance, of_fits), (0.003, 0.004));
            assert!((of_brdf - 0.32).abs() < 1e-12, "{of_brdf}");
        }
    }

    #[test]
    fn mirrored_digits() {
        assert_eq!([1, 2, 3, 4].map(|k| halton(k, 2)), [0.5, 0.25, 0.75, 0.125]);
        assert!((halton(5, 3) - 7.0 / 9.0).abs() < 1e-15);
    }
}
