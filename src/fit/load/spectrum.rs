//! The measured spectrum of a drawdown.

use super::FitReading;
use crate::fit::file::{FitGeometry, MeasuredTable};
use crate::input::measured::{
    MeasuredContent, MeasuredGeometry, MeasuredKind, MeasuredReading, MeasuredRequest,
};
use crate::input::study::Study;
use crate::material::columns::in_other_unit;

/// Largest reflectance factor accepted: a layer does not emit light, but calibrations may err.
const BRIGHTEST: f64 = 1.02;
/// Smallest reflectance factor accepted: instrument noise at black.
const DARKEST: f64 = -0.02;

/// Distance of rows above which it is said that values between them are interpolated, nm: no
/// spectrophotometer has wider steps.
const WIDEST_NM: f64 = 50.0;

/// A measured spectrum at the wavelengths of a study.
pub(super) struct FitSpectrum {
    pub(super) values: Vec<f64>,
    /// By the key, or as the file declares; none where both are silent.
    pub(super) geometry: Option<FitGeometry>,
}

impl FitReading<'_> {
    /// The measured values at the study's wavelengths, and their geometry.
    pub(super) fn spectrum(
        &mut self,
        field: &str,
        table: &MeasuredTable,
        study: &Study,
    ) -> Option<FitSpectrum> {
        let path = self.folder.join(table.file.as_ref()?);
        let waves = &study.wavelengths_nm;
        let own_keys = |text: &str| text.replace("compare.", &format!("{field}."));
        let request = MeasuredRequest {
            patch: table.patch.clone(),
            one_must_be_named: true,
            unit: table.unit,
            condition: table.condition,
            kind: if table.geometry == Some(FitGeometry::Transmitted) {
                MeasuredKind::Transmittance
            } else {
                MeasuredKind::Reflectance
            },
            geometries: geometries(table.geometry),
            used_nm: [waves[0], waves[waves.len() - 1]],
            ..MeasuredRequest::default()
        };
        let reading = MeasuredReading::new(&path, &request).and_then(|reading| match reading.measured {
            MeasuredContent::Spectrum(spectrum) => Ok((spectrum, reading.geometry, reading.remarks)),
            MeasuredContent::Colour(_) => Err(format!("{}: a colour, and no spectrum", path.display())),
        });
        let (spectrum, declared, remarks) = match reading {
            Ok(read) => read,
            Err(error) => {
                let allowed = "a spectrum of reflectance factors against wavelengths in nm, of one sample";
                let remedy = "correct the file, or say by patch, unit, condition or geometry what is meant";
                self.faults.add(format!("{field}.file"), own_keys(&error), allowed, remedy);
                return None;
            }
        };
        self.remarks.extend(remarks.iter().map(|remark| format!("{field}: {}", own_keys(remark))));
        let geometry = table.geometry.or(declared.as_ref().and_then(known_geometry));
        let is_usual = geometry.is_none_or(|geometry| geometry == FitGeometry::LitAt45);
        if let (None, false, Some(declared)) = (table.geometry, is_usual, &declared) {
            self.remarks.push(format!("{field}.geometry: {}, as the file declares", declared.name()));
        }
        if let Some([nm, value]) = spectrum.rows.iter().find(|row| !(DARKEST..=BRIGHTEST).contains(&row[1])) {
            let allowed = format!("reflectance factors from {DARKEST} to {BRIGHTEST}");
            let remedy =
                "fluorescent layers cannot be fitted; for values in percent write unit = \"percent\"";
            self.faults.add(format!("{field}.file"), format!("{value} at {nm} nm"), allowed, remedy);
            return None;
        }
        let hole = |nm: f64| {
            let mut pairs = spectrum.rows.windows(2).map(|pair| [pair[0][0], pair[1][0]]);
            pairs.find(|[a, b]| *a < nm && nm < *b && b - a > WIDEST_NM)
        };
        if let Some((nm, [a, b])) = waves.iter().find_map(|&nm| Some((nm, hole(nm)?))) {
            self.remarks.push(format!(
                "{field}.file: no row between {a} and {b} nm, where the base has {nm} nm: values there are interpolated, and fitted \
                 as if measured; leave such wavelengths out of the base's [light]"
            ));
        }
        let [from, to] = spectrum.range_nm();
        let values: Option<Vec<f64>> = waves.iter().map(|&nm| spectrum.at(nm)).collect();
        if values.is_none() {
            let [first, last] = [waves[0], waves[waves.len() - 1]];
            let allowed = format!("all wavelengths of the base: {first} to {last} nm");
            let usual = "give [light] of the base a range that all files cover";
            let remedy = in_other_unit([from, to], [first, last]).unwrap_or_else(|| usual.to_owned());
            self.faults.add(format!("{field}.file"), format!("{from} to {to} nm"), allowed, remedy);
        }
        Some(FitSpectrum { values: values?, geometry })
    }
}

/// The geometries of files that suit a key; without it any that can be predicted.
fn geometries(key: Option<FitGeometry>) -> Vec<MeasuredGeometry> {
    let sphere = || vec![MeasuredGeometry::Sphere(Some(true)), MeasuredGeometry::Sphere(None)];
    match key {
        Some(FitGeometry::LitAt45) => vec![MeasuredGeometry::LitAt45],
        Some(FitGeometry::Sphere) => sphere(),
        Some(FitGeometry::SphereExcluded) => {
            // seen along the normal instead of at 8° the two are alike to a thousandth
            vec![
                MeasuredGeometry::Sphere(Some(false)),
                MeasuredGeometry::Sphere(None),
                MeasuredGeometry::DiffuseNormal,
            ]
        }
        Some(FitGeometry::UniformSky) => vec![MeasuredGeometry::UniformSky],
        // any that a file of transmitted light may state
        Some(FitGeometry::Transmitted) => Vec::new(),
        None => vec![
            MeasuredGeometry::LitAt45,
            MeasuredGeometry::Sphere(Some(true)),
            MeasuredGeometry::Sphere(Some(false)),
            MeasuredGeometry::UniformSky,
        ],
    }
}

/// The geometry that a file's is predicted by. A sphere whose specular light may be included or not
/// needs the key.
fn known_geometry(declared: &MeasuredGeometry) -> Option<FitGeometry> {
    match declared {
        MeasuredGeometry::LitAt45 => Some(FitGeometry::LitAt45),
        MeasuredGeometry::Sphere(Some(true)) => Some(FitGeometry::Sphere),
        MeasuredGeometry::Sphere(Some(false)) => Some(FitGeometry::SphereExcluded),
        MeasuredGeometry::UniformSky => Some(FitGeometry::UniformSky),
        MeasuredGeometry::Sphere(None) | MeasuredGeometry::DiffuseNormal | MeasuredGeometry::Other(_) => None,
    }
}
