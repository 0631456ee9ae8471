//! Characterisation sets of prints, as makers of profiles read them.

use super::{BANDS, DOTS, Place, ink_of_thickness};
use std::path::Path;

/// A table of CGATS.17 as readers of other programs see it: keywords with their values, fields, sets.
struct Cgats {
    keywords: Vec<(String, String)>,
    fields: Vec<String>,
    sets: Vec<Vec<String>>,
}

/// Keywords of the standard.
const STANDARD: [&str; 20] = [
    "ORIGINATOR",
    "FILE_DESCRIPTOR",
    "DESCRIPTOR",
    "CREATED",
    "MANUFACTURER",
    "PROD_DATE",
    "SERIAL",
    "MATERIAL",
    "INSTRUMENTATION",
    "MEASUREMENT_SOURCE",
    "PRINT_CONDITIONS",
    "NUMBER_OF_FIELDS",
    "NUMBER_OF_SETS",
    "SAMPLE_BACKING",
    "WEIGHTING_FUNCTION",
    "COMPUTATIONAL_PARAMETER",
    "TARGET_TYPE",
    "COLORANT",
    "TABLE_DESCRIPTOR",
    "TABLE_NAME",
];
/// Fields that the sets may have besides bands and values of other inks.
const FIELDS: [&str; 12] = [
    "SAMPLE_ID",
    "SAMPLE_NAME",
    "CMYK_C",
    "CMYK_M",
    "CMYK_Y",
    "CMYK_K",
    "XYZ_X",
    "XYZ_Y",
    "XYZ_Z",
    "LAB_L",
    "LAB_A",
    "LAB_B",
];

/// Reads a file by the rules of CGATS.17 (ANSI CGATS.17-2009) as makers of profiles take them: ASCII, an identifier, keywords
/// of the standard or declared by KEYWORD before their use, once each, counts that are so, each sample named once.
fn strict_cgats(text: &str) -> Cgats {
    assert!(text.is_ascii(), "{text}");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("CGATS.17"));
    let words = |line: &str| -> Vec<String> {
        let parts = line.split('"').enumerate();
        let word = |(k, part): (usize, &str)| match k % 2 {
            1 => vec![part.to_owned()],
            _ => part.split_whitespace().map(str::to_owned).collect(),
        };
        assert_eq!(line.matches('"').count() % 2, 0, "{line}");
        parts.flat_map(word).collect()
    };
    let mut declared: Vec<String> = STANDARD.map(str::to_owned).into();
    let mut table = Cgats { keywords: Vec::new(), fields: Vec::new(), sets: Vec::new() };
    while let Some(line) = lines.next() {
        let line = words(line);
        match line.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
            [] => (),
            ["KEYWORD", name] => {
                assert!(!declared.contains(&(*name).to_owned()), "{name} is declared twice");
                declared.push((*name).to_owned());
            }
            ["BEGIN_DATA_FORMAT"] => {
                let format = lines.by_ref().take_while(|line| *line != "END_DATA_FORMAT");
                table.fields = format.flat_map(words).collect();
            }
            ["BEGIN_DATA"] => {
                table.sets = lines.by_ref().take_while(|line| *line != "END_DATA").map(words).collect();
            }
            [keyword, value] => {
                assert!(declared.contains(&(*keyword).to_owned()), "{keyword} is not declared");
                table.keywords.push(((*keyword).to_owned(), (*value).to_owned()));
            }
            other => panic!("no line of CGATS.17: {other:?}"),
        }
    }
    let count = |keyword: &str| table.value(keyword).parse::<usize>().expect("a count");
    assert_eq!((count("NUMBER_OF_FIELDS"), count("NUMBER_OF_SETS")), (table.fields.len(), table.sets.len()));
    let known = |field: &String| {
        let wave =
            field.strip_prefix("SPECTRAL_NM").is_some_and(|nm| nm.len() == 3 && nm.parse::<u32>().is_ok());
        let other = field
            .split_once("CLR_")
            .is_some_and(|(n, k)| n.parse::<u32>().is_ok() && k.parse::<u32>().is_ok());
        wave || other || FIELDS.contains(&field.as_str())
    };
    assert!(table.fields.iter().all(known), "{:?}", table.fields);
    let mut ids: Vec<&String> = table.sets.iter().map(|set| &set[0]).collect();
    assert!(table.fields[0] == "SAMPLE_ID" && table.sets.iter().all(|set| set.len() == table.fields.len()));
    ids.dedup();
    assert_eq!(ids.len(), table.sets.len());
    table
}

impl Cgats {
    fn value(&self, keyword: &str) -> &str {
        let entry = self.keywords.iter().find(|(name, _)| name == keyword);
        &entry.unwrap_or_else(|| panic!("no {keyword}")).1
    }

    fn numbers(&self, field: &str) -> Vec<f64> {
        let place = self.fields.iter().position(|name| name == field);
        let place = place.unwrap_or_else(|| panic!("no {field} among {:?}", self.fields));
        self.sets.iter().map(|set| set[place].parse().expect("a number")).collect()
    }
}

/// Characterisation sets are files that strict readers take: device values in percent, Y of a perfect white 100, Lab of D50
/// and 2° whatever the study's light, one set for each condition of a brightened paper, no two colours of one device value.
/// *Planted*: Lab of the study's own light; all conditions in one file; ink names as they are.
#[test]
fn characterisation_sets_are_what_makers_of_profiles_read() {
    let place = Place::new();
    let exported = |name: &str, text: &str| {
        place.run(name, text);
        let output = place.output(name);
        let done = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"))
            .args(["export", output.to_str().unwrap(), "--to", "cgats"])
            .output()
            .expect("the program");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        output
    };
    let read = |folder: &Path, name: &str| {
        let found = walk(folder, name).unwrap_or_else(|| panic!("no {name} in {}", folder.display()));
        strict_cgats(&std::fs::read_to_string(found).unwrap())
    };
    exported("other", &ink_of_thickness(0.7));
    // the light of the study is A, and names hold what no such file may
    let inks = "[dots]\nruling_per_cm = 60\nspread_um = 40\npatches = 'grid'\n[[ink]]\nname = 'Cyan'\ncoverage = [0, 0.5, 1]\n\
                [[ink]]\nname = 'yellow'\ncoverage = [0, 1]\n[[area]]\ninks = ['Cyan']\nresults = 'other'\n[[area]]\n\
                inks = ['yellow']\nresults = 'other'\n[[area]]\ninks = ['yellow', 'Cyan']\n[colour]\nilluminant = 'A'\n";
    let title = "title = 'Zyan \"matt\" über Gelb, 5 µm'\n";
    let set = read(&exported("inks", &format!("{title}{}{inks}", ink_of_thickness(1.8))), "prints.cgats");
    assert_eq!(set.value("LAB_CONDITIONS").matches("D50").count(), 1);
    assert!(set.value("DESCRIPTOR").contains("Zyan 'matt' ?ber Gelb, 5 um"), "{}", set.value("DESCRIPTOR"));
    let inks = set.numbers("CMYK_C").into_iter().zip(set.numbers("CMYK_Y"));
    let bare = inks.filter(|inks| *inks == (0.0, 0.0)).count();
    assert_eq!((bare, set.sets.len()), (1, 6), "the paper once, and all combinations of its inks");
    assert!(set.numbers("CMYK_C").contains(&50.0) && set.numbers("CMYK_K").iter().all(|k| *k == 0.0));
    let [x, y, z] = ["XYZ_X", "XYZ_Y", "XYZ_Z"].map(|field| set.numbers(field));
    let lab = ["LAB_L", "LAB_A", "LAB_B"].map(|field| set.numbers(field));
    // D50 and 2° of ISO 13655, table A: white of 10 nm
    let white = [96.422, 100.0, 82.521];
    let f = |t: f64| if t > 216.0 / 24389.0 { t.cbrt() } else { (24389.0 / 27.0 * t + 16.0) / 116.0 };
    let waves: Vec<usize> = (400..=700).step_by(10).collect();
    assert_eq!(set.value("SPECTRAL_BANDS"), waves.len().to_string());
    assert_eq!((set.value("SPECTRAL_START_NM"), set.value("SPECTRAL_END_NM")), ("400.000000", "700.000000"));
    for k in 0..set.sets.len() {
        let [fx, fy, fz] = [f(x[k] / white[0]), f(y[k] / white[1]), f(z[k] / white[2])];
        let expected = [116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)];
        // light from 400 to 700 nm alone makes another white, by a few thousandths
        assert!((0..3).all(|i| (expected[i] - lab[i][k]).abs() < 0.5), "{expected:?} {:?}", set.sets[k]);
        let spectrum: Vec<f64> = waves.iter().map(|nm| set.numbers(&format!("SPECTRAL_NM{nm}"))[k]).collect();
        assert!(spectrum.iter().all(|percent| (0.0..=100.0).contains(percent)), "{spectrum:?}");
        let [low, high] =
            [spectrum.iter().copied().fold(1e9, f64::min), spectrum.iter().copied().fold(0.0, f64::max)];
        assert!(low <= y[k] && y[k] <= high, "Y is a mean of the spectrum: {low} {} {high}", y[k]);
    }
    // the darkest print is the overprint, the lightest the paper
    let lightest = (0..y.len()).max_by(|a, b| y[*a].total_cmp(&y[*b])).unwrap();
    assert_eq!((set.numbers("CMYK_C")[lightest], set.numbers("CMYK_Y")[lightest]), (0.0, 0.0));
    // a brightened paper has a set for each condition
    let bright = format!("fluorescence = {{ {BANDS}, yield = 0.6 }}\n");
    let text = ink_of_thickness(1.0).replace("albedo = 0.93\n", &format!("albedo = 0.93\n{bright}"));
    let text = text.replace("from_nm = 400", "from_nm = 300") + DOTS;
    let folder = exported("bright", &text);
    let blues = ["m0", "m1", "m2"].map(|condition| {
        let set = read(&folder, &format!("prints-{condition}.cgats"));
        let source = set.value("MEASUREMENT_SOURCE").to_owned();
        assert_eq!(source.to_lowercase(), format!("measurementcondition={condition}"));
        let mut device: Vec<String> = set.sets.iter().map(|set| set[2].clone()).collect();
        assert_eq!(device.len(), 4, "paper, two tints, solid");
        device.dedup();
        assert_eq!(device.len(), 4, "one colour for a device value");
        set.numbers("LAB_B")[0]
    });
    assert!(blues[1] < blues[0] && blues[0] < blues[2], "ultraviolet light makes paper blue: {blues:?}");
}

/// A file of this name below a folder.
fn walk(folder: &Path, name: &str) -> Option<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).ok()?.filter_map(Result::ok).map(|entry| entry.path());
    let found = |path: std::path::PathBuf| match path.is_dir() {
        true => walk(&path, name),
        false => path.file_name().is_some_and(|own| own == name).then_some(path),
    };
    entries.filter_map(found).next()
}
