//! Coherent transmittance of the layer, |⟨t⟩|²: what goes straight on through a print of any size.
//!
//! The unscattered order of a cell carries ⟨|t|²⟩ = |⟨t⟩|² + diffuse light, as every order does,
//! and the smaller the cell the more of it. |⟨t⟩|² is the square of the mean amplitude.
//! Realisations have their own wavelengths, and the phase of t turns with the wavelength: fitted is
//! its ratio to the amplitude of the coherent film, which is smooth, with the squares of the film's
//! amplitudes as weights. The square of a mean of n is too large by the variance of the mean, which
//! is taken off.

use super::films::{FilmAt, Films, LIGHTS};
use super::regression::{Fits, Normal};
use super::samples::{SolvedRealisation, SolvedWavelength};
use super::wavelengths::SpectralBasis;
use crate::numerics::estimate::Estimate;
use ndarray::Array2;
use num_complex::Complex64;

/// Fitted ratios of mean amplitudes to those of the coherent film.
#[derive(Clone, Debug)]
pub struct CoherentLight {
    basis: SpectralBasis,
    /// \[exact angle\]\[polarisation of the light\]: real and imaginary part against wavelength.
    fits: Vec<[Fits; LIGHTS]>,
}

impl CoherentLight {
    /// Fits the exact angles of an ensemble. `None` without realisations, and for layers of uneven
    /// thickness: a print has areas of every thickness side by side, whose phases differ.
    pub fn new(
        solved: &[SolvedRealisation],
        basis: &SpectralBasis,
        films: &Films,
        exact_deg: &[f64],
    ) -> Option<Self> {
        let first = solved.first()?.thickness_um;
        if solved.iter().any(|realisation| realisation.thickness_um != first) {
            return None;
        }
        let fit = |angle: usize, light: usize| {
            let sample = |w: &SolvedWavelength| {
                let film = films.of_thickness(w.wavelength_nm, first);
                let reference = film.transmitted_amplitudes(exact_deg[angle])[light];
                (w.wavelength_nm, turned_back(w.exact[angle].unscattered[light], reference))
            };
            Fits::with_influence(
                solved.iter().map(|realisation| realisation.wavelengths.iter().map(sample)),
                basis,
                1,
                2,
            )
        };
        let fits = (0..exact_deg.len()).map(|angle| std::array::from_fn(|light| fit(angle, light)));
        Some(Self { fits: fits.collect(), basis: basis.clone() })
    }

    /// |⟨t⟩|² at an exact angle at these wavelengths, whose films are given; without bias, so that
    /// noise may make it slightly negative. The error is unknown for one realisation, and so is the
    /// bias.
    pub fn transmittance(&self, angle: usize, films: &[FilmAt], exact_deg: f64, nm: &[f64]) -> Vec<Estimate> {
        films
            .iter()
            .zip(nm)
            .map(|(film, &nm)| unbiased(&self.amplitudes(angle, film, exact_deg, nm)))
            .collect()
    }

    /// |⟨t⟩|² at these wavelengths without each realisation, and the variance of the mean amplitude
    /// that is taken off all of them; \[wavelength\].
    pub fn without(&self, angle: usize, films: &[FilmAt], exact_deg: f64, nm: &[f64]) -> Vec<PowersWithout> {
        let of = |(film, &nm): (&FilmAt, &f64)| {
            let replicates = self.amplitudes(angle, film, exact_deg, nm);
            let variance = replicates.variance();
            PowersWithout {
                powers: replicates.without.iter().map(|left| power(left) - variance).collect(),
                variance,
            }
        };
        films.iter().zip(nm).map(of).collect()
    }

    /// Mean amplitudes at one wavelength.
    fn amplitudes(&self, angle: usize, film: &FilmAt, exact_deg: f64, nm: f64) -> Replicates {
        let reference = film.transmitted_amplitudes(exact_deg);
        let weights = self.basis.weights(nm);
        let amplitudes = |coefficients: &dyn Fn(&Fits) -> &Array2<f64>| -> [Complex64; LIGHTS] {
            std::array::from_fn(|light| {
                let fit = coefficients(&self.fits[angle][light]);
                let part = |column: usize| SpectralBasis::at(&weights, |i| fit[[i, column]]);
                reference[light] * Complex64::new(part(0), part(1))
            })
        };
        Replicates {
            whole: amplitudes(&|fits| &fits.whole),
            without: (0..self.replicates()).map(|r| amplitudes(&|fits| &fits.without[r])).collect(),
            influence: (0..self.replicates()).map(|r| amplitudes(&|fits| &fits.influence[r])).collect(),
        }
    }

    fn replicates(&self) -> usize {
        self.fits.first().map_or(0, |fits| fits[0].without.len())
    }
}

/// A sample of the ratio amplitude/reference with the weight |reference|².
fn turned_back(amplitude: Complex64, reference: Complex64) -> Normal {
    let mut sample = Normal::new(1, 2);
    let size = reference.norm();
    if size > 0.0 {
        let turned = amplitude * reference.conj() / size;
        sample.sample(&[size], &[turned.re, turned.im]);
    }
    sample
}

/// Mean amplitudes of all lights: of the ensemble, without each realisation, and what each adds to
/// first order.
struct Replicates {
    whole: [Complex64; LIGHTS],
    without: Vec<[Complex64; LIGHTS]>,
    influence: Vec<[Complex64; LIGHTS]>,
}

/// |⟨t⟩|² at one wavelength without each realisation, and the variance that is taken off.
#[derive(Clone, Debug, PartialEq)]
pub struct PowersWithout {
    /// \[realisation left out\]
    pub powers: Vec<f64>,
    /// Variance of the mean amplitude of all.
    pub variance: f64,
}

/// Σ |a|² over mutually incoherent amplitudes.
fn power(amplitudes: &[Complex64; LIGHTS]) -> f64 {
    amplitudes.iter().map(Complex64::norm_sqr).sum()
}

impl Replicates {
    /// Variance of the mean amplitudes; 0 where a single realisation leaves it unknown.
    fn variance(&self) -> f64 {
        let Self { whole, without, influence } = self;
        if without.len() < 2 {
            return 0.0;
        }
        let terms = without.iter().zip(influence).flat_map(|(left, added)| {
            (0..LIGHTS).map(move |light| (added[light].conj() * (whole[light] - left[light])).re)
        });
        terms.sum()
    }
}

/// Σ |a|² over mutually incoherent mean amplitudes, less the variance of the means. The variance
/// multiplies what a realisation adds to first order by what leaving it out changes: either alone
/// is too small or too large where few realisations lie near a wavelength (HC2: J. G. MacKinnon and
/// H. White, J. Econometrics 29 (1985) 305). The error is that of the jackknife for amplitudes
/// beyond their noise, and the variance for amplitudes within it.
fn unbiased(replicates: &Replicates) -> Estimate {
    let Replicates { whole, without, .. } = replicates;
    if without.len() < 2 {
        return Estimate::unknown_error(power(whole));
    }
    let variance = replicates.variance();
    let powers: Vec<f64> = without.iter().map(power).collect();
    let chance = Estimate::jackknife(power(whole), &powers).standard_error.unwrap_or(0.0);
    Estimate { value: power(whole) - variance, standard_error: Some(chance.hypot(variance)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::film::Profile;
    use crate::evaluate::samples::SolvedDirection;
    use crate::input::variation::ThicknessShare;
    use crate::numerics::Draws;
    use crate::wave::Wave;

    const RANGE_NM: [f64; 2] = [400.0, 700.0];

    fn films(wave: Wave) -> Films<'static> {
        Films {
            profile: Profile::homogeneous(),
            indices: &|_| (vec![Complex64::new(1.5, 0.01)], Vec::new()),
            thicknesses: ThicknessShare::even(2.0),
            index_out: 1.2,
            wave,
        }
    }

    /// Solves at shifted wavelengths whose amplitude is that of the film times `mean`, plus
    /// circular noise of the given mean square.
    fn solved(films: &Films, cells: usize, mean: Complex64, noise: f64, seed: u64) -> Vec<SolvedRealisation> {
        let mut draws = Draws::new(seed, 5);
        let mut cell = |r: usize| {
            let wavelengths = (0..12).map(|j| {
                let wavelength_nm = 400.0 + 25.0 * (j as f64 + (r as f64 + 0.5) / cells as f64);
                let film = films.of_thickness(wavelength_nm, 2.0).transmitted_amplitudes(0.0);
                let mut noisy = |a: Complex64| {
                    let part = (0.5 * noise).sqrt();
                    mean * a + Complex64::new(part * draws.normal(), part * draws.normal())
                };
                let unscattered = film.map(|a| if a.norm() > 0.0 { noisy(a) } else { a });
                let direction = SolvedDirection { unscattered, ..SolvedDirection::default() };
                SolvedWavelength {
                    wavelength_nm,
                    exact: vec![direction],
                    strata: Vec::new(),
                    exit: Vec::new(),
                }
            });
            SolvedRealisation { thickness_um: 2.0, wavelengths: wavelengths.collect() }
        };
        (0..cells).map(&mut cell).collect()
    }

    fn transmittances(films: &Films, solved: &[SolvedRealisation]) -> Vec<Estimate> {
        let basis = SpectralBasis::splines(RANGE_NM, 12, solved.len());
        let light = CoherentLight::new(solved, &basis, films, &[0.0]).unwrap();
        let nm: Vec<f64> = (0..7).map(|i| 400.0 + 50.0 * f64::from(i)).collect();
        let at_nm: Vec<FilmAt> = nm.iter().map(|&nm| films.at(nm)).collect();
        light.transmittance(0, &at_nm, 0.0, &nm)
    }

    /// Identity: without noise |⟨t⟩|² is that of the film times |mean|², in every light, however
    /// the wavelengths are shifted against each other.
    #[test]
    fn amplitudes_are_averaged_before_they_are_squared() {
        for wave in [Wave::Scalar, Wave::P, Wave::Unpolarised] {
            let films = films(wave);
            let mean = Complex64::new(0.3, -0.6);
            let all = transmittances(&films, &solved(&films, 6, mean, 0.0, 1));
            for (i, estimate) in all.iter().enumerate() {
                let nm = 400.0 + 50.0 * i as f64;
                let want = 0.45 * films.at(nm).reflectance_transmittance(0.0)[1];
                // the fit's ridge
                assert!((estimate.value - want).abs() < 1e-9, "{wave:?}, {nm} nm: {estimate:?} {want}");
            }
        }
    }

    /// Noise of 0.09, as of a paint whose unscattered order holds diffuse light alone: mean |t|² is
    /// 0.09,
    /// |mean t|² is 0. *Planted*: without the correction of the bias the mean is 9 standard errors
    /// off.
    #[test]
    fn diffuse_light_of_the_order_is_not_coherent() {
        let films = films(Wave::Unpolarised);
        for (mean, seeds) in [(0.0, 60), (0.5, 60)] {
            let all = (0..seeds)
                .flat_map(|seed| transmittances(&films, &solved(&films, 12, mean.into(), 0.09, seed)))
                .collect::<Vec<_>>();
            let nm = |i: usize| 400.0 + 50.0 * (i % 7) as f64;
            let want = |i: usize| mean * mean * films.at(nm(i)).reflectance_transmittance(0.0)[1];
            let off: Vec<f64> = all.iter().enumerate().map(|(i, e)| e.value - want(i)).collect();
            let z: Vec<f64> = off.iter().zip(&all).map(|(off, e)| off / e.standard_error.unwrap()).collect();
            // of one seed the seven wavelengths are nearly independent
            let average = Estimate::of_mean(&off);
            assert!(average.value.abs() < 4.0 * average.standard_error.unwrap(), "{mean}: {average:?}");
            // the error covers: between half and one and a half times
            let spread = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
            assert!((0.5..1.5).contains(&spread), "{mean}: rms z {spread}");
        }
    }
}
