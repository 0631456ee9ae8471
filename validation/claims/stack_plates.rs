//! Layers joined as plates, and the mean wave through all of them, against closed forms and identities.

use crate::claim::{Bound, Claim, Findings, Level, Reason};
use crate::formulas::films::{Film, amplitudes};
use inkwave::appearance::composed::flux::Hemisphere;
use inkwave::appearance::composed::fringes::Lobes;
use inkwave::appearance::composed::fringes::stack_film::{Mirrors, SolvedElement};
use inkwave::appearance::composed::ordinates::Ordinates;
use inkwave::appearance::composed::plate::Plate;
use inkwave::appearance::composed::stack::{PlateStack, StackElement};
use inkwave::appearance::composed::transport::Transport;
use inkwave::appearance::paper::MirroredSky;
use inkwave::evaluate::composed::layer::ComposedLayer;
use inkwave::evaluate::composed::spectral::{lights, spectral};
use inkwave::evaluate::quantities::LayerNumbers;
use inkwave::numerics::Draws;
use inkwave::wave::Wave;
use num_complex::Complex64;
use std::f64::consts::TAU;

pub const CLAIM: Claim = Claim {
    id: "37-stack-plates",
    statement: "A stack of plates is Airy's stack where it is clear, loses nothing where nothing absorbs, passes light alike both ways, and is the layer itself where a layer is cut in two.",
    because: "Elements share the zones of directions of all media, star products of the mean amplitudes go over the whole stack, and what the mean wave loses is shared as composing shares it.",
    file: file!(),
    measure,
};

const WAVELENGTH_UM: f64 = 0.55;
const OBLIQUE_DEG: f64 = 45.0;

/// One layer of a made-up stack: an index, a thickness, and what it scatters and absorbs.
#[derive(Clone, Copy)]
struct Made {
    index: f64,
    thickness_um: f64,
    light: Option<Transport>,
}

/// A stack in air in front of a medium of some index.
struct Pile<'a> {
    layers: &'a [Made],
    behind: f64,
    /// Number of equal parts that scattering layers are cut into.
    parts: usize,
    /// Whether their fluxes are made reciprocal: with a few directions, transport theory's are so to their quadrature.
    reciprocal: bool,
}

impl Pile<'_> {
    fn medium(&self, index: f64, oblique_deg: Option<f64>) -> Hemisphere {
        let borders: Vec<f64> =
            self.layers.iter().map(|layer| layer.index).chain([1.0, self.behind]).collect();
        Hemisphere { ordinates: Ordinates::new(index, &borders, [3, 3]), polarisations: 1, oblique_deg }
    }

    fn stack(&self) -> PlateStack {
        let front = self.medium(1.0, Some(OBLIQUE_DEG));
        PlateStack::new(self.elements(&front, self.behind), front, WAVELENGTH_UM).expect("zones of all media")
    }

    /// The same from behind, built in its own order.
    fn turned_over(&self) -> PlateStack {
        let turned: Vec<Made> = self.layers.iter().rev().copied().collect();
        let front = self.medium(self.behind, None);
        let elements = Pile { layers: &turned, ..*self }.elements(&front, 1.0);
        PlateStack::new(elements, front, WAVELENGTH_UM).expect("zones of all media")
    }

    fn elements(&self, front: &Hemisphere, behind: f64) -> Vec<StackElement> {
        let mut before = front.clone();
        let mut all = Vec::new();
        for (number, layer) in self.layers.iter().enumerate() {
            let within = self.medium(layer.index, None);
            let next = self.layers.get(number + 1).map_or(behind, |next| next.index);
            let after = self.medium(next, None);
            let Some(light) = layer.light else {
                all.extend(clear([&before, &within, &after], layer.thickness_um, number));
                before = after;
                continue;
            };
            all.extend(clear([&before, &within, &within], 0.0, number));
            let um = layer.thickness_um / self.parts as f64;
            for _ in 0..self.parts {
                all.push(self.scattering(light, &within, um, number));
            }
            all.extend(clear([&within, &within, &after], 0.0, number));
            before = after;
        }
        all
    }
}

impl Pile<'_> {
    /// A slab of a medium of transport theory; its mean wave fades as the beam does.
    fn scattering(
        &self,
        light: Transport,
        medium: &Hemisphere,
        thickness_um: f64,
        layer: usize,
    ) -> StackElement {
        let plate = light.layer(medium, thickness_um).expect("some optical thickness");
        let plate = if self.reciprocal { made_reciprocal(plate, &medium.weights()) } else { plate };
        let index = medium.ordinates.index;
        let extinction = light.scattering_per_um + light.absorption_per_um;
        let amplitude = |deg: f64| {
            let cosine = deg.to_radians().cos();
            let phase = TAU / WAVELENGTH_UM * index * cosine * thickness_um;
            Complex64::from_polar((-0.5 * extinction * thickness_um / cosine).exp(), phase)
        };
        let side: Vec<_> =
            medium.directions_deg().into_iter().map(|deg| vec![[Complex64::ZERO, amplitude(deg)]]).collect();
        let film = SolvedElement {
            amplitudes: [side.clone(), side],
            between: [index; 2],
            index,
            permittivity: (index * index).into(),
            thickness_um,
            mirrors: Mirrors::Nowhere,
            count: 1.0,
            part_first: false,
        };
        StackElement::solved(plate, film, medium.clone(), layer)
    }
}

/// The mean of all ways and the ways back: F_ij/w_i = F_ji/w_j with étendues w.
fn made_reciprocal(plate: Plate, weights: &[f64]) -> Plate {
    let mut even = plate.clone();
    for i in 0..weights.len() {
        for j in (0..weights.len()).filter(|&j| weights[i] * weights[j] > 0.0) {
            let by = weights[i] / weights[j];
            for k in 0..2 {
                let r = &plate.reflection[k];
                let t = &plate.transmission[k];
                even.reflection[k][(i, j)] = 0.5 * (r[(i, j)] + r[(j, i)] * by);
                even.transmission[k][(i, j)] = 0.5 * (t[(i, j)] + t[(j, i)] * by);
            }
        }
    }
    even
}

/// A clear layer between two media, with its faces.
fn clear(media: [&Hemisphere; 3], thickness_um: f64, layer: usize) -> Vec<StackElement> {
    let index = media[1].ordinates.index.into();
    StackElement::clear(media, index, thickness_um, WAVELENGTH_UM, layer)
}

fn numbers(stack: &PlateStack, albedo: f64) -> LayerNumbers<f64> {
    let film = stack.film(false);
    let layer = ComposedLayer::of_stack(stack, &film, Wave::Scalar);
    spectral(&layer, Wave::Scalar, MirroredSky::Included, albedo).numbers
}

/// R and T of diffuse light without interference. (With it, T̄ from behind is taken from that in front by reciprocity.)
fn diffuse(stack: &PlateStack) -> Lobes {
    let film = stack.film(false);
    let layer = ComposedLayer::of_stack(stack, &film, Wave::Scalar);
    layer.of_light(&lights(stack.before(), Wave::Scalar)[2])
}

const INK: Transport = Transport { scattering_per_um: 0.4, absorption_per_um: 0.3, asymmetry: 0.6 };
const WHITE: Transport = Transport { scattering_per_um: 1.2, absorption_per_um: 0.0, asymmetry: 0.4 };
const CLEAR_INK: Transport = Transport { scattering_per_um: 0.5, absorption_per_um: 0.0, asymmetry: 0.5 };

fn measure(level: Level, findings: &mut Findings) {
    is_airy(level.pick(12, 200), findings);
    loses_nothing(findings);
    passes_alike(findings);
    is_the_layer_itself(findings);
    accounts_for_all(findings);
}

/// Clear films of any indices against the transfer recursion.
fn is_airy(stacks: usize, findings: &mut Findings) {
    let mut draws = Draws::new(37, 0);
    let mut largest = [0.0_f64; 2];
    for _ in 0..stacks {
        let count = 2 + draws.below(3);
        let layers: Vec<Made> = (0..count)
            .map(|_| Made {
                index: draws.between(1.2, 2.2),
                thickness_um: draws.between(0.1, 3.0),
                light: None,
            })
            .collect();
        let behind = draws.between(1.0, 1.7);
        let pile = Pile { layers: &layers, behind, parts: 1, reciprocal: false };
        let films: Vec<Film> = layers
            .iter()
            .map(|made| Film { index: made.index.into(), thickness_um: made.thickness_um })
            .collect();
        let airy = |deg: f64| amplitudes(1.0, &films, behind.into(), WAVELENGTH_UM, deg)[0].norm_sqr();
        let got = numbers(&pile.stack(), 0.0);
        let off = |reflected: f64, transmitted: f64, deg: f64| {
            (reflected - airy(deg)).abs().max((reflected + transmitted - 1.0).abs())
        };
        largest[0] = largest[0].max(off(got.reflectance_normal, got.transmittance_normal, 0.0));
        largest[0] = largest[0].max(off(got.reflectance_45, got.transmittance_45, OBLIQUE_DEG));
        let steps = 40_000;
        let at = |k: usize| {
            let cosine = (k as f64 + 0.5) / steps as f64;
            2.0 * cosine * airy(cosine.acos().to_degrees())
        };
        let mean = (0..steps).map(at).sum::<f64>() / steps as f64;
        largest[1] = largest[1].max((got.reflectance_diffuse - mean).abs());
    }
    findings.identity(
        "clear stacks: R and R + T − 1 at 0° and 45°",
        largest[0],
        1e-9,
        "rounding of some hundred products",
    );
    findings.identity(
        "clear stacks: R of diffuse light",
        largest[1],
        1e-4,
        "sharp fringes at grazing angles: eight nodes a fringe against the midpoint rule in 40 000 steps",
    );
}

const VARNISHED: [Made; 3] = [
    Made { index: 1.5, thickness_um: 4.0, light: None },
    Made { index: 1.6, thickness_um: 1.3, light: Some(CLEAR_INK) },
    Made { index: 1.45, thickness_um: 6.0, light: Some(WHITE) },
];

/// The furnace: κ = 0.
fn loses_nothing(findings: &mut Findings) {
    let mut lost = 0.0_f64;
    for behind in [1.0, 1.5] {
        let stack = Pile { layers: &VARNISHED, behind, parts: 1, reciprocal: false }.stack();
        let got = numbers(&stack, 1.0);
        for [r, t] in [
            [got.reflectance_normal, got.transmittance_normal],
            [got.reflectance_45, got.transmittance_45],
            [got.reflectance_diffuse, got.transmittance_diffuse],
        ] {
            lost = lost.max((r + t - 1.0).abs());
        }
        lost = lost.max((got.natural_light - 1.0).abs());
    }
    findings.identity(
        "varnish, ink and white without absorption: light lost, alone and on a perfect white",
        lost,
        1e-5,
        "layers of transport theory are doubled some twenty times from 1e-6",
    );
}

const MIXED: [Made; 3] = [
    Made { index: 1.5, thickness_um: 0.7, light: None },
    Made { index: 1.6, thickness_um: 1.3, light: Some(INK) },
    Made { index: 1.45, thickness_um: 3.0, light: Some(WHITE) },
];

/// T̄ of a stack that is not symmetric: the étendue of air times T̄ from in front is that of the medium behind
/// times T̄ from there.
fn passes_alike(findings: &mut Findings) {
    let mut apart = 0.0_f64;
    let mut swapped = f64::INFINITY;
    for behind in [1.0, 1.5] {
        let pile = Pile { layers: &MIXED, behind, parts: 1, reciprocal: true };
        let onward = diffuse(&pile.stack());
        let back = diffuse(&pile.turned_over());
        apart = apart.max((onward.transmitted / (behind * behind * back.transmitted) - 1.0).abs());
        let [first, second, third] = MIXED;
        let other = diffuse(&Pile { layers: &[first, third, second], ..pile }.stack());
        swapped = swapped.min((onward.reflected - other.reflected).abs());
    }
    findings.identity(
        "T̄ n² from in front over that from behind, less 1",
        apart,
        1e-9,
        "plates that are reciprocal, and adding, which keeps that: rounding",
    );
    findings.check(
        "R̄ with ink and white swapped",
        swapped,
        Bound::AtLeast(0.1),
        Reason::Promise,
        "an ink over white is not white over ink: the order of layers must matter",
    );
}

/// A layer in one piece, and in two or five.
fn is_the_layer_itself(findings: &mut Findings) {
    let whole = numbers(&Pile { layers: &MIXED, behind: 1.0, parts: 1, reciprocal: false }.stack(), 0.8);
    let mut apart = 0.0_f64;
    for parts in [2, 5] {
        let cut = numbers(&Pile { layers: &MIXED, behind: 1.0, parts, reciprocal: false }.stack(), 0.8);
        let changes = whole.zipped(cut, |a: f64, b: f64| (a - b).abs());
        changes.map(|change| apart = apart.max(change));
    }
    findings.identity(
        "layers cut into two or five: largest change of any number",
        apart,
        1e-5,
        "transport layers of a half and a fifth are doubled from other thin ones",
    );
}

/// What goes in and does not come out is absorbed in the layers that absorb.
fn accounts_for_all(findings: &mut Findings) {
    let stack = Pile { layers: &MIXED, behind: 1.0, parts: 2, reciprocal: false }.stack();
    let light = &lights(stack.before(), Wave::Scalar)[2];
    let nothing = Plate::lambertian(0.0, &stack.behind().weights());
    let absorbed = stack.absorbed(light, &nothing);
    let film = stack.film(false);
    let layer = ComposedLayer::of_stack(&stack, &film, Wave::Scalar);
    let Lobes { reflected, transmitted } = layer.of_light(light);
    let all = 1.0 - reflected - transmitted;
    findings.identity(
        "1 − R̄ − T̄ less what all layers absorb",
        (absorbed.iter().sum::<f64>() - all).abs(),
        1e-12,
        "rounding",
    );
    findings.identity(
        "absorbed in the varnish and in the white, which absorb nothing",
        absorbed[0].abs().max(absorbed[2].abs()),
        1e-5,
        "layers of transport theory are doubled some twenty times from 1e-6",
    );
}
