//! Positions of other programs: written and read back, corners of boxes, scales of lengths.

use super::{STATED, cell, given, packed, scene};
use inkwave::export::grains::{dump, xyz};
use inkwave::ink::pack;
use inkwave::report::packing::grains_csv;
use inkwave::wave::Scene;

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
