//! Two thin layers of grains: solved each between half-spaces and joined as plates, and solved both at once.

use inkwave::appearance::composed::flux::{Fluxes, Hemisphere, Lit, Sides};
use inkwave::appearance::composed::fringes::stack_film::{Mirrors, SolvedElement};
use inkwave::appearance::composed::ordinates::Ordinates;
use inkwave::appearance::composed::stack::{PlateStack, StackElement};
use inkwave::ink::{PackingRequest, PigmentGrains, Sphere, pack};
use inkwave::input::file::ComposedTable;
use inkwave::numerics::Draws;
use inkwave::solve::{Gmres, Goal, Silent, Solver};
use inkwave::wave::{
    Body, BodyShape, FarField, Incidence, Mean, Media, Problem, Resolution, Scene, Scheme, Side, Stratum,
};
use num_complex::Complex64;
use rayon::prelude::*;

/// A layer of spheres in a binder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    pub thickness_um: f64,
    pub share: f64,
    pub diameter_nm: f64,
    pub grains: Complex64,
    pub binder: f64,
}

/// Two layers in air at one wavelength.
#[derive(Clone, Copy, Debug)]
pub struct TwoCoats {
    pub coats: [Coat; 2],
    pub wavelength_um: f64,
    /// Shortest and longest side of the cells, µm: every pair of packings has its own, so that guided modes of a cell,
    /// whose places depend on its sides, do not stand for those of an endless layer. At 0° all cells have one Bloch vector.
    pub sides_um: [f64; 2],
    pub realisations: usize,
    /// Index of the joint; the binder of the layer behind is right.
    pub joint: f64,
}

/// What was solved of one pair of packings.
pub struct SolvedPair {
    /// Each layer between its half-spaces.
    pub fluxes: [Fluxes; 2],
    /// Both at once: \[direction\]\[R, T\], the directions of [`TwoCoats::directions_deg`].
    pub direct: Vec<[f64; 2]>,
    /// Both at once, in light at 0° from the front alone.
    pub direct_beam: Fluxes,
}

const AIR: f64 = 1.0;
/// As in stacks that name no directions.
const NODES: [usize; 2] = ComposedTable::OF_A_STACK;
/// Points and cells per µm: amplitudes to some 3e-3, the same in all solves.
const PER_UM: f64 = 12.0;
const OBLIQUE_DEG: f64 = 45.0;

impl Coat {
    /// Of one packing.
    fn packed(&self, period_um: [f64; 2], seed: u64, stream: u64) -> Vec<Sphere> {
        let request = PackingRequest {
            period_um,
            thickness_um: self.thickness_um,
            pigments: vec![PigmentGrains::spheres(self.diameter_nm, self.share)],
            seed,
            stream,
            ..Default::default()
        };
        let packing = pack(&request, &mut ()).expect("30 % packs");
        packing.grains().iter().flat_map(|grain| grain.spheres.clone()).collect()
    }
}

impl TwoCoats {
    /// Media of the three half-spaces; the first has a beam at 45°.
    fn media(&self) -> [Hemisphere; 3] {
        let borders = [AIR, self.joint];
        let medium = |index: f64, oblique_deg| Hemisphere {
            ordinates: Ordinates::new(index, &borders, NODES),
            polarisations: 1,
            oblique_deg,
        };
        [medium(AIR, Some(OBLIQUE_DEG)), medium(self.joint, None), medium(AIR, None)]
    }

    /// What either layer lies between.
    pub fn sides(&self) -> [Sides; 2] {
        let [before, joint, behind] = self.media();
        [[before, joint.clone()], [joint, behind]].map(|media| Sides { media, alike: false })
    }

    /// What both lie between.
    pub fn outer_sides(&self) -> Sides {
        let [before, _, behind] = self.media();
        Sides { media: [before, behind], alike: false }
    }

    /// Directions of the light on both layers: 0°, the nodes, 45°.
    pub fn directions_deg(&self) -> Vec<f64> {
        self.media()[0].directions_deg()
    }

    /// All pairs of packings, solved apart and together.
    pub fn solved(&self) -> Vec<SolvedPair> {
        (0..self.realisations as u64).into_par_iter().map(|stream| self.pair(stream)).collect()
    }

    fn pair(&self, stream: u64) -> SolvedPair {
        let mut draws = Draws::new(51, stream);
        let period_um = self.period_um(stream);
        let shift = period_um.map(|um| draws.between(0.0, um));
        let azimuth_deg = draws.between(0.0, 360.0);
        let packed = [0_usize, 1].map(|k| self.coats[k].packed(period_um, 7 + k as u64, stream));
        let ends = [[AIR, self.joint], [self.joint, AIR]];
        let apart = |k: usize| {
            let sides = &self.sides()[k];
            let scene = self.scene(period_um, &[(k, packed[k].as_slice())]);
            let mut solved = Vec::new();
            for (medium, from) in sides.media.iter().zip([Side::Incident, Side::Exit]) {
                for (direction, polar_deg) in medium.directions_deg().into_iter().enumerate() {
                    let far = self.far(&scene, ends[k], (polar_deg, azimuth_deg, from));
                    solved.push((from, direction, far));
                }
            }
            sides.fluxes(solved.iter().map(|(from, direction, far)| {
                let from = *from;
                let direction = *direction;
                Lit { from, direction, polarisation: 0, absorptance: far.absorptance, orders: &far.orders }
            }))
        };
        let behind: Vec<Sphere> =
            packed[1].iter().map(|sphere| self.moved(sphere, period_um, shift)).collect();
        let both = self.scene(period_um, &[(0, packed[0].as_slice()), (1, behind.as_slice())]);
        let direct = |polar_deg| self.far(&both, [AIR; 2], (polar_deg, azimuth_deg, Side::Incident));
        let direct: Vec<FarField> = self.directions_deg().into_iter().map(direct).collect();
        let beam = Lit {
            from: Side::Incident,
            direction: 0,
            polarisation: 0,
            absorptance: direct[0].absorptance,
            orders: &direct[0].orders,
        };
        SolvedPair {
            fluxes: [apart(0), apart(1)],
            direct_beam: self.outer_sides().fluxes(std::iter::once(beam)),
            direct: direct.iter().map(|far| [far.reflectance, far.transmittance]).collect(),
        }
    }

    /// Sides of the cell of a pair, spread evenly over their range.
    fn period_um(&self, stream: u64) -> [f64; 2] {
        // steps of the plastic number fill a square evenly
        const PLASTIC: f64 = 1.324_717_957_244_746;
        let [shortest, longest] = self.sides_um;
        let along = |step: f64| shortest + (longest - shortest) * (0.5 + stream as f64 * step).fract();
        [along(PLASTIC.recip()), along(PLASTIC.powi(-2))]
    }

    /// A sphere of the second layer under the first one.
    fn moved(&self, sphere: &Sphere, period_um: [f64; 2], shift: [f64; 2]) -> Sphere {
        let [x, y, z] = sphere.center_um;
        let x = (x + shift[0]).rem_euclid(period_um[0]);
        let y = (y + shift[1]).rem_euclid(period_um[1]);
        Sphere { center_um: [x, y, z + self.coats[0].thickness_um], ..*sphere }
    }

    /// Layers with their grains, from the front.
    fn scene(&self, period_um: [f64; 2], layers: &[(usize, &[Sphere])]) -> Scene {
        let strata = layers
            .iter()
            .map(|(k, _)| Stratum { thickness_um: self.coats[*k].thickness_um, background: *k })
            .collect();
        let bodies = |(k, spheres): &(usize, &[Sphere])| {
            let k = *k;
            let body = move |sphere: &Sphere| Body::new(BodyShape::Balls(vec![*sphere]), k);
            spheres.iter().map(body).collect::<Vec<_>>()
        };
        Scene { period_um, strata, bodies: layers.iter().flat_map(bodies).collect(), cut: false }
    }

    fn far(
        &self,
        scene: &Scene,
        ends: [f64; 2],
        (polar_deg, azimuth_deg, from): (f64, f64, Side),
    ) -> FarField {
        let media = Media {
            incident: ends[0].into(),
            exit: ends[1].into(),
            backgrounds: self.coats.iter().map(|coat| coat.binder.into()).collect(),
            inclusions: self.coats.iter().map(|coat| coat.grains).collect(),
        };
        let incidence = Incidence { wavelength_um: self.wavelength_um, polar_deg, azimuth_deg, from };
        let points = |um: f64| inkwave::solve::accuracy::smooth_size((PER_UM * um).ceil() as usize);
        let [nx, ny] = scene.period_um.map(points);
        let height_um: f64 = scene.strata.iter().map(|stratum| stratum.thickness_um).sum();
        let cells = (PER_UM * height_um).round() as usize;
        let resolution = Resolution { nx, ny, cells, scheme: Scheme::default() };
        let problem =
            Problem::from_scene(scene, &media, &incidence, resolution, Mean::default()).expect("two layers");
        let goal = Goal { tolerance: 1e-5, ..Goal::default() };
        let field = Gmres::default().solve(&problem, goal, &mut Silent).expect("inks converge").field;
        problem.far_field(&field)
    }

    /// The stack of the mean plates, with or without one of the pairs.
    pub fn stack(&self, solved: &[SolvedPair], left_out: Option<usize>) -> PlateStack {
        let all = |k: usize| -> Vec<Fluxes> { solved.iter().map(|pair| pair.fluxes[k].clone()).collect() };
        let sides = self.sides();
        let element = |k: usize| {
            let fluxes = all(k);
            let between = sides[k].media.each_ref().map(|medium| medium.ordinates.index);
            let film = SolvedElement {
                amplitudes: sides[k].coherent(&fluxes, left_out),
                between,
                index: self.even_index(k),
                permittivity: self.even_index(k).powi(2).into(),
                thickness_um: self.coats[k].thickness_um,
                mirrors: Mirrors::OnBothSides,
                count: 1.0,
                part_first: false,
            };
            StackElement::solved(sides[k].mean(&fluxes, left_out), film, sides[k].media[1].clone(), k)
        };
        let elements = vec![element(0), element(1)];
        PlateStack::new(elements, sides[0].media[0].clone(), self.wavelength_um).expect("one joint")
    }

    /// √Re⟨η²⟩ of a layer.
    fn even_index(&self, k: usize) -> f64 {
        let Coat { share, grains, binder, .. } = self.coats[k];
        (share * (grains * grains).re + (1.0 - share) * binder * binder).sqrt()
    }
}
