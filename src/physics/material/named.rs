//! Named materials: measured indices that come with the program, from the refractiveindex.info database (CC0 1.0).
//!
//! A crystal with an ordinary and an extraordinary index stands in every direction in a layer of grains; the waves
//! here see one scalar index, that of the orientation average ε̄ = (2ε_o + ε_e)/3.

use super::dispersion::{Dispersion, RecordText};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// A material of the list: its name, what was measured, and its records with their weights in ε̄.
#[derive(Debug)]
pub struct NamedMaterial {
    /// The name in `index = { material = "…" }`.
    pub name: &'static str,
    /// What it is to an ink or paint maker.
    pub what: &'static str,
    records: &'static [(f64, &'static str)],
}

macro_rules! isotropic {
    ($name:literal, $what:literal, $file:literal) => {
        NamedMaterial {
            name: $name,
            what: $what,
            records: &[(1.0, include_str!(concat!("records/", $file, ".yml")))],
        }
    };
}

macro_rules! uniaxial {
    ($name:literal, $what:literal, $file:literal) => {
        NamedMaterial {
            name: $name,
            what: $what,
            records: &[
                (2.0 / 3.0, include_str!(concat!("records/", $file, "-o.yml"))),
                (1.0 / 3.0, include_str!(concat!("records/", $file, "-e.yml"))),
            ],
        }
    };
}

/// All named materials.
pub const MATERIALS: &[NamedMaterial] = &[
    uniaxial!("TiO2 rutile", "white pigment", "tio2-rutile"),
    isotropic!("TiO2 anatase", "white pigment", "tio2-anatase"),
    isotropic!("ZnS", "white pigment (sphalerite)", "zns"),
    uniaxial!("ZnO", "white pigment", "zno"),
    uniaxial!("CaCO3", "extender (calcite)", "caco3"),
    isotropic!("SiO2", "extender, coating (fused silica)", "sio2"),
    uniaxial!("Fe2O3", "red pigment (haematite)", "fe2o3"),
    isotropic!("Fe3O4", "black pigment (magnetite)", "fe3o4"),
    isotropic!("CdS", "yellow pigment (film)", "cds"),
    isotropic!("carbon", "black pigment (amorphous film)", "carbon"),
    isotropic!("soot", "black pigment (acetylene soot)", "soot"),
    isotropic!("Al", "metal", "al"),
    isotropic!("Au", "metal", "au"),
    isotropic!("Cu", "metal", "cu"),
    isotropic!("PMMA", "acrylic binder", "pmma"),
    isotropic!("PS", "polystyrene: binder, hollow spheres", "ps"),
    isotropic!("PVA", "polyvinyl alcohol: binder", "pva"),
];

impl NamedMaterial {
    /// The material of that name; upper and lower case alike.
    pub fn find(name: &str) -> Option<&'static Self> {
        MATERIALS.iter().find(|material| material.name.eq_ignore_ascii_case(name))
    }

    /// Whether the crystal has two indices, which are averaged over its orientations.
    pub fn is_birefringent(&self) -> bool {
        self.records.len() > 1
    }

    /// Its index against wavelength.
    pub fn index(&self) -> NamedIndex {
        let parts = self.records.iter().map(|&(weight, text)| (weight, Dispersion::shipped(self.name, text)));
        NamedIndex { name: self.name.into(), parts: parts.collect() }
    }

    /// Whose measurement of what it is, one text a record.
    pub fn sources(&self) -> Vec<RecordText> {
        self.records.iter().map(|(_, text)| RecordText::of(text)).collect()
    }
}

/// n(λ) + iκ(λ) of a named material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedIndex {
    name: String,
    /// Records with their weights in the average of ε.
    parts: Vec<(f64, Dispersion)>,
}

impl NamedIndex {
    /// The material's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// First and last wavelength that all records hold, nm.
    pub fn range_nm(&self) -> [f64; 2] {
        let ranges = self.parts.iter().map(|(_, record)| record.range_nm());
        ranges.fold([0.0, f64::INFINITY], |[lo, hi], [a, b]| [f64::max(lo, a), f64::min(hi, b)])
    }

    /// The widest gap between the records' rows that a range of wavelengths reaches into, nm.
    pub fn widest_gap_nm(&self, range_nm: [f64; 2]) -> Option<[f64; 2]> {
        let gaps = self.parts.iter().filter_map(|(_, record)| record.widest_gap_nm(range_nm));
        gaps.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))
    }

    /// √ε̄ at a wavelength in µm inside the range.
    pub fn index(&self, wavelength_um: f64) -> Complex64 {
        match self.parts.as_slice() {
            [(_, record)] => record.index(wavelength_um),
            parts => parts
                .iter()
                .map(|(w, record)| w * record.index(wavelength_um).powi(2))
                .sum::<Complex64>()
                .sqrt(),
        }
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
}
