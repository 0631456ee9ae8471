//! The page of a sweep: one HTML file with its contact sheets and figures inside.

use crate::report::page::{Picture, rendered};
use minijinja::value::Serde;
use serde::Serialize;

/// All that the page says; its layout is `sweep.html`.
#[derive(Clone, Debug, Serialize)]
pub struct SweepPage {
    /// The sweep's title.
    pub title: String,
    /// What is finished, in a sentence.
    pub summary: String,
    /// What is missing, while the sweep is not finished.
    pub partial: Option<String>,
    /// How far the scalar wave is off, where a variant is scalar.
    pub scalar_error: Option<String>,
    /// Contact sheets.
    pub sheets: Vec<Picture>,
    /// The conclusions, those of each source apart.
    pub conclusions: Vec<ConclusionGroup>,
    /// Which variants come nearest to a wanted colour, where there is one.
    pub nearest: Option<Nearest>,
    /// Names of the axes: columns of the table of variants.
    pub axes: Vec<String>,
    /// Name of the variant that ΔE refers to.
    pub reference: String,
    /// One row a variant.
    pub variants: Vec<VariantRow>,
    /// Plots.
    pub figures: Vec<Picture>,
    /// Program and version.
    pub program: String,
}

/// The conclusions of one source.
#[derive(Clone, Debug, Serialize)]
pub struct ConclusionGroup {
    /// Whose they are; none where nobody is quoted.
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
    /// The bounds in words.
    pub inequality: String,
    /// The difference with its error.
    pub measured: String,
    /// The verdict as a word.
    pub verdict: String,
    /// What else is to be known.
    pub remark: String,
    /// The source's own words.
    pub quote: Option<String>,
    /// The quote in English.
    pub translation: Option<String>,
    /// Why this inequality and these bounds.
    pub because: Option<String>,
}

/// The variants nearest to a wanted colour.
#[derive(Clone, Debug, Serialize)]
pub struct Nearest {
    /// The wanted colour with its conditions.
    pub target: String,
    /// Which one is nearest, and how many cannot be told apart from it.
    pub summary: String,
    /// The nearest ones in their order.
    pub rows: Vec<NearRow>,
}

/// One of the variants nearest to a wanted colour.
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
    /// Y over black divided by Y over white, with its 95 % interval.
    pub contrast_ratio: String,
    /// Whether it can be told apart from the nearest.
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
    /// L*, a*, b*, C*, h, ΔE in words.
    pub numbers: Vec<String>,
    /// What is missing or failed; empty when the variant is finished.
    pub state: String,
}

impl SweepPage {
    /// The page as HTML; all text is escaped.
    ///
    /// # Errors
    /// The template does not fit the page's data, which is a fault of the program.
    pub fn html(&self) -> Result<String, minijinja::Error> {
        rendered(include_str!("sweep.html"), Serde(self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// *Planted*: the reason in the last of ten columns is a sliver at 1280 pixels.
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
