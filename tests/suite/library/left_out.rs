//! What a library says of its plates, and of layers that are none.

use super::{PLATES, carried_out, inkwave};
use crate::run_support::{study, succeed};

/// A clear layer between inks is in no library, and the command, the page and the run say so and what to do; thicknesses are
/// written without the rounding of their quotients. *Planted*: the layer left out in silence; all digits of 2.1 / 3.
#[test]
fn layers_that_are_no_plates_are_told() {
    let scratch = tempfile::tempdir().unwrap();
    let folder = scratch.path();
    let varnish = "[[layer]]\nname = \"varnish & wax\"\nthickness_um = 0.3\nbinder.index = 1.5\n[[layer]]\nname = \"red\"";
    let text = PLATES.replacen("[[layer]]\nname = \"red\"", varnish, 1);
    let text = text.replace("[1, 2.3]\nslab_um = 0.5", "2.1\nslab_um = 0.7");
    let run = succeed(&study(folder, &text), &folder.join("out"), &[]);
    let words = "varnish & wax: no plate: a library holds layers with grains";
    assert!(run.contains(words), "{run}");
    let done = inkwave(&["library", "out", "--page", "page.html"], folder);
    let said = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(said.contains(words) && said.contains("run the whole stack (inkwave run)"), "{said}");
    assert!(said.contains("white: cut into slabs of 0.7 µm, means over 2 realisations"), "{said}");
    assert!(said.contains("red: solved whole, 0.5 µm"), "{said}");
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("varnish &amp; wax: no plate") && !page.contains("@LEFT_OUT@"));
    // a library without such layers says nothing
    succeed(&study(folder, PLATES), &folder.join("other"), &[]);
    carried_out(&["library", "other", "--page", "other.html"], folder);
    assert!(!std::fs::read_to_string(folder.join("other.html")).unwrap().contains("no plate:"));
}
