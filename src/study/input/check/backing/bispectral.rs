//! Bispectral tables of fluorescent paper: radiance factors by the wavelength emitted and that of
//! the light (Donaldson).

use crate::appearance::fluorescence::Fluorescence;
use crate::material::text_table::read_text;
use std::path::Path;

/// Share of a bispectral table below its diagonal, where light would be emitted at shorter waves
/// than it came at, that is noise.
const BELOW_DIAGONAL: f64 = 0.01;

/// Reads a bispectral table: what is emitted, of longer wavelength than its light.
pub(super) fn donaldson(path: &Path) -> Result<Fluorescence, String> {
    let text = read_text(path).map_err(|error| error.to_string())?;
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let mut lines = lines.map(|line| line.split([',', ';', '\t']).map(str::trim).collect::<Vec<_>>());
    let header = lines.next().ok_or("no rows")?;
    let number = |cell: &&str| {
        cell.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| format!("{cell:?} is no number"))
    };
    let excitation_nm = header[1..].iter().map(number).collect::<Result<Vec<_>, _>>()?;
    let widths: Vec<f64> = excitation_nm.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if widths.is_empty() || widths.iter().any(|w| *w <= 0.0 || (w - widths[0]).abs() > 1e-6 * widths[0].abs())
    {
        return Err(format!(
            "{} wavelengths of the light that do not rise in equal steps",
            excitation_nm.len()
        ));
    }
    let mut emission_nm: Vec<f64> = Vec::new();
    let mut factors = Vec::new();
    let mut emitted_later = 0.0;
    let mut left_out = 0.0;
    for cells in lines {
        let nm = number(cells.first().ok_or("an empty row")?)?;
        let row = cells[1..].iter().map(number).collect::<Result<Vec<_>, _>>()?;
        if row.len() != excitation_nm.len() {
            return Err(format!(
                "{} factors at {nm} nm, {} wavelengths of the light",
                row.len(),
                excitation_nm.len()
            ));
        }
        if emission_nm.last().is_some_and(|last| nm <= *last) {
            return Err(format!("emitted wavelengths that do not rise at {nm} nm"));
        }
        if let Some(negative) = row.iter().find(|x| **x < 0.0) {
            return Err(format!("{negative} at {nm} nm: factors are 0 or more"));
        }
        for (from, factor) in excitation_nm.iter().zip(&row) {
            emitted_later += if nm > *from { *factor } else { 0.0 };
            left_out += if nm < *from { *factor } else { 0.0 };
        }
        let emitted =
            excitation_nm.iter().zip(row).map(|(from, factor)| if nm > *from { factor } else { 0.0 });
        factors.push(emitted.collect::<Vec<f64>>());
        emission_nm.push(nm);
    }
    if emission_nm.len() < 2 {
        return Err(format!("{} emitted wavelengths, 2 are the least", emission_nm.len()));
    }
    if emitted_later == 0.0 || left_out > BELOW_DIAGONAL * emitted_later {
        return Err(format!(
            "{:.3} in all emitted at waves longer than those of the light, {:.3} at shorter ones, of which there is nothing: \
             exchange rows and columns, so that emitted wavelengths stand in the first column",
            emitted_later, left_out
        ));
    }
    Ok(Fluorescence::Table { excitation_nm, emission_nm, factors })
}
