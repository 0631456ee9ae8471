//! Fits of coats that are composed of slabs: opaque and thick ones.
//!
//! A composed layer has no derivatives of its solves. Its slabs are solved once at the nodes of a
//! table of n and κ, and every coat, card and geometry is evaluated from them. Between the nodes
//! ln((1 − R)²/2R), which is nearly linear in ln κ and in ln |n − n_binder| where a coat is opaque,
//! is a polynomial in both. The fit is that of thin coats on this table; the table's errors are among those of the
//! data.

use super::data::Data;
use super::face::SampleFace;
use super::file::FitGeometry;
use super::law::rms;
use super::load::{Drawdown, FitTask};
use super::response::{Response, Spectra};
use super::run::{Branch, FitError, FitOutcome, FittedIndex, Forecast, Trust, descend, near, prior_of};
use crate::evaluate::composed::summary::summarise_slabs;
use crate::evaluate::published::ErrorParts;
use crate::evaluate::quantities::LayerNumbers;
use crate::input::study::Study;
use crate::run::watch::RunWatch;
use crate::run::{RunError, RunSettings, Stores};
use crate::store::folder::OutputFolder;
use crate::work::alone::stored_portions;
use crate::work::run::{Scope, run};
use crate::work::units::Shard;
use crate::work::variant::Variant;
use ndarray::Array4;
use num_complex::Complex64;

/// Nodes in n, over `fit.n` in equal ratios of the distance from the binder's index.
const NODES_N: usize = 3;
/// Nodes in κ, as shares of the largest of `fit.kappa`.
const SHARES: [f64; 5] = [0.003, 0.02, 0.1, 0.4, 1.0];
/// Error of a reflectance between the nodes: *measured* on the closed form of the tests, 0.003 at most.
const BETWEEN_NODES: f64 = 0.003;
/// A layer of this many times the thickness comes from solves that are made anyway.
const THICKER: f64 = 1.1;
/// Reflectances are taken between these.
const ENDS: [f64; 2] = [1e-4, 1.0 - 1e-4];
/// Smallest distance of n from the binder's on which the table is evaluated.
const LEAST_APART: f64 = 0.02;
/// Step of the derivatives in n and in ln κ.
const STEP: f64 = 1e-4;
/// Points per wavelength of the search for a start.
const SEARCHED: usize = 60;
/// Error of n over |n − n_binder| from which n is not determined: scattering goes with the square of
/// that difference, and the κ of an opaque coat with scattering.
const CONTRAST_ERROR: f64 = 0.1;

/// The studies whose slabs are solved: of every coat one at each node.
pub fn variants(task: &FitTask) -> Vec<Variant> {
    let coats = if task.predicted.is_empty() { task.coats_measured } else { task.coats.len() };
    let mut all = Vec::new();
    for (number, coat) in task.coats[..coats].iter().enumerate() {
        for [n, kappa] in nodes(task) {
            let name = format!("coat {}, n = {n:.3}, κ = {kappa:.4}", number + 1);
            all.push(Variant { name, study: at_node(task, coat, [n, kappa]) });
        }
    }
    all
}

/// Axes of the table.
fn axes(task: &FitTask) -> [Vec<f64>; 2] {
    let [from, to] = task.settings.n;
    let [_, most] = task.settings.kappa;
    let binder = task.binder_index();
    let ratio = (to - binder) / (from - binder);
    let node = |i: usize| binder + (from - binder) * ratio.powf(i as f64 / (NODES_N - 1) as f64);
    let n = (0..NODES_N).map(node).collect();
    [n, SHARES.iter().map(|share| share * most).collect()]
}

/// \[n, κ\] of all nodes, n first.
fn nodes(task: &FitTask) -> Vec<[f64; 2]> {
    let [n, kappa] = axes(task);
    n.iter().flat_map(|&n| kappa.iter().map(move |&kappa| [n, kappa])).collect()
}

/// A study with one index at all wavelengths, which also reports a thicker layer.
fn at_node(task: &FitTask, study: &Study, [n, kappa]: [f64; 2]) -> Study {
    let index = vec![Complex64::new(n, kappa); study.wavelengths_nm.len()];
    let mut node = study.with_index(task.pigment, &index);
    let um = node.requested_um()[0];
    node.request_um(vec![um, THICKER * um]);
    node
}

/// What a node says of a drawdown at one wavelength.
#[derive(Clone, Copy, Debug, Default)]
pub struct NodeValue {
    /// Reflectance factor.
    pub value: f64,
    /// That of the thicker layer.
    pub thicker: f64,
    /// Standard error of the first.
    pub error: f64,
}

/// Reflectances of drawdowns at the nodes: drawdown → wavelength → n → κ.
pub struct NodeTable {
    binder: f64,
    /// ln |n − n_binder| of the nodes.
    log_apart: Vec<f64>,
    log_kappa: Vec<f64>,
    nodes: Array4<NodeValue>,
    /// Face and geometry of every drawdown; the nodes are those of smooth faces.
    faces: Vec<(SampleFace, FitGeometry)>,
}

/// Solves the slabs of all nodes, and fits.
///
/// # Errors
/// A stop, a failure of the solves or of the least squares; a node without a reflectance.
pub fn fit(
    task: &FitTask,
    folder: &OutputFolder,
    settings: RunSettings,
    watch: &dyn RunWatch,
) -> Result<FitOutcome, FitError> {
    let variants = variants(task);
    folder.begin().map_err(RunError::from)?;
    let settings = RunSettings { retry_failed: true, ..settings };
    let tally = run(&variants, folder, (Shard::ALL, Scope::Solves), settings, watch)?;
    if let Some(failure) = tally.failure {
        return Err(failure.into());
    }
    if watch.stop() {
        return Err(RunError::Stopped.into());
    }
    let stores = Stores::open(folder).map_err(RunError::Store)?;
    let measured = NodeTable::stored(task, &task.measured, &stores)?;
    let mut outcome = measured.fitted(task)?;
    if task.predicted.is_empty() {
        return Ok(outcome);
    }
    let predicted = NodeTable::stored(task, &task.predicted, &stores)?;
    let index: Vec<[f64; 2]> = outcome.index.iter().map(|row| [row.n, row.kappa]).collect();
    let response = predicted.response(&index, outcome.log_thickness);
    for (k, drawdown) in task.predicted.iter().enumerate() {
        let mut forecast = Forecast::new(task, drawdown, k, &response, &outcome.index, outcome.face_light);
        for (w, error) in forecast.errors.iter_mut().enumerate() {
            *error = error.hypot(predicted.error((k, w), index[w]));
        }
        match forecast.impossible(task.wavelengths_nm()) {
            Some(reason) => outcome.remarks.push(reason),
            None => outcome.forecasts.push(forecast),
        }
    }
    Ok(outcome)
}

impl NodeTable {
    /// The table from what is stored of all nodes.
    fn stored(task: &FitTask, drawdowns: &[Drawdown], stores: &Stores) -> Result<Self, FitError> {
        let mut rows = Vec::new();
        for drawdown in drawdowns {
            for node in nodes(task) {
                let study = at_node(task, &drawdown.study, node);
                let solved = stored_portions(&study, stores);
                let manifest = summarise_slabs(&study, &solved).map_err(FitError::Node)?;
                let spectra = manifest.spectra.composed();
                let waves = study.wavelengths_nm.len();
                let value = |row: usize| {
                    let parts = seen(drawdown.geometry, &spectra.get(row)?.layer)?;
                    Some([parts.value, parts.standard_error])
                };
                for w in 0..waves {
                    let found = value(w).zip(value(waves + w));
                    let Some(([value, own_error], [thicker, _])) = found else {
                        let [n, kappa] = node;
                        let nm = study.wavelengths_nm[w];
                        let what = &drawdown.name;
                        return Err(FitError::Node(format!("{what} at n = {n}, κ = {kappa}, {nm} nm")));
                    };
                    let error = own_error * drawdown.face.slope(w, value, drawdown.geometry).abs();
                    rows.push(NodeValue { value, thicker, error });
                }
            }
        }
        let [n, kappa] = axes(task);
        let waves = task.wavelengths_nm().len();
        let shape = (drawdowns.len(), waves, n.len(), kappa.len());
        let binder = task.binder_index();
        let table = Self::of(shape, binder, [n, kappa], |d, w, i, j| {
            rows[((d * NODES_N + i) * SHARES.len() + j) * waves + w]
        });
        Ok(table.behind_faces(drawdowns))
    }

    /// The table with the faces of these drawdowns in place of smooth ones.
    fn behind_faces(mut self, drawdowns: &[Drawdown]) -> Self {
        self.faces = drawdowns.iter().map(|drawdown| (drawdown.face.clone(), drawdown.geometry)).collect();
        self
    }

    /// A table of these values at the nodes of \[n, κ\].
    pub fn of(
        shape: (usize, usize, usize, usize),
        binder: f64,
        [n, kappa]: [Vec<f64>; 2],
        value: impl Fn(usize, usize, usize, usize) -> NodeValue,
    ) -> Self {
        let nodes = Array4::from_shape_fn(shape, |(d, w, i, j)| value(d, w, i, j));
        Self {
            binder,
            log_apart: n.iter().map(|n| log_apart(*n, binder)).collect(),
            log_kappa: kappa.iter().map(|kappa| kappa.ln()).collect(),
            faces: vec![(SampleFace::Smooth, FitGeometry::LitAt45); shape.0],
            nodes,
        }
    }

    /// A reflectance factor between the nodes, of the layer or of the thicker one.
    fn at(&self, (d, w): (usize, usize), [n, kappa]: [f64; 2], of: fn(&NodeValue) -> f64) -> f64 {
        let along = lagrange(&self.log_apart, log_apart(n, self.binder));
        // below the table the absorbance goes on as between its first nodes
        let log = kappa.max(1e-12).ln();
        let first = self.log_kappa[0];
        let across = lagrange(&self.log_kappa, log.max(first));
        let mut sum = 0.0;
        for (i, a) in along.iter().enumerate() {
            for (j, b) in across.iter().enumerate() {
                sum += a * b * absorbance(of(&self.nodes[[d, w, i, j]]));
            }
            if log < first {
                let [low, high] = [0, 1].map(|j| absorbance(of(&self.nodes[[d, w, i, j]])));
                sum += a * (high - low) / (self.log_kappa[1] - first) * (log - first);
            }
        }
        let (face, geometry) = &self.faces[d];
        face.seen(w, reflectance(sum), *geometry)
    }

    /// Reflectances with derivatives at an index for every wavelength and a factor e^`log` of the
    /// thicknesses.
    pub fn response(&self, index: &[[f64; 2]], log: f64) -> Response {
        let all = |f: &dyn Fn((usize, usize), [f64; 2]) -> f64| -> Spectra {
            let drawdowns = 0..self.nodes.dim().0;
            drawdowns.map(|d| index.iter().enumerate().map(|(w, eta)| f((d, w), *eta)).collect()).collect()
        };
        let value = |place: (usize, usize), eta: [f64; 2]| self.at(place, eta, |node| node.value);
        let thicker =
            |place, eta| (self.at(place, eta, |node| node.thicker) - value(place, eta)) / THICKER.ln();
        let slopes = [
            all(&|place, [n, kappa]| {
                (value(place, [n + STEP, kappa]) - value(place, [n - STEP, kappa])) / (2.0 * STEP)
            }),
            all(&|place, [n, kappa]| {
                let kappa = kappa.max(1e-9);
                let [more, less] = [STEP, -STEP].map(|step| value(place, [n, kappa * f64::exp(step)]));
                (more - less) / (2.0 * STEP * kappa)
            }),
            all(&thicker),
        ];
        let values = all(&|place, eta| value(place, eta) + log * thicker(place, eta));
        let none = vec![Vec::new(); values.len()];
        Response { replicates: none.clone(), slope_replicates: none, values, slopes }
    }

    /// Error of a value: that of the nodes about it, linear in ln κ, and between them. Nodes of white
    /// coats have errors many times those of dark ones.
    fn error(&self, (d, w): (usize, usize), [n, kappa]: [f64; 2]) -> f64 {
        let apart = log_apart(n, self.binder);
        let distance = |i: &usize| (self.log_apart[*i] - apart).abs();
        let nearest = (0..self.log_apart.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let error = |j: usize| self.nodes[[d, w, nearest.unwrap_or(0), j]].error;
        let last = self.log_kappa.len() - 1;
        let log = kappa.max(1e-12).ln().clamp(self.log_kappa[0], self.log_kappa[last]);
        let after = self.log_kappa.partition_point(|node| *node < log).clamp(1, last);
        let [from, to] = [after - 1, after].map(|j| self.log_kappa[j]);
        let share = (log - from) / (to - from);
        (error(after - 1) + share * (error(after) - error(after - 1))).hypot(BETWEEN_NODES)
    }

    /// Errors of all values at an index for every wavelength: drawdown after drawdown.
    fn errors(&self, index: &[[f64; 2]]) -> Vec<f64> {
        let of = |d: usize| index.iter().enumerate().map(move |(w, eta)| self.error((d, w), *eta));
        (0..self.nodes.dim().0).flat_map(of).collect()
    }

    /// The fit of the measured drawdowns.
    ///
    /// # Errors
    /// The least squares have no solution.
    pub fn fitted(&self, task: &FitTask) -> Result<FitOutcome, FitError> {
        let prior = prior_of(task);
        let response_at =
            |unknowns: &[f64]| Ok(self.response(&prior.index(unknowns), prior.log_thickness(unknowns)));
        let path = self.start(task);
        let systematic = self.errors(&path);
        let start = near(&prior, &path).ok_or(FitError::Singular)?;
        let Branch { unknowns, .. } = descend(task, &prior, start, &systematic, response_at)?;
        let prior = prior.adapted(&unknowns);
        let response = response_at(&unknowns)?;
        let systematic = self.errors(&prior.index(&unknowns));
        let data = Data::new(task, &prior, &unknowns, &response, &systematic);
        let (strength, step) = data.chosen().ok_or(FitError::Singular)?;
        let mut outcome = data.outcome(strength, &step, 0);
        outcome.n_is_determined &= contrast_error(&outcome, task.binder_index()) < CONTRAST_ERROR;
        if !outcome.n_is_determined && outcome.trust != Trust::Contradicted {
            let n_error = rms(outcome.index.iter().filter_map(|row| row.n_error));
            let remedy = match task.settings.known_n {
                Some(known) => format!("know it better than fit.known_n.n_error = {}", known.n_error),
                None => "give n at one wavelength as fit.known_n".to_owned(),
            };
            outcome.remarks.insert(
                0,
                format!(
                    "n is not determined: its standard error is {n_error:.2} (root mean square). Opaque coats tell absorption over scattering: \
                     {remedy}, or add tints with a known white or thin coats on white and black cards"
                ),
            );
        }
        Ok(outcome)
    }

    /// The κ that suits each wavelength best, at the known n or in the middle of those searched.
    fn start(&self, task: &FitTask) -> Vec<[f64; 2]> {
        let [from, to] = task.settings.n;
        let n = task.settings.known_n.map_or(0.5 * (from + to), |known| known.n.clamp(from, to));
        let first = self.log_kappa[0];
        let last = self.log_kappa[self.log_kappa.len() - 1];
        let kappa = |k: usize| (first + (last - first) * k as f64 / (SEARCHED - 1) as f64).exp();
        let best = |w: usize| {
            let miss = |kappa: f64| -> f64 {
                let spectra =
                    task.measured.iter().enumerate().filter(|(_, drawdown)| drawdown.values.is_some());
                let misses = spectra.map(|(d, drawdown)| {
                    self.at((d, w), [n, kappa], |node| node.value) - drawdown.measured(w)
                });
                misses.map(|miss| miss * miss).sum()
            };
            let all = (0..SEARCHED).map(kappa);
            [n, all.min_by(|a, b| miss(*a).total_cmp(&miss(*b))).unwrap_or(kappa(0))]
        };
        (0..task.wavelengths_nm().len()).map(best).collect()
    }
}

/// Root mean square of the error of n over |n − n_binder|.
fn contrast_error(outcome: &FitOutcome, binder: f64) -> f64 {
    let relative = |row: &FittedIndex| row.n_error.map(|error| error / (row.n - binder).abs());
    rms(outcome.index.iter().filter_map(relative))
}

/// What an instrument reads of a composed layer.
fn seen(geometry: FitGeometry, layer: &LayerNumbers<Option<ErrorParts>>) -> Option<ErrorParts> {
    match geometry {
        FitGeometry::LitAt45 => layer.lit_at_45,
        // diffuse light seen along the normal: at 8° a smooth face mirrors the same to 1e-5
        FitGeometry::UniformSky | FitGeometry::Sphere => layer.natural_light,
        FitGeometry::SphereExcluded => {
            let (all, mirrored) = layer.natural_light.zip(layer.mirrored)?;
            Some(ErrorParts { value: all.value - mirrored.value, ..all })
        }
        FitGeometry::Transmitted => layer.transmittance_normal,
    }
}

/// ln |n − n_binder|, bounded where the coat would not scatter.
fn log_apart(n: f64, binder: f64) -> f64 {
    (n - binder).abs().max(LEAST_APART).ln()
}

/// ln((1 − R)²/2R): K/S of an opaque coat by Kubelka and Munk.
fn absorbance(reflectance: f64) -> f64 {
    let [low, high] = ENDS;
    let r = reflectance.clamp(low, high);
    ((1.0 - r).powi(2) / (2.0 * r)).ln()
}

/// R of that logarithm: 1 + x − √(x² + 2x).
fn reflectance(absorbance: f64) -> f64 {
    let x = absorbance.clamp(-40.0, 40.0).exp();
    1.0 / (1.0 + x + (x * x + 2.0 * x).sqrt())
}

/// Lagrange's weights of the nodes at x.
fn lagrange(nodes: &[f64], x: f64) -> Vec<f64> {
    let weight = |i: usize| {
        let others = (0..nodes.len()).filter(|&j| j != i);
        others.map(|j| (x - nodes[j]) / (nodes[i] - nodes[j])).product()
    };
    (0..nodes.len()).map(weight).collect()
}

#[cfg(test)]
#[path = "composed_tests.rs"]
mod tests;
