//! The report page of a study: one HTML file with embedded pictures.

use crate::draw::OutputError;
use crate::draw::chart::Chart;
use crate::store::identity::METHOD_VERSION;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use minijinja::{Environment, Value, value::Serde};
use serde::Serialize;

/// Contents of the page; its template is `page.html`.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Page {
    /// The study's title.
    pub title: String,
    /// The study in one sentence.
    pub summary: String,
    /// What is missing if the study is unfinished.
    pub partial: Option<String>,
    /// The picture of the ink on paper.
    pub picture: Option<Picture>,
    /// Colours in words and numbers.
    pub colour: Option<Value>,
    /// Plots.
    pub figures: Vec<Figure>,
    /// Hiding power and differences, where there are colours.
    pub ink_maker: Option<MakerBlock>,
    /// The parts of the uncertainty.
    pub certainty: Vec<Meant>,
    /// The settings of the study.
    pub asked: Vec<Named>,
    /// The packings that were made.
    pub packings: Vec<Value>,
    /// Solves and packings that failed.
    pub failures: Vec<FailureRow>,
    /// What the numbers do not cover.
    pub limits: Vec<String>,
    /// What is needed to reproduce the results.
    pub provenance: Provenance,
}

/// An embedded image.
#[derive(Clone, Debug, Serialize)]
pub struct Picture {
    /// A `data:` address.
    pub data: String,
    /// Caption.
    pub caption: String,
}

/// A figure under its own heading.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// Heading over the figure.
    pub heading: String,
    /// The figure as a data address.
    pub data: String,
    /// Caption.
    pub caption: String,
}

/// Numbers for an ink maker.
#[derive(Clone, Debug, Serialize)]
pub struct MakerBlock {
    /// `#rrggbb` and name of each swatch.
    pub swatches: Vec<Named>,
    /// Numbers and what they mean.
    pub rows: Vec<Meant>,
}

/// A number and what it means.
#[derive(Clone, Debug, Serialize)]
pub struct Meant {
    /// The quantity.
    pub name: String,
    /// Its value.
    pub value: String,
    /// What it means.
    pub meaning: String,
}

/// A row of name and value; `code` sets the value in a monospaced face.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Named {
    /// The quantity.
    pub name: String,
    /// Its value.
    pub value: String,
    /// Whether the value is set as code.
    pub code: bool,
}

/// A solve that has no result.
#[derive(Clone, Debug, Serialize)]
pub struct FailureRow {
    /// Which solve.
    pub point: String,
    /// The error's message.
    pub reason: String,
}

/// Where the numbers come from.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Provenance {
    /// Program and version.
    pub program: String,
    /// What is needed to reproduce them.
    pub rows: Vec<Named>,
}

impl Picture {
    /// An image with its caption.
    pub fn new(data: String, caption: &str) -> Self {
        Self { data, caption: caption.to_owned() }
    }
}

impl Figure {
    /// A chart under a heading.
    ///
    /// # Errors
    /// As [`Chart::svg`].
    pub fn new(heading: &str, chart: &Chart, caption: String) -> Result<Self, OutputError> {
        Ok(Self { heading: heading.to_owned(), data: svg_data(&chart.svg()?), caption })
    }
}

impl Meant {
    /// A quantity with its value and what it means.
    pub fn new(name: &str, value: String, meaning: impl Into<String>) -> Self {
        Self { name: name.to_owned(), value, meaning: meaning.into() }
    }
}

impl Named {
    /// A row of plain text.
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.into(), code: false }
    }

    /// A row whose value is set as code.
    pub fn code(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self { code: true, ..Self::new(name, value) }
    }
}

/// Program and method of a page, for its footer.
pub(crate) fn made_by() -> String {
    format!("{}, method {METHOD_VERSION}", crate::evaluate::summary::program())
}

impl Page {
    /// The page as HTML; all text is escaped.
    ///
    /// # Errors
    /// The template does not fit the data, which is a bug.
    pub fn html(&self) -> Result<String, minijinja::Error> {
        rendered(include_str!("page.html"), Serde(self))
    }
}

/// What all pages begin with: `head.html`, which takes `title`, and `program` and `swatch` if there
/// are any.
pub(crate) fn templates<'a>() -> Result<Environment<'a>, minijinja::Error> {
    let mut templates = Environment::new();
    templates.add_template("style.css", STYLE)?;
    templates.add_template("head.html", include_str!("head.html"))?;
    Ok(templates)
}

/// Renders a page from its template, which begins with `head.html`; all text is escaped.
pub(crate) fn rendered(layout: &str, data: impl Into<minijinja::Value>) -> Result<String, minijinja::Error> {
    let mut templates = templates()?;
    templates.add_template("page.html", layout)?;
    templates.get_template("page.html")?.render(data)
}

/// A colour as `#rrggbb`.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// The style sheet of every page, for templates that include `style.css`.
pub const STYLE: &str = include_str!("style.css");

/// A PNG as a `data:` address.
pub fn png_data(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png))
}

/// An SVG as a `data:` address.
pub fn svg_data(svg: &str) -> String {
    format!("data:image/svg+xml;base64,{}", BASE64_STANDARD.encode(svg))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_a_partial_run_says_so_first() {
        let partial = Some("3 of 9 solves are there.".to_owned());
        let page = Page { title: "<b>&".into(), partial, ..Page::default() };
        let html = page.html().unwrap();
        assert!(html.contains("<h1>&lt;b&gt;&amp;</h1>"));
        let banner = html.find("Partial results").unwrap();
        assert!(banner < html.find("<h2>").unwrap());
    }

    #[test]
    fn a_whole_run_has_no_banner() {
        assert!(!Page::default().html().unwrap().contains("Partial results"));
    }
}
