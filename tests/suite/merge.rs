//! `inkwave merge`: what belongs together, and what does not.

use crate::sweep_support::{Place, TINY, inkwave, said, succeed};

/// A sweep whose pigment was measured, in two shards.
fn measured() -> Place {
    let place = Place::new(&TINY.replace("{ built_in = \"yellow\" }", "{ csv = \"ink.csv\" }"));
    let table = "wavelength_nm,n,k\n400,1.6,0.2\n550,1.6,0.05\n700,1.6,0.01\n";
    std::fs::write(place.path("ink.csv"), table).unwrap();
    for (shard, name) in [("1/2", "one"), ("2/2", "two")] {
        place.sweep(name, &["--shard", shard]);
    }
    place
}

#[test]
fn shards_whose_measured_inputs_differ_are_not_joined() {
    let place = measured();
    let one = place.path("one");
    let two = place.path("two");
    let out = place.path("out");
    let inputs = std::fs::read_dir(place.path("two/inputs")).unwrap().next().unwrap().unwrap();
    let table = inputs.path().join("ink.csv");
    let text = std::fs::read_to_string(&table).unwrap();
    // Only the table differs: the files of the variants and the outline are those of the other shard.
    std::fs::write(&table, text.replace("700,1.6,0.01", "700,1.6,0.02")).unwrap();
    let refused = inkwave(&["merge", &one, &two, "--output", &out]).output().unwrap();
    assert!(!refused.status.success(), "{}", said(&refused));
    assert!(!std::path::Path::new(&out).exists(), "a refused merge leaves nothing");
    std::fs::write(&table, text).unwrap();
    succeed(&["merge", &one, &two, "--output", &out]);
}
