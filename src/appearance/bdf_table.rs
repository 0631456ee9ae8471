//! A BDF as a sparse table: one row per propagating order, CSV that spreadsheets, Python and R open.

use super::bdf::{Bdf, BdfError, Lobe, OrderMean};
use serde::Serialize;
use std::io::Write;

/// One row. Angles in degrees (polar from the normal on the side the light leaves to, vacuum), BDF in 1/sr,
/// efficiencies as shares of the incident power; empty where one realisation leaves a number unknown.
#[derive(Serialize)]
struct Row<'a> {
    wavelength_nm: f64,
    incidence_polar_deg: f64,
    incidence_azimuth_deg: f64,
    lit_from: &'a str,
    side: &'a str,
    m: i32,
    n: i32,
    direction_x: f64,
    direction_y: f64,
    polar_deg: f64,
    azimuth_deg: f64,
    efficiency: f64,
    efficiency_standard_error: Option<f64>,
    coherent_efficiency: Option<f64>,
    diffuse_efficiency: Option<f64>,
    bdf_per_sr: f64,
    bdf_standard_error: Option<f64>,
    realisations: usize,
}

impl Bdf {
    /// Writes the rows of both sides; `header` once, at the top of the file, then more wavelengths may follow.
    ///
    /// The specular order (0, 0) is a row too; its `bdf_per_sr` is that of a delta spread over one lattice cell.
    ///
    /// # Errors
    /// The sink cannot be written.
    pub fn write_csv(&self, sink: impl Write, header: bool) -> Result<(), BdfError> {
        let mut table = csv::WriterBuilder::new().has_headers(header).from_writer(sink);
        let failed = |e: String| BdfError::Write(e);
        for (lobe, side) in [(Lobe::Reflected, "reflected"), (Lobe::Transmitted, "transmitted")] {
            for order in self.orders(lobe) {
                table.serialize(self.row(order, side)).map_err(|e| failed(e.to_string()))?;
            }
        }
        table.flush().map_err(|e| failed(e.to_string()))
    }

    fn row<'a>(&self, o: &OrderMean, side: &'a str) -> Row<'a> {
        let (incidence, [x, y]) = (self.incidence(), o.direction);
        Row {
            wavelength_nm: 1000.0 * incidence.wavelength_um,
            incidence_polar_deg: incidence.polar_deg,
            incidence_azimuth_deg: incidence.azimuth_deg,
            lit_from: match incidence.from {
                crate::wave::Side::Incident => "above",
                crate::wave::Side::Exit => "below",
            },
            side,
            m: o.m,
            n: o.n,
            direction_x: x,
            direction_y: y,
            polar_deg: x.hypot(y).min(1.0).asin().to_degrees(),
            azimuth_deg: y.atan2(x).to_degrees(),
            efficiency: o.efficiency.value,
            efficiency_standard_error: o.efficiency.standard_error,
            coherent_efficiency: o.coherent,
            diffuse_efficiency: o.diffuse,
            bdf_per_sr: o.bdf.value,
            bdf_standard_error: o.bdf.standard_error,
            realisations: self.realisations(),
        }
    }
}
