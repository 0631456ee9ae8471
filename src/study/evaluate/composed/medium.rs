//! What the medium of a composed layer is to light: its mean wave, its transport coefficients, and
//! Kubelka and Munk's K and S, from the slabs within the layer.

use super::level::Slabs;
use crate::appearance::composed::transport::{Transport, extinction_per_um, two_flux};
use crate::evaluate::quantities::MediumNumbers;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// What the medium of the slabs is to light. NaN for what these realisations do not determine.
pub(super) fn medium_numbers(slabs: &Slabs, slab_um: f64) -> MediumNumbers<f64> {
    let medium = &slabs.media[1];
    let transport = Transport::of_slab(&slabs.inner, medium, slab_um);
    let of_transport = |get: fn(&Transport) -> f64| transport.as_ref().map_or(f64::NAN, get);
    let munk = two_flux(&slabs.inner, medium, slab_um);
    let index = mean_wave_index(slabs, slab_um);
    // Diffuse light is counted in the half-spaces. Of the same radiance, a medium of index n holds
    // light in proportion to n²: it absorbs so much more, and so much more passes a thick layer.
    let more = (index / medium.ordinates.index).powi(2);
    MediumNumbers {
        effective_index: index,
        coherent_path_um: extinction_per_um(&slabs.inner, slab_um).map_or(f64::NAN, f64::recip),
        scattering_per_um: of_transport(|t| t.scattering_per_um),
        absorption_per_um: of_transport(|t| t.absorption_per_um),
        asymmetry: of_transport(|t| t.asymmetry),
        transport_path_um: of_transport(Transport::mean_free_path_um),
        kubelka_munk_absorption_per_um: munk.map_or(f64::NAN, |m| m.absorption_per_um / more),
        kubelka_munk_scattering_per_um: munk.map_or(f64::NAN, |m| m.scattering_per_um * more),
    }
}

/// Index of the mean wave at 0°: that of the half-spaces, and what the wave's phase behind an inner
/// slab is beyond theirs.
fn mean_wave_index(slabs: &Slabs, slab_um: f64) -> f64 {
    let embedding = slabs.media[1].ordinates.index;
    let wavenumber = TAU / slabs.film.wavelength_um;
    let even = Complex64::from_polar(1.0, wavenumber * embedding * slab_um);
    // of an inner slab lit from in front at 0°, for each polarisation: transmitted
    let passed = &slabs.film.slabs[1][0][0];
    let phases = passed.iter().map(|[_, transmitted]| (transmitted / even).arg());
    embedding + phases.sum::<f64>() / passed.len() as f64 / (wavenumber * slab_um)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::composed::level::tests::{even_plate, slabs_of};

    /// Slabs of the same fluxes whose mean wave has another index than their half-spaces: of the
    /// same radiance they hold n² times the light, so that K is smaller and S larger by that.
    /// *Planted*: K and S counted in the half-spaces.
    #[test]
    fn kubelka_and_munk_count_light_in_the_medium() {
        let of_index = |index: f64| {
            let mut slabs = slabs_of(even_plate(0.0, 1.0), even_plate(0.2, 0.7), even_plate(0.0, 1.0));
            let passed = Complex64::from_polar(0.5, TAU / slabs.film.wavelength_um * index);
            slabs.film.slabs[1][0] = vec![vec![[Complex64::ZERO, passed]]];
            medium_numbers(&slabs, 1.0)
        };
        let [alike, denser] = [of_index(1.5), of_index(1.65)];
        assert!((denser.effective_index - 1.65).abs() < 1e-12, "{}", denser.effective_index);
        let square = (1.65_f64 / 1.5).powi(2);
        let scattering = denser.kubelka_munk_scattering_per_um / alike.kubelka_munk_scattering_per_um;
        let absorption = denser.kubelka_munk_absorption_per_um / alike.kubelka_munk_absorption_per_um;
        // the fluxes are the same: rounding
        assert!((scattering - square).abs() < 1e-12, "{scattering}");
        assert!((absorption - 1.0 / square).abs() < 1e-12, "{absorption}");
    }
}
