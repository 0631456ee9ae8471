use super::*;

fn grid(from: f64, to: f64, step: f64) -> Vec<f64> {
    (0..=((to - from) / step).round() as usize).map(|k| from + step * k as f64).collect()
}

/// A triangle of weights from 400 to 600 nm: straight lines have their value at 500 nm, 1 has 1.
#[test]
fn means_of_lines_are_their_values_at_the_centroid() {
    let table = WeightTable::new(vec![[400.0, 0.0], [500.0, 2.0], [600.0, 0.0]]).unwrap();
    for nm in [grid(400.0, 600.0, 50.0), vec![400.0, 410.0, 590.0, 600.0], grid(300.0, 900.0, 100.0)] {
        let sum = WeightedSum::new(&nm, &table);
        let line: Vec<f64> = nm.iter().map(|nm| 1e-3 * nm).collect();
        assert!((sum.of(&vec![1.0; nm.len()]) - 1.0).abs() < 1e-14);
        assert!((sum.of(&line) - 0.5).abs() < 1e-14 && sum.outside() == 0.0, "{}", sum.of(&line));
    }
}

/// Parts of the sun's light add up to the whole, and a step at the joint of two parts is seen by
/// one of them alone. *Planted*: the share of a part taken of the whole table.
#[test]
fn parts_of_a_table_have_means_of_their_own() {
    let sun = NamedWeights::find("solar_g173").unwrap().tables.remove(0);
    let parts = [[280.0, 400.0], [400.0, 700.0], [700.0, 2500.0]].map(|range| sun.within(range).unwrap());
    let sum: f64 = parts.iter().map(WeightTable::total).sum();
    assert!((sum / sun.total() - 1.0).abs() < 1e-12);
    let nm = grid(280.0, 2500.0, 10.0);
    let below: Vec<f64> = nm.iter().map(|nm| f64::from(u8::from(*nm <= 400.0))).collect();
    let mean = |table: &WeightTable| WeightedSum::new(&nm, table).of(&below);
    assert!(mean(&parts[0]) > 0.999 && mean(&parts[2]).abs() < 1e-12);
}

/// What is beyond the grid counts by its ends, with an error; within it there is none.
#[test]
fn light_beyond_the_grid_is_that_of_its_ends_with_an_error() {
    let sun = NamedWeights::find("solar_g173").unwrap().tables.remove(0);
    let nm = grid(400.0, 2500.0, 20.0);
    let sum = WeightedSum::new(&nm, &sun);
    assert!((0.04..0.05).contains(&sum.outside()), "{}", sum.outside());
    let spectrum: Vec<f64> = nm.iter().map(|nm| 0.5 + 1e-4 * (nm - 400.0)).collect();
    let [below, above] = sum.beyond(&spectrum);
    assert!((1e-3..2e-2).contains(&below) && above == 0.0, "{below} {above}");
    // white that begins to absorb just below the grid. *Planted*: the slow drift of other ends
    let white = |nm: &f64| if *nm < 385.0 { 0.05 } else { 0.9 };
    let of = |nm: &[f64]| WeightedSum::new(nm, &sun).of(&nm.iter().map(white).collect::<Vec<f64>>());
    let missed = (of(&nm) - of(&grid(280.0, 2500.0, 2.0))).abs();
    let [below, _] = sum.beyond(&nm.iter().map(white).collect::<Vec<f64>>());
    assert!(missed < 2.0 * below && below < missed, "{missed} {below}");
    let whole = WeightedSum::new(&grid(280.0, 2500.0, 20.0), &sun);
    assert_eq!(whole.beyond(&[0.5; 112]), [0.0; 2]);
}

/// A white paint's reflectance by Kubelka and Munk's formula, with fringes of a film and the band
/// edge of rutile.
fn paint(nm: f64, exponent: f64, fringes: f64) -> f64 {
    let scattering = 8.0 * (550.0 / nm).powf(exponent);
    let absorbed = 1.0 / (1.0 + ((nm - 400.0) / 8.0).exp());
    let film = fringes * (std::f64::consts::TAU * 3000.0 / nm).cos();
    (scattering / (1.0 + scattering) * (1.0 - 0.92 * absorbed) + film).clamp(0.0, 1.0)
}

/// The error of a coarse grid covers its difference to one of 1 nm in most cases.
/// *Planted*: parts a fifth as large; absolute instead of relative distances.
#[test]
fn coarse_grids_know_what_they_leave_open() {
    let sun = NamedWeights::find("solar_g173").unwrap().tables.remove(0);
    let fine = grid(300.0, 2500.0, 1.0);
    let truth_of = WeightedSum::new(&fine, &sun);
    let mut squares = 0.0;
    let mut largest: f64 = 0.0;
    let mut count = 0.0;
    for step in [20.0, 50.0, 100.0] {
        for (k, exponent) in [0.5, 1.0, 2.0, 3.0].into_iter().enumerate() {
            for fringes in [0.0, 0.02, 0.05] {
                let nm = grid(300.0 + 3.0 * k as f64, 2400.0, step);
                let sum = WeightedSum::new(&nm, &sun);
                let of =
                    |nm: &[f64]| -> Vec<f64> { nm.iter().map(|nm| paint(*nm, exponent, fringes)).collect() };
                let values = of(&nm);
                let parts = sum.spacing(&values, None).into_iter().chain(sum.beyond(&values));
                let error = parts.fold(0.0, f64::hypot);
                let off = sum.of(&values) - truth_of.of(&of(&fine));
                squares += (off / error).powi(2);
                largest = largest.max((off / error).abs());
                count += 1.0;
                assert!(error < 0.05 || step > 50.0, "{step} nm: a bar of {error} tells nothing");
            }
        }
    }
    let rms = f64::sqrt(squares / count);
    assert!((0.05..1.2).contains(&rms) && largest < 3.0, "{rms} {largest}");
}

/// A film that has the fringes between the wavelengths tells of them. *Planted*: the guide's part
/// left out.
#[test]
fn a_guide_tells_of_what_is_between_the_wavelengths() {
    let table = WeightTable::new(vec![[500.0, 1.0], [600.0, 1.0]]).unwrap();
    let nm = grid(500.0, 600.0, 20.0);
    let fringe = |nm: &f64| 0.5 + 0.2 * (std::f64::consts::TAU * (nm - 500.0) / 20.0).cos();
    let of = |nm: &[f64]| -> Vec<f64> { nm.iter().map(fringe).collect() };
    let fine_nm = grid(500.0, 600.0, 1.0);
    let guide = Guide { on_grid: of(&nm), fine: of(&fine_nm), fine_nm };
    let sum = WeightedSum::new(&nm, &table);
    let error = |guide| sum.spacing(&of(&nm), guide).into_iter().fold(0.0, f64::hypot);
    assert!(error(Some(&guide)) > 0.15 && error(None) < 0.02, "{}", error(None));
}

/// −log₁₀ and 1/x of what is not above 0 are no numbers; a white's whiteness is 100, its tint 0.
#[test]
fn transforms_of_nothing_are_no_numbers() {
    assert_eq!(NumberTransform::Density.of_mean(0.01), 2.0);
    assert_eq!(NumberTransform::Reciprocal.of_mean(0.02), 50.0);
    for transform in [NumberTransform::Density, NumberTransform::Reciprocal] {
        assert!(
            transform.of_mean(1e-31).is_nan()
                && transform.of_mean(0.0).is_nan()
                && transform.of_mean(-1e-3).is_nan()
        );
    }
    let white = NamedWeights::find("D65/10").unwrap().white.unwrap();
    assert!((NumberTransform::Whiteness.of_xyz(white.xyz, &white) - 100.0).abs() < 1e-12);
    assert!(NumberTransform::Tint.of_xyz(white.xyz, &white).abs() < 1e-12);
}

#[test]
fn tables_that_are_none_are_refused() {
    let fault = |rows: &[[f64; 2]]| WeightTable::new(rows.to_vec()).unwrap_err().to_string();
    assert!(fault(&[[400.0, 1.0]]).contains("1 rows"));
    assert!(fault(&[[400.0, 1.0], [400.0, 1.0]]).contains("row 2: 400 nm after 400 nm"));
    assert!(fault(&[[400.0, 1.0], [500.0, -0.1]]).contains("row 2: a weight of -0.1 at 500 nm"));
    assert!(fault(&[[400.0, 0.0], [500.0, 0.0]]).contains("all weights are 0"));
}
