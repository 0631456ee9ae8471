//! What is left of a stack without some of its layers.

use super::*;
use inkwave::input::study::Study;

fn loaded(folder: &Path, text: &str) -> Study {
    load(&study(folder, text)).expect("sound")
}

/// Of two layers each is what is left without the other, and solved once; joints stay open only where grains reached across all
/// that is left out; a rough face leaves with its layer. *Planted*: both layers twice; every joint kept.
#[test]
fn parts_of_stacks_are_stacks() {
    let scratch = tempfile::tempdir().unwrap();
    let open = INKS
        .replace("n = 1.45", "n = 1.5")
        .replace("binder.index = 1.45", "binder.index = 1.5")
        .replace("binder.index = 1.55", "binder.index = 1.5");
    let joints = open.replace("thickness_um = 0.3\n", "thickness_um = 0.3\njoint = \"open\"\n");
    let one_open = loaded(scratch.path(), &joints);
    let both_open = loaded(
        scratch.path(),
        &joints.replace("thickness_um = 0.5\n", "thickness_um = 0.5\njoint = \"open\"\n"),
    );
    let names = |study: &Study| study.substacks().into_iter().map(|part| part.name).collect::<Vec<_>>();
    assert_eq!(
        names(&one_open),
        ["without varnish", "without red", "without blue", "varnish alone", "red alone", "blue alone"]
    );
    let without_red = |study: &Study| study.substacks().swap_remove(study.place_without(1)).study;
    assert_eq!(without_red(&one_open).stack[0].joint, inkwave::ink::Joint::Wall);
    assert_eq!(without_red(&both_open).stack[0].joint, inkwave::ink::Joint::Open);
    for part in both_open.substacks() {
        let Study { stack, packing, pigments, layer, angles, .. } = &part.study;
        assert!(stack.last().is_none_or(|last| last.joint == inkwave::ink::Joint::Wall), "{}", part.name);
        assert_eq!((packing.layers.len(), packing.pigments.len()), (stack.len(), pigments.len()));
        assert_eq!(packing.thickness_um, layer.thickness_um);
        // one even layer is the same from both sides
        assert_eq!(angles.exit_strata == 0, stack.is_empty(), "{}", part.name);
    }
    let two = loaded(
        scratch.path(),
        &inks_without(&["varnish"]).replace("period_um = 0.8\n", "period_um = 0.8\nwithout_layers = true\n"),
    );
    assert_eq!(names(&two), ["without red", "without blue"]);
    assert_eq!((two.place_without(0), two.place_alone(0), two.place_alone(1)), (0, 1, 0));
    assert_eq!(two.substacks()[0].study.pigments[0].name, "blue grains");
    let rough = INKS.replace(
        "thickness_um = 0.4\n",
        "thickness_um = 0.4\nrelief = { depth_um = 0.1, face = \"exit\" }\n",
    );
    for part in loaded(scratch.path(), &rough).substacks() {
        let is_rough = part.study.packing.relief.is_some();
        let has_blue = part.study.pigments.iter().any(|pigment| pigment.name == "blue grains");
        assert_eq!(is_rough, has_blue, "{}", part.name);
        // a rough layer is another one from behind
        assert!(!is_rough || part.study.angles.exit_strata > 0, "{}", part.name);
    }
}
