//! The coherent film at all wavelengths and thicknesses of an ensemble.

use crate::appearance::film::{Film, Profile};
use crate::appearance::kubelka_munk::DiffuseFaces;
use crate::input::variation::{MEAN_INDEX, ThicknessShare};
use crate::numerics::integral::{Halving, halved};
use crate::wave::maxwell::Polarisation;
use crate::wave::{Side, Wave};
use gauss_quad::GaussLegendre;
use num_complex::Complex64;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

/// Most polarisations of one light, whose amplitudes are mutually incoherent.
pub const LIGHTS: usize = 2;

/// Number of angles of hemispherical means, exact to rounding for films of a few wavelengths …
const MEAN_ANGLES: usize = 40;
/// … and of a rule beside it that tells where they do not suffice.
const CHECKING_ANGLES: usize = 28;
/// A piece of the hemisphere is halved where the two rules differ by more.
const MEAN_ERROR: f64 = 1e-7;
/// Fringes of the pieces that are begun with.
const FRINGES_OF_A_PIECE: f64 = 16.0;
/// Most pieces: thicker films have fringes beyond number, whose phases they sample …
const MOST_PIECES: usize = 64;
/// … and most of an uneven film, which has few; at grazing incidence the rest of the sum over its
/// thicknesses is no smooth function, whose weight is small.
const MOST_AVERAGED_PIECES: usize = 6;

/// Rules of Gauss and Legendre on 0…1, of the mean and of its check.
static RULES: LazyLock<[Vec<(f64, f64)>; 2]> = LazyLock::new(|| {
    [MEAN_ANGLES, CHECKING_ANGLES].map(|count| {
        let rule = GaussLegendre::new(count).expect("a positive number of nodes");
        rule.iter().map(|(x, weight)| (0.5 * (1.0 + x), 0.5 * weight)).collect()
    })
});

/// ∫₀¹ of several functions: fringes of thick films and resonances of guided light are not missed.
/// `begun` and `most` are the numbers of pieces.
fn integral<const N: usize>([begun, most]: [usize; 2], functions: &impl Fn(f64) -> [f64; N]) -> [f64; N] {
    halved(&RULES, Halving { begun, most, error: MEAN_ERROR }, functions)
}

/// Polar angles in degrees with the weights of 2∫₀¹ f μ dμ.
pub(super) fn hemisphere() -> Vec<(f64, f64)> {
    let rule = GaussLegendre::new(MEAN_ANGLES).expect("a positive number of nodes");
    let angle = |mu: f64, weight: f64| (mu.acos().to_degrees(), weight * mu);
    rule.iter().map(|(x, weight)| angle(0.5 * (1.0 + x), *weight)).collect()
}

/// Distance of the fringes of a film of this thickness at a wavelength, both in nm: λ²/(2nd), for a
/// mean index n that few layers exceed.
pub(super) fn fringe_nm(nm: f64, thickness_um: f64) -> f64 {
    nm * nm / (2e3 * MEAN_INDEX * thickness_um)
}

/// Fringes whose phase varies by more over an uneven layer are averaged out, rad.
const AVERAGED_OUT: f64 = 6.0;

/// The thickness whose fringes are left at wavelengths of at most `longest_nm`, µm: the longest, or
/// 0 where a single layer is so uneven that it has none. (Of a stack's other layers they are left.)
pub(super) fn fringing_um(thicknesses: &[ThicknessShare], is_stack: bool, longest_nm: f64) -> f64 {
    let mean_um: f64 = thicknesses.iter().map(|of| of.share * of.um).sum();
    let variance: f64 = thicknesses.iter().map(|of| of.share * (of.um - mean_um).powi(2)).sum();
    // the least phase: of index 1
    if !is_stack && 2.0 * TAU * variance.sqrt() > AVERAGED_OUT * 1e-3 * longest_nm {
        return 0.0;
    }
    thicknesses.iter().fold(0.0, |longest, of| of.um.max(longest))
}

/// Indices of the background of every layer and of the inclusions at a vacuum wavelength in nm.
pub type Indices<'a> = dyn Fn(f64) -> (Vec<Complex64>, Vec<Complex64>) + 'a;

/// The films of an ensemble: one profile, several thicknesses.
#[derive(Clone)]
pub struct Films<'a> {
    /// Mean volume fractions across the layer.
    pub profile: Profile,
    /// Indices against wavelength.
    pub indices: &'a Indices<'a>,
    /// Thicknesses of the layer.
    pub thicknesses: Vec<ThicknessShare>,
    /// Index of the half-space on the exit side.
    pub index_out: f64,
    /// The light: s for the scalar wave, the mean of s and p for unpolarised light.
    pub wave: Wave,
}

/// The film at one wavelength, averaged over its thicknesses.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmAt {
    /// Of the first thickness.
    film: Film,
    thicknesses: Vec<LayersShare>,
    wave: Wave,
}

/// Thicknesses of the film's layers, and their share of the area.
#[derive(Clone, Debug, PartialEq)]
struct LayersShare {
    layers_um: Vec<f64>,
    share: f64,
}

impl Films<'_> {
    /// The film at a wavelength, averaged over the thicknesses of the ensemble.
    pub fn at(&self, wavelength_nm: f64) -> FilmAt {
        let film = self.film(wavelength_nm, self.thicknesses.first().map_or(0.0, |first| first.um));
        let layers = |thickness: &ThicknessShare| LayersShare {
            layers_um: self.profile.layers_um(thickness.um),
            share: thickness.share,
        };
        FilmAt { film, thicknesses: self.thicknesses.iter().map(layers).collect(), wave: self.wave }
    }

    /// The films for light returned by the paper.
    pub fn returned(&self) -> Self {
        Self { wave: self.wave.returned(), ..self.clone() }
    }

    /// The film of one thickness, µm.
    pub fn of_thickness(&self, wavelength_nm: f64, thickness_um: f64) -> FilmAt {
        FilmAt::even(self.film(wavelength_nm, thickness_um), self.wave)
    }

    fn film(&self, wavelength_nm: f64, thickness_um: f64) -> Film {
        let (backgrounds, inclusions) = (self.indices)(wavelength_nm);
        Film {
            squared_indices: self.profile.squared_indices(&backgrounds, &inclusions),
            layers_um: self.profile.layers_um(thickness_um),
            wavelength_um: 1e-3 * wavelength_nm,
            index_out: self.index_out,
        }
    }
}

impl FilmAt {
    fn even(film: Film, wave: Wave) -> Self {
        let thicknesses = vec![LayersShare { layers_um: film.layers_um.clone(), share: 1.0 }];
        Self { film, thicknesses, wave }
    }

    /// Index of the half-space on the exit side.
    pub fn index_out(&self) -> f64 {
        self.film.index_out
    }

    /// The film for light returned by the paper, which is unpolarised.
    pub fn returned(&self) -> FilmAt {
        FilmAt { wave: self.wave.returned(), ..self.clone() }
    }

    /// \[R, T\] for light from the incident side.
    pub fn reflectance_transmittance(&self, polar_deg: f64) -> [f64; 2] {
        self.from(Side::Incident, polar_deg)
    }

    /// Transmitted amplitudes of light from the incident side, one for each polarisation of the
    /// light, so that the sum of their squares is T of the first thickness; 0 beyond them.
    pub fn transmitted_amplitudes(&self, polar_deg: f64) -> [Complex64; LIGHTS] {
        let lights: &[Polarisation] =
            if self.wave.is_vector() { self.wave.polarisations() } else { &[Polarisation::S] };
        let share = (1.0 / lights.len() as f64).sqrt();
        let mut all = [Complex64::ZERO; LIGHTS];
        for (amplitude, &light) in all.iter_mut().zip(lights) {
            *amplitude = share * self.film.amplitudes(Side::Incident, polar_deg, light)[1];
        }
        all
    }

    /// \[R, T\] for light from one side, with the angle in its half-space.
    pub(super) fn from(&self, side: Side, polar_deg: f64) -> [f64; 2] {
        let lights: &[Polarisation] =
            if self.wave.is_vector() { self.wave.polarisations() } else { &[Polarisation::S] };
        let mut totals = [0.0; 2];
        for &light in lights {
            let wave = self.film.wave(side, polar_deg, light);
            for LayersShare { layers_um, share } in &self.thicknesses {
                let weight = share / lights.len() as f64;
                let amplitudes = wave.amplitudes(layers_um);
                totals.iter_mut().zip(amplitudes).for_each(|(sum, a)| *sum += weight * a.norm_sqr());
            }
        }
        totals
    }

    /// Shares that the layers of a stack absorb of light from the incident side.
    pub fn absorbed(&self, polar_deg: f64) -> Vec<f64> {
        let lights: &[Polarisation] =
            if self.wave.is_vector() { self.wave.polarisations() } else { &[Polarisation::S] };
        let mut all = vec![0.0; self.film.layers_um.len()];
        for LayersShare { layers_um, share } in &self.thicknesses {
            let film = Film { layers_um: layers_um.clone(), ..self.film.clone() };
            for &light in lights {
                let weight = share / lights.len() as f64;
                let own = film.absorbed(polar_deg, light);
                all.iter_mut().zip(own).for_each(|(sum, own)| *sum += weight * own);
            }
        }
        all
    }

    /// The film's faces for diffuse light, with its mean index: the real part of √⟨η²⟩ over its
    /// slices.
    pub fn faces(&self) -> DiffuseFaces {
        let film = &self.film;
        let sum: Complex64 = film.squared_indices.iter().sum();
        let index = (sum / film.squared_indices.len().max(1) as f64).sqrt().re;
        let face = Film {
            squared_indices: vec![(index * index).into()],
            layers_um: vec![0.0],
            index_out: index,
            ..film.clone()
        };
        DiffuseFaces::plane(FilmAt::even(face, self.wave).means()[0], index)
    }

    /// Pieces of the hemisphere that its fringes ask for, and at most; where several thicknesses
    /// average them out, one.
    fn pieces(&self) -> [usize; 2] {
        let [LayersShare { layers_um, .. }] = &self.thicknesses[..] else { return [1, MOST_AVERAGED_PIECES] };
        let fringes = 2.0 * MEAN_INDEX * layers_um.iter().sum::<f64>() / self.film.wavelength_um;
        let begun = (fringes / FRINGES_OF_A_PIECE).ceil().clamp(1.0, MOST_PIECES as f64) as usize;
        [begun, MOST_PIECES]
    }

    /// Hemispherical means 2∫₀¹ f μ dμ of \[R, T\] for light from the incident side.
    pub fn means(&self) -> [f64; 2] {
        integral(self.pieces(), &|mu: f64| {
            let both = self.reflectance_transmittance(mu.acos().to_degrees());
            both.map(|value| 2.0 * mu * value)
        })
    }

    /// Hemispherical mean of A for light from the exit side, with angles in its half-space. The
    /// integral is split at the critical angle: below it the variable is that of vacuum, beyond it
    /// the arc μ = μ_c cos t, along which the evanescent decay is smooth.
    pub fn absorptance_from_exit(&self) -> f64 {
        let index = self.index_out();
        let absorbed = |polar_deg: f64| {
            let [r, t] = self.from(Side::Exit, polar_deg);
            1.0 - r - t
        };
        let critical = (1.0 - 1.0 / (index * index)).max(0.0).sqrt();
        let [passing] = integral(self.pieces(), &|share: f64| {
            let inside = ((1.0 - share * share).sqrt() / index).asin();
            [2.0 * share / (index * index) * absorbed(inside.to_degrees())]
        });
        if critical == 0.0 {
            return passing;
        }
        let [reflected] = integral(self.pieces(), &|share: f64| {
            let t = FRAC_PI_2 * share;
            let measure = FRAC_PI_2 * critical * critical * (2.0 * t).sin();
            [measure * absorbed((critical * t.cos()).acos().to_degrees())]
        });
        passing + reflected
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_those_of_closed_forms() {
        let indices = |_: f64| (vec![Complex64::ONE], Vec::new());
        let films = Films {
            profile: Profile::homogeneous(),
            indices: &indices,
            thicknesses: ThicknessShare::even(1.0),
            index_out: 1.0,
            wave: Wave::Scalar,
        };
        let [r, t] = films.at(500.0).means();
        // identity: there is no layer
        assert!(r.abs() < 1e-13 && (t - 1.0).abs() < 1e-13);
        assert!(films.at(500.0).absorptance_from_exit().abs() < 1e-13);
    }

    /// Energy: the weights of both rules add up to one, as seen from a black film's absorption of
    /// all light from the exit side.
    #[test]
    fn the_weights_from_the_exit_side_sum_to_one() {
        let waves = [Wave::Scalar, Wave::P, Wave::Unpolarised];
        for (index_out, wave) in [1.0, 1.2, 1.558, 2.0].into_iter().flat_map(|n| waves.map(|w| (n, w))) {
            // An opaque film matched to the exit side absorbs what enters: 1 − R̄ of a single face,
            // here by a dense sum.
            let eta = Complex64::new(index_out, 3.0);
            let indices = move |_: f64| (vec![eta], Vec::new());
            let films = Films {
                profile: Profile::homogeneous(),
                indices: &indices,
                thicknesses: ThicknessShare::even(5.0),
                index_out,
                wave,
            };
            let film = films.at(500.0);
            let points = 20_000;
            let plain: f64 = (0..points)
                .map(|i| ((i as f64 + 0.5) / points as f64).sqrt().acos().to_degrees())
                .map(|deg| 1.0 - film.from(Side::Exit, deg)[0])
                .sum::<f64>()
                / points as f64;
            // error of the dense sum at grazing incidence, where R has a root
            assert!((film.absorptance_from_exit() - plain).abs() < 2e-6, "{index_out}");
        }
    }

    /// Fringes of thick films, and light guided by a coat over a thinner medium, against a dense
    /// sum.
    /// *Planted*: one rule of 40 angles.
    #[test]
    fn means_have_the_fringes_and_resonances_of_their_films() {
        let coats = [
            vec![(Complex64::new(1.6, 5e-4), 5.0)],
            vec![(Complex64::new(1.6, 5e-4), 15.0)],
            vec![(Complex64::new(1.56, 1e-3), 1.2), (Complex64::new(1.41, 0.0), 0.4)],
        ];
        for coat in coats {
            let film = Film {
                squared_indices: coat.iter().map(|(index, _)| index * index).collect(),
                layers_um: coat.iter().map(|(_, um)| *um).collect(),
                wavelength_um: 0.42,
                index_out: 1.5,
            };
            let film = FilmAt::even(film, Wave::Unpolarised);
            let points = 100_000;
            let degrees = (0..points).map(|i| ((i as f64 + 0.5) / points as f64).sqrt().acos().to_degrees());
            let sum = |of: &dyn Fn(f64) -> f64| degrees.clone().map(of).sum::<f64>() / points as f64;
            let from_behind = sum(&|deg| {
                let [r, t] = film.from(Side::Exit, deg);
                1.0 - r - t
            });
            let through = sum(&|deg| film.reflectance_transmittance(deg)[1]);
            // the dense sum at grazing incidence
            assert!((film.absorptance_from_exit() - from_behind).abs() < 1e-5, "{coat:?}");
            assert!((film.means()[1] - through).abs() < 1e-5, "{coat:?}");
        }
    }
}
