//! Tests of [`super`].

use super::*;

/// The figures of the design note: effective diameter of a cylinder of length 6 R.
#[test]
fn cylinders_of_length_6_have_the_stated_effective_diameters() {
    for (spheres, expected) in [(3, 2.884), (5, 3.107), (9, 3.158)] {
        let template = Shape::Cylinder { length_in_radii: 6.0, spheres }.template();
        // Three decimals were printed.
        assert!((template.effective_diameter() - expected).abs() < 5e-4);
        assert!((template.length - 6.0).abs() < 1e-14);
    }
}

#[test]
fn inscribed_beads_approach_the_ellipsoid_from_inside() {
    let exact = 4.0 * PI / 3.0 * 2.0;
    let volume = |spheres| Shape::BeadedEllipsoid { aspect_ratio: 2.0, spheres }.template().volume.um3;
    let coarse = exact - volume(11);
    let fine = exact - volume(21);
    // Order: the gap between an envelope and its n members shrinks as 1/n²: a factor 4 from 10
    // to 20 gaps.
    assert!(fine > 0.0 && coarse / fine > 3.5 && coarse / fine < 4.5, "{coarse} {fine}");
    let tips = Shape::BeadedEllipsoid { aspect_ratio: 2.0, spheres: 9 }.template().length;
    assert!((tips - 4.0).abs() < 1e-14);
}

#[test]
fn a_cluster_is_centred_and_turned_to_its_long_axis() {
    let rows = vec![[5.0, 1.0, 1.0, 2.0], [11.0, 1.0, 1.0, 2.0], [8.0, 1.0, 1.0, 2.0]];
    let template = Shape::Cluster { spheres: rows }.template();
    // Identity: rounding of the power iteration.
    assert!((template.length - 5.0).abs() < 1e-12, "{}", template.length);
    assert!(template.spheres.iter().all(|s| s.center_um[0].hypot(s.center_um[1]) < 1e-12));
}

#[test]
fn shapes_read_as_names_and_tables_and_refuse_unknown_keys() {
    #[derive(serde::Deserialize)]
    struct Line {
        #[serde(deserialize_with = "crate::numerics::files::name_or_table")]
        shape: Shape,
    }
    let read = |text: &str| toml::from_str::<Line>(text).map(|l| l.shape);
    assert_eq!(read("shape = 'sphere'").unwrap(), Shape::Sphere);
    assert_eq!(read("shape = 'cylinder'").unwrap(), Shape::CYLINDER);
    let long = read("shape = { kind = 'cylinder', length_in_radii = 8 }").unwrap();
    assert_eq!(long, Shape::Cylinder { length_in_radii: 8.0, spheres: 5 });
    assert!(read("shape = { kind = 'cylinder', lenght = 8 }").is_err());
    assert!(read("shape = 'cube'").unwrap_err().to_string().contains("rice_grain"));
}
