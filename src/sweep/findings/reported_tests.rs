use crate::evaluate::ink_maker::Target;
use crate::evaluate::manifest::Count;
use crate::sweep::definition::load::{AxisOutline, Place};
use crate::sweep::findings::reported::*;

/// A variant with three realisations at the given distance from its target.
fn variant(name: &str, value: f64, error: Option<f64>, deviations: [f64; 3]) -> Outcome {
    let estimate = Estimate { value, standard_error: error };
    let deviations = deviations.into_iter().enumerate().collect();
    let target = Target { lab: [70.0, -5.0, 40.0], delta_e_2000: estimate, deviations };
    Outcome {
        name: name.into(),
        labels: vec![name.into()],
        solves: Count { asked: 3, finished: 3 },
        failures: 0,
        reason: None,
        realisations: 3,
        certain: false,
        colour: None,
        lab_deviations: Default::default(),
        contrast: Some((Estimate { value: 0.8, standard_error: Some(0.01) }, Vec::new())),
        numbers: Vec::new(),
        aim: Some("L* 70, a* −5, b* 40 (D50, 2° observer)".into()),
        target: Some(target),
        print_hex: Some("#808080".into()),
        spectra: Vec::new(),
        picture: None,
        medium: Vec::new(),
        hiding_thickness_um: None,
    }
}

/// Variants along an axis of diameters, starting at 100 nm.
fn grid(count: usize) -> Outline {
    let labels = (0..count).map(|k| (100 * (k + 1)).to_string()).collect();
    let axis = AxisOutline { name: "diameter_nm".into(), labels, unit: "nm".into() };
    Outline {
        title: String::new(),
        axes: vec![axis],
        sheet: Default::default(),
        reference: 0,
        reference_asked: false,
        claims: Vec::new(),
        variants: (0..count).map(|k| Place { name: k.to_string(), place: vec![k] }).collect(),
    }
}

/// *Planted*: the nearest variant at the end of an axis would pass for the optimum.
#[test]
fn the_nearest_at_the_edge_of_the_grid_is_flagged() {
    let far = [3.0, 2.0, 1.0];
    let by = [0.1, 0.0, -0.1];
    let said = |order: [usize; 3]| {
        let outcomes = order.map(|k| variant("v", far[k], Some(0.1), by));
        nearest(&grid(3), &outcomes).unwrap().summary
    };
    let last = said([0, 1, 2]);
    assert!(
        last.ends_with("(diameter 300\u{a0}nm is the largest): there may be a nearer one beyond."),
        "{last}"
    );
    assert!(said([2, 1, 0]).contains("diameter 100\u{a0}nm is the smallest"));
    assert!(!said([0, 2, 1]).contains("edge"));
    assert_eq!(grid(1).axes[0].heading(), "diameter, nm");
    assert_eq!(grid(1).axes[0].named(0), "diameter 100\u{a0}nm");
    assert_eq!(grid(1).axes[0].caption(0), "100\u{a0}nm");
}

/// t for 2 degrees of freedom is 4.303. *Planted*: if errors were added as independent, "same
/// packings" would be tied, too.
#[test]
fn ties_with_the_nearest_rest_on_the_error_of_the_difference() {
    let by = [0.3, -0.1, -0.2];
    let error = Some(0.14_f64.sqrt());
    let outcomes = [
        variant("same packings", 2.0, error, by),
        variant("far", 9.0, error, [0.2, -0.3, 0.1]),
        variant("best", 1.0, error, by),
        variant("other packings", 2.5, error, [-0.3, 0.1, 0.2]),
        variant("one realisation", 3.0, None, [0.0; 3]),
    ];
    let nearest = nearest(&grid(5), &outcomes).unwrap();
    let told: Vec<[&str; 2]> =
        nearest.rows.iter().map(|r| [r.labels[0].as_str(), r.verdict.as_str()]).collect();
    assert_eq!(told[0], ["best", "nearest"]);
    // moved in the same direction: the difference of 1 is exact
    assert_eq!(told[1], ["same packings", "farther by 1.00"]);
    // moved in opposite directions: 4.303 · 2 · 0.374 = 3.2 exceeds 1.5
    assert_eq!(told[2], ["other packings", "cannot be distinguished from it"]);
    assert_eq!(told[3], ["one realisation", "unknown"]);
    assert!(told[4][0] == "far" && told[4][1].starts_with("farther by 8.0"), "{told:?}");
    assert_eq!(nearest.target, "L* 70, a* −5, b* 40 (D50, 2° observer)");
    let said = &nearest.summary;
    assert!(
        said.starts_with("best is nearest. One other cannot be distinguished") && said.contains("Of 1"),
        "{said}"
    );
    // ± 4.303 · 0.374
    assert_eq!(nearest.rows[0].delta_e, "1.0 ± 1.6");
}

#[test]
fn without_a_target_there_is_neither_a_table_nor_a_column() {
    let plain = Outcome { aim: None, target: None, ..variant("plain", 1.0, None, [0.0; 3]) };
    assert!(
        nearest(&grid(1), std::slice::from_ref(&plain)).is_none()
            && target_columns(std::slice::from_ref(&plain)).is_empty()
    );
    // a variant without results still has its columns
    let mut asked = variant("asked", 1.0, None, [0.0; 3]);
    asked.target = None;
    let both = [plain, asked];
    assert_eq!((target_columns(&both).len(), nearest(&grid(2), &both).unwrap().rows.len()), (2, 0));
    assert_eq!(target_numbers(&both[1]), [None, None]);
}
