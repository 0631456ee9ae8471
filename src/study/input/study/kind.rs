//! What is computed of a layer.

use super::{Composed, Portion, Study};

/// What is computed of a layer, and whether as a whole.
#[derive(Clone, Debug, PartialEq)]
pub enum StudyKind {
    /// The layer, solved at once, and the ink on its paper.
    InkOnPaper,
    /// The layer alone, solved at once; the reason why its directions allow no paper and no colour.
    LayerAlone(String),
    /// A layer that is composed of slabs, which have [studies](Study::portions) of their own, and
    /// the ink on its paper.
    Composed(Composed),
    /// One slab of a composed layer.
    Slab(Portion),
}

impl Study {
    /// How the layer is composed of slabs; `None` for layers and slabs that are solved at once.
    pub fn composed(&self) -> Option<&Composed> {
        if let StudyKind::Composed(composed) = &self.kind { Some(composed) } else { None }
    }

    /// The slab of a composed layer that this study is about; `None` for studies of whole layers.
    pub fn portion(&self) -> Option<&Portion> {
        if let StudyKind::Slab(portion) = &self.kind { Some(portion) } else { None }
    }

    /// Thicknesses of the layers that the study is about, µm: several of a composed layer alone.
    pub fn requested_um(&self) -> Vec<f64> {
        match self.composed() {
            Some(composed) => composed.thicknesses_um.clone(),
            None => vec![self.layer.thickness_um],
        }
    }

    /// Requests a composed layer in other thicknesses, µm; other layers keep their own.
    pub fn request_um(&mut self, thicknesses_um: Vec<f64>) {
        if let StudyKind::Composed(composed) = &mut self.kind {
            composed.thicknesses_um = thicknesses_um;
        }
    }

    /// Why the directions of the light allow no paper and no colour; `None` if they do.
    pub fn no_paper(&self) -> Option<&str> {
        match &self.kind {
            StudyKind::InkOnPaper | StudyKind::Composed(_) => None,
            StudyKind::LayerAlone(reason) => Some(reason),
            StudyKind::Slab(_) => Some("a slab of a composed layer"),
        }
    }
}
