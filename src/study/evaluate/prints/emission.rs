//! Light that a brightened paper emits below the kinds of area of a print.

use crate::appearance::fluorescence::{CUT_NM, summed_nm, summed_powers};
use crate::appearance::paper_series::{AreaMix, AreaOptics};
use crate::appearance::tristimulus::{Colorimeter, EmissionWeights, visible};
use crate::appearance::viewing::{ColourError, Summation, Viewing};
use crate::input::measured::MeasuredCondition;
use crate::input::study::Paper;

/// A brightened paper under a light.
#[derive(Clone, Debug)]
pub struct Brightened {
    /// Wavelengths of the sum over excitation.
    grid_nm: Vec<f64>,
    albedos: Vec<f64>,
    light: Vec<f64>,
    matrix: Vec<Vec<f64>>,
    /// The light, where it has lines.
    lamp: Option<Viewing>,
}

/// What the paper below every kind of area emits, against wavelength.
pub struct EmittedLight<'a> {
    pub(super) brightened: &'a Brightened,
    /// \[wavelength\]\[kind of area\]
    emitted: Vec<Vec<f64>>,
}

impl Brightened {
    /// The paper under the light of an instrument, or under an illuminant; `None` if it does not
    /// fluoresce.
    ///
    /// # Errors
    /// An illuminant that is not known.
    pub fn under(
        paper: &Paper,
        wavelengths_nm: &[f64],
        condition: Option<MeasuredCondition>,
        illuminant: &Viewing,
    ) -> Result<Option<Self>, ColourError> {
        let of = |name: &str| Viewing::new(name, "2", Summation::Plain);
        let (lamp, cut_nm) = match condition {
            None => (illuminant.clone(), 0.0),
            Some(MeasuredCondition::M0) => (of("A")?, 0.0),
            Some(MeasuredCondition::M1) => (of("D50")?, 0.0),
            // polarised light has no ultraviolet either
            Some(MeasuredCondition::M2 | MeasuredCondition::M3) => (of("D50")?, CUT_NM),
        };
        Ok(Self::new(paper, wavelengths_nm, &lamp, cut_nm))
    }

    /// The paper under an illuminant, at wavelengths from below `cut_nm` of which there is no
    /// light; `None` if it does not fluoresce.
    pub fn new(paper: &Paper, wavelengths_nm: &[f64], viewing: &Viewing, cut_nm: f64) -> Option<Self> {
        let fluorescence = paper.fluorescence.as_ref()?;
        let grid_nm = summed_nm(*wavelengths_nm.first()?, *wavelengths_nm.last()?);
        let powers = grid_nm.iter().zip(summed_powers(viewing, &grid_nm));
        let albedo = |&nm: &f64| paper.albedo.at(nm).unwrap_or(f64::NAN);
        Some(Self {
            albedos: grid_nm.iter().map(albedo).collect(),
            light: powers.map(|(&nm, power)| if nm < cut_nm { 0.0 } else { power }).collect(),
            matrix: fluorescence.matrix(&grid_nm),
            grid_nm,
            lamp: viewing.has_lines().then(|| viewing.clone()),
        })
    }

    /// Powers of a lamp with lines that shares of emitted light at these wavelengths are over;
    /// `None` of smooth light.
    pub fn lamp_powers(&self, wavelengths_nm: &[f64]) -> Option<Vec<f64>> {
        Some(self.lamp.as_ref()?.mean_powers(wavelengths_nm))
    }

    /// How an eye under the same lamp with lines sums such shares at those of these wavelengths
    /// that it sees; `None` where they are parts of factors like others: of smooth light, and where
    /// the paper is excited by other light than the eye's.
    pub fn emission(&self, eye: &Colorimeter, wavelengths_nm: &[f64]) -> Option<EmissionWeights> {
        let lamp = self.lamp.as_ref()?;
        let powers = self.lamp_powers(wavelengths_nm)?;
        (lamp.illuminant() == eye.viewing().illuminant())
            .then(|| eye.emission(&powers[visible(wavelengths_nm)]))
    }

    /// What is emitted below kinds of area that are known at these wavelengths.
    pub fn below(&self, mix: &AreaMix, kinds: &[&[AreaOptics]], wavelengths_nm: &[f64]) -> EmittedLight<'_> {
        let at = |&nm: &f64| kinds.iter().map(|kind| AreaOptics::at(kind, wavelengths_nm, nm)).collect();
        let areas: Vec<Vec<AreaOptics>> = self.grid_nm.iter().map(at).collect();
        let emitted = mix.emitted(&areas, &self.albedos, &self.light, &self.matrix);
        EmittedLight { brightened: self, emitted }
    }
}

/// Kinds of area on a paper at 45:0, against wavelength.
#[derive(Clone, Copy)]
pub struct LitAreas<'a> {
    /// Their shares, and the spread of the light between them.
    pub mix: &'a AreaMix,
    /// \[kind of area\]\[wavelength\]
    pub kinds: &'a [&'a [AreaOptics]],
    /// Albedos of the paper.
    pub albedos: &'a [f64],
    /// What it emits besides, if it fluoresces.
    pub emitted: Option<&'a EmittedLight<'a>>,
    /// The wavelengths, nm, rising.
    pub wavelengths_nm: &'a [f64],
}

impl LitAreas<'_> {
    /// Radiance factors, with what the paper emits.
    pub fn factors(&self) -> Vec<f64> {
        let emitted = EmittedLight::of(self.emitted, self.wavelengths_nm);
        let factor = |(i, albedo): (usize, &f64)| {
            let areas: Vec<AreaOptics> = self.kinds.iter().map(|kind| kind[i]).collect();
            self.mix.factor(&areas, *albedo, &emitted[i])
        };
        self.albedos.iter().enumerate().map(factor).collect()
    }

    /// The parts of the factors that the paper emits.
    pub fn emitted_parts(&self) -> Vec<f64> {
        let dark = Self { emitted: None, ..*self };
        self.factors().into_iter().zip(dark.factors()).map(|(lit, dark)| lit - dark).collect()
    }

    /// X, Y, Z for an eye at those of the wavelengths that it sees; `emission` is how it sums what
    /// the paper emits under a lamp with lines ([`Brightened::emission`]).
    ///
    /// # Errors
    /// Factors that are no numbers.
    pub fn xyz(
        &self,
        eye: &Colorimeter,
        emission: Option<&EmissionWeights>,
    ) -> Result<[f64; 3], ColourError> {
        let seen = visible(self.wavelengths_nm);
        let Some(weights) = emission else { return eye.xyz(&self.factors()[seen]) };
        let dark = eye.xyz(&Self { emitted: None, ..*self }.factors()[seen.clone()])?;
        let emitted = weights.xyz(&self.emitted_parts()[seen]);
        Ok(std::array::from_fn(|c| dark[c] + emitted[c]))
    }
}

impl EmittedLight<'_> {
    /// [`EmittedLight::relative`], empty at every wavelength where nothing is emitted.
    pub(super) fn of(emitted: Option<&Self>, wavelengths_nm: &[f64]) -> Vec<Vec<f64>> {
        emitted.map_or(vec![Vec::new(); wavelengths_nm.len()], |light| light.relative(wavelengths_nm))
    }

    /// S_k/E at every wavelength of a list that a colour or a spectrum takes; nothing where there
    /// is no light to compare with. E is the light about each of them: colours under lamps with
    /// lines, where S is smooth, sum it without E ([`Brightened::emission`]).
    pub fn relative(&self, wavelengths_nm: &[f64]) -> Vec<Vec<f64>> {
        let means = self.brightened.lamp_powers(wavelengths_nm);
        let mean = |i: usize| means.as_ref().map(|means| means[i]);
        wavelengths_nm.iter().enumerate().map(|(i, &nm)| self.relative_to(nm, mean(i))).collect()
    }

    /// S_k/E at a wavelength, over this power or that of the light there.
    fn relative_to(&self, nm: f64, power: Option<f64>) -> Vec<f64> {
        let Brightened { grid_nm, light, .. } = self.brightened;
        let after = grid_nm.partition_point(|&x| x < nm).min(grid_nm.len().saturating_sub(1));
        let below =
            if grid_nm.get(after).is_some_and(|&x| x <= nm) { after } else { after.saturating_sub(1) };
        let (Some(from), Some(to)) = (grid_nm.get(below), grid_nm.get(after)) else { return Vec::new() };
        let share = if to > from { ((nm - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        let mix = |low: f64, high: f64| low + share * (high - low);
        let power = power.unwrap_or(mix(light[below], light[after]));
        let kinds = self.emitted[below].iter().zip(&self.emitted[after]);
        kinds.map(|(low, high)| if power > 0.0 { mix(*low, *high) / power } else { 0.0 }).collect()
    }
}
