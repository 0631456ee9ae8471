//! A composed layer on its paper from every direction, for its picture and for renderers.
//!
//! Flux matrices give the BRDF at the nodes, and Lagrange polynomials between them. Mirrored light,
//! which oblique nodes hold beside the diffuse light, is taken off: it is a beam. The reflectance
//! of all light also goes through the beam at 0°, and has the fringes of the coherent light.
//! Everything is a mean over the azimuth between the planes of light and view.

use super::distribution::projected_sr;
use super::layer::{ComposedLayer, OnPaper, polarised, ratio};
use super::level::{Change, Level, Slabs, SolvedPortion};
use super::numbers::LayerTask;
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::fringes::Lobes;
use crate::appearance::composed::stack::PlateStack;
use crate::appearance::paper::MirroredSky;
use crate::appearance::picture::InkPicture;
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::appearance::viewing::ColourError;
use crate::evaluate::directional::{Direction, DirectionalPrint, Disagreement, interpolated};
use crate::evaluate::ink::InkError;
use crate::input::study::Study;
use crate::numerics::interpolate::lagrange;
use crate::wave::Wave;
use faer::Mat;
use std::f64::consts::PI;

/// Step of the table against the angle, degrees, and its last one.
const STEP_DEG: f64 = 1.0;
const STEPS: usize = 89;

/// A composed layer of one thickness on its paper.
#[derive(Clone, Debug)]
pub struct ComposedView {
    wavelengths_nm: Vec<f64>,
    /// \[wavelength\]: the medium in front.
    media: Vec<Hemisphere>,
    /// \[wavelength\]: BRDF at the nodes, row by row of the view; then R of a uniform sky's light
    /// and its mirrored part, step by step.
    numbers: Vec<Vec<f64>>,
}

impl ComposedView {
    /// The layer of this thickness, µm.
    ///
    /// # Errors
    /// A portion without complete realisations, paper without an albedo.
    pub fn new(study: &Study, solved: &[SolvedPortion], thickness_um: f64) -> Result<Self, String> {
        let task = LayerTask::new(study)?;
        let level =
            Level::complete(study, solved, false).ok_or("not every slab has a complete realisation yet")?;
        let wavelengths_nm = study.wavelengths_nm.clone();
        if let Some(stack) = &task.stack {
            let stacks = stack.stacks(&level, thickness_um, Change::default())?;
            let numbers = |(stack, albedo): (&PlateStack, &f64)| {
                let film = stack.film(false);
                table_of(&ComposedLayer::of_stack(stack, &film, study.wave), study.wave, *albedo)
            };
            return Ok(Self {
                wavelengths_nm,
                media: stacks.iter().map(|stack| stack.before().clone()).collect(),
                numbers: stacks.iter().zip(&task.albedos).map(numbers).collect(),
            });
        }
        let slabs = level.slabs(Change::default());
        let numbers = |(slabs, albedo): (&Slabs, &f64)| {
            let layer = ComposedLayer::new(slabs, task.slab_count(thickness_um), study.wave);
            table_of(&layer, study.wave, *albedo)
        };
        Ok(Self {
            wavelengths_nm,
            media: slabs.iter().map(|slabs| slabs.media[0].clone()).collect(),
            numbers: slabs.iter().zip(&task.albedos).map(numbers).collect(),
        })
    }

    /// The picture as thin layers have it: see [`crate::appearance::picture`].
    ///
    /// # Errors
    /// Wavelengths that carry no colour.
    pub fn picture(&self, angles_deg: &[f64], sky: MirroredSky) -> Result<InkPicture, ColourError> {
        let seen = visible(&self.wavelengths_nm);
        let eye = Colorimeter::new(&self.wavelengths_nm[seen.clone()])?;
        let colour =
            |quantity: &dyn Fn(usize) -> f64| eye.colour(&seen.clone().map(quantity).collect::<Vec<_>>());
        let mirrored = f64::from(u8::from(sky == MirroredSky::Included));
        let all = |w: usize, deg: f64| self.diffuse_albedo(w, deg) + mirrored * self.specular(w, deg);
        let square = |o: usize, i: usize| {
            let view = Direction { polar_deg: angles_deg[o], azimuth_deg: 0.0 };
            colour(&|w| PI * self.brdf(w, angles_deg[i], view).max(0.0))
        };
        InkPicture::new(angles_deg, |o| colour(&|w| all(w, angles_deg[o])), square)
    }

    /// R of a uniform sky's light, and its mirrored part.
    fn tabulated(&self, wavelength: usize, polar_deg: f64) -> [f64; 2] {
        let table = &self.numbers[wavelength][self.media[wavelength].ordinates.count().pow(2)..];
        interpolated(table.as_chunks().0, polar_deg / STEP_DEG)
    }

    /// Nodes in light or view of a direction, with their shares.
    fn shares(&self, wavelength: usize, polar_deg: f64) -> Vec<(usize, f64)> {
        let ordinates = &self.media[wavelength].ordinates;
        ordinates.shares(ordinates.index * polar_deg.to_radians().sin())
    }
}

impl DirectionalPrint for ComposedView {
    fn wavelengths_nm(&self) -> &[f64] {
        &self.wavelengths_nm
    }

    fn brdf(&self, wavelength: usize, light_deg: f64, view: Direction) -> f64 {
        let count = self.media[wavelength].ordinates.count();
        let lit = self.shares(wavelength, light_deg);
        let viewed = self.shares(wavelength, view.polar_deg);
        let row = |&(o, share): &(usize, f64)| -> f64 {
            lit.iter().map(|(i, lit_share)| share * lit_share * self.numbers[wavelength][o * count + i]).sum()
        };
        viewed.iter().map(row).sum()
    }

    fn specular(&self, wavelength: usize, polar_deg: f64) -> f64 {
        self.tabulated(wavelength, polar_deg)[1]
    }

    fn diffuse_albedo(&self, wavelength: usize, polar_deg: f64) -> f64 {
        let [all, mirrored] = self.tabulated(wavelength, polar_deg);
        all - mirrored
    }

    /// What the polynomials between the nodes change, and interference between the slabs.
    fn disagreement(&self, polar_deg: f64) -> Result<Vec<Disagreement>, InkError> {
        let mut all = Vec::new();
        for (w, medium) in self.media.iter().enumerate() {
            let count = medium.ordinates.count();
            let lit = self.shares(w, polar_deg);
            let brdf =
                |o: usize| -> f64 { lit.iter().map(|(i, s)| s * self.numbers[w][o * count + i]).sum() };
            let albedo: f64 = (0..count).map(|o| brdf(o) * projected_sr(medium, o)).sum();
            all.push(Disagreement::unknown_error(albedo - self.diffuse_albedo(w, polar_deg)));
        }
        Ok(all)
    }
}

/// The BRDF at the nodes and the table of a layer.
fn table_of(layer: &ComposedLayer, wave: Wave, albedo: f64) -> Vec<f64> {
    let before = layer.media[0];
    let paper = layer.on(albedo);
    let mut all = at_nodes(before, layer, &paper, wave);
    let light = polarised(before, wave);
    let directions = 0..=before.ordinates.escaping();
    let cosines: Vec<f64> =
        [1.0].into_iter().chain(directions.clone().skip(1).map(|d| before.ordinates.cosine(d - 1))).collect();
    let fluxes = [&paper.plate.reflection[0], &layer.plate.reflection[0], &layer.plate.transmission[0]];
    let totals: Vec<[f64; 3]> =
        directions.map(|d| fluxes.map(|fluxes| column_sum(fluxes, before, d, &light))).collect();
    // at 0° it is known without the bias of few realisations
    let bias = layer.plate.reflection[0][(0, 0)] + layer.change_of_beam().reflected - layer.mirrored(0.0);
    for step in 0..=STEPS {
        let angle = (STEP_DEG * step as f64).to_radians();
        let cosine = angle.cos();
        let sine = before.ordinates.index * angle.sin();
        let weights = lagrange(&cosines, cosine);
        let mean = |k: usize| weights.iter().zip(&totals).map(|(w, x)| w * x[k]).sum::<f64>();
        let all_light = mean(0);
        let alone = Lobes { reflected: mean(1), transmitted: mean(2) };
        let changed = alone.changed(layer.change_of_interpolated(sine));
        let passes = ratio(changed.transmitted, alone.transmitted);
        let returned = passes * paper.returned * paper.leaving * (all_light - alone.reflected);
        let whole = changed.reflected + returned;
        all.extend([whole, (layer.mirrored(sine) + bias).min(whole).max(0.0)]);
    }
    all
}

/// All flux that light of direction `d` causes.
fn column_sum(fluxes: &Mat<f64>, medium: &Hemisphere, d: usize, light: &[f64]) -> f64 {
    let columns = light.iter().enumerate().map(|(p, share)| (share, fluxes.col(medium.state(d, p))));
    columns.map(|(share, column)| share * column.iter().sum::<f64>()).sum()
}

/// Diffuse BRDF at the nodes, row by row of the view, 1/sr.
fn at_nodes(medium: &Hemisphere, layer: &ComposedLayer, paper: &OnPaper, wave: Wave) -> Vec<f64> {
    let light = polarised(medium, wave);
    let alone = &layer.plate.reflection[0];
    let on_paper = &paper.plate.reflection[0];
    let beam = |node: usize, p: usize| match node < medium.ordinates.escaping() {
        true => layer.mirrored_incoherently(medium.ordinates.sines[node], p),
        false => 0.0,
    };
    let passes: Vec<f64> = (0..medium.ordinates.count())
        .map(|node| {
            let sum = |fluxes: &Mat<f64>| column_sum(fluxes, medium, node + 1, &light);
            let composed = Lobes { reflected: sum(alone), transmitted: sum(&layer.plate.transmission[0]) };
            let changed = composed.changed(layer.change(medium.ordinates.sines[node]));
            ratio(changed.transmitted, composed.transmitted)
        })
        .collect();
    let nodes = 0..medium.ordinates.count();
    let mut all = Vec::new();
    for (to, from) in nodes.clone().flat_map(|to| nodes.clone().map(move |from| (to, from))) {
        let mut flux = 0.0;
        for (p, share) in light.iter().enumerate() {
            let from_p = medium.state(from + 1, p);
            let into = |fluxes: &Mat<f64>| -> f64 {
                (0..medium.polarisations).map(|q| fluxes[(medium.state(to + 1, q), from_p)]).sum()
            };
            let returned = passes[to] * passes[from] * paper.returned * (into(on_paper) - into(alone));
            let mirrored = if to == from { beam(to, p) } else { 0.0 };
            flux += share * (into(alone) - mirrored + returned).max(0.0);
        }
        all.push(flux / projected_sr(medium, to));
    }
    all
}
