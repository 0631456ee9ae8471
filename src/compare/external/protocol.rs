//! What inkwave asks a program, and what it may answer: one JSON text each; and what a program says
//! of itself when it is started with `--describe`.

use crate::input::case::Case;
use crate::input::case_inputs::CaseInputs;
use crate::input::wave_kind::WaveKind;
use crate::report::cell::plain;
use crate::wave::BodyShape;
use num_complex::Complex64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The question, on the program's standard input.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ProgramRequest {
    /// A word for this case, which the answer may repeat.
    pub case: String,
    /// The case, with the keys of a case file of `inkwave solve`: µm, degrees, time factor e^(−iωt).
    #[schemars(with = "CaseInputs")]
    pub inputs: Value,
    /// The wave to solve.
    pub wave: WaveKind,
    /// The value of the program's own knob for accuracy; null where it has none.
    pub knob: Option<f64>,
    /// Wall time after which the program is killed, s.
    pub time_limit_s: f64,
    /// Memory beyond which the program is killed, GB.
    pub memory_gb: f64,
}

/// The answer, on the program's standard output: all orders that propagate, or a refusal.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct Answer {
    /// Amplitudes of the orders, for an incident wave of amplitude 1 at x = y = 0 of the face that
    /// it enters by.
    #[serde(default)]
    pub orders: Option<Vec<AnsweredOrder>>,
    /// Why the program does not solve this case.
    #[serde(default)]
    pub refusal: Option<String>,
    /// The question's word for its case: an answer to another case is not taken.
    #[serde(default)]
    pub case: Option<String>,
    /// What the program itself measured of its solve, without its start, s.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub seconds: Option<f64>,
}

/// One order on one side.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
pub struct AnsweredOrder {
    /// Order along x, counted from the specular direction: kx = qx + 2πm/Lx.
    pub m: i32,
    /// Order along y.
    #[serde(default)]
    pub n: i32,
    /// Where it leaves the layer.
    pub side: AnsweredSide,
    /// Complex amplitude at x = y = 0 of the face by which it leaves.
    pub amplitude: AnsweredAmplitude,
}

/// The amplitude of an order: [re, im] of the scalar wave, of the vector wave one for each pair of
/// polarisations.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "[re, im], or by incident, then by outgoing polarisation")]
pub enum AnsweredAmplitude {
    /// Of the scalar wave.
    Scalar([f64; 2]),
    /// Of the vector wave.
    Vector {
        /// For incident s light.
        s: OutgoingAmplitudes,
        /// For incident p light.
        p: OutgoingAmplitudes,
    },
}

/// Amplitudes [re, im] of both outgoing polarisations.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
pub struct OutgoingAmplitudes {
    /// E perpendicular to the plane of the order's direction and the normal, along ẑ × k∥.
    pub s: [f64; 2],
    /// E in that plane; H is along ẑ × k∥.
    pub p: [f64; 2],
}

/// Where an order leaves the layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AnsweredSide {
    /// On the side that the light comes from.
    Reflected,
    /// On the other side.
    Transmitted,
}

/// The description of a program; whatever it leaves out is left to its answers.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(default)]
pub struct ProgramDescription {
    /// Name and version of the program behind the adapter.
    #[schemars(example = &"treams 0.4.7")]
    pub program: String,
    /// Waves that it solves; any where none are listed.
    pub waves: Vec<WaveKind>,
    /// Shapes that it solves; any where none are listed.
    pub shapes: Vec<ShapeKind>,
    /// Media that it solves; any where none are listed.
    pub media: Vec<MediumKind>,
    /// Meaning of its knob.
    #[schemars(example = &"largest multipole")]
    pub knob: String,
    /// Its own conventions, from which the adapter converts.
    #[schemars(example = &"time factor exp(-iwt), parity basis")]
    pub conventions: String,
}

/// A shape of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ShapeKind {
    /// Homogeneous films.
    Films,
    /// Bars along y.
    Bars,
    /// Cylinders along y.
    Cylinders,
    /// Spheres.
    Spheres,
    /// Convex bodies: ellipsoids, boxes, discs and prisms.
    Bodies,
    /// Spheres inside others, whose material they displace.
    NestedSpheres,
}

/// A medium of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MediumKind {
    /// Im η = 0 in the layer.
    Clear,
    /// Im η > 0 in the layer.
    Absorbing,
    /// Re η² < 0 in the layer.
    Metals,
    /// A half-space of another index than 1.
    HalfSpaces,
}

/// Characters of what a program says in words.
const SAID: usize = 240;

/// The beginning of a text, without what a terminal would act upon.
pub(super) fn quoted(text: &str) -> String {
    plain(text).chars().take(SAID).collect()
}

impl ProgramDescription {
    /// The description in a program's output; none where it is something else.
    pub(super) fn of(output: &[u8]) -> Option<ProgramDescription> {
        let mut read: ProgramDescription = serde_json::from_slice(output).ok()?;
        for text in [&mut read.program, &mut read.knob, &mut read.conventions] {
            *text = quoted(text);
        }
        Some(read)
    }

    /// Why a case is not asked of this program, where it says that it cannot solve it.
    pub fn refusal(&self, case: &Case, wave: WaveKind) -> Option<String> {
        let lacks = |what: String| Some(format!("not asked: it describes itself as without {what}"));
        if !self.waves.is_empty() && !self.waves.contains(&wave) {
            return lacks(format!("the {} wave", wave.name()));
        }
        let shape = shapes(case).into_iter().find(|s| !self.shapes.is_empty() && !self.shapes.contains(s));
        let medium = media(case).into_iter().find(|m| !self.media.is_empty() && !self.media.contains(m));
        let shape = shape.map(|shape| format!("{shape:?}").to_lowercase());
        shape.or(medium.map(|medium| medium.in_words().to_owned())).and_then(lacks)
    }
}

impl MediumKind {
    fn in_words(self) -> &'static str {
        match self {
            Self::Clear => "clear media",
            Self::Absorbing => "absorbing media",
            Self::Metals => "metals",
            Self::HalfSpaces => "half-spaces other than vacuum",
        }
    }
}

/// The shapes of a case; what else the body of a study may be is refused before.
fn shapes(case: &Case) -> Vec<ShapeKind> {
    let kind = |shape: &BodyShape| match shape {
        BodyShape::CylinderY { .. } => ShapeKind::Cylinders,
        BodyShape::BarY { .. } => ShapeKind::Bars,
        BodyShape::Sheet { .. } => ShapeKind::Films,
        BodyShape::Solid(_) => ShapeKind::Bodies,
        BodyShape::Balls(_) | BodyShape::Open { .. } => ShapeKind::Spheres,
    };
    let bodies = case.scene.bodies.iter();
    let bodies = bodies.map(|body| body.within.map_or(kind(&body.shape), |_| ShapeKind::NestedSpheres));
    bodies.chain(case.scene.bodies.is_empty().then_some(ShapeKind::Films)).collect()
}

fn media(case: &Case) -> Vec<MediumKind> {
    let media = &case.media;
    let layer = || media.backgrounds.iter().chain(&media.inclusions);
    let has = |test: fn(&Complex64) -> bool| layer().any(test);
    let kinds = [
        (MediumKind::Metals, has(|eta| (eta * eta).re < 0.0)),
        (MediumKind::Absorbing, has(|eta| eta.im > 0.0)),
        (MediumKind::Clear, layer().all(|eta| eta.im == 0.0)),
        (MediumKind::HalfSpaces, [media.incident, media.exit].iter().any(|eta| *eta != Complex64::ONE)),
    ];
    kinds.into_iter().filter(|(_, has)| *has).map(|(kind, _)| kind).collect()
}
