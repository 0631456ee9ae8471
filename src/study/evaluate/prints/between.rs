//! What paper does between the wavelengths of a study. The layers on it are known at these alone
//! and taken as smooth, but the paper is given, and so is its colour.

use super::{EmittedLight, LitAreas};
use crate::appearance::paper_series::AreaOptics;
use crate::appearance::tristimulus::{Colorimeter, EmissionWeights, lagrange_shares, visible};
use crate::appearance::viewing::{Summation, Viewing};
use crate::input::study::Paper;

/// Largest step of the sum over the paper, nm.
const STEP_NM: f64 = 5.0;
/// Difference from a smooth paper that is rounding.
const SMOOTH: f64 = 1e-12;

/// A place between the wavelengths.
#[derive(Clone, Debug)]
struct PaperPlace {
    albedo: f64,
    /// (wavelength, weight) of the sum of the study's wavelengths there.
    shares: Vec<(usize, f64)>,
    /// The albedo by these.
    smooth: f64,
}

/// The sum of a print's colour over its paper between the wavelengths of a study.
#[derive(Clone, Debug)]
pub(super) struct PaperBetween {
    places: Vec<PaperPlace>,
    eye: Colorimeter,
}

impl PaperBetween {
    /// The paper between wavelengths; `None` where nothing is in between, and for weights that are
    /// meant for these wavelengths (ASTM E308).
    pub fn new(paper: &Paper, wavelengths_nm: &[f64], viewing: &Viewing) -> Option<Self> {
        let seen = visible(wavelengths_nm);
        let grid = &wavelengths_nm[seen.clone()];
        let widest = grid.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        if viewing.summation == Summation::E308 || grid.len() < 3 || widest <= STEP_NM * (1.0 + 1e-9) {
            return None;
        }
        let (first, last) = (grid[0], grid[grid.len() - 1]);
        let intervals = ((last - first) / STEP_NM - 1e-9).ceil();
        let place_nm = |k: usize| first + (last - first) * k as f64 / intervals;
        let places_nm: Vec<f64> = (0..=intervals as usize).map(place_nm).collect();
        let mut places = Vec::new();
        for &nm in &places_nm {
            let shares: Vec<(usize, f64)> =
                lagrange_shares(grid, nm).into_iter().map(|(i, share)| (seen.start + i, share)).collect();
            let albedo = |nm: f64| paper.albedo.at(nm).ok();
            let known = |&(i, share): &(usize, f64)| Some(share * albedo(wavelengths_nm[i])?);
            let smooth = shares.iter().map(known).sum::<Option<f64>>()?;
            places.push(PaperPlace { albedo: albedo(nm)?, shares, smooth });
        }
        let is_smooth = places.iter().all(|place| (place.albedo - place.smooth).abs() < SMOOTH);
        if is_smooth && paper.fluorescence.is_none() {
            return None;
        }
        Some(Self { places, eye: Colorimeter::under(&places_nm, viewing).ok()? })
    }

    /// X, Y, Z of a print beyond those of its sum over the study's wavelengths; `emission` is how
    /// the eye sums there what the paper emits under a lamp with lines.
    pub fn beyond(&self, lit: &LitAreas, emission: Option<&EmissionWeights>) -> [f64; 3] {
        let Some(weights) = emission else { return self.beyond_factors(lit) };
        let dark = self.beyond_factors(&LitAreas { emitted: None, ..*lit });
        let own = weights.xyz(&lit.emitted_parts()[visible(lit.wavelengths_nm)]);
        let closely = self.emitted(lit);
        std::array::from_fn(|c| dark[c] + closely[c] - own[c])
    }

    /// X, Y, Z of what the paper emits at the places between.
    fn emitted(&self, lit: &LitAreas) -> [f64; 3] {
        let at_places = |kind: &&[AreaOptics]| -> Vec<AreaOptics> {
            self.places.iter().map(|place| AreaOptics::sum(kind, &place.shares)).collect()
        };
        let kinds: Vec<Vec<AreaOptics>> = lit.kinds.iter().map(at_places).collect();
        let kinds: Vec<&[AreaOptics]> = kinds.iter().map(Vec::as_slice).collect();
        let albedos: Vec<f64> = self.places.iter().map(|place| place.albedo).collect();
        let nm = self.eye.wavelengths_nm();
        let closely = LitAreas { kinds: &kinds, albedos: &albedos, wavelengths_nm: nm, ..*lit };
        let weights = lit.emitted.and_then(|light| light.brightened.emission(&self.eye, nm));
        weights.map_or([0.0; 3], |weights| weights.xyz(&closely.emitted_parts()))
    }

    /// [`PaperBetween::beyond`] where what the paper emits is a part of factors like others.
    fn beyond_factors(&self, lit: &LitAreas) -> [f64; 3] {
        let LitAreas { mix, kinds, emitted, wavelengths_nm, .. } = *lit;
        let of_wavelengths = EmittedLight::of(emitted, wavelengths_nm);
        let of_places = EmittedLight::of(emitted, self.eye.wavelengths_nm());
        let difference = |(place, emitted): (&PaperPlace, &Vec<f64>)| {
            let areas: Vec<AreaOptics> =
                kinds.iter().map(|kind| AreaOptics::sum(kind, &place.shares)).collect();
            let mut smooth = vec![0.0; of_wavelengths.first().map_or(0, Vec::len)];
            for &(i, share) in &place.shares {
                smooth.iter_mut().zip(&of_wavelengths[i]).for_each(|(sum, emitted)| *sum += share * emitted);
            }
            mix.factor(&areas, place.albedo, emitted) - mix.factor(&areas, place.smooth, &smooth)
        };
        let differences: Vec<f64> = self.places.iter().zip(&of_places).map(difference).collect();
        self.eye.xyz(&differences).unwrap_or([f64::NAN; 3])
    }
}
