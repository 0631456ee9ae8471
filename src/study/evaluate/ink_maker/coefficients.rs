//! Kubelka–Munk coefficients of an ensemble, with errors.

use super::super::ink::InkOnPaper;
use super::super::on_paper::LayerOnPaper;
use super::super::uncertainty::{Shift, Uncertainty};
use crate::appearance::kubelka_munk::KubelkaMunk;
use crate::numerics::estimate::Estimate;
use serde::Serialize;

/// Kubelka–Munk coefficients at one wavelength.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct KubelkaMunkRow {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// K, 1/µm.
    pub absorption_per_um: Estimate,
    /// S, 1/µm.
    pub scattering_per_um: Estimate,
}

/// R̄ and T̄ of the layer alone, the diffuse fluxes that the paper exchanges with it, moved by errors.
fn fluxes(layer: &LayerOnPaper, [r, t]: Shift) -> Shift {
    [layer.mean_reflectance_exit() + r, layer.mean_transmittance() + t]
}

/// K and S at every wavelength that tells them.
pub(super) fn kubelka_munk(
    ink: &InkOnPaper,
    uncertainty: &Uncertainty,
    thickness_um: f64,
) -> Vec<KubelkaMunkRow> {
    let part = |get| Coefficient { thickness_um, get }.estimates(ink, uncertainty);
    let (k, s) = (part(|km| km.absorption_per_um), part(|km| km.scattering_per_um));
    let rows = ink.wavelengths_nm().iter().zip(k.into_iter().zip(s));
    let row = |(&wavelength_nm, (absorption_per_um, scattering_per_um)): (&f64, (Estimate, Estimate))| {
        KubelkaMunkRow { wavelength_nm, absorption_per_um, scattering_per_um }
    };
    // Where hardly any light comes through, T is within its error of none: K and S are anything.
    let known = |e: &Estimate| e.value.is_finite() && e.standard_error.is_none_or(f64::is_finite);
    rows.map(row).filter(|row| known(&row.absorption_per_um) && known(&row.scattering_per_um)).collect()
}

/// K or S of a layer of known thickness.
struct Coefficient {
    thickness_um: f64,
    get: fn(KubelkaMunk) -> f64,
}

impl Coefficient {
    /// At every wavelength, with all errors.
    fn estimates(&self, ink: &InkOnPaper, uncertainty: &Uncertainty) -> Vec<Estimate> {
        let estimates = ink.spectrum(|layer| self.continued(layer, [0.0; 2])).estimates().into_iter();
        estimates.zip(ink.layers()).map(|(e, layer)| self.estimate(layer, e, uncertainty)).collect()
    }

    /// At one wavelength, where the continuation is `continued` by chance.
    fn estimate(&self, layer: &LayerOnPaper, continued: Estimate, uncertainty: &Uncertainty) -> Estimate {
        let moved = |by: Shift| self.continued(layer, by) - continued.value;
        let errors = uncertainty.widen_by(continued, |[r, t]| worse(moved([r, t]), moved([r, -t])));
        Estimate { value: self.value(layer), ..errors }
    }

    /// The coefficient itself, no number where R̄ and T̄ have none.
    fn value(&self, layer: &LayerOnPaper) -> f64 {
        let [r, t] = fluxes(layer, [0.0; 2]);
        KubelkaMunk::from_layer(r, t, self.thickness_um).map_or(f64::NAN, self.get)
    }

    /// Its continuation, moved by errors of R and T: where K stops at 0 its spread would stop too.
    fn continued(&self, layer: &LayerOnPaper, by: Shift) -> f64 {
        let [r, t] = fluxes(layer, by);
        KubelkaMunk::continued(r, t, self.thickness_um).map_or(f64::NAN, self.get)
    }
}

/// The larger one, or no number. The signs of errors of R and T are unknown: S is the more wrong where they differ, as they do
/// where nothing is absorbed, K where they agree.
fn worse(alike: f64, opposite: f64) -> f64 {
    if alike.is_nan() || alike.abs() > opposite.abs() { alike } else { opposite }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::paper::{Albedo, Coupling, PRINT_DEG, Substrate};
    use crate::evaluate::film::Profile;
    use crate::evaluate::films::Films;
    use crate::evaluate::ink::InkInputs;
    use crate::evaluate::ink::tests::made_up::{MadeUp, RANGE_NM};
    use crate::evaluate::layer::LayerEnsemble;
    use crate::evaluate::wavelengths::SpectralBasis;
    use crate::numerics::Draws;
    use crate::numerics::estimate::coverage_factor_95;
    use crate::numerics::sequence::Sequence;
    use crate::solve::accuracy::grid_error::GridError;
    use crate::wave::Wave;

    /// Absorptance of the made-up layer, and its deviation from realisation to realisation: the mean of four is twice as uncertain
    /// as it is large, so that noise takes it below 0 in three studies of ten.
    const ABSORBED: [f64; 2] = [0.001, 0.004];
    const REALISATIONS: usize = 4;
    const SEEDS: u64 = 150;

    /// A scattering layer that hardly absorbs: what it lacks in T it sends back.
    fn ink(made: &MadeUp, realisations: usize, absorbed: [f64; 2], seed: u64) -> InkOnPaper {
        let mut draws = Draws::new(seed, 5);
        let sequence = Sequence::<2>::new(seed);
        let mut solved: Vec<_> =
            (0..realisations).map(|r| made.realisation(sequence.point(r), || draws.normal())).collect();
        for realisation in &mut solved {
            let absorbed = absorbed[0] + absorbed[1] * draws.normal();
            for solve in
                realisation.wavelengths.iter_mut().flat_map(|w| w.exact.iter_mut().chain(&mut w.strata))
            {
                solve.absorptance = absorbed;
                solve.reflectance = 1.0 - solve.transmittance - absorbed;
            }
        }
        let basis = SpectralBasis::Splines { range_nm: RANGE_NM, intervals: made.wavelengths };
        let layer = LayerEnsemble::new(&solved, basis, &made.films, &[0.0, PRINT_DEG]);
        let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
        let inputs = InkInputs {
            films: &made.films,
            substrate: &substrate,
            outputs_nm: &[430.0, 520.0, 610.0, 670.0],
        };
        InkOnPaper::new((layer, &solved), None, &inputs).unwrap()
    }

    /// Shares of intervals that hold the truth: of K and of S.
    fn covered(seeds: &[Vec<[Estimate; 2]>], truth: &[[Estimate; 2]], factor: f64) -> [f64; 2] {
        let inside = |i: usize| {
            let all = seeds.iter().flat_map(|rows| rows.iter().zip(truth));
            let holds = |(own, truth): (&[Estimate; 2], &[Estimate; 2])| {
                (own[i].value - truth[i].value).abs() <= factor * own[i].standard_error.unwrap()
            };
            all.map(holds).filter(|holds| *holds).count() as f64 / (seeds.len() * truth.len()) as f64
        };
        [inside(0), inside(1)]
    }

    /// *Planted*: replicates whose K stops at 0, and the normal law's 1.96 in place of Student's factor, are noticed.
    #[test]
    fn intervals_of_few_realisations_hold_k_and_s() {
        let clear = |_: f64| (num_complex::Complex64::from(1.5), Vec::new());
        let films = || Films {
            profile: Profile::homogeneous(),
            indices: &clear,
            thicknesses_um: vec![1.0],
            index_out: 1.0,
            wave: Wave::Scalar,
        };
        let made = MadeUp { films: films(), strata: 3, wavelengths: 10, noise: 0.01 };
        let exact = MadeUp { films: films(), strata: 12, wavelengths: 10, noise: 0.0 };
        let sure =
            Uncertainty { grid: GridError::default(), residual: 0.0, missing_cells: 0.0, certain: false };
        let rows = |ink: &InkOnPaper| -> Vec<[Estimate; 2]> {
            let rows = kubelka_munk(ink, &sure, 1.0);
            rows.iter().map(|row| [row.absorption_per_um, row.scattering_per_um]).collect()
        };
        let truth = rows(&ink(&exact, 24, [ABSORBED[0], 0.0], 1));
        let inks: Vec<InkOnPaper> = (0..SEEDS).map(|seed| ink(&made, REALISATIONS, ABSORBED, seed)).collect();
        let seeds: Vec<_> = inks.iter().map(rows).collect();
        let student = coverage_factor_95(REALISATIONS - 1).unwrap();
        let [k, s] = covered(&seeds, &truth, student);
        let stopped = |ink: &InkOnPaper| -> Vec<[Estimate; 2]> {
            let of = |layer: &LayerOnPaper| {
                let [r, t] = fluxes(layer, [0.0; 2]);
                KubelkaMunk::from_layer(r, t, 1.0).unwrap()
            };
            let part = |get: fn(KubelkaMunk) -> f64| ink.spectrum(|layer| get(of(layer))).estimates();
            let (k, s) = (part(|km| km.absorption_per_um), part(|km| km.scattering_per_um));
            k.into_iter().zip(s).map(|(k, s)| [k, s]).collect()
        };
        let [stopped, _] = covered(&inks.iter().map(stopped).collect::<Vec<_>>(), &truth, student);
        let normal = covered(&seeds, &truth, 1.96);
        println!("held: K {k:.3}, S {s:.3}; K that stops at 0 {stopped:.3}; normal law's {normal:.3?}");
        // Significance: 95 % of 150 studies scatter by 1.8 %, wavelengths of one study belong together; K at 0 may be held more often.
        assert!((0.90..=1.0).contains(&k) && (0.90..=0.995).contains(&s), "{k} {s}");
        assert!(stopped < 0.90 && normal[1] < 0.92, "the check is empty: {stopped} {normal:?}");
    }

    /// Errors of R and T with unknown signs: in a layer without absorption they are opposite, and S errs by both.
    #[test]
    fn opposite_errors_of_r_and_t_do_not_cancel_in_s() {
        let s = |r: f64, t: f64| KubelkaMunk::continued(r, t, 1.0).unwrap().scattering_per_um;
        let (r, t, e) = (0.3, 0.7, 1e-3);
        let [alike, opposite] = [s(r + e, t + e), s(r + e, t - e)].map(|x| x - s(r, t));
        assert!(
            opposite.abs() > 1.5 * alike.abs() && worse(alike, opposite) == opposite,
            "{alike} {opposite}"
        );
        assert!(worse(f64::NAN, 1.0).is_nan() && worse(1.0, f64::NAN).is_nan());
    }
}
