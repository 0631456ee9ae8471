//! One sphere's angular distribution: every propagating order of a sparse array, reflected ones too, against Mie.
//!
//! Spheres at the points of a square lattice of side L, each scattering F(k_o ← k_i) e^{ikr}/r, send into the order of wavevector
//! k_o = (k_∥, ±κ) the plane wave 2πi F/(κ L²), with the phase from the sphere's centre (Weyl's integral). What is left are waves
//! between the spheres: they run sideways, F₁ = max |F(sideways ← k_i)|, and are scattered once more, F₂ = max |F(k_o ← sideways)|, so
//! they add F₁F₂ times the lattice sum of claim 9, 3.900/L, whose phase turns with L: differences are averaged over sides.

use super::dilute::{PLACE, Single, array, cases};
use crate::claim::{Claim, Findings, Level};
use crate::formulas::mie::{Mie, Sphere};
use crate::vector::{far_fields, pairs};
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::maxwell::{Averaging, NormalMoments, Polarisation, VectorProblem};
use inkwave::wave::{Incidence, Mean, Problem, Resolution, Scheme, Side};
use num_complex::Complex64;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The scalar wave.
pub const SCALAR: Claim = Claim {
    id: "21-sphere-directions",
    statement: "A sphere alone scatters into every direction, backwards too, as in scalar Mie theory.",
    because: "Each order of a sparse array is 2πi f(θ)/(κ L²) (Weyl's integral); Mie's series is checked against 40 digits.",
    file: file!(),
    measure: scalar,
};

/// Maxwell's equations.
pub const VECTOR: Claim = Claim {
    id: "22-vector-sphere",
    statement: "Maxwell's equations: a sphere alone scatters s and p light into every direction and polarisation as in Mie's theory.",
    because: "Each order of a sparse array is 2πi F/(κ L²), F = (i/k)(S₁ along the scattering plane's normal, S₂ in the plane); Bohren and Huffman's series, checked against their printed example.",
    file: file!(),
    measure: vector,
};

const POLAR_DEG: f64 = 20.0;
const AZIMUTH_DEG: f64 = 20.0;
type Vector = [f64; 3];
/// Order (m, n), reflected, and polarisations in and out (0 in the scalar wave).
type Label = (i32, i32, bool, [usize; 2]);

/// One amplitude of an order as Mie has it and as the array shows it.
struct Amplitude {
    label: Label,
    expected: Complex64,
    found: Complex64,
}

fn dot(a: Vector, b: Vector) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The array of one side, seen from one order.
struct View<'a> {
    mie: &'a Mie,
    side: f64,
    height: f64,
    /// Unit vector of the incident wave.
    incident: Vector,
}

impl View<'_> {
    fn new(mie: &Mie, side: f64, height: f64) -> View<'_> {
        let (sine, cosine) = POLAR_DEG.to_radians().sin_cos();
        let azimuth = AZIMUTH_DEG.to_radians();
        View { mie, side, height, incident: [sine * azimuth.cos(), sine * azimuth.sin(), cosine] }
    }

    /// Unit vector of an order with lateral wavevector k0 (α, β); none of evanescent ones.
    fn outgoing(&self, [x, y]: [f64; 2], k0: f64, reflected: bool) -> Option<Vector> {
        let x = x * k0 / self.mie.k;
        let y = y * k0 / self.mie.k;
        let square = 1.0 - x * x - y * y;
        (square > 0.0).then(|| [x, y, if reflected { -square.sqrt() } else { square.sqrt() }])
    }

    /// F from an order's amplitude, the incident wave taken off where it is one with the order.
    fn scattered(&self, amplitude: Complex64, out: Vector, incident_too: bool) -> Complex64 {
        let k = self.mie.k;
        let away = 0.5 * self.height;
        let straight = Complex64::cis(k * self.incident[2] * self.height);
        let wave = if incident_too { amplitude - straight } else { amplitude };
        let lateral = (0..2).map(|i| (self.incident[i] - out[i]) * PLACE[i]).sum::<f64>() * self.side;
        let phase = k * (lateral + (self.incident[2] + out[2].abs()) * away);
        wave * Complex64::cis(-phase) * (k * out[2].abs() * self.side * self.side) / (TAU * Complex64::I)
    }
}

/// e_s and e_p of a direction: s = ẑ × p̂, P = (±κ p̂ − q ẑ)/k; p̂ = (cos φ, sin φ) of the incident azimuth where q = 0.
fn basis(direction: Vector) -> [Vector; 2] {
    let [x, y, z] = direction;
    let q = x.hypot(y);
    let azimuth = AZIMUTH_DEG.to_radians();
    let [px, py] = if q < 1e-12 { [azimuth.cos(), azimuth.sin()] } else { [x / q, y / q] };
    [[-py, px, 0.0], [z * px, z * py, -q]]
}

/// F of one pair of polarisations: S₁ for E along the normal of the scattering plane, S₂ for E in it.
fn dyadic(mie: &Mie, from: Vector, to: Vector, [input, output]: [usize; 2]) -> Complex64 {
    let [s1, s2] = mie.amplitudes(dot(from, to));
    let across = cross(from, to);
    let length = dot(across, across).sqrt();
    // Straight on and back every plane is one.
    let normal = if length < 1e-9 { basis(from)[0] } else { across.map(|x| x / length) };
    let e_in = basis(from)[input];
    let e_out = basis(to)[output];
    let along = dot(cross(from, normal), e_in) * dot(cross(to, normal), e_out);
    let through = dot(normal, e_in) * dot(normal, e_out);
    Complex64::I / mie.k * (s2 * along + s1 * through)
}

fn incidence(sphere: &Sphere) -> Incidence {
    let wavelength_um = sphere.wavelength_um;
    let from = Side::Incident;
    Incidence { wavelength_um, polar_deg: POLAR_DEG, azimuth_deg: AZIMUTH_DEG, from }
}

const GOAL: Goal = Goal { tolerance: 1e-8, max_applications: 1000 };

fn scalar_orders(single: &Single, mie: &Mie, side: f64) -> Vec<Amplitude> {
    let (scene, media, resolution) = array(&single.sphere, side);
    let incidence = incidence(&single.sphere);
    let problem =
        Problem::from_scene(&scene, &media, &incidence, resolution, Mean::default()).expect("problem");
    let solution = Gmres::default().solve(&problem, GOAL, &mut Silent).expect("converges");
    let view = View::new(mie, side, scene.thickness_um());
    let k0 = TAU / single.sphere.wavelength_um;
    let mut all = Vec::new();
    for order in problem.far_field(&solution.field).orders {
        for (reflected, amplitude) in [(true, order.reflected), (false, order.transmitted)] {
            let Some(out) = view.outgoing(order.direction, k0, reflected) else { continue };
            let incident_too = !reflected && (order.m, order.n) == (0, 0);
            let found = view.scattered(amplitude, out, incident_too);
            let expected = mie.scalar(dot(view.incident, out));
            all.push(Amplitude { label: (order.m, order.n, reflected, [0, 0]), expected, found });
        }
    }
    all
}

fn vector_orders(single: &Single, mie: &Mie, side: f64) -> Vec<Amplitude> {
    let (scene, media, scalar) = array(&single.sphere, side);
    // Two Gauss planes a cell for three, and odd numbers of points, which the tensor wants.
    let points = scalar.nx | 1;
    let cells = scalar.cells * 3 / 2;
    let resolution = Resolution { nx: points, ny: points, cells, scheme: Scheme::Quadratic };
    let moments = Arc::new(NormalMoments::new(&scene, resolution).expect("moments"));
    let incidence = incidence(&single.sphere);
    let problem = VectorProblem::new(&moments, &media, &incidence, Mean::default(), Averaging::Normal);
    let problem = problem.expect("problem");
    let fields = Polarisation::BOTH
        .map(|p| Gmres::default().solve(&problem.polarised(p), GOAL, &mut Silent).expect("converges").field);
    let view = View::new(mie, side, scene.thickness_um());
    let k0 = TAU / single.sphere.wavelength_um;
    let mut all = Vec::new();
    let [s, p] = far_fields(&problem, &fields);
    for (order, other) in s.orders.iter().zip(&p.orders) {
        for (reflected, amplitudes) in [true, false].into_iter().zip(pairs([order, other])) {
            let Some(out) = view.outgoing(order.direction, k0, reflected) else { continue };
            for pair in [[0, 0], [0, 1], [1, 0], [1, 1]] {
                let straight = !reflected && (order.m, order.n) == (0, 0) && pair[0] == pair[1];
                let found = view.scattered(amplitudes[pair[0]][pair[1]], out, straight);
                let expected = dyadic(mie, view.incident, out, pair);
                all.push(Amplitude { label: (order.m, order.n, reflected, pair), expected, found });
            }
        }
    }
    all
}

/// Largest |F| to or from a direction sideways, over all azimuths.
fn sideways(direction: Vector, size: &dyn Fn(f64) -> f64) -> f64 {
    let q = direction[0].hypot(direction[1]);
    (0..=36).map(|i| size(q * (f64::from(i) * TAU / 72.0).cos())).fold(0.0, f64::max)
}

/// An order's remainders, found less expected, over the sides, and its largest |F|.
#[derive(Default)]
struct Over {
    remainders: Vec<Complex64>,
    largest: f64,
}

impl Over {
    fn mean(&self) -> Complex64 {
        self.remainders.iter().sum::<Complex64>() / self.remainders.len() as f64
    }

    /// Square of the mean's standard error.
    fn square_error(&self) -> f64 {
        let mean = self.mean();
        let n = self.remainders.len() as f64;
        self.remainders.iter().map(|r| (r - mean).norm_sqr()).sum::<f64>() / (n * (n - 1.0))
    }
}

/// Measures both half-spaces: differences averaged over the sides, over the largest |F| there.
fn compare(
    name: &str,
    single: &Single,
    sides: &[f64],
    orders: &dyn Fn(&Single, &Mie, f64) -> Vec<Amplitude>,
    size: &dyn Fn(&Mie, f64) -> f64,
    findings: &mut Findings,
) {
    let mie = single.sphere.mie();
    let mut all: BTreeMap<Label, Over> = BTreeMap::new();
    for amplitude in sides.iter().flat_map(|&side| orders(single, &mie, side)) {
        let over = all.entry(amplitude.label).or_default();
        over.remainders.push(amplitude.found - amplitude.expected);
        over.largest = over.largest.max(amplitude.expected.norm());
    }
    let lattice = sides.iter().map(|side| 3.9 / side).sum::<f64>() / sides.len() as f64;
    let incident = View::new(&mie, 1.0, 1.0).incident;
    let size = |cosine: f64| size(&mie, cosine);
    for (reflected, half) in [(false, "onwards"), (true, "backwards")] {
        let seen: Vec<&Over> = all
            .iter()
            .filter(|(l, over)| l.2 == reflected && over.remainders.len() == sides.len())
            .map(|(_, over)| over)
            .collect();
        let largest = seen.iter().map(|over| over.largest).fold(0.0, f64::max);
        let what = format!("{}, {name}: {} amplitudes {half}", single.id, seen.len());
        // At grazing angles a wave that runs sideways is scattered straight on, the strongest of all.
        let twice = sideways(incident, &size) * size(1.0);
        findings.order_of_smallness(
            format!("{what}, of the largest |F|"),
            seen.iter().map(|over| over.mean().norm()).fold(0.0, f64::max) / largest,
            lattice * twice / largest,
            "waves between the spheres: F₁F₂ × 3.9/L, the static lattice sum",
        );
        let root = |of: &dyn Fn(&Over) -> f64| seen.iter().map(|over| of(over)).sum::<f64>().sqrt();
        let error = root(&Over::square_error);
        findings.significance(
            format!("{what}, root mean square in standard errors over the sides"),
            root(&|over| over.mean().norm_sqr()) / error,
            2.0,
            "the waves between the spheres turn their phase with the side, what is wrong in F does not; one is expected, and neighbouring orders are alike",
        );
        findings.promise(
            format!("{what}, such a standard error of the root mean square |F|"),
            error / root(&|over| over.largest.powi(2)),
            0.125,
            "the power of the test above: a quarter of F is two of them",
        );
    }
}

fn sides(single: &Single, level: Level) -> Vec<f64> {
    (0..level.pick(4, 6)).map(|i| (3.3 + 0.37 * f64::from(i)) * single.sphere.wavelength_um).collect()
}

fn scalar(level: Level, findings: &mut Findings) {
    for single in cases().into_iter().take(level.pick(2, 4)) {
        let mie = single.sphere.mie();
        let table = single.amplitudes.iter().map(|(cosine, f)| (mie.scalar(*cosine) - f).norm());
        let error = table.fold(0.0, f64::max) / single.forward().norm();
        let because = "series of 40 digits at nine angles; rounding";
        findings.identity(format!("{}: Mie's series", single.id), error, 1e-12, because);
        let size = |mie: &Mie, cosine: f64| mie.scalar(cosine).norm();
        compare("scalar", &single, &sides(&single, level), &scalar_orders, &size, findings);
    }
}

fn vector(level: Level, findings: &mut Findings) {
    // Appendix A: a sphere of 0.525 µm and index 1.55 in vacuum at 0.6328 µm.
    let printed = Sphere { wavelength_um: 0.6328, radius_um: 0.525, index: 1.55.into(), host: 1.0 };
    let mie = printed.mie();
    let [scattering, extinction] = mie.efficiencies(printed.radius_um);
    let back = 4.0 * (mie.amplitudes(-1.0)[0].norm() / (mie.k * printed.radius_um)).powi(2);
    let differences = [scattering - 3.10543, extinction - 3.10543, back - 2.92534].map(f64::abs);
    let because = "Bohren and Huffman's printed example: Q_sca = Q_ext = 3.10543, Q_back = 2.92534; half of their last digit";
    findings.identity("Mie's series", differences.into_iter().fold(0.0, f64::max), 6e-6, because);
    for single in cases().into_iter().take(level.pick(2, 3)) {
        let size = |mie: &Mie, cosine: f64| {
            mie.amplitudes(cosine).iter().map(|s| s.norm()).fold(0.0, f64::max) / mie.k
        };
        compare("vector", &single, &sides(&single, level), &vector_orders, &size, findings);
    }
}
