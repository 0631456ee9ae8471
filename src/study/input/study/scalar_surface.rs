//! What the scalar wave does to the surface of paper: it crosses faces as s light does, whereas
//! bare paper is measured in unpolarised light.

use super::Study;
use crate::appearance::bare_paper::{BareSurface, PaperGeometry};
use crate::appearance::paper::Coupling;
use crate::wave::Wave;
use serde::Serialize;

/// Factors of a paper; a perfect white has 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PaperFactors {
    /// Lit at 45°, seen along the normal.
    pub lit_at_45: f64,
    /// Under a uniform sky, mirrored light included.
    pub natural_light: f64,
}

/// Bare paper beside the same paper below a clear layer of its own index, which changes nothing in
/// unpolarised light, at the wavelength at which they differ most at 45:0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScalarSurface {
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Index of the paper's medium.
    pub index: f64,
    /// The bare paper in unpolarised light.
    pub bare_paper: PaperFactors,
    /// The paper below such a layer, as the scalar wave has it.
    pub below_clear_layer: PaperFactors,
}

impl ScalarSurface {
    /// Both at one wavelength; `None` for what is no albedo.
    fn at(wavelength_nm: f64, albedo: f64, coupling: Coupling) -> Option<Self> {
        let factors = |surface: &BareSurface| {
            Some(PaperFactors {
                lit_at_45: surface.factor(albedo, PaperGeometry::LitAt45).ok()?,
                natural_light: surface.factor(albedo, PaperGeometry::NaturalLight).ok()?,
            })
        };
        Some(Self {
            wavelength_nm,
            index: coupling.index_out(),
            bare_paper: factors(&BareSurface::new(coupling))?,
            below_clear_layer: factors(&BareSurface::of_s_light(coupling))?,
        })
    }

    /// The row, wavelength in nm and albedo, at which both differ most at 45:0; `None` where the
    /// paper has no surface.
    pub fn of_rows(rows: impl Iterator<Item = (f64, f64)>, coupling: Coupling) -> Option<Self> {
        let at = |(nm, albedo): (f64, f64)| Self::at(nm, albedo, coupling);
        let size = |surface: &Self| surface.difference().abs();
        let has_surface = coupling.index_out() != 1.0;
        rows.filter(|_| has_surface).filter_map(at).max_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// How much more the paper reads at 45:0 below the layer.
    fn difference(&self) -> f64 {
        self.below_clear_layer.lit_at_45 - self.bare_paper.lit_at_45
    }

    /// What it means, in words.
    pub fn in_words(&self) -> String {
        format!(
            "the scalar wave crosses the paper's surface as s light, and bare paper is read in unpolarised light: below a clear \
             layer of its index, {}, this paper reads {:.3} at 45:0 and {:.3} under natural light, where bare it reads {:.3} and \
             {:.3} (at {} nm, where they differ most); light.wave = \"unpolarised\" has both alike",
            self.index,
            self.below_clear_layer.lit_at_45,
            self.below_clear_layer.natural_light,
            self.bare_paper.lit_at_45,
            self.bare_paper.natural_light,
            self.wavelength_nm
        )
    }
}

impl Study {
    /// What the scalar wave does to the surface of a paper whose bare factors enter the results:
    /// measured ones, and those beside dots or of densities. `None` where there is no surface, or
    /// none of these.
    pub fn scalar_surface(&self) -> Option<ScalarSurface> {
        let paper = &self.paper;
        let is_bare_seen = paper.measured.is_some() || paper.dots.is_some() || self.without_layers;
        if self.wave != Wave::Scalar || !is_bare_seen || self.no_paper().is_some() {
            return None;
        }
        let row = |&nm: &f64| Some((nm, paper.albedo.at(nm).ok()?));
        ScalarSurface::of_rows(self.wavelengths_nm.iter().filter_map(row), paper.coupling)
    }
}
