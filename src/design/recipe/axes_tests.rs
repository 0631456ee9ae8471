use super::super::load;
use super::*;

/// Grains of which everything may vary; `LAYER` and `VARY` are filled in.
const DESIGN: &str = r#"
[target]
lab = [85, -10, 70]
VARY
[base.layer]
LAYER
binder.index = 1.5
[[base.pigment]]
name = "grains"
diameter_nm = 200
volume_fraction = 0.15
index = 2.0
[base.paper]
albedo = 0.9
[base.light]
wavelengths_nm = [430, 540, 660]
[base.run]
realisations = 2
"#;

fn task(layer: &str, varied: &[(&str, f64, f64)], more: &str) -> DesignTask {
    let vary = varied
        .iter()
        .map(|(field, from, to)| format!("[[vary]]\nfield = \"{field}\"\nfrom = {from}\nto = {to}\n"));
    let text = DESIGN.replace("LAYER", layer).replace("VARY", &vary.collect::<String>());
    loaded(&format!("{text}{more}"))
}

fn loaded(text: &str) -> DesignTask {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("design.toml");
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|error| panic!("{error}"))
}

const ALL: [(&str, f64, f64); 4] = [
    ("paper.albedo", 0.2, 0.9),
    ("pigment[0].volume_fraction", 0.1, 0.2),
    ("layer.thickness_um", 1.0, 2.0),
    ("pigment[0].index", 1.8, 2.0),
];

/// *Planted*: studies compared with their paper; of slabs, studies of layers instead.
#[test]
fn what_takes_no_solves_is_composed() {
    let whole = task("thickness_um = 1", &ALL, "");
    assert_eq!(whole.names(whole.composed()), ["paper.albedo"]);
    let slabs = task("thickness_um = 1\ncomposed = { slab_um = 0.5 }", &ALL, "");
    assert_eq!(slabs.names(slabs.composed()), ["paper.albedo", "layer.thickness_um"]);
    assert_eq!(slabs.names(slabs.interpolated()), ["pigment[0].volume_fraction", "pigment[0].index"]);
    // 4 for the square of two variables, 2 cubes: 8, and half of that and 3 more
    assert_eq!(slabs.variants(), 15);
    // the index behind the layer is no paper
    let contact = "[base.layer]\nindex_out = 1.4\n";
    let text =
        DESIGN.replace("[base.layer]\n", contact).replace("albedo = 0.9", "coupling = \"optical_contact\"");
    let vary = "[[vary]]\nfield = \"layer.index_out\"\nfrom = 1.4\nto = 1.5\n";
    let behind = loaded(&text.replace("LAYER", "thickness_um = 1").replace("VARY", vary));
    assert_eq!(behind.composed().count(), 0);
}

/// Every thickness has the slabs of the smallest one; the recipe is of its own thickness alone.
/// *Planted*: the thickness alone, whose slabs are its own.
#[test]
fn all_thicknesses_have_the_slabs_of_the_smallest() {
    let task =
        task("thickness_um = 1.4\ncomposed = { slab_um = 0.6 }", &[("layer.thickness_um", 1.4, 2.0)], "");
    for place in [0.0, 0.3, 1.0] {
        let study = task.study(&[place]).unwrap();
        let composed = study.composed().unwrap();
        assert!((composed.slab_um - 0.7).abs() < 1e-12, "{composed:?}");
        assert_eq!(composed.thicknesses_um, task.values(&[place]));
    }
    assert_eq!(task.variants(), 1);
}

/// Of a stack, clear layers and one in slabs. *Planted*: two thicknesses written as lists.
#[test]
fn layers_of_a_stack_are_composed_where_they_are_clear_or_in_slabs() {
    let stack = |vary: &str| {
        let layers = r#"
[base.stack]
composed = { slab_um = 0.5, directions = [2, 2] }
[[base.layer]]
name = "varnish"
thickness_um = 0.8
binder.index = 1.48
[[base.layer]]
name = "coat"
thickness_um = 1.0
binder.index = 1.5
[[base.layer.pigment]]
name = "grains"
diameter_nm = 200
volume_fraction = 0.1
index = 2.0
[[base.layer]]
name = "ink"
thickness_um = 0.6
binder.index = 1.5
[[base.layer.pigment]]
name = "red"
diameter_nm = 180
volume_fraction = 0.1
index = { built_in = "red" }
[base.paper]
albedo = 0.9
[base.light]
wavelengths_nm = [430, 540, 660]
[base.run]
realisations = 2
"#;
        loaded(&format!("[target]\nlab = [85, -10, 70]\n{vary}{layers}"))
    };
    let vary = |layer: usize, from: f64| {
        format!("[[vary]]\nfield = \"layer[{layer}].thickness_um\"\nfrom = {from}\nto = {}\n", from + 0.3)
    };
    let task = stack(&[vary(0, 0.5), vary(1, 1.0), vary(2, 0.5)].concat());
    assert_eq!(task.names(task.composed()), ["layer[0].thickness_um", "layer[1].thickness_um"]);
}

/// *Planted*: the number of variants told for all variables.
#[test]
fn variants_are_counted_for_what_is_interpolated() {
    let varied = [ALL[0], ALL[1]];
    let task = task("thickness_um = 1", &varied, "[design]\nvariants = 6\n");
    assert_eq!((task.variants(), task.remarks.len()), (6, 0));
    let one = self::task("thickness_um = 1", &varied[..1], "[design]\nvariants = 6\n");
    assert!(one.variants() == 1 && one.remarks[0].contains("one run is enough"), "{:?}", one.remarks);
}
