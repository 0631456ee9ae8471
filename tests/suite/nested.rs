//! Bodies inside others and layers around the cores of grains, against the same light described in another way.

use super::packing_output::read_packing_json;
use inkwave::ink::statistics::profile;
use inkwave::ink::{Grain, Packing, Sphere, pack};
use inkwave::input::Study;
use inkwave::input::case::Case;
use inkwave::input::check::check;
use inkwave::input::file::StudyFile;
use inkwave::report::packing::packing_json;
use inkwave::solve::accuracy::largest_difference;
use inkwave::wave::maxwell::NormalMoments;
use inkwave::wave::{Resolution, Scene, Scheme};
use inkwave_validation::{support, vector};
use std::path::Path;

/// Spheres as (x, radius, index), about heights and places of their own.
fn case(spheres: &[(f64, f64, f64)]) -> Case {
    let one = |(x, r, n): &(f64, f64, f64)| {
        format!(r#"{{ "center": [{x}, 0.2, 0.3], "radius": {r}, "eta": [{n}, 0.0] }}"#)
    };
    let spheres: Vec<String> = spheres.iter().map(one).collect();
    let text = format!(
        r#"{{ "wavelength": 0.55, "sigma_deg": 20, "phi_deg": 30, "L": 0.5, "H": 0.6, "eta_binder": [1.5, 0], "spheres": [{}] }}"#,
        spheres.join(", ")
    );
    Case::parse(&text, false).unwrap_or_else(|e| panic!("{e}"))
}

fn scalar_difference(a: &Case, b: &Case) -> f64 {
    let [a, b] = [a, b]
        .map(|case| support::solve_at(case, support::resolution(case, 16, 12, Scheme::Cubic), 1e-12).far);
    largest_difference(&a, &b)
}

fn vector_difference(a: &Case, b: &Case, [points, cells]: [usize; 2]) -> f64 {
    let a = vector::solve(a, points, cells, 1e-10).far;
    let b = vector::solve(b, points, cells, 1e-10).far;
    a.iter().zip(&b).map(|(a, b)| largest_difference(a, b)).fold(0.0, f64::max)
}

#[test]
fn a_shell_of_the_binders_index_is_not_there() {
    let coated = case(&[(0.2, 0.16, 1.5), (0.2, 0.1, 1.8)]);
    let bare = case(&[(0.2, 0.1, 1.8)]);
    // identity: the residuals
    assert!(scalar_difference(&coated, &bare) < 1e-10);
    assert!(vector_difference(&coated, &bare, [15, 12]) < 1e-8);
}

#[test]
fn a_core_of_the_shells_index_is_not_there() {
    let coated = case(&[(0.2, 0.16, 1.6), (0.2, 0.1, 1.6)]);
    let whole = case(&[(0.2, 0.16, 1.6)]);
    assert!(scalar_difference(&coated, &whole) < 1e-10);
    // The normal field differs inside, which both grids resolve: its error falls with the grid.
    let coarse = vector_difference(&coated, &whole, [15, 12]);
    let fine = vector_difference(&coated, &whole, [31, 40]);
    assert!(fine < 1e-5 && fine < 0.3 * coarse, "{coarse:e} {fine:e}");
}

/// Cores beside the centre, one of them a box, are not there either if they have the sphere's index; with another
/// one, they change the light.
#[test]
fn cores_anywhere_inside_displace_what_is_around_them() {
    let voids = |eta: f64| {
        let text = format!(
            r#"{{ "wavelength": 0.55, "sigma_deg": 20, "phi_deg": 30, "L": 0.5, "H": 0.6, "eta_binder": [1.5, 0],
                "spheres": [{{ "center": [0.2, 0.2, 0.3], "radius": 0.16, "eta": [1.6, 0] }},
                            {{ "center": [0.72, 0.2, 0.38], "radius": 0.05, "eta": [{eta}, 0] }}],
                "bodies": [{{ "shape": {{ "kind": "box", "edges": [0.08, 0.1, 0.09] }}, "center": [0.2, 0.2, 0.25],
                             "axis": [1, 1, 2], "eta": [{eta}, 0] }}] }}"#
        );
        Case::parse(&text, false).unwrap_or_else(|e| panic!("{e}"))
    };
    let whole = case(&[(0.2, 0.16, 1.6)]);
    assert_eq!(
        voids(1.0).scene.bodies.iter().map(|b| b.within).collect::<Vec<_>>(),
        [None, Some(0), Some(0)]
    );
    assert!(scalar_difference(&voids(1.6), &whole) < 1e-10);
    assert!(scalar_difference(&voids(1.0), &whole) > 1e-2);
    let coarse = vector_difference(&voids(1.6), &whole, [15, 12]);
    let fine = vector_difference(&voids(1.6), &whole, [31, 40]);
    assert!(fine < 1e-5 && fine < 0.3 * coarse, "{coarse:e} {fine:e}");
}

#[test]
fn the_vector_wave_refuses_layers_of_clusters() {
    let ball = |x: f64, r: f64| Sphere { center_um: [x, 0.3, 0.3], radius_um: r };
    let pair = Grain::new(vec![ball(0.2, 0.1), ball(0.3, 0.1)], 0);
    let packing = Packing::from_grains([0.8, 0.8], 0.6, true, vec![pair]).expect("room");
    let scene = Scene::from_packing(&packing.with_shells(vec![vec![0.02]]).expect("a core"));
    let grid = Resolution { nx: 15, ny: 15, cells: 12, scheme: Scheme::Quadratic };
    let refused = NormalMoments::new(&scene, grid).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(refused.contains("cluster of spheres") && refused.contains("scalar wave"), "{refused}");
}

fn study(pigment: &str) -> Study {
    let text = format!(
        "title = 't'\n[layer]\nthickness_um = 0.8\nperiod_um = 3.0\nbinder.index = 1.5\n[[pigment]]\nname = 'a'\n\
         share = 'scale_sizes'\n{pigment}\n[[pigment]]\nname = 'b'\nshare = 'scale_sizes'\ndiameter_nm = 150\n\
         volume_fraction = 0.05\nindex = 1.9\nshell = [{{ thickness_nm = 15, index = 1.3 }}]\n[light]\n\
         wavelengths_nm = [500]\n"
    );
    let file: StudyFile = toml::from_str(&text).expect("a study file");
    check(&file, Path::new("."), "test").unwrap_or_else(|e| panic!("{e:?}"))
}

const COATED: &str = "diameter_nm = 260\nvolume_fraction = 0.12\nindex = 1.0\n\
    shell = [{ thickness_nm = 30, index = 1.6 }, { thickness_nm = 20, index = 1.4 }]";

/// Indices, shares, names, the film's profile and the stored coordinates all know the layers, in one order.
#[test]
fn everything_that_knows_pigments_knows_their_layers() {
    let study = study(COATED);
    let indices: Vec<f64> = study.media(0.5).inclusions.iter().map(|eta| eta.re).collect();
    assert_eq!(indices, [1.0, 1.9, 1.6, 1.4, 1.3]);
    assert_eq!(study.material_names(), ["a", "b", "a shell 1", "a shell 2", "b shell"]);
    let shares = study.material_shares();
    let core = 0.12 * (160.0f64 / 260.0).powi(3);
    assert!((shares[0] - core).abs() < 1e-12 && (shares.iter().sum::<f64>() - 0.17).abs() < 1e-12);
    let packing = pack(&study.packing_request(0), &mut ()).expect("room");
    let slices = profile(&packing, 20);
    let mean = |m: usize| slices.iter().map(|slice| slice[m]).sum::<f64>() / 20.0;
    for (material, share) in shares.iter().enumerate() {
        // Sizes are scaled to the exact volume fraction, layers are not: a few per cent of a hundred grains.
        assert!((mean(material) / share - 1.0).abs() < 0.05, "{material}: {} {share}", mean(material));
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("packing.json");
    std::fs::write(&path, packing_json(&packing)).expect("written");
    let back = read_packing_json(&path);
    assert_eq!((back.shells_um(), back.grains()), (packing.shells_um(), packing.grains()));
}

/// Layers are solved in packed grains of several spheres, too; a thinner core changes what is reflected.
#[test]
fn unions_of_spheres_have_layers() {
    let rods = |nm: f64| {
        study(&format!(
            "shape = 'cylinder'\nsize = {{ kind = 'constant', value_nm = 60, of = 'radius' }}\nvolume_fraction = 0.1\n\
             index = 1.2\nshell = [{{ thickness_nm = {nm}, index = 1.8 }}]"
        ))
    };
    let shares = [10.0, 30.0].map(|nm| rods(nm).material_shares());
    for shares in &shares {
        assert!((shares[0] + shares[2] - 0.1).abs() < 1e-12, "{shares:?}");
    }
    assert!(shares[0][0] > 2.0 * shares[1][0], "{shares:?}");
    let packing = pack(&rods(30.0).packing_request(0), &mut ()).expect("room");
    let nested = packing.nested(packing.grains().iter().find(|g| g.pigment == 0).expect("a rod"));
    let radii: Vec<f64> = nested.iter().map(|body| body.spheres[0].radius_um).collect();
    assert!((radii[0] - radii[1] - 0.03).abs() < 1e-12, "{radii:?}");
}

/// Plates with layers are packed by their outer size; shares, profile and pictures know the layers.
#[test]
fn convex_bodies_have_layers() {
    let plates = study(
        "shape = { kind = 'disc', diameter = 4.0, thickness = 1.0 }\nsize = { kind = 'constant', value_nm = 320, of = \
         'length' }\nvolume_fraction = 0.1\nindex = 1.6\nshell = [{ thickness_nm = 20, index = 2.4 }]",
    );
    let shares = plates.material_shares();
    let core = (280.0f64 / 320.0).powi(2) * 40.0 / 80.0;
    assert!(
        (shares[0] - 0.1 * core).abs() < 1e-12 && (shares[2] - 0.1 * (1.0 - core)).abs() < 1e-12,
        "{shares:?}"
    );
    let packing = pack(&plates.packing_request(0), &mut ()).expect("room");
    let slices = profile(&packing, 20);
    for (material, share) in shares.iter().enumerate() {
        let mean = slices.iter().map(|slice| slice[material]).sum::<f64>() / 20.0;
        assert!((mean / share - 1.0).abs() < 0.05, "{material}: {mean} {share}");
    }
    let labels = inkwave::export::voxels::labels(&packing, None);
    let voxels =
        |material: u8| labels.iter().filter(|&&l| l == material + 1).count() as f64 / labels.len() as f64;
    assert!((voxels(0) / shares[0] - 1.0).abs() < 0.1, "{} {}", voxels(0), shares[0]);
}
