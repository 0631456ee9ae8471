use super::*;
use crate::appearance::paper::{Coupling, MirroredSky};
use crate::numerics::estimate::Estimate;
use inkwave_validation::fixtures::molecular_ink;

/// Ends of the drawn lines of the first colour.
fn lines(svg: &str) -> Vec<usize> {
    let colour = "stroke=\"#000000\" stroke-width=\"2\" points=\"";
    let all =
        svg.split(colour).skip(1).map(|rest| rest.split('"').next().unwrap_or("").split_whitespace().count());
    all.collect()
}

/// *Planted*: a line through the missing point has five ends, and one tick at 1.
#[test]
fn lines_do_not_run_through_missing_points_and_ticks_stand_at_the_data() {
    let points = [(0.8, 10.0), (1.2, 20.0), (1.6, f64::NAN), (2.4, 20.0), (3.2, 30.0)];
    let plot = Chart::log_log("", "period, µm", "applications", vec![Curve::new("a", Style::Data, points)]);
    let svg = plot.svg().unwrap();
    // two parts of the line, and its key
    assert_eq!(lines(&svg), [2, 2, 2], "{svg}");
    assert!(["0.8", "1.2", "2.4", "3.2"].iter().all(|tick| svg.contains(&format!(">\n{tick}\n<"))), "{svg}");
    assert!(!svg.contains(">\n1\n<"));
}

#[test]
fn ticks_may_have_words() {
    let curve = Curve::new("a", Style::Data, [(0.0, 1.0), (0.08, 2.0)]);
    let x_ticks = vec![(0.0, "11-21 14:32".to_owned()), (0.08, "11-21 16:27".to_owned())];
    let svg = Chart { x_ticks, ..Chart::linear("", "", "", vec![curve]) }.svg().unwrap();
    assert!(svg.contains("11-21 14:32") && svg.contains("11-21 16:27"), "{svg}");
}

/// *Planted*: thirty dates of one night run into each other.
#[test]
fn words_of_ticks_do_not_touch() {
    let curve = Curve::new("a", Style::Data, (0..30).map(|k| (f64::from(k), 1.0)));
    let x_ticks = (0..30).map(|k| (f64::from(k), format!("2026-11-{:02} 05:36Z", k + 1))).collect();
    let svg = Chart { x_ticks, ..Chart::linear("", "", "", vec![curve]) }.svg().unwrap();
    assert!((2..=4).contains(&svg.matches("05:36Z").count()), "{svg}");
}

/// *Planted*: a guide with markers looks as if it had been measured.
#[test]
fn guides_are_not_drawn_as_data() {
    let data = Curve::new("data", Style::Data, [(1.0, 1.0), (10.0, 100.0)]);
    let count = |curves: Vec<Curve>| {
        let svg = Chart::log_log("", "x", "y", curves).svg().unwrap();
        svg.matches("<polygon opacity").count() + svg.matches("<polygon fill=\"#").count()
    };
    let guide = Curve::guide("order 2", &data, 2.0);
    assert!(guide.exponent().is_none());
    // powers are exact to rounding
    for (have, want) in guide.points.iter().zip(&data.points) {
        assert!((have[1] - want[1]).abs() <= 1e-12 * want[1], "{have:?} {want:?}");
    }
    // two markers and one in the legend; the guide adds its band alone
    assert_eq!((count(vec![data.clone()]), count(vec![data, guide])), (3, 4));
}

fn spectra() -> Chart {
    let curves = [0.05, 0.15, 0.3].map(|share| {
        let ink = molecular_ink("yellow", share, Coupling::Gap);
        let view = ink.at(0.0).unwrap();
        let spectrum = ink.spectrum(|l| l.natural_light(&view, MirroredSky::Included));
        let with_error = |v: &f64| Estimate { value: *v, standard_error: Some(0.02) };
        let points = ink.wavelengths_nm().iter().copied().zip(spectrum.values.iter().map(with_error));
        Curve::measured(format!("{:.0} %", 100.0 * share), points)
    });
    let y_label = "reflectance factor, natural light";
    let title = "Yellow (synthetic) on paper 0.9";
    Chart { from_zero: true, ..Chart::linear(title, "wavelength, nm", y_label, curves.to_vec()) }
}

#[test]
fn charts_have_axes_units_curves_and_error_bars() {
    let svg = spectra().svg().unwrap();
    for text in
        ["wavelength, nm", "reflectance factor, natural light", "15 %", "Yellow (synthetic) on paper 0.9"]
    {
        assert!(svg.contains(text), "{text} is missing");
    }
    assert!(!svg.contains("NaN"));
    let bitmap = spectra().bitmap().unwrap();
    let (width, height) = spectra().leaf().size();
    assert_eq!((bitmap.width, bitmap.height), (width as usize, height as usize));
    if let Some(folder) = std::env::var_os("INKWAVE_PICTURES") {
        let folder = std::path::PathBuf::from(folder);
        std::fs::write(folder.join("spectra.png"), bitmap.png(&[("Source", "test")]).unwrap()).unwrap();
        std::fs::write(folder.join("spectra.svg"), svg).unwrap();
    }
}

#[test]
fn a_chart_without_points_says_so_and_a_flat_one_is_drawn() {
    let of = |y: f64| Chart::linear("x", "", "", vec![Curve::new("", Style::Data, [(1.0, y)])]);
    for empty in [Chart::default(), of(f64::NAN), Chart { log: [false, true], ..of(0.0) }] {
        assert!(empty.is_empty());
        assert!(empty.svg().unwrap().contains("Nothing to show"));
    }
    // an error bar that is not known, or has no end, is none
    for bar in [f64::NAN, f64::INFINITY] {
        let curve = Curve::with_bars("", Style::Data, [[1.0, 2.0, bar]]);
        let svg = Chart::linear("x", "", "", vec![curve]).svg().unwrap();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
    assert!(of(0.0).svg().is_ok() && Chart { from_zero: true, ..of(0.0) }.svg().is_ok());
}
