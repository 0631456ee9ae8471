//! Pages on a study.

use crate::draw::page::templates;
use crate::numerics::estimate::Estimate;
use minijinja::Value;

/// Renders the page on a study.
pub(super) fn on_study(data: impl Into<Value>) -> Result<String, minijinja::Error> {
    let mut templates = templates()?;
    templates.add_filter("in_words", in_words);
    templates.add_filter("fixed", |x: f64, decimals: usize| format!("{x:.decimals$}"));
    templates.add_filter("plain", |x: f64| x.to_string());
    templates.add_filter("percent", |share: f64| format!("{} %", (share * 1e4).round() / 1e2));
    templates.add_filter("power", |x: f64, digits: Option<usize>| format!("{x:.*e}", digits.unwrap_or(1)));
    templates.add_template("study.html", include_str!("study.html"))?;
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

    /// A page of a composed layer without numbers.
    fn page(status: &str) -> String {
        let nothing: [f64; 0] = [];
        let study = context! {
            angles => context!(strata => 0, exact_deg => [0.0]),
            layer => context!(period_um => [1.0, 1.0], binder => context!(source => "1.5"), index_in => 1.0, index_out => 1.0),
            variation => context!(cell => "fixed", thickness_std_um => 0.0),
            paper => context!(source => "1", coupling => context!(optical_contact => ())),
            wavelengths_nm => [550.0],
            goal => context!(tolerance => 1e-4),
        };
        let composed = context!(slab_um => 1.0, thicknesses_um => [2.0], directions => [3, 3]);
        let largest = context!(chance => 0.0, model => 0.0, grid => 0.0, directions => 0.0, inputs => 0.0);
        let solves = context!(finished => 3, asked => 9);
        let numbers = context!(composed, largest, solves, solve_seconds => 0.0, colours => nothing);
        let page = context!(title => "<b>&", thicknesses_um => [2.0], solver => "krylov", status, study);
        on_study(context!(..page, ..numbers)).unwrap()
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
