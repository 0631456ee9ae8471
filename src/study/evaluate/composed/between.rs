//! What fringes do between the wavelengths of a composed layer, which alone are solved.
//!
//! An estimate from even films of the layers' indices in which light fades as the mean wave does.
//! The phase of the layer's own fringes is known less well than its amplitude: films a quarter of a
//! fringe apart tell what any phase may do.

use crate::appearance::film::Film;
use crate::appearance::tristimulus::Guide;
use crate::evaluate::quantities::LayerNumbers;
use crate::wave::maxwell::Polarisation;
use crate::wave::{Side, Wave};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::Range;

/// Most wavelengths at which films are followed, and their least distance, nm: fringes of 20 µm are
/// 5 nm apart.
const MOST_PLACES: f64 = 1000.0;
const STEP_NM: f64 = 1.0;
/// Least share of the coherent light that counts.
const FAINT: f64 = 1e-30;
/// Angle of the light of instruments, degrees.
const LIT_DEG: f64 = 45.0;

/// One layer as an even film.
#[derive(Clone, Debug)]
pub(super) struct FilmLayer {
    /// Its index at every wavelength of the study.
    pub indices: Vec<f64>,
    /// Its thickness, µm.
    pub thickness_um: f64,
}

/// Even films in place of the layers, between air and a medium.
#[derive(Clone, Debug)]
pub(super) struct FilmStack {
    /// The layers from the front.
    pub layers: Vec<FilmLayer>,
    /// Index behind them.
    pub index_out: f64,
    /// The wave.
    pub wave: Wave,
    /// Whether natural light lacks what the layer mirrors.
    pub excludes_mirrored: bool,
}

/// What interference changes of a layer's numbers, at its wavelengths and between them, for films a
/// quarter of a fringe apart.
#[derive(Clone, Debug)]
pub(super) struct Fringes {
    wavelengths_nm: Vec<f64>,
    fine_nm: Vec<f64>,
    listed: [Vec<LayerNumbers<f64>>; 2],
    fine: [Vec<LayerNumbers<f64>>; 2],
}

/// A place between two wavelengths: the first of them and the way to the second, 0 to 1.
type WayBetween = (usize, f64);

impl FilmStack {
    /// Of a layer with these numbers at these wavelengths; `None` of a single wavelength and of
    /// nothing.
    pub fn fringes(&self, wavelengths_nm: &[f64], rows: &[LayerNumbers<f64>]) -> Option<Fringes> {
        let first = *wavelengths_nm.first()?;
        let last = *wavelengths_nm.last()?;
        if last <= first || self.thickness_um() <= 0.0 || rows.len() != wavelengths_nm.len() {
            return None;
        }
        let steps = ((last - first) / STEP_NM).ceil().min(MOST_PLACES);
        let fine_nm: Vec<f64> =
            (0..=steps as usize).map(|k| first + (last - first) * k as f64 / steps).collect();
        let faded: Vec<f64> = (0..rows.len())
            .map(|k| {
                let clear = 1.0 - self.swings(wavelengths_nm[k], (k, 0.0), 0.0).even[0];
                (rows[k].coherent_transmittance / clear).clamp(FAINT, 1.0).ln()
            })
            .collect();
        let changes = |nm: f64| {
            let place = place(wavelengths_nm, nm);
            let row =
                rows[place.0].zipped(rows[(place.0 + 1).min(rows.len() - 1)], |a, b| a + place.1 * (b - a));
            let swings = self.swings(nm, place, between(&faded, place));
            [0, 1].map(|quarter| swings.changes(&row, quarter, self.excludes_mirrored))
        };
        let all = |nm: &[f64]| {
            let (zero, quarter) = nm.iter().map(|nm| changes(*nm)).map(|[a, b]| (a, b)).unzip();
            [zero, quarter]
        };
        Some(Fringes {
            listed: all(wavelengths_nm),
            fine: all(&fine_nm),
            wavelengths_nm: wavelengths_nm.to_vec(),
            fine_nm,
        })
    }

    fn thickness_um(&self) -> f64 {
        self.layers.iter().map(|layer| layer.thickness_um).sum()
    }

    /// R of the films at 0° and 45°, of which a passage leaves the share exp(`faded`).
    fn swings(&self, nm: f64, place: WayBetween, faded: f64) -> Swings {
        let um = 1e-3 * nm;
        let indices: Vec<f64> = self.layers.iter().map(|layer| between(&layer.indices, place)).collect();
        let way: f64 = indices.iter().zip(&self.layers).map(|(n, layer)| n * layer.thickness_um).sum();
        let loss = -faded * um / (2.0 * TAU * self.thickness_um());
        let films = [0.0, 1.0, 2.0, 3.0].map(|quarters| Film {
            squared_indices: indices.iter().map(|n| Complex64::new(*n, loss).powi(2)).collect(),
            // an eighth of a wavelength more, to and fro
            layers_um: self
                .layers
                .iter()
                .map(|layer| layer.thickness_um * (1.0 + quarters * um / (8.0 * way)))
                .collect(),
            wavelength_um: um,
            index_out: self.index_out,
        });
        let polarisations: &[Polarisation] = match self.wave {
            Wave::Scalar | Wave::S => &[Polarisation::S],
            Wave::P => &[Polarisation::P],
            Wave::Unpolarised => &[Polarisation::S, Polarisation::P],
        };
        let reflected = |film: &Film, deg: f64| {
            let of = |light: &Polarisation| film.reflectance_transmittance(Side::Incident, deg, *light).0;
            polarisations.iter().map(of).sum::<f64>() / polarisations.len() as f64
        };
        let all = films.each_ref().map(|film| [0.0, LIT_DEG].map(|deg| reflected(film, deg)));
        let even = [0, 1].map(|angle| all.iter().map(|film| film[angle]).sum::<f64>() / 4.0);
        Swings { by: [0, 1].map(|film| [0, 1].map(|angle| all[film][angle] - even[angle])), even }
    }
}

/// R of films at one wavelength, at 0° and 45°.
struct Swings {
    /// Without fringes.
    even: [f64; 2],
    /// What fringes add, of two films a quarter of a fringe apart.
    by: [[f64; 2]; 2],
}

impl Swings {
    /// What one film's fringes change of a layer's numbers: what is mirrored does not enter.
    fn changes(&self, row: &LayerNumbers<f64>, film: usize, excludes_mirrored: bool) -> LayerNumbers<f64> {
        let [at_0, at_45] = self.by[film];
        let [enters_0, enters_45] = [0, 1].map(|angle| -self.by[film][angle] / (1.0 - self.even[angle]));
        let in_and_out = enters_0 + enters_45;
        let mirrored = if excludes_mirrored { 0.0 } else { row.reflectance_normal };
        let from_paper = (row.natural_light - mirrored).max(0.0);
        LayerNumbers {
            reflectance_normal: at_0,
            transmittance_normal: enters_0 * row.transmittance_normal,
            reflectance_45: at_45,
            transmittance_45: enters_45 * row.transmittance_45,
            coherent_transmittance: enters_0 * row.coherent_transmittance,
            mirrored: at_0,
            natural_light: if excludes_mirrored { 0.0 } else { at_0 } + enters_0 * from_paper,
            lit_at_45: in_and_out * row.lit_at_45,
            over_black: in_and_out * row.over_black,
            over_white: in_and_out * row.over_white,
            ..LayerNumbers::default()
        }
    }
}

impl Fringes {
    /// Of a print at 45:0 of which the layers cover this share: of the solid's fringes that share.
    pub fn of_print(&self, seen: Range<usize>, share: f64) -> [Guide; 2] {
        self.guides(seen, |row| share * row.lit_at_45)
    }

    /// Of a spectrum at some of the wavelengths, for films a quarter of a fringe apart.
    pub fn guides(&self, seen: Range<usize>, spectrum: impl Fn(&LayerNumbers<f64>) -> f64) -> [Guide; 2] {
        let listed_nm = &self.wavelengths_nm[seen.clone()];
        let [first, last] = [listed_nm[0], listed_nm[listed_nm.len() - 1]];
        let within: Vec<usize> =
            (0..self.fine_nm.len()).filter(|&k| (first..=last).contains(&self.fine_nm[k])).collect();
        [0, 1].map(|film| Guide {
            on_grid: self.listed[film][seen.clone()].iter().map(&spectrum).collect(),
            fine_nm: within.iter().map(|&k| self.fine_nm[k]).collect(),
            fine: within.iter().map(|&k| spectrum(&self.fine[film][k])).collect(),
        })
    }
}

fn place(wavelengths_nm: &[f64], nm: f64) -> WayBetween {
    let k = wavelengths_nm.partition_point(|listed| *listed <= nm).clamp(1, wavelengths_nm.len() - 1) - 1;
    let [from, to] = [wavelengths_nm[k], wavelengths_nm[k + 1]];
    (k, (nm - from) / (to - from))
}

fn between(values: &[f64], (k, way): WayBetween) -> f64 {
    values[k] + way * (values[(k + 1).min(values.len() - 1)] - values[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::tristimulus::Colorimeter;

    const INDEX: f64 = 1.48;
    const UM: f64 = 5.0;

    /// R of a film in air (Airy).
    fn airy(nm: f64) -> f64 {
        let r = (1.0 - INDEX) / (1.0 + INDEX);
        let turn = Complex64::from_polar(1.0, 2.0 * TAU * INDEX * UM / (1e-3 * nm));
        (r * (1.0 - turn) / (1.0 - r * r * turn)).norm_sqr()
    }

    /// Of a clear film whose fringes are as far apart as the wavelengths, the films tell what the
    /// sum over these misses: .045 of Y. *Planted*: films without light that comes back; the films
    /// a whole fringe apart.
    #[test]
    fn what_wavelengths_miss_of_fringes_is_found() {
        let nm: Vec<f64> = (0..16).map(|k| 400.0 + 20.0 * f64::from(k)).collect();
        let rows: Vec<LayerNumbers<f64>> = nm
            .iter()
            .map(|nm| {
                let reflectance_normal = airy(*nm);
                let passed = 1.0 - reflectance_normal;
                LayerNumbers {
                    reflectance_normal,
                    transmittance_normal: passed,
                    coherent_transmittance: passed,
                    ..LayerNumbers::default()
                }
            })
            .collect();
        let film = |index: f64| FilmStack {
            layers: vec![FilmLayer { indices: vec![index; nm.len()], thickness_um: UM }],
            index_out: 1.0,
            wave: Wave::Scalar,
            excludes_mirrored: false,
        };
        let eye = Colorimeter::new(&nm).unwrap();
        let fine: Vec<f64> = (0..301).map(|k| 400.0 + f64::from(k)).collect();
        let of = |nm: &[f64]| {
            let values: Vec<f64> = nm.iter().map(|nm| airy(*nm)).collect();
            Colorimeter::new(nm).unwrap().xyz(&values).unwrap()[1]
        };
        let off = (of(&nm) - of(&fine)).abs();
        assert!(off > 3.0, "{off}");
        // the own index, and one whose fringes have another phase
        for index in [INDEX, INDEX + 0.02] {
            let fringes = film(index).fringes(&nm, &rows).unwrap();
            let guides = fringes.guides(0..nm.len(), |row| row.reflectance_normal);
            let told = guides.each_ref().map(|guide| eye.missed_luminance(guide));
            let told = told[0].hypot(told[1]);
            // light fades a little where T is low by a fringe; another index, another distance
            assert!((0.7 * off..2.0 * off).contains(&told), "{index}: {told} {off}");
        }
        // light that does not come back has no fringes
        let faint: Vec<LayerNumbers<f64>> =
            rows.iter().map(|row| LayerNumbers { coherent_transmittance: 1e-6, ..*row }).collect();
        let fringes = film(INDEX).fringes(&nm, &faint).unwrap();
        let [guide, _] = fringes.guides(0..nm.len(), |row| row.reflectance_normal);
        assert!(eye.missed_luminance(&guide).abs() < 1e-3);
    }
}
