//! Positions of spheres in the files of other programs.

use super::{Positions, read_positions};
use crate::input::file::{LengthUnit, MicrostructureTable, SizeColumn};

fn in_nm() -> MicrostructureTable {
    let (unit, size) = (Some(LengthUnit::Nm), Some(SizeColumn::Diameter));
    MicrostructureTable { unit, size, ..Default::default() }
}

fn read(text: &str, meaning: &MicrostructureTable) -> Result<Vec<Positions>, String> {
    let file = tempfile::NamedTempFile::new().expect("a file");
    std::fs::write(file.path(), text).expect("written");
    read_positions(file.path(), meaning)
}

/// Two spheres in three formats.
#[test]
fn three_formats_are_one() {
    let csv = "pigment,x_nm,y_um,z_um,diameter_nm\n1,100,0.2,0.3,80\n2,400,0.2,0.3,60\n";
    let atoms = "ITEM: ATOMS id type x y z radius\n1 1 100 200 300 80\n2 2 400 200 300 60\n";
    let dump = format!(
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp ff\n0 500\n0 600\n0 700\n{atoms}"
    );
    let xyz = "2\nLattice=\"500 0 0 0 600 0 0 0 700\" Properties=species:S:1:pos:R:3:radius:R:1\n\
               1 100 200 300 80\n2 400 200 300 60\n";
    let [csv, dump, xyz] = [(csv, Default::default()), (&dump, in_nm()), (xyz, in_nm())]
        .map(|(text, meaning)| read(text, &meaning).unwrap().remove(0));
    assert_eq!(dump, xyz);
    assert_eq!((&csv.spheres, &csv.pigments), (&dump.spheres, &dump.pigments));
    assert_eq!(csv.spheres[0].radius_um, 0.04);
    assert_eq!(dump.box_um.unwrap()[2].map(|x| (1e9 * x).round()), [0.0, 7e8]);
    assert_eq!(read(&xyz_twice(), &in_nm()).unwrap().len(), 2);
}

fn xyz_twice() -> String {
    "1\nProperties=species:S:1:pos:R:3:radius:R:1\n1 1 2 3 4\n".repeat(2)
}

/// One cell as programs write it. *Planted*: an origin or a corner that is ignored.
#[test]
fn variants_of_a_format_are_one() {
    let um = || MicrostructureTable {
        unit: Some(LengthUnit::Um),
        size: Some(SizeColumn::Radius),
        ..Default::default()
    };
    let expected = [[0.5, 1.5, 0.25, 0.125], [1.0, 0.5, 0.75, 0.25]];
    let dump = |head: &str, names: &str, rows: &str| {
        format!(
            "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS{head}\nITEM: ATOMS {names}\n{rows}"
        )
    };
    let upright = " pp pp ff\n0 2\n-1 3\n-1 1";
    let csv = [
        "# of a program\n\nx_um,y_um,z_um,radius_um\n0.5,1.5,0.25,0.125\n\n# half\n1,0.5,0.75,0.25\n"
            .to_owned(),
        "# x_um y_um z_um radius_um\n0.5 1.5 0.25 0.125\n1 0.5 0.75 0.25\n".to_owned(),
        "X (µm);Y [um];z/µm;Diameter (mm)\r\n0,5;1,5;0,25;0,00025\r\n1;0,5;0,75;0,0005\r\n".to_owned(),
        "x\ty\tz\tradius\n0.5\t1.5\t0.25\t0.125\n1\t0.5\t0.75\t0.25\n".to_owned(),
        "\"x_m\",\"y_um\",z_um,d_nm\n5e-7,1.5,0.25,250\n1e-6,0.5,0.75,500\n".to_owned(),
    ];
    let dumps = [
        dump(upright, "id type x y z radius", "1 1 0.5 1.5 0.25 0.125\n2 1 1 0.5 0.75 0.25\n"),
        dump(upright, "type xu yu zu radius", "1 0.5 1.5 0.25 0.125\n\n# two\n1 1 0.5 0.75 0.25\n"),
        dump(upright, "xs ys zs radius", "0.25 0.625 0.625 0.125\n0.5 0.375 0.875 0.25\n"),
        dump(upright, "radius xsu ysu zsu", "0.125 0.25 0.625 0.625\n0.25 0.5 0.375 0.875\n"),
        dump(
            " xy xz yz pp pp ff\n0 2 0\n-1 3 0\n-1 1 0",
            "x y z radius",
            "0.5 1.5 0.25 0.125\n1 0.5 0.75 0.25\n",
        ),
        "# first\n".to_owned() + &dump(upright, "x y z Radius", "0.5 1.5 0.25 0.125\n1 0.5 0.75 0.25\n"),
    ];
    let xyz = [
        "2\nLattice=\"2 0 0 0 4 0 0 0 2\" Origin=\"0 -1 -1\" Properties=pos:R:3:radius:R:1 pbc=\"T T F\"\n\
         0.5 1.5 0.25 0.125\n1 0.5 0.75 0.25\n",
        "\n2\nframe properties=species:S:1:pos:R:3:radius:R:1 origin=[0,-1,-1] lattice={2 0 0 0 4 0 0 0 2}\n\
         A 0.5 1.5 0.25 0.125\n# second\nA 1 0.5 0.75 0.25\n\n",
    ]
    .map(str::to_owned);
    for (text, has_box) in csv.iter().map(|t| (t, false)).chain(dumps.iter().chain(&xyz).map(|t| (t, true))) {
        let cut = read(text, &um()).unwrap_or_else(|e| panic!("{text}: {e}")).remove(0);
        let found = cut.spheres.iter().map(|s| [s.center_um[0], s.center_um[1], s.center_um[2], s.radius_um]);
        for (found, expected) in found.zip(expected) {
            // identity: rounding of units and of shares
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{text}: {found:?}");
        }
        assert_eq!(cut.box_um, has_box.then_some([[0.0, 2.0], [-1.0, 3.0], [-1.0, 1.0]]), "{text}");
        assert_eq!(cut.spheres.len(), 2, "{text}");
    }
}

/// *Planted*: a row that lacks a value would shift the pigments of all that follow.
#[test]
fn rows_without_a_value_are_refused_with_their_line() {
    let dump = |names: &str, rows: &str| {
        format!(
            "ITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp ff\n0 9\n0 9\n0 9\nITEM: ATOMS {names}\n{rows}"
        )
    };
    let bounds = |line: &str| {
        let other = format!("ITEM: BOX BOUNDS pp pp ff\n{line}\n");
        dump("x y z radius", "1 2 3 4\n1 2 3 4\n").replace("ITEM: BOX BOUNDS pp pp ff\n0 9\n", &other)
    };
    for (text, says) in [
        (dump("x y z radius type", "1 2 3 4 1\n1 2 3 4\n"), "line 9: 4 values where 5 columns"),
        (dump("x y z radius type", "1 2 3 4 1\n1 2 3 4 1 7\n"), "line 9: 6 values where 5 columns"),
        (dump("x y z radius", "1 2 3 4\nITEM: TIMESTEP\n"), "line 9: 2 values"),
        (dump("x y z radius", "1 2 3 4\n1 2 3 4\n1 2 3 4\n"), "line 10: \"1 2 3 4\" where an ITEM"),
        (bounds("0 9 1"), "line 4: an upright box"),
        (bounds("9 0"), "line 4: an upright box"),
        (bounds("0 a"), "line 4: an upright box"),
        ("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS xs ys zs radius\n0 0 0 1\n".to_owned(), "without a box"),
        ("ITEM: ATOMS x y z radius\n0 0 0 1\n".to_owned(), "no NUMBER OF ATOMS"),
        (xyz_twice().replace("1 1 2 3 4", "1 1 2 3"), "line 3: 4 values where 5 columns"),
        (xyz_twice() + "1 1 2 3 4\n", "line 7: \"1 1 2 3 4\" where the number"),
        ("1\nProperties=species:S:1000000000000:pos:R:3\n1 2\n".to_owned(), "at most 1000 columns"),
        ("1\nProperties=species:S:1:pos:R:3:radius\n1 2\n".to_owned(), "not \"radius\""),
        ("1\nLattice=\"2 0 0 0 2 0 0 0 1 a\" Properties=pos:R:3\n1 2\n".to_owned(), "no upright box"),
        ("1\nLattice=\"2 0 0 0 2 0 0 0 1\" Origin=\"1 2\" Properties=pos:R:3\n1\n".to_owned(), "Origin"),
        ("x_um,y_um,z_um,radius_um,pigment\n1,2,3,1,a\n1,2,3,1\n".to_owned(), "line 3: 4 values where 5"),
        ("x_um,y_um,z_um,radius_um\n1,2,3,1\n1,2,3,1,a\n".to_owned(), "line 3: 5 values where 4"),
        ("x,y,z,radius\n1,2,3,1\n".to_owned(), "no column radius_um"),
    ] {
        let meaning = if says.contains("radius_um") { Default::default() } else { in_nm() };
        let error = read(&text, &meaning).unwrap_err();
        assert!(error.contains(says) || error.contains("add unit"), "{text}: {error}");
    }
    // molecule 0 of a dump is none
    let apart = read(&dump("mol x y z radius", "0 1 2 3 1\n0 5 2 3 1\n"), &in_nm()).unwrap().remove(0);
    assert_ne!(apart.grains[0], apart.grains[1]);
}

#[test]
fn what_a_file_leaves_open_is_asked_for() {
    let xyz = xyz_twice();
    for (text, meaning, says) in [
        (xyz.as_str(), MicrostructureTable { unit: None, ..in_nm() }, "no unit"),
        (xyz.as_str(), MicrostructureTable { size: None, ..in_nm() }, "radii or diameters"),
        ("x,y,z,r\n1,2,3,4\n", Default::default(), "no column x_um or x_nm"),
        ("x_um,y_um,z_um\n1,2,3\n", in_nm(), "radius_um or diameter_um"),
        ("x_um,x_um,y_um,z_um,radius_um\n1,1,2,3,1\n", in_nm(), "2 columns for x"),
        ("x_um,x_nm,y_um,z_um,radius_um\n1,1,2,3,1\n", in_nm(), "2 columns for x"),
        ("x_um,y_um,z_um,radius_um,radius_nm\n1,2,3,1,1\n", in_nm(), "2 columns for radius"),
        ("x_um,y_um,z_um,radius_um\n1,2,a,1\n", in_nm(), "line 2: \"a\""),
        ("x_um,y_um,z_um,radius_um\n1,2,3,0\n", in_nm(), "line 2: a sphere of radius 0"),
        ("3\nProperties=species:S:1:pos:R:3:radius:R:1\n1 1 2 3 4\n", in_nm(), "ends before the last"),
    ] {
        let error = read(text, &meaning).unwrap_err();
        assert!(error.contains(says), "{error}");
    }
}
