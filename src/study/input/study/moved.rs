//! A study with a table of indices moved by its stated errors: what these errors do to every number
//! is the difference between solves of both in the same packings.

use super::{Study, StudyKind};
use crate::material::spectra::{ErrorAxis, Spectrum};
use std::collections::BTreeSet;

/// Realisations that are also solved with the moved tables: the first ones. The packings hardly
/// change what a table's error does, so two suffice, which may share a cell.
const MOVED_REALISATIONS: usize = 2;

/// Where a table stands in a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InputPlace {
    /// Core of a pigment's grains.
    Core(usize),
    /// A layer around it: pigment and layer.
    Shell(usize, usize),
    /// The binder of a layer.
    Binder(usize),
    /// A pigment dissolved in the binder of a layer: layer and pigment.
    Dissolved(usize, usize),
}

/// A table moved by one of the independent parts of its errors, to one side, in all of its rows at
/// once: errors are taken as common to all wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputMove {
    place: InputPlace,
    axis: ErrorAxis,
    /// In standard errors: 1 or −1.
    times: f64,
}

impl Study {
    /// All moves by one standard error to either side; none without errors in any table. Of a
    /// composed layer they are those of its slabs, of which the whole ones are solved with them. The
    /// plates of a stack are not moved.
    pub fn input_moves(&self) -> Vec<InputMove> {
        let moves = match &self.kind {
            StudyKind::InkOnPaper | StudyKind::LayerAlone(_) => true,
            StudyKind::Composed(composed) => composed.layers.is_empty(),
            StudyKind::Slab(portion) => !portion.halved && portion.stacked.is_none(),
        };
        if moves { self.all_moves() } else { Vec::new() }
    }

    /// All moves, also of the tables of a composed layer.
    fn all_moves(&self) -> Vec<InputMove> {
        let mut moves = Vec::new();
        for place in self.places() {
            for axis in self.spectrum(place).error_axes() {
                moves.extend([1.0, -1.0].map(|times| InputMove { place, axis, times }));
            }
        }
        moves
    }

    /// The moves with which a realisation is solved as well.
    pub fn moves_of(&self, realisation: usize) -> Vec<InputMove> {
        if realisation < MOVED_REALISATIONS { self.input_moves() } else { Vec::new() }
    }

    /// Says that the error bars of a stack of plates lack the errors of its tables.
    pub fn errors_left_out(&self) -> Option<String> {
        let names = self.inputs_with_errors().join(", ");
        let remark = format!(
            "{names}: its errors of n and κ are not in the error bars of a stack of plates; run the study with the table moved by \
             one error to see what they do"
        );
        let is_stack = self.composed().is_some_and(|composed| !composed.layers.is_empty());
        (is_stack && !names.is_empty()).then_some(remark)
    }

    /// Names of the tables whose errors are known, each once.
    pub fn inputs_with_errors(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for place in self.all_moves().into_iter().map(|by| by.place) {
            let name = self.spectrum(place).name();
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// What the tables say of quantities that are not determined, one line each.
    pub fn undetermined_inputs(&self) -> BTreeSet<String> {
        let mut said = BTreeSet::new();
        for spectrum in self.places().into_iter().map(|place| self.spectrum(place)) {
            for remark in spectrum.undetermined() {
                let name = spectrum.name();
                said.insert(format!("{name}: {remark}; every number that depends on it is as uncertain"));
            }
        }
        said
    }

    /// This study with a table moved.
    pub fn moved(&self, by: &InputMove) -> Study {
        let mut study = self.clone();
        let Some(spectrum) = self.spectrum(by.place).moved(by.axis, by.times) else { return study };
        let material = match by.place {
            InputPlace::Core(pigment) => &mut study.pigments[pigment].material,
            InputPlace::Shell(pigment, layer) => &mut study.pigments[pigment].shell[layer],
            InputPlace::Binder(layer) | InputPlace::Dissolved(layer, _) => study.binder_mut(layer),
        };
        match by.place {
            InputPlace::Dissolved(_, i) => material.dissolved[i].1 = spectrum,
            _ => material.spectrum = spectrum,
        }
        material.index = self.wavelengths_nm.iter().map(|nm| material.index_at(1e-3 * nm)).collect();
        study
    }

    /// All places of tables.
    fn places(&self) -> Vec<InputPlace> {
        let mut places = Vec::new();
        for (i, pigment) in self.pigments.iter().enumerate() {
            places.push(InputPlace::Core(i));
            places.extend((0..pigment.shell.len()).map(|layer| InputPlace::Shell(i, layer)));
        }
        for (layer, binder) in self.binders().into_iter().enumerate() {
            places.push(InputPlace::Binder(layer));
            places.extend((0..binder.dissolved.len()).map(|i| InputPlace::Dissolved(layer, i)));
        }
        places
    }

    fn spectrum(&self, place: InputPlace) -> &Spectrum {
        match place {
            InputPlace::Core(pigment) => &self.pigments[pigment].material.spectrum,
            InputPlace::Shell(pigment, layer) => &self.pigments[pigment].shell[layer].spectrum,
            InputPlace::Binder(layer) => &self.binders()[layer].spectrum,
            InputPlace::Dissolved(layer, i) => &self.binders()[layer].dissolved[i].1,
        }
    }
}
