//! Pages on a study.

use crate::draw::page::templates;
use crate::numerics::estimate::Estimate;
use minijinja::Value;

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
    let part = |key: &str| number.get_attr(key).ok()?.try_into().ok();
    let value = part("value").or_else(|| number.clone().try_into().ok()).unwrap_or(f64::NAN);
    let error = error.or_else(|| part("standard_error"));
    let standard_error = error.filter(|error| least.is_none_or(|least| *error >= least));
    Estimate { value, standard_error }.in_words(decimals)
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
