//! The ink on its paper over all wavelengths and realisations: spectra, colours and the picture, with errors.

use super::films::{FilmAt, Films};
use super::layer::{LayerEnsemble, Mean, SpectrumEstimate, Total, film_means, film_totals};
use super::on_paper::{
    AZIMUTHAL, Anchors, BENDS, Curve, DIFFUSE, LayerOnPaper, Measured, Nodes, PolarAngle, SYMMETRIC,
    anchor_shares, azimuthal, diffuse_functions, symmetric,
};
use super::regression::{Fits, Normal, Sums};
use super::samples::{Solved, SolvedRealisation, SolvedWavelength};
use super::wavelengths::SpectralBasis;
use crate::appearance::colour::{Colorimeter, Colour, ColourError};
use crate::appearance::paper::{MirroredSky, PRINT_DEG, PaperError, Substrate};
use crate::appearance::picture::InkPicture;
use crate::numerics::estimate::{Estimate, jackknife_covariance};
use ndarray::Array2;
use std::f64::consts::PI;
use std::ops::Range;
use thiserror::Error;

/// Largest step of the wavelengths that colours are summed over, nm.
const COLOUR_STEP_NM: f64 = 5.0;
/// Length of the step in the direction of a residual that a derivative is taken with.
const DERIVATIVE_STEP: f64 = 1e-4;

/// Why the ensemble gives no ink on paper.
#[derive(Debug, Error, PartialEq)]
pub enum InkError {
    /// The paper, or a number of the layer on it.
    #[error(transparent)]
    Paper(#[from] PaperError),
    /// The wavelengths cannot carry a colour.
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// 0° and 45° are not both among the angles solved, or the hemisphere is not.
    #[error("paper and colour need solves at 0° and 45° and over the hemisphere")]
    AnglesMissing,
}

/// What an ensemble of solves stands for: its film, its paper and what shall be reported.
pub struct InkInputs<'a> {
    /// The coherent film.
    pub films: &'a Films<'a>,
    /// The paper.
    pub substrate: &'a Substrate,
    /// Wavelengths of the spectra to report, nm, rising.
    pub outputs_nm: &'a [f64],
}

/// Places of the nodes: spectra, colours, and the wavelengths solved.
#[derive(Clone, Debug)]
struct Places {
    outputs: Range<usize>,
    colours: Range<usize>,
    /// One range for each realisation; empty with listed wavelengths.
    solved: Vec<Range<usize>>,
}

/// The ink on its paper. Every quantity is computed from ensemble means (a print shows many cells at once); errors are jackknife errors
/// over realisations, so that noise common to wavelengths and angles of one packing counts once.
///
/// ```
/// use inkwave::appearance::paper::{Albedo, Coupling, MirroredSky, Substrate};
/// use inkwave::evaluate::film::Profile;
/// use inkwave::evaluate::films::Films;
/// use inkwave::evaluate::ink::{InkInputs, InkOnPaper};
/// use inkwave::material::spectra::{Spectrum, molecular_mixture};
///
/// let yellow = Spectrum::synthetic("yellow")?;
/// let mixture = |nm: f64| (molecular_mixture(1.558.into(), &[(0.3, yellow.index(1e-3 * nm).unwrap())]), Vec::new());
/// let films = Films { profile: Profile::homogeneous(), indices: &mixture, thicknesses_um: vec![1.0], index_out: 1.0, wave: Default::default() };
/// let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
/// let outputs_nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
/// let ink = InkOnPaper::homogeneous(&InkInputs { films: &films, substrate: &substrate, outputs_nm: &outputs_nm })?;
/// let view = ink.at(0.0)?;
/// let colour = ink.colour(|layer| layer.natural_light(&view, MirroredSky::Included))?;
/// assert!(colour.chroma().value > 90.0 && (80.0..110.0).contains(&colour.hue_deg().value));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct InkOnPaper {
    layer: LayerEnsemble,
    /// Places of 0° and 45° among the exact angles.
    anchored: [usize; 2],
    substrate: Substrate,
    nodes: Nodes,
    places: Places,
    meter: Result<Colorimeter, ColourError>,
    curves: Fits,
    diffuse: Fits,
    /// Functions that the diffuse fit has.
    diffuse_width: usize,
    /// The layer in the light that the paper gives back, where that is another one.
    returned: Option<(LayerEnsemble, Fits)>,
    directional: Fits,
    /// 1/(Lx Ly), mean over the solves, 1/µm².
    orders_per_um2: f64,
    whole: Vec<LayerOnPaper>,
    /// \[realisation left out\]\[node\]
    replicates: Vec<Vec<LayerOnPaper>>,
}

impl InkOnPaper {
    /// Fits what the layer itself does not hold, and puts it on its paper.
    ///
    /// # Errors
    /// Angles that do not carry it, an albedo that does not answer everywhere, a lossless mirror over a lossless paper.
    pub fn new(
        layer: LayerEnsemble,
        solved: &[SolvedRealisation],
        inputs: &InkInputs,
    ) -> Result<Self, InkError> {
        Self::lit((layer, solved), None, inputs)
    }

    /// The same where polarised light comes in, `inputs.films` being its own; `returned` is the layer in the unpolarised
    /// light that the paper gives back.
    ///
    /// # Errors
    /// As [`InkOnPaper::new`].
    pub fn polarised(
        lit: (LayerEnsemble, &[SolvedRealisation]),
        returned: (LayerEnsemble, &[SolvedRealisation]),
        inputs: &InkInputs,
    ) -> Result<Self, InkError> {
        Self::lit(lit, Some(returned), inputs)
    }

    fn lit(
        (layer, solved): (LayerEnsemble, &[SolvedRealisation]),
        returned: Option<(LayerEnsemble, &[SolvedRealisation])>,
        inputs: &InkInputs,
    ) -> Result<Self, InkError> {
        let anchored = [0.0, PRINT_DEG].map(|deg| layer.place(deg));
        let ([Some(normal), Some(slanted)], true) = (anchored, layer.strata > 0) else {
            return Err(InkError::AnglesMissing);
        };
        let anchored = [normal, slanted];
        let (nodes_nm, places) = places(&layer, inputs.outputs_nm);
        let meter = Colorimeter::new(&nodes_nm[places.colours.clone()]);
        let films: Vec<FilmAt> = nodes_nm.iter().map(|&nm| inputs.films.at(nm)).collect();
        let albedos =
            nodes_nm.iter().map(|&nm| inputs.substrate.albedo.at(nm)).collect::<Result<Vec<_>, _>>()?;
        let shares = nodes_nm.iter().map(|&nm| layer.basis.shares(nm)).collect();
        let means = films.iter().map(|film| film_means(&film.returned(), layer.exit)).collect();
        let nodes = Nodes { wavelengths_nm: nodes_nm, films, albedos, shares, means };
        let none = |width: usize, columns: usize| Fits::nothing(&layer.basis, width, columns);
        let polarised = returned.is_some();
        let diffuse_width = if polarised { DIFFUSE } else { SYMMETRIC };
        let (own_curves, diffuse, directional) = match solved {
            [] => (none(BENDS, 3), none(diffuse_width, 1), none(SYMMETRIC + AZIMUTHAL, 1)),
            _ => (
                curves(&layer, anchored, solved, inputs.films),
                match polarised {
                    false => diffuse::<SYMMETRIC>(&layer, solved, &mean_functions),
                    true => diffuse::<DIFFUSE>(&layer, solved, &polarised_functions),
                },
                diffuse::<{ SYMMETRIC + AZIMUTHAL }>(&layer, solved, &all_functions),
            ),
        };
        let returned = returned.map(|(layer, solved)| {
            let fits = curves(&layer, anchored, solved, &inputs.films.returned());
            (layer, fits)
        });
        let replicates = layer.replicates();
        let mut ink = Self {
            layer,
            anchored,
            substrate: inputs.substrate.clone(),
            nodes,
            places,
            meter,
            curves: own_curves,
            diffuse,
            diffuse_width,
            returned,
            directional,
            orders_per_um2: orders_per_um2(solved),
            whole: Vec::new(),
            replicates: Vec::new(),
        };
        ink.whole = ink.layers_without(None)?;
        ink.replicates = (0..replicates).map(|r| ink.layers_without(Some(r))).collect::<Result<_, _>>()?;
        Ok(ink)
    }

    /// A layer that is its own film (the molecular mixture, or the clear binder) at listed wavelengths: nothing to solve.
    ///
    /// # Errors
    /// As [`InkOnPaper::new`].
    pub fn homogeneous(inputs: &InkInputs) -> Result<Self, InkError> {
        let basis = SpectralBasis::Listed(inputs.outputs_nm.to_vec());
        let exit = inputs.substrate.coupling.index_below() != 1.0;
        Self::new(LayerEnsemble::film_alone(basis, &[0.0, PRINT_DEG], exit), &[], inputs)
    }

    /// The same layer on another paper with the same contact.
    ///
    /// # Errors
    /// As [`InkOnPaper::new`].
    pub fn on(&self, substrate: &Substrate) -> Result<Self, InkError> {
        let mut other = Self { substrate: substrate.clone(), ..self.clone() };
        let at = |&nm: &f64| substrate.albedo.at(nm);
        other.nodes.albedos = other.nodes.wavelengths_nm.iter().map(at).collect::<Result<_, _>>()?;
        other.whole = other.layers_without(None)?;
        other.replicates =
            (0..self.replicates.len()).map(|r| other.layers_without(Some(r))).collect::<Result<_, _>>()?;
        Ok(other)
    }

    fn layers_without(&self, left_out: Option<usize>) -> Result<Vec<LayerOnPaper>, PaperError> {
        (0..self.nodes.wavelengths_nm.len()).map(|node| self.layer_at(node, left_out)).collect()
    }

    fn layer_at(&self, node: usize, left_out: Option<usize>) -> Result<LayerOnPaper, PaperError> {
        let shares = &self.nodes.shares[node];
        let at = |fits: &Fits, row: usize, width: usize, column: usize| {
            let coefficients = left_out.map_or(&fits.whole, |r| &fits.without[r]);
            SpectralBasis::at(shares, |i| coefficients[[i * width + row, column]])
        };
        let measured = self.measured(|layer, column| layer.fitted(left_out, shares, column));
        let bends =
            |fits: &Fits| std::array::from_fn(|column| std::array::from_fn(|b| at(fits, b, BENDS, column)));
        let width = self.diffuse_width;
        let diffuse = |k: usize| if k < width { at(&self.diffuse, k, width, 0) } else { 0.0 };
        let curve = Curve {
            bends: bends(&self.curves),
            returned: bends(self.returned.as_ref().map_or(&self.curves, |(_, fits)| fits)),
            diffuse: std::array::from_fn(diffuse),
            azimuthal: std::array::from_fn(|k| {
                at(&self.directional, SYMMETRIC + k, SYMMETRIC + AZIMUTHAL, 0)
            }),
            order_area: self.orders_per_um2 * (1e-3 * self.nodes.wavelengths_nm[node]).powi(2),
        };
        let [mean_t, _, mean_a, _] = self.nodes.means[node];
        let film = [mean_t, mean_a];
        LayerOnPaper::new(
            node,
            film,
            measured,
            curve,
            self.nodes.albedos[node],
            self.substrate.coupling.index_below(),
        )
    }

    /// Wavelengths of the spectra, nm.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.nodes.wavelengths_nm[self.places.outputs.clone()]
    }

    /// The layer alone.
    pub fn layer(&self) -> &LayerEnsemble {
        &self.layer
    }

    /// The paper under it.
    pub fn substrate(&self) -> &Substrate {
        &self.substrate
    }

    /// The ensemble mean at every wavelength of the spectra.
    pub fn layers(&self) -> &[LayerOnPaper] {
        &self.whole[self.places.outputs.clone()]
    }

    /// A viewing or illumination angle, 0° ≤ θ < 90°.
    ///
    /// # Errors
    /// Other angles.
    pub fn at(&self, polar_deg: f64) -> Result<PolarAngle, PaperError> {
        PolarAngle::new(polar_deg, &self.nodes)
    }

    /// Any quantity of the layer on paper against wavelength:
    /// `ink.spectrum(|layer| layer.natural_light(&view, MirroredSky::Included))`.
    pub fn spectrum(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> SpectrumEstimate {
        let of = |layers: &[LayerOnPaper]| {
            layers[self.places.outputs.clone()].iter().map(&quantity).collect::<Vec<f64>>()
        };
        SpectrumEstimate {
            values: of(&self.whole),
            replicates: self.replicates.iter().map(|r| of(r)).collect(),
        }
    }

    /// Any scalar of the spectra (a mean over wavelengths, a ratio) with its jackknife error.
    pub fn scalar(&self, quantity: impl Fn(&[LayerOnPaper]) -> f64) -> Estimate {
        let of = |layers: &[LayerOnPaper]| quantity(&layers[self.places.outputs.clone()]);
        let replicates: Vec<f64> = self.replicates.iter().map(|r| of(r)).collect();
        Estimate::jackknife(of(&self.whole), &replicates)
    }

    /// Colour of a quantity that is 1 for a perfect white diffuser, with the jackknife covariance of Lab.
    ///
    /// # Errors
    /// Wavelengths that cannot carry a colour.
    pub fn colour(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<Colour, InkError> {
        let labs = (0..self.replicates.len()).map(|r| Ok(self.colour_without(Some(r), &quantity)?.lab));
        let labs = labs.collect::<Result<Vec<_>, InkError>>()?;
        Ok(Colour { lab_covariance: jackknife_covariance(&labs), ..self.colour_without(None, &quantity)? })
    }

    /// How far the colour moves by what the spectra's fit leaves over at the wavelengths solved: the part of the colour that the
    /// wavelengths' spacing alone would have lost. It is in the colour; see [`InkOnPaper::colour`].
    ///
    /// # Errors
    /// As [`InkOnPaper::colour`].
    pub fn wavelength_shift(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<[f64; 3], InkError> {
        let meter = self.meter.as_ref().map_err(Clone::clone)?;
        let plain = meter.colour(&self.colour_values(&self.whole, &quantity))?;
        let full = self.colour_without(None, &quantity)?;
        Ok(std::array::from_fn(|i| full.lab[i] - plain.lab[i]))
    }

    /// Colour of the whole ensemble, without its uncertainty.
    ///
    /// # Errors
    /// As [`InkOnPaper::colour`].
    pub fn colour_of_mean(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> Result<Colour, InkError> {
        self.colour_without(None, &quantity)
    }

    /// What the placing of the directions may cost in T̄ at each wavelength of the spectra: standard deviation over realisations of the
    /// quadrature error of the fitted curve, over √n.
    pub fn angle_errors(&self, solved: &[SolvedRealisation]) -> Vec<f64> {
        let at = |node: usize| {
            let nm = self.nodes.wavelengths_nm[node];
            let error = |realisation: &SolvedRealisation| {
                let strata = &realisation.wavelengths[nearest(&realisation.wavelengths, nm)].strata;
                let polar_deg = strata.iter().map(|s| s.polar_deg);
                self.whole[node].quadrature_error(polar_deg, self.layer.exit).transmittance
            };
            let errors: Vec<f64> = solved.iter().map(error).collect();
            let square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            (square / errors.len() as f64).sqrt()
        };
        self.places.outputs.clone().map(at).collect()
    }

    fn colour_values(&self, layers: &[LayerOnPaper], quantity: &impl Fn(&LayerOnPaper) -> f64) -> Vec<f64> {
        layers[self.places.colours.clone()].iter().map(quantity).collect()
    }

    /// XYZ = ∫ w F(m̂) + ⟨Σ_j w_j F′(m̂)·(x_j − m̂)⟩: the fitted means m̂, and to first order what the solves x_j say beyond
    /// them. So the smoothness of the fit costs the colour nothing.
    fn colour_without(
        &self,
        left_out: Option<usize>,
        quantity: &impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Colour, InkError> {
        let meter = self.meter.as_ref().map_err(Clone::clone)?;
        let layers = left_out.map_or(&self.whole, |r| &self.replicates[r]);
        let mut xyz = meter.xyz(&self.colour_values(layers, quantity))?;
        let kept: Vec<usize> = (0..self.places.solved.len()).filter(|&r| Some(r) != left_out).collect();
        for &r in &kept {
            let nodes = self.places.solved[r].clone();
            let width = self.step_nm(nodes.len());
            for (j, node) in nodes.enumerate() {
                let moved = layers[node].moved(&self.residual(left_out, r, j, node), DERIVATIVE_STEP);
                let slope = (quantity(&moved) - quantity(&layers[node])) / DERIVATIVE_STEP;
                let weight = meter.weight_per_nm(self.nodes.wavelengths_nm[node]);
                (0..3).for_each(|c| xyz[c] += weight[c] * width * slope / kept.len() as f64);
            }
        }
        Ok(meter.colour_of(xyz))
    }

    /// Width of a stratum of wavelengths, nm.
    fn step_nm(&self, strata: usize) -> f64 {
        match self.layer.basis {
            SpectralBasis::Splines { range_nm: [from, to], .. } => (to - from) / strata.max(1) as f64,
            SpectralBasis::Listed(_) => 0.0,
        }
    }

    /// What a solve says beyond the fit.
    fn residual(&self, left_out: Option<usize>, r: usize, j: usize, node: usize) -> Measured {
        let shares = &self.nodes.shares[node];
        self.measured(|layer, column| layer.measured(r, j, column) - layer.fitted(left_out, shares, column))
    }

    /// Differences from the film at the anchors and of the means, by a source of them for any column of an ensemble.
    fn measured(&self, of: impl Fn(&LayerEnsemble, usize) -> f64) -> Measured {
        let returned = self.returned.as_ref().map_or(&self.layer, |(layer, _)| layer);
        let at = |layer: &LayerEnsemble| {
            anchors(self.anchored, |angle, total| of(layer, layer.column(angle, total)))
        };
        let mean = |mean: Mean| of(returned, returned.mean_column(mean));
        Measured {
            anchors: at(&self.layer),
            returned: at(returned),
            transmittance: mean(Mean::Transmittance),
            absorptance: mean(Mean::ExitAbsorptance),
        }
    }

    /// Covariance of Lab that the placing of the directions alone has brought into a colour: each realisation's quadrature error of the
    /// fitted curves, a part of the jackknife's. `None` for one realisation.
    ///
    /// # Errors
    /// As [`InkOnPaper::colour`].
    pub fn angle_covariance(
        &self,
        solved: &[SolvedRealisation],
        quantity: impl Fn(&LayerOnPaper) -> f64,
    ) -> Result<Option<[[f64; 3]; 3]>, InkError> {
        let meter = self.meter.as_ref().map_err(Clone::clone)?;
        let mut shifted = Vec::new();
        for realisation in solved.iter().take(self.layer.replicates()) {
            let mut values = self.colour_values(&self.whole, &quantity);
            let strata: Vec<&[Solved]> =
                realisation.wavelengths.iter().map(|w| w.strata.as_slice()).collect();
            for (value, node) in values.iter_mut().zip(self.places.colours.clone()) {
                let near = nearest(&realisation.wavelengths, self.nodes.wavelengths_nm[node]);
                let error = self.whole[node]
                    .quadrature_error(strata[near].iter().map(|s| s.polar_deg), self.layer.exit);
                let moved = self.whole[node].moved(&error, DERIVATIVE_STEP);
                *value += (quantity(&moved) - quantity(&self.whole[node])) / DERIVATIVE_STEP;
            }
            shifted.push(meter.colour(&values)?.lab);
        }
        let n = shifted.len() as f64;
        // the covariance of a mean: the jackknife's formula over samples instead of replicates, less a factor (n − 1)²
        Ok(jackknife_covariance(&shifted).map(|c| c.map(|row| row.map(|x| x / (n - 1.0).powi(2)))))
    }

    /// The picture of P1 Fig. 6 at the given angles (0–60° there), rows viewing, columns illumination.
    ///
    /// The strip is natural light, with or without the mirrored sky; the square is π f(i, o), diffuse, averaged over
    /// the azimuth between the two planes (P1 leaves both open).
    ///
    /// # Errors
    /// Angles outside 0–90°, or wavelengths that cannot carry a colour.
    pub fn picture(&self, angles_deg: &[f64], sky: MirroredSky) -> Result<InkPicture, InkError> {
        let meter = self.meter.as_ref().map_err(Clone::clone)?;
        let angles = angles_deg.iter().map(|&a| self.at(a)).collect::<Result<Vec<PolarAngle>, _>>()?;
        let colour = |f: &dyn Fn(&LayerOnPaper) -> f64| {
            let values: Vec<f64> = self.whole[self.places.colours.clone()].iter().map(f).collect();
            meter.colour(&values)
        };
        let strip =
            angles.iter().map(|o| colour(&|l| l.natural_light(o, sky))).collect::<Result<Vec<_>, _>>()?;
        let cells = angles.iter().flat_map(|o| angles.iter().map(move |i| (o, i)));
        let square = cells.map(|(o, i)| colour(&|l| PI * l.brdf(i, o))).collect::<Result<Vec<_>, _>>()?;
        let square =
            Array2::from_shape_fn((angles.len(), angles.len()), |(o, i)| square[o * angles.len() + i]);
        Ok(InkPicture { angles_deg: angles_deg.to_vec(), strip, square })
    }
}

/// Differences at 0° and 45° from a source of them.
fn anchors(places: [usize; 2], of: impl Fn(usize, Total) -> f64) -> Anchors {
    let totals = [Total::Reflectance, Total::Transmittance, Total::SpecularReflectance];
    places.map(|angle| totals.map(|total| of(angle, total)))
}

/// Mean of 1/(Lx Ly) over all solves, 1/µm²; 0 without any.
fn orders_per_um2(solved: &[SolvedRealisation]) -> f64 {
    let of_cell = |w: &SolvedWavelength| w.exact[0].order_area / (1e-3 * w.wavelength_nm).powi(2);
    let all: Vec<f64> = solved.iter().flat_map(|r| &r.wavelengths).map(of_cell).collect();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

/// Place of the wavelength nearest to `nm`.
fn nearest(wavelengths: &[SolvedWavelength], nm: f64) -> usize {
    let distance = |w: &SolvedWavelength| (w.wavelength_nm - nm).abs();
    (0..wavelengths.len())
        .min_by(|&a, &b| distance(&wavelengths[a]).total_cmp(&distance(&wavelengths[b])))
        .unwrap_or(0)
}

fn places(layer: &LayerEnsemble, outputs_nm: &[f64]) -> (Vec<f64>, Places) {
    let mut nodes = outputs_nm.to_vec();
    let outputs = 0..nodes.len();
    let SpectralBasis::Splines { range_nm: [from, to], .. } = layer.basis else {
        return (nodes, Places { colours: outputs.clone(), outputs, solved: Vec::new() });
    };
    let steps = ((to - from) / COLOUR_STEP_NM).ceil().max(1.0) as usize;
    let start = nodes.len();
    nodes.extend((0..=steps).map(|k| from + (to - from) * k as f64 / steps as f64));
    let colours = start..nodes.len();
    let mut solved = Vec::new();
    for r in 0..layer.realisations() {
        let start = nodes.len();
        nodes.extend(layer.wavelengths_nm(r));
        solved.push(start..nodes.len());
    }
    (nodes, Places { outputs, colours, solved })
}

/// R, T and specular R between the anchors: what the solves in the strata differ from the film and the anchors' share.
fn curves(layer: &LayerEnsemble, anchored: [usize; 2], solved: &[SolvedRealisation], films: &Films) -> Fits {
    let part = |(r, realisation): (usize, &SolvedRealisation)| {
        let mut normal = Normal::new(layer.basis.len() * BENDS, 3);
        for (j, at) in realisation.wavelengths.iter().enumerate() {
            let film = films.of_thickness(at.wavelength_nm, realisation.thickness_um);
            let own = anchors(anchored, |angle, total| layer.measured(r, j, layer.column(angle, total)));
            let mut sums = Sums::new(BENDS, 3);
            for s in &at.strata {
                let (between, bends) = anchor_shares(s.polar_deg.to_radians().cos());
                let [film_r, _, film_t, ..] = film_totals(&film, s.polar_deg);
                let values =
                    [s.reflectance - film_r, s.transmittance - film_t, s.specular_reflectance - film_r];
                let rest: [f64; 3] =
                    std::array::from_fn(|q| values[q] - between[0] * own[0][q] - between[1] * own[1][q]);
                sums.add(&bends, &rest);
            }
            normal.add(&layer.basis.shares(at.wavelength_nm), &sums);
        }
        normal
    };
    Fits::new(&solved.iter().enumerate().map(part).collect::<Vec<_>>(), &layer.basis, BENDS)
}

/// Functions of a sample: cosines of light and order, and sin θ_i sin θ_o cos Δφ.
type Functions<const N: usize> = dyn Fn(f64, f64, f64) -> [f64; N];

fn mean_functions(lit: f64, seen: f64, _: f64) -> [f64; SYMMETRIC] {
    symmetric(lit, seen)
}

fn polarised_functions(lit: f64, seen: f64, _: f64) -> [f64; DIFFUSE] {
    diffuse_functions(lit, seen)
}

fn all_functions(lit: f64, seen: f64, s: f64) -> [f64; SYMMETRIC + AZIMUTHAL] {
    let (mean, directional) = (symmetric(lit, seen), azimuthal(lit, seen, s));
    std::array::from_fn(|k| if k < SYMMETRIC { mean[k] } else { directional[k - SYMMETRIC] })
}

/// The layer's own diffuse BRDF, from all orders of all solves from the incident side: its mean over the azimuth, which colours
/// need, or with its dependence on it, which a renderer needs.
fn diffuse<const N: usize>(
    layer: &LayerEnsemble,
    solved: &[SolvedRealisation],
    functions: &Functions<N>,
) -> Fits {
    let part = |realisation: &SolvedRealisation| {
        let mut normal = Normal::new(layer.basis.len() * N, 1);
        for at in &realisation.wavelengths {
            let mut sums = Sums::new(N, 1);
            for s in at.exact.iter().chain(&at.strata) {
                let (sine, lit) = s.polar_deg.to_radians().sin_cos();
                s.scattered.iter().for_each(|order| {
                    sums.add(&functions(lit, order.cosine, sine * order.along), &[order.density])
                });
            }
            normal.add(&layer.basis.shares(at.wavelength_nm), &sums);
        }
        normal
    };
    Fits::new(&solved.iter().map(part).collect::<Vec<_>>(), &layer.basis, N)
}

#[cfg(test)]
#[path = "ink_tests.rs"]
pub(crate) mod tests;
