//! Contacts of grains: soft ones, cuts under several names, many spheres.

use super::{LIGHT, PIGMENTS, STATED, cell, given, scene, study};
use inkwave::ink::pack;
use inkwave::wave::Scene;

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
