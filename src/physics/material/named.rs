//! Named materials: measured indices shipped with the program, most of them from the
//! refractiveindex.info database (CC0 1.0), each with its origin at its head and with a grade.
//!
//! The grains of a birefringent crystal have random orientations in a layer. One index for all of
//! them is that of the orientation average ε̄ = (2ε_o + ε_e)/3; Maxwell's equations take both rays
//! of a uniaxial one as well ([`Ray`]).

use super::columns::{common, widest};
use super::dispersion::Dispersion;
#[cfg(feature = "serde")]
use super::dispersion::RecordText;
use num_complex::Complex64;

/// A listed material: its name, what it is, what is known of its record, and the record itself.
#[derive(Debug)]
pub struct NamedMaterial {
    /// The name in `index = { material = "…" }`.
    pub name: &'static str,
    /// Earlier names of the same record, which are still read.
    pub former: &'static [&'static str],
    /// Description for ink and paint makers.
    pub what: &'static str,
    /// How far the record can be trusted.
    pub grade: Grade,
    /// Records with their weights in ε̄, each with those that continue it beyond its range.
    records: &'static [(f64, &'static [&'static str])],
}

/// What was measured, and what paints of it look like.
#[derive(Clone, Copy, Debug)]
pub struct Grade {
    /// The sample: a crystal, a film, a pellet, particles.
    pub sample: &'static str,
    /// Where κ is known, and to which size.
    pub kappa: &'static str,
    /// The colour of an opaque paint, where measured ones are at hand.
    pub masstone: Option<Masstone>,
}

/// The colour of an opaque paint of one pigment beside measured ones of the same kind: D50, 2°,
/// lit at 45° and viewed along the normal. Both stand in `reports/measured`.
#[derive(Clone, Copy, Debug)]
pub struct Masstone {
    /// L*, a*, b* of the record by Mie's theory and radiative transfer.
    pub lab: [f64; 3],
    /// Median diameter of the grains for that colour, nm.
    pub diameter_nm: f64,
    /// The measured paints.
    pub paints: &'static str,
    /// The beginning of their names in `validation/data/measured`.
    pub paints_named: &'static str,
    /// Smallest and largest ΔE₀₀ to them.
    pub delta_e_2000: [f64; 2],
    /// Whether these lie within what the paints differ by, or why not.
    pub verdict: &'static str,
}

impl Grade {
    const fn of(sample: &'static str, kappa: &'static str) -> Self {
        Self { sample, kappa, masstone: None }
    }

    const fn with(self, masstone: Masstone) -> Self {
        Self { masstone: Some(masstone), ..self }
    }
}

macro_rules! material {
    ($name:literal $(formerly $former:literal)?, $what:literal, $grade:expr, $($weight:expr => $($file:literal)+),+) => {
        NamedMaterial {
            name: $name,
            former: &[$($former)?],
            what: $what,
            grade: $grade,
            records: &[$(($weight, &[$(include_str!(concat!("records/", $file, ".yml"))),+])),+],
        }
    };
}

/// Weight of the extraordinary index of a uniaxial crystal, and of each index of a biaxial one.
const E: f64 = 1.0 / 3.0;
/// Weight of the ordinary index of a uniaxial crystal.
const O: f64 = 2.0 / 3.0;
/// κ of records that have n alone.
const NO_KAPPA: &str = "not measured, taken as 0";
/// κ of records whose source states no error.
const NO_ERROR: &str = "as printed, without a stated error";

/// All named materials.
pub const MATERIALS: &[NamedMaterial] = &[
    material!("TiO2 rutile", "white pigment",
        Grade::of("crystals: three records joined", "0.12 to 2.2 below 360 nm; taken as 0 from 400 nm up, where paints show traces up to 420 nm").with(Masstone {
            lab: [101.9, 0.0, 0.3],
            diameter_nm: 250.0,
            paints: "one titanium white",
            paints_named: "white",
            delta_e_2000: [3.0, 3.0],
            verdict: "brighter than the paint, whose thickness is not stated, and without its trace of yellow",
        }),
        O => "tio2-rutile-o" "tio2-rutile-o-uv" "tio2-rutile-o-ir",
        E => "tio2-rutile-e" "tio2-rutile-e-uv" "tio2-rutile-e-ir"),
    material!("TiO2 anatase", "white pigment", Grade::of("film of anatase, deposited in atomic layers", NO_ERROR),
        1.0 => "tio2-anatase"),
    material!("ZnS", "white pigment (sphalerite)", Grade::of("crystal", NO_KAPPA), 1.0 => "zns"),
    material!("ZnO", "white pigment", Grade::of("crystal", NO_KAPPA), O => "zno-o", E => "zno-e"),
    material!("BaSO4", "extender (barite)", Grade::of("natural crystal: one n for all wavelengths", NO_KAPPA),
        E => "baso4-x", E => "baso4-y", E => "baso4-z"),
    material!("CaCO3", "extender (calcite)", Grade::of("crystal", NO_KAPPA), O => "caco3-o", E => "caco3-e"),
    material!("kaolin", "extender (kaolinite)", Grade::of("natural crystal: one n for all wavelengths", NO_KAPPA),
        E => "kaolinite-x", E => "kaolinite-y", E => "kaolinite-z"),
    material!("SiO2", "extender, coating (fused silica)", Grade::of("glass", NO_KAPPA), 1.0 => "sio2"),
    material!("haematite (Longtin)", "red pigment", Grade::of("not stated", "0.52 at 400, 0.09 at 550, 0.001 at 694 nm").with(Masstone {
            lab: [39.1, 33.3, 45.5],
            diameter_nm: 200.0,
            paints: "four red oxides (PR101)",
            paints_named: "PR101",
            delta_e_2000: [5.7, 15.1],
            verdict: "more orange than the pigment, whose makers differ by 8 to 11: κ beyond 600 nm is too small",
        }),
        1.0 => "fe2o3-longtin"),
    material!("haematite (Querry)" formerly "Fe2O3", "brown: darker in the red than the pigment",
        Grade::of("crystal", "1.3 at 400, 0.5 at 550, 0.03 at 700 nm, without a stated error").with(Masstone {
            lab: [18.4, 25.1, 19.3],
            diameter_nm: 200.0,
            paints: "four red oxides (PR101)",
            paints_named: "PR101",
            delta_e_2000: [7.0, 16.4],
            verdict: "darker than the pigment, whose makers differ by 8 to 11: κ beyond 600 nm is too large",
        }), O => "fe2o3-o", E => "fe2o3-e"),
    material!("magnetite (Jena)", "black pigment", Grade::of("not stated", "1.0 at 400, 0.65 at 700 nm, without a stated error").with(Masstone {
            lab: [4.2, 0.9, 0.8],
            diameter_nm: 200.0,
            paints: "two Mars blacks (PBk11)",
            paints_named: "PBk11",
            delta_e_2000: [6.0, 9.5],
            verdict: "with the light that the paints' surfaces return, 1 to 2 %, 0.2 to 1.2; makers differ by about 5",
        }),
        1.0 => "fe3o4-jena"),
    material!("magnetite (Querry)" formerly "Fe3O4", "blue-violet: not the black pigment",
        Grade::of("not stated", "0.03 at 450, 0.10 at 550, 0.14 at 650 nm, a tenth of other records").with(Masstone {
            lab: [20.7, 6.0, -27.3],
            diameter_nm: 200.0,
            paints: "two Mars blacks (PBk11)",
            paints_named: "PBk11",
            delta_e_2000: [17.9, 18.9],
            verdict: "not the black pigment, whose makers differ by about 5",
        }), 1.0 => "fe3o4"),
    material!("CdS", "yellow pigment without zinc", Grade::of("sputtered film", NO_ERROR).with(Masstone {
            lab: [88.0, 26.3, 132.1],
            diameter_nm: 300.0,
            paints: "two cadmium yellows (PY35)",
            paints_named: "PY35",
            delta_e_2000: [6.0, 18.2],
            verdict: "PY35 holds zinc, which moves its edge to the blue; the film has none",
        }), 1.0 => "cds"),
    material!("flame soot", "black pigment: the nearest measured kin of carbon black",
        Grade::of("particles in a flame of propane", "0.67 at 400, 0.57 at 710 nm, without a stated error"), 1.0 => "flame-soot"),
    material!("acetylene soot" formerly "soot", "black pigment: acetylene black with the voids of a pellet",
        Grade::of("pellet", NO_ERROR), 1.0 => "soot"),
    material!("amorphous carbon" formerly "carbon", "black film, no pigment", Grade::of("film evaporated by an arc", NO_ERROR),
        1.0 => "carbon"),
    material!("Al", "metal", Grade::of("evaporated films", NO_ERROR), 1.0 => "al"),
    material!("Au", "metal", Grade::of("not stated", NO_ERROR), 1.0 => "au"),
    material!("Cu", "metal", Grade::of("not stated", NO_ERROR), 1.0 => "cu"),
    material!("PMMA", "acrylic binder", Grade::of("product of one maker", NO_ERROR), 1.0 => "pmma"),
    material!("PS", "polystyrene: binder, hollow spheres", Grade::of("product of one maker", NO_ERROR), 1.0 => "ps"),
    material!("PVA", "polyvinyl alcohol: binder", Grade::of("film", "0.0050 ± 0.0004, which no clear binder has"), 1.0 => "pva"),
];

impl NamedMaterial {
    /// The material of that name or former name, ignoring case and further spaces; haematite may be
    /// hematite.
    pub fn find(name: &str) -> Option<&'static Self> {
        let name = spelt_alike(name);
        MATERIALS.iter().find(|material| material.names().any(|own| spelt_alike(own) == name))
    }

    /// Names of the materials whose name or use has these words, with the spellings of
    /// [`NamedMaterial::find`].
    pub fn with_words(words: &str) -> Vec<&'static str> {
        let words = spelt_alike(words);
        if words.is_empty() {
            return Vec::new();
        }
        let has = |material: &&Self| {
            material.names().chain([material.what]).any(|text| spelt_alike(text).contains(&words))
        };
        MATERIALS.iter().filter(has).map(|material| material.name).collect()
    }

    /// Its name, and its former ones.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        [self.name].into_iter().chain(self.former.iter().copied())
    }

    /// Whether the crystal is birefringent, so that its indices are averaged over orientations.
    pub fn is_birefringent(&self) -> bool {
        self.records.len() > 1
    }

    /// Whether it is a uniaxial crystal of which both rays are recorded.
    pub fn is_uniaxial(&self) -> bool {
        matches!(self.records, [(O, _), (E, _)])
    }

    /// Index of one ray of a uniaxial crystal; `None` for other materials.
    #[cfg(feature = "serde")]
    pub(super) fn ray(&self, ray: Ray, name: &str) -> Option<NamedIndex> {
        let mut whole = self.is_uniaxial().then(|| self.index_called(name))?;
        let (_, record) = whole.parts.swap_remove(ray as usize);
        whole.name = format!("{name}, {} ray", ray.name());
        whole.parts = vec![(1.0, record)];
        Some(whole)
    }

    /// Index of the material against wavelength.
    #[cfg(feature = "serde")]
    pub fn index(&self) -> NamedIndex {
        self.index_called(self.name)
    }

    /// Index of the material under one of its names, which reports repeat.
    #[cfg(feature = "serde")]
    pub(super) fn index_called(&self, name: &str) -> NamedIndex {
        // Tests read every record.
        let read = |text: &&str| Dispersion::parse(self.name, text).expect("a record of the program's own");
        let joined = |texts: &[&str]| read(&texts[0]).joined_with(texts[1..].iter().map(read).collect());
        let parts = self.records.iter().map(|&(weight, texts)| (weight, joined(texts))).collect();
        NamedIndex { name: name.into(), parts }
    }

    /// References and comments of the measurements, one per record.
    #[cfg(feature = "serde")]
    pub fn sources(&self) -> Vec<RecordText> {
        let texts = self.records.iter().flat_map(|(_, texts)| texts.iter());
        texts.map(|text| serde_norway::from_str(text).unwrap_or_default()).collect()
    }

    /// Remarks at the head of the records: where each was found, and under which terms.
    pub fn origins(&self) -> impl Iterator<Item = &'static str> {
        let texts = self.records.iter().flat_map(|(_, texts)| texts.iter());
        texts.flat_map(|text| text.lines().map_while(|line| line.strip_prefix('#'))).map(str::trim)
    }
}

/// A name without what people spell in different ways.
fn spelt_alike(name: &str) -> String {
    let words = name.to_lowercase().replace("haem", "hem");
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A ray in a uniaxial crystal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ray {
    /// Its field is across the optic axis.
    Ordinary,
    /// Its field has a part along the optic axis.
    Extraordinary,
}

impl Ray {
    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ordinary => "ordinary",
            Self::Extraordinary => "extraordinary",
        }
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

    /// Pairs of wavelengths, nm, between which two records are joined, linear between both.
    pub fn seams_nm(&self) -> Vec<[f64; 2]> {
        self.parts.iter().flat_map(|(_, record)| record.seams_nm()).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of the publications, and of the database's page for the formulas.
    #[test]
    fn materials_are_found_by_a_part_of_their_name_or_use() {
        assert_eq!(NamedMaterial::with_words("Rutile"), ["TiO2 rutile"]);
        assert_eq!(NamedMaterial::with_words("red pigment"), ["haematite (Longtin)"]);
        assert_eq!(NamedMaterial::with_words("hematite").len(), 2);
        assert_eq!(NamedMaterial::find(" tio2  Rutile").map(|found| found.name), Some("TiO2 rutile"));
        assert!(NamedMaterial::with_words(" ").is_empty() && NamedMaterial::with_words("chalk").is_empty());
    }

    #[test]
    fn materials_have_the_published_indices() {
        let rows = [
            ("SiO2", 0.5876, 1.45846, 0.0, 1e-5),
            ("ZnS", 0.5876, 2.36828, 0.0, 2e-3),
            ("Au", 0.5486, 0.43, 2.455, 1e-12),
            ("PMMA", 0.56, 1.48639, 2.25e-7, 1e-12),
            ("Fe3O4", 0.54, 2.344, 0.099, 1e-12),
            ("magnetite (Querry)", 0.54, 2.344, 0.099, 1e-12),
            ("magnetite (Jena)", 0.56234, 2.18001, 0.85703, 1e-12),
            ("haematite (Longtin)", 0.55, 3.102, 0.0925, 1e-12),
            ("flame soot", 0.54, 1.77, 0.63, 1e-12),
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

    /// Both rays of rutile, whose mean is the material's own index; barite is biaxial.
    #[test]
    fn uniaxial_crystals_have_two_rays() {
        let rutile = NamedMaterial::find("TiO2 rutile").unwrap();
        let [o, e] = [Ray::Ordinary, Ray::Extraordinary].map(|ray| rutile.ray(ray, "rutile").unwrap());
        assert!((o.index(0.5893).re - 2.613).abs() < 1e-3 && (e.index(0.5893).re - 2.909).abs() < 1e-3);
        let mean = ((2.0 * o.index(0.5).powi(2) + e.index(0.5).powi(2)) / 3.0).sqrt();
        assert!((mean - rutile.index().index(0.5)).norm() < 1e-12);
        assert!(NamedMaterial::find("BaSO4").unwrap().ray(Ray::Ordinary, "barite").is_none());
    }

    /// Rutile across its seams: Devore's ray keeps its formula, the seams are straight, and the
    /// records meet: n of the three steps by less than 0.005 in the infrared, where Devore and
    /// Zeidler end and begin at the same wavelength. *Planted*: the seam's end taken for its start.
    #[test]
    fn joined_records_meet_and_show_their_seams() {
        let rutile = NamedMaterial::find("TiO2 rutile").unwrap().index();
        let [lo, hi] = rutile.range_nm();
        assert!(lo < 308.0 && hi > 2500.0, "{lo} to {hi}");
        let seams = rutile.seams_nm();
        assert!(seams.len() == 4 && seams.iter().all(|[a, b]| a <= b), "{seams:?}");
        let ordinary = &rutile.parts[0].1;
        let ends = [0.358013, 0.4].map(|um| ordinary.index(um));
        approx::assert_relative_eq!(ends[0].re, 3.38);
        assert!((ends[1].re - 2.996).abs() < 1e-3 && ends[1].im == 0.0, "{ends:?}");
        let middle = ordinary.index(0.5 * (0.358013 + 0.4));
        assert!((middle - (ends[0] + ends[1]) / 2.0).norm() < 1e-9, "{middle}");
        let [before, after] = [1.53, 1.531].map(|um| ordinary.index(um).re);
        assert!((before - after).abs() < 5e-3, "{before} {after}");
    }

    /// A former name gives the same record under that name.
    #[test]
    fn former_names_are_read() {
        for material in MATERIALS {
            for name in material.names() {
                let found = NamedMaterial::find(&name.to_uppercase()).unwrap();
                assert_eq!(found.name, material.name);
                assert_eq!(found.index_called(name).index(0.55), material.index().index(0.55));
            }
        }
        let count: usize = MATERIALS.iter().map(|material| material.names().count()).sum();
        let all: std::collections::HashSet<_> = MATERIALS.iter().flat_map(NamedMaterial::names).collect();
        assert_eq!(all.len(), count, "a name twice");
    }

    #[test]
    fn every_material_is_physical_over_its_range_and_says_whose_it_is() {
        for material in MATERIALS {
            let index = material.index();
            let [lo, hi] = index.range_nm();
            assert!(lo < 460.0 && hi >= 700.0, "{}: {lo} to {hi} nm", material.name);
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
