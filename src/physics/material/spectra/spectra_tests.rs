//! Tables, records and the refusals of both.

use super::*;
use crate::material::kramers_kronig::KnownIndex;
use std::io::Write;

fn file(text: &str) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    file
}

#[test]
fn a_table_is_linear_between_rows_and_exact_on_them() {
    let csv = file("# measured by me\nwavelength_nm, kappa, n\n400, 0.1, 1.4\n500, 0.3, 1.6\n");
    let spectrum = Spectrum::from_csv(csv.path(), None).unwrap();
    assert_eq!(spectrum.range_nm(), Some([400.0, 500.0]));
    for (um, n, kappa) in [(0.4, 1.4, 0.1), (0.425, 1.45, 0.15), (0.5, 1.6, 0.3)] {
        let eta = spectrum.index(um).unwrap();
        approx::assert_abs_diff_eq!(eta.re, n, epsilon = 1e-14);
        approx::assert_abs_diff_eq!(eta.im, kappa, epsilon = 1e-14);
    }
}

/// Tables of instruments, spreadsheets and the collection's own site.
#[test]
fn tables_of_other_programs_are_read() {
    let read = |text: &str| Spectrum::from_csv(file(text).path(), None).unwrap();
    let site = read("wl,n\n0.4,1.4\n0.6,1.6\n\nwl,k\n0.3,0.0\n0.5,0.2\n0.7,0.0\n");
    let eta = site.index(0.55).unwrap();
    assert!((eta.re - 1.55).abs() < 1e-12 && (eta.im - 0.15).abs() < 1e-12, "{eta}");
    assert_eq!(site.range_nm(), Some([400.0, 600.0]));
    let clear = read("wl,n\n0.4,1.4\n0.6,1.6\n").index(0.5).unwrap();
    assert!((clear - Complex64::new(1.5, 0.0)).norm() < 1e-12);
    let plain = read("wavelength_nm,n,kappa\n400,1.4,0.1\n600,1.6,0.3\n").index(0.5).unwrap();
    for text in [
        "sep=;\n# mine\nwavelength_nm;n;kappa\n# more\n600;1,6;0,3\n400;1,4;0,1\n",
        "wl,n,k\n0.6,1.6,0.3\n0.4,1.4,0.1\n",
        "wavelength (nm)\tk\tn\n400\t0.1\t1.4\n400\t0.1\t1.4\n600\t0.3\t1.6\n",
    ] {
        assert!((read(text).index(0.5).unwrap() - plain).norm() < 1e-12, "{text}");
    }
    let nm = Spectrum::from_csv(file("wl,n\n400,1.4\n600,1.6\n").path(), None).unwrap_err().to_string();
    assert!(nm.contains("these look like nm"), "{nm}");
}

/// A bad row in the infrared blocks nothing in the visible.
#[test]
fn faulty_rows_cost_their_own_range() {
    let csv = file("wavelength_nm,n,kappa\n400,1.5,0.1\n700,1.5,0.1\n2000,1.5,-0.1\n3000,1.5,0.1\n");
    let table = Spectrum::from_csv(csv.path(), None).unwrap();
    assert_eq!(table.unusable([400.0, 700.0]), None);
    assert!(table.unusable([690.0, 800.0]).unwrap().reason.contains("row 3: kappa = -0.1"));
}

/// The squares of the moves are the covariance of n and κ. *Planted*: the correlation left out,
/// or its sign lost.
#[test]
fn errors_move_n_and_kappa_together() {
    let csv = file(
        "# n is not determined: two branches\nwavelength_nm,n,kappa,n_error,kappa_error,correlation\n\
         400,1.5,0.2,0.2,0.03,-0.97\n700,1.5,0.2,0.1,0.01,0.5\n",
    );
    let table = Spectrum::from_csv(csv.path(), None).unwrap();
    assert_eq!(table.undetermined(), ["n is not determined: two branches"]);
    for (um, n, kappa, correlation) in [(0.4, 0.2, 0.03, -0.97), (0.7, 0.1, 0.01, 0.5)] {
        let here = table.index(um).unwrap();
        let mut sums = [0.0; 3];
        for axis in [ErrorAxis::N, ErrorAxis::Kappa] {
            let step = table.moved(axis, 1.0).unwrap().index(um).unwrap() - here;
            let back = table.moved(axis, -1.0).unwrap().index(um).unwrap() - here;
            assert!((step + back).norm() < 1e-15);
            sums[0] += step.re * step.re;
            sums[1] += step.im * step.im;
            sums[2] += step.re * step.im;
        }
        for (sum, want) in sums.iter().zip([n * n, kappa * kappa, correlation * n * kappa]) {
            assert!((sum - want).abs() < 1e-15, "{sum} {want}");
        }
    }
    // no errors, or errors of zero
    let without = "wavelength_nm,n,kappa\n400,1.5,0.2\n700,1.5,0.2\n";
    let zero = "wavelength_nm,n,kappa,n_error,kappa_error\n400,1.5,0.2,0,0\n700,1.5,0.2,0,0\n";
    let [without, zero] = [without, zero].map(|text| {
        let table = Spectrum::from_csv(file(text).path(), None).unwrap();
        assert_eq!(table.moved(ErrorAxis::N, 1.0), None);
        serde_json::to_value(&table).unwrap()["tabulated"]["samples"].clone()
    });
    assert_eq!(without, zero);
    let bad = file("wavelength_nm,n,kappa,n_error\n400,1.5,0.2,-1\n700,1.5,0.2,0\n");
    let message = Spectrum::from_csv(bad.path(), None).unwrap_err().to_string();
    assert!(message.contains("n_error = -1"), "{message}");
}

/// Identity: a record of κ has the n of a table with its rows.
#[test]
fn recorded_kappa_has_the_n_of_its_table() {
    let known = KnownIndex::At { wavelength_um: 0.589, n: 1.65 };
    let csv = file("wavelength_nm,kappa\n400,0.1\n500,0.3\n600,0.05\n");
    let beside = BesideKappa::KramersKronig { known, n_error: 0.01 };
    let table = Spectrum::from_kappa(csv.path(), &beside, None).unwrap();
    let yaml = file(
        "DATA:\n  - type: tabulated k\n    data: |\n        0.4 0.1\n        0.5 0.3\n        0.6 0.05\n",
    );
    let record = Spectrum::from_recorded_kappa(yaml.path(), known, 0.01).unwrap();
    for um in [0.4, 0.47, 0.6] {
        assert!((record.index(um).unwrap() - table.index(um).unwrap()).norm() < 1e-12);
    }
    assert_eq!(record.error_axes().len(), table.error_axes().len());
    let both = "  - type: tabulated nk\n    data: |\n        0.4 1.5 0.1\n        0.6 1.5 0.2\n";
    let both = file(&format!("DATA:\n{both}"));
    let said = Spectrum::from_recorded_kappa(both.path(), known, 0.0).unwrap_err().to_string();
    assert!(said.contains("has n itself"), "{said}");
}

#[test]
fn n_is_in_the_file_or_beside_it() {
    let csv = file("wavelength_nm,kappa\n400,0.1\n500,0.3\n");
    assert_eq!(Spectrum::from_csv(csv.path(), Some(1.5)).unwrap().index(0.45).unwrap().re, 1.5);
    let without = Spectrum::from_csv(csv.path(), None).unwrap_err().to_string();
    assert!(without.contains("no real part n"), "{without}");
    let both = file("wavelength_nm,kappa,n\n400,0.1,1.4\n500,0.3,1.4\n");
    assert!(Spectrum::from_csv(both.path(), Some(1.5)).unwrap_err().to_string().contains("twice"));
    let yaml = file("DATA:\n  - type: tabulated k\n    data: |\n        0.4 0.1\n        0.6 0.2\n");
    let record = Spectrum::from_yaml(yaml.path(), Some(1.6)).unwrap();
    assert_eq!((record.index(0.5).unwrap().re, record.range_nm()), (1.6, Some([400.0, 600.0])));
    assert!(Spectrum::from_yaml(yaml.path(), None).is_err());
}

#[test]
fn bad_tables_and_wavelengths_are_refused_with_the_field() {
    let message = |text| {
        Spectrum::from_csv(file(text).path(), text.starts_with("wavelength_nm,kappa\n").then_some(1.4))
            .unwrap_err()
            .to_string()
    };
    assert!(message("wavelength_nm,kappa\n400,-0.1\n500,0.3\n").contains("row 1: kappa = -0.1"));
    assert!(message("wavelength_nm,kappa\n400,0.1\n500,12\n").contains("row 2: kappa = 12"));
    assert!(message("wavelength_nm,kappa\n500,0.1\n500,0.3\n").contains("two rows at 500 nm"));
    assert!(message("wavelength_nm,kappa\n500,NaN\n600,0.3\n").contains("kappa = NaN"));
    assert!(message("wavelength_nm,kappa,n\n500,1,0\n600,0.3,1\n").contains("n = 0"));
    assert!(
        message("wavelength_nm,kappa,n\n500,1,\n600,0.3,1\n").contains("line 2, column n: an empty cell")
    );
    assert!(message("wavelength_nm,kappa\n0.5,0.1\n0.6,0.3\n").contains("these look like µm"));
    assert!(message("wavelength_nm,kappa\n500,0.1\n").contains("1 rows"));
    assert!(message("lambda,kappa\n500,0.1\n600,0.1\n").contains("lambda"));
    assert!(
        Spectrum::from_csv("no/such/file.csv", None).unwrap_err().to_string().contains("no/such/file.csv")
    );
    let yellow = Spectrum::synthetic("yellow").unwrap();
    assert!(yellow.index(0.30).unwrap_err().to_string().contains("380 to 780 nm"));
    assert!(yellow.index(f64::NAN).is_err() && yellow.index(0.0).is_err());
    assert!(yellow.index(0.38).is_ok() && yellow.index(0.78).is_ok());
    assert!(Spectrum::synthetic("mauve").is_err());
    assert!(Spectrum::constant(1.4, -0.1).is_err() && Spectrum::constant(0.0, 0.1).is_err());
}

const ANCHORED: BesideKappa =
    BesideKappa::KramersKronig { known: KnownIndex::At { wavelength_um: 0.589, n: 1.65 }, n_error: 0.01 };

/// A file of κ has n by its relation to κ, the anchor's n at the anchor, and its unknowns as
/// independent moves. *Planted*: the moves dropped; n of the placeholder kept.
#[test]
fn a_table_of_kappa_has_n_by_kramers_and_kronig() {
    let band = |nm: f64| 0.3 * (-((nm - 550.0) / 40.0).powi(2)).exp() + 0.01;
    let rows: String =
        (0..=76).map(|k| 400.0 + 5.0 * f64::from(k)).map(|nm| format!("{nm},{}\n", band(nm))).collect();
    let csv = file(&format!("wavelength_nm,kappa\n{rows}"));
    let spectrum = Spectrum::from_kappa(csv.path(), &ANCHORED, None).unwrap();
    let n = |nm: f64| spectrum.index(1e-3 * nm).unwrap().re;
    assert!((n(589.0) - 1.65).abs() < 2e-3, "{}", n(589.0));
    // anomalous within the band: n rises through it towards the red
    assert!(n(590.0) - n(510.0) > 0.1, "{} {}", n(510.0), n(590.0));
    let axes = spectrum.error_axes();
    assert_eq!(axes, (0..3).map(ErrorAxis::Change).collect::<Vec<_>>(), "ultraviolet, infrared, anchor");
    let moved = |axis: usize, nm: f64| {
        spectrum.moved(ErrorAxis::Change(axis), 1.0).unwrap().index(1e-3 * nm).unwrap().re - n(nm)
    };
    assert!(
        moved(0, 400.0) > 0.005 && moved(0, 589.0).abs() < 1e-3,
        "{} {}",
        moved(0, 400.0),
        moved(0, 589.0)
    );
    assert!((moved(2, 450.0) - 0.01).abs() < 1e-12);
    let with_errors = file(&format!("wavelength_nm,kappa,kappa_error\n{}", rows.replace('\n', ",0.02\n")));
    let spectrum = Spectrum::from_kappa(with_errors.path(), &ANCHORED, None).unwrap();
    let moved = spectrum.moved(ErrorAxis::Change(3), 1.0).unwrap().index(0.45).unwrap();
    assert!((moved.im - spectrum.index(0.45).unwrap().im - 0.02).abs() < 1e-12);
}

/// n by Kramers and Kronig takes κ from everywhere: a line drawn over a gap beyond the wavelengths
/// in use is reported. *Planted*: gaps within these alone.
#[test]
fn gaps_in_kappa_are_told_wherever_they_are_where_n_follows_from_it() {
    let rows = |last: &str| {
        let near: String = (0..=30).map(|k| format!("{},0.1\n", 400 + 10 * k)).collect();
        file(&format!("wavelength_nm,kappa\n{near}{last}"))
    };
    let related = Spectrum::from_kappa(rows("2000,0.1\n").path(), &ANCHORED, None).unwrap();
    assert_eq!(related.widest_gap_nm([400.0, 700.0]), Some([700.0, 2000.0]));
    let told = |text: &str, beside: &BesideKappa| {
        Spectrum::from_kappa(rows(text).path(), beside, None).unwrap().widest_gap_nm([400.0, 700.0])
    };
    assert_eq!(told("2000,0.1\n", &BesideKappa::Constant(1.6)), None);
    assert_eq!(told("710,0\n2000,0\n", &ANCHORED), None);
}

/// A = εcd of a dilution and κ = A λ ln 10/(4π φ d) are one number: 0.02 g/l of density 2 are a
/// share of 1e-5; over 10 mm A = 1 at 500 nm is κ = 0.9162.
#[test]
fn the_absorbance_of_a_dilution_is_kappa() {
    let csv = file("wavelength_nm,absorbance\n500,1\n600,0.5\n700,-0.001\n");
    let dilution = Dilution { path_mm: 10.0, concentration_g_per_l: 0.02, density_g_per_cm3: 2.0 };
    let spectrum = Spectrum::from_kappa(csv.path(), &BesideKappa::Constant(1.6), Some(&dilution)).unwrap();
    let kappa = [0.5, 0.6, 0.7].map(|um| spectrum.index(um).unwrap().im);
    approx::assert_relative_eq!(kappa[0], 0.916_17, max_relative = 1e-4);
    approx::assert_relative_eq!(kappa[1], 0.6 * kappa[0], max_relative = 1e-12);
    assert_eq!(kappa[2], 0.0);
    let said = |beside: &BesideKappa, dilution: Option<&Dilution>, text: &str| {
        Spectrum::from_kappa(file(text).path(), beside, dilution).unwrap_err().to_string()
    };
    let absorbance = "wavelength_nm,absorbance\n500,1\n600,0.5\n";
    assert!(said(&ANCHORED, None, absorbance).contains("path, concentration and density"));
    let kappa = "wavelength_nm,kappa\n500,1\n600,0.5\n";
    assert!(said(&ANCHORED, Some(&dilution), kappa).contains("no column absorbance"));
    let twice = "wavelength_nm,kappa,n\n500,1,1.5\n600,0.5,1.5\n";
    assert!(said(&ANCHORED, None, twice).contains("given twice"));
    let gap = "wavelength_nm,kappa\n500,0.1\n550,-1\n600,0.1\n";
    assert!(said(&ANCHORED, None, gap).contains("needs every row"));
    let strong = "wavelength_nm,kappa\n400,0\n540,0.1\n580,9\n620,0.1\n700,0\n";
    assert!(said(&ANCHORED, None, strong).contains("n must be above 0"));
}
