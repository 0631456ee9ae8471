use crate::appearance::tristimulus::beyond::tests::printed;
use crate::appearance::tristimulus::{Colorimeter, Guide};
use crate::appearance::viewing::{Summation, Viewing};
use crate::numerics::Draws;

const FINE_NM: f64 = 5.0;

/// 400–700 nm in steps of a multiple of 5 nm.
fn grid(step_nm: f64) -> Vec<f64> {
    (0..=(300.0 / step_nm) as usize).map(|i| 400.0 + step_nm * i as f64).collect()
}

/// The values of a spectrum known every 5 nm.
fn at(spectrum: &[f64], nm: &[f64]) -> Vec<f64> {
    nm.iter().map(|nm| spectrum[((nm - 400.0) / FINE_NM).round() as usize]).collect()
}

/// Standard errors of Lab.
fn errors(meter: &Colorimeter, values: &[f64], guide: Option<&Guide>) -> [f64; 3] {
    let shifts = meter.spacing(values, meter.xyz(values).unwrap(), guide);
    std::array::from_fn(|i| shifts.iter().fold(0.0, |sum: f64, by| sum.hypot(by[i])))
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Of 200 spectra known every 10 to 100 nm, the 95 % intervals hold the Lab of the same spectra
/// every 5 nm, and are not so wide that they say nothing.
#[test]
fn coarse_sums_keep_their_colour() {
    let fine = grid(FINE_NM);
    let mut draws = Draws::new(49, 0);
    let spectra: Vec<Vec<f64>> = (0..200).map(|_| printed(&mut draws, &fine)).collect();
    let plain = Viewing::default();
    let e308 = Viewing::new("D50", "2", Summation::E308).unwrap();
    for (viewing, step) in [&plain, &e308]
        .into_iter()
        .flat_map(|v| [10.0, 15.0, 20.0, 30.0, 50.0, 60.0, 75.0, 100.0, 150.0].map(|step| (v, step)))
    {
        let nm = grid(step);
        let exact = Colorimeter::under(&fine, viewing).unwrap();
        let meter = Colorimeter::under(&nm, viewing).unwrap();
        let mut held = [0; 3];
        let mut off = Vec::new();
        let mut said = Vec::new();
        for spectrum in &spectra {
            let values = at(spectrum, &nm);
            let truth = exact.colour(spectrum).unwrap().lab;
            let lab = meter.colour(&values).unwrap().lab;
            let error = errors(&meter, &values, None);
            let miss: [f64; 3] = std::array::from_fn(|i| lab[i] - truth[i]);
            // 0.02: sums every 10 nm and every 5 nm differ in how much of the ends they take
            (0..3).for_each(|i| held[i] += usize::from(miss[i].abs() <= 1.96 * error[i] + 0.02));
            off.push(length(miss));
            said.push(length(error));
        }
        off.sort_by(f64::total_cmp);
        said.sort_by(f64::total_cmp);
        println!("{step} nm: {held:?}, off {:.3} … {:.3}, said {:.3}", off[100], off[190], said[100]);
        // 95 % of 200, less two standard deviations of that count
        assert!(held.iter().all(|&n| n >= 184), "{step} nm: {held:?} of 200");
        // a bar of the median spectrum is below what one of twenty spectra misses, twice
        assert!(
            said[100] < 2.0 * off[190] + 0.05,
            "{step} nm: bars of {}, errors of {}",
            said[100],
            off[190]
        );
    }
}

/// A band of σ = 12 nm between wavelengths 40 nm apart is lost without a trace; a guide that has it
/// says by how much the colour is off, also where the spectrum is not the guide's.
#[test]
fn a_guide_sees_what_lies_between_the_wavelengths() {
    let fine = grid(FINE_NM);
    let nm = grid(60.0);
    let band = |nm: &f64| 0.5 * (-0.5 * ((nm - 490.0) / 12.0).powi(2)).exp();
    let guide = Guide {
        on_grid: nm.iter().map(|nm| 0.8 - band(nm)).collect(),
        fine: fine.iter().map(|nm| 0.8 - band(nm)).collect(),
        fine_nm: fine.clone(),
    };
    let exact = Colorimeter::new(&fine).unwrap();
    let meter = Colorimeter::new(&nm).unwrap();
    let reflectance = |nm: &f64| 0.7 - 0.9 * band(nm) + 1e-4 * (nm - 550.0);
    let values: Vec<f64> = nm.iter().map(reflectance).collect();
    let truth = exact.colour(&fine.iter().map(reflectance).collect::<Vec<_>>()).unwrap().lab;
    let lab = meter.colour(&values).unwrap().lab;
    let miss: [f64; 3] = std::array::from_fn(|i| lab[i] - truth[i]);
    assert!(length(miss) > 5.0, "{miss:?}");
    let blind = errors(&meter, &values, None);
    let guided = errors(&meter, &values, Some(&guide));
    assert!(length(blind) < 0.5 * length(miss), "{blind:?}");
    for i in 0..3 {
        // nine tenths of the guide's band, beside bars of the difference
        assert!((0.5..2.0).contains(&(guided[i] / miss[i].abs())), "{i}: {guided:?}, {miss:?}");
    }
    let luminance = meter.spacing_luminance(&values, Some(&guide));
    let off = (meter.xyz(&values).unwrap()[1]
        - exact.xyz(&fine.iter().map(reflectance).collect::<Vec<_>>()).unwrap()[1])
        .abs();
    assert!((0.5..2.0).contains(&(luminance / off)), "{luminance} {off}");
}

/// A spectrum that is the guide has no error but what the grid misses of it; a flat one none.
#[test]
fn nothing_unknown_has_no_error() {
    let fine = grid(FINE_NM);
    let nm = grid(50.0);
    let meter = Colorimeter::new(&nm).unwrap();
    let flat = Guide { on_grid: vec![0.4; nm.len()], fine: vec![0.4; fine.len()], fine_nm: fine };
    let error = errors(&meter, &flat.on_grid, Some(&flat));
    assert!(length(error) < 1e-9, "{error:?}");
}
