//! What all pages are made of: their beginning and style, and embedded pictures.

use crate::chart::Chart;
use crate::figure::DrawResult;
use crate::store::identity::METHOD_VERSION;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use minijinja::Environment;
use serde::Serialize;

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

impl Figure {
    /// A chart under a heading.
    ///
    /// # Errors
    /// As [`Chart::svg`].
    pub fn new(heading: &str, chart: &Chart, caption: impl Into<String>) -> DrawResult<Self> {
        Ok(Self { heading: heading.to_owned(), data: svg_data(&chart.svg()?), caption: caption.into() })
    }
}

/// Program and method of a page, for its footer.
pub fn made_by() -> String {
    format!("{}, method {METHOD_VERSION}", crate::evaluate::summary::program())
}

/// What all pages begin with: `head.html`, which takes `title`, and `program` and `swatch` if there
/// are any.
///
/// # Errors
/// None of its own: the templates are part of the program.
pub fn templates<'a>() -> Result<Environment<'a>, minijinja::Error> {
    let mut templates = Environment::new();
    templates.add_template("style.css", STYLE)?;
    templates.add_template("head.html", include_str!("head.html"))?;
    Ok(templates)
}

/// Renders a page from its template, which begins with `head.html`; all text is escaped.
///
/// # Errors
/// A template that is not well-formed, or that takes what `data` lacks.
pub fn rendered(layout: &str, data: impl Into<minijinja::Value>) -> Result<String, minijinja::Error> {
    let mut templates = templates()?;
    templates.add_template("page.html", layout)?;
    templates.get_template("page.html")?.render(data)
}

/// A colour as `#rrggbb`.
pub fn hex([r, g, b]: [u8; 3]) -> String {
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
