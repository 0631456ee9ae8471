//! Forms of files: heads, names of fields, remarks, wrapped sets, tables of instruments; every form reads back as it was written.

use super::{BLACK, FIELDS, cgats, close, refusal, requested, spectrum, values};
use inkwave::input::measured::{MeasuredRequest, MeasuredUnit};
use proptest::prelude::*;

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
    let two =
        spectrum(&plain.replace("\"black\"", "# page 2\n\"black\""), &requested("", None, None)).unwrap();
    assert!(two.source.ends_with("\"paper\", sample 1 of 2"), "{}", two.source);
    for cut in ["END_DATA\n", "\"black\""] {
        let text = &plain[..plain.rfind(cut).unwrap()];
        refusal(text, &requested("paper", None, None), &["cut short"]);
    }
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
        refusal(text, &requested("inc", None, None), &["no sample \"inc\"; found \"paper\", \"ink\""]);
        let several = MeasuredRequest { one_must_be_named: true, ..MeasuredRequest::default() };
        refusal(text, &several, &["2 samples", "compare.patch", "\"paper\""]);
    }
    assert!(close(values(rows, "2"), wanted));
    assert!(close(values("400,0.9,0.05\n550,0.9,0.4\n700,0.9,0.8\n", "2"), wanted));
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
        let read = spectrum(&text, &MeasuredRequest { used_nm: [380.0, 2000.0], ..requested("", Some(MeasuredUnit::Factor), None) });
        prop_assert_eq!(read.map(|read| read.rows), Ok(wanted), "{}", text);
    }
}
