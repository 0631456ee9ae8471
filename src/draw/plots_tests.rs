use super::*;
use crate::appearance::paper::{Coupling, MirroredSky};
use inkwave_validation::fixtures::molecular_ink;
use std::path::PathBuf;

fn keep(plot: impl Fn(&Path) -> Result<(), FigureError>, name: &str) {
    if let Some(folder) = std::env::var_os("INKWAVE_PICTURES") {
        plot(&PathBuf::from(folder).join(name)).unwrap();
    }
}

fn spectra() -> Plot {
    let series = [0.05, 0.15, 0.3].map(|share| {
        let ink = molecular_ink("yellow", share, Coupling::Gap);
        let view = ink.at(0.0).unwrap();
        let spectrum = ink.spectrum(|l| l.natural_light(&view, MirroredSky::Included));
        let with_error = |v: &f64| Estimate { value: *v, standard_error: Some(0.02) };
        let y: Vec<_> = spectrum.values.iter().map(with_error).collect();
        Series::new(&format!("{:.0} %", 100.0 * share), ink.wavelengths_nm(), &y)
    });
    Plot {
        title: "Yellow (synthetic) on paper 0.9".into(),
        x_label: "wavelength, nm".into(),
        y_label: "reflectance factor, natural light".into(),
        series: series.to_vec(),
        ..Plot::default()
    }
}

#[test]
fn plots_have_axes_units_series_and_error_bars() {
    let svg = spectra().svg().unwrap();
    for text in
        ["wavelength, nm", "reflectance factor, natural light", "15 %", "Yellow (synthetic) on paper 0.9"]
    {
        assert!(svg.contains(text), "{text} is missing");
    }
    assert!(!svg.contains("NaN"));
    for name in ["spectra.png", "spectra.svg"] {
        keep(|path| spectra().write(path), name);
    }
}

#[test]
fn plots_are_written_by_their_ending() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.svg", "a.png"] {
        spectra().write(folder.path().join(name)).unwrap();
        assert!(std::fs::metadata(folder.path().join(name)).unwrap().len() > 1000);
    }
}

#[test]
fn empty_or_broken_plots_are_refused() {
    assert!(Plot::default().svg().unwrap_err().to_string().contains("series is empty"));
    let nan = Series::new("x", &[1.0], &[Estimate::unknown_error(f64::NAN)]);
    assert!(Plot { series: vec![nan], ..Plot::default() }.svg().is_err());
    assert!(spectra().write("/no/such/folder/a.svg").is_err());
    let flat = Series::new("x", &[1.0], &[Estimate::unknown_error(0.0)]);
    assert!(Plot { series: vec![flat], ..Plot::default() }.svg().is_ok());
}
