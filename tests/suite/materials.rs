//! `inkwave materials` from outside.

/// A reader of the command sees every material with its range, one of them with its source.
#[test]
fn materials_are_listed_with_their_sources() {
    let inkwave = |args: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_inkwave")).args(args).output().unwrap()
    };
    let list = inkwave(&["materials"]);
    let text = String::from_utf8_lossy(&list.stdout).into_owned();
    assert!(list.status.success() && text.lines().count() >= 15, "{text}");
    let rutile = String::from_utf8_lossy(&inkwave(&["materials", "tio2 rutile"]).stdout).into_owned();
    for part in
        ["307–2599 nm", "Devore", "orientation average", "CC0", "sample: crystals", "seam: two records"]
    {
        assert!(rutile.contains(part), "{part}: {rutile}");
    }
    let magnetite = String::from_utf8_lossy(&inkwave(&["materials", "fe3o4"]).stdout).into_owned();
    for part in ["magnetite (Querry)", "formerly: Fe3O4", "masstone: L*", "not the black pigment"] {
        assert!(magnetite.contains(part), "{part}: {magnetite}");
    }
    assert!(!inkwave(&["materials", "chalk"]).status.success());
}
