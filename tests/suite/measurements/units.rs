//! The unit of a file: what it declares, or what all its samples show; and what is no reflectance at all.

use super::{
    ANNULAR, BLACK, FIELDS, PAPER, cgats, close, cxf, reading, refusal, requested, spectrum, values,
};
use inkwave::input::measured::MeasuredUnit;

#[test]
fn the_unit_is_what_the_file_declares_or_what_all_its_samples_show() {
    let factors = BLACK.map(|x| x / 100.0);
    for head in ["CGATS.17\nSPECTRAL_NORM \"100.0\"", "SPECT\nSPECTRAL_NORM \"100.000000\"", "CGATS.17"] {
        assert!(close(values(&cgats(head, FIELDS, 1.0), "black"), factors), "{head}");
    }
    assert!(close(values(&cgats("CGATS.17\nSPECTRAL_NORM \"1.0\"", FIELDS, 0.01), "black"), factors));
    // fluorescent paper, whose factors exceed one, and a declared norm
    let bright = cgats("CGATS.17\nSPECTRAL_NORM \"1.0\"", FIELDS, 0.013);
    assert!(close(values(&bright, "paper"), PAPER.map(|x| 0.013 * x)));
    let pct = FIELDS.replace("SPEC_", "SPECTRAL_PCT_");
    assert!(close(values(&cgats("CGATS.17", &pct, 1.0), "black"), factors));
    let table = "nm,paper (%R),black (%R)\n400,82,0.52\n550,84,0.62\n700,88,0.82\n";
    assert!(close(values(table, "black (%R)"), factors));
    let alone = "Wavelength (nm),%R\n400,0.52\n550,0.62\n700,0.82\n";
    assert!(close(values(alone, ""), factors));
    // a sample in percent alone, dark as a black is, with no word of its unit: said, and the key decides
    let undeclared = "400,0.52\n550,0.62\n700,0.82\n";
    let said = reading(undeclared, &requested("", None, None)).unwrap().remarks;
    assert!(
        said.iter().any(|remark| remark.contains("no unit is stated") && remark.contains("compare.unit")),
        "{said:?}"
    );
    let by_key = spectrum(undeclared, &requested("", Some(MeasuredUnit::Percent), None)).unwrap();
    assert!((by_key.rows[0][1] - 0.0052).abs() < 1e-15);
    refusal(
        "400,0.9\n550,1.2\n700,2.1\n",
        &requested("", None, None),
        &["no unit is stated", "2.1", "compare.unit"],
    );
    // declared units leave nothing to say
    let declared = cgats("CGATS.17\nSPECTRAL_NORM \"100\"", FIELDS, 1.0);
    assert!(reading(&declared, &requested("black", None, None)).unwrap().remarks.is_empty());
}

#[test]
fn what_is_no_reflectance_is_refused() {
    let any = requested("paper", None, None);
    for head in [
        "MEAS_TYPE \"TRANSMISSIVE\"",
        "MEASUREMENT_TYPE \"transmission\"",
        "MEAS_TYPE TRANSMISSIVE\nMEASUREMENT_SOURCE \"x\"",
    ] {
        refusal(&cgats(&format!("SPECT\n{head}"), FIELDS, 0.01), &any, &["transmi", "reflect"]);
    }
    refusal(&cgats("CTI3\nDEVICE_CLASS \"DISPLAY\"", FIELDS, 0.01), &any, &["emission"]);
    let fields = FIELDS.replace("SPEC_", "T_");
    refusal(&cgats("CGATS.17", &fields, 0.01), &any, &["transmi"]);
    let first = requested("", None, None);
    refusal("nm,%T\n400,50\n500,60\n", &first, &["transmi"]);
    refusal("nm,Absorbance\n400,0.5\n500,0.6\n", &first, &["column reflectance is missing", "Absorbance"]);
    refusal(&cxf("Spectrum_Transmittance", ANNULAR, &["M0_Incandescent"]), &first, &["transmi"]);
    let element = cxf("Spectrum_Reflectance", ANNULAR, &["M0_Incandescent"])
        .replace("ReflectanceSpectrum", "TransmittanceSpectrum");
    refusal(&element, &first, &["transmi"]);
    refusal("##TITLE=a\n##XYDATA=(X++(Y..Y))\n400 1 2\n##END=\n", &first, &["JCAMP-DX"]);
}
