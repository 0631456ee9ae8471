//! Every independent case, at the accuracy that was asked for. Finer levels are the vector claim's.

use inkwave_validation::vector::*;

/// Identity: the mean medium is exact per harmonic. 1e-11 leaves room for rounding in films of many wavelengths.
#[test]
fn films_are_exact_in_both_polarisations() {
    let films = references().iter().filter(|r| r.case.scene.uniform_in_plane());
    assert!(films.clone().count() >= 6);
    for film in films {
        for cells in [film.case.scene.strata.len().max(2) * 4, 37] {
            let error = film.error(&solve(&film.case, 1, cells, 1e-6).far);
            assert!(error < 1e-11, "{}: {error:.1e}", film.id);
        }
    }
}

/// Accuracy asked for: every amplitude in all four pairs of polarisations, and an estimate that is no smaller.
#[test]
fn ink_keeps_the_accuracy_asked_for() {
    for id in ["vink01", "vink02", "vsph01", "vsph02", "vsph03", "vsph04", "vlam01", "vcyl01"] {
        keeps(id, 1e-3);
    }
}

/// The same for the strong contrasts of pigments: 2.5 to 1e-3, 2.6 to 5e-3.
#[test]
fn pigments_keep_the_accuracy_asked_for() {
    keeps("vcyl02", 1e-3);
    keeps("vlam02", 1e-3);
    keeps("vsph05", 5e-3);
}

fn keeps(id: &str, accuracy: f64) {
    let reference = reference(id);
    let solved = solve_to(&reference.case, accuracy).unwrap_or_else(|e| panic!("{id}: {e}"));
    let error = reference.error(&solved.far_fields);
    assert!(error <= accuracy, "{id}: {error:.1e}");
    assert!(error <= solved.error_estimate, "{id}: {error:.1e} above {:.1e}", solved.error_estimate);
}

/// Measured with an independent prototype of the same scheme at 21 points and 40 planes per µm: 8.2e-5 and 1.4e-4; the
/// bound is their goal of 2e-4. Plain averaging errs by 9e-4 and 2.5e-3 there, so this fails if the tensor is dropped.
#[test]
fn packed_cells_reach_the_accuracy_of_the_tensor() {
    for id in ["vink01", "vink02"] {
        let error = reference(id).error(&solve(&reference(id).case, 25, 16, 1e-6).far);
        assert!(error < 2e-4, "{id}: {error:.1e}");
    }
}
