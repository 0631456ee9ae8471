//! The numbers of a composed layer, as one list: what is published, before its error bars.

use super::layer::{ComposedLayer, OnPaper, polarised, ratio};
use super::level::{Change, Level, Slabs};
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::plate::{Plate, total};
use crate::appearance::composed::transport::{Transport, extinction_per_um, two_flux};
use crate::appearance::paper::{MirroredSky, PRINT_DEG};
use crate::appearance::tristimulus::Colorimeter;
use crate::evaluate::ink_maker::{BLACK, WHITE};
use crate::input::study::{Composed, Study};
use crate::wave::Wave;
use faer::Mat;
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// Quantities of a layer at one wavelength.
pub const SPECTRAL: usize = 12;
/// Numbers of a layer's colours.
pub const COLOURS: usize = 10;
/// Coefficients of the medium at one wavelength.
pub const COEFFICIENTS: usize = 8;
/// Contrast ratio that counts as hiding.
pub const HIDING: f64 = 0.98;
/// Most slabs of a layer that is tried for hiding.
pub const MOST_SLABS: usize = 1024;

/// Which number of the list one is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberPlace {
    /// One quantity of one thickness at all wavelengths.
    pub series: usize,
    /// Which wavelength; 0 for numbers of all wavelengths together.
    pub wavelength: usize,
}

/// What is asked of the slabs of either thickness.
pub struct LayerTask<'a> {
    /// The study.
    pub study: &'a Study,
    /// Its composed layer.
    pub composed: &'a Composed,
    /// Albedos of the paper at every wavelength.
    pub albedos: Vec<f64>,
    /// The eye, where the wavelengths carry a colour.
    pub colorimeter: Option<Colorimeter>,
    /// Thicknesses, µm: those asked for, the curve's, and two around the hiding thickness if there
    /// is one.
    pub thicknesses_um: Vec<f64>,
    /// Whether the last two thicknesses lie around the one that hides.
    pub hides: bool,
}

impl<'a> LayerTask<'a> {
    /// What a study asks of its composed layer.
    ///
    /// # Errors
    /// A layer that is not composed, paper without an albedo.
    pub fn new(study: &'a Study) -> Result<Self, String> {
        let composed = study.composed().ok_or("the layer is not composed")?;
        let albedo = |&nm: &f64| study.paper.albedo.at(nm).map_err(|error| error.to_string());
        Ok(Self {
            study,
            composed,
            albedos: study.wavelengths_nm.iter().map(albedo).collect::<Result<_, _>>()?,
            colorimeter: Colorimeter::new(&study.wavelengths_nm).ok(),
            thicknesses_um: composed.thicknesses_um.clone(),
            hides: false,
        })
    }

    /// All numbers: of each thickness its spectral quantities and its colours; the coefficients of
    /// each wavelength; the distributions of each thickness asked for and wavelength; the thickness
    /// that hides.
    pub fn numbers(&self, level: &Level, change: Change) -> Vec<f64> {
        let slabs = level.slabs(change);
        let per_h = (self.composed.slab_um / level.slab_um).round();
        let (mut numbers, mut contrasts) = (Vec::new(), Vec::new());
        for &thickness_um in &self.thicknesses_um {
            let rows = self.rows(&slabs, thickness_um, per_h);
            numbers.extend(rows.iter().flatten());
            if self.colorimeter.is_some() {
                let colours = self.colours(&rows).unwrap_or_else(|| vec![f64::NAN; COLOURS]);
                contrasts.push(colours[COLOURS - 1]);
                numbers.extend(colours);
            }
        }
        numbers.extend(slabs.iter().flat_map(|slabs| coefficients(slabs, level.slab_um)));
        for &thickness_um in &self.composed.thicknesses_um {
            let count = self.slab_count(thickness_um) * per_h;
            numbers.extend(slabs.iter().flat_map(|slabs| distribution(slabs, count)));
        }
        if self.hides {
            numbers.push(self.hiding_um(&contrasts));
        }
        numbers
    }

    /// What each of the [numbers](Self::numbers) is, in their order.
    pub fn places(&self, slabs: &[Slabs]) -> Vec<NumberPlace> {
        let (mut all, mut first) = (Vec::new(), 0);
        let at = |first: usize, wavelength: usize, quantities: usize| {
            (0..quantities).map(move |k| NumberPlace { series: first + k, wavelength })
        };
        for _ in &self.thicknesses_um {
            all.extend((0..slabs.len()).flat_map(|w| at(first, w, SPECTRAL)));
            first += SPECTRAL;
            if self.colorimeter.is_some() {
                all.extend(at(first, 0, COLOURS));
                first += COLOURS;
            }
        }
        all.extend((0..slabs.len()).flat_map(|w| at(first, w, COEFFICIENTS)));
        first += COEFFICIENTS;
        for _ in &self.composed.thicknesses_um {
            let nodes = |w: usize| slabs[w].media[0].ordinates.count() + slabs[w].media[2].ordinates.count();
            all.extend((0..slabs.len()).flat_map(|w| at(first, w, nodes(w))));
            first += (0..slabs.len()).map(nodes).max().unwrap_or(0);
        }
        all.extend(at(first, 0, usize::from(self.hides)));
        all
    }

    /// Quantities of a thickness at every wavelength; `per_h` of the slabs have the thickness h.
    fn rows(&self, slabs: &[Slabs], thickness_um: f64, per_h: f64) -> Vec<Vec<f64>> {
        let count = self.slab_count(thickness_um) * per_h;
        let of = |(slabs, albedo): (&Slabs, &f64)| spectral(slabs, count, self.study, *albedo);
        slabs.iter().zip(&self.albedos).map(of).collect()
    }

    /// Slabs of h in a thickness: a whole number but for rounding, or any.
    pub(super) fn slab_count(&self, thickness_um: f64) -> f64 {
        let count = thickness_um / self.composed.slab_um;
        if (count - count.round()).abs() < 1e-9 * count { count.round() } else { count }
    }

    /// Lab under natural light, at 45:0 and at 45:0 over black, and the contrast ratio.
    fn colours(&self, rows: &[Vec<f64>]) -> Option<Vec<f64>> {
        let eye = self.colorimeter.as_ref()?;
        let of = |k: usize| eye.colour(&rows.iter().map(|row| row[k]).collect::<Vec<_>>()).ok();
        let [natural, lit, black, white] = [of(8)?, of(9)?, of(10)?, of(11)?];
        let mut all = [natural.lab, lit.lab, black.lab].concat();
        all.push(black.xyz[1] / white.xyz[1]);
        Some(all)
    }

    /// Whether a layer of this number of slabs hides.
    pub fn does_hide(&self, slabs: &[Slabs], count: usize) -> Option<bool> {
        let rows = self.rows(slabs, count as f64 * self.composed.slab_um, 1.0);
        Some(self.colours(&rows)?[COLOURS - 1] >= HIDING)
    }

    /// Where the contrast ratio passes what counts as hiding; 1 less it falls as an exponential.
    fn hiding_um(&self, contrasts: &[f64]) -> f64 {
        let [.., a, b] = contrasts else { return f64::NAN };
        let [below, above] = [a, b].map(|c| (1.0 - c).max(f64::MIN_POSITIVE).ln());
        let [.., from, to] = self.thicknesses_um[..] else { return f64::NAN };
        from + (to - from) * ((1.0 - HIDING).ln() - below) / (above - below)
    }
}

/// R and T at 0°, at 45° and of diffuse light; coherent T and mirrored R at 0°; under natural light
/// and at 45:0 on the paper; at 45:0 over black and over white.
fn spectral(slabs: &Slabs, count: f64, study: &Study, albedo: f64) -> Vec<f64> {
    let before = &slabs.media[0];
    let layer = ComposedLayer::new(slabs, count, study.wave);
    let oblique = before.ordinates.index * PRINT_DEG.to_radians().sin();
    let [at_normal, at_45, of_diffuse] = lights(before, study.wave);
    let (normal, slanted, diffuse) =
        (layer.of_light(&at_normal), layer.of_light(&at_45), layer.of_light(&of_diffuse));
    let normal_changed = normal.changed(layer.change(0.0));
    let slanted_changed = slanted.changed(layer.change_of_shared(oblique));
    let diffuse_changed = diffuse.changed(layer.change_of_diffuse());
    let mut all: Vec<f64> = Vec::with_capacity(SPECTRAL);
    for own in [normal_changed, slanted_changed, diffuse_changed] {
        all.extend([own.reflected, own.transmitted]);
    }
    let beam = layer.change_of_beam();
    let straight = layer.plate.transmission[0][(0, 0)] + beam.transmitted;
    let mirrored = layer.plate.reflection[0][(0, 0)] + beam.reflected;
    let mirrored = mirrored.max(0.0).min(normal_changed.reflected);
    all.extend([straight.max(0.0).min(normal_changed.transmitted), mirrored]);
    // what returns from the paper has passed at 0°, and passes at 45°
    let through_normal = ratio(normal_changed.transmitted, normal.transmitted);
    let through_45 = ratio(slanted_changed.transmitted, layer.transmitted_by_nodes(oblique));
    let paper = layer.on(albedo);
    let returned = total(&(&paper.plate.reflection[0] * &at_normal)) - normal.reflected;
    let natural = normal_changed.reflected + through_normal * paper.returned * paper.leaving * returned;
    all.push(natural - if study.output.mirrored_sky == MirroredSky::Excluded { mirrored } else { 0.0 });
    let alone = lit_at_45(&layer.plate, before, study.wave);
    let lit = |on: &OnPaper| {
        let returned = lit_at_45(&on.plate, before, study.wave) - alone;
        alone + through_normal * through_45 * on.returned * returned
    };
    all.extend([lit(&paper), lit(&layer.on(BLACK)), lit(&layer.on(WHITE))]);
    all
}

/// BRDF and BTDF of light at 0° in the directions of the media in front and behind, per steradian.
/// The mirrored and the straight beam are left out, and what interference changes.
fn distribution(slabs: &Slabs, count: f64) -> Vec<f64> {
    let ([before, _, behind], layer) = (&slabs.media, slabs.layer(count));
    let of = |fluxes: &Mat<f64>, medium: &Hemisphere| {
        let flux =
            |node| (0..medium.polarisations).map(|p| fluxes[(medium.state(node + 1, p), 0)]).sum::<f64>();
        (0..medium.ordinates.count()).map(|node| flux(node) / projected_sr(medium, node)).collect::<Vec<_>>()
    };
    [of(&layer.reflection[0], before), of(&layer.transmission[0], behind)].concat()
}

/// Projected solid angle that a node stands for, ∫ cos θ dω, sr.
pub fn projected_sr(medium: &Hemisphere, node: usize) -> f64 {
    PI * medium.ordinates.weights[node] / medium.ordinates.index.powi(2)
}

/// Unit fluxes of light at 0°, at 45° and of diffuse light.
pub fn lights(medium: &Hemisphere, wave: Wave) -> [Mat<f64>; 3] {
    let shares = polarised(medium, wave);
    let mut all: [Mat<f64>; 3] = std::array::from_fn(|_| Mat::zeros(medium.states(), 1));
    all[0][(0, 0)] = 1.0;
    let (nodes, sum) = (medium.ordinates.count(), medium.ordinates.weights.iter().sum::<f64>());
    for (polarisation, share) in shares.into_iter().enumerate() {
        if medium.oblique_deg.is_some() {
            all[1][(medium.state(nodes + 1, polarisation), 0)] = share;
        }
        for node in 0..nodes {
            all[2][(medium.state(node + 1, polarisation), 0)] = share * medium.ordinates.weights[node] / sum;
        }
    }
    all
}

/// π × BRDF at 45:0, by reciprocity: light at 0° that leaves at 45°.
fn lit_at_45(plate: &Plate, medium: &Hemisphere, wave: Wave) -> f64 {
    let sine = medium.ordinates.index * PRINT_DEG.to_radians().sin();
    let shares = polarised(medium, wave);
    let at = |(node, share): (usize, f64)| {
        let flux = |p: usize| plate.reflection[0][(medium.state(node + 1, p), 0)];
        let own: f64 = shares.iter().enumerate().map(|(p, s)| shares.len() as f64 * s * flux(p)).sum();
        share * own / medium.ordinates.weights[node]
    };
    medium.ordinates.shares(sine).into_iter().map(at).sum()
}

/// Index of the mean wave; mean free path of the coherent light, k_s, k_a, g and l* of the medium
/// that the slabs are; K and S of thick layers without surfaces. NaN for what these realisations do
/// not determine.
fn coefficients(slabs: &Slabs, slab_um: f64) -> [f64; COEFFICIENTS] {
    let medium = &slabs.media[1];
    let coherent = extinction_per_um(&slabs.inner, slab_um).map_or(f64::NAN, f64::recip);
    let transport = Transport::of_slab(&slabs.inner, medium, slab_um);
    let of = |get: fn(&Transport) -> f64| transport.as_ref().map_or(f64::NAN, get);
    let munk = two_flux(&slabs.inner, medium, slab_um);
    let index = mean_wave_index(slabs, slab_um);
    // Diffuse light is counted in the half-spaces. Of the same radiance, a medium of index n holds
    // light in proportion to n²: it absorbs so much more, and so much more passes a thick layer.
    let more = (index / medium.ordinates.index).powi(2);
    [
        index,
        coherent,
        of(|t| t.scattering_per_um),
        of(|t| t.absorption_per_um),
        of(|t| t.asymmetry),
        of(Transport::mean_free_path_um),
        munk.map_or(f64::NAN, |m| m.absorption_per_um / more),
        munk.map_or(f64::NAN, |m| m.scattering_per_um * more),
    ]
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
