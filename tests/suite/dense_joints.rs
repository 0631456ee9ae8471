//! Stacks whose layers are solved between half-spaces denser than their binders.

use super::run_support::{results, study, succeed};

/// Two thin inks as plates of a library between half-spaces of 2.6: cells of all sides have points for the orders that propagate
/// there. *Planted*: grids as they are chosen, which lack points for 4 of 2880 solves.
#[test]
fn orders_in_dense_joints_have_points() {
    let text = r#"
[stack]
period_um = 0.9
composed = { slab_um = 1.0, joint_index = 2.6, directions = [3, 6] }
[[layer]]
name = "cyan"
thickness_um = 0.45
binder.index = 1.6
[[layer.pigment]]
diameter_nm = 120
volume_fraction = 0.18
share = "scale_sizes"
index = { n = 1.75, k = 0.12 }
[[layer]]
name = "green"
thickness_um = 0.5
binder.index = 1.52
[[layer.pigment]]
diameter_nm = 160
volume_fraction = 0.15
share = "scale_sizes"
index = { n = 1.95, k = 0.03 }
[paper]
albedo = 0.8
[light]
wavelengths_nm = [460, 540, 620]
[run]
realisations = 8
seed = 5
[resolution]
accuracy = 1e-1
"#;
    let scratch = tempfile::tempdir().unwrap();
    succeed(&study(scratch.path(), text), &scratch.path().join("out"), &[]);
    assert_eq!(results(&scratch.path().join("out"))["spectra"].as_array().expect("rows").len(), 3);
}
