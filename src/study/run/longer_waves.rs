//! Coarser grids for longer waves.
//!
//! The error of a grid with spacing h grows at least as V h², with V ∝ |η² − η_b²|/λ² (numerics,
//! order of the coverage), and as the phase k h. A wave longer than the shortest one therefore
//! allows a spacing larger by λ/λ₀, or by √(V₀/V) if that is less: the work per solve falls as
//! (λ₀/λ)³ in a clear ink. Two test solves at the longest wavelength check this.

use crate::input::study::{IndexSpectrum, Study, WantedResolution};
use crate::input::variation::stratified_deg;
use crate::solve::accuracy::smooth_size;
use crate::wave::{Incidence, Resolution, Side};
use serde::{Deserialize, Serialize};

/// Exponents of the coarsening, tried in this order; if none keeps the accuracy, the grid is not
/// coarsened.
pub(super) const SHARES: [f64; 3] = [1.0, 0.7, 0.4];

/// Steps of the coarsening per octave: wavelengths within one step share a coverage.
const STEPS: f64 = 4.0;

/// Largest |η² − η_b²|/λ² of the pigments in the binder, proportional to the contrast V, 1/nm².
pub(super) fn largest_contrast(study: &Study, nm: f64) -> f64 {
    let binders: Vec<_> = study.binders().iter().map(|binder| binder.index_at(1e-3 * nm)).collect();
    let contrast = |(material, layer): (&IndexSpectrum, usize)| {
        let eta = material.index_at(1e-3 * nm);
        let binder = binders[layer];
        ((eta * eta - binder * binder) / (nm * nm)).norm()
    };
    study.materials().zip(study.layers_of_materials()).map(contrast).fold(0.0, f64::max)
}

/// What needs the finest grid of a list of wavelengths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finest {
    /// Shortest vacuum wavelength, nm.
    pub shortest_nm: f64,
    /// Largest contrast at any of them, |η² − η_b²|/λ², 1/nm².
    pub contrast_per_nm2: f64,
}

impl Finest {
    /// Of a study's wavelengths.
    pub fn of(study: &Study) -> Self {
        let contrasts = study.wavelengths_nm.iter().map(|&nm| largest_contrast(study, nm));
        Self { shortest_nm: study.wavelengths_nm[0], contrast_per_nm2: contrasts.fold(0.0, f64::max) }
    }
}

/// The grid of the finest wave, coarsened for a longer one; `share` is the exponent of the
/// coarsening.
pub fn coarsened(
    study: &Study,
    grid: Resolution,
    wavelength_um: f64,
    finest: Finest,
    share: f64,
) -> Resolution {
    let factor = coarser(study, wavelength_um, finest, share);
    let fewer = |n: usize| (n as f64 / factor * (1.0 - 1e-9)).ceil() as usize;
    let points = |n: usize| if n == 1 { 1 } else { smooth_size(fewer(n)).min(n) };
    Resolution {
        nx: points(grid.nx),
        ny: points(grid.ny),
        cells: fewer(grid.cells).max(1),
        scheme: grid.scheme,
    }
}

/// Factor ≥ 1 by which the grid may be coarser than at the shortest wavelength.
fn coarser(study: &Study, wavelength_um: f64, finest: Finest, share: f64) -> f64 {
    if share == 0.0 {
        return 1.0;
    }
    let by_contrast = (finest.contrast_per_nm2 / largest_contrast(study, 1e3 * wavelength_um)).sqrt();
    let by_phase = 1e3 * wavelength_um / finest.shortest_nm;
    stepped(by_phase.min(by_contrast).max(1.0).powf(share))
}

/// Rounds down to a whole step; rounding errors do not select another step.
fn stepped(factor: f64) -> f64 {
    ((STEPS * factor.log2() + 1e-9).floor() / STEPS).exp2()
}

/// The smallest and the largest polar angle of the study, degrees.
pub(super) fn probed_angles_deg(study: &Study) -> [f64; 2] {
    let exact = &study.angles.exact_deg;
    let all = stratified_deg(study.angles.strata, 0.5).into_iter().chain(exact.iter().copied());
    [exact[0], all.fold(0.0, f64::max)]
}

/// The longest wavelength at the smallest and the largest angle, on one packing; empty if all waves
/// share a grid: on request, with a single wavelength, or without any contrast.
pub(super) fn probes(study: &Study, realisation: usize) -> Vec<Incidence> {
    let first = study.wavelengths_nm[0];
    let last = study.wavelengths_nm[study.wavelengths_nm.len() - 1];
    let allowed = matches!(study.resolution, WantedResolution::Accuracy { per_wavelength: true, .. });
    if !allowed || stepped(last / first) == 1.0 || largest_contrast(study, last) == 0.0 {
        return Vec::new();
    }
    let azimuth_deg = study.draw(realisation).azimuth_deg;
    let from = Side::Incident;
    let incidence = |polar_deg: f64| Incidence { wavelength_um: last * 1e-3, polar_deg, azimuth_deg, from };
    let mut probes = probed_angles_deg(study).map(incidence).to_vec();
    probes.dedup();
    probes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::check::check;
    use crate::input::file::StudyFile;
    use crate::wave::Scheme;
    use std::path::Path;

    fn study(pigment: &str, resolution: &str) -> Study {
        let text = format!(
            "title = 't'\n[layer]\nthickness_um = 0.5\nbinder.index = 1.5\n[[pigment]]\nname = 'p'\ndiameter_nm = 200\n\
             volume_fraction = 0.2\nindex = {pigment}\n[light]\nwavelengths_nm = [400, 450, 500, 600, 700]\n\
             [angles]\npolar_deg = [0, 40]\n[resolution]\n{resolution}\n"
        );
        let file: StudyFile = toml::from_str(&text).expect("a study file");
        check(&file, Path::new("."), "test").expect("a sound study")
    }

    const OWN: Resolution = Resolution { nx: 40, ny: 30, cells: 14, scheme: Scheme::Cubic };

    /// λ/λ₀ in a clear ink, rounded down to steps of 2^¼.
    #[test]
    fn a_clear_ink_allows_a_spacing_in_proportion_to_the_wavelength() {
        let study = study("1.9", "accuracy = 1e-3");
        let points = |nm: f64, share: f64| {
            let r = coarsened(&study, OWN, 1e-3 * nm, Finest::of(&study), share);
            (r.nx, r.ny, r.cells)
        };
        assert_eq!(points(400.0, 1.0), (40, 30, 14));
        assert_eq!(points(450.0, 1.0), (40, 30, 14), "not a step yet");
        // 600/400 is a little more than 2^(2/4), 700/400 a little more than 2^(3/4).
        assert_eq!(points(600.0, 1.0), (30, 24, 10));
        assert_eq!(points(700.0, 1.0), (24, 18, 9));
        assert_eq!(points(700.0, 0.4), (36, 27, 12));
        assert_eq!(points(700.0, 0.0), (40, 30, 14));
        assert_eq!(probes(&study, 0).len(), 2);
    }

    /// Where the pigment absorbs most, its contrast decides, however long the wave.
    #[test]
    fn the_largest_contrast_keeps_the_finest_grid() {
        let study = study("{ built_in = 'red' }", "accuracy = 1e-3");
        let nm = study.wavelengths_nm.iter().copied();
        let strongest =
            nm.max_by(|&a, &b| largest_contrast(&study, a).total_cmp(&largest_contrast(&study, b)));
        let strongest = strongest.expect("wavelengths");
        assert!(strongest > 450.0, "{strongest}");
        let finest = Finest::of(&study);
        assert_eq!(coarsened(&study, OWN, 1e-3 * strongest, finest, 1.0), OWN);
        assert!(coarsened(&study, OWN, 0.7, finest, 1.0).nx < OWN.nx);
    }

    #[test]
    fn one_grid_has_no_probes() {
        let clear = "1.9";
        assert!(probes(&study(clear, "accuracy = 1e-3\nper_wavelength = false"), 0).is_empty());
        assert!(probes(&study(clear, "accuracy = 1e-2"), 0).is_empty(), "it does not pay");
        assert!(probes(&study(clear, "points_per_um = 20\nplanes_per_um = 30"), 0).is_empty());
        assert!(probes(&study("1.5", "accuracy = 1e-3"), 0).is_empty(), "no contrast");
    }
}
