//! The ink on its paper, over all wavelengths and realisations: spectra, colours and the picture,
//! with errors.

mod brightened;
mod colours;
mod directions;
mod moved;
mod places;
mod sums;

pub(super) use brightened::emitted_parts;
pub use colours::Sight;

use super::films::{FilmAt, Films};
use super::layer::{LayerEnsemble, SpectrumEstimate, film_means};
use super::on_paper::curves::{curves, fits};
use super::on_paper::{
    AZIMUTHAL, AngleCurve, AngleNodes, BENDS, DIFFUSE, LayerOnPaper, PolarAngle, SYMMETRIC,
};
use super::regression::Fits;
use super::samples::{SolvedRealisation, SolvedWavelength};
use super::wavelengths::SpectralBasis;
use crate::appearance::kubelka_munk::DiffuseFaces;
use crate::appearance::paper::{PRINT_DEG, PaperError, Substrate};
use crate::appearance::viewing::ColourError;
use directions::SampledDirections;
use moved::MovedNodes;
use places::{Places, places};
use rayon::prelude::*;
use thiserror::Error;

/// Why there is no ink on paper.
#[derive(Debug, Error, PartialEq)]
pub enum InkError {
    /// The paper, or a number of the layer on it, is not valid.
    #[error(transparent)]
    Paper(#[from] PaperError),
    /// The wavelengths do not suffice for a colour.
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// The solves lack 0°, 45° or the hemisphere.
    #[error("paper and colour need solves at 0° and 45° and over the hemisphere")]
    AnglesMissing,
}

/// Inputs of the ink on paper, besides the solves.
pub struct InkInputs<'a> {
    /// The coherent film.
    pub films: &'a Films<'a>,
    /// The paper.
    pub substrate: &'a Substrate,
    /// Wavelengths of the spectra, nm, increasing.
    pub outputs_nm: &'a [f64],
}

/// The ink on its paper. Every quantity is computed from ensemble means (a print shows many cells
/// at once); errors are jackknife errors over realisations, so that noise common to all wavelengths
/// and angles of a packing counts once.
///
/// ```
/// use inkwave_study::appearance::paper::{Albedo, Coupling, MirroredSky, Substrate};
/// use inkwave_study::appearance::film::Profile;
/// use inkwave_study::evaluate::films::Films;
/// use inkwave_study::evaluate::ink::{InkInputs, InkOnPaper};
/// use inkwave_study::input::variation::ThicknessShare;
/// use inkwave_study::material::mixing::molecular_mixture;
/// use inkwave_study::material::spectra::Spectrum;
///
/// let yellow = Spectrum::synthetic("yellow")?;
/// let of_yellow = |nm: f64| yellow.index(1e-3 * nm).unwrap();
/// let ink = |nm: f64| molecular_mixture(1.558.into(), &[(0.3, of_yellow(nm))]);
/// let mixture = |nm: f64| (vec![ink(nm)], Vec::new());
/// let films = Films {
///     profile: Profile::homogeneous(),
///     indices: &mixture,
///     thicknesses: ThicknessShare::even(1.0),
///     index_out: 1.0,
///     wave: Default::default(),
/// };
/// let substrate = Substrate { albedo: Albedo::Constant(0.9), coupling: Coupling::Gap };
/// let outputs_nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
/// let inputs = InkInputs { films: &films, substrate: &substrate, outputs_nm: &outputs_nm };
/// let ink = InkOnPaper::homogeneous(&inputs)?;
/// let view = ink.at(0.0)?;
/// let colour = ink.colour(|layer| layer.natural_light(&view, MirroredSky::Included))?;
/// assert!(colour.chroma().value > 90.0 && (80.0..110.0).contains(&colour.hue_deg().value));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct InkOnPaper {
    layer: LayerEnsemble,
    /// Indices of 0° and 45° among the exact angles.
    anchored: [usize; 2],
    /// Index of the half-space on the exit side.
    index_out: f64,
    nodes: AngleNodes,
    places: Places,
    curves: Fits,
    diffuse: Fits,
    /// Number of functions of the diffuse fit.
    diffuse_width: usize,
    /// The layer in the light returned by the paper, if that differs.
    returned: Option<(LayerEnsemble, Fits)>,
    directional: Fits,
    directions: SampledDirections,
    /// 1/(Lx Ly), averaged over the solves, 1/µm².
    orders_per_um2: f64,
    whole: Vec<LayerOnPaper>,
    /// \[realisation left out\]\[node\], without the nodes of solves
    replicates: Vec<Vec<LayerOnPaper>>,
    /// The layer of a few packings, with and without tables of indices moved by their errors.
    moved: Option<MovedNodes>,
}

/// The layer of an ensemble with the solves that it was made of.
#[derive(Clone, Debug)]
pub struct SolvedLayer<'a> {
    /// The layer's totals.
    pub ensemble: LayerEnsemble,
    /// Every realisation.
    pub solved: &'a [SolvedRealisation],
}

impl InkOnPaper {
    /// Fits the difference between the layer and its film, and places the layer on its paper. For
    /// polarised light `inputs.films` are those of that light, and `returned` is the layer in the
    /// unpolarised light returned by the paper.
    ///
    /// # Errors
    /// The angles do not suffice, the albedo is not defined everywhere, or a lossless mirror lies
    /// on a lossless paper.
    pub fn new(
        solved_layer: SolvedLayer,
        returned: Option<SolvedLayer>,
        inputs: &InkInputs,
    ) -> Result<Self, InkError> {
        let SolvedLayer { ensemble: layer, solved } = solved_layer;
        let (Some(normal), Some(slanted)) = (layer.place(0.0), layer.place(PRINT_DEG)) else {
            return Err(InkError::AnglesMissing);
        };
        if layer.strata == 0 {
            return Err(InkError::AnglesMissing);
        }
        let anchored = [normal, slanted];
        let (nodes_nm, mut places) = places(&layer, inputs.films, inputs.outputs_nm);
        let mut nodes = nodes(&layer, nodes_nm, &places, inputs)?;
        let guided = places.guide.start..places.fine_sum_guide.end;
        if nodes.means[guided.clone()].iter().flatten().all(|mean| mean.is_finite()) {
            // nothing fitted: the film
            nodes.weights[guided].iter_mut().for_each(Vec::clear);
        } else {
            nodes.cut(guided.start);
            places.guide = 0..0;
            places.fine_guide = 0..0;
            places.sum_guide = 0..0;
            places.fine_sum_guide = 0..0;
        }
        let diffuse_width = if returned.is_some() { DIFFUSE } else { SYMMETRIC };
        let [own_curves, diffuse, directional] = fits(&layer, anchored, solved, inputs.films, diffuse_width);
        let of_means = returned
            .as_ref()
            .map_or((solved, inputs.films.clone()), |returned| (returned.solved, inputs.films.returned()));
        let directions = SampledDirections::new(of_means.0, &layer.basis, &of_means.1);
        let returned = returned.map(|SolvedLayer { ensemble, solved }| {
            let fits = curves(&ensemble, anchored, solved, &inputs.films.returned());
            (ensemble, fits)
        });
        let ink = Self {
            layer,
            anchored,
            index_out: inputs.substrate.coupling.index_out(),
            nodes,
            places,
            curves: own_curves,
            diffuse,
            diffuse_width,
            returned,
            directional,
            directions,
            orders_per_um2: orders_per_um2(solved),
            whole: Vec::new(),
            replicates: Vec::new(),
            moved: None,
        };
        Ok(ink.laid_on_paper()?)
    }

    /// A layer that equals its film (the molecular mixture, or the clear binder), at listed
    /// wavelengths and without solves.
    ///
    /// # Errors
    /// As for [`InkOnPaper::new`].
    pub fn homogeneous(inputs: &InkInputs) -> Result<Self, InkError> {
        let basis = SpectralBasis::Listed(inputs.outputs_nm.to_vec());
        let ensemble = LayerEnsemble::new(&[], basis, inputs.films, &[0.0, PRINT_DEG]);
        Self::new(SolvedLayer { ensemble, solved: &[] }, None, inputs)
    }

    /// The layer on another paper with the same contact.
    ///
    /// # Errors
    /// As for [`InkOnPaper::new`].
    pub fn on(&self, substrate: &Substrate) -> Result<Self, InkError> {
        let mut other = self.clone();
        let albedo = |&nm: &f64| substrate.albedo.at(nm);
        other.nodes.albedos = other.nodes.wavelengths_nm.iter().map(albedo).collect::<Result<_, _>>()?;
        Ok(other.laid_on_paper()?)
    }

    /// The ink without its leave-one-out ensembles and moved tables, to be laid [`on`](Self::on)
    /// other papers: values have no errors then.
    pub(super) fn of_means(&self) -> Self {
        Self { layer: self.layer.of_means(), replicates: Vec::new(), moved: None, ..self.clone() }
    }

    /// With the layers of the whole ensemble and of all leave-one-out ensembles.
    fn laid_on_paper(mut self) -> Result<Self, PaperError> {
        let left_out = 0..self.layer.replicates();
        self.whole = self.layers_without(None)?;
        self.replicates = left_out.map(|r| self.layers_without(Some(r))).collect::<Result<_, _>>()?;
        Ok(self)
    }

    fn layers_without(&self, left_out: Option<usize>) -> Result<Vec<LayerOnPaper>, PaperError> {
        let all = self.nodes.wavelengths_nm.len();
        let count = if left_out.is_some() { self.places.fitted() } else { all };
        (0..count).map(|node| self.layer_at(node, left_out)).collect()
    }

    fn layer_at(&self, node: usize, left_out: Option<usize>) -> Result<LayerOnPaper, PaperError> {
        let weights = &self.nodes.weights[node];
        let coefficient = |fits: &Fits, row: usize, width: usize, column: usize| {
            SpectralBasis::at(weights, |i| fits.coefficients(left_out)[[i * width + row, column]])
        };
        let measured = self.measured(|layer, column| layer.fitted(left_out, weights, column));
        let bends = |fits: &Fits| {
            std::array::from_fn(|column| std::array::from_fn(|b| coefficient(fits, b, BENDS, column)))
        };
        let width = self.diffuse_width;
        let diffuse = |k: usize| if k < width { coefficient(&self.diffuse, k, width, 0) } else { 0.0 };
        let azimuthal = |k: usize| coefficient(&self.directional, SYMMETRIC + k, SYMMETRIC + AZIMUTHAL, 0);
        let curve = AngleCurve {
            bends: bends(&self.curves),
            returned: bends(self.returned.as_ref().map_or(&self.curves, |(_, fits)| fits)),
            diffuse: std::array::from_fn(diffuse),
            azimuthal: std::array::from_fn(azimuthal),
            order_area: self.orders_per_um2 * (1e-3 * self.nodes.wavelengths_nm[node]).powi(2),
        };
        let paper = [self.nodes.albedos[node], self.index_out];
        LayerOnPaper::new(node, self.nodes.means[node], measured, curve, paper)
    }

    /// Wavelengths of the spectra, nm.
    pub fn wavelengths_nm(&self) -> &[f64] {
        &self.nodes.wavelengths_nm[self.places.outputs.clone()]
    }

    /// Wavelength of one of the layers, nm.
    pub(super) fn wavelength_nm(&self, layer: &LayerOnPaper) -> f64 {
        self.nodes.wavelengths_nm[layer.node]
    }

    /// The faces as they act on diffuse light, at every node of the spectra, also of those with
    /// moved tables; none elsewhere.
    pub(super) fn faces(&self) -> Vec<DiffuseFaces> {
        let mut faces = vec![DiffuseFaces::default(); self.nodes.films.len()];
        let starts = self.moved.iter().flat_map(|all| all.moved.iter().copied().chain([all.few])).chain([0]);
        for node in starts.flat_map(|start| (start..).take(self.places.outputs.len())) {
            faces[node] = self.nodes.films[node].returned().faces();
        }
        faces
    }

    /// The ensemble mean at every wavelength of the spectra.
    pub fn layers(&self) -> &[LayerOnPaper] {
        &self.whole[self.places.outputs.clone()]
    }

    /// The layers of every leave-one-out ensemble at every wavelength of the spectra.
    pub(super) fn layers_of_replicates(&self) -> impl Iterator<Item = &[LayerOnPaper]> {
        self.replicates.iter().map(|layers| &layers[self.places.outputs.clone()])
    }

    /// A viewing or illumination angle, 0° ≤ θ < 90°.
    ///
    /// # Errors
    /// The angle is outside this range.
    pub fn at(&self, polar_deg: f64) -> Result<PolarAngle, PaperError> {
        PolarAngle::new(polar_deg, &self.nodes)
    }

    /// Any quantity of the layer on paper against wavelength: `ink.spectrum(|layer|
    /// layer.natural_light(&view, MirroredSky::Included))`.
    pub fn spectrum(&self, quantity: impl Fn(&LayerOnPaper) -> f64) -> SpectrumEstimate {
        let spectrum = |layers: &[LayerOnPaper]| {
            layers[self.places.outputs.clone()].iter().map(&quantity).collect::<Vec<f64>>()
        };
        SpectrumEstimate {
            values: spectrum(&self.whole),
            replicates: self.replicates.iter().map(|r| spectrum(r)).collect(),
        }
    }
}

/// Mean of 1/(Lx Ly) over all solves, 1/µm²; 0 without solves.
fn orders_per_um2(solved: &[SolvedRealisation]) -> f64 {
    let of_cell = |w: &SolvedWavelength| w.exact[0].order_area / (1e-3 * w.wavelength_nm).powi(2);
    let all: Vec<f64> = solved.iter().flat_map(|r| &r.wavelengths).map(of_cell).collect();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

/// Everything known at these wavelengths besides the solves.
fn nodes(
    layer: &LayerEnsemble,
    nodes_nm: Vec<f64>,
    places: &Places,
    inputs: &InkInputs,
) -> Result<AngleNodes, InkError> {
    let films: Vec<FilmAt> = nodes_nm.iter().map(|&nm| inputs.films.at(nm)).collect();
    let albedos = nodes_nm.iter().map(|&nm| inputs.substrate.albedo.at(nm)).collect::<Result<Vec<_>, _>>()?;
    let weights = nodes_nm.iter().map(|&nm| layer.basis.weights(nm)).collect();
    let means = node_means(&films, &nodes_nm, places, layer.exit);
    Ok(AngleNodes { wavelengths_nm: nodes_nm, films, albedos, weights, means })
}

/// The films' means over the hemisphere, linear between wavelengths that are far closer than the
/// means change.
fn node_means(films: &[FilmAt], nm: &[f64], places: &Places, exit: bool) -> Vec<[f64; 2]> {
    let mut known: Vec<usize> = Vec::new();
    for (node, &here_nm) in nm.iter().enumerate() {
        let before_nm = known.last().map_or(f64::NAN, |&last| nm[last]);
        if !places.is_between(node, before_nm, here_nm) {
            known.push(node);
        }
    }
    let exact: Vec<[f64; 2]> =
        known.par_iter().map(|&node| film_means(&films[node].returned(), exit)).collect();
    let mean = |node: usize| -> [f64; 2] {
        let after = known.partition_point(|&other| other < node);
        if known.get(after) == Some(&node) {
            return exact[after];
        }
        let [from, to] = [known[after - 1], known[after]];
        let share = (nm[node] - nm[from]) / (nm[to] - nm[from]);
        std::array::from_fn(|k| exact[after - 1][k] + share * (exact[after][k] - exact[after - 1][k]))
    };
    (0..nm.len()).map(mean).collect()
}

#[cfg(test)]
#[path = "ink_tests.rs"]
pub mod tests;
