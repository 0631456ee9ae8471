//! Packings of convex bodies: no overlap by dense points of their surfaces, sizes, walls, order and
//! agglomerates.

use super::packing_grains::agglomeration_of;
use inkwave::ink::Fractal;
use inkwave::ink::grains::contact::{contains, proven_gap_um};
use inkwave::ink::statistics::{orientation_tensor, profile, section_statistics};
use inkwave::ink::{
    Agglomeration, EquilibrationSettings, Grain, MethodChoice, Orientation, PackError, Packing,
    PackingRequest, PigmentGrains, Shape, Solid, pack,
};
use inkwave::input::check::check;
use inkwave::input::file::StudyFile;
use inkwave::numerics::vector::Rotation;
use inkwave::numerics::vector::{norm, sub};
use std::path::Path;

fn shapes() -> [Shape; 4] {
    let corners = vec![[0.0, 0.0], [2.0, 0.0], [2.5, 1.0], [1.0, 1.8]];
    [
        Shape::Ellipsoid { axes: [1.0, 1.5, 2.5] },
        Shape::Box { edges: [1.0, 1.5, 0.6] },
        Shape::Disc { diameter: 3.0, thickness: 1.0 },
        Shape::Prism { corners, length: 1.0 },
    ]
}

fn request(shape: Shape, share: f64, method: MethodChoice) -> PackingRequest {
    let pigments = vec![PigmentGrains::of(shape, 200.0, share)];
    PackingRequest { period_um: [1.1, 1.0], thickness_um: 0.8, pigments, method, ..Default::default() }
}

/// Points of one surface inside another body, over all nearest images: shares nothing with the search for contacts or
/// the proof of separation.
fn overlapping_pairs(packing: &Packing) -> usize {
    let [lx, ly] = packing.period_um();
    let solids: Vec<&Solid> = packing.grains().iter().filter_map(|g| g.solid.as_ref()).collect();
    let nearest = |d: f64, l: f64| d - l * (d / l).round();
    let meets = |a: &Solid, b: &Solid| {
        let [x, y, z] = a.center_um;
        let dx = nearest(b.center_um[0] - x, lx);
        let dy = nearest(b.center_um[1] - y, ly);
        let moved = Solid { center_um: [x + dx, y + dy, b.center_um[2]], ..b.clone() };
        a.triangles(16).into_iter().flatten().any(|p| contains(&moved, p)) && z.is_finite()
    };
    let pairs = (0..solids.len()).flat_map(|i| (0..solids.len()).map(move |j| (i, j)));
    pairs.filter(|&(i, j)| i != j && meets(solids[i], solids[j])).count()
}

#[test]
fn convex_bodies_pack_without_overlap_by_either_method() {
    for shape in shapes() {
        for (share, method) in [(0.1, MethodChoice::SequentialAddition), (0.35, MethodChoice::Relaxation)] {
            let request = request(shape.clone(), share, method);
            let packing = pack(&request, &mut ()).unwrap_or_else(|e| panic!("{}: {e}", shape.name()));
            // The nearest whole number of grains of 0.0042 µm³ in 0.88 µm³.
            assert!((packing.achieved_fraction(0) - share).abs() < 0.003, "{}", shape.name());
            assert_eq!(overlapping_pairs(&packing), 0, "{}", shape.name());
            let outside = |g: &Grain| g.extent_um(2)[0] < 0.0 || g.extent_um(2)[1] > 0.8;
            assert!(!packing.grains().iter().any(outside), "{}", shape.name());
        }
    }
}

#[test]
fn the_proof_rejects_bodies_that_meet_across_the_boundary() {
    let form = Shape::Box { edges: [0.2, 0.2, 0.2] }.form().expect("a convex body");
    let at = |x: f64| Grain::convex(Solid::upright(form.clone(), [x, 0.5, 0.5]), 0);
    let packed = |xs: [f64; 2]| Packing::from_grains([1.0, 1.0], 1.0, true, xs.map(at).to_vec());
    assert!(packed([0.1, 0.301]).is_ok(), "a gap of 1 nm");
    assert!(matches!(packed([0.1, 0.299]), Err(PackError::Overlap { .. })));
    assert!(matches!(packed([0.05, 0.9]), Err(PackError::Overlap { .. })));
    // Long bodies that are apart in the image with the nearest centre and meet in another one.
    let long = Shape::Box { edges: [0.95, 0.05, 0.05] }.form().expect("a convex body");
    let long_grain = |centre: [f64; 3], turn: f64| {
        let upright = Solid::upright(long.scaled(0.95 / long.longest_um()), centre);
        Grain::convex(Solid { rotation: Rotation::by([0.0, 0.0, turn]), ..upright }, 0)
    };
    let both =
        vec![long_grain([0.5, 0.5, 0.5], 0.0), long_grain([0.96, 0.25, 0.5], std::f64::consts::FRAC_PI_4)];
    let packing = Packing::from_grains([1.0, 1.0], 1.0, true, both.clone());
    assert!(matches!(packing, Err(PackError::Overlap { .. })), "{packing:?}");
    assert!(Packing::from_grains([1.5, 1.0], 1.0, true, both).is_ok());
}

/// Flakes of micrometres need cells and layers of their size, and the refusal says which.
#[test]
fn flakes_wider_than_the_cell_are_refused_with_the_size_needed() {
    let faults = |layer: &str, shape: &str| {
        let text = format!(
            "[layer]\n{layer}\n[[pigment]]\nvolume_fraction = 0.05\nsize = {{ kind = 'constant', value_nm = 5000, of = 'length' }}\n\
             {shape}\nindex = 1.6\n[light]\nwavelengths_nm = [500]\n"
        );
        let file: StudyFile = toml::from_str(&text).expect("a study");
        check(&file, Path::new("."), "flakes").err().unwrap_or_default()
    };
    let flake = "shape = { kind = 'disc', diameter = 20, thickness = 1 }";
    let fixed = |period: f64| format!("cell = 'fixed'\nperiod_um = {period}\nthickness_um = 2");
    let narrow = faults(&fixed(2.4), flake);
    // Twice the distance between its farthest corners, √(5² + 0.25²) µm, rounded up.
    assert!(narrow[0].remedy.ends_with("layer.period_um = 10.02 or more"), "{narrow:?}");
    assert!(faults(&fixed(10.01), flake)[0].remedy.contains("10.02"));
    assert_eq!(faults(&fixed(10.02), flake), []);
    let thin = faults("cell = 'fixed'\nperiod_um = 12\nthickness_um = 0.2", flake);
    assert!(thin[0].remedy.ends_with("layer.thickness_um = 0.25 or more"), "{thin:?}");
}

#[test]
fn statistics_see_the_bodies_themselves() {
    let request = request(Shape::Disc { diameter: 3.0, thickness: 1.0 }, 0.2, MethodChoice::Relaxation);
    let packing = pack(&request, &mut ()).expect("20 % of discs");
    let sections = section_statistics(&packing, 60, 0.004, 0.02, 0.1);
    // Sampling: 60 planes and 250 lines, some 10⁻² of a share with 40 grains.
    let fraction = sections.total_profile().iter().sum::<f64>() / sections.z_um.len() as f64;
    assert!((fraction - packing.achieved_fraction(0)).abs() < 0.01 * 0.2, "{fraction}");
    let mean = profile(&packing, 16).iter().map(|slice| slice[0]).sum::<f64>() / 16.0;
    assert!((mean - packing.achieved_fraction(0)).abs() < 1e-12);
}

#[test]
fn platelets_follow_the_field_that_aligns_their_axes() {
    let order = |orientation: Orientation| {
        let mut request = request(Shape::Disc { diameter: 3.0, thickness: 1.0 }, 0.2, MethodChoice::Auto);
        request.pigments[0].orientation = orientation;
        let packing = pack(&request, &mut ()).expect("20 % of discs");
        orientation_tensor(&packing, Some(0)).expect("discs have an axis").q[2][2]
    };
    let flat = order(Orientation::Perpendicular { strength: Some(10.0) });
    let upright = order(Orientation::InPlane { strength: Some(10.0) });
    // ⟨3 cos² − 1⟩/2 of κ = ± 10 is 0.83 and −0.42; contacts and 42 grains leave some 0.2 of it.
    assert!(flat > 0.5 && upright < -0.2, "{flat} {upright}");
}

/// A share of the grains in agglomerates of three, in a cell with room for them.
fn glued(shape: Shape, share: f64, method: MethodChoice, degree: f64) -> PackingRequest {
    let mut requested = PackingRequest { period_um: [1.5, 1.45], ..request(shape, share, method) };
    requested.pigments[0].agglomeration = Some(agglomeration_of(3, degree));
    requested
}

/// Members of the agglomerates, in the order of their bodies.
fn agglomerates(packing: &Packing) -> Vec<Vec<&Grain>> {
    let count = packing.grains().iter().filter_map(|g| g.agglomerate).max().map_or(0, |most| most + 1);
    let members = |k| packing.grains().iter().filter(|g| g.agglomerate == Some(k)).collect();
    (0..count).map(members).collect()
}

/// The solid of a grain and where that of another lies from it, in the nearest image.
fn neighbours(packing: &Packing, from: &Grain, to: &Grain) -> (Solid, Solid, [f64; 3]) {
    let a = from.solid.clone().expect("a convex body");
    let b = to.solid.clone().expect("a convex body");
    let cell = [packing.period_um()[0], packing.period_um()[1], f64::INFINITY];
    let nearest = |i: usize| {
        let d = b.center_um[i] - a.center_um[i];
        if cell[i].is_finite() { d - cell[i] * (d / cell[i]).round() } else { d }
    };
    let apart = std::array::from_fn(nearest);
    (a, b, apart)
}

/// The members of an agglomerate touch in one piece, none overlaps another, and each is the grain it was.
#[test]
fn glued_bodies_touch_and_keep_their_volume_and_share() {
    for shape in shapes() {
        for (share, method) in [(0.06, MethodChoice::SequentialAddition), (0.2, MethodChoice::Relaxation)] {
            let requested = glued(shape.clone(), share, method, 0.75);
            let packing = pack(&requested, &mut ()).unwrap_or_else(|e| panic!("{}: {e}", shape.name()));
            let volume = std::f64::consts::PI / 6.0 * 0.2f64.powi(3);
            // Identity: spheres of equal volume, 200 nm across.
            assert!(packing.grains().iter().all(|g| (g.volume_um3 / volume - 1.0).abs() < 1e-12));
            let placed = packing.grains().len() as f64 * volume / (1.5 * 1.45 * 0.8);
            assert!((packing.achieved_fraction(0) - placed).abs() < 1e-12 && (placed - share).abs() < 0.003);
            let stuck = (0.75 * packing.grains().len() as f64).round() as usize;
            let bodies = agglomerates(&packing);
            // A last grain that is alone is no agglomerate.
            assert_eq!(bodies.iter().map(Vec::len).sum::<usize>(), stuck - usize::from(stuck % 3 == 1));
            assert_eq!(overlapping_pairs(&packing), 0, "{}", shape.name());
            let outside = |g: &Grain| g.extent_um(2)[0] < 0.0 || g.extent_um(2)[1] > 0.8;
            assert!(!packing.grains().iter().any(outside), "{}", shape.name());
            bodies.iter().for_each(|members| assert_in_one_piece(&packing, members));
        }
    }
}

/// Every member but the first touches one before it.
fn assert_in_one_piece(packing: &Packing, members: &[&Grain]) {
    for (i, grain) in members.iter().enumerate().skip(1) {
        let gap = |other: &&Grain| {
            let (a, b, apart) = neighbours(packing, other, grain);
            proven_gap_um(&a, &b, apart) / a.form.thin_um()
        };
        let closest = members[..i].iter().map(gap).fold(f64::MAX, f64::min);
        // The gap of the glue is 1e-5 of the thinnest radius.
        assert!((0.0..2e-5).contains(&closest), "{closest}");
    }
}

/// Equilibration moves and turns the bodies of the same packing; what a member sees of another in its own frame stays.
/// *Planted*: members that keep their rotation, or their place, while the body turns.
#[test]
fn agglomerates_of_bodies_move_rigidly() {
    for shape in shapes() {
        let packed = |sweeps: Option<u64>| {
            let mut requested = glued(shape.clone(), 0.15, MethodChoice::Relaxation, 1.0);
            requested.equilibration = sweeps.map(|sweeps| EquilibrationSettings { sweeps });
            pack(&requested, &mut ()).unwrap_or_else(|e| panic!("{}: {e}", shape.name()))
        };
        let before = packed(None);
        let after = packed(Some(40));
        let mut turned = 0.0f64;
        for (old, new) in agglomerates(&before).iter().zip(agglomerates(&after)) {
            for (i, j) in [(0, 1), (1, 0), (0, old.len() - 1)] {
                // the place of one member in the frame of another, and two of its axes there
                let in_frame = |packing: &Packing, members: &[&Grain]| {
                    let (a, b, apart) = neighbours(packing, members[i], members[j]);
                    let back = a.rotation.inverse();
                    // Identity: the axis of a grain is the z axis of its body.
                    let off = sub(members[i].axis, a.rotation.turn([0.0, 0.0, 1.0]));
                    assert!(norm(off) < 1e-12, "{off:?}");
                    let axes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]].map(|v| back.turn(b.rotation.turn(v)));
                    (back.turn(apart), axes)
                };
                let (was, axes) = in_frame(&before, old);
                let (is, moved) = in_frame(&after, &new);
                // Identity: rounding of some thousand small rotations.
                assert!(norm(sub(was, is)) < 1e-10, "{}: {was:?} {is:?}", shape.name());
                assert!((0..2).all(|k| norm(sub(axes[k], moved[k])) < 1e-10), "{}", shape.name());
                turned = turned.max(norm(sub(old[i].axis, new[i].axis)));
            }
        }
        assert!(turned > 0.1, "{}: the bodies turn, {turned}", shape.name());
    }
}

#[test]
fn the_proof_judges_members_of_one_agglomerate_like_any_grains() {
    let form = Shape::Box { edges: [0.2, 0.2, 0.2] }.form().expect("a convex body");
    let at = |x: f64| {
        let grain = Grain::convex(Solid::upright(form.clone(), [x, 0.5, 0.5]), 0);
        Grain { agglomerate: Some(0), ..grain }
    };
    let packed = |xs: [f64; 2]| Packing::from_grains([1.0, 1.0], 1.0, true, xs.map(at).to_vec());
    let touching = packed([0.25, 0.45]).expect("faces that touch");
    assert!(touching.account().smallest_gap_um.expect("a gap") < 1e-14);
    assert!(matches!(packed([0.25, 0.4499]), Err(PackError::Overlap { .. })));
}

#[test]
fn fractal_agglomerates_of_convex_bodies_are_refused() {
    let mut requested = request(shapes()[1].clone(), 0.1, MethodChoice::Auto);
    let fractal = Some(Fractal { dimension: 1.78, prefactor: 1.3 });
    requested.pigments[0].agglomeration = Some(Agglomeration { fractal, ..agglomeration_of(3, 1.0) });
    let error = pack(&requested, &mut ()).unwrap_err().to_string();
    assert!(
        error.contains("pigment[0].agglomeration.fractal") && error.contains("beaded_ellipsoid"),
        "{error}"
    );
}
