//! Common setup of the discrete problems of one wavelength and direction: the scalar wave's and
//! Maxwell's; the mean medium ⟨k²⟩ of every cell, the deviation of the backgrounds from it, and the
//! cell heights it allows.

use crate::numerics::fourier::Harmonics;
use crate::wave::bloch::BlochVector;
use crate::wave::{Grid, Incidence, Layout, Media, Side, WaveError};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::sync::Arc;

/// One wavelength and direction on a grid.
pub struct Setting {
    /// The incident light.
    pub incidence: Incidence,
    /// Indices of all media.
    pub media: Media,
    /// Vacuum wavenumber 2π/λ, 1/µm.
    pub k0: f64,
    /// The harmonics in use: columns of a field.
    pub harmonics: Arc<Harmonics>,
    /// Lateral wavevectors of every harmonic, 1/µm: centred on zero.
    pub lateral: Vec<[f64; 2]>,
    /// Normal wavenumbers of every harmonic in the half-spaces (incident side, exit side), 1/µm.
    pub kappa: [Vec<Complex64>; 2],
    /// Compact index of the incident harmonic, which is the specular order.
    pub incident_harmonic: usize,
}

impl Setting {
    /// The setting, and the mean k̄² of every cell, 1/µm²; `normal` is the normal wavenumber for
    /// k0, the index of a half-space and a lateral wavevector.
    ///
    /// # Errors
    /// Lights that [`Incidence::check`] rejects, or incident through an absorber; a grid too coarse
    /// for the propagating orders or for the wavelength.
    pub(in crate::wave) fn new(
        layout: &Layout,
        harmonics: &Arc<Harmonics>,
        media: &Media,
        incidence: &Incidence,
        mean: Mean,
        normal: impl Fn(f64, Complex64, [f64; 2]) -> Complex64,
    ) -> Result<(Setting, Vec<Complex64>), WaveError> {
        incidence.check()?;
        let k0 = TAU / incidence.wavelength_um;
        let bloch = BlochVector::new(layout, media, incidence)?;
        bloch.check_orders(layout, media, k0)?;
        let lateral: Vec<[f64; 2]> = harmonics.orders.iter().map(|&o| bloch.lateral(o)).collect();
        let mean_k2 = mean_wavenumbers(layout, media, k0, mean);
        let [m, n] = bloch.incident;
        let incident_harmonic = harmonics.find(m, n).expect("the incident order propagates, so it is in use");
        let [x, y] = lateral[incident_harmonic];
        check_phase(layout, &mean_k2, x * x + y * y)?;
        let kappa = [media.incident, media.exit]
            .map(|eta| lateral.iter().map(|&lateral| normal(k0, eta, lateral)).collect());
        let harmonics = harmonics.clone();
        let incidence = *incidence;
        let media = media.clone();
        Ok((Setting { incidence, media, k0, harmonics, lateral, kappa, incident_harmonic }, mean_k2))
    }

    /// Normal wavenumber κ₀₀ in the half-space of incidence, 1/µm.
    pub fn incident_kappa(&self) -> f64 {
        self.kappa[self.entry_side()][self.incident_harmonic].re
    }

    /// Illuminated side: 0 at z = 0, 1 at z = H.
    pub fn entry_side(&self) -> usize {
        usize::from(self.incidence.from == Side::Exit)
    }
}

/// Largest phase k̄h of a cell with contrast: beyond it the moments no longer resolve the wave.
pub const PHASE_LIMIT: f64 = 2.9;

/// Choice of ⟨k²⟩. It belongs to the discretisation: all strategies for a problem share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mean {
    /// Whether ⟨k²⟩ is the average of each cell instead of the whole layer (P2, below (3.12)).
    pub depends_on_z: bool,
    /// Whether the imaginary part is included; relaxation needs a real ⟨k²⟩, with absorption in the
    /// contrast.
    pub absorbing: bool,
}

impl Default for Mean {
    fn default() -> Mean {
        Mean { depends_on_z: true, absorbing: true }
    }
}

/// Mean k̄² of every cell: k² of the background plus the contrasts weighted by coverage.
pub(super) fn mean_wavenumbers(layout: &Layout, media: &Media, k0: f64, mean: Mean) -> Vec<Complex64> {
    let grid = &layout.grid;
    let mut values: Vec<_> = (0..grid.cells()).map(|j| mean_wavenumber(layout, media, k0, j)).collect();
    if !mean.depends_on_z {
        let weighted = values.iter().enumerate().map(|(j, v)| v * grid.height_um(j)).sum::<Complex64>();
        values.fill(weighted / grid.nodes_um[grid.cells()]);
    }
    if !mean.absorbing {
        values.iter_mut().for_each(|v| v.im = 0.0);
    }
    values
}

/// Mean k̄² of one cell over the plane.
fn mean_wavenumber(layout: &Layout, media: &Media, k0: f64, cell: usize) -> Complex64 {
    let medium = layout.grid.background[cell];
    let square = |eta: Complex64| eta * eta * (k0 * k0);
    let background = square(media.backgrounds[medium]);
    let parts = layout.channels.iter().zip(&layout.fractions).filter(|(c, _)| c.background == medium);
    let contrasts = parts.map(|(c, f)| (square(media.index_of(c.material)) - background) * f[cell]);
    background + contrasts.sum::<Complex64>()
}

/// Moments of k²_background − ⟨k²⟩ on each plane, divided by the number of its points.
pub(super) fn plane_offsets(grid: &Grid, media: &Media, k0: f64, mean_k2: &[Complex64]) -> Vec<Complex64> {
    let mut offsets = vec![Complex64::default(); grid.planes()];
    for j in 0..grid.cells() {
        let shift = cell_offset(grid, media, k0, mean_k2, j);
        for (plane, weight) in grid.planes_of_cell(j).zip(&grid.element.weights) {
            offsets[plane] += shift * (grid.height_um(j) * weight / grid.points() as f64);
        }
    }
    offsets
}

/// k² of a cell's background less the mean, 1/µm².
pub(super) fn cell_offset(
    grid: &Grid,
    media: &Media,
    k0: f64,
    mean_k2: &[Complex64],
    cell: usize,
) -> Complex64 {
    let eta = media.backgrounds[grid.background[cell]] * k0;
    // A difference of the size of rounding is set to zero: homogeneous layers then need no
    // iteration at all.
    let raw = eta * eta - mean_k2[cell];
    if raw.norm() < 1e-14 * mean_k2[cell].norm() { Complex64::default() } else { raw }
}

/// Number of cells that the phase limit requires of a grid `other`, from k̄² of the cells of an
/// accepted grid.
pub(in crate::wave) fn cells_needed(grid: &Grid, means: &[Complex64], other: &Grid) -> usize {
    let cells = other.nodes_um.windows(2);
    let largest = cells.map(|ends| phase_between(grid, means, [ends[0], ends[1]])).fold(0.0, f64::max);
    let needed = (largest / PHASE_LIMIT * other.cells() as f64).ceil() as usize;
    if largest > PHASE_LIMIT { needed.max(other.cells() + 1) } else { other.cells() }
}

/// Phase k̄h between two heights, with k̄² averaged over the cells in between.
fn phase_between(grid: &Grid, means: &[Complex64], [lo, hi]: [f64; 2]) -> f64 {
    let common = |i: usize| (grid.nodes_um[i + 1].min(hi) - grid.nodes_um[i].max(lo)).max(0.0);
    let sum: Complex64 = (0..grid.cells()).map(|i| means[i] * common(i)).sum();
    (sum / (hi - lo)).sqrt().re * (hi - lo)
}

/// Rejects cells too high for the wave: with contrast by accuracy, without it only near kz h = mπ.
pub(super) fn check_phase(layout: &Layout, mean_k2: &[Complex64], lateral_k2: f64) -> Result<(), WaveError> {
    let grid = &layout.grid;
    let exact = layout.channels.is_empty();
    for (j, &k2) in mean_k2.iter().enumerate() {
        let h = grid.height_um(j);
        let phase = (if exact { k2 - lateral_k2 } else { k2 }).sqrt().re * h;
        let near_pole =
            exact && (k2 - lateral_k2).im.abs() * h < 1e-3 && phase > 1.0 && phase.sin().abs() < 1e-5;
        let needed = (phase / PHASE_LIMIT * grid.cells() as f64).ceil() as usize;
        if near_pole || (!exact && phase > PHASE_LIMIT) {
            let needed = needed.max(grid.cells() + 1);
            return Err(WaveError::CellTooHigh { cell: j, height_um: h, phase, limit: PHASE_LIMIT, needed });
        }
    }
    Ok(())
}
