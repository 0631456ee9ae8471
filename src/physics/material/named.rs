//! Named materials: measured indices shipped with the program, from the refractiveindex.info
//! database (CC0 1.0); and the built-in pigments.
//!
//! The grains of a birefringent crystal have random orientations in a layer; the waves here use one
//! scalar index, that of the orientation average ε̄ = (2ε_o + ε_e)/3.
//!
//! P1 fixes Re η = 1.4 for every pigment and shows Im η of red, yellow, blue and an artificial
//! green only as a plot (Fig. 5). The built-in pigments are therefore **synthetic**: smooth sums of
//! Gaussians made for this project (`validation/data/pigments.json`), not measured data. Measured
//! spectra come from a CSV file.

use super::columns::{common, widest};
use super::dispersion::Dispersion;
#[cfg(feature = "serde")]
use super::dispersion::RecordText;
use num_complex::Complex64;

/// A listed material: its name, its description, and its records with their weights in ε̄.
#[derive(Debug)]
pub struct NamedMaterial {
    /// The name in `index = { material = "…" }`.
    pub name: &'static str,
    /// Description for ink and paint makers.
    pub what: &'static str,
    records: &'static [(f64, &'static str)],
}

macro_rules! material {
    ($name:literal, $what:literal, $($weight:expr => $file:literal),+) => {
        NamedMaterial {
            name: $name,
            what: $what,
            records: &[$(($weight, include_str!(concat!("records/", $file, ".yml")))),+],
        }
    };
}

/// Weight of the extraordinary index of a uniaxial crystal.
const E: f64 = 1.0 / 3.0;
/// Weight of its ordinary index.
const O: f64 = 2.0 / 3.0;

/// All named materials.
pub const MATERIALS: &[NamedMaterial] = &[
    material!("TiO2 rutile", "white pigment", O => "tio2-rutile-o", E => "tio2-rutile-e"),
    material!("TiO2 anatase", "white pigment", 1.0 => "tio2-anatase"),
    material!("ZnS", "white pigment (sphalerite)", 1.0 => "zns"),
    material!("ZnO", "white pigment", O => "zno-o", E => "zno-e"),
    material!("CaCO3", "extender (calcite)", O => "caco3-o", E => "caco3-e"),
    material!("SiO2", "extender, coating (fused silica)", 1.0 => "sio2"),
    material!("Fe2O3", "red pigment (haematite)", O => "fe2o3-o", E => "fe2o3-e"),
    material!("Fe3O4", "black pigment (magnetite)", 1.0 => "fe3o4"),
    material!("CdS", "yellow pigment (film)", 1.0 => "cds"),
    material!("carbon", "black pigment (amorphous film)", 1.0 => "carbon"),
    material!("soot", "black pigment (acetylene soot)", 1.0 => "soot"),
    material!("Al", "metal", 1.0 => "al"),
    material!("Au", "metal", 1.0 => "au"),
    material!("Cu", "metal", 1.0 => "cu"),
    material!("PMMA", "acrylic binder", 1.0 => "pmma"),
    material!("PS", "polystyrene: binder, hollow spheres", 1.0 => "ps"),
    material!("PVA", "polyvinyl alcohol: binder", 1.0 => "pva"),
];

impl NamedMaterial {
    /// The material of that name, ignoring case.
    pub fn find(name: &str) -> Option<&'static Self> {
        MATERIALS.iter().find(|material| material.name.eq_ignore_ascii_case(name))
    }

    /// Whether the crystal is birefringent, so that its two indices are averaged over orientations.
    pub fn is_birefringent(&self) -> bool {
        self.records.len() > 1
    }

    /// Index of the material against wavelength.
    #[cfg(feature = "serde")]
    pub fn index(&self) -> NamedIndex {
        // Tests read every record.
        let read = |text| Dispersion::parse(self.name, text).expect("a record of the program's own");
        let parts = self.records.iter().map(|&(weight, text)| (weight, read(text))).collect();
        NamedIndex { name: self.name.into(), parts }
    }

    /// References and comments of the measurements, one per record.
    #[cfg(feature = "serde")]
    pub fn sources(&self) -> Vec<RecordText> {
        self.records.iter().map(|(_, text)| serde_norway::from_str(text).unwrap_or_default()).collect()
    }
}

/// n(λ) + iκ(λ) of a named material.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NamedIndex {
    pub(super) name: String,
    /// Records with their weights in the average of ε.
    parts: Vec<(f64, Dispersion)>,
}

impl NamedIndex {
    /// Wavelength range common to all records, nm.
    pub fn range_nm(&self) -> [f64; 2] {
        common(self.parts.iter().map(|(_, record)| record.range_nm()))
    }

    /// The widest gap between the records' rows within a range of wavelengths, nm.
    pub fn widest_gap_nm(&self, range_nm: [f64; 2]) -> Option<[f64; 2]> {
        widest(self.parts.iter().filter_map(|(_, record)| record.widest_gap_nm(range_nm)))
    }

    /// √ε̄ at a wavelength in µm inside the range.
    pub fn index(&self, wavelength_um: f64) -> Complex64 {
        match self.parts.as_slice() {
            [(_, record)] => record.index(wavelength_um),
            parts => {
                let permittivity = |(w, record): &(f64, Dispersion)| w * record.index(wavelength_um).powi(2);
                parts.iter().map(permittivity).sum::<Complex64>().sqrt()
            }
        }
    }
}

/// The built-in synthetic pigments (κ(λ) of `validation/data/pigments.json`, Re η = 1.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Synthetic {
    /// Absorbs green.
    Red,
    /// Absorbs blue.
    Yellow,
    /// Absorbs red.
    Blue,
    /// P1's artificial green: absorbs blue and red alike.
    Green,
}

/// Range of the synthetic formulas: that of the CIE tables.
pub(super) const SYNTHETIC_RANGE_NM: [f64; 2] = [380.0, 780.0];

impl Synthetic {
    /// All synthetic pigments.
    pub const ALL: [Self; 4] = [Self::Red, Self::Yellow, Self::Blue, Self::Green];

    /// Name in study files: red, yellow, blue or green.
    pub fn name(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::Yellow => "yellow",
            Self::Blue => "blue",
            Self::Green => "green",
        }
    }

    /// κ(λ) = 0.30 (Σ a exp(−((λ − c)/s)²/2) + floor), λ in nm.
    pub fn kappa(self, wavelength_nm: f64) -> f64 {
        let (bands, floor): (&[[f64; 3]], f64) = match self {
            Self::Red => (&[[0.58, 516., 30.], [0.77, 549., 21.], [0.20, 360., 45.]], 0.015),
            Self::Yellow => (&[[0.55, 412., 34.], [0.74, 457., 23.]], 0.008),
            Self::Blue => (&[[0.80, 618., 36.], [1.00, 705., 40.], [0.18, 345., 45.]], 0.010),
            Self::Green => (&[[1.00, 430., 32.], [1.00, 655., 38.]], 0.008),
        };
        let gauss = |[a, c, s]: &[f64; 3]| a * (-((wavelength_nm - c) / s).powi(2) / 2.0).exp();
        0.30 * (bands.iter().map(gauss).sum::<f64>() + floor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of the publications, and of the database's page for the formulas.
    #[test]
    fn materials_have_the_published_indices() {
        let rows = [
            ("SiO2", 0.5876, 1.45846, 0.0, 1e-5),
            ("ZnS", 0.5876, 2.36828, 0.0, 2e-3),
            ("Au", 0.5486, 0.43, 2.455, 1e-12),
            ("PMMA", 0.56, 1.48639, 2.25e-7, 1e-12),
            ("Fe3O4", 0.54, 2.344, 0.099, 1e-12),
            ("TiO2 anatase", 0.50400, 2.55780, 0.0, 1e-12),
        ];
        for (name, um, n, kappa, allowed) in rows {
            let eta = NamedMaterial::find(name).unwrap().index().index(um);
            assert!((eta - Complex64::new(n, kappa)).norm() <= allowed, "{name} {um}: {eta}");
        }
    }

    /// DeVore (1951), table I, 589.3 nm: rutile n_o = 2.613, n_e = 2.909.
    #[test]
    fn crystals_are_averaged_in_permittivity() {
        let averaged = NamedMaterial::find("tio2 RUTILE").unwrap().index().index(0.5893);
        let expected = f64::sqrt((2.0 * 2.613f64.powi(2) + 2.909f64.powi(2)) / 3.0);
        assert!((averaged.re - expected).abs() < 1e-3 && averaged.im == 0.0, "{averaged} {expected}");
    }

    #[test]
    fn every_material_is_physical_over_its_range_and_says_whose_it_is() {
        for material in MATERIALS {
            let index = material.index();
            let [lo, hi] = index.range_nm();
            assert!(lo < 460.0 && hi > 700.0, "{}: {lo} to {hi} nm", material.name);
            for step in 0..=200 {
                let um = 1e-3 * (lo + (hi - lo) * f64::from(step) / 200.0).clamp(lo, hi);
                let eta = index.index(um);
                assert!(eta.re > 0.0 && eta.im >= 0.0 && eta.is_finite(), "{} {um}: {eta}", material.name);
            }
            for source in material.sources() {
                assert!(source.reference.contains("(19") || source.reference.contains("(20"), "{source:?}");
                assert!(!source.reference.contains('<'), "{source:?}");
            }
        }
    }

    #[test]
    fn synthetic_pigments_are_those_of_the_reference_table() {
        let text = include_str!("../../../validation/data/pigments.json");
        let json: serde_json::Value = serde_json::from_str(text).unwrap();
        for pigment in Synthetic::ALL {
            let table = &json["pigments"][pigment.name()];
            let column = |key: &str| -> Vec<f64> { serde_json::from_value(table[key].clone()).unwrap() };
            for (nm, kappa) in column("l").into_iter().zip(column("kappa")) {
                // rounding: the table has 8 significant digits
                approx::assert_relative_eq!(pigment.kappa(nm), kappa, max_relative = 1e-7);
            }
        }
    }
}
