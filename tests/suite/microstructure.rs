//! Grains in given places and fractal clusters: what a packing writes, a study reads back, and wrong files are refused with place and count.

use inkwave::export::grains::{dump, xyz};
use inkwave::ink::{Packing, pack};
use inkwave::input::Study;
use inkwave::input::check::check;
use inkwave::input::fault::Fault;
use inkwave::input::file::StudyFile;
use inkwave::report::packing::grains_csv;
use inkwave::wave::Scene;
use std::path::Path;

const PIGMENTS: &str = "[[pigment]]\nname = 'a'\nindex = 1.9\nshell = [{ thickness_nm = 15, index = 1.3 }]\n\
    [[pigment]]\nname = 'b'\nindex = 1.7\n";
const LIGHT: &str = "[light]\nwavelengths_nm = [500]\n";

fn study(folder: &Path, text: &str) -> Result<Study, String> {
    let file: StudyFile = toml::from_str(text).map_err(|e| e.to_string())?;
    let told = |faults: Vec<Fault>| {
        faults.iter().map(|fault| format!("{fault}; {}", fault.remedy)).collect::<Vec<String>>().join("; ")
    };
    check(&file, folder, "test").map_err(told)
}

/// A packing of coated spheres and rods, of two pigments.
fn packed(realisation: usize) -> Packing {
    let text = format!(
        "[layer]\nthickness_um = 0.8\nperiod_um = [1.0, 1.2]\ncell = 'fixed'\nbinder.index = 1.5\n{PIGMENTS}{LIGHT}"
    );
    let text = text
        .replace("name = 'a'", "name = 'a'\nvolume_fraction = 0.1\ndiameter_nm = 150")
        .replace("name = 'b'", "name = 'b'\nvolume_fraction = 0.1\ndiameter_nm = 180\nshape = 'cylinder'");
    pack(&study(Path::new("."), &text).expect("a study").packing_request(realisation), &mut ()).expect("room")
}

fn given(folder: &Path, microstructure: &str, period: &str) -> Result<Study, String> {
    let layer = format!(
        "[layer]\nthickness_um = 0.8\nbinder.index = 1.5\n{period}\nmicrostructure = {microstructure}\n"
    );
    study(folder, &format!("{layer}{PIGMENTS}{LIGHT}"))
}

#[test]
fn what_is_written_is_read_back() {
    let packing = packed(0);
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("written");
    write("g.csv", &grains_csv(&packing).expect("a table"));
    write("g.dump", dump(&packing).as_bytes());
    write("g.xyz", xyz(&packing).as_bytes());
    let stated = "unit = 'um', size = 'radius'";
    for (table, period) in [
        ("{ spheres = 'g.csv' }".to_owned(), "period_um = [1.0, 1.2]"),
        (format!("{{ spheres = 'g.dump', {stated} }}"), ""),
        (format!("{{ spheres = 'g.xyz', {stated} }}"), ""),
    ] {
        let study = given(folder.path(), &table, period).unwrap_or_else(|e| panic!("{table}: {e}"));
        let back = pack(&study.packing_request(0), &mut ()).expect("the given grains");
        assert_eq!(Scene::from_packing(&back), Scene::from_packing(&packing), "{table}");
        for k in [0, 1] {
            // identity: volumes of the same spheres, summed in another order
            assert!((back.achieved_fraction(k) - packing.achieved_fraction(k)).abs() < 1e-12, "{table}");
        }
        assert_eq!((study.realisations, study.layer.period_um), (1, [1.0, 1.2]));
    }
    write("h.csv", &grains_csv(&packed(1)).expect("a table"));
    let two = "{ spheres = ['g.csv', 'h.csv'] }";
    assert_eq!(given(folder.path(), two, "period_um = [1.0, 1.2]").expect("two cuts").realisations, 2);
}

/// A study of one pigment in a cell of 2 × 2 × 1 µm, whose spheres are in a file.
fn cell(folder: &Path, name: &str, text: &str, keys: &str) -> Result<Study, String> {
    std::fs::write(folder.join(name), text).expect("written");
    let period = if text.contains("BOX BOUNDS") || text.contains("Lattice") { "" } else { "period_um = 2" };
    let layer = format!(
        "[layer]\nthickness_um = 1\nbinder.index = 1.5\n{period}\nmicrostructure = {{ spheres = '{name}'{keys} }}\n"
    );
    study(folder, &format!("{layer}[[pigment]]\nname = 'a'\nindex = 1.7\n{LIGHT}"))
}

fn scene(study: &Study) -> Scene {
    Scene::from_packing(&pack(&study.packing_request(0), &mut ()).expect("the given grains"))
}

const STATED: &str = ", unit = 'um', size = 'radius'";

/// A box elsewhere holds the same cell. *Planted*: the corner of the box added instead of taken away.
#[test]
fn the_corner_of_a_box_is_the_corner_of_the_cell() {
    let folder = tempfile::tempdir().expect("a folder");
    let dump = |corner: [f64; 3], names: &str, rows: &str| {
        let side = |i: usize, length: f64| format!("{} {}\n", corner[i], corner[i] + length);
        let bounds = [side(0, 2.0), side(1, 2.0), side(2, 1.0)].concat();
        format!(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp ff\n{bounds}ITEM: ATOMS {names}\n{rows}"
        )
    };
    let xyz = |origin: &str, rows: &str| {
        format!("2\nLattice=\"2 0 0 0 2 0 0 0 1\"{origin} Properties=pos:R:3:radius:R:1\n{rows}")
    };
    let rows = "0.5 0.5 0.375 0.25\n1.5 1.25 0.625 0.25\n";
    let expected =
        scene(&cell(folder.path(), "0.dump", &dump([0.0; 3], "x y z radius", rows), STATED).expect("a cell"));
    for (name, text) in [
        ("1.dump", dump([-3.0, 4.0, -7.0], "x y z radius", "-2.5 4.5 -6.625 0.25\n-1.5 5.25 -6.375 0.25\n")),
        (
            "2.dump",
            dump([-3.0, 4.0, -7.0], "xs ys zs radius", "0.25 0.25 0.375 0.25\n0.75 0.625 0.625 0.25\n"),
        ),
        ("3.xyz", xyz("", rows)),
        ("4.xyz", xyz(" Origin=\"-3 4 -7\"", "-2.5 4.5 -6.625 0.25\n-1.5 5.25 -6.375 0.25\n")),
    ] {
        let study = cell(folder.path(), name, &text, STATED).unwrap_or_else(|e| panic!("{name}: {e}"));
        // binary fractions: no rounding
        assert_eq!(scene(&study), expected, "{name}");
    }
}

/// *Planted*: lengths in another unit gave the clear film, or a packing without end.
#[test]
fn lengths_on_another_scale_are_refused_with_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let csv = |unit: &str, rows: &str| format!("x_{unit},y_{unit},z_{unit},radius_{unit}\n{rows}");
    let dump = |scale: f64, high: f64| {
        let l = 2.0 * scale;
        let h = high * scale;
        let x = 0.5 * scale;
        let r = 0.2 * scale;
        format!(
            "ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp ff\n0 {l}\n0 {l}\n0 {h}\nITEM: ATOMS x y z radius\n{x} {x} {x} {r}\n"
        )
    };
    let xyz = |high: f64| {
        format!("1\nLattice=\"2 0 0 0 2 0 0 0 {high}\" Properties=pos:R:3:radius:R:1\n0.5 0.5 0.5 0.2\n")
    };
    for (name, text, says) in [
        (
            "mm.csv",
            csv("um", "5e-4,5e-4,4e-4,2e-4\n1.5e-3,1.5e-3,6e-4,2e-4\n"),
            "largest coordinate 1.700e-3 µm, in a layer of 1 µm",
        ),
        ("m.csv", csv("um", "5e-7,5e-7,4e-7,2e-7\n"), "largest coordinate 7.000e-7 µm"),
        ("nm.csv", csv("um", "500,500,400,200\n"), "largest coordinate along z 600 µm"),
        ("far.csv", csv("um", "5e300,0.5,0.4,0.2\n"), "largest coordinate 5.000e300"),
        ("radius.csv", csv("um", "0.5,0.5,0.4,2e-4\n"), "largest sphere 4.000e-4 µm across"),
        ("mm.dump", dump(1e-3, 1.0), "a box 0.001 µm high; is unit right?"),
        ("high.dump", dump(1.0, 1.2), "a box 1.2 µm high"),
        ("high.xyz", xyz(0.8), "a box 0.8 µm high"),
    ] {
        let error = cell(folder.path(), name, &text, STATED).expect_err(name);
        assert!(error.contains(says) && error.contains(name), "{name}: {error}");
    }
    for (name, text, keys) in [
        ("mm", csv("mm", "5e-4,5e-4,4e-4,2e-4\n"), ""),
        ("bare", "x,y,z,radius\n5e-7,5e-7,4e-7,2e-7\n".to_owned(), ", unit = 'm'"),
        ("dump", dump(1e3, 1.0), ", unit = 'nm', size = 'radius'"),
    ] {
        let study = cell(folder.path(), name, &text, keys).unwrap_or_else(|e| panic!("{name}: {e}"));
        // identity: 4π/3 · 0.2³ of 4 µm³
        assert!((study.pigments[0].grains.volume_fraction / 8.377_580_41e-3 - 1.0).abs() < 1e-8, "{name}");
    }
}

/// Contacts of soft spheres are taken, within a limit that the study can set; the spheres touch then, and the volume lost is
/// said. The expected radii are in closed form.
#[test]
fn soft_contacts_become_contacts() {
    let folder = tempfile::tempdir().expect("a folder");
    let csv = |rows: &str| format!("x_um,y_um,z_um,radius_um\n{rows}");
    // 0.4 apart less an overlap, of radii 0.25 and 0.15; across the period; the third sphere is alone
    let pair =
        |overlap: f64| csv(&format!("0.1,0.5,0.5,0.25\n{},0.5,0.5,0.15\n1,1.4,0.5,0.2\n", 1.7 + overlap));
    let study = cell(folder.path(), "soft.csv", &pair(1e-4), "").expect("a contact");
    let spheres = scene(&study).bodies;
    let radii: Vec<f64> = pack(&study.packing_request(0), &mut ())
        .expect("touching spheres")
        .grains()
        .iter()
        .map(|g| g.spheres[0].radius_um)
        .collect();
    assert_eq!(spheres.len(), 3);
    for (radius, expected) in radii.iter().zip([0.25 * 0.3999 / 0.4, 0.15 * 0.3999 / 0.4, 0.2]) {
        assert!((radius - expected).abs() < 1e-14, "{radii:?}");
    }
    let remark = study
        .remarks
        .iter()
        .find(|r| r.contains("1 contacts overlap by up to 1.00e-4 µm"))
        .expect("a remark");
    // 3 · 2.5e-4 of the two, which have 0.2500³ + 0.15³ of 0.25³ + 0.15³ + 0.2³
    assert!(remark.contains("takes 0.053 % of the pigment's volume"), "{remark}");
    let error = cell(folder.path(), "deep.csv", &pair(2e-3), "").expect_err("deeper than usual");
    assert!(error.contains("overlap_um = 2.1e-3") && error.contains("2.000e-3 µm (0.667 %"), "{error}");
    assert!(cell(folder.path(), "deep.csv", &pair(2e-3), ", overlap_um = 2.1e-3").is_ok());
    let error =
        cell(folder.path(), "soft.csv", &pair(1e-4), ", overlap_um = 1e-5").expect_err("the study's limit");
    assert!(error.contains("overlap_um = 0.00001") || error.contains("overlap_um = 1e-5"), "{error}");
    let error = cell(folder.path(), "far.csv", &pair(0.1), ", overlap_um = 1").expect_err("other spheres");
    assert!(error.contains("a tenth of the smaller diameter"), "{error}");
    // a wall does not give way
    let study =
        cell(folder.path(), "wall.csv", &csv("0.5,0.5,0.1999,0.2\n1.5,0.5,0.8,0.2\n"), "").expect("a wall");
    let packing = pack(&study.packing_request(0), &mut ()).expect("touching a face");
    assert!((packing.grains()[0].spheres[0].radius_um - 0.1999).abs() < 1e-14);
    assert_eq!(packing.grains()[1].spheres[0].radius_um, 0.2);
}

/// Equal cuts are one, whatever their files are called. *Planted*: three realisations of one file, without any scatter.
#[test]
fn one_cut_by_several_names_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "x_um,y_um,z_um,radius_um,pigment\n0.2,0.2,0.2,0.1,a\n0.6,0.6,0.2,0.1,b\n";
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("a.csv", text);
    write("copy.csv", &text.replace("0.2,0.2,0.2", "0.20,0.2,2e-1"));
    write("other.csv", &text.replace("0.2,0.2,0.2", "0.3,0.2,0.2"));
    #[cfg(unix)]
    std::os::unix::fs::symlink("a.csv", folder.path().join("link.csv")).expect("a link");
    let absolute = folder.path().join("a.csv").display().to_string();
    let frame = "1\nLattice=\"1 0 0 0 1.2 0 0 0 0.8\" Properties=pos:R:3:radius:R:1\n0.5 0.5 0.4 0.1\n";
    write("twice.xyz", &frame.repeat(2));
    let names = |list: &[&str]| {
        let list = list.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        let keys = format!("{{ spheres = [{list}]{STATED} }}");
        given(folder.path(), &keys, "period_um = [1.0, 1.2]")
    };
    for (list, says) in [
        (&["a.csv", "./a.csv"][..], "a.csv and ./a.csv, which are one file"),
        (&["other.csv", "a.csv", &absolute], "which are one file"),
        #[cfg(unix)]
        (&["link.csv", "a.csv"], "which are one file"),
        (&["a.csv", "copy.csv"], "a.csv and copy.csv with the same spheres"),
        (&["twice.xyz"], "twice.xyz with the same frame twice"),
    ] {
        let error = names(list).expect_err(says);
        assert!(error.contains(says), "{list:?}: {error}");
    }
    assert_eq!(names(&["a.csv", "other.csv"]).expect("two cuts").realisations, 2);
}

/// 120 000 spheres of which neighbours overlap, and half a million of which none do, are judged in a time nearly proportional to their number:
/// all pairs of the first took half an hour. *Planted*: overlaps counted over all pairs.
#[test]
fn many_spheres_are_judged_in_seconds() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = |across: usize, down: usize, pitch: f64| {
        let mut text = "x_um,y_um,z_um,radius_um\n".to_owned();
        for i in 0..across * across * down {
            let place = [i / down % across, i / down / across, i % down].map(|k| pitch * (k as f64 + 0.5));
            let [x, y, z] = place;
            text += &format!("{x:.4},{y:.4},{:.4},0.05\n", z + 0.01);
        }
        text
    };
    let layer = |name: &str, text: &str, side: f64, height: f64| {
        std::fs::write(folder.path().join(name), text).expect("written");
        let layer = format!(
            "[layer]\nthickness_um = {height}\nperiod_um = {side}\nbinder.index = 1.5\nmicrostructure.spheres = '{name}'\n"
        );
        study(folder.path(), &format!("{layer}[[pigment]]\nname = 'a'\nindex = 1.7\n{LIGHT}"))
    };
    let start = std::time::Instant::now();
    let error = layer("close.csv", &rows(110, 10, 0.09), 9.9, 1.0).expect_err("they overlap");
    // three neighbours each, but not beyond the two faces
    assert!(error.contains(&format!("{} pairs of grains", 110 * 110 * (2 * 10 + 9))), "{error}");
    layer("apart.csv", &rows(224, 10, 0.11), 24.64, 1.2).expect("they are apart");
    // promise: seconds, on a machine that has much else to do
    assert!(start.elapsed().as_secs() < 90, "{:?}", start.elapsed());
}

/// Rows in any order, as programs in parallel write them, and a pigment that has no name of its own.
#[test]
fn spheres_of_a_grain_need_no_neighbouring_rows() {
    let folder = tempfile::tempdir().expect("a folder");
    let one = "0.2,0.2,0.2,0.1,a,1\n";
    let two = "0.3,0.2,0.2,0.1,a,1\n";
    let other = "0.7,0.7,0.2,0.1,pigment 2,2\n";
    let scene = |rows: &[&str]| {
        let text = format!("x_um,y_um,z_um,radius_um,pigment,grain\n{}", rows.concat());
        std::fs::write(folder.path().join("cut.csv"), text).expect("written");
        let pigments = PIGMENTS.replace("name = 'b'\n", "");
        let layer = "[layer]\nthickness_um = 0.8\nbinder.index = 1.5\nperiod_um = 1\nmicrostructure.spheres = 'cut.csv'\n";
        let study = study(folder.path(), &format!("{layer}{pigments}{LIGHT}")).expect("sound");
        Scene::from_packing(&pack(&study.packing_request(0), &mut ()).expect("the given grains"))
    };
    assert_eq!(scene(&[one, other, two]), scene(&[one, two, other]));
}

#[test]
fn files_that_cannot_be_read_are_the_only_fault() {
    let folder = tempfile::tempdir().expect("a folder");
    let layer = "[layer]\nthickness_um = 0.8\ncell = 'fixed'\nbinder.index = 1.5\nmicrostructure.spheres = 'absent.csv'\n";
    let error =
        study(folder.path(), &format!("{layer}{PIGMENTS}{LIGHT}[run]\nrealisations = 3\n")).unwrap_err();
    assert!(error.contains("absent.csv") && error.matches("allowed:").count() == 1, "{error}");
}

#[test]
fn wrong_files_are_refused_with_place_and_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows = |rows: &str| format!("x_um,y_um,z_um,radius_um,pigment\n{rows}");
    let b = "0.5,0.5,0.5,0.05,b\n";
    for (name, text, says) in [
        ("empty", rows(""), "no spheres"),
        ("other", rows("0.1,0.1,0.2,0.05,c\n"), "pigment \"c\""),
        ("one", rows("0.1,0.1,0.2,0.05,a\n"), "pigment[1]"),
        (
            "mixed",
            rows("0.1,0.1,0.2,0.05,a,7\n0.1,0.1,0.25,0.05,b,7\n").replace("t\n", "t,grain\n"),
            "grain 7 of several",
        ),
        (
            "overlap",
            rows(&format!("0.1,0.1,0.2,0.05,a\n0.12,0.1,0.2,0.05,a\n0.98,0.1,0.2,0.08,b\n{b}")),
            "2 pairs",
        ),
        ("high", rows(&format!("0.1,0.1,0.9,0.05,a\n0.1,0.5,0.78,0.05,a\n{b}")), "2 spheres outside"),
        ("nm", rows("100,100,200,50,a\n500,500,500,50,b\n"), "in nm"),
        ("axes", rows("0.1,0.2,1.4,0.05,a\n0.6,0.9,0.3,0.05,b\n"), "another column"),
        ("bare", "x,y,z,r\n1,1,1,1\n".to_owned(), "x_um or x_nm"),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
        let error =
            given(folder.path(), &format!("{{ spheres = '{name}' }}"), "period_um = [1.0, 1.2]").unwrap_err();
        assert!(error.contains(says) && error.contains("microstructure") || name == "one", "{name}: {error}");
        assert!(error.contains(says), "{name}: {error}");
    }
    for (files, says) in [("['one', 'one']", "one twice"), ("[]", "no file")] {
        let error = given(folder.path(), &format!("{{ spheres = {files} }}"), "period_um = 1").unwrap_err();
        assert!(error.contains(says), "{error}");
    }
    let error = given(folder.path(), "{ spheres = 'one' }", "").unwrap_err();
    assert!(error.contains("layer.period_um") && error.contains("no box"), "{error}");
    let shared =
        format!("[layer]\nthickness_um = 0.8\nmicrostructure = {{ spheres = 'one' }}\n{PIGMENTS}{LIGHT}");
    let error = study(folder.path(), &shared.replace("index = 1.7", "index = 1.7\nvolume_fraction = 0.2"))
        .unwrap_err();
    assert!(error.contains("pigment[1].volume_fraction") && error.contains("grains are placed"), "{error}");
}

/// Clusters in a packing have the dimension asked for: least squares of ln N over the logarithm of the mean radius of gyration.
#[test]
fn fractal_agglomerates_have_their_dimension_in_a_packing() {
    let gyration = |grains: usize| {
        let text = format!(
            "[layer]\nthickness_um = 5\nperiod_um = 10\ncell = 'fixed'\nbinder.index = 1.5\n[[pigment]]\nname = 'black'\n\
             diameter_nm = 60\nvolume_fraction = {}\nindex = 1.7\nagglomeration = {{ degree = 1, grains = {grains}, \
             fractal = {{ dimension = 1.78 }} }}\n{LIGHT}",
            12.0 * grains as f64 * std::f64::consts::PI / 6.0 * 0.06f64.powi(3) / 500.0
        );
        let study = study(Path::new("."), &text).unwrap_or_else(|e| panic!("{e}"));
        let packing = pack(&study.packing_request(0), &mut ()).expect("room");
        let clusters = packing.grains().iter().filter_map(|g| g.agglomerate).max().expect("clusters") + 1;
        (0..clusters).map(|k| gyration_um(&packing, k).ln()).sum::<f64>() / clusters as f64
    };
    let points: Vec<[f64; 2]> = [16, 48, 144].map(|n| [gyration(n), (n as f64).ln()]).to_vec();
    let dimension = (points[2][1] - points[0][1]) / (points[2][0] - points[0][0]);
    // promise: contacts within 1 % of the law's distance, and the scatter of a dozen clusters of each number
    assert!((dimension / 1.78 - 1.0).abs() < 0.06, "{dimension}: {points:?}");
}

/// Radius of gyration of the centres of an agglomerate's grains.
fn gyration_um(packing: &Packing, agglomerate: usize) -> f64 {
    let own = packing.grains().iter().filter(|g| g.agglomerate == Some(agglomerate));
    let centres: Vec<[f64; 3]> = own.map(inkwave::ink::Grain::centre_um).collect();
    let near = |c: &[f64; 3]| {
        let period = packing.period_um();
        let d: [f64; 3] = std::array::from_fn(|i| c[i] - centres[0][i]);
        [d[0] - period[0] * (d[0] / period[0]).round(), d[1] - period[1] * (d[1] / period[1]).round(), d[2]]
    };
    let centres: Vec<[f64; 3]> = centres.iter().map(near).collect();
    let count = centres.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(|i| centres.iter().map(|c| c[i]).sum::<f64>() / count);
    let square = |c: &[f64; 3]| (0..3).map(|i| (c[i] - mean[i]).powi(2)).sum::<f64>();
    (centres.iter().map(square).sum::<f64>() / count).sqrt()
}

/// `solve --realisation` takes the azimuth of that realisation, which differs from cell to cell. *Planted*: that of the next one.
#[test]
fn a_realisation_is_lit_from_its_own_azimuth() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("study.toml");
    let text = "[layer]\nthickness_um = 0.4\nbinder.index = 1.5\n[[pigment]]\nname = 'a'\nindex = 1.7\nvolume_fraction = 0.1\n\
                diameter_nm = 250\n[light]\nwavelengths_nm = [600]\n[angles]\npolar_deg = [20]\n[run]\nrealisations = 3\n";
    std::fs::write(&path, text).expect("written");
    let study = inkwave::input::load::load(&path).expect("a study");
    let mut azimuths: Vec<f64> = Vec::new();
    for number in 1..=3 {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
        let number = number.to_string();
        let done = command
            .arg("solve")
            .arg(&path)
            .args(["--nxy", "12", "--nz", "6", "--realisation", &number])
            .output();
        let found: serde_json::Value =
            serde_json::from_slice(&done.expect("the program").stdout).expect("JSON");
        azimuths.push(found["azimuth_deg"].as_f64().expect("an azimuth"));
    }
    // identity: the same draw
    assert_eq!(azimuths, [0, 1, 2].map(|realisation| study.draw(realisation).azimuth_deg));
    assert!(azimuths[0] != azimuths[1] && azimuths[1] != azimuths[2], "{azimuths:?}");
}

/// `solve --realisation` of positions in a file against the case that holds the same spheres. *Planted*: the azimuth of another
/// realisation, or the index of another pigment.
#[test]
fn a_realisation_is_solved_as_the_case_of_its_grains() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
        folder.path().join(name)
    };
    write("cut.csv", "x_um,y_um,z_um,radius_um,pigment\n0.2,0.3,0.25,0.12,a\n0.6,0.5,0.4,0.1,b\n");
    let study = write(
        "study.toml",
        "title = 't'\n[layer]\nthickness_um = 0.6\nperiod_um = [0.8, 0.7]\nbinder.index = 1.5\n\
         microstructure = { spheres = 'cut.csv' }\n[[pigment]]\nname = 'a'\nindex = 1.9\n\
         [[pigment]]\nname = 'b'\nindex = { n = 1.7, k = 0.1 }\n[light]\nwavelengths_nm = [500, 600]\n",
    );
    let solve = |arguments: &[&str], path: &Path| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_inkwave"));
        let done = command.arg("solve").arg(path).args(["--nxy", "12", "--nz", "6"]).args(arguments).output();
        let done = done.expect("the program");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        serde_json::from_slice::<serde_json::Value>(&done.stdout).expect("JSON")
    };
    let of_study = solve(&["--realisation", "1", "--wavelength-nm", "550", "--polar-deg", "20"], &study);
    let azimuth = inkwave::input::load::load(&study).expect("a study").draw(0).azimuth_deg;
    let case = write(
        "case.json",
        &serde_json::json!({
            "wavelength": 0.55, "sigma_deg": 20, "phi_deg": azimuth, "L": [0.8, 0.7], "H": 0.6, "eta_binder": [1.5, 0.0],
            "spheres": [
                { "center": [0.2, 0.3, 0.25], "radius": 0.12, "eta": [1.9, 0.0] },
                { "center": [0.6, 0.5, 0.4], "radius": 0.1, "eta": [1.7, 0.1] },
            ],
        })
        .to_string(),
    );
    let of_case = solve(&[], &case);
    let keys =
        ["orders", "R_total", "T_total", "A_total", "wave", "wavelength_nm", "polar_deg", "azimuth_deg"];
    for key in keys {
        assert_eq!(of_study[key], of_case[key], "{key}");
    }
    // the study's wave, unless another is asked for
    let text = std::fs::read_to_string(&study).expect("the study") + "wave = 'unpolarised'\n";
    let vector = write("vector.toml", &text);
    let one = ["--realisation", "1", "--wavelength-nm", "550", "--polar-deg", "20"];
    let waves = [&[][..], &["--wave", "scalar"]].map(|more| solve(&[&one, more].concat(), &vector));
    assert_eq!([&waves[0]["wave"], &waves[1]["wave"]], ["vector", "scalar"]);
    assert_eq!(waves[1]["orders"], of_case["orders"]);
}
