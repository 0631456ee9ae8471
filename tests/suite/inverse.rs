//! Files of fits and designs: what is wrong is said with its field and a remedy, before anything is solved.

use inkwave::fit::load::load as load_fit;
use inkwave::input::fault::StudyError;
use std::path::Path;

const INK: &str = "[layer]\nthickness_um = 1.0\nbinder.index = 1.5\n[[pigment]]\nname = \"a\"\ndiameter_nm = 200\n\
                   volume_fraction = 0.2\nindex = { built_in = \"yellow\" }\n[light]\nwavelengths_nm = [500, 600]\n\
                   [run]\nrealisations = 6\n";
const DYE: &str =
    "[[pigment]]\nname = \"dye\"\ndiameter_nm = \"molecular\"\nvolume_fraction = 0.02\nindex = 1.6\n";
const CARD: &str = "wavelength_nm,reflectance\n400,0.5\n700,0.6\n";
const OTHER_CARD: &str = "wavelength_nm,reflectance\n400,0.4\n700,0.5\n";

/// The faults that a reader finds in a file beside an ink and a spectrum.
fn faults<T>(text: &str, card: &str, read: fn(&Path) -> Result<T, StudyError>) -> Vec<String> {
    faults_with(INK, text, card, read)
}

fn faults_with<T>(
    ink: &str,
    text: &str,
    card: &str,
    read: fn(&Path) -> Result<T, StudyError>,
) -> Vec<String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("inverse.toml");
    for (name, content) in [("inverse.toml", text), ("ink.toml", ink), ("card.csv", card)] {
        std::fs::write(folder.path().join(name), content).expect("written");
    }
    match read(&path) {
        Ok(_) => Vec::new(),
        Err(StudyError::Values { faults, .. }) => {
            faults.iter().map(|fault| format!("{fault}; {}", fault.remedy)).collect()
        }
        Err(other) => vec![other.to_string()],
    }
}

/// The one fault must name all these words.
fn one_fault(found: &[String], words: &[&str]) {
    assert_eq!(found.len(), 1, "{found:?}");
    words.iter().for_each(|word| assert!(found[0].contains(word), "{word:?} is missing: {}", found[0]));
}

const FIT: &str = "base = \"ink.toml\"\n[[measured]]\nfile = \"card.csv\"\nbacking = 0.8\n";

#[test]
fn slips_in_fits_are_said_with_their_field_and_a_remedy() {
    assert_eq!(faults(FIT, CARD, load_fit), Vec::<String>::new());
    let fit = |from: &str, to: &str| faults(&FIT.replace(from, to), CARD, load_fit);
    one_fault(&fit("backing = 0.8\n", ""), &["measured[0].backing", "nothing", "0.85 for a white card"]);
    one_fault(&fit("backing = 0.8", "backing = 1.8"), &["measured[0].backing", "1.8"]);
    one_fault(&fit("card.csv", "none.csv"), &["measured[0].file", "none.csv"]);
    one_fault(&fit("backing", "volume_fraction = 1.2\nbacking"), &["measured[0].volume_fraction", "1.2"]);
    one_fault(&faults("base = \"ink.toml\"\n", CARD, load_fit), &["measured", "none", "white and on black"]);
}

const DENSITY: &str = "[[number]]\nname = \"density\"\nweights = \"D65/2\"\nfrom_nm = 500\nto_nm = 600\nof = \"lit_at_45\"\ntransform = \"density\"\n\
                       [[number]]\nname = \"haze\"\nweights = \"D65/2\"\nfrom_nm = 500\nto_nm = 600\nof = \"scattered_transmittance\"\n\
                       over = \"transmittance\"\n";

/// Weighted numbers of a sample: those of the base, in a geometry that reads them, beside one spectrum at least.
#[test]
fn slips_in_measured_numbers_are_said() {
    let base = INK.replace("[500, 600]", "[500, 550, 600]") + DENSITY;
    let sample = |text: &str| {
        faults_with(&base, &format!("{FIT}[[measured]]\nbacking = 0.04\n{text}"), CARD, load_fit)
    };
    let number = |name: &str, value: &str, error: &str| {
        format!("[[measured.number]]\nname = \"{name}\"\nvalue = {value}\nerror = {error}\n")
    };
    let density = number("density", "1.3", "0.01");
    assert_eq!(sample(&density), Vec::<String>::new());
    one_fault(
        &sample(&number("denstiy", "1.3", "0.01")),
        &["measured[1].number[0].name", "denstiy", "\"density\", \"haze\""],
    );
    one_fault(
        &sample(&number("density", "1.3", "0.0")),
        &["measured[1].number[0].error", "0", "0.01 is usual"],
    );
    one_fault(
        &sample(&number("density", "nan", "0.01")),
        &["measured[1].number[0].value", "a finite number"],
    );
    one_fault(
        &sample(&number("haze", "0.3", "0.01")),
        &["measured[1].number[0].name", "over transmittance", "lit_at_45"],
    );
    one_fault(&sample(&(density.clone() + &density)), &["measured[1].number[1].name", "twice"]);
    one_fault(
        &sample(&format!("geometry = \"d:8\"\n{density}")),
        &["measured[1].number[0].name", "d:8", "45:0"],
    );
    one_fault(&sample(""), &["measured[1].file", "nothing", "[[measured.number]]"]);
    one_fault(
        &faults(&format!("{FIT}{density}"), CARD, load_fit),
        &["measured[0].number[0].name", "which has none"],
    );
    let alone = format!("base = \"ink.toml\"\n[[measured]]\nbacking = 0.04\n{density}");
    one_fault(
        &faults_with(&base, &alone, CARD, load_fit),
        &["measured", "numbers only", "determine no index"],
    );
    let predicted = format!("{FIT}[[predict]]\nbacking = 0.8\n{}", density.replace("measured.", "predict."));
    one_fault(
        &faults_with(&base, &predicted, CARD, load_fit),
        &["predict[0].number", "none under [[predict]]"],
    );
}

#[test]
fn a_spectrum_listed_twice_is_no_independent_data() {
    let again = &FIT[FIT.find("[[").expect("a table")..];
    let twice = faults(&format!("{FIT}{again}"), CARD, load_fit);
    one_fault(&twice, &["measured[1].file", "measured[0] again", "no independent data"]);
}

#[test]
fn slips_in_the_settings_of_a_fit_are_said() {
    let table = |text: &str| faults(&format!("{FIT}[fit]\n{text}\n"), CARD, load_fit);
    one_fault(&table("pigment = \"b\""), &["fit.pigment", "\"b\"", "a"]);
    one_fault(&table("noise = 0.0"), &["fit.noise", "0.003 is usual"]);
    one_fault(&table("n = [2.0, 1.4]"), &["fit.n", "from < to"]);
    one_fault(&table("kappa = [0.3, 0.1]"), &["fit.kappa", "[0.3, 0.1]", "from < to"]);
}

#[test]
fn slips_in_measured_spectra_are_said() {
    let card = |rows: &str| faults(FIT, &format!("wavelength_nm,reflectance\n{rows}"), load_fit);
    one_fault(&card(""), &["measured[0].file", "0 rows"]);
    assert_eq!(card("700,0.5\n400,0.6\n"), Vec::<String>::new(), "instruments write falling wavelengths");
    one_fault(&card("700,0.5\n400,0.6\n400,0.7\n"), &["measured[0].file", "two values at 400 nm"]);
    one_fault(&card("400,0.5\n700,1.3\n"), &["measured[0].file", "1.3", "measured[0].unit"]);
    one_fault(&card("400,50\n550,130\n700,60\n"), &["measured[0].file", "1.3 at 550 nm", "to 1.02"]);
    one_fault(&card("450,0.5\n550,0.6\n"), &["measured[0].file", "450 to 550 nm", "500 to 600 nm"]);
    one_fault(&card("400,0.5\n550,nan\n700,0.6\n"), &["measured[0].file", "550"]);
    one_fault(&faults(FIT, TWO_COLOURS, load_fit), &["measured[0].file"]);
    // percent is recognised
    assert_eq!(card("400,50\n700,60\n"), Vec::<String>::new());
}

#[test]
fn slips_in_the_light_of_a_fits_base_are_said() {
    for (waves, said) in [("[]", "wavelengths_nm"), ("[600, 500]", "wavelengths_nm")] {
        let ink = INK.replace("[500, 600]", waves);
        one_fault(&faults_with(&ink, FIT, CARD, load_fit), &["base.light", said]);
    }
}

#[test]
fn a_dissolved_pigment_is_not_fitted() {
    for ink in [
        INK.replace("[light]", &format!("{DYE}[light]")),
        INK.replace("diameter_nm = 200", "diameter_nm = 'molecular'"),
    ] {
        // alone, it leaves no pigment whose index could be sought
        if !ink.contains("dye") {
            let allowed = "a pigment with grains, of which the base has none";
            one_fault(&faults_with(&ink, FIT, CARD, load_fit), &["fit.pigment", allowed, "diameter_nm"]);
        }
        let name = if ink.contains("dye") { "dye" } else { "a" };
        let fit = format!("{FIT}[fit]\npigment = \"{name}\"\n");
        one_fault(&faults_with(&ink, &fit, CARD, load_fit), &["fit.pigment", name, "dissolved"]);
    }
}

/// Another name of one file, a link to it and a copy are the same values, whatever card is stated.
#[cfg(unix)]
#[test]
fn one_spectrum_under_two_names_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for (name, content) in
        [("ink.toml", INK), ("card.csv", CARD), ("copy.csv", CARD), ("other.csv", OTHER_CARD)]
    {
        std::fs::write(path(name), content).expect("written");
    }
    std::os::unix::fs::symlink(path("card.csv"), path("link.csv")).expect("a link");
    let read = |second: &str| {
        let fit = format!("{FIT}[[measured]]\nfile = \"{second}\"\nbacking = 0.04\n");
        std::fs::write(path("fit.toml"), fit).expect("written");
        load_fit(&path("fit.toml")).map(|task| task.measured.len()).map_err(|error| match error {
            StudyError::Values { faults, .. } => faults.iter().map(ToString::to_string).collect::<Vec<_>>(),
            other => vec![other.to_string()],
        })
    };
    assert_eq!(read("other.csv"), Ok(2));
    for second in ["./card.csv", "link.csv", "copy.csv", "../card.csv"] {
        let second = second.replace("..", &format!("../{}", folder.path().file_name().unwrap().display()));
        let faults = read(&second).expect_err(&second);
        one_fault(&faults, &["measured[1].file", "measured[0] again"]);
    }
}

/// The prior looks for absorption below the data and has a pole at 200 nm; one wavelength is enough for it.
#[test]
fn wavelengths_that_the_prior_cannot_describe_are_refused_before_any_solve() {
    let with = |waves: &str, prior: &str| {
        let ink = INK.replace("[500, 600]", waves).replace("{ built_in = \"yellow\" }", "1.7");
        let card = "wavelength_nm,reflectance\n100,0.5\n700,0.6\n";
        faults_with(&ink, &format!("{FIT}[fit]\nprior = \"{prior}\"\n"), card, load_fit)
    };
    one_fault(&with("[180, 300]", "kramers-kronig"), &["base.light", "180 nm", "210 nm or more", "smooth"]);
    one_fault(&with("[200, 300]", "kramers-kronig"), &["base.light", "200 nm"]);
    for (waves, prior) in [("[180, 300]", "smooth"), ("[210, 300]", "kramers-kronig"), ("[550]", "smooth")] {
        assert_eq!(with(waves, prior), Vec::<String>::new(), "{waves} {prior}");
    }
}

#[test]
fn dissolved_pigments_do_not_shift_the_one_fitted() {
    let ink = INK.replace("[[pigment]]", &format!("{DYE}[[pigment]]"));
    let folder = tempfile::tempdir().expect("a folder");
    let fit = format!("{FIT}volume_fraction = 0.15\n[fit]\npigment = \"a\"\n");
    for (name, content) in [("fit.toml", fit.as_str()), ("ink.toml", &ink), ("card.csv", CARD)] {
        std::fs::write(folder.path().join(name), content).expect("written");
    }
    let task = load_fit(&folder.path().join("fit.toml")).expect("sound");
    let fitted = &task.coats[0].pigments[task.pigment];
    assert_eq!((fitted.name.as_str(), fitted.grains.volume_fraction), ("a", 0.15));
}

#[test]
fn files_of_another_kind_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in [("ink.toml", INK), ("fit.toml", FIT), ("design.toml", DESIGN)] {
        std::fs::write(folder.path().join(name), content).expect("written");
    }
    for (command, file, says) in [
        ("fit", "ink.toml", "is a study, and this command reads a fit"),
        ("design", "ink.toml", "is a study, and this command reads a design"),
        ("fit", "design.toml", "is a design, and this command reads a fit"),
        ("run", "fit.toml", "is a fit, and this command reads a study"),
    ] {
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
        let done = program.arg(command).arg(folder.path().join(file)).output().expect("the program");
        let said = String::from_utf8_lossy(&done.stderr).replace('│', " ");
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(!done.status.success() && said.contains(says), "{command} {file}: {said}");
    }
}

/// Colours of two samples whose light is not stated.
const TWO_COLOURS: &str = "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_NAME LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\nBEGIN_DATA\n\
                           \"a\" 95 0 -2\n\"b\" 85 -10 80\nEND_DATA\n";
const DESIGN: &str = "base = \"ink.toml\"\n[target]\nlab = [80, 0, 50]\n[[vary]]\nfield = \"pigment[0].volume_fraction\"\nfrom = 0.1\nto = 0.3\n";

#[test]
fn slips_in_designs_are_said_with_their_field_and_a_remedy() {
    let read = inkwave::design::recipe::load;
    assert_eq!(faults(DESIGN, CARD, read), Vec::<String>::new());
    let design = |from: &str, to: &str| faults(&DESIGN.replace(from, to), CARD, read);
    one_fault(&design("lab = [80, 0, 50]\n", ""), &["target", "neither lab nor file", "lab = [85, -10, 80]"]);
    one_fault(&design("lab = [80, 0, 50]", "lab = [800, 0, 50]"), &["target", "800"]);
    one_fault(&design("from = 0.1", "from = 0.5"), &["vary[0].from", "0.5 to 0.3", "exchange"]);
    one_fault(&design("to = 0.3", "to = 1.3"), &["vary[0]", "1.3"]);
    one_fault(&design("volume_fraction", "colour"), &["colour"]);
    one_fault(&design("lab = [80, 0, 50]", "file = \"none.csv\""), &["target", "none.csv"]);
    let ratio = design("field = \"pigment[0].volume_fraction\"", "ratio = [\"a\", \"a\"]");
    one_fault(&ratio, &["vary[0].ratio", "twice", "two pigments"]);
    let again = "to = 0.3\n[[vary]]\nfield = \"pigment.a.volume_fraction\"\nfrom = 0.2\nto = 0.4";
    one_fault(&design("to = 0.3", again), &["vary[1].field", "beside \"pigment[0]", "every field once"]);
}

#[test]
fn slips_in_the_target_colour_of_a_design_are_said() {
    let read = inkwave::design::recipe::load;
    let colour = |patch: &str| {
        let target = format!("file = \"card.csv\"{patch}");
        faults(&DESIGN.replace("lab = [80, 0, 50]", &target), TWO_COLOURS, read)
    };
    one_fault(&colour("\npatch = \"b\""), &["target", "illuminant and observer are not stated"]);
    one_fault(&colour(""), &["target", "2 samples", "target.patch"]);
}

#[test]
fn slips_in_the_settings_of_a_design_are_said() {
    one_fault(&format_design("[design]\ndelta_e = 0.0\n"), &["design.delta_e", "0.5 is hard to see"]);
    one_fault(&format_design("[design]\nvariants = 2\n"), &["design.variants", "2"]);
    let none = format_design("[design]\nrealisations = 0\n");
    one_fault(&none, &["design.realisations: found 0", "1 to 100000", "that of the base"]);
}

fn format_design(more: &str) -> Vec<String> {
    faults(&format!("{DESIGN}{more}"), CARD, inkwave::design::recipe::load)
}

#[test]
fn recipes_are_studies_and_ratios_divide_the_sum() {
    let folder = tempfile::tempdir().expect("a folder");
    let second = INK.replace(
        "[light]",
        "[[pigment]]\nname = \"b\"\ndiameter_nm = 200\nvolume_fraction = 0.1\nindex = { built_in = \"blue\" }\n[light]",
    );
    let text = format!("{DESIGN}[[vary]]\nratio = [\"a\", \"b\"]\nfrom = 0.2\nto = 0.8\n");
    for (name, content) in [("inverse.toml", &text), ("ink.toml", &second)] {
        std::fs::write(folder.path().join(name), content).expect("written");
    }
    let task = inkwave::design::recipe::load(&folder.path().join("inverse.toml")).expect("sound");
    let study = task.study(&[1.0, 0.0]).expect("sound");
    let shares = [0, 1].map(|i| study.pigments[i].grains.volume_fraction);
    // 0.3 and 0.1 in the ratio 0.2 : 0.8
    assert!((shares[0] - 0.08).abs() < 1e-12 && (shares[1] - 0.32).abs() < 1e-12, "{shares:?}");
    assert_eq!(task.lab, Some([80.0, 0.0, 50.0]));
}
