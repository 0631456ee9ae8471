//! Files with wrong values, cut or damaged, and too large ones.

use super::{ANNULAR, CHART, FIELDS, cgats, cxf, reading, refusal, requested, spectrum};
use inkwave::input::measured::{
    MeasuredCondition, MeasuredContent, MeasuredReading, MeasuredRequest, MeasuredUnit,
};
use std::time::{Duration, Instant};

/// A wrong value that the study does not use blocks nothing; what is used is named by line, sample and value.
#[test]
fn faults_count_only_where_values_are_used() {
    let first = requested("", None, None);
    let infrared = "nm,R\n400,0.05\n550,0.4\n700,0.8\n790,0.8\n2400,-0.7\n2400,9e9\n2500,no light\n";
    assert_eq!(spectrum(infrared, &first).unwrap().at(700.0), Some(0.8));
    let needed = MeasuredRequest { used_nm: [400.0, 2450.0], ..MeasuredRequest::default() };
    let percent = MeasuredRequest { unit: Some(MeasuredUnit::Factor), ..needed };
    refusal(infrared, &percent, &["line 6", "-0.7 at 2400 nm"]);
    let table = "name,400,550,700\npaper,0.9,0.9,0.9\nink,0.05,,0.8\nblack,0.05\n";
    assert!(spectrum(table, &requested("paper", None, None)).is_ok());
    refusal(table, &requested("ink", None, None), &["\"ink\"", "line 3, 550 nm", "empty"]);
    refusal(table, &requested("black", None, None), &["\"black\"", "line 4", "2 cells under 4 columns"]);
    let ragged = cgats("CGATS.17", FIELDS, 0.01).replace("0.0062\t", "");
    assert!(spectrum(&ragged, &requested("paper", None, None)).is_ok());
    refusal(&ragged, &requested("black", None, None), &["\"black\"", "line 8", "3 values under 4 fields"]);
    let text = cgats("CGATS.17", FIELDS, 0.01).replace("0.0062", "n.a.");
    refusal(&text, &requested("black", None, None), &["\"black\"", "line 8, 550 nm", "\"n.a.\""]);
    refusal("nm,R\n400,0.1\n500,0.2\n500,0.3\n700,0.4\n", &first, &["two values at 500 nm"]);
    assert!(spectrum("nm,R\n400,0.1\n500,0.2\n500,0.2\n700,0.4\n", &first).is_ok());
    let fresh = spectrum("nm,R\n400,0.1\n4l0,0.2\n700,0.4\n", &first).unwrap_err();
    assert!(fresh.contains("line 3") && fresh.contains("\"4l0\""), "{fresh}");
}

/// Cut anywhere and with any byte changed, files give a result or an error, at once, and never a value that is not finite.
#[test]
fn cut_and_damaged_files_give_an_error_or_finite_values() {
    let texts = [
        cgats("CGATS.17\nSPECTRAL_NORM \"100\"", FIELDS, 1.0),
        CHART.to_owned(),
        cxf("Spectrum_Reflectance", ANNULAR, &["M0_Incandescent", "M1_Daylight"]),
        "sep=;\nnm;R;%R\n400;0,05;5\n550;0,4;40\n700;0,8;80\n".to_owned(),
        "name,400,550,700\npaper,0.9,0.9,0.9\nink,0.05,0.4,0.8\n".to_owned(),
    ];
    let requests = [
        requested("", None, None),
        requested("ink", None, Some(MeasuredCondition::M1)),
        requested("3", Some(MeasuredUnit::Percent), None),
    ];
    let sound = |text: &str| {
        for request in &requests {
            if let Ok(read) = reading(text, request) {
                let numbers: Vec<f64> = match read.measured {
                    MeasuredContent::Spectrum(spectrum) => spectrum.rows.concat(),
                    MeasuredContent::Colour(colour) => colour.lab.to_vec(),
                };
                assert!(numbers.iter().all(|x| x.is_finite()), "{text}");
            }
        }
    };
    for text in &texts {
        for end in (0..text.len()).filter(|&end| text.is_char_boundary(end)) {
            sound(&text[..end]);
        }
        let strange = ['"', '\n', '<', 'e', '9', '#', '\t', ';', '-', '\u{0}', 'µ'];
        for (i, (at, old)) in text.char_indices().enumerate() {
            let mut changed = text[..at].to_owned();
            changed.push(strange[i % strange.len()]);
            changed += &text[at + old.len_utf8()..];
            sound(&changed);
        }
    }
}

/// Sizes are gated before they cost time.
#[test]
fn what_is_too_large_is_refused_at_once() {
    let wide = format!("nm{}\n400{}\n", ",a".repeat(1_000_000), ",1".repeat(1_000_000));
    let bands: String = (0..300_000).map(|i| format!("SPEC_{i} ")).collect();
    let bands = format!("CGATS.17\nBEGIN_DATA_FORMAT\n{bands}\nEND_DATA_FORMAT\nBEGIN_DATA\n1\nEND_DATA\n");
    let long = format!(
        "CGATS.17\nBEGIN_DATA_FORMAT\nnm400 nm500\nEND_DATA_FORMAT\nBEGIN_DATA\n{}END_DATA\n",
        "1 1\n".repeat(3_000_000)
    );
    let deep = "<a>".repeat(100_000);
    for text in [wide, bands, long, deep] {
        let begin = Instant::now();
        assert!(reading(&text, &MeasuredRequest::default()).is_err());
        // a second on an idle machine
        assert!(begin.elapsed() < Duration::from_secs(20), "{:?} for {}", begin.elapsed(), &text[..20]);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.csv");
    // a hole of 100 MB
    std::fs::File::create(&path).unwrap().set_len(100 << 20).unwrap();
    let error = MeasuredReading::new(&path, &MeasuredRequest::default()).unwrap_err();
    assert!(error.contains("larger than the limit"), "{error}");
}
