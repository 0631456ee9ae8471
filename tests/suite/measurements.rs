//! Files of measurements as instruments, programs and people write them: what each declares is believed, what none declares is
//! asked for, and nothing is guessed from one sample.

use crate::run_support::{TINY, study, succeed};
use inkwave::appearance::colour::ciede2000;
use inkwave::appearance::viewing::{Summation, Viewing};
use inkwave::input::fault::StudyError;
use inkwave::input::load::load;
use inkwave::input::measured::{
    MeasuredCondition, MeasuredContent, MeasuredReading, MeasuredRequest, MeasuredSpectrum, MeasuredUnit,
    Patch,
};
use proptest::prelude::*;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Paper and a black, percent.
const PAPER: [f64; 3] = [82.0, 84.0, 88.0];
const BLACK: [f64; 3] = [0.52, 0.62, 0.82];

/// A request by its keys.
fn asked(patch: &str, unit: Option<MeasuredUnit>, condition: Option<MeasuredCondition>) -> MeasuredRequest {
    let patch = (!patch.is_empty()).then(|| Patch::Name(patch.into()));
    MeasuredRequest { patch, unit, condition, ..MeasuredRequest::default() }
}

fn reading(text: &str, request: &MeasuredRequest) -> Result<MeasuredReading, String> {
    MeasuredReading::parse(text, "file", request)
}

fn spectrum(text: &str, request: &MeasuredRequest) -> Result<MeasuredSpectrum, String> {
    match reading(text, request)?.measured {
        MeasuredContent::Spectrum(spectrum) => Ok(spectrum),
        MeasuredContent::Colour(colour) => Err(format!("a colour {:?}", colour.lab)),
    }
}

/// Values of a sample at 400, 550 and 700 nm.
fn values(text: &str, patch: &str) -> [f64; 3] {
    let read = spectrum(text, &asked(patch, None, None)).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let nm: Vec<f64> = read.rows.iter().map(|row| row[0]).collect();
    assert_eq!(nm, [400.0, 550.0, 700.0], "{text}");
    [0, 1, 2].map(|i| read.rows[i][1])
}

fn close(found: [f64; 3], wanted: [f64; 3]) -> bool {
    // identity: decimal text and a division by 100
    (0..3).all(|i| (found[i] - wanted[i]).abs() < 1e-12)
}

fn refusal(text: &str, request: &MeasuredRequest, words: &[&str]) {
    let error = spectrum(text, request).expect_err(text);
    words.iter().for_each(|word| assert!(error.contains(word), "{word:?} is missing: {error}\n{text}"));
}

/// CGATS of two samples with a head and the names of the fields; values times a scale.
fn cgats(head: &str, fields: &str, scale: f64) -> String {
    let row = |name: &str, values: [f64; 3]| {
        let values = values.map(|x| (x * scale).to_string()).join("\t");
        format!("{name}\t{values}\n")
    };
    let (paper, black) = (row("\"paper\"", PAPER), row("\"black\"", BLACK));
    format!(
        "{head}\nBEGIN_DATA_FORMAT\nSAMPLE_NAME {fields}\nEND_DATA_FORMAT\nNUMBER_OF_SETS 2\nBEGIN_DATA\n{paper}{black}END_DATA\n"
    )
}

const FIELDS: &str = "SPEC_400 SPEC_550 SPEC_700";

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
    let said = reading(undeclared, &asked("", None, None)).unwrap().remarks;
    assert!(
        said.iter().any(|remark| remark.contains("no unit is stated") && remark.contains("compare.unit")),
        "{said:?}"
    );
    let by_key = spectrum(undeclared, &asked("", Some(MeasuredUnit::Percent), None)).unwrap();
    assert!((by_key.rows[0][1] - 0.0052).abs() < 1e-15);
    refusal(
        "400,0.9\n550,1.2\n700,2.1\n",
        &asked("", None, None),
        &["no unit is stated", "2.1", "compare.unit"],
    );
    // declared units leave nothing to say
    let declared = cgats("CGATS.17\nSPECTRAL_NORM \"100\"", FIELDS, 1.0);
    assert!(reading(&declared, &asked("black", None, None)).unwrap().remarks.is_empty());
}

#[test]
fn heads_names_of_fields_remarks_and_wrapped_sets() {
    let wanted = BLACK.map(|x| x / 100.0);
    for head in [
        "CGATS.17",
        "ISO28178",
        "IT8.7/4",
        "CTI3",
        "SPECT",
        "LGOROWLENGTH 2\nCREATED \"8/20/2009\"  # Time: 14:42",
        "ECI2002",
        "ORIGINATOR \"somebody\"\nDESCRIPTOR \"a chart",
        "Date: 3/27/2000  Time: 19:04",
        "",
    ] {
        assert!(close(values(&cgats(head, FIELDS, 0.01), "black"), wanted), "{head}");
    }
    for name in [
        "nm#",
        "NM_#",
        "#_NM",
        "R_#",
        "SPECTRAL_NM#",
        "SPECTRAL_NM_#",
        "SPECTRAL_#",
        "SPECTRAL_DEC_#",
        "spec_#",
        "#nm",
    ] {
        let fields = ["400", "550", "700"].map(|nm| name.replace('#', nm)).join("\t");
        assert!(close(values(&cgats("CGATS.17", &fields, 0.01), "black"), wanted), "{name}");
    }
    let pairs = "SPECTRAL_NM SPECTRAL_DEC SPECTRAL_NM SPECTRAL_DEC SPECTRAL_NM SPECTRAL_DEC";
    let data = "\"paper\" 400 .82 550 .84 700 .88 \"black\" 400 .0052 550 .0062 700 .0082";
    let paired = |fields: &str, data: &str| {
        format!(
            "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME {fields}\nEND_DATA_FORMAT\nBEGIN_DATA\n{data}\nEND_DATA\n"
        )
    };
    assert!(close(values(&paired(pairs, &data.replace(" \"black", "\n\"black")), "black"), wanted));
    let long = data.replace("\"paper\" ", "").replace(" \"black\"", "");
    let long: Vec<&str> = long.split(' ').collect();
    let long: Vec<String> = long
        .chunks(2)
        .enumerate()
        .map(|(i, pair)| format!("{} {}", if i < 3 { "paper" } else { "black" }, pair.join(" ")))
        .collect();
    assert!(close(values(&paired("SPECTRAL_NM SPECTRAL_DEC", &long.join("\n")), "black"), wanted));
    let percent = long.join("\n").replace(".0052", "0.52").replace(".0062", "0.62").replace(".0082", "0.82");
    assert!(close(values(&paired("SPECTRAL_NM SPECTRAL_PCT", &percent), "black"), wanted));
    let plain = cgats("CGATS.17", FIELDS, 0.01);
    for changed in [
        plain.replace("BEGIN_DATA\n", "BEGIN_DATA\n# first page\n\n"),
        plain.replace("\"black\"", "# second page\n  # and third\n\"black\"  "),
        plain.replace('\t', "\n"),
        plain.replace("0.", "0,"),
        plain.replace('\n', "\r\n"),
        format!("\u{feff}{plain}"),
        // a table of densities before, and one of calibration after it
        plain.replace(
            "CGATS.17",
            "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_ID D_VIS\nEND_DATA_FORMAT\nBEGIN_DATA\n1 1.2\nEND_DATA",
        ),
        format!("{plain}CAL\nBEGIN_DATA_FORMAT\nRGB_I RGB_R\nEND_DATA_FORMAT\nBEGIN_DATA\n0 1\nEND_DATA\n"),
    ] {
        assert!(close(values(&changed, "black"), wanted), "{changed}");
    }
    let two = spectrum(&plain.replace("\"black\"", "# page 2\n\"black\""), &asked("", None, None)).unwrap();
    assert!(two.source.ends_with("\"paper\", sample 1 of 2"), "{}", two.source);
    for cut in ["END_DATA\n", "\"black\""] {
        let text = &plain[..plain.rfind(cut).unwrap()];
        refusal(text, &asked("paper", None, None), &["cut short"]);
    }
}

#[test]
fn what_is_no_reflectance_is_refused() {
    let any = asked("paper", None, None);
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
    let first = asked("", None, None);
    refusal("nm,%T\n400,50\n500,60\n", &first, &["transmi"]);
    refusal("nm,Absorbance\n400,0.5\n500,0.6\n", &first, &["column reflectance is missing", "Absorbance"]);
    refusal(&cxf("Spectrum_Transmittance", ANNULAR, &["M0_Incandescent"]), &first, &["transmi"]);
    let element = cxf("Spectrum_Reflectance", ANNULAR, &["M0_Incandescent"])
        .replace("ReflectanceSpectrum", "TransmittanceSpectrum");
    refusal(&element, &first, &["transmi"]);
    refusal("##TITLE=a\n##XYDATA=(X++(Y..Y))\n400 1 2\n##END=\n", &first, &["JCAMP-DX"]);
}

const ANNULAR: &str = "<cc:SingleAngle><cc:SingleAngleConfiguration>Annular</cc:SingleAngleConfiguration>\
                       <cc:IlluminationAngle>45</cc:IlluminationAngle><cc:MeasurementAngle>0</cc:MeasurementAngle></cc:SingleAngle>";

/// CxF3 of one ink under several conditions: 5 %, 40 % and 80 %, a tenth more under each further one.
fn cxf(kind: &str, geometry: &str, lights: &[&str]) -> String {
    let (mut spectra, mut specifications) = (String::new(), String::new());
    for (i, light) in lights.iter().enumerate() {
        let more = 1.0 + 0.1 * i as f64;
        let values = [0.05, 0.4, 0.8].map(|x| (x * more).to_string()).join(" ");
        spectra += &format!(
            "<cc:ReflectanceSpectrum ColorSpecification=\"c{i}\" StartWL=\"400\">{values}</cc:ReflectanceSpectrum>"
        );
        specifications += &format!(
            "<cc:ColorSpecification Id=\"c{i}\"><cc:MeasurementSpec><cc:MeasurementType>{kind}</cc:MeasurementType>\
             <cc:GeometryChoice>{geometry}</cc:GeometryChoice><cc:WavelengthRange StartWL=\"400\" Increment=\"150\"/>\
             <cc:Device><cc:DeviceIllumination>{light}</cc:DeviceIllumination></cc:Device></cc:MeasurementSpec></cc:ColorSpecification>"
        );
    }
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<cc:CxF xmlns:cc=\"http://colorexchangeformat.com/CxF3-core\"><cc:Resources>\
         <cc:ObjectCollection><cc:Object ObjectType=\"Standard\" Name=\"ink\" Id=\"1\"><cc:ColorValues>{spectra}</cc:ColorValues>\
         <cc:DeviceColorValues><cc:ColorCMYK ColorSpecification=\"c0\"><cc:Cyan>0</cc:Cyan><cc:Magenta>30</cc:Magenta>\
         <cc:Yellow>100</cc:Yellow><cc:Black>0</cc:Black></cc:ColorCMYK></cc:DeviceColorValues></cc:Object></cc:ObjectCollection>\
         <cc:ColorSpecificationCollection>{specifications}</cc:ColorSpecificationCollection></cc:Resources></cc:CxF>"
    )
}

#[test]
fn a_spheres_values_are_not_compared_at_45_degrees() {
    let kind = "Spectrum_Reflectance";
    let first = asked("", None, None);
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
            refusal(&text, &asked("paper", None, None), &["sphere", "45:0"]);
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
        refusal(&text, &asked(patch, None, None), &["M0, M1, M2", "compare.condition"]);
    }
    for (condition, at_700) in
        [(MeasuredCondition::M0, 0.8), (MeasuredCondition::M1, 0.88), (MeasuredCondition::M2, 0.96)]
    {
        let read = spectrum(&text, &asked("ink", None, Some(condition))).unwrap();
        assert!((read.rows[2][1] - at_700).abs() < 1e-12, "{condition:?}");
    }
    refusal(&text, &asked("ink", None, Some(MeasuredCondition::M3)), &["M3", "M0, M1, M2"]);
    let head = |words: &str| cgats(&format!("CGATS.17\n{words}"), FIELDS, 0.01);
    for words in [
        "MEASUREMENT_SOURCE \"MeasurementCondition=M1\tFilter=no\"",
        "INSTRUMENTATION \"i1Pro 2, M1\"",
        "FILTER \"M1\"",
    ] {
        assert!(
            spectrum(&head(words), &asked("paper", None, Some(MeasuredCondition::M1))).is_ok(),
            "{words}"
        );
        refusal(&head(words), &asked("paper", None, Some(MeasuredCondition::M0)), &["M0", "found: M1"]);
    }
    // columns or rows of several conditions
    let columns = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME M0_400 M0_500 M1_400 M1_500\nEND_DATA_FORMAT\nBEGIN_DATA\nink .1 .2 .3 .4\nEND_DATA\n";
    let rows = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME MEASUREMENT_CONDITION nm400 nm500\nEND_DATA_FORMAT\nBEGIN_DATA\nink M0 .1 .2\nink M1 .3 .4\nEND_DATA\n";
    for text in [columns, rows] {
        refusal(text, &asked("ink", None, None), &["M0, M1"]);
        let read = spectrum(text, &asked("ink", None, Some(MeasuredCondition::M1))).unwrap();
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
        refusal(&objects, &asked(patch, None, None), &["\"A1\"", "M0, M2"]);
    }
    assert_eq!(
        spectrum(&objects, &asked("", None, Some(MeasuredCondition::M2))).unwrap().rows[0],
        [400.0, 0.3]
    );
    // measured twice under one name
    let twice = rows.replace("ink M1", "ink M0");
    refusal(&twice, &asked("ink", None, None), &["2 measurements of \"ink\" that differ"]);
    let equal = twice.replace(".3 .4", ".1 .2");
    assert!(spectrum(&equal, &asked("ink", None, None)).is_ok());
}

/// FOGRA39L's way: no names, amounts of ink, conditions in words.
const CHART: &str = "ORIGINATOR\t\"a, institute\"\nDESCRIPTOR\t\"FOGRA39L, D65\"\nCREATED\t\"December 2006\"\n\
    INSTRUMENTATION\t\"D50, 2 degree, geometry 45/0, no polarisation filter, white backing, according to ISO 13655\"\n\
    PRINT_CONDITIONS\t\"Offset, tone value increase curves A (CMY) and B (K)\"\nNUMBER_OF_FIELDS\t11\nBEGIN_DATA_FORMAT\n\
    SAMPLE_ID\tCMYK_C\tCMYK_M\tCMYK_Y\tCMYK_K\tXYZ_X\tXYZ_Y\tXYZ_Z\tLab_L\tLab_A\tLab_B\nEND_DATA_FORMAT\nNUMBER_OF_SETS\t3\n\
    BEGIN_DATA\n1\t0\t0\t0\t0\t84.54\t87.6\t74.77\t95\t0\t-2\n2\t0\t10\t0\t0\t79\t79\t68\t91.3\t6.6\t-3.1\n\
    3\t0\t0\t100\t0\t68\t71\t7\t88.1\t-5.2\t93.5\nEND_DATA\n";

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

#[test]
fn tables_of_instruments() {
    let wanted = [0.05, 0.4, 0.8];
    for text in [
        "wavelength_nm,reflectance\n700,0.8\n550,0.4\n400,0.05\n",
        "400,0.05\n550,0.4\n700,0.8\n",
        "Wavelength (nm),%R\n700,80\n550,40\n400,5\n",
        "\"Wavelength (nm)\",\"R [%]\"\n400,5.0\n550,40\n700,80\n",
        "sep=;\r\nnm;Reflectance (%)\r\n400;5,0\r\n550;40,0\r\n700;80,0\r\n",
        "\u{feff}Wellenlänge [nm];Reflectance\n400;0,05\n550;0,4\n700;0,8\n",
        "nm\tR\n400\t0.05\n550\t0.4\n700\t0.8\n",
        "400 0.05\n550 0.4\n700 0.8\n",
        "# spectrometer X\n# nm  R\n400  0.05\n550  0.4\n700  0.8\n",
        "Instrument: X, serial 12\nDate,2020\nMode,Reflectance\n\nnm,%R\n400,5\n550,40\n700,80\nend of data\n",
        "wavelength_um,reflectance\n0.4,0.05\n0.55,0.4\n0.7,0.8\n",
        "name,400,550,700\nink,0.05,0.4,0.8\n",
        "Sample;400 nm;550 nm;700 nm\nink;5,0;40,0;80,0\n",
        "Wavelength (nm),400,550,700\nink,0.05,0.4,0.8\n",
        "400,550,700\n0.05,0.4,0.8\n",
        "name\tR400\tR550\tR700\nink\t5\t40\t80\n",
        "sample,wavelength,reflectance\nink,700,0.8\nink,550,0.4\nink,400,0.05\n",
        "nm,R,R std\n400,0.05,0.001\n550,0.4,0.002\n700,0.8,0.002\n",
    ] {
        assert!(close(values(text, ""), wanted), "{text}");
    }
    let columns = "nm,paper,ink\n400,0.9,0.05\n550,0.9,0.4\n700,0.9,0.8\n";
    let rows = "id,name,700,550,400\n1,paper,.9,.9,.9\n2,ink,.8,.4,.05\n";
    for text in [columns, rows] {
        assert!(close(values(text, "ink"), wanted), "{text}");
        refusal(text, &asked("inc", None, None), &["no sample \"inc\"; found \"paper\", \"ink\""]);
        let several = MeasuredRequest { one_must_be_named: true, ..MeasuredRequest::default() };
        refusal(text, &several, &["2 samples", "compare.patch", "\"paper\""]);
    }
    assert!(close(values(rows, "2"), wanted));
    assert!(close(values("400,0.9,0.05\n550,0.9,0.4\n700,0.9,0.8\n", "2"), wanted));
}

/// A wrong value that the study does not use blocks nothing; what is used is named by line, sample and value.
#[test]
fn faults_count_only_where_values_are_used() {
    let first = asked("", None, None);
    let infrared = "nm,R\n400,0.05\n550,0.4\n700,0.8\n790,0.8\n2400,-0.7\n2400,9e9\n2500,no light\n";
    assert_eq!(spectrum(infrared, &first).unwrap().at(700.0), Some(0.8));
    let needed = MeasuredRequest { used_nm: [400.0, 2450.0], ..MeasuredRequest::default() };
    let percent = MeasuredRequest { unit: Some(MeasuredUnit::Factor), ..needed };
    refusal(infrared, &percent, &["line 6", "-0.7 at 2400 nm"]);
    let table = "name,400,550,700\npaper,0.9,0.9,0.9\nink,0.05,,0.8\nblack,0.05\n";
    assert!(spectrum(table, &asked("paper", None, None)).is_ok());
    refusal(table, &asked("ink", None, None), &["\"ink\"", "line 3, 550 nm", "empty"]);
    refusal(table, &asked("black", None, None), &["\"black\"", "line 4", "2 cells under 4 columns"]);
    let ragged = cgats("CGATS.17", FIELDS, 0.01).replace("0.0062\t", "");
    assert!(spectrum(&ragged, &asked("paper", None, None)).is_ok());
    refusal(&ragged, &asked("black", None, None), &["\"black\"", "line 8", "3 values under 4 fields"]);
    let text = cgats("CGATS.17", FIELDS, 0.01).replace("0.0062", "n.a.");
    refusal(&text, &asked("black", None, None), &["\"black\"", "line 8, 550 nm", "\"n.a.\""]);
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
        asked("", None, None),
        asked("ink", None, Some(MeasuredCondition::M1)),
        asked("3", Some(MeasuredUnit::Percent), None),
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

proptest! {
    /// A table written in any form reads back as it was.
    #[test]
    fn spectra_read_back_from_every_form(
        values in prop::collection::vec(0u32..1_000_000, 3..40),
        step in 1u32..30,
        form in 0usize..6,
        falls in any::<bool>(),
    ) {
        let mut rows: Vec<[f64; 2]> = values
            .iter()
            .enumerate()
            .map(|(i, value)| [f64::from(380 + step * i as u32), f64::from(*value) / 1e6])
            .collect();
        let wanted = rows.clone();
        if falls {
            rows.reverse();
        }
        let join = |of: &dyn Fn(&[f64; 2]) -> String, by: &str| rows.iter().map(of).collect::<Vec<_>>().join(by);
        let text = match form {
            0 => format!("nm,reflectance_factor\n{}\n", join(&|row| format!("{},{}", row[0], row[1]), "\n")),
            1 => format!("nm;reflectance_factor\n{}\n", join(&|row| format!("{};{}", row[0], row[1].to_string().replace('.', ",")), "\r\n")),
            2 => format!("name,{}\nink,{}\n", join(&|row| row[0].to_string(), ","), join(&|row| row[1].to_string(), ",")),
            3 => format!(
                "CGATS.17\nSPECTRAL_NORM \"1\"\nBEGIN_DATA_FORMAT\nSAMPLE_ID {}\nEND_DATA_FORMAT\nBEGIN_DATA\n1 {}\nEND_DATA\n",
                join(&|row| format!("SPEC_{}", row[0]), " "),
                join(&|row| row[1].to_string(), "\n")
            ),
            4 => format!(
                "ISO28178\nBEGIN_DATA_FORMAT\nSPECTRAL_NM SPECTRAL_DEC\nEND_DATA_FORMAT\nBEGIN_DATA\n{}\nEND_DATA\n",
                join(&|row| format!("{} {}", row[0], row[1]), "\n")
            ),
            _ => format!(
                "<CxF><Object Name=\"ink\"><CustomSpectrum ColorSpecification=\"a\">{}</CustomSpectrum></Object></CxF>",
                join(&|row| format!("<SpectralPoint WL=\"{}\">{}</SpectralPoint>", row[0], row[1]), "")
            ),
        };
        let read = spectrum(&text, &MeasuredRequest { used_nm: [380.0, 2000.0], ..asked("", Some(MeasuredUnit::Factor), None) });
        prop_assert_eq!(read.map(|read| read.rows), Ok(wanted), "{}", text);
    }
}

/// What the program writes of a black print reads back as the print itself.
#[test]
fn exports_of_a_black_print_read_back_without_a_difference() {
    let folder = tempfile::tempdir().unwrap();
    let film = "[layer]\nthickness_um = 1.0\nbinder.index = 1.5\n[paper]\nalbedo = 0.01\n[light]\nfrom_nm = 400\n\
                to_nm = 700\nstep_nm = 20\n[resolution]\naccuracy = 3e-2\n";
    let out = folder.path().join("out");
    succeed(&study(folder.path(), film), &out, &[]);
    let done = Command::new(env!("CARGO_BIN_EXE_inkwave"))
        .arg("export")
        .arg(&out)
        .args(["--to", "cxf,cgats"])
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let largest = |name: &str| {
        let request = MeasuredRequest { used_nm: [400.0, 700.0], ..MeasuredRequest::default() };
        let read = MeasuredReading::new(&out.join("export").join(name), &request).unwrap();
        // other samples are bright enough to show the unit: it is declared all the same
        assert!(read.remarks.iter().all(|remark| !remark.contains("no unit")), "{:?}", read.remarks);
        let MeasuredContent::Spectrum(spectrum) = read.measured else { panic!("a spectrum") };
        (spectrum.rows.iter().map(|row| row[1]).fold(0.0, f64::max), spectrum.source)
    };
    for name in ["spectra.cgats", "spectra.sp", "spectra.cxf"] {
        // dark enough to pass for factors when it is in percent
        let (most, source) = largest(name);
        assert!(most < 0.01, "{name}: {most}");
        assert!(source.contains("45:0"), "{source}");
        let compared = format!("{film}[compare]\nmeasured = \"out/export/{name}\"\n");
        let again = folder.path().join("again");
        succeed(&study(folder.path(), &compared), &again, &[]);
        let results: serde_json::Value =
            serde_json::from_str(&std::fs::read_to_string(again.join("results.json")).unwrap()).unwrap();
        let apart = results["ink_maker"]["measured"]["delta_e_2000"]["value"].as_f64().unwrap();
        // the files' decimals, and values between the study's wavelengths by two rules
        assert!(apart < 0.02, "{name}: {apart}");
        std::fs::remove_dir_all(&again).unwrap();
    }
}

fn faults(path: &Path) -> Vec<String> {
    match load(path) {
        Ok(_) => Vec::new(),
        Err(StudyError::Values { faults, .. }) => {
            faults.iter().map(|fault| format!("{fault}; {}", fault.remedy)).collect()
        }
        Err(other) => vec![other.to_string()],
    }
}

/// Paper and cards are measured as inks are.
#[test]
fn papers_are_read_from_files_of_measurements() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("paper.txt", &cgats("CGATS.17\nSPECTRAL_NORM \"100\"", FIELDS, 1.0));
    write(
        "paper.cxf",
        &cxf(
            "Spectrum_Reflectance",
            "<cc:SphereGeometry>Specular_Included</cc:SphereGeometry>",
            &["M0_Incandescent", "M2_UVExcluded"],
        ),
    );
    write("paper.csv", "wavelength_nm,albedo\n700,0.88\n550,0.84\n400,0.82\n");
    let with = |albedo: &str| study(folder.path(), &format!("{TINY}[paper]\nalbedo = {{ {albedo} }}\n"));
    let at_550 = |albedo: &str| {
        let study = load(&with(albedo)).unwrap_or_else(|error| panic!("{albedo}: {error}"));
        (study.paper.albedo.at(550.0).unwrap(), study.remarks)
    };
    assert!((at_550("csv = \"paper.txt\", patch = \"paper\"").0 - 0.84).abs() < 1e-12);
    assert_eq!(at_550("csv = \"paper.csv\"").0, 0.84);
    let (value, remarks) = at_550("csv = \"paper.cxf\", condition = \"M2\"");
    assert!(
        (value - 0.44).abs() < 1e-12
            && remarks.iter().any(|remark| remark.contains("specular light included")),
        "{remarks:?}"
    );
    for (albedo, words) in [
        ("csv = \"paper.txt\"", ["paper.albedo", "2 samples", "paper.albedo.patch"]),
        ("csv = \"paper.cxf\"", ["paper.albedo", "M0, M2", "paper.albedo.condition"]),
        ("csv = \"paper.txt\", patch = \"ink\"", ["paper.albedo", "no sample \"ink\"", "\"black\""]),
    ] {
        let found = faults(&with(albedo));
        assert!(found.len() == 1 && words.iter().all(|word| found[0].contains(word)), "{found:?}");
    }
}

const FIT: &str = "base = \"ink.toml\"\n[[measured]]\nfile = \"FILE\"\nbacking = 0.8\n";
const DESIGN: &str = "base = \"ink.toml\"\n[target]\nfile = \"FILE\"\n[[vary]]\nfield = \"pigment[0].volume_fraction\"\nfrom = 0.1\nto = 0.2\n";

/// Of a file with several samples `fit` and `design` take none without its name, and a fit takes the geometry that its file states.
#[test]
fn fits_and_designs_ask_which_sample_is_meant_and_believe_the_geometry() {
    use inkwave::fit::file::FitGeometry;
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let ink = TINY.replace("realisations = 2", "realisations = 6");
    write("ink.toml", &ink);
    write("two.txt", &cgats("CGATS.17\nSPECTRAL_NORM \"100\"", FIELDS, 1.0));
    for (name, specular) in
        [("sci.cxf", "Specular_Included"), ("sce.cxf", "Specular_Excluded"), ("sphere.cxf", "Diffuse")]
    {
        let geometry = format!("<cc:SphereGeometry>{specular}</cc:SphereGeometry>");
        write(name, &cxf("Spectrum_Reflectance", &geometry, &["M0_Incandescent"]));
    }
    let path = folder.path().join("inverse.toml");
    let fit = |text: &str| {
        std::fs::write(&path, text).unwrap();
        inkwave::fit::load::load(&path).map_err(|error| error.to_string())
    };
    let design = |text: &str| {
        std::fs::write(&path, text).unwrap();
        inkwave::design::recipe::load(&path).map_err(|error| error.to_string())
    };
    let with = |text: &str, file: &str, more: &str| {
        let (from, to) = (format!("file = \"{file}\""), format!("file = \"{file}\"\n{more}"));
        text.replace("FILE", file).replace(&from, &to)
    };
    let error = fit(&with(FIT, "two.txt", "")).unwrap_err();
    assert!(error.contains("2 samples") && error.contains("measured[0].patch"), "{error}");
    let error = design(&with(DESIGN, "two.txt", "")).unwrap_err();
    assert!(error.contains("2 samples") && error.contains("target"), "{error}");
    let named = fit(&with(FIT, "two.txt", "patch = \"black\"")).unwrap();
    assert!((named.measured[0].measured(0) - 0.0052).abs() < 1e-9);
    let black = design(&with(DESIGN, "two.txt", "patch = \"black\"")).unwrap();
    assert!(black.lab.is_some_and(|lab| lab[0] < 8.0), "{:?}", black.lab);
    // a declared sphere
    let sci = fit(&with(FIT, "sci.cxf", "")).unwrap();
    assert_eq!(sci.measured[0].geometry, FitGeometry::Sphere);
    assert!(
        sci.remarks.iter().any(|remark| remark.contains("measured[0].geometry") && remark.contains("d:8")),
        "{:?}",
        sci.remarks
    );
    for (file, key, says) in [
        ("sci.cxf", "geometry = \"45:0\"", "specular light included"),
        ("sce.cxf", "", "specular light excluded"),
        ("sce.cxf", "geometry = \"d:8\"", "specular light excluded"),
        ("sphere.cxf", "", "d:8"),
    ] {
        let error = fit(&with(FIT, file, key)).unwrap_err();
        assert!(error.contains("measured[0].file") && error.contains(says), "{file} {key}: {error}");
    }
    assert!(fit(&with(FIT, "sphere.cxf", "geometry = \"d:8\"")).is_ok());
    let error = design(&with(DESIGN, "sci.cxf", "")).unwrap_err();
    assert!(error.contains("d:8"), "{error}");
}

/// A target is a colour of its own rows: the base's steps do not change it.
#[test]
fn the_colour_of_a_target_does_not_depend_on_the_steps_of_the_base() {
    let folder = tempfile::tempdir().unwrap();
    let edge = |nm: f64| 0.04 + 0.8 / (1.0 + (-(nm - 505.0) / 7.0).exp());
    let rows: String =
        (0..=35).map(|i| 380.0 + 10.0 * f64::from(i)).map(|nm| format!("{nm},{}\n", edge(nm))).collect();
    std::fs::write(folder.path().join("steep.csv"), format!("nm,reflectance_factor\n{rows}")).unwrap();
    let lab = |light: &str| {
        let ink = TINY.replace("from_nm = 400\nto_nm = 700\nstep_nm = 100\nsampling = \"listed\"", light);
        assert!(ink.contains(light), "{ink}");
        std::fs::write(folder.path().join("ink.toml"), ink).unwrap();
        let path = folder.path().join("design.toml");
        std::fs::write(&path, DESIGN.replace("FILE", "steep.csv")).unwrap();
        inkwave::design::recipe::load(&path).unwrap_or_else(|error| panic!("{error}")).lab.expect("a colour")
    };
    let coarse = lab("from_nm = 400\nto_nm = 700\nstep_nm = 60\nsampling = \"listed\"");
    let fine = lab("from_nm = 400\nto_nm = 700\nstep_nm = 20\nsampling = \"listed\"");
    assert!(ciede2000(coarse, fine) < 1e-9, "{coarse:?} {fine:?}");
}
