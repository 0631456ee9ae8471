//! Which of several measurements is meant: by geometry, condition, name or amounts of ink.

use super::{ANNULAR, CHART, FIELDS, cgats, close, cxf, reading, refusal, requested, spectrum, values};
use inkwave::appearance::viewing::{Summation, Viewing};
use inkwave::input::measured::{MeasuredCondition, MeasuredContent, MeasuredRequest, Patch};

#[test]
fn a_spheres_values_are_not_compared_at_45_degrees() {
    let kind = "Spectrum_Reflectance";
    let first = requested("", None, None);
    for (geometry, says) in [
        ("<cc:Sphere><cc:SphereType>Reflectance_Sphere_8</cc:SphereType></cc:Sphere>", "d:8"),
        ("<cc:SphereGeometry>Specular_Included</cc:SphereGeometry>", "specular light included"),
        ("<cc:SphereGeometry>Specular_Excluded</cc:SphereGeometry>", "specular light excluded"),
        ("<cc:UnknownGeometry>d/8, SCE</cc:UnknownGeometry>", "specular light excluded"),
        (&ANNULAR.replace(">45<", ">15<"), "15:0"),
    ] {
        refusal(&cxf(kind, geometry, &["M0_Incandescent"]), &first, &[says, "45:0"]);
    }
    for geometry in
        [ANNULAR, &ANNULAR.replace(">45<", ">x<").replace(">0<", ">45<").replace(">x<", ">0<"), ""]
    {
        assert!(
            close(values(&cxf(kind, geometry, &["M0_Incandescent"]), ""), [0.05, 0.4, 0.8]),
            "{geometry}"
        );
    }
    for words in ["d/8 SCI", "d:8°, specular component excluded", "8°/d", "di:8", "integrating sphere"] {
        for keyword in ["MEASUREMENT_GEOMETRY", "INSTRUMENTATION", "MEASUREMENT_SOURCE"] {
            let text = cgats(&format!("CGATS.17\n{keyword} \"{words}\""), FIELDS, 0.01);
            refusal(&text, &requested("paper", None, None), &["sphere", "45:0"]);
        }
    }
    let table = "Geometry: d/8, specular included\nWavelength (nm),Reflectance (%)\n400,5\n550,40\n700,80\n";
    refusal(table, &first, &["sphere"]);
    // both geometries in one file: like is compared with like
    let both = cxf(kind, ANNULAR, &["M0_Incandescent", "M0_Incandescent"]);
    let second = both.rfind(ANNULAR).unwrap();
    let both = format!(
        "{}<cc:SphereGeometry>Specular_Included</cc:SphereGeometry>{}",
        &both[..second],
        &both[second + ANNULAR.len()..]
    );
    assert!(close(values(&both, "ink"), [0.05, 0.4, 0.8]));
}

#[test]
fn of_several_conditions_under_one_name_one_is_chosen_by_a_key() {
    let text = cxf("Spectrum_Reflectance", ANNULAR, &["M0_Incandescent", "M1_Daylight", "M2_UVExcluded"]);
    for patch in ["", "ink", "1"] {
        refusal(&text, &requested(patch, None, None), &["M0, M1, M2", "compare.condition"]);
    }
    for (condition, at_700) in
        [(MeasuredCondition::M0, 0.8), (MeasuredCondition::M1, 0.88), (MeasuredCondition::M2, 0.96)]
    {
        let read = spectrum(&text, &requested("ink", None, Some(condition))).unwrap();
        assert!((read.rows[2][1] - at_700).abs() < 1e-12, "{condition:?}");
    }
    refusal(&text, &requested("ink", None, Some(MeasuredCondition::M3)), &["M3", "M0, M1, M2"]);
    let head = |words: &str| cgats(&format!("CGATS.17\n{words}"), FIELDS, 0.01);
    for words in [
        "MEASUREMENT_SOURCE \"MeasurementCondition=M1\tFilter=no\"",
        "INSTRUMENTATION \"i1Pro 2, M1\"",
        "FILTER \"M1\"",
    ] {
        assert!(
            spectrum(&head(words), &requested("paper", None, Some(MeasuredCondition::M1))).is_ok(),
            "{words}"
        );
        refusal(&head(words), &requested("paper", None, Some(MeasuredCondition::M0)), &["M0", "found: M1"]);
    }
    // columns or rows of several conditions
    let columns = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME M0_400 M0_500 M1_400 M1_500\nEND_DATA_FORMAT\nBEGIN_DATA\nink .1 .2 .3 .4\nEND_DATA\n";
    let rows = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME MEASUREMENT_CONDITION nm400 nm500\nEND_DATA_FORMAT\nBEGIN_DATA\nink M0 .1 .2\nink M1 .3 .4\nEND_DATA\n";
    for text in [columns, rows] {
        refusal(text, &requested("ink", None, None), &["M0, M1"]);
        let read = spectrum(text, &requested("ink", None, Some(MeasuredCondition::M1))).unwrap();
        assert_eq!(read.rows, [[400.0, 0.3], [500.0, 0.4]]);
    }
    // an object for each condition, as profiling programs write them
    let objects = |lights: [&str; 2]| {
        let mut text = String::from("<CxF>");
        for (i, light) in lights.iter().enumerate() {
            let value = [0.2, 0.3][i];
            text += &format!(
                "<Object Name=\"A1\" Id=\"c{i}\"><ReflectanceSpectrum ColorSpecification=\"{light}\">{value} {value}</ReflectanceSpectrum>\
                 </Object><ColorSpecification Id=\"{light}\"><WavelengthRange StartWL=\"400\" Increment=\"100\"/>\
                 <DeviceIllumination>{light}</DeviceIllumination></ColorSpecification>"
            );
        }
        text + "</CxF>"
    };
    let objects = objects(["M0_Incandescent", "M2_UVExcluded"]);
    for patch in ["", "A1"] {
        refusal(&objects, &requested(patch, None, None), &["\"A1\"", "M0, M2"]);
    }
    assert_eq!(
        spectrum(&objects, &requested("", None, Some(MeasuredCondition::M2))).unwrap().rows[0],
        [400.0, 0.3]
    );
    // measured twice under one name
    let twice = rows.replace("ink M1", "ink M0");
    refusal(&twice, &requested("ink", None, None), &["2 measurements of \"ink\" that differ"]);
    let equal = twice.replace(".3 .4", ".1 .2");
    assert!(spectrum(&equal, &requested("ink", None, None)).is_ok());
}

#[test]
fn patches_are_chosen_by_their_inks_and_conditions_read_in_words() {
    let d50 = Viewing::new("D50", "2", Summation::Plain).unwrap();
    let of = |text: &str, patch: Patch| {
        let request =
            MeasuredRequest { patch: Some(patch), viewing: d50.clone(), ..MeasuredRequest::default() };
        match reading(text, &request)?.measured {
            MeasuredContent::Colour(colour) => Ok((colour.lab, colour.viewing)),
            MeasuredContent::Spectrum(spectrum) => Err(format!("{:?}", spectrum.rows)),
        }
    };
    let yellow = Ok(([88.1, -5.2, 93.5], Ok(d50.clone())));
    for patch in [
        Patch::Inks(vec![0.0, 0.0, 100.0, 0.0]),
        Patch::Name("0 0 100 0".into()),
        Patch::Name("C0 M0 Y100 K0".into()),
        Patch::Name("3".into()),
    ] {
        assert_eq!(of(CHART, patch.clone()), yellow, "{patch:?}");
    }
    let missing = of(CHART, Patch::Inks(vec![0.0, 0.0, 99.0, 0.0])).unwrap_err();
    assert!(missing.contains("99") && missing.contains("[0.0, 0.0, 0.0, 0.0]"), "{missing}");
    let none = reading(CHART, &MeasuredRequest::default()).unwrap_err();
    assert!(none.contains("3 samples") && none.contains("compare.patch"), "{none}");
    for from in ["INSTRUMENTATION", "MEASUREMENT_SOURCE", "COMPUTATIONAL_PARAMETER", "ANYTHING"] {
        assert_eq!(of(&CHART.replace("INSTRUMENTATION", from), Patch::Name("3".into())), yellow, "{from}");
    }
    let wide = CHART.replace("2 degree", "10°").replace("Lab_", "LAB_");
    let (_, viewing) = of(&wide, Patch::Name("3".into())).unwrap();
    assert_eq!(viewing.unwrap().observer(), "10");
    let lower = CHART
        .replace("Lab_L", "lab_l")
        .replace("Lab_A", "lab_a")
        .replace("Lab_B", "lab_b")
        .replace(".1\t", ",1\t");
    assert_eq!(of(&lower, Patch::Name("3".into())), yellow);
    let spectra = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K nm400 nm500\nEND_DATA_FORMAT\nBEGIN_DATA\n\
                   1 0 0 0 0 .9 .9\n2 33.33 0 0 0 .5 .6\nEND_DATA\n";
    let request = |inks: [f64; 4]| MeasuredRequest {
        patch: Some(Patch::Inks(inks.to_vec())),
        ..MeasuredRequest::default()
    };
    assert_eq!(spectrum(spectra, &request([33.333, 0.0, 0.0, 0.0])).unwrap().rows[1], [500.0, 0.6]);
    let cxf = cxf("Spectrum_Reflectance", ANNULAR, &["M0_Incandescent"]);
    assert!(spectrum(&cxf, &request([0.0, 30.0, 100.0, 0.0])).is_ok());
}
