//! The wavelengths at which the layer on its paper is evaluated: those of spectra, colours,
//! weighted numbers and solves, in one list.

use crate::appearance::tristimulus::{TABLE_RANGE_NM, visible};
use crate::evaluate::films::{Films, fringe_nm, fringing_um};
use crate::evaluate::layer::LayerEnsemble;
use crate::evaluate::wavelengths::SpectralBasis;
use std::ops::Range;

/// Largest wavelength step of colour sums and of the films that guide coarser ones, nm.
const COLOUR_STEP_NM: f64 = 5.0;
/// Steps for every fringe of the film, at least: fringes that are sampled at one phase would count
/// as colour.
const STEPS_PER_FRINGE: f64 = 1.5;
/// Means over the hemisphere have fringes no more and are known this far apart, nm; steps that no
/// fringes ask for are wider.
const MEANS_APART_NM: f64 = 2.0;
/// Most wavelengths of a colour sum.
const MOST_SUMMED: f64 = 20_000.0;

/// Indices of the wavelengths: of spectra, of colours, and of solves.
#[derive(Clone, Debug)]
pub(super) struct Places {
    pub outputs: Range<usize>,
    /// Those of the spectra that colours can take.
    pub visible: Range<usize>,
    /// What colours are summed over, within the tables of the observers.
    pub colours: Range<usize>,
    /// What weighted numbers are summed over.
    pub sums: Range<usize>,
    /// The film alone, at the visible wavelengths of a list …
    pub guide: Range<usize>,
    /// … and every 5 nm or closer between them.
    pub fine_guide: Range<usize>,
    /// The film alone, at all wavelengths of a list …
    pub sum_guide: Range<usize>,
    /// … and at closer ones, for weighted numbers.
    pub fine_sum_guide: Range<usize>,
    /// One range per realisation; empty with listed wavelengths.
    pub solved: Vec<Range<usize>>,
    /// Width of the range that the wavelengths of the solves are drawn from, nm.
    pub range_nm: f64,
}

impl Places {
    /// Whether a wavelength is one of many that fringes ask for, nearer to `before` than means over
    /// the hemisphere change.
    pub fn is_between(&self, node: usize, before_nm: f64, here_nm: f64) -> bool {
        let summed = [&self.colours, &self.sums, &self.fine_guide, &self.fine_sum_guide];
        let inner = |range: &&Range<usize>| range.start < node && node + 1 < range.end;
        let is_inner = node >= self.outputs.end && summed.iter().any(inner);
        is_inner && (0.0..MEANS_APART_NM).contains(&(here_nm - before_nm))
    }

    /// Number of nodes up to the last of which spectra, colours or numbers are made.
    pub fn fitted(&self) -> usize {
        self.outputs.end.max(self.colours.end).max(self.sums.end)
    }
}

/// All wavelengths at which the layer is evaluated, nm, and which of them is for what.
pub(super) fn places(layer: &LayerEnsemble, films: &Films, outputs_nm: &[f64]) -> (Vec<f64>, Places) {
    let is_stack = !films.profile.layers.is_empty();
    let close = |range_nm: [f64; 2]| {
        let fringe_nm = fringe_nm(range_nm[0], fringing_um(&films.thicknesses, is_stack, range_nm[1]));
        closely(range_nm, COLOUR_STEP_NM.min(fringe_nm / STEPS_PER_FRINGE))
    };
    let sums_nm = layer.sums_nm.as_slice();
    let mut nodes = outputs_nm.to_vec();
    let mut add = |added_nm: &mut dyn Iterator<Item = f64>| {
        let start = nodes.len();
        nodes.extend(added_nm);
        start..nodes.len()
    };
    let outputs = 0..outputs_nm.len();
    let visible = visible(outputs_nm);
    if let SpectralBasis::Splines { range_nm: [from, to], .. } = layer.basis {
        let [shortest, longest] = TABLE_RANGE_NM;
        let colours = add(&mut close([from.max(shortest), to.min(longest)]).into_iter());
        let sums = add(&mut sums_nm.iter().copied());
        let solved = (0..layer.realisations()).map(|r| add(&mut layer.wavelengths_nm(r))).collect();
        let places = Places {
            outputs,
            visible,
            colours,
            sums,
            guide: 0..0,
            fine_guide: 0..0,
            sum_guide: 0..0,
            fine_sum_guide: 0..0,
            solved,
            range_nm: to - from,
        };
        return (nodes, places);
    }
    let seen_nm = &outputs_nm[visible.clone()];
    let ends = seen_nm.first().zip(seen_nm.last());
    let guide = add(&mut seen_nm.iter().copied());
    let fine_guide = add(&mut ends.map_or(Vec::new(), |(&from, &to)| close([from, to])).into_iter());
    let summed_nm = if sums_nm.is_empty() { &[] } else { outputs_nm };
    let places = Places {
        colours: visible.clone(),
        sums: outputs.clone(),
        outputs,
        visible,
        guide,
        fine_guide,
        sum_guide: add(&mut summed_nm.iter().copied()),
        fine_sum_guide: add(&mut sums_nm.iter().copied()),
        solved: Vec::new(),
        range_nm: 0.0,
    };
    (nodes, places)
}

/// Equal steps of at most this many nm over a range; nothing where it is none.
fn closely([from, to]: [f64; 2], step_nm: f64) -> Vec<f64> {
    if from > to {
        return Vec::new();
    }
    let steps = ((to - from) / step_nm).ceil().clamp(1.0, MOST_SUMMED) as usize;
    (0..=steps).map(|k| from + (to - from) * k as f64 / steps as f64).collect()
}
