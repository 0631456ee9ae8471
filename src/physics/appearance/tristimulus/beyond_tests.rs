use crate::appearance::tristimulus::Colorimeter;
use crate::appearance::viewing::ColourError;
use crate::appearance::viewing::{Summation, Viewing};
use crate::numerics::Draws;

const STEP_NM: f64 = 5.0;

fn grid(from: f64, to: f64) -> Vec<f64> {
    (0..=((to - from) / STEP_NM) as usize).map(|i| from + STEP_NM * i as f64).collect()
}

/// Smooth spectra as prints have them, made without any of the formulas under test: a level, one to
/// three edges and up to three bands, squeezed between a dark and a bright level where they leave
/// 0.02–0.95.
pub fn printed(draws: &mut Draws, grid: &[f64]) -> Vec<f64> {
    let mut uniform = |from: f64, to: f64| draws.between(from, to);
    let mut values = vec![uniform(0.02, 0.9); grid.len()];
    for _ in 0..1 + uniform(0.0, 3.0) as usize {
        let height = uniform(-0.8, 0.8);
        let centre = uniform(380.0, 720.0);
        let width = uniform(6.0, 30.0);
        values.iter_mut().zip(grid).for_each(|(v, nm)| *v += height / (1.0 + (-(nm - centre) / width).exp()));
    }
    for _ in 0..uniform(0.0, 4.0) as usize {
        let height = uniform(-0.4, 0.4);
        let centre = uniform(380.0, 720.0);
        let width = uniform(15.0, 60.0);
        values
            .iter_mut()
            .zip(grid)
            .for_each(|(v, nm)| *v += height * (-0.5 * ((nm - centre) / width).powi(2)).exp());
    }
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    if low < 0.02 || high > 0.95 {
        let dark = uniform(0.02, 0.15);
        let bright = uniform(0.4, 0.92);
        values.iter_mut().for_each(|v| *v = dark + (bright - dark) * (*v - low) / (high - low).max(1e-3));
    }
    values
}

/// Of 200 spectra cut at 380–460 and 600–700 nm the 95 % intervals hold the Lab of the whole, or
/// there is no colour.
#[test]
fn cut_spectra_keep_their_colour() {
    let whole = grid(400.0, 700.0);
    let meter = Colorimeter::new(&whole).unwrap();
    let mut draws = Draws::new(25, 0);
    let spectra: Vec<Vec<f64>> = (0..200).map(|_| printed(&mut draws, &whole)).collect();
    let mut refused = 0;
    let mut published = 0;
    let froms = (0..=12).map(|k| 400.0 + 5.0 * f64::from(k));
    for [from, to] in froms.flat_map(|from| (0..=20).map(move |k| [from, 600.0 + 5.0 * f64::from(k)])) {
        let cut = match Colorimeter::new(&grid(from, to)) {
            Ok(cut) => cut,
            Err(ColourError::WhiteNotCovered { .. }) => {
                refused += 1;
                continue;
            }
            Err(other) => panic!("{other}"),
        };
        published += 1;
        let mut held = [0; 3];
        let start = ((from - 400.0) / STEP_NM) as usize;
        for spectrum in &spectra {
            let values = &spectrum[start..start + cut.wavelengths_nm().len()];
            let colour = cut.colour(values).unwrap();
            let truth = meter.colour(spectrum).unwrap().lab;
            let [a, b] = cut.beyond(values, colour.xyz);
            for i in 0..3 {
                held[i] += usize::from((colour.lab[i] - truth[i]).abs() <= 1.96 * a[i].hypot(b[i]) + 1e-9);
            }
        }
        // 95 % of 200, less two standard deviations of that count
        assert!(held.iter().all(|&n| n >= 184), "{from}–{to} nm: {held:?} of 200");
    }
    assert!(published > 100 && refused > 50, "{published} {refused}");
}

/// The rule for what lies outside is that of steps inside: a flat spectrum is what it is on the
/// whole range.
#[test]
fn the_ends_stand_for_what_lies_beyond_them() {
    let viewings = ["D65", "A", "F11"].map(|light| Viewing::new(light, "10", Summation::Plain).unwrap());
    for viewing in viewings {
        let whole = Colorimeter::under(&grid(400.0, 700.0), &viewing).unwrap();
        let cut = Colorimeter::under(&grid(420.0, 660.0), &viewing).unwrap();
        for c in 0..3 {
            // rounding of two sums of 300 terms
            assert!((whole.white_xyz[c] - cut.white_xyz[c]).abs() < 1e-9, "{}", viewing.name());
        }
        let values = vec![0.5; whole.wavelengths_nm().len()];
        assert_eq!(whole.beyond(&values, whole.xyz(&values).unwrap()), [[0.0; 3]; 2]);
        assert_eq!(whole.beyond_luminance(&values), 0.0);
    }
    let message = Colorimeter::new(&grid(460.0, 700.0)).unwrap_err().to_string();
    assert!(message.contains("from 460 to 700 nm") && message.contains("cover 400 to 700 nm"), "{message}");
    assert!(Colorimeter::new(&grid(440.0, 700.0)).is_ok() && Colorimeter::new(&grid(400.0, 600.0)).is_err());
}
