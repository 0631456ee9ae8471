//! The page of a sweep: an HTML file that includes its contact sheets and figures.

use crate::report::page::{Picture, rendered};
use minijinja::value::Serde;
use serde::Serialize;

/// Everything on the page; its template is `sweep.html`.
#[derive(Clone, Debug, Serialize)]
pub struct SweepPage {
    /// The sweep's title.
    pub title: String,
    /// Says what is finished.
    pub summary: String,
    /// Says what is missing while the sweep is unfinished.
    pub partial: Option<String>,
    /// Describes the error of the scalar wave, if a variant is scalar.
    pub scalar_error: Option<String>,
    /// Contact sheets.
    pub sheets: Vec<Picture>,
    /// The conclusions, grouped by source.
    pub conclusions: Vec<ConclusionGroup>,
    /// The variants nearest to a target colour, if there is one.
    pub nearest: Option<Nearest>,
    /// Names of the axes, the first columns of the table of variants.
    pub axes: Vec<String>,
    /// Name of the reference variant of ΔE.
    pub reference: String,
    /// One row per variant.
    pub variants: Vec<VariantRow>,
    /// Plots.
    pub figures: Vec<Picture>,
    /// Program and version.
    pub program: String,
}

/// The conclusions of one source.
#[derive(Clone, Debug, Serialize)]
pub struct ConclusionGroup {
    /// The source; `None` without one.
    pub heading: Option<String>,
    /// Its conclusions.
    pub rows: Vec<ConclusionRow>,
}

/// One inequality and its verdict.
#[derive(Clone, Debug, Serialize)]
pub struct ConclusionRow {
    /// Short name.
    pub id: String,
    /// The conclusion as one sentence.
    pub statement: String,
    /// The inequality as text.
    pub inequality: String,
    /// The measured value with its error.
    pub measured: String,
    /// The verdict.
    pub verdict: String,
    /// Further remarks.
    pub remark: String,
    /// The wording of the source.
    pub quote: Option<String>,
    /// The quote in English.
    pub translation: Option<String>,
    /// Why this inequality and these bounds were chosen.
    pub because: Option<String>,
}

/// The variants nearest to a target colour.
#[derive(Clone, Debug, Serialize)]
pub struct Nearest {
    /// The target colour with its conditions.
    pub target: String,
    /// Names the nearest variant, and how many cannot be distinguished from it.
    pub summary: String,
    /// The nearest variants, in order.
    pub rows: Vec<NearRow>,
}

/// One of the variants nearest to a target colour.
#[derive(Clone, Debug, Serialize)]
pub struct NearRow {
    /// Labels of the variant on the axes.
    pub labels: Vec<String>,
    /// The variant's own page.
    pub link: String,
    /// `#rrggbb` of the print.
    pub hex: Option<String>,
    /// ΔE₀₀ with its 95 % interval.
    pub delta_e: String,
    /// Contrast ratio (Y over black divided by Y over white) with its 95 % interval.
    pub contrast_ratio: String,
    /// Whether it can be distinguished from the nearest.
    pub verdict: String,
}

/// One variant.
#[derive(Clone, Debug, Serialize)]
pub struct VariantRow {
    /// Labels of the variant on the axes.
    pub labels: Vec<String>,
    /// The variant's own page.
    pub link: Option<String>,
    /// `#rrggbb`
    pub hex: Option<String>,
    /// L*, a*, b*, C*, h, ΔE as text.
    pub numbers: Vec<String>,
    /// What is missing or has failed; empty if the variant is finished.
    pub state: String,
}

impl SweepPage {
    /// The page as HTML; all text is escaped.
    ///
    /// # Errors
    /// The template does not match the page's data, which is a bug.
    pub fn html(&self) -> Result<String, minijinja::Error> {
        rendered(include_str!("sweep.html"), Serde(self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// *Planted*: in the last of ten columns the reason would be only a few characters wide at 1280
    /// pixels.
    #[test]
    fn the_reason_of_a_failure_has_the_whole_width() {
        let row = |state: &str| VariantRow {
            labels: vec!["yellow".into(), "100".into()],
            link: None,
            hex: None,
            numbers: vec![String::new(); 6],
            state: state.into(),
        };
        let page = SweepPage {
            title: String::new(),
            summary: String::new(),
            partial: None,
            scalar_error: None,
            sheets: Vec::new(),
            conclusions: Vec::new(),
            nearest: None,
            axes: vec!["ink".into(), "diameter, nm".into()],
            reference: String::new(),
            variants: vec![row("4 failed: no room for grain 7"), row("")],
            figures: Vec::new(),
            program: String::new(),
        };
        let html = page.html().unwrap();
        assert!(html.contains("<td colspan=\"9\">4 failed: no room for grain 7</td>"), "{html}");
        assert!(html.contains("<th>diameter, nm</th>") && html.matches("colspan").count() == 1, "{html}");
    }
}
