//! A library of plates: what solved layers are to light from both sides, so that stacks of them in
//! any order are composed without a solve.
//!
//! All plates of a library lie between half-spaces of one index (`stack.composed.joint_index`),
//! and have the same states there: state i of one goes to state i of the next. A layer that was
//! solved as a whole is one plate, one that was cut into slabs has a plate for its front, for an
//! inner slab and for its back; all of them again at half the thickness, which tells the error of
//! composing. Of every portion there are the means over the ensemble and the means that leave out
//! one cell each, so that every composed number has its bar.

mod encoding;
mod gathering;

use super::level::KeptPortion;
use crate::appearance::composed::flux::Hemisphere;
use crate::appearance::composed::ordinates::Ordinates;
use crate::input::study::Position;
use crate::numerics::allowed::brief;
use crate::store::identity::METHOD_VERSION;
use crate::wave::Wave;
use gathering::lights;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Version of the form that is written, and the newest that is read.
pub const LIBRARY_FORM: u32 = 5;
/// Difference of indices and of directions that is rounding.
const ROUNDING: f64 = 1e-9;

/// Solved layers as plates between half-spaces of one index.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Library {
    /// Version of this form of file: 4; 1 lacks `lights`, 2 amplitudes of light turned back by air,
    /// 3 `seen_powers`, `emitted` and slabs whose mean index is below that of the joints.
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
    /// Under a lamp with lines, the weights of what the paper emits over `seen_powers`; none under
    /// smooth light, of which all parts of factors weigh the same.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub emitted: Vec<[f64; 3]>,
}

/// The power of an illuminant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryLight {
    /// Its name, such as `D65`.
    pub illuminant: String,
    /// Relative powers at the multiples of 5 nm within the library's wavelengths, from 300 nm on;
    /// of a lamp with lines the means of the light about each of them.
    pub powers: Vec<f64>,
    /// Those of a lamp with lines at the library's wavelengths, for the light that each stands for;
    /// none of smooth lights, whose `powers` are linear in between.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub seen_powers: Vec<f64>,
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
    /// At every wavelength: imaginary part of that medium's permittivity, which absorbs; forms
    /// before 5 have none.
    #[serde(default)]
    pub loss: Vec<f64>,
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
                let wavelengths = self.wavelengths_nm.len();
                if kept.is_empty() || [plate.within.len(), plate.loss.len()] != [wavelengths; 2] {
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
        let media = plate.within.iter().zip(&plate.loss);
        let permittivities: Vec<_> =
            media.map(|(index, loss)| Complex64::new(index * index, *loss)).collect();
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
                permittivities: permittivities.clone(),
                states,
            })
        };
        own.map(kept).collect()
    }
}

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
        let [shown_um, least_um, most_um] = [own_um, 2.0 * own_um, MOST_SLABS * own_um].map(brief);
        match thickness_um {
            None => Ok(if self.slabs { 2.0 } else { 1.0 }),
            Some(um) if !self.slabs => {
                let is_own = (um - own_um).abs() <= 1e-6 * own_um;
                let words = format!(
                    "thickness_um: found {um} µm of {name:?}; allowed {shown_um}, as which it was solved whole: take another plate of \
                     the ink, or solve it in slabs"
                );
                is_own.then_some(1.0).ok_or(words)
            }
            Some(um) => {
                let count = um / own_um;
                let whole = if (count - count.round()).abs() < 1e-9 * count { count.round() } else { count };
                let words = format!(
                    "thickness_um: found {um} µm of {name:?}; allowed from {least_um} µm, two slabs, to {most_um} µm"
                );
                (2.0..=MOST_SLABS).contains(&whole).then_some(whole).ok_or(words)
            }
        }
    }
}

/// Most slabs of a layer.
const MOST_SLABS: f64 = 4096.0;
