//! The whole scattering matrix of a tiny layer: all propagating orders of both sides, from dense solves.

use super::tiny::ball;
use inkwave::solve::{Direct, Goal, Silent, Solver};
use inkwave::wave::{
    Coverage, FarField, Incidence, Mean, Media, Order, Problem, Resolution, Scene, Scheme, Side,
};
use num_complex::Complex64;
use std::sync::Arc;

const WAVELENGTH: f64 = 0.55;
const SIDES: [Side; 2] = [Side::Incident, Side::Exit];

/// A direction of incidence or departure: a side, and the lateral wavevector over k0.
#[derive(Clone, Copy, Debug)]
struct Channel {
    side: Side,
    direction: [f64; 2],
}

struct Layer {
    coverage: Arc<Coverage>,
    media: Media,
}

impl Layer {
    fn new(nx: usize, ny: usize, scheme: Scheme, kappa: f64) -> Layer {
        let bodies = vec![ball([0.2, 0.12, 0.1], 0.09), ball([0.5, 0.4, 0.2], 0.1)];
        let scene = Scene::layer([0.7, 0.6], 0.32, bodies);
        let resolution = Resolution { nx, ny, cells: 4, scheme };
        let pigment = Complex64::new(1.3, kappa);
        let media = Media {
            incident: 1.0.into(),
            exit: 1.3.into(),
            backgrounds: vec![1.5.into()],
            inclusions: vec![pigment],
        };
        Layer { coverage: Arc::new(Coverage::new(&scene, resolution).expect("a valid scene")), media }
    }

    fn index(&self, side: Side) -> f64 {
        if side == Side::Incident { self.media.incident.re } else { self.media.exit.re }
    }

    /// κ/k0 of a channel.
    fn kappa(&self, channel: Channel) -> f64 {
        let [x, y] = channel.direction;
        (self.index(channel.side).powi(2) - x * x - y * y).sqrt()
    }

    /// Light into the layer along a channel.
    fn solve(&self, channel: Channel) -> FarField {
        let [x, y] = channel.direction;
        let polar_deg = (x.hypot(y) / self.index(channel.side)).asin().to_degrees();
        let azimuth_deg = y.atan2(x).to_degrees();
        let light = Incidence { wavelength_um: WAVELENGTH, polar_deg, azimuth_deg, from: channel.side };
        let problem = Problem::new(&self.coverage, &self.media, &light, Mean::default()).expect("a problem");
        let goal = Goal { tolerance: 1e-12, ..Goal::default() };
        problem.far_field(&Direct::default().solve(&problem, goal, &mut Silent).expect("dense").field)
    }

    /// What leaves towards each propagating channel for light along `channel`: labels, channels, amplitudes.
    fn row(&self, channel: Channel) -> Vec<([i32; 2], Channel, Complex64)> {
        let far = self.solve(channel);
        let outgoing = |side: Side| {
            let leaves = move |o: &Order| {
                let (propagates, amplitude) = if side == channel.side {
                    (o.reflected_propagates, o.reflected)
                } else {
                    (o.transmitted_propagates, o.transmitted)
                };
                propagates.then_some(([o.m, o.n], Channel { side, direction: o.direction }, amplitude))
            };
            far.orders.iter().filter_map(leaves).collect::<Vec<_>>()
        };
        SIDES.into_iter().flat_map(outgoing).collect()
    }

    /// All propagating channels of one Bloch vector.
    fn channels(&self) -> Vec<Channel> {
        let seed = Channel { side: Side::Incident, direction: [0.31, -0.17] };
        self.row(seed).into_iter().map(|(_, channel, _)| channel).collect()
    }
}

fn layers() -> impl Iterator<Item = (String, Layer)> {
    // Odd and even grids: the Nyquist harmonic of an even grid is left out, so the set is symmetric on both.
    let grids = [(5, 5), (6, 6), (8, 5)];
    let cases = grids.into_iter().flat_map(|g| [(g, Scheme::Tents, 0.0), (g, Scheme::Cubic, 0.2)]);
    cases.map(|((nx, ny), scheme, kappa)| {
        (format!("{nx} × {ny} {scheme:?} κ = {kappa}"), Layer::new(nx, ny, scheme, kappa))
    })
}

/// Identity: κ_o S(o ← i) = κ_i S(−i ← −o) for every pair, since (A + V)ᵀ at q is A + V at −q (a contrast in points
/// couples harmonics by their difference alone, folded by the grid or not). 1e-11: dense residuals, amplified a little.
#[test]
fn the_whole_scattering_matrix_is_reciprocal() {
    for (name, layer) in layers() {
        let opposite = |c: Channel| Channel { direction: c.direction.map(|d| -d), ..c };
        let channels = layer.channels();
        assert!(channels.len() >= 10, "{name}: {}", channels.len());
        let back: Vec<_> = channels.iter().map(|&c| layer.row(opposite(c))).collect();
        for &i in &channels {
            for (label, o, amplitude) in layer.row(i) {
                let there = layer.kappa(o) * amplitude;
                let near = |c: &Channel| {
                    c.side == o.side && (0..2).all(|a| (c.direction[a] - o.direction[a]).abs() < 1e-9)
                };
                let reversed = &back[channels.iter().position(near).expect("a channel")];
                let found = reversed.iter().find(|(l, c, _)| *l == label && c.side == i.side);
                let here = layer.kappa(i) * found.expect("the way back").2;
                assert!((there - here).norm() < 1e-11, "{name} {i:?} → {o:?}: {there} {here}");
            }
        }
    }
}

/// Identity: without absorption Σ_o κ_o S*(o ← i) S(o ← j) = κ_i δ_ij, for different i and j too: all incident waves of
/// one Bloch vector share their harmonics.
#[test]
fn the_whole_scattering_matrix_is_unitary_without_absorption() {
    for (nx, ny) in [(5, 5), (6, 7)] {
        let layer = Layer::new(nx, ny, Scheme::Cubic, 0.0);
        let channels = layer.channels();
        let rows: Vec<_> = channels.iter().map(|&c| layer.row(c)).collect();
        for (i, a) in rows.iter().enumerate() {
            for (j, b) in rows.iter().enumerate() {
                let terms = a.iter().zip(b).map(|(a, b)| layer.kappa(a.1) * a.2.conj() * b.2);
                let expected = if i == j { layer.kappa(channels[i]) } else { 0.0 };
                let sum: Complex64 = terms.sum();
                assert!((sum - expected).norm() < 1e-11, "{nx} × {ny} ({i}, {j}): {sum}, not {expected}");
            }
        }
    }
}
