//! Files that are easily misread: pairs of columns, other quantities, decimal commas, contradictions, text in parts, and lines that
//! end by a carriage return.

use super::{ANNULAR, FIELDS, cgats, close, cxf, reading, refusal, requested, spectrum, values};
use inkwave::input::measured::{MeasuredKind, MeasuredRequest, MeasuredUnit, Patch};

const INK: [f64; 3] = [0.05, 0.4, 0.8];

/// Each sample is taken at the wavelengths of the column before it; the pairs' wavelengths differ.
#[test]
fn samples_side_by_side_have_their_own_wavelengths() {
    for (heads, separator) in [
        (["nm", "nm"], ","),
        (["Wavelength (nm)", "Wavelength (nm)"], ";"),
        (["wavelength_nm", "wavelength_nm"], "\t"),
        (["nm", "nm.1"], ","),
        (["nm", "nm_2"], ","),
        (["lambda", "lambda"], ";"),
        (["wavelength", "Wavelength (nm) 2"], ","),
    ] {
        let rows = ["390,.82,400,.05", "540,.84,550,.4", "690,.86,700,.8", "740,.9,,"];
        let head = [heads[0], "paper", heads[1], "ink"].join(separator);
        let text = format!("{head}\n{}\n", rows.join("\n").replace(',', separator));
        assert!(close(values(&text, "ink"), INK), "{text}");
        let paper = spectrum(&text, &requested("paper", None, None)).unwrap();
        assert_eq!(paper.rows[..3], [[390.0, 0.82], [540.0, 0.84], [690.0, 0.86]]);
        let percent = text.replace(".82", "82").replace(".05", "5").replace(".4", "40");
        let percent =
            percent.replace(".84", "84").replace(".86", "86").replace(".8", "80").replace(".9", "90");
        assert!(close(values(&percent, "ink"), INK), "{percent}");
    }
    let micrometres = "nm,paper,wavelength_um,ink\n390,.8,.4,.05\n540,.8,.55,.4\n690,.8,.7,.8\n";
    assert!(close(values(micrometres, "ink"), INK));
    for (text, says) in [
        ("paper,nm,ink,nm\n.8,390,.05,400\n.8,540,.4,550\n.8,690,.8,700\n", "none before \"paper\""),
        ("nm,nm,ink\n390,400,.05\n540,550,.4\n", "that differ, 390 and 400"),
        ("390,.8,400,.05\n540,.8,550,.4\n690,.8,700,.8\n", "look like wavelengths"),
        ("nm,paper,q,ink\n390,.8,400,.05\n540,.8,550,.4\n690,.8,700,.8\n", "look like wavelengths"),
    ] {
        for patch in ["ink", "1", ""] {
            for unit in [None, Some(MeasuredUnit::Factor)] {
                refusal(text, &requested(patch, unit, None), &[says]);
            }
        }
    }
    // the same wavelengths in two units are one column
    assert!(close(values("wavelength_um,nm,ink\n.4,400,.05\n.55,550,.4\n.7,700,.8\n", ""), INK));
}

/// What is no reflectance is no reflectance under any name, in columns, titles, heads and keywords.
#[test]
fn other_quantities_are_no_reflectances() {
    let any = requested("", None, None);
    let transmitted = MeasuredRequest { kind: MeasuredKind::Transmittance, ..requested("", None, None) };
    for quantity in [
        "K/S",
        "KS",
        "k/s",
        "K_S",
        "Kubelka-Munk",
        "F(R)",
        "log(1/R)",
        "log 1/R",
        "-log10(R)",
        "ln(1/R)",
        "absorbance",
        "Absorbance (a.u.)",
        "A",
        "Abs",
        "OD",
        "O.D. density",
        "optical density",
        "density",
        "Reflection density",
        "extinction",
        "absorptance",
        "counts",
    ] {
        let text = format!("wavelength_nm,{quantity}\n400,0.9\n550,0.4\n700,0.1\n");
        for request in [&any, &transmitted] {
            refusal(&text, request, &["column reflectance is missing", quantity]);
        }
        let beside = format!("nm,{quantity},R\n400,0.9,.05\n550,0.4,.4\n700,0.1,.8\n");
        assert!(close(values(&beside, ""), INK), "{beside}");
    }
    for name in ["T", "%T", "T (%)", "ink %T", "Transmission"] {
        refusal(&format!("nm,{name}\n400,.9\n550,.4\n"), &any, &["transmi"]);
    }
    for head in [
        "Y units: K/S",
        "Mode: Absorbance",
        "Data type: log(1/R)",
        "Absorbance",
        "Kubelka-Munk",
        "Ordinate: T",
    ] {
        for rest in ["nm,ink\n400,.9\n550,.4\n700,.1\n", "name,400,550,700\nink,.9,.4,.1\n"] {
            let text = format!("{head}\n{rest}");
            assert!(spectrum(&text, &any).is_err(), "{text}");
        }
    }
    for keyword in [
        "SPECTRAL_UNITS \"K/S\"",
        "MEAS_TYPE \"density\"",
        "MEASUREMENT_TYPE \"log(1/R)\"",
        "YUNITS \"absorbance\"",
    ] {
        let text = cgats(&format!("CGATS.17\n{keyword}"), FIELDS, 0.01);
        refusal(&text, &requested("paper", None, None), &["not reflectance"]);
    }
    let unit = cxf(
        "Spectrum_Reflectance",
        &format!("{ANNULAR}</cc:GeometryChoice><cc:Unit>K/S</cc:Unit><cc:GeometryChoice>"),
        &["M0_Incandescent"],
    );
    refusal(&unit, &any, &["K/S", "not reflectance"]);
    for y in ["TRANSMITTANCE", "KUBELKA-MUNK", "ABSORBANCE", "REFLECTANCE"] {
        for data in
            ["##XYPOINTS=(XY..XY)\n400,.9\n550,.4\n", "##XYDATA=(X++(Y..Y))\n400 1 2\n", "400,.9\n550,.4\n"]
        {
            let text =
                format!("##TITLE=ink\n##JCAMP-DX=4.24\n##XUNITS=NANOMETERS\n##YUNITS={y}\n{data}##END=\n");
            refusal(&text, &any, &["JCAMP-DX", y, "CSV"]);
        }
    }
    // a title over a column that says in full what it holds may be the sample's
    let titled = |head: &str| format!("{head}\nnm,reflectance\n400,.05\n550,.4\n700,.8\n");
    assert!(close(values(&titled("Density"), ""), INK));
    refusal(&titled("Mode: Density"), &any, &["not reflectance"]);
    // names of samples that hold such letters
    for name in ["ink/substrate", "black K", "density 1.2", "T1", "A4 sheet"] {
        assert!(close(values(&format!("nm,{name}\n400,.05\n550,.4\n700,.8\n"), ""), INK), "{name}");
    }
}

/// Decimal commas between commas: neither the whole numbers nor the decimals are a spectrum.
#[test]
fn decimal_commas_between_commas_are_refused() {
    for text in [
        "400,0,0503\n550,0,4\n700,0,8\n",
        "400,0,5\n550,0,4\n700,0,8\n",
        "400,5,03\n550,40,0\n700,80,1\n",
        "ink\n400,0,05\n550,0,4\n700,0,8\n",
        "nm,R,\n400,0,0503\n550,0,4\n700,0,8\n",
        "400,5,03e-2\n550,4,0e-1\n700,8,0e-1\n",
        "400,0,0,05\n550,0,0,4\n700,0,0,8\n",
    ] {
        for patch in ["", "1", "2"] {
            for unit in [None, Some(MeasuredUnit::Factor), Some(MeasuredUnit::Percent)] {
                refusal(text, &requested(patch, unit, None), &["comma", "quotes", "sep="]);
            }
        }
    }
    // each remedy is read
    for text in [
        "400,0.05\n550,0.4\n700,0.8\n",
        "400,\"0,05\"\n550,\"0,4\"\n700,\"0,8\"\n",
        "sep=;\n400;0,05\n550;0,4\n700;0,8\n",
        "nm,ink,paper\n400,5,82\n550,40,84\n700,80,86\n",
    ] {
        assert!(close(values(text, ""), INK), "{text}");
    }
}

/// One sample that no surface can have shows that the file is misread, whichever sample is used.
#[test]
fn all_samples_of_a_file_are_looked_at() {
    for text in [
        "nm,p,q\n400,.05,8\n550,.4,7999\n700,.8,80\n",
        "name,400,550,700\na,.05,.4,.8\nb,8,7999,80\n",
        &cgats("CGATS.17\nSPECTRAL_NORM \"1\"", FIELDS, 0.01).replace("\"black\"\t0.0052", "\"black\"\t5.2"),
    ] {
        let first = spectrum(text, &requested("", None, None)).expect_err(text);
        assert!(first.contains("not a reflectance factor") && first.contains("misread"), "{first}");
    }
    // outside of what is used it blocks nothing, and a key may correct what is declared
    assert!(spectrum("nm,p,q\n400,.05,.8\n700,.8,.8\n2000,1,9e9\n", &requested("", None, None)).is_ok());
    let wrong = cgats("CGATS.17\nSPECTRAL_NORM \"1\"", FIELDS, 1.0);
    assert!(spectrum(&wrong, &requested("black", Some(MeasuredUnit::Percent), None)).is_ok());
}

/// CxF follows the rule of tables, and for a norm that its values contradict there is a remark.
#[test]
fn units_of_cxf_and_declared_norms() {
    let of = |values: [&str; 3]| {
        let text = cxf("Spectrum_Reflectance", ANNULAR, &["M0_Incandescent"]);
        assert!(text.contains(">0.05 0.4 0.8<"));
        text.replace(">0.05 0.4 0.8<", &format!(">{}<", values.join(" ")))
    };
    let said = |text: &str| reading(text, &requested("", None, None)).unwrap().remarks.join("; ");
    assert!(said(&of(["0.4", "0.5", "0.55"])).contains("taken as factors"));
    assert!(said(&of(["5", "40", "80"])).contains("taken as percent"));
    assert!(close(values(&of(["5", "40", "80"]), ""), INK));
    let between = of(["2.51", "2.51", "2.51"]);
    refusal(&between, &requested("", None, None), &["no unit is stated", "2.51", "compare.unit"]);
    let black = spectrum(&between, &requested("", Some(MeasuredUnit::Percent), None)).unwrap();
    assert!((black.rows[0][1] - 0.0251).abs() < 1e-15);
    let norm = |text: &str, norm: &str| {
        text.replace("<cc:Device>", &format!("<cc:SpectralNorm>{norm}</cc:SpectralNorm><cc:Device>"))
    };
    assert!(close(values(&norm(&between, "100"), ""), [0.0251; 3]));
    assert_eq!(said(&norm(&of(["0.4", "0.5", "1.2"]), "1")), "");
    for text in [
        norm(&of(["0.4", "0.5", "0.55"]), "100"),
        cgats("CGATS.17\nSPECTRAL_NORM \"100\"", FIELDS, 0.01),
        "nm,%R\n400,.05\n550,.4\n700,.8\n".to_owned(),
    ] {
        let remark = said(&text);
        assert!(remark.contains("declares 100") && remark.contains("compare.unit"), "{remark}");
    }
}

/// Rows of one wavelength say one value, at the ends of the range as within it.
#[test]
fn rows_that_contradict_each_other_are_refused() {
    let request = MeasuredRequest { used_nm: [400.0, 700.0], ..MeasuredRequest::default() };
    for nm in ["400", "550", "700"] {
        for place in 0..4 {
            let mut rows = vec!["400,.05", "550,.4", "700,.8"];
            let other = format!("{nm},.5");
            rows.insert(place, &other);
            for head in ["nm,reflectance", "wavelength_nm,albedo", "nm,ink"] {
                refusal(
                    &format!("{head}\n{}\n", rows.join("\n")),
                    &request,
                    &[&format!("two values at {nm} nm")],
                );
            }
        }
    }
    let fields = "SPEC_400 SPEC_550 SPEC_700 SPEC_700";
    let text = cgats("CGATS.17", fields, 0.01)
        .replace("0.88\n", "0.88\t0.1\n")
        .replace("0.008199999999999999\n", "0.0082\t0.1\n");
    refusal(&text, &request, &["two values at 700 nm"]);
    let point = |nm: f64, value: f64| format!("<SpectralPoint WL=\"{nm}\">{value}</SpectralPoint>");
    let points = |last: f64| {
        let all = [point(400.0, 0.05), point(550.0, 0.4), point(700.0, 0.8), point(700.0, last)].concat();
        format!("<CxF><Object Name=\"ink\"><CustomSpectrum>{all}</CustomSpectrum></Object></CxF>")
    };
    refusal(&points(0.5), &request, &["two values at 700 nm"]);
    assert!(close(values(&points(0.8), ""), INK));
    assert!(close(values("nm,R\n400,.05\n550,.4\n700,.8\n700,.8\n400,.05\n", ""), INK));
}

/// Comments, character data, entities and instructions part a text; what is behind them counts.
#[test]
fn all_text_of_an_xml_element_counts() {
    let whole = cxf("Spectrum_Reflectance", ANNULAR, &["M0_Incandescent"]);
    for text in [
        "0.05 <!-- half -->0.4 0.8",
        "<!-- all -->0.05 0.4 0.8",
        "0.05 0.<!-- in a number -->4 0.8",
        "<![CDATA[0.05 0.4]]> 0.8",
        "0.05 <![CDATA[0.4]]><!-- x --> <![CDATA[0.8]]>",
        "0.05&#32;0.4&#x20;0.8",
        "0.05 <?note x?> 0.4 0.8",
        "\n0.05\r\n0.4\t0.8\n",
    ] {
        assert!(close(values(&whole.replace("0.05 0.4 0.8", text), ""), INK), "{text}");
    }
    let sphere = cxf(
        "Spectrum_Reflectance",
        "<cc:SphereGeometry><!-- x -->Specular_Included</cc:SphereGeometry>",
        &["M0_Incandescent"],
    );
    refusal(&sphere, &requested("", None, None), &["specular light included"]);
    let kind = cxf("<!-- x -->Spectrum_Transmittance", ANNULAR, &["M0_Incandescent"]);
    refusal(&kind, &requested("", None, None), &["transmi"]);
    let point = "<CxF><Object Name=\"ink\"><CustomSpectrum><SpectralPoint WL=\"400\"><!-- a -->0.05</SpectralPoint>\
                 <SpectralPoint WL=\"550\">0.<!-- b -->4</SpectralPoint><SpectralPoint WL=\"700\"><![CDATA[0.8]]></SpectralPoint>\
                 </CustomSpectrum></Object></CxF>";
    assert!(close(values(point, ""), INK));
}

/// Lines may end by a carriage return alone, and a sample's number may be written as a number.
#[test]
fn carriage_returns_end_lines_and_numbers_name_samples() {
    for text in [
        cgats("CGATS.17\nSPECTRAL_NORM \"1\"", FIELDS, 0.01),
        "# spectrometer X\nnm,paper\n400,.82\n550,.84\n700,.88\n".to_owned(),
        "name;400;550;700\npaper;82;84;88\n".to_owned(),
        cxf("Spectrum_Reflectance", ANNULAR, &["M0_Incandescent"]),
    ] {
        let wanted = values(&text, "");
        assert!(close(values(&text.replace('\n', "\r"), ""), wanted), "{text}");
        assert!(close(values(&text.replacen('\n', "\r", 1), ""), wanted), "{text}");
    }
    let patch = |json: &str| serde_json::from_str::<Patch>(json).map_err(|error| error.to_string());
    assert_eq!(patch("2"), Ok(Patch::Number(2)));
    assert_eq!(patch("\"2\""), Ok(Patch::Name("2".into())));
    let numbered = "id,400,550,700\n1,.82,.84,.88\n2,.05,.4,.8\n";
    let second = MeasuredRequest { patch: Some(Patch::Number(2)), ..MeasuredRequest::default() };
    assert_eq!(spectrum(numbered, &second).unwrap().rows[0], [400.0, 0.05]);
    assert_eq!(patch("[0, 0, 100, 0]"), Ok(Patch::Inks(vec![0.0, 0.0, 100.0, 0.0])));
    for wrong in ["2.5", "-1", "true"] {
        assert!(patch(wrong).unwrap_err().contains("name or number"), "{wrong}");
    }
}
