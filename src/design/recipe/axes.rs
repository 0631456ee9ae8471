//! Which variables enter after the solves, and are composed exactly, and which are interpolated
//! between variants.
//!
//! Names of fields do not decide it: a variable is composed where the studies at both ends of
//! its range, and between them, take the same solves. That holds for what lies behind the layer,
//! for thicknesses of a layer that is composed of slabs, and for clear layers of such a stack.

use super::{DesignTask, corner};
use crate::appearance::paper::Albedo;
use crate::input::study::{Paper, Study};
use crate::store::identity::Key;

/// Places of a range at which studies are compared with that at its beginning.
const COMPARED: [f64; 3] = [0.37, 0.71, 1.0];

impl DesignTask {
    /// Numbers of the variables that are interpolated between variants.
    pub fn interpolated(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.variables.len()).filter(|&i| !self.variables[i].composed)
    }

    /// Numbers of the variables of which every value is composed from the same solves.
    pub fn composed(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.variables.len()).filter(|&i| self.variables[i].composed)
    }

    /// Names of these variables.
    pub fn names(&self, of: impl Iterator<Item = usize>) -> Vec<String> {
        of.map(|i| self.variables[i].name.clone()).collect()
    }

    /// The places of a recipe on the interpolated axes.
    pub(in crate::design) fn interpolated_places(&self, places: &[f64]) -> Vec<f64> {
        self.interpolated().map(|i| places[i]).collect()
    }

    /// The places of a recipe on the composed axes.
    pub(in crate::design) fn composed_places(&self, places: &[f64]) -> Vec<f64> {
        self.composed().map(|i| places[i]).collect()
    }

    /// A recipe at other places of the composed axes.
    pub(in crate::design) fn moved(&self, places: &[f64], composed: &[f64]) -> Vec<f64> {
        let mut moved = places.to_vec();
        self.composed().zip(composed).for_each(|(i, place)| moved[i] = *place);
        moved
    }

    /// The recipe at these places of the interpolated axes, in the middle of the composed ones.
    pub(in crate::design) fn between(&self, interpolated: &[f64]) -> Vec<f64> {
        let mut places = vec![0.5; self.variables.len()];
        self.interpolated().zip(interpolated).for_each(|(i, place)| places[i] = *place);
        places
    }

    /// Finds the variables that are composed.
    pub(super) fn tell_axes_apart(&mut self) {
        for i in 0..self.variables.len() {
            let is_first_list = self.variables.iter().all(|variable| !variable.listed);
            let is_thickness = self.variables[i].name.ends_with("thickness_um");
            // beside the smallest thickness, which sets the slabs, others take no solves
            let forms = if is_first_list && is_thickness { &[false, true][..] } else { &[false] };
            for &listed in forms {
                self.variables[i].listed = listed;
                self.variables[i].composed = self.takes_no_solves(i);
                if self.variables[i].composed {
                    break;
                }
                self.variables[i].listed = false;
            }
        }
    }

    /// Whether studies anywhere on a variable's range take the same solves, at all corners of the
    /// others.
    fn takes_no_solves(&self, variable: usize) -> bool {
        let count = self.variables.len();
        let is_corner = |c: &usize| (c >> variable) & 1 == 0;
        let at = |corner: &[f64], place: f64| {
            let mut places = corner.to_vec();
            places[variable] = place;
            self.study(&places).ok().map(|study| solves(&study))
        };
        (0..1 << count).filter(is_corner).all(|c| {
            let corner = corner(c, count);
            let first = at(&corner, 0.0);
            first.is_some() && COMPARED.iter().all(|&place| at(&corner, place) == first)
        })
    }
}

/// Hashes of what is solved of a study, in its order.
fn solves(study: &Study) -> Vec<Key> {
    let portions = study.portions();
    let all = if portions.is_empty() { std::slice::from_ref(study) } else { &portions };
    all.iter().map(|study| bare(study).key()).collect()
}

/// A study over a paper that returns nothing; only its contact is that of the study.
fn bare(study: &Study) -> Study {
    let paper = Paper {
        source: String::new(),
        albedo: Albedo::Constant(0.0),
        coupling: study.paper.coupling,
        measured: None,
        fluorescence: None,
        dots: None,
    };
    Study { paper, ..study.clone() }
}

#[cfg(test)]
#[path = "axes_tests.rs"]
mod tests;
