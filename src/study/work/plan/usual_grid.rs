//! The grid that a study is likely to get, where none has been searched.

use crate::input::study::{Study, WantedResolution};
use crate::solve::accuracy::smooth_size;
use crate::wave::Resolution;

/// Points and planes per wavelength in the densest medium for an error of 1e-2, as found by
/// searches on inks of 30 %.
const PER_WAVE: [f64; 2] = [4.5, 8.0];

/// The grid of the first realisation: as requested, or the one that the accuracy is likely to need.
pub(super) fn usual_grid(study: &Study) -> Resolution {
    let scheme = study.resolution.scheme();
    let [points_per_um, planes_per_um] = match study.resolution {
        WantedResolution::Grid { points_per_um, planes_per_um, .. } => [points_per_um, planes_per_um],
        WantedResolution::Accuracy { amplitude, .. } => {
            let waves = densest(study) / (1e-3 * study.wavelengths_nm[0]);
            let finer = (1e-2 / amplitude).max(1.0);
            [PER_WAVE[0] * finer.powf(0.25) * waves, PER_WAVE[1] * finer.powf(0.2) * waves]
        }
    };
    let draw = study.draw(0);
    let points = |um: f64| smooth_size((points_per_um * um).ceil() as usize);
    let [nx, ny] = if study.pigments.is_empty() { [1, 1] } else { draw.period_um.map(points) };
    let cells = (planes_per_um * draw.thickness_um / scheme.degree() as f64).ceil().max(1.0) as usize;
    Resolution { nx, ny, cells, scheme }
}

/// Largest |η| of all media at the shortest wavelength.
fn densest(study: &Study) -> f64 {
    study.indices(1e-3 * study.wavelengths_nm[0]).into_iter().map(|eta| eta.norm()).fold(1.0, f64::max)
}
