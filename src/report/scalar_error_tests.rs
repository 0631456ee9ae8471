use super::*;

/// The rows are the last measurement's, as it was published.
#[test]
fn the_rows_are_those_of_the_published_report() {
    let published = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("reports/scalar-against-vector/differences.csv");
    let Ok(text) = std::fs::read_to_string(published) else { return };
    assert!(
        text == DATA,
        "copy reports/scalar-against-vector/differences.csv to src/report/scalar_error.csv"
    );
}

#[test]
fn every_measured_ink_finds_itself() {
    let all = measured();
    assert_eq!(all.len(), DATA.lines().count() - 1, "every row is read");
    assert!(all.len() >= 18, "two inks, three shares, three sizes");
    for m in &all {
        assert_eq!(nearest_to(&m.place, &all).as_ref(), Some(m));
    }
}

/// Each respect alone decides: an ink a little off one measured row finds that row and no other.
#[test]
fn the_row_chosen_is_the_nearest_in_every_respect() {
    let all = measured();
    let near = |kappa, fraction, diameter_nm| {
        let place = TablePlace {
            largest_kappa: kappa,
            contrast: 0.16,
            volume_fraction: fraction,
            diameter_nm,
            thickness_um: 1.1,
        };
        nearest_to(&place, &all).map(|m| (m.ink, 100.0 * m.place.volume_fraction, m.place.diameter_nm))
    };
    let row = |ink: &str, share: f64, nm: f64| Some((ink.to_owned(), share, nm));
    assert_eq!(near(0.28, 0.17, 90.0), row("yellow", 15.0, 100.0));
    assert_eq!(near(0.28, 0.27, 260.0), row("yellow", 30.0, 300.0));
    assert_eq!(near(0.28, 0.45, 260.0), row("yellow", 50.0, 300.0));
    assert_eq!(near(0.35, 0.28, 30.0), row("red", 30.0, 0.0));
    assert_eq!(near(0.35, 0.28, 330.0), row("red", 30.0, 300.0));
}

/// Beyond what was measured nothing is said.
#[test]
fn an_ink_unlike_all_measured_ones_has_no_row() {
    let all = measured();
    let like = all[4].place;
    assert!(nearest_to(&like, &all).is_some());
    let unlike = [
        TablePlace { largest_kappa: 0.0, ..like },
        TablePlace { largest_kappa: 0.6, ..like },
        TablePlace { contrast: 1.0, ..like },
        TablePlace { volume_fraction: 0.02, ..like },
        TablePlace { diameter_nm: 600.0, ..like },
        TablePlace { thickness_um: 5.0, ..like },
    ];
    for place in unlike {
        assert_eq!(nearest_to(&place, &all), None, "{place:?}");
    }
}

#[test]
fn the_words_carry_the_numbers_of_their_row() {
    let all = measured();
    let yellow = &all[4];
    let words = yellow.in_words(true);
    let with_error = |value: f64, error: f64| format!("{value:+.3} ± {error:.3}");
    for part in [
        format!("yellow, κ up to {:.2}, 30 % of 100 nm, 1 µm", yellow.place.largest_kappa),
        format!("{:.1} ± {:.1}", yellow.delta_e_sky, yellow.delta_e_sky_standard_error),
        format!("{:.1} lit at 45°", yellow.delta_e_print),
        with_error(yellow.transmittance, yellow.transmittance_standard_error),
    ] {
        assert!(words.contains(&part), "{part}: {words}");
    }
    assert!(!yellow.in_words(false).contains("ΔE"));
}
