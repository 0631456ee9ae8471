//! A composed layer of one thickness, alone and on paper: the fluxes of its slabs, and what
//! interference of the coherent light changes.
//!
//! Light from the paper meets the layer from the exit side. Of diffuse light R̄_b comes back and
//! T̄_b passes, and between the layer and a paper of albedo ρ it is the geometric series g = ρ/(1 −
//! ρ R̄_b). Interference changes what enters, what comes back and what leaves. T̄_b follows from T̄
//! of light from in front by reciprocity, and R̄_b = 1 − T̄_b − Ā_b: on a perfect white a layer
//! without absorption loses nothing.

use super::level::Slabs;
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::fringes::stack_film::StackFilm;
use crate::appearance::composed::fringes::{Interference, Lobes};
use crate::appearance::composed::plate::{Plate, total};
use crate::appearance::composed::stack::PlateStack;
use crate::wave::Wave;
use faer::Mat;

/// A layer of one thickness, or a stack of layers, at one wavelength.
pub struct ComposedLayer<'a> {
    /// Media in front and behind.
    pub media: [&'a Hemisphere; 2],
    /// Its fluxes, without interference between the surfaces.
    pub plate: Plate,
    /// What interference does to light from in front, for each polarisation.
    interference: Vec<Interference<'a>>,
    /// Shares of the polarisations in the light.
    polarised: Vec<f64>,
    /// What interference changes of diffuse light from in front, for each polarisation.
    change_of_diffuse: Vec<Lobes>,
    /// Sums of unpolarised diffuse light from behind.
    change_from_behind: Lobes,
}

/// The layer on a Lambertian paper.
pub struct OnPaper {
    /// Fluxes without interference between the surfaces.
    pub plate: Plate,
    /// What interference does to the series of returns, as a factor of g.
    pub returned: f64,
    /// What it does to the diffuse light that leaves the paper, as a factor of T̄_b.
    pub leaving: f64,
    /// R̄_b with interference.
    pub back: f64,
    /// Ā_b with interference.
    pub absorbed: f64,
}

impl<'a> ComposedLayer<'a> {
    /// A layer of this many slabs, at least two and not always a whole number.
    pub fn new(slabs: &'a Slabs, count: f64, wave: Wave) -> Self {
        let plate = slabs.layer(count);
        let [before, _, behind] = &slabs.media;
        let of_polarisation = |p: usize| slabs.film.interference(count, p, &columns(&plate, 0, before, p));
        let interference = (0..before.polarisations).map(of_polarisation).collect();
        let turned = slabs.film.turned();
        let change_from_behind = mean(&unpolarised(behind), |p| {
            turned.interference(count, p, &columns(&plate, 1, behind, p)).change_of_diffuse()
        });
        Self::of([before, behind], plate, interference, change_from_behind, wave)
    }

    /// A stack of layers; `film` is the mean wave in it.
    pub fn of_stack(stack: &'a PlateStack, film: &'a StackFilm, wave: Wave) -> Self {
        let plate = stack.plate();
        let (before, behind) = (stack.before(), stack.behind());
        let of_polarisation = |p: usize| film.interference(p, &columns(&plate, 0, before, p));
        let interference = (0..before.polarisations).map(of_polarisation).collect();
        let turned = film.turned();
        let change_from_behind = mean(&unpolarised(behind), |p| {
            turned.interference(p, &columns(&plate, 1, behind, p)).change_of_diffuse()
        });
        Self::of([before, behind], plate, interference, change_from_behind, wave)
    }

    fn of(
        media: [&'a Hemisphere; 2],
        plate: Plate,
        interference: Vec<Interference<'a>>,
        change_from_behind: Lobes,
        wave: Wave,
    ) -> Self {
        Self {
            media,
            change_of_diffuse: interference.iter().map(Interference::change_of_diffuse).collect(),
            change_from_behind,
            interference,
            polarised: polarised(media[0], wave),
            plate,
        }
    }

    /// R and T of light with these fluxes in the states in front, without interference.
    pub fn of_light(&self, light: &Mat<f64>) -> Lobes {
        let reflected = total(&(&self.plate.reflection[0] * light));
        let transmitted = total(&(&self.plate.transmission[0] * light));
        Lobes { reflected, transmitted }
    }

    /// What interference changes of R and T at 0° or at a node, by its lateral wavenumber.
    pub fn change(&self, sine: f64) -> Lobes {
        mean(&self.polarised, |p| self.interference[p].change(sine))
    }

    /// What it changes of R and T of light that is shared among the nodes.
    pub fn change_of_shared(&self, sine: f64) -> Lobes {
        mean(&self.polarised, |p| self.interference[p].change_of_shared(sine))
    }

    /// What it changes of R and T that are interpolated between 0° and the nodes.
    pub fn change_of_interpolated(&self, sine: f64) -> Lobes {
        mean(&self.polarised, |p| self.interference[p].change_of_interpolated(sine))
    }

    /// T of light with this lateral wavenumber, shared among the nodes, without interference.
    pub fn transmitted_by_nodes(&self, sine: f64) -> f64 {
        let before = self.media[0];
        let node = |node: usize, p: usize| -> f64 {
            self.plate.transmission[0].col(before.state(node + 1, p)).iter().sum()
        };
        let shares = before.ordinates.shares(sine).into_iter();
        let transmitted = |(index, share): (usize, f64)| {
            self.polarised.iter().enumerate().map(|(p, part)| part * share * node(index, p)).sum::<f64>()
        };
        shares.map(transmitted).sum()
    }

    /// What it changes of R and T of diffuse light.
    pub fn change_of_diffuse(&self) -> Lobes {
        mean(&self.polarised, |p| self.change_of_diffuse[p])
    }

    /// What it changes of the beam at 0°.
    pub fn change_of_beam(&self) -> Lobes {
        mean(&self.polarised, |p| self.interference[p].change_of_beam())
    }

    /// Shares of the light with this lateral wavenumber that the mean field mirrors, with
    /// interference and without it.
    pub fn mirrored(&self, sine: f64) -> f64 {
        self.polarised.iter().zip(&self.interference).map(|(s, fringes)| s * fringes.mirrored(sine)[0]).sum()
    }

    /// As [`ComposedLayer::mirrored`] without interference, for one polarisation.
    pub fn mirrored_incoherently(&self, sine: f64, polarisation: usize) -> f64 {
        self.interference[polarisation].mirrored(sine)[1]
    }

    /// The layer on paper of this albedo.
    pub fn on(&self, albedo: f64) -> OnPaper {
        let [before, behind] = self.media;
        let plate = self.plate.then(&Plate::lambertian(albedo, &behind.weights()));
        let onto = self.diffuse(0);
        // light from the paper has no polarisation
        let change = mean(&unpolarised(before), |p| self.change_of_diffuse[p]);
        let leaving = ratio(onto.changed(change).transmitted, onto.transmitted);
        let behind = self.diffuse(1);
        let returned = returns(behind, self.change_from_behind, leaving, albedo);
        let back = reflected_behind(behind, self.change_from_behind, leaving);
        let absorbed = (1.0 - back - behind.transmitted * leaving).max(0.0);
        OnPaper { plate, returned, leaving, back, absorbed }
    }

    /// R̄ and T̄ of unpolarised diffuse light from a side, without interference.
    fn diffuse(&self, side: usize) -> Lobes {
        let weights = self.media[side].weights();
        let sum: f64 = weights.iter().sum();
        let mean = |m: &Mat<f64>| -> f64 {
            (0..weights.len()).map(|j| weights[j] / sum * m.col(j).iter().sum::<f64>()).sum()
        };
        Lobes {
            reflected: mean(&self.plate.reflection[side]),
            transmitted: mean(&self.plate.transmission[side]),
        }
    }
}

/// Factor of g = ρ/(1 − ρ R̄_b): `composed` is R̄_b and T̄_b without interference, which changes
/// T̄_b by the factor `leaving` and the sum of both by that of `change`.
fn returns(composed: Lobes, change: Lobes, leaving: f64, albedo: f64) -> f64 {
    let reflected = reflected_behind(composed, change, leaving);
    ratio(1.0 - albedo * composed.reflected, 1.0 - albedo * reflected)
}

/// R̄_b with interference.
fn reflected_behind(composed: Lobes, change: Lobes, leaving: f64) -> f64 {
    let not_absorbed = composed.reflected + composed.transmitted + change.reflected + change.transmitted;
    let passed = composed.transmitted * leaving;
    (not_absorbed.min(1.0) - passed).clamp(0.0, 1.0)
}

/// The quotient; 1 of nothing.
pub fn ratio(changed: f64, composed: f64) -> f64 {
    let quotient = changed / composed;
    if quotient.is_finite() { quotient } else { 1.0 }
}

/// A mean over polarisations.
fn mean(shares: &[f64], lobes: impl Fn(usize) -> Lobes) -> Lobes {
    let present = shares.iter().enumerate().filter(|(_, share)| **share > 0.0);
    present.fold(Lobes::default(), |sum, (p, share)| sum.plus(*share, lobes(p)))
}

/// R and T of light from a side at 0° and at all nodes.
fn columns(plate: &Plate, side: usize, medium: &Hemisphere, polarisation: usize) -> Vec<Lobes> {
    let lobes = |direction: usize| {
        let state = medium.state(direction, polarisation);
        let sum = |m: &Mat<f64>| m.col(state).iter().sum::<f64>();
        Lobes { reflected: sum(&plate.reflection[side]), transmitted: sum(&plate.transmission[side]) }
    };
    (0..=medium.ordinates.count()).map(lobes).collect()
}

/// Equal shares of the polarisations.
fn unpolarised(medium: &Hemisphere) -> Vec<f64> {
    vec![1.0 / medium.polarisations as f64; medium.polarisations]
}

/// Shares of the polarisations in the light.
pub fn polarised(medium: &Hemisphere, wave: Wave) -> Vec<f64> {
    match wave {
        Wave::Scalar => vec![1.0],
        Wave::S => vec![1.0, 0.0],
        Wave::P => vec![0.0, 1.0],
        Wave::Unpolarised => vec![0.5; medium.polarisations],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A layer that mirrors 0.4 and passes 0.5 of diffuse light from the paper, absorbs 0.1, and
    /// by interference passes a fifth less and absorbs 0.02 less: R̄_b = 0.52. *Planted*: the
    /// change with the other sign.
    #[test]
    fn the_series_of_returns_takes_what_interference_sends_back() {
        let composed = Lobes { reflected: 0.4, transmitted: 0.5 };
        let change = Lobes { reflected: 0.11, transmitted: -0.09 };
        let factor = returns(composed, change, 0.8, 0.9);
        let series = |back: f64| (0..400).map(|k| 0.9 * (0.9 * back).powi(k)).sum::<f64>();
        assert!((factor - series(0.52) / series(0.4)).abs() < 1e-12, "{factor}");
        // a white paper and a layer without absorption: g T̄_b is 1 with and without interference
        let clear = Lobes { reflected: 0.4, transmitted: 0.6 };
        let factor = returns(clear, Lobes::default(), 0.8, 1.0);
        assert!((factor * 0.8 - 1.0).abs() < 1e-12);
    }
}
