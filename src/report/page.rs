//! Pages: HTML files with embedded pictures.

use crate::draw::DrawResult;
use crate::draw::chart::Chart;
use crate::numerics::estimate::Estimate;
use crate::store::identity::METHOD_VERSION;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use minijinja::{Environment, Value};
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
pub(crate) fn made_by() -> String {
    format!("{}, method {METHOD_VERSION}", crate::evaluate::summary::program())
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

/// Renders a page on a study from its template, which extends `page.html`.
pub(crate) fn on_study(layout: &str, data: impl Into<Value>) -> Result<String, minijinja::Error> {
    let mut templates = templates()?;
    templates.add_filter("in_words", in_words);
    templates.add_filter("fixed", |x: f64, decimals: usize| format!("{x:.decimals$}"));
    templates.add_filter("plain", |x: f64| x.to_string());
    templates.add_filter("percent", |share: f64| format!("{} %", (share * 1e4).round() / 1e2));
    templates.add_filter("power", |x: f64, digits: Option<usize>| format!("{x:.*e}", digits.unwrap_or(1)));
    templates.add_template("page.html", include_str!("page.html"))?;
    templates.add_template("study.html", layout)?;
    templates.get_template("study.html")?.render(data)
}

/// A number with its standard error, which it has itself or which stands beside it; errors below
/// `least` are not shown.
fn in_words(number: Value, decimals: usize, error: Option<f64>, least: Option<f64>) -> String {
    let own = |key: &str| number.get_attr(key).ok()?.try_into().ok();
    let value = own("value").or_else(|| number.clone().try_into().ok()).unwrap_or(f64::NAN);
    let error = error.or_else(|| own("standard_error"));
    let standard_error = error.filter(|error| least.is_none_or(|least| *error >= least));
    Estimate { value, standard_error }.in_words(decimals)
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
    use minijinja::context;

    fn page(status: &str) -> String {
        let solves = context!(finished => 3, asked => 9);
        on_study("{% extends \"page.html\" %}", context!(title => "<b>&", status, solves)).unwrap()
    }

    #[test]
    fn text_is_escaped_and_a_partial_run_says_so_first() {
        let html = page("partial");
        assert!(html.contains("<h1>&lt;b&gt;&amp;</h1>") && html.contains("3 of 9 solves"));
        let banner = html.find("Partial results").unwrap();
        assert!(banner < html.find("<h2>").unwrap());
    }

    #[test]
    fn a_whole_run_has_no_banner() {
        assert!(!page("complete").contains("Partial results"));
    }
}
