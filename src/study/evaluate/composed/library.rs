//! A library of plates: what solved layers are to light from both sides, so that stacks of them in
//! any order are composed without a solve.
//!
//! All plates of a library lie between half-spaces of one index (`stack.composed.joint_index`),
//! and have the same states there: state i of one goes to state i of the next. A layer that was
//! solved as a whole is one plate, one that was cut into slabs has a plate for its front, for an
//! inner slab and for its back; all of them again at half the thickness, which tells the error of
//! composing. Of every portion there are the means over the ensemble and the means that leave out
//! one cell each, so that every composed number has its bar.
//!
//! Numbers of one portion at one wavelength follow one another in this order, with m states in
//! front, n behind and d + 1 known directions (0° and the nodes from which light reaches air):
//!
//! ```text
//! R from in front (m × m), R from behind (n × n), T onward (n × m), T back (m × n), row by row
//! amplitudes [side][0 … d][polarisation][reflected, transmitted], each as real and imaginary part
//! ```

use super::level::{KeptPortion, KeptStates, Level, PortionStates, SolvedPortion};
use crate::appearance::composed::flux::{Coherent, Hemisphere};
use crate::appearance::composed::ordinates::Ordinates;
use crate::appearance::composed::plate::Plate;
use crate::appearance::fluorescence::summed_nm;
use crate::appearance::tristimulus::{Colorimeter, visible};
use crate::appearance::viewing::{Summation, Viewing};
use crate::input::study::{Composed, LayerPlates, Position, Study};
use crate::store::identity::{Key, METHOD_VERSION};
use crate::wave::Wave;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use faer::Mat;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Version of the form that is written, and the newest that is read.
pub const LIBRARY_FORM: u32 = 2;
/// Difference of indices and of directions that is rounding.
const ROUNDING: f64 = 1e-9;
/// Largest whole number that a difference of a replicate is written as.
const FULL_SCALE: f64 = 32_767.0;
/// Illuminants and observers whose weights a library holds.
const ILLUMINANTS: [&str; 6] = ["D65", "D50", "A", "E", "F2", "F11"];
const OBSERVERS: [&str; 2] = ["2", "10"];

/// Solved layers as plates between half-spaces of one index.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Library {
    /// Version of this form of file: 2; files of 1 lack `lights`.
    pub inkwave_library: u32,
    /// Version of the numerical method of all plates.
    pub method: u32,
    /// The program that gathered the plates.
    pub program: String,
    /// The equation that was solved.
    pub wave: Wave,
    /// Vacuum wavelengths of all plates, nm, rising.
    pub wavelengths_nm: Vec<f64>,
    /// The half-spaces between the plates.
    pub joint: JointMedium,
    /// Weights of X, Y and Z of the wavelengths, for colours.
    pub eyes: Vec<LibraryEye>,
    /// Powers of the illuminants, for papers with a brightener.
    #[serde(default)]
    pub lights: Vec<LibraryLight>,
    /// The plates.
    pub plates: Vec<LibraryPlate>,
}

/// The states of light in the half-spaces between the plates: the beam at 0°, then every direction
/// with its polarisations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointMedium {
    /// Real index.
    pub index: f64,
    /// Directions in the zone from which light reaches air, and in each zone beyond.
    pub directions: [usize; 2],
    /// 1 for the scalar wave, 2 for s and p.
    pub polarisations: usize,
    /// Lateral wavenumbers n sin θ of the directions, rising; those of the first zone first.
    pub sines: Vec<f64>,
    /// Étendue of every direction; the sum is the square of the index.
    pub weights: Vec<f64>,
}

/// An illuminant and an observer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryEye {
    /// Name of the illuminant, such as `D65`.
    pub illuminant: String,
    /// Name of the observer: `2` or `10`.
    pub observer: String,
    /// Weights of X, Y and Z for factors at the library's wavelengths; a perfect white has Y = 100.
    pub weights: Vec<[f64; 3]>,
}

/// The power of an illuminant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryLight {
    /// Its name, such as `D65`.
    pub illuminant: String,
    /// Relative powers at the multiples of 5 nm within the library's wavelengths, from 300 nm on.
    pub powers: Vec<f64>,
}

/// A pigment of a plate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlatePigment {
    /// Its name.
    pub name: String,
    /// Its share of the layer's volume.
    pub volume_fraction: f64,
    /// Size of its smallest and of its largest grain, nm.
    pub size_nm: [f64; 2],
    /// Its refractive index: a constant, a built-in spectrum, or the path of a table.
    pub index: String,
}

/// One solved layer.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryPlate {
    /// Its name, which no other plate of the library has.
    pub name: String,
    /// Hash of binder, pigments and packing: plates of one ink at several thicknesses share it.
    pub ink: String,
    /// Index of the binder, or where it is from.
    pub binder: String,
    /// Its pigments.
    pub pigments: Vec<PlatePigment>,
    /// Thickness of the layer, µm; of one slab of a layer that was cut into slabs.
    pub thickness_um: f64,
    /// Whether it was cut into slabs: then any thickness from two slabs on follows from it.
    pub slabs: bool,
    /// Hash of the study that it was solved for.
    pub study: String,
    /// Title of that study.
    pub title: String,
    /// At every wavelength: real index of the even medium that its mean wave is compared with.
    pub within: Vec<f64>,
    /// The portions that it is made of.
    pub portions: Vec<LibraryPortion>,
}

/// One portion of a plate.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryPortion {
    /// Where it lies: `whole`, or `front`, `inner` and `back` of slabs.
    pub position: Position,
    /// Whether it has half the thickness, for the error of composing.
    pub halved: bool,
    /// Thickness, µm.
    pub thickness_um: f64,
    /// Error of R and T that is expected from the grid.
    pub grid_error: f64,
    /// Its numbers at every wavelength.
    pub states: Vec<LibraryStates>,
}

/// A portion at one wavelength.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryStates {
    /// Real indices of the half-spaces in front and behind.
    pub between: [f64; 2],
    /// Number of states in front and behind.
    pub states: [usize; 2],
    /// The means over all cells: base64 of 64-bit floats, the least significant byte first.
    pub mean: String,
    /// The means that leave out one cell each, in the order of the cells.
    pub replicates: Vec<LibraryReplicate>,
}

/// What a mean that leaves out one cell differs by from that over all.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryReplicate {
    /// Unit of the differences.
    pub unit: f64,
    /// The differences: base64 of signed 16-bit whole numbers, the least significant byte first.
    pub differences: String,
}

impl JointMedium {
    /// The states.
    pub fn hemisphere(&self) -> Hemisphere {
        self.medium(self.index)
    }

    /// States of another medium whose zones are those of the joint as far as it has them.
    pub(super) fn medium(&self, index: f64) -> Hemisphere {
        let ordinates = Ordinates::new(index, &[self.index], self.directions);
        Hemisphere { ordinates, polarisations: self.polarisations, oblique_deg: None }
    }
}

impl Library {
    /// The plates of a finished stack that was solved between half-spaces of one index.
    ///
    /// # Errors
    /// A study of another kind, layers without complete realisations, other media around the stack.
    pub fn of_stack(study: &Study, solved: &[SolvedPortion], program: &str) -> Result<Self, String> {
        let composed = study.composed().ok_or(NO_STATES)?;
        let index = composed.joint_index.ok_or(NO_STATES)?;
        let joint = joint_of(study, composed, index)?;
        let level =
            |halved| Level::new(solved, halved).ok_or("not every layer has a complete realisation yet");
        let portions = [level(false)?.kept(), level(true)?.kept()];
        let mut plates = Vec::new();
        for (layer, kind) in composed.layers.iter().enumerate() {
            let slabs = match kind {
                LayerPlates::Clear => continue,
                LayerPlates::Whole => None,
                LayerPlates::Slabs(um) => Some(*um),
            };
            plates.push(plate_of(study, layer, slabs, &portions, &joint));
        }
        Ok(Self {
            inkwave_library: LIBRARY_FORM,
            method: METHOD_VERSION,
            program: program.to_owned(),
            wave: study.wave,
            wavelengths_nm: study.wavelengths_nm.clone(),
            eyes: eyes(&study.wavelengths_nm),
            lights: lights(&study.wavelengths_nm),
            joint,
            plates,
        })
    }

    /// Reads a library.
    ///
    /// # Errors
    /// No library, one of a newer form or of another method, or plates whose numbers do not fit.
    pub fn read(text: &str) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct Head {
            inkwave_library: u32,
        }
        let head: Head = serde_json::from_str(text).map_err(|error| {
            format!("found no library ({error}); allowed is a file that `inkwave library` has written")
        })?;
        if head.inkwave_library > LIBRARY_FORM {
            return Err(format!(
                "inkwave_library: found form {}; allowed up to {LIBRARY_FORM}: read it with a newer program, or \
                 gather its folders again with this one",
                head.inkwave_library
            ));
        }
        let library: Self = serde_json::from_str(text).map_err(|error| error.to_string())?;
        if library.method != METHOD_VERSION {
            return Err(format!(
                "method: found {}; allowed {METHOD_VERSION}, that of this program: solve its layers again",
                library.method
            ));
        }
        library.check()?;
        Ok(Self { inkwave_library: LIBRARY_FORM, lights: lights(&library.wavelengths_nm), ..library })
    }

    /// Every number is there and finite.
    fn check(&self) -> Result<(), String> {
        let own = self.joint.hemisphere();
        let apart = |a: &[f64], b: &[f64]| {
            a.len() != b.len() || a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e3 * ROUNDING)
        };
        if apart(&own.ordinates.sines, &self.joint.sines)
            || apart(&own.ordinates.weights, &self.joint.weights)
        {
            return Err(
                "joint: found other directions than those of its index; gather the library again".to_owned()
            );
        }
        for (number, plate) in self.plates.iter().enumerate() {
            if self.plates[..number].iter().any(|other| other.name == plate.name) {
                return Err(format!(
                    "plates: found two of the name {:?}; allowed are different names",
                    plate.name
                ));
            }
            for halved in [false, true] {
                let kept = self.portions_of(number, halved)?;
                if kept.is_empty() || plate.within.len() != self.wavelengths_nm.len() {
                    return Err(format!(
                        "plate {:?}: lacks portions or wavelengths; gather it again",
                        plate.name
                    ));
                }
            }
        }
        Ok(())
    }

    /// Adds the plates of another library; equal ones are there once.
    ///
    /// # Errors
    /// Other wavelengths, methods, waves, half-spaces or directions, and different plates of one
    /// name.
    pub fn merge(&mut self, other: Self) -> Result<(), String> {
        let differs = |what: &str, found: &str, allowed: &str, remedy: &str| {
            Err(format!("{what}: found {found}; allowed {allowed}, as the library has: {remedy}"))
        };
        let again = "solve the layers again as the others";
        if self.method != other.method {
            return differs("method", &other.method.to_string(), &self.method.to_string(), again);
        }
        if self.wave != other.wave {
            return differs("wave", other.wave.in_words(), self.wave.in_words(), again);
        }
        if self.wavelengths_nm != other.wavelengths_nm {
            let found = format!("{:?} nm", other.wavelengths_nm);
            return differs("wavelengths_nm", &found, &format!("{:?} nm", self.wavelengths_nm), again);
        }
        if (self.joint.index - other.joint.index).abs() > ROUNDING {
            let found = other.joint.index.to_string();
            return differs("joint index", &found, &self.joint.index.to_string(), again);
        }
        if self.joint.directions != other.joint.directions {
            let found = format!("{:?} directions", other.joint.directions);
            return differs("joint", &found, &format!("{:?}", self.joint.directions), again);
        }
        for plate in other.plates {
            match self.plates.iter().find(|own| own.name == plate.name) {
                None => self.plates.push(plate),
                Some(own) if own.is_same(&plate) => {}
                Some(_) => {
                    let words = "found different plates of this name; allowed is one: rename the layer in one of the studies";
                    return Err(format!("plate {:?}: {words}", plate.name));
                }
            }
        }
        Ok(())
    }

    /// Number of a plate; an error that names those there are.
    ///
    /// # Errors
    /// A name that no plate has.
    pub fn plate(&self, name: &str) -> Result<usize, String> {
        self.plates.iter().position(|plate| plate.name == name).ok_or_else(|| {
            let all: Vec<&str> = self.plates.iter().map(|plate| plate.name.as_str()).collect();
            format!("plate: found {name:?}; allowed are {}", all.join(", "))
        })
    }

    /// What is kept of a plate, of one of the thicknesses.
    pub(super) fn portions_of(&self, number: usize, halved: bool) -> Result<Vec<KeptPortion>, String> {
        let plate = &self.plates[number];
        let own = plate.portions.iter().filter(|portion| portion.halved == halved);
        let kept = |portion: &LibraryPortion| -> Result<KeptPortion, String> {
            let states =
                portion.states.iter().map(|states| self.unpacked(states)).collect::<Option<Vec<_>>>();
            let states = states.filter(|all| all.len() == self.wavelengths_nm.len());
            let states = states.ok_or_else(|| {
                format!("plate {:?}: its numbers are incomplete or not finite; gather it again", plate.name)
            })?;
            Ok(KeptPortion {
                layer: number,
                position: portion.position,
                slab_um: portion.thickness_um,
                grid_error: portion.grid_error,
                states,
            })
        };
        own.map(kept).collect()
    }

    fn unpacked(&self, packed: &LibraryStates) -> Option<KeptStates> {
        let [before, behind] = packed.between;
        let media = [self.joint.medium(before), self.joint.medium(behind)];
        if media[0].states() != packed.states[0] || media[1].states() != packed.states[1] {
            return None;
        }
        let mean = floats(&packed.mean)?;
        let known = self.known_directions();
        let replicate = |replicate: &LibraryReplicate| {
            let differences = whole_numbers(&replicate.differences)?;
            let same = differences.len() == mean.len();
            let moved: Vec<f64> =
                mean.iter().zip(&differences).map(|(x, d)| x + replicate.unit * f64::from(*d)).collect();
            same.then(|| states_of(&moved, &media, known))?
        };
        let replicates = packed.replicates.iter().map(replicate).collect::<Option<Vec<_>>>()?;
        Some(KeptStates { mean: states_of(&mean, &media, known)?, media, replicates })
    }

    /// Directions whose amplitudes are kept: 0° and the nodes from which light reaches air.
    fn known_directions(&self) -> usize {
        1 + self.joint.directions[0]
    }
}

/// Why a study is no library study, and what to do.
const NO_STATES: &str = "its layers were not solved between half-spaces of one index, so that no plates of them join any others: \
     write the layers as [[layer]] with [stack.composed] joint_index = 1.5 (or that of their binders), and run it again";

impl LibraryPlate {
    fn is_same(&self, other: &Self) -> bool {
        let numbers = |plate: &Self| -> Vec<String> {
            plate.portions.iter().flat_map(|p| p.states.iter().map(|s| s.mean.clone())).collect()
        };
        self.ink == other.ink && self.thickness_um == other.thickness_um && numbers(self) == numbers(other)
    }

    /// How many slabs a thickness takes, or 1 of a whole layer.
    ///
    /// # Errors
    /// A thickness that was not solved, and of slabs one of less than two.
    pub fn count(&self, thickness_um: Option<f64>) -> Result<f64, String> {
        let own_um = self.thickness_um;
        let name = &self.name;
        match thickness_um {
            None => Ok(if self.slabs { 2.0 } else { 1.0 }),
            Some(um) if !self.slabs => {
                let is_own = (um - own_um).abs() <= 1e-6 * own_um;
                let words = format!(
                    "thickness_um: found {um} µm of {name:?}; allowed {own_um}, as which it was solved whole: take another plate of \
                     the ink, or solve it in slabs"
                );
                is_own.then_some(1.0).ok_or(words)
            }
            Some(um) => {
                let count = um / own_um;
                let whole = if (count - count.round()).abs() < 1e-9 * count { count.round() } else { count };
                let words = format!(
                    "thickness_um: found {um} µm of {name:?}; allowed from {} µm, two slabs, to {} µm",
                    2.0 * own_um,
                    MOST_SLABS * own_um
                );
                (2.0..=MOST_SLABS).contains(&whole).then_some(whole).ok_or(words)
            }
        }
    }
}

/// Most slabs of a layer.
const MOST_SLABS: f64 = 4096.0;

/// The half-spaces of a study's stack.
fn joint_of(study: &Study, composed: &Composed, index: f64) -> Result<JointMedium, String> {
    for outer in [study.layer.index_in, study.layer.index_out] {
        if (outer - 1.0).abs() > ROUNDING && (outer - index).abs() > ROUNDING {
            return Err(format!(
                "stack.index_out: found {outer} around plates of joint_index {index}, which limits their directions; allowed are 1 \
                 and {index}"
            ));
        }
    }
    let polarisations = if study.wave.is_vector() { 2 } else { 1 };
    let directions = composed.directions;
    let ordinates = Ordinates::new(index, &[index], directions);
    Ok(JointMedium { index, directions, polarisations, sines: ordinates.sines, weights: ordinates.weights })
}

fn plate_of(
    study: &Study,
    layer: usize,
    slabs: Option<f64>,
    portions: &[Vec<KeptPortion>; 2],
    joint: &JointMedium,
) -> LibraryPlate {
    let own = study.of_layer(layer);
    let pigments = own.pigments.iter().map(|pigment| PlatePigment {
        name: pigment.name.clone(),
        volume_fraction: pigment.grains.volume_fraction,
        size_nm: [pigment.grains.size.smallest_nm(), pigment.grains.size.largest_nm()],
        index: pigment.material.source.clone(),
    });
    // names are no part of an ink: pigments of two layers have different ones
    let materials: Vec<_> = own.pigments.iter().map(|p| (&p.grains, &p.material, &p.shell)).collect();
    let packing = crate::ink::PackingRequest { seed: 0, thickness_um: 0.0, ..own.packing.clone() };
    let mut packed = Vec::new();
    for (halved, all) in [(false, &portions[0]), (true, &portions[1])] {
        for portion in all.iter().filter(|portion| portion.layer == layer) {
            packed.push(LibraryPortion {
                position: portion.position,
                halved,
                thickness_um: portion.slab_um,
                grid_error: portion.grid_error,
                states: portion.states.iter().map(|states| packed_states(states, joint)).collect(),
            });
        }
    }
    LibraryPlate {
        name: study.stack[layer].name.clone(),
        ink: Key::of("ink", &(&own.layer.binder, materials, &packing)).short().to_owned(),
        binder: own.layer.binder.source.clone(),
        pigments: pigments.collect(),
        thickness_um: slabs.unwrap_or(study.stack[layer].thickness_um),
        slabs: slabs.is_some(),
        study: study.key().as_str().to_owned(),
        title: study.title.clone(),
        within: study.wavelengths_nm.iter().map(|nm| own.embedding_index(1e-3 * nm)).collect(),
        portions: packed,
    }
}

/// The weights of wavelengths for the usual conditions; none where they carry no colour.
fn eyes(wavelengths_nm: &[f64]) -> Vec<LibraryEye> {
    let seen = visible(wavelengths_nm);
    let mut all = Vec::new();
    for illuminant in ILLUMINANTS {
        for observer in OBSERVERS {
            let viewing = Viewing::new(illuminant, observer, Summation::Plain);
            let eye = viewing.and_then(|viewing| Colorimeter::under(&wavelengths_nm[seen.clone()], &viewing));
            let Ok(eye) = eye else { continue };
            let weight = |w: usize| {
                let only: Vec<f64> = seen.clone().map(|k| f64::from(u8::from(k == w))).collect();
                eye.xyz(&only).unwrap_or_default()
            };
            let weights = (0..wavelengths_nm.len()).map(weight).collect();
            all.push(LibraryEye {
                illuminant: illuminant.to_owned(),
                observer: observer.to_owned(),
                weights,
            });
        }
    }
    all
}

/// The powers of the usual illuminants at the wavelengths at which excitation is summed.
fn lights(wavelengths_nm: &[f64]) -> Vec<LibraryLight> {
    let (Some(&from_nm), Some(&to_nm)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
        return Vec::new();
    };
    let nm = summed_nm(from_nm, to_nm);
    let light = |illuminant: &str| {
        let viewing = Viewing::new(illuminant, OBSERVERS[0], Summation::Plain).ok()?;
        let powers = nm.iter().map(|&nm| viewing.power(nm)).collect();
        Some(LibraryLight { illuminant: illuminant.to_owned(), powers })
    };
    ILLUMINANTS.into_iter().filter_map(light).collect()
}

/// The numbers of one portion in a row.
fn listed(states: &PortionStates, known: usize) -> Vec<f64> {
    let mut all = Vec::new();
    let matrices = states.plate.reflection.iter().chain(&states.plate.transmission);
    for matrix in matrices {
        for i in 0..matrix.nrows() {
            all.extend((0..matrix.ncols()).map(|j| matrix[(i, j)]));
        }
    }
    for side in &states.coherent {
        for lobes in side[..known].iter().flatten() {
            all.extend(lobes.iter().flat_map(|amplitude| [amplitude.re, amplitude.im]));
        }
    }
    all
}

/// The other way round; `None` for another number of numbers, or for some that are not finite.
fn states_of(numbers: &[f64], media: &[Hemisphere; 2], known: usize) -> Option<PortionStates> {
    let [m, n] = [media[0].states(), media[1].states()];
    let polarisations = media[0].polarisations;
    let whole = m * m + n * n + 2 * m * n + 2 * known * polarisations * 4;
    if numbers.len() != whole || !numbers.iter().all(|x| x.is_finite()) {
        return None;
    }
    let matrix = |from: usize, rows: usize, columns: usize| {
        Mat::from_fn(rows, columns, |i, j| numbers[from + i * columns + j])
    };
    let onward = m * m + n * n;
    let plate = Plate {
        reflection: [matrix(0, m, m), matrix(m * m, n, n)],
        transmission: [matrix(onward, n, m), matrix(onward + m * n, m, n)],
    };
    let first = onward + 2 * m * n;
    let amplitude = |place: usize| Complex64::new(numbers[first + 2 * place], numbers[first + 2 * place + 1]);
    let side = |side: usize| {
        let direction = |d: usize| {
            let lobes = |p: usize| {
                let place = ((side * known + d) * polarisations + p) * 2;
                [amplitude(place), amplitude(place + 1)]
            };
            (0..polarisations).map(lobes).collect()
        };
        (0..known).map(direction).collect()
    };
    let coherent: Coherent = [side(0), side(1)];
    Some(PortionStates { plate, coherent })
}

fn packed_states(kept: &KeptStates, joint: &JointMedium) -> LibraryStates {
    let known = 1 + joint.directions[0];
    let mean = listed(&kept.mean, known);
    let replicate = |states: &PortionStates| {
        let differences: Vec<f64> = listed(states, known).iter().zip(&mean).map(|(a, b)| a - b).collect();
        let largest = differences.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let unit = if largest > 0.0 { largest / FULL_SCALE } else { 1.0 };
        let bytes: Vec<u8> =
            differences.iter().flat_map(|x| ((x / unit).round() as i16).to_le_bytes()).collect();
        LibraryReplicate { unit, differences: STANDARD.encode(bytes) }
    };
    let bytes: Vec<u8> = mean.iter().flat_map(|x| x.to_le_bytes()).collect();
    LibraryStates {
        between: [kept.media[0].ordinates.index, kept.media[1].ordinates.index],
        states: [kept.media[0].states(), kept.media[1].states()],
        mean: STANDARD.encode(bytes),
        replicates: kept.replicates.iter().map(replicate).collect(),
    }
}

fn floats(text: &str) -> Option<Vec<f64>> {
    let bytes = STANDARD.decode(text).ok()?;
    let (whole, rest) = bytes.as_chunks::<8>();
    rest.is_empty().then(|| whole.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
}

fn whole_numbers(text: &str) -> Option<Vec<i16>> {
    let bytes = STANDARD.decode(text).ok()?;
    let (whole, rest) = bytes.as_chunks::<2>();
    rest.is_empty().then(|| whole.iter().map(|bytes| i16::from_le_bytes(*bytes)).collect())
}
