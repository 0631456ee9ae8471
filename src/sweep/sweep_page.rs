//! The page of a sweep: one HTML file with its contact sheets and figures inside.

use crate::report::page::Picture;
use minijinja::{Environment, value::Serde};
use serde::Serialize;

/// All that the page says; its layout is `sweep.html`.
#[derive(Clone, Debug, Serialize)]
pub struct SweepPage {
    pub title: String,
    pub summary: String,
    /// What is missing, while the sweep is not finished.
    pub partial: Option<String>,
    pub sheets: Vec<Picture>,
    pub conclusions: Vec<ConclusionRow>,
    pub axes: Vec<String>,
    /// Name of the variant that ΔE refers to.
    pub reference: String,
    pub variants: Vec<VariantRow>,
    pub figures: Vec<Picture>,
    pub program: String,
}

/// One inequality and its verdict.
#[derive(Clone, Debug, Serialize)]
pub struct ConclusionRow {
    pub id: String,
    pub statement: String,
    pub inequality: String,
    pub measured: String,
    pub verdict: String,
    pub remark: String,
}

/// One variant.
#[derive(Clone, Debug, Serialize)]
pub struct VariantRow {
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
        let mut templates = Environment::new();
        templates.add_template("style.css", crate::report::page::STYLE)?;
        templates.add_template("sweep.html", include_str!("sweep.html"))?;
        templates.get_template("sweep.html")?.render(Serde(self))
    }
}
