//! Colours of light that a surface emits: its spectrum is smooth, whatever the lines of the lamp
//! that excites it, and so is summed with the weights of the observer alone.

use super::{Colorimeter, RawWeights, weighted_sum};

/// Weights of X, Y, Z at the wavelengths of a colorimeter for light that a surface emits.
#[derive(Clone, Debug, PartialEq)]
pub struct EmissionWeights(Vec<[f64; 3]>);

impl Colorimeter {
    /// Weights of emitted light that is given over these powers of the illuminant at the
    /// wavelengths, as parts of factors are: the powers cancel, and so do the illuminant's lines.
    ///
    /// ```
    /// use inkwave_physics::appearance::tristimulus::Colorimeter;
    /// use inkwave_physics::appearance::viewing::{Summation, Viewing};
    /// let lamp = Viewing::new("F11", "2", Summation::Plain)?;
    /// let nm: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
    /// let meter = Colorimeter::under(&nm, &lamp)?;
    /// // the same radiance over other powers is the same light
    /// let ones = meter.emission(&[1.0; 31]).xyz(&[0.5; 31]);
    /// let twos = meter.emission(&[2.0; 31]).xyz(&[0.25; 31]);
    /// assert_eq!(ones, twos);
    /// # Ok::<(), inkwave_physics::appearance::viewing::ColourError>(())
    /// ```
    pub fn emission(&self, powers: &[f64]) -> EmissionWeights {
        let observer = self.viewing.in_even_light();
        let RawWeights { step_nm, raw, .. } = RawWeights::new(&self.wavelengths_nm, &self.viewing, &observer);
        let scale = self.scale_per_nm * step_nm;
        EmissionWeights(raw.iter().zip(powers).map(|(row, power)| row.map(|x| scale * power * x)).collect())
    }
}

impl EmissionWeights {
    /// X, Y, Z of what is emitted, over the powers.
    pub fn xyz(&self, emitted: &[f64]) -> [f64; 3] {
        weighted_sum(&self.0, emitted)
    }

    /// The weights, wavelength by wavelength.
    pub fn rows(&self) -> &[[f64; 3]] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::viewing::{Summation, Viewing};

    /// A band of emitted light under lamps is, in steps up to 10 nm, the sum of observer times
    /// radiance over every nm. *Planted*: the powers not cancelled, another observer.
    #[test]
    fn emitted_light_is_summed_without_the_lines_of_the_lamp() {
        let band = |nm: f64| (-0.5 * ((nm - 450.0) / 25.0).powi(2)).exp();
        for (name, observer) in [("F2", "2"), ("F11", "10"), ("F12", "2"), ("LED_V1", "2015_10")] {
            let lamp = Viewing::new(name, observer, Summation::Plain).unwrap();
            let row = |light: &Viewing, nm: u32| light.row(nm as usize);
            let white: f64 = (380..=730).map(|nm| row(&lamp, nm)[1]).sum();
            let even = lamp.in_even_light();
            let truth: [f64; 3] = std::array::from_fn(|c| {
                (380..=730).map(|nm| row(&even, nm)[c] * band(f64::from(nm))).sum::<f64>() * 100.0 / white
            });
            for step in [5_u32, 10] {
                let nm: Vec<f64> = (380..=730_u32).step_by(step as usize).map(f64::from).collect();
                let powers = lamp.mean_powers(&nm);
                let factors: Vec<f64> = nm.iter().zip(&powers).map(|(nm, power)| band(*nm) / power).collect();
                let xyz = Colorimeter::under(&nm, &lamp).unwrap().emission(&powers).xyz(&factors);
                for (have, want) in xyz.iter().zip(truth) {
                    // order: cubic interpolation over 10 nm of a band of σ = 25 nm
                    assert!((have / want - 1.0).abs() < 1e-3, "{name} {step}: {xyz:?} {truth:?}");
                }
            }
        }
    }

    /// Where the light has no lines and every wavelength counts directly, the part of a factor
    /// weighs what the factor weighs.
    #[test]
    fn under_smooth_light_emission_weighs_as_factors_do() {
        let nm: Vec<f64> = (0..31).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
        let meter = Colorimeter::new(&nm).unwrap();
        let powers: Vec<f64> = nm.iter().map(|nm| meter.viewing().power(*nm)).collect();
        let values: Vec<f64> = nm.iter().map(|nm| 0.001 * nm).collect();
        let plain = meter.xyz(&values).unwrap();
        for (have, want) in meter.emission(&powers).xyz(&values).iter().zip(plain) {
            assert!((have / want - 1.0).abs() < 1e-12, "{have} {want}");
        }
    }
}
