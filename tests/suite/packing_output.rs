//! Files of a packing run.

use inkwave::draw::{cut_picture, perspective_picture, shape_sheet, top_picture};
use inkwave::ink::pack;
use inkwave::ink::{Packing, Shape};
use inkwave::input::Study;
use inkwave::input::check::check_packing;
use inkwave::input::file::StudyFile;
use inkwave::report::packing::{grains_csv, spheres_vtp, write_report};

const STUDY: &str = r#"
run = { seed = 2, realisations = 2 }
[layer]
cell = "fixed"
period_um = [2.0, 1.5]
thickness_um = 0.8
relief = { depth_um = 0.1, rule = { kind = "following", follow = 0.5, smoothing_um = 0.05 } }
[[pigment]]
name = "yellow"
shape = "cylinder"
size = { kind = "constant", value_nm = 200.0 }
volume_fraction = 0.2
orientation = "in_plane"
[[pigment]]
name = "blue"
size = { kind = "list", values_nm = [120.0, 180.0], weights = [2.0, 1.0] }
volume_fraction = 0.1
agglomeration = { degree = 0.5, grains = 3 }
"#;

/// The study, or its faults in one line.
fn checked(text: &str) -> Result<Study, String> {
    let file: StudyFile = toml::from_str(text).map_err(|e| e.to_string())?;
    let told = |faults: Vec<_>| faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    check_packing(&file, std::path::Path::new("."), "test").map_err(told)
}

fn packed() -> (Vec<(String, Shape)>, Vec<Packing>) {
    let study = checked(STUDY).unwrap();
    let packings =
        (0..study.realisations).map(|k| pack(&study.packing_request(k), &mut ()).unwrap()).collect();
    (study.pigments.iter().map(|p| (p.name.clone(), p.grains.shape.clone())).collect(), packings)
}

/// The grains of a JSON file, checked again for overlaps.
pub fn read_packing_json(path: &std::path::Path) -> Packing {
    let file: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let period = file["period_um"].clone();
    let shells = file["shells_um"].clone();
    let grains = file["grains"].clone();
    let period = serde_json::from_value(period).unwrap();
    let grains = serde_json::from_value(grains).unwrap();
    let height = file["thickness_um"].as_f64().unwrap();
    let walls = file["walls"].as_bool().unwrap();
    let packing = Packing::from_grains(period, height, walls, grains).unwrap();
    packing.with_shells(serde_json::from_value(shells).unwrap()).unwrap()
}

#[test]
fn a_report_holds_every_file_and_the_json_reads_back_bit_for_bit() {
    let (pigments, packings) = packed();
    let folder = tempfile::tempdir().unwrap();
    let (statistics, page) = write_report(folder.path(), "test", &pigments, &packings).unwrap();
    let text = std::fs::read_to_string(page).unwrap();
    let mut pictures = 0;
    for name in text.split("src=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        let content = std::fs::read(folder.path().join(name)).unwrap();
        assert!(content.starts_with(b"\x89PNG") || content.starts_with(b"<svg"), "{name}");
        pictures += 1;
    }
    assert_eq!(pictures, 4 + statistics.curves.len());
    for (k, packing) in packings.iter().enumerate() {
        let back = read_packing_json(&folder.path().join(format!("packing_{k:03}.json")));
        assert_eq!(back.grains(), packing.grains());
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert!(left.iter().all(|n| n.to_string_lossy().contains('.') && !n.to_string_lossy().starts_with('.')));
    let names: Vec<&str> = statistics.scalars.iter().map(|s| s.0.as_str()).collect();
    for wanted in
        ["orientation tensor Q_zz of pigment 0", "share of the pigment above the binder", "smallest gap"]
    {
        assert!(names.contains(&wanted), "{wanted} in {names:?}");
    }
}

/// Every number on the page is rounded to its error, and pigments have their names.
#[test]
fn the_page_of_packings_is_for_people() {
    let (pigments, packings) = packed();
    let folder = tempfile::tempdir().unwrap();
    let (_, page) = write_report(folder.path(), "test", &pigments, &packings).unwrap();
    let text = std::fs::read_to_string(page).unwrap();
    let text = text.split("</style>").nth(1).unwrap();
    for wanted in [
        "requested fraction of yellow<td>0.2<td>",
        "grains of blue<td>",
        "φ(z) of blue",
        " ± ",
        "<p>2 realisations. ",
        "<tr><td>1<td>",
        "<tr><td>2<td>",
        "alt=\"The grains of realisation 1 seen from the incident side\"",
        "the pigment that sticks out of the binder&#x27;s free face<td>",
    ] {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
    assert!(
        !text.contains("(s)") && !text.contains("<tr><td>0<td>") && !text.contains("alt=\"top.png"),
        "{text}"
    );
    assert!(!text.contains("of pigment ") && !text.contains("e0"), "{text}");
    let numbers = text.split(|c: char| !c.is_ascii_digit() && c != '.').filter(|n| n.contains('.'));
    let long: Vec<&str> = numbers.filter(|n| n.trim_start_matches(['0', '.']).len() > 8).collect();
    assert!(long.is_empty(), "{long:?}");
    let plot = std::fs::read_to_string(folder.path().join("profile_pigment_1.svg")).unwrap();
    assert!(plot.contains("φ(z) of blue"), "{plot}");
}

#[test]
fn csv_and_vtk_have_one_entry_per_sphere() {
    let (_, packings) = packed();
    let spheres: usize = packings[0].grains().iter().map(|g| g.spheres.len()).sum();
    let csv = grains_csv(&packings[0]).unwrap();
    assert_eq!(csv.iter().filter(|b| **b == b'\n').count(), spheres + 1);
    let vtk = spheres_vtp(&packings[0]);
    assert!(vtk.contains(&format!("NumberOfPoints=\"{spheres}\"")));
    let points = vtk.split("Name=\"points\"").nth(1).unwrap().split("</DataArray>").next().unwrap();
    assert_eq!(points.lines().skip(1).count(), spheres);
}

/// Pictures show what they should: the share of coloured pixels is the share of the plane that is covered.
#[test]
fn the_cut_shows_the_sections_of_the_grains() {
    use inkwave::ink::{Grain, Sphere};
    let sphere = Sphere { center_um: [0.5, 0.5, 0.5], radius_um: 0.3 };
    let packing = Packing::from_grains([1.0, 1.0], 1.0, true, vec![Grain::new(vec![sphere], 1)]).unwrap();
    let decoded = |bytes: Vec<u8>| {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    };
    let pixels = decoded(cut_picture(&packing).unwrap());
    let is = |colour: [u8; 3]| pixels.chunks(3).filter(|p| **p == colour).count() as f64;
    let pigment = is([0, 114, 178]);
    let binder = is([228, 232, 236]);
    let share = pigment / (pigment + binder);
    // Order: the rim of a disc of some 800 pixels is mixed colour: 2 % of its area.
    assert!((share - 0.09 * std::f64::consts::PI).abs() < 0.02 * share, "{share}");
    for picture in [top_picture(&packing), perspective_picture(&packing), shape_sheet(&[])] {
        assert!(decoded(picture.unwrap()).len() > 1000);
    }
}

/// A cell as thick as wide is as wholly in its picture as a flat one; what stands out of a cell by
/// less than a grain does so, too.
#[test]
fn all_of_a_cell_is_in_its_picture() {
    for height_um in [0.5, 2.0, 4.0] {
        let sphere = inkwave::ink::Sphere { center_um: [1.0, 1.0, 0.25], radius_um: 0.2 };
        let grain = inkwave::ink::Grain::new(vec![sphere], 0);
        let packing = Packing::from_grains([2.0, 2.0], height_um, true, vec![grain]).unwrap();
        let bytes = perspective_picture(&packing).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let width = info.width as usize;
        let height = info.height as usize;
        let white = |x: usize, y: usize| pixels[3 * (y * width + x)..][..3] == [255; 3];
        // beneath the caption
        let top = 40;
        let sides = (top..height).all(|y| white(0, y) && white(width - 1, y));
        let ends = (0..width).all(|x| white(x, top) && white(x, height - 1));
        assert!(sides && ends, "{height_um} µm: the cell reaches the border of its picture");
        let drawn =
            (top..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|&(x, y)| !white(x, y));
        assert!(drawn.count() > 2000, "{height_um}");
    }
}

#[test]
fn slips_in_a_study_are_named() {
    let spoilt = |from: &str, to: &str| checked(&STUDY.replace(from, to)).unwrap_err();
    assert!(spoilt("volume_fraction = 0.2", "volume_fracton = 0.2").contains("volume_fracton"));
    assert!(spoilt("\"cylinder\"", "\"cilinder\"").contains("cilinder"));
    assert!(spoilt("realisations", "realizations").contains("realizations"));
    assert!(spoilt("depth_um = 0.1", "depth_um = 2.0").contains("relief.depth_um"));
    let bare = STUDY.split("[[pigment]]").next().unwrap();
    assert!(checked(bare).unwrap_err().contains("pigment"));
}
