//! Tables of `examples/scalar-against-vector.toml`: `cargo run --release --example
//! scalar_against_vector -- OUT DATA.csv` reads the finished sweep in OUT, prints its pairs of
//! variants as Markdown, and writes their differences to DATA.csv.

use inkwave::appearance::tristimulus::Colorimeter;
use inkwave::evaluate::manifest::main_numbers::PrintRow;
use inkwave::input::study::Study;
use inkwave::numerics::estimate::{Estimate, Linked};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::sweep::file::MeasuredQuantity;
use inkwave::sweep::outcome::Outcome;
use inkwave::sweep::{folder, publish::publish};
use inkwave::wave::Wave;
use std::error::Error;
use std::path::Path;

/// One ink in both waves: differences are scalar less unpolarised.
struct Pair {
    ink: String,
    kappa: f64,
    contrast: f64,
    volume_fraction: f64,
    diameter_nm: f64,
    thickness_um: f64,
    sky: Estimate,
    print: f64,
    reflectance: Estimate,
    transmittance: Estimate,
    /// Mean over the wavelengths of the radiance factor under a uniform sky, scalar and
    /// unpolarised.
    white_sky: [f64; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [out, data] = args.as_slice() else {
        return Err("give the sweep's folder and the file to write".into());
    };
    let sweep = folder::read(Path::new(out))?;
    let reported = publish(&sweep, &OutputFolder::open(Path::new(out), Holds::Sweep)?)?;
    let of = |wave: Wave| {
        let variants = sweep.variants.iter().zip(&reported.outcomes);
        variants.filter(move |(variant, _)| variant.study.wave == wave)
    };
    let mut pairs = Vec::new();
    for (scalar, outcome) in of(Wave::Scalar) {
        let others = |labels: &[String]| {
            labels.iter().filter(|l| !Wave::NAMES.contains(&l.as_str())).cloned().collect::<Vec<_>>()
        };
        let same = |(_, o): &(_, &Outcome)| others(&o.labels) == others(&outcome.labels);
        let (_, vector) = of(Wave::Unpolarised).find(same).ok_or("a scalar variant without its pair")?;
        pairs.push(pair(&scalar.study, outcome, vector)?);
    }
    pairs.iter().for_each(|p| println!("{}", p.in_markdown()));
    let mut table = csv::Writer::from_path(data)?;
    table.write_record([
        "ink",
        "largest_kappa",
        "contrast",
        "volume_fraction",
        "diameter_nm",
        "thickness_um",
        "delta_e_sky",
        "delta_e_sky_standard_error",
        "delta_e_print",
        "reflectance",
        "reflectance_standard_error",
        "transmittance",
        "transmittance_standard_error",
    ])?;
    for p in &pairs {
        let numbers = [
            p.kappa,
            p.contrast,
            p.volume_fraction,
            p.diameter_nm,
            p.thickness_um,
            p.sky.value,
            p.sky.standard_error.unwrap_or(0.0),
            p.print,
            p.reflectance.value,
            p.reflectance.standard_error.unwrap_or(0.0),
            p.transmittance.value,
            p.transmittance.standard_error.unwrap_or(0.0),
        ];
        let rounded = numbers.map(|x| format!("{x:.4}"));
        table.write_record(std::iter::once(p.ink.clone()).chain(rounded))?;
    }
    Ok(table.flush()?)
}

fn pair(study: &Study, scalar: &Outcome, vector: &Outcome) -> Result<Pair, Box<dyn Error>> {
    let (name, volume_fraction, index, diameter_nm) = match (study.pigments.first(), study.dissolved.first())
    {
        (Some(p), _) => (&p.name, p.grains.volume_fraction, &p.material.index, p.grains.size.largest_nm()),
        (None, Some(d)) => (&d.name, d.volume_fraction, &d.material.index, 0.0),
        _ => return Err("a variant without a pigment".into()),
    };
    let lit = |o: &Outcome| normal(o).filter_map(|row| Some(row.lit_at_45?.value)).collect::<Vec<f64>>();
    let mut contrast: f64 = 0.0;
    for (nm, eta) in study.wavelengths_nm.iter().zip(index) {
        contrast = contrast.max((eta.re - study.layer.binder.spectrum.index(1e-3 * nm)?.re).abs());
    }
    let meter = Colorimeter::new(&study.wavelengths_nm)?;
    let print = [meter.colour(&lit(scalar))?, meter.colour(&lit(vector))?];
    let sky = |o: &Outcome| {
        let values: Vec<f64> = normal(o).filter_map(|row| Some(row.natural_light?.value)).collect();
        values.iter().sum::<f64>() / values.len().max(1) as f64
    };
    Ok(Pair {
        ink: name.clone(),
        kappa: index.iter().map(|eta| eta.im).fold(0.0, f64::max),
        contrast,
        volume_fraction,
        diameter_nm,
        thickness_um: study.layer.thickness_um,
        sky: scalar.difference(vector).ok_or("a variant without a colour")?.estimate,
        print: print[0].delta_e_2000(&print[1]).value,
        reflectance: largest(scalar, vector, MeasuredQuantity::Reflectance),
        transmittance: largest(scalar, vector, MeasuredQuantity::Transmittance),
        white_sky: [sky(scalar), sky(vector)],
    })
}

fn normal(outcome: &Outcome) -> impl Iterator<Item = &PrintRow> {
    outcome.spectra.iter().filter(|row| row.polar_deg == 0.0)
}

/// The difference of largest modulus over the wavelengths, at normal incidence. Both waves are
/// solved in the same packings, cells, directions and wavelengths, so that errors that these share
/// cancel.
fn largest(scalar: &Outcome, vector: &Outcome, quantity: MeasuredQuantity) -> Estimate {
    let differences = normal(scalar).filter_map(|row| {
        let of = |o: &Outcome| o.quantity(quantity, Some(row.wavelength_nm));
        let [a, b] = [of(scalar)?, of(vector)?];
        Some(Linked::sum([(1.0, &a), (-1.0, &b)]).estimate)
    });
    let nothing = Estimate { value: 0.0, standard_error: None };
    differences.fold(nothing, |most, d| if d.value.abs() > most.value.abs() { d } else { most })
}

impl Pair {
    fn in_markdown(&self) -> String {
        let grains = if self.diameter_nm == 0.0 {
            "molecular".to_owned()
        } else {
            format!("{:.0} nm", self.diameter_nm)
        };
        let with_error = |e: Estimate, digits: usize| {
            format!("{:+.digits$} ± {:.digits$}", e.value, e.standard_error.unwrap_or(0.0))
        };
        let error = self.sky.standard_error.unwrap_or(0.0);
        let [scalar, vector] = self.white_sky;
        format!(
            "| {} | {:.0} % | {grains} | {:.2} ± {error:.2} | {:.2} | {} | {} | {scalar:.3} | {vector:.3} |",
            self.ink,
            100.0 * self.volume_fraction,
            self.sky.value,
            self.print,
            with_error(self.reflectance, 3),
            with_error(self.transmittance, 3)
        )
    }
}
