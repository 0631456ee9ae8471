//! CxF3 (ISO 17972): the spectra of the print with Lab, as colour instruments' programs exchange them.
//!
//! The format has no slot for uncertainties: they are tags of each object. What was simulated says so in `Creator`,
//! `Description` and in the tags.

use super::print::{InstrumentGeometry, Print, PrintSpectrum, xml};
use std::fmt::Write;

/// Decimals of reflectance factors: far below any standard error.
const DECIMALS: usize = 7;
/// Illuminants that the format has a name for, of those that a study may ask for.
const ILLUMINANTS: [&str; 11] = ["A", "D50", "D65", "E", "F2", "F3", "F7", "F9", "F10", "F11", "F12"];

/// The whole file.
pub fn cxf(print: &Print) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    out += "<cc:CxF xmlns:cc=\"http://colorexchangeformat.com/CxF3-core\">\n";
    out += &information(print);
    out += "<cc:Resources>\n<cc:ObjectCollection>\n";
    print.spectra.iter().for_each(|spectrum| out += &object(print, spectrum));
    out += "</cc:ObjectCollection>\n<cc:ColorSpecificationCollection>\n";
    print.spectra.iter().for_each(|spectrum| out += &specification(print, spectrum));
    out += "</cc:ColorSpecificationCollection>\n</cc:Resources>\n</cc:CxF>\n";
    out
}

fn information(print: &Print) -> String {
    let description = format!(
        "Simulated, not measured: {} (study {}, mirror reflection {})",
        print.title, print.study_hash, "left out of 45:0"
    );
    format!(
        "<cc:FileInformation>\n<cc:Creator>{} (simulated)</cc:Creator>\n<cc:CreationDate>{}</cc:CreationDate>\n\
         <cc:Description>{}</cc:Description>\n</cc:FileInformation>\n",
        xml(&print.program),
        print.created,
        xml(&description),
    )
}

fn object(print: &Print, spectrum: &PrintSpectrum) -> String {
    let (id, name) = (spectrum.geometry.id(), spectrum.geometry.name());
    let mut out = format!(
        "<cc:Object ObjectType=\"Standard\" Name=\"{}\" Id=\"{id}\">\n<cc:CreationDate>{}</cc:CreationDate>\n",
        xml(&format!("{} ({name})", print.title)),
        print.created,
    );
    let values: Vec<String> = spectrum.values.iter().map(|e| format!("{:.DECIMALS$}", e.value)).collect();
    let start = print.wavelengths_nm.first().copied().unwrap_or(0);
    let _ = writeln!(
        out,
        "<cc:ColorValues>\n<cc:ReflectanceSpectrum ColorSpecification=\"spec_{id}\" StartWL=\"{start}\">{}</cc:ReflectanceSpectrum>",
        values.join(" ")
    );
    if let Some(colour) = &spectrum.colour {
        let [l, a, b] = colour.lab;
        let _ = writeln!(
            out,
            "<cc:ColorCIELab ColorSpecification=\"spec_{id}\"><cc:L>{l:.5}</cc:L><cc:A>{a:.5}</cc:A><cc:B>{b:.5}</cc:B></cc:ColorCIELab>"
        );
    }
    out += "</cc:ColorValues>\n";
    out += &tags(print, spectrum);
    out + "</cc:Object>\n"
}

fn tags(print: &Print, spectrum: &PrintSpectrum) -> String {
    let mut out = String::from("<cc:TagCollection Name=\"inkwave\">\n");
    let mut tag = |name: &str, value: &str| {
        let _ = writeln!(out, "<cc:Tag Name=\"{name}\" Value=\"{}\"/>", xml(value));
    };
    tag("Origin", "simulated");
    tag("StudyHash", &print.study_hash);
    tag("LabConditions", &print.viewing.name());
    tag("Spectra", print.spectra_from());
    tag("Lab", &print.lab_differs().unwrap_or_else(|| "as on the study's page".to_owned()));
    let errors: Option<Vec<String>> =
        spectrum.values.iter().map(|e| e.standard_error.map(|s| format!("{s:.DECIMALS$}"))).collect();
    tag("StandardErrors", &errors.map_or_else(|| "unknown".to_owned(), |e| e.join(" ")));
    if let Some(error) = spectrum.colour.as_ref().and_then(|c| c.lab_standard_error()) {
        tag("LabStandardErrors", &error.map(|e| format!("{e:.5}")).join(" "));
    }
    out + "</cc:TagCollection>\n"
}

/// Light and observer of Lab, with the white that Lab refers to; names that the format does not know are `Custom`.
fn tristimulus(print: &Print, spectrum: &PrintSpectrum) -> String {
    let (light, observer) = (print.viewing.illuminant(), print.viewing.observer());
    let white = spectrum.colour.as_ref().map_or_else(String::new, |colour| {
        let [x, y, z] = colour.white_xyz;
        format!(" X=\"{x:.5}\" Y=\"{y:.5}\" Z=\"{z:.5}\"")
    });
    let known = if ILLUMINANTS.contains(&light) { light } else { "Custom" };
    let observer = match observer {
        "2" => "<cc:Observer>2_Degree</cc:Observer>".to_owned(),
        "10" => "<cc:Observer>10_Degree</cc:Observer>".to_owned(),
        other => {
            let degree = other.trim_start_matches("2015_");
            format!("<cc:Observer Name=\"CIE 2015\" Angle=\"{degree}\">Custom_CMF</cc:Observer>")
        }
    };
    format!(
        "<cc:TristimulusSpec><cc:Illuminant Name=\"{light}\"{white}>{known}</cc:Illuminant>{observer}\
         <cc:Method>unknown</cc:Method></cc:TristimulusSpec>\n"
    )
}

fn specification(print: &Print, spectrum: &PrintSpectrum) -> String {
    let geometry = spectrum.geometry;
    let start = print.wavelengths_nm.first().copied().unwrap_or(0);
    let increment = print.wavelengths_nm.get(1).map_or(10, |second| second - start);
    let choice = match geometry {
        InstrumentGeometry::LitAt45 => {
            "<cc:SingleAngle><cc:SingleAngleConfiguration>Annular</cc:SingleAngleConfiguration>\
             <cc:IlluminationAngle>45</cc:IlluminationAngle><cc:MeasurementAngle>0</cc:MeasurementAngle></cc:SingleAngle>"
        }
        InstrumentGeometry::NaturalLight => {
            "<cc:UnknownGeometry>uniform hemisphere, seen along the normal</cc:UnknownGeometry>"
        }
    };
    format!(
        "<cc:ColorSpecification Id=\"spec_{}\">\n{}<cc:MeasurementSpec>\n<cc:MeasurementType>Spectrum_Reflectance</cc:MeasurementType>\n\
         <cc:GeometryChoice>{choice}</cc:GeometryChoice>\n\
         <cc:WavelengthRange StartWL=\"{start}\" Increment=\"{increment}\"/>\n\
         <cc:CalibrationStandard>Others</cc:CalibrationStandard>\n\
         <cc:Device><cc:Manufacturer>inkwave</cc:Manufacturer><cc:Model>simulation</cc:Model>\
         <cc:DeviceIllumination>M0_Incandescent</cc:DeviceIllumination></cc:Device>\n\
         </cc:MeasurementSpec>\n</cc:ColorSpecification>\n",
        geometry.id(),
        tristimulus(print, spectrum),
    )
}
