//! Files of measurements as instruments, programs and people write them: what each declares is believed, what none declares is
//! asked for, and nothing is guessed from one sample.

mod choice;
mod damage;
mod formats;
mod misread;
mod readers;
mod units;

use inkwave::input::measured::{
    MeasuredCondition, MeasuredContent, MeasuredReading, MeasuredRequest, MeasuredSpectrum, MeasuredUnit,
    Patch,
};

/// Paper and a black, percent.
const PAPER: [f64; 3] = [82.0, 84.0, 88.0];
const BLACK: [f64; 3] = [0.52, 0.62, 0.82];

/// A request by its keys.
fn requested(
    patch: &str,
    unit: Option<MeasuredUnit>,
    condition: Option<MeasuredCondition>,
) -> MeasuredRequest {
    let patch = (!patch.is_empty()).then(|| Patch::Name(patch.into()));
    MeasuredRequest { patch, unit, condition, ..MeasuredRequest::default() }
}

/// What is read of the text of a file.
fn reading(text: &str, request: &MeasuredRequest) -> Result<MeasuredReading, String> {
    MeasuredReading::parse(text, "file", request)
}

/// The spectrum that is read of the text of a file.
fn spectrum(text: &str, request: &MeasuredRequest) -> Result<MeasuredSpectrum, String> {
    match reading(text, request)?.measured {
        MeasuredContent::Spectrum(spectrum) => Ok(spectrum),
        MeasuredContent::Colour(colour) => Err(format!("a colour {:?}", colour.lab)),
    }
}

/// Values of a sample at 400, 550 and 700 nm.
fn values(text: &str, patch: &str) -> [f64; 3] {
    let read =
        spectrum(text, &requested(patch, None, None)).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let nm: Vec<f64> = read.rows.iter().map(|row| row[0]).collect();
    assert_eq!(nm, [400.0, 550.0, 700.0], "{text}");
    [0, 1, 2].map(|i| read.rows[i][1])
}

/// Whether values are the expected ones.
fn close(found: [f64; 3], expected: [f64; 3]) -> bool {
    // identity: decimal text and a division by 100
    (0..3).all(|i| (found[i] - expected[i]).abs() < 1e-12)
}

/// Asserts that a text is refused with these words.
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
    let paper = row("\"paper\"", PAPER);
    let black = row("\"black\"", BLACK);
    format!(
        "{head}\nBEGIN_DATA_FORMAT\nSAMPLE_NAME {fields}\nEND_DATA_FORMAT\nNUMBER_OF_SETS 2\nBEGIN_DATA\n{paper}{black}END_DATA\n"
    )
}

const FIELDS: &str = "SPEC_400 SPEC_550 SPEC_700";

const ANNULAR: &str = "<cc:SingleAngle><cc:SingleAngleConfiguration>Annular</cc:SingleAngleConfiguration>\
                       <cc:IlluminationAngle>45</cc:IlluminationAngle><cc:MeasurementAngle>0</cc:MeasurementAngle></cc:SingleAngle>";

/// CxF3 of one ink under several conditions: 5 %, 40 % and 80 %, a tenth more under each further one.
fn cxf(kind: &str, geometry: &str, lights: &[&str]) -> String {
    let mut spectra = String::new();
    let mut specifications = String::new();
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

/// FOGRA39L's way: no names, amounts of ink, conditions in words.
const CHART: &str = "ORIGINATOR\t\"a, institute\"\nDESCRIPTOR\t\"FOGRA39L, D65\"\nCREATED\t\"December 2006\"\n\
    INSTRUMENTATION\t\"D50, 2 degree, geometry 45/0, no polarisation filter, white backing, according to ISO 13655\"\n\
    PRINT_CONDITIONS\t\"Offset, tone value increase curves A (CMY) and B (K)\"\nNUMBER_OF_FIELDS\t11\nBEGIN_DATA_FORMAT\n\
    SAMPLE_ID\tCMYK_C\tCMYK_M\tCMYK_Y\tCMYK_K\tXYZ_X\tXYZ_Y\tXYZ_Z\tLab_L\tLab_A\tLab_B\nEND_DATA_FORMAT\nNUMBER_OF_SETS\t3\n\
    BEGIN_DATA\n1\t0\t0\t0\t0\t84.54\t87.6\t74.77\t95\t0\t-2\n2\t0\t10\t0\t0\t79\t79\t68\t91.3\t6.6\t-3.1\n\
    3\t0\t0\t100\t0\t68\t71\t7\t88.1\t-5.2\t93.5\nEND_DATA\n";
