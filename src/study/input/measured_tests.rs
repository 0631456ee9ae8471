//! Spectra and colours in the forms that users have them.

use super::*;
use crate::appearance::viewing::Summation;

const CXF: &str = "http://colorexchangeformat.com/CxF3-core";

fn spectrum(text: &str, request: &MeasuredRequest) -> Result<MeasuredSpectrum, String> {
    match MeasuredReading::parse(text, "ink.csv", request)?.measured {
        MeasuredContent::Spectrum(spectrum) => Ok(spectrum),
        MeasuredContent::Colour(_) => Err("a colour".into()),
    }
}

fn read(text: &str) -> Result<MeasuredSpectrum, String> {
    spectrum(text, &MeasuredRequest::default())
}

fn of_patch(text: &str, patch: &str) -> Result<MeasuredSpectrum, String> {
    spectrum(text, &MeasuredRequest { patch: Some(Patch::Name(patch.into())), ..Default::default() })
}

fn in_unit(text: &str, unit: MeasuredUnit) -> Result<MeasuredSpectrum, String> {
    spectrum(text, &MeasuredRequest { unit: Some(unit), ..Default::default() })
}

#[test]
fn the_same_spectrum_in_four_files() {
    let csv = "wavelength_nm,reflectance\n400,0.25\n410,0.5\n";
    let excel = "Wavelength;Reflectance\r\n400;25,0\r\n410;50,0\r\n";
    let cxf = format!(
        "<?xml version=\"1.0\"?><c:CxF xmlns:c=\"{CXF}\"><c:Resources><c:ObjectCollection><c:Object><c:ColorValues>\
         <c:ReflectanceSpectrum ColorSpecification=\"b\" StartWL=\"400\">0.25 0.5</c:ReflectanceSpectrum>\
         </c:ColorValues></c:Object></c:ObjectCollection><c:ColorSpecificationCollection>\
         <c:ColorSpecification Id=\"a\"><c:WavelengthRange StartWL=\"380\" Increment=\"5\"/></c:ColorSpecification>\
         <c:ColorSpecification Id=\"b\"><c:WavelengthRange StartWL=\"400\" Increment=\"10\"/></c:ColorSpecification>\
         </c:ColorSpecificationCollection></c:Resources></c:CxF>"
    );
    let cgats = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME LAB_L SPEC_400 SPEC_410\nEND_DATA_FORMAT\nBEGIN_DATA\n\"my ink\" 50 25.0 50.0\nEND_DATA\n";
    for text in [csv, excel, &cxf, cgats] {
        assert_eq!(read(text).unwrap().rows, vec![[400.0, 0.25], [410.0, 0.5]], "{text}");
    }
    let wider = read(&cxf.replace("Increment=\"10\"", "Increment=\"20\"")).unwrap();
    assert_eq!(wider.rows, vec![[400.0, 0.25], [420.0, 0.5]]);
    let spectrum = read(csv).unwrap();
    assert_eq!((spectrum.at(405.0), spectrum.at(399.0)), (Some(0.375), None));
}

/// A dark print in percent has no value that distinguishes it from factors: the unit is required.
#[test]
fn a_dark_print_in_percent_needs_its_unit() {
    let file = |values: [f64; 2]| format!("nm,r\n400,{}\n410,{}\n", values[0], values[1]);
    let rows = |values: [f64; 2], unit: MeasuredUnit| {
        in_unit(&file(values), unit).map(|m| [m.rows[0][1], m.rows[1][1]])
    };
    let dark = [0.8, 2.9];
    let asked = read(&file(dark)).unwrap_err();
    assert!(asked.contains("2.9") && asked.contains("compare.unit = \"percent\""), "{asked}");
    assert_eq!(rows(dark, MeasuredUnit::Percent).unwrap(), dark.map(|x| x / 100.0));
    assert_eq!(rows(dark, MeasuredUnit::Factor).unwrap(), dark);
    assert_eq!(rows([0.2, 0.9], MeasuredUnit::Percent).unwrap(), [0.2, 0.9].map(|x: f64| x / 100.0));
    assert_eq!(read(&file([0.2, 1.0])).unwrap().rows[1][1], 1.0);
    assert!(rows([20.0, 90.0], MeasuredUnit::Factor).unwrap_err().contains("not a reflectance factor"));
}

#[test]
fn of_several_samples_the_one_that_is_named_is_taken() {
    let cgats = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME SPEC_400 SPEC_410\nEND_DATA_FORMAT\nBEGIN_DATA\n\
                 1 \"paper\" 90 91\n\n2 \"my ink\" 25 50\nEND_DATA\n";
    let object = |name: &str, values: &str| {
        format!(
            "<c:Object Name=\"{name}\" Id=\"{name} id\"><c:ReflectanceSpectrum StartWL=\"400\">{values}</c:ReflectanceSpectrum></c:Object>"
        )
    };
    let cxf = format!(
        "<c:CxF xmlns:c=\"{CXF}\">{}{}<c:WavelengthRange StartWL=\"400\" Increment=\"10\"/></c:CxF>",
        object("paper", "0.90 0.91"),
        object("my ink", "0.25 0.50"),
    );
    for text in [cgats, &cxf] {
        let (first, named) = (read(text).unwrap(), of_patch(text, "my ink").unwrap());
        assert_eq!((first.rows[0], named.rows[0]), ([400.0, 0.9], [400.0, 0.25]));
        assert!(first.source.ends_with(": \"paper\", sample 1 of 2"), "{}", first.source);
        assert!(named.source.ends_with(": \"my ink\", sample 2 of 2") && named.patches == 2);
        let none = of_patch(text, "ink").unwrap_err();
        assert!(none.contains("no sample \"ink\"; found \"paper\", \"my ink\""), "{none}");
    }
    assert_eq!(of_patch(cgats, "2").unwrap().rows[0], [400.0, 0.25]);
    let table = of_patch("wavelength_nm,reflectance\n400,0.25\n410,0.5\n", "ink");
    assert!(table.unwrap_err().contains("no names"));
}

#[test]
fn files_without_a_spectrum_are_refused_with_their_reason() {
    let reason = |text: &str| read(text).unwrap_err();
    assert!(reason("wavelength_nm,lab\n400,1\n").contains("column reflectance is missing"));
    assert!(reason("wavelength_nm,reflectance\n410,\n420,1\n").contains("line 2, 410 nm: an empty cell"));
    assert!(reason("wavelength_nm,reflectance\n410,NaN\n420,1\n").contains("not a number"));
    assert!(reason("wavelength_nm,reflectance\n0.41,1\n0.42,1\n").contains("these look like µm"));
    assert!(reason("wavelength_nm,reflectance\n410,0,5\n").contains("(wavelength_nm;reflectance)"));
    assert!(reason("<CxF/>").contains("without spectra"));
    assert!(!reason("<CxF").is_empty());
    assert!(reason("<html></html>").contains("not CxF"));
    assert!(reason("wavelength_nm,reflectance\n400,-0.5\n420,0.5\n").contains("-0.5 at 400 nm"));
    assert!(reason("wavelength_nm,reflectance\n400,30000\n420,0.5\n").contains("30000 at 400 nm"));
    let short = "CGATS.17\nBEGIN_DATA_FORMAT\nSPEC_400 SPEC_500\nEND_DATA_FORMAT\nBEGIN_DATA\n1\nEND_DATA\n";
    assert!(reason(short).contains("1 values under 2 fields"), "{}", reason(short));
    let rgb = "CGATS.17\nBEGIN_DATA_FORMAT\nRGB_R\nEND_DATA_FORMAT\nBEGIN_DATA\n1\nEND_DATA\n";
    assert!(reason(rgb).contains("CGATS file without spectra"), "{}", reason(rgb));
    assert!(MeasuredReading::new(Path::new("none.cxf"), &MeasuredRequest::default()).is_err());
}

const LAB: &str = "CGATS.17\nCONDITIONS\nBEGIN_DATA_FORMAT\nSAMPLE_NAME LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\n\
                   BEGIN_DATA\n\"paper\" 95 0 -2\n\"my ink\" 85.5 -10 80\nEND_DATA\n";

fn lab_cxf(specification: &str) -> String {
    format!(
        "<c:CxF xmlns:c=\"{CXF}\"><c:Object Name=\"my ink\"><c:ColorCIELab ColorSpecification=\"s\"><c:L>85.5</c:L>\
         <c:A>-10</c:A><c:B>80</c:B></c:ColorCIELab></c:Object><c:ColorSpecification Id=\"s\">{specification}\
         </c:ColorSpecification></c:CxF>"
    )
}

fn colour_of(text: &str, patch: Option<&str>) -> Result<MeasuredColour, String> {
    let patch = patch.map(|name| Patch::Name(name.into()));
    match MeasuredReading::parse(text, "lab.txt", &MeasuredRequest { patch, ..Default::default() })?.measured
    {
        MeasuredContent::Colour(colour) => Ok(colour),
        MeasuredContent::Spectrum(_) => Err("a spectrum".into()),
    }
}

#[test]
fn lab_alone_is_a_colour_under_the_conditions_that_the_file_states() {
    let spec = "<c:TristimulusSpec><c:Illuminant>D50</c:Illuminant><c:Observer>2_Degree</c:Observer></c:TristimulusSpec>";
    let conditions = [
        "WEIGHTING_FUNCTION \"ILLUMINANT, D50\"\nWEIGHTING_FUNCTION \"OBSERVER, 2 degree\"",
        "ILLUMINATION_NAME \"D50\"\nOBSERVER_ANGLE \"2\"",
        "MEASUREMENT_SOURCE \"Illumination=D50\tObserverAngle=2°\tWhiteBase=Abs\"",
        "ILLUMINANT \"D50\"\nOBSERVER \"CIE 2 degree\"",
        "INSTRUMENTATION \"D50, 2 degree, geometry 45/0, no polarisation filter, white backing\"",
    ];
    let texts = conditions.map(|stated| LAB.replace("CONDITIONS", stated));
    for text in texts.iter().chain([&lab_cxf(spec)]) {
        let colour = colour_of(text, Some("my ink")).unwrap();
        assert_eq!(colour.lab, [85.5, -10.0, 80.0]);
        let viewing = colour.viewing.unwrap();
        assert_eq!((viewing.illuminant(), viewing.observer()), ("D50", "2"), "{text}");
    }
    let wide = "WEIGHTING_FUNCTION \"ILLUMINANT, A\"\nWEIGHTING_FUNCTION \"OBSERVER, 2015, 10 degree\"";
    let wide = colour_of(&LAB.replace("CONDITIONS", wide), Some("paper")).unwrap();
    assert_eq!((wide.lab[0], wide.viewing.unwrap().observer()), (95.0, "2015_10"));
}

#[test]
fn conditions_that_are_not_stated_or_not_known_are_errors_and_spectra_go_before_colours() {
    for text in [LAB.to_owned(), lab_cxf("")] {
        let colour = colour_of(&text, Some("my ink")).unwrap();
        assert!(colour.viewing.unwrap_err().contains("not stated"));
    }
    let odd = LAB.replace("CONDITIONS", "ILLUMINATION_NAME \"D93\"\nOBSERVER_ANGLE \"2\"");
    assert!(colour_of(&odd, Some("paper")).unwrap().viewing.unwrap_err().contains("D93"));
    let two = LAB.replace("CONDITIONS", "COMPUTATIONAL_PARAMETER \"D50 and D65, 2 degree\"");
    assert!(colour_of(&two, Some("paper")).unwrap().viewing.unwrap_err().contains("D50 and D65"));
    let unnamed = colour_of(LAB, None).unwrap_err();
    assert!(unnamed.contains("2 samples") && unnamed.contains("compare.patch"), "{unnamed}");
    assert!(colour_of(LAB, Some("none")).unwrap_err().contains("no sample"));
    assert!(colour_of(&LAB.replace("85.5", "x"), Some("my ink")).is_err());
    let spectral = LAB
        .replace("LAB_B", "LAB_B SPEC_400 SPEC_410")
        .replace("-2\n", "-2 90 90\n")
        .replace("80\n", "80 50 50\n");
    assert_eq!(of_patch(&spectral, "my ink").unwrap().rows[0], [400.0, 0.5]);
}

/// X, Y, Z of CIE white D50 are L* 100 within the rounding of the tables (sums of 5 nm: ± 0.03
/// in Z), and those of half its luminance L* 76.07, by the formula of CIE 15.
#[test]
fn x_y_z_alone_are_a_colour_relative_to_white_of_the_stated_light() {
    let xyz = LAB
        .replace("CONDITIONS", "ILLUMINATION_NAME \"D50\"\nOBSERVER_ANGLE \"2\"")
        .replace("LAB_L LAB_A LAB_B", "XYZ_X XYZ_Y XYZ_Z")
        .replace("95 0 -2", "96.42 100 82.49")
        .replace("85.5 -10 80", "48.21 50 41.245");
    let cxf = lab_cxf(
        "<c:TristimulusSpec><c:Illuminant>D50</c:Illuminant><c:Observer>2_Degree</c:Observer></c:TristimulusSpec>",
    )
    .replace("CIELab", "CIEXYZ")
    .replace("<c:L>85.5</c:L>", "<c:X>48.21</c:X>")
    .replace("<c:A>-10</c:A><c:B>80</c:B>", "<c:Y>50</c:Y><c:Z>41.245</c:Z>");
    let near = |found: [f64; 3], expected: [f64; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.05), "{found:?}, not {expected:?}");
    };
    near(colour_of(&xyz, Some("paper")).unwrap().lab, [100.0, 0.0, 0.0]);
    near(colour_of(&xyz, Some("my ink")).unwrap().lab, [76.069, 0.0, 0.0]);
    near(colour_of(&cxf, Some("my ink")).unwrap().lab, [76.069, 0.0, 0.0]);
    let unstated = colour_of(&xyz.replace("OBSERVER_ANGLE", "#"), Some("paper")).unwrap_err();
    assert!(unstated.contains("not stated"), "{unstated}");
    let shares = xyz.replace("96.42 100 82.49", "0.9642 1 0.8249").replace("48.21 50 41.245", "0.5 0.5 0.4");
    let shares = colour_of(&shares, Some("paper")).unwrap_err();
    assert!(shares.contains("compare.unit"), "{shares}");
}

/// Of a colour under several conditions that of the study is taken.
#[test]
fn a_colour_under_the_conditions_of_the_study_is_found_among_others() {
    let specification = |id: &str, light: &str| {
        format!(
            "<ColorSpecification Id=\"{id}\"><TristimulusSpec><Illuminant>{light}</Illuminant><Observer>10_Degree</Observer>\
             </TristimulusSpec></ColorSpecification>"
        )
    };
    let colour = |id: &str, l: f64| {
        format!("<ColorCIELab ColorSpecification=\"{id}\"><L>{l}</L><A>1</A><B>2</B></ColorCIELab>")
    };
    let text = format!(
        "<CxF><Object Name=\"a\">{}{}</Object>{}{}</CxF>",
        colour("x", 50.0),
        colour("y", 51.0),
        specification("x", "D50"),
        specification("y", "D65")
    );
    let viewing = Viewing::new("D65", "10", Summation::E308).unwrap();
    let request = MeasuredRequest { viewing: viewing.clone(), ..Default::default() };
    let MeasuredContent::Colour(found) = MeasuredReading::parse(&text, "a.cxf", &request).unwrap().measured
    else {
        panic!("a colour")
    };
    assert_eq!((found.lab[0], found.viewing), (51.0, Ok(viewing)));
}

/// Sums over a spectrum's own rows: an edge between the steps of a study is not lost, and cutting
/// the range between two rows interpolates. *Planted*: the values at every sixth row alone move b*
/// by more than one.
#[test]
fn a_colour_is_summed_over_the_spectrums_own_rows() {
    let rows: Vec<[f64; 2]> = (0..=35)
        .map(|i| 380.0 + 10.0 * f64::from(i))
        .map(|nm| [nm, 0.04 + 0.8 / (1.0 + (-(nm - 505.0) / 7.0).exp())])
        .collect();
    let own = MeasuredSpectrum { source: String::new(), rows, patches: 1 };
    let viewing = Viewing::default();
    let lab = own.colour(&viewing, [400.0, 700.0]).unwrap().lab;
    let inside: Vec<[f64; 2]> =
        own.rows.iter().copied().filter(|row| (400.0..=700.0).contains(&row[0])).collect();
    let (nm, values): (Vec<f64>, Vec<f64>) = inside.iter().map(|row| (row[0], row[1])).unzip();
    assert_eq!(Colorimeter::under(&nm, &viewing).unwrap().colour(&values).unwrap().lab, lab);
    let coarse: Vec<f64> = nm.iter().copied().step_by(6).collect();
    let coarse_values: Vec<f64> = coarse.iter().map(|&nm| own.at(nm).unwrap()).collect();
    let wrong = Colorimeter::under(&coarse, &viewing).unwrap().colour(&coarse_values).unwrap().lab;
    assert!((wrong[2] - lab[2]).abs() > 1.0, "{wrong:?} {lab:?}");
    // ends between rows: a nanometre of range is less than a screen shows
    let between = own.colour(&viewing, [401.0, 699.0]).unwrap().lab;
    assert!((0..3).all(|i| (between[i] - lab[i]).abs() < 0.2), "{between:?} {lab:?}");
    assert!(own.colour(&viewing, [620.0, 700.0]).is_err());
}
