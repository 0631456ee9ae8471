//! Absorption, in all and in every background medium.

use crate::wave::operator::setting::cell_offset;
use crate::wave::{Field, Problem};
use num_complex::Complex64;
use rayon::prelude::*;

impl Problem {
    /// Absorbed fraction of the incident flux, Im⟨u, (A_interior + V) u⟩/κ₀₀.
    pub fn absorptance(&self, u: &Field) -> f64 {
        let mut product = Field::zeros(self.shape());
        self.double().contrast_loads(u.view(), &mut product);
        self.mean.inverse.load(&mut product);
        self.mean.add_product(u, None, &mut product);
        absorbed(u, &product) / self.incident_kappa()
    }

    /// Absorbed fraction of the incident flux in every background medium with the bodies in it;
    /// their sum is the absorptance to rounding. Empty with a single background.
    ///
    /// A and V are sums over cells, and a cell has one background: the form is evaluated cell by
    /// cell. At planes between two backgrounds the contrast is divided as its integral is.
    pub fn absorbed(&self, u: &Field) -> Vec<f64> {
        let backgrounds = self.media.backgrounds.len();
        if backgrounds < 2 {
            return Vec::new();
        }
        (0..backgrounds).map(|background| self.absorbed_in(background, u)).collect()
    }

    fn absorbed_in(&self, background: usize, u: &Field) -> f64 {
        let grid = &self.coverage.grid;
        let own: Vec<usize> = (0..grid.cells()).filter(|&j| grid.background[j] == background).collect();
        let mut product = Field::zeros(self.shape());
        let mut is_met = vec![false; grid.planes()];
        own.iter().flat_map(|&j| grid.planes_of_cell(j)).for_each(|plane| is_met[plane] = true);
        let scattering = self.double();
        let planes = product.outer_iter_mut().into_par_iter().enumerate().filter(|(plane, _)| is_met[*plane]);
        planes.for_each_init(
            || self.fft.scratch(),
            |scratch, (plane, mut loads)| {
                let weights = self.weights_in(background, plane);
                let out = loads.as_slice_mut().expect("rows are contiguous");
                scattering.plane_loads(&u.view(), plane, &weights, out, scratch);
            },
        );
        self.mean.inverse.load(&mut product);
        own.iter().for_each(|&j| self.mean.add_cell(j, u, &mut product));
        absorbed(u, &product) / self.incident_kappa()
    }

    /// The part of the weights W_p of one plane that is due to cells of a background, divided by
    /// the number of points.
    fn weights_in(&self, background: usize, plane: usize) -> Vec<Complex64> {
        let coverage = &self.coverage;
        let grid = &coverage.grid;
        let mut uniform = Complex64::ZERO;
        for j in (0..grid.cells()).filter(|&j| grid.background[j] == background) {
            let shift = cell_offset(grid, &self.media, self.k0, &self.mean.mean_k2, j);
            let planes = grid.planes_of_cell(j).zip(&grid.element.weights).filter(|(p, _)| *p == plane);
            uniform += planes
                .map(|(_, w)| shift * (grid.height_um(j) * w / grid.points() as f64))
                .sum::<Complex64>();
        }
        let mut weights = vec![uniform; grid.points()];
        let is_own = |channel: usize| coverage.channels[channel].background == background;
        let points = grid.points() as f64;
        let of_pair = |number: usize, &[a, b]: &[usize; 2]| {
            let whole = self.contrasts[coverage.channels.len() + number];
            let loss = match [is_own(a), is_own(b)] {
                [true, true] => return whole,
                [false, false] => return Complex64::ZERO,
                // of Im(k_a k_b) what absorbs in a belongs to a
                [true, false] => self.contrasts[a].im * self.contrasts[b].re,
                [false, true] => self.contrasts[b].im * self.contrasts[a].re,
            };
            Complex64::new(0.5 * whole.re, 2.0 * points * loss)
        };
        let of_channel =
            |channel: usize| if is_own(channel) { self.contrasts[channel] } else { Complex64::ZERO };
        let singles = (0..coverage.channels.len()).map(of_channel);
        let pairs = coverage.pairs.iter().enumerate().map(|(number, pair)| of_pair(number, pair));
        let fields = coverage.moments.iter().chain(&coverage.folded);
        for (moments, contrast) in fields.zip(singles.chain(pairs)).filter(|(_, c)| *c != Complex64::ZERO) {
            weights.iter_mut().zip(moments.row(plane)).for_each(|(w, &m)| *w += contrast * m);
        }
        weights
    }
}

/// Im⟨u, y⟩.
fn absorbed(u: &Field, y: &Field) -> f64 {
    let rows = u.outer_iter().zip(y.outer_iter());
    rows.map(|(u, y)| u.iter().zip(y).map(|(u, y)| (u.conj() * y).im).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ink::Sphere;
    use crate::solve::{Gmres, Goal, Silent, Solver};
    use crate::wave::{Body, BodyShape, Incidence, Mean, Media, Resolution, Scene, Scheme, Side, Stratum};

    /// What two strata absorb adds up to A to rounding, with a ball across their joint, on every
    /// scheme; a stratum that absorbs nothing has none of it. *Planted*: weights at the joint
    /// counted for both strata.
    #[test]
    fn strata_absorb_what_is_lost() {
        let ball = Sphere { center_um: [0.2, 0.25, 0.2], radius_um: 0.12 };
        let strata = [0, 1].map(|background| Stratum { thickness_um: 0.2, background }).to_vec();
        let bodies = vec![Body::new(BodyShape::Balls(vec![ball]), 0)];
        let scene = Scene { period_um: [0.5, 0.45], strata, bodies, cut: false };
        let light =
            Incidence { wavelength_um: 0.6, polar_deg: 25.0, azimuth_deg: 10.0, from: Side::Incident };
        let absorbed = |binders: [Complex64; 2], ball: Complex64, scheme: Scheme| {
            let media = Media {
                incident: Complex64::ONE,
                exit: 1.5.into(),
                backgrounds: binders.to_vec(),
                inclusions: vec![ball],
            };
            let grid = Resolution { nx: 9, ny: 9, cells: 8, scheme };
            let problem = Problem::from_scene(&scene, &media, &light, grid, Mean::default()).expect("strata");
            let goal = Goal { tolerance: 1e-10, ..Goal::default() };
            let field = Gmres::default().solve(&problem, goal, &mut Silent).expect("converges").field;
            let far = problem.far_field(&field);
            let sum: f64 = far.absorbed.iter().sum();
            assert!((sum - far.absorptance).abs() < 1e-13, "{scheme:?}: {sum} {}", far.absorptance);
            assert!(far.energy_error().abs() < 1e-8);
            far.absorbed
        };
        let lossy = Complex64::new(1.6, 0.03);
        for scheme in [Scheme::SecondDifference, Scheme::Quadratic, Scheme::Cubic] {
            let both = absorbed([Complex64::new(1.5, 0.02), lossy], Complex64::new(1.4, 0.1), scheme);
            assert!(both.iter().all(|share| *share > 1e-3), "{both:?}");
            let [first, second] = absorbed([1.5.into(), lossy], 1.4.into(), scheme)[..] else {
                panic!("two strata")
            };
            assert!(first.abs() < 1e-13 && second > 1e-3, "{first} {second}");
        }
    }
}
