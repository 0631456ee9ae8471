//! The grid that a study asks for by its points and planes, and whether the shortest wave fits on
//! it.

use super::{Study, WantedResolution};
use crate::input::fault::Fault;
use crate::input::variation::Draw;
use crate::numerics::allowed::brief;
use crate::solve::accuracy::smooth_size;
use crate::wave::{PHASE_LIMIT, Resolution, Scheme};
use std::f64::consts::TAU;

/// How much denser than its mean the medium of a cell of the grid may be.
const DENSER: f64 = 1.1;

/// A grid as a file gives it.
struct GivenGrid {
    points_per_um: f64,
    planes_per_um: f64,
    scheme: Scheme,
}

impl Study {
    /// The grid in the cell of a realisation, with at least the points and planes per µm that the
    /// study gives, in sizes with fast Fourier transforms; `None` where its accuracy chooses the
    /// grid.
    pub fn given_grid(&self, draw: &Draw) -> Option<Resolution> {
        let GivenGrid { points_per_um, planes_per_um, scheme } = self.per_um()?;
        let [nx, ny] = draw.period_um.map(|period| smooth_size((points_per_um * period).ceil() as usize));
        let cells = (planes_per_um * draw.thickness_um / scheme.degree() as f64).ceil().max(1.0) as usize;
        Some(Resolution { nx, ny, cells, scheme })
    }

    fn per_um(&self) -> Option<GivenGrid> {
        match self.resolution {
            WantedResolution::Grid { points_per_um, planes_per_um, scheme } => {
                Some(GivenGrid { points_per_um, planes_per_um, scheme })
            }
            WantedResolution::Accuracy { .. } => None,
        }
    }

    /// What of the given grid no solve could use, told before the first one: of a composed layer
    /// for each of its parts. Grids that only the packing shows to be too coarse are left to the
    /// solves.
    pub(in crate::input) fn grid_faults(&self) -> Vec<Fault> {
        if self.per_um().is_none() {
            return Vec::new();
        }
        let portions = self.portions();
        let all = if portions.is_empty() { std::slice::from_ref(self) } else { &portions };
        let mut faults = Vec::new();
        for part in all.iter().filter(|part| !part.pigments.is_empty() && part.has_own_grid()) {
            let place =
                part.portion().map_or_else(String::new, |portion| format!(" in {}", portion.in_words()));
            faults.extend(part.too_few_points(&place));
            faults.extend(part.too_few_planes(&place));
        }
        faults
    }

    /// Whether the grid is chosen for this study, and not for another part of its layer.
    fn has_own_grid(&self) -> bool {
        matches!(self.grid_source(), std::borrow::Cow::Borrowed(_))
    }

    /// Points that lack a harmonic for an order that propagates in a half-space, at 0°.
    fn too_few_points(&self, place: &str) -> Option<Fault> {
        let draw = self.draw(0);
        let given = self.given_grid(&draw)?;
        let nm = self.wavelengths_nm.first()?;
        let media = self.media(1e-3 * nm);
        let index = media.incident.re.max(media.exit.re);
        let needed = |period_um: f64| 2 * (index * period_um / (1e-3 * nm)).floor() as usize + 1;
        let axes = draw.period_um.into_iter().zip([given.nx, given.ny]);
        let (period_um, points) = axes.into_iter().find(|(period_um, n)| needed(*period_um) > *n)?;
        let per_um = self.per_um()?.points_per_um;
        let found = format!(
            "{per_um} per µm: {points} points along {} µm{place}, where light of {nm} nm leaves in orders up to {}",
            brief(period_um),
            needed(period_um) / 2
        );
        let least = (needed(period_um) as f64 / period_um).ceil();
        let allowed = format!("{least} or more: {} points, two for every order and one", needed(period_um));
        Some(Fault::new("resolution.points_per_um", found, allowed, REMEDY))
    }

    /// Cells of the grid that are too high for the wave even in the thinnest of the media.
    fn too_few_planes(&self, place: &str) -> Option<Fault> {
        let draw = self.draw(0);
        let given = self.given_grid(&draw)?;
        let nm = self.wavelengths_nm.first()?;
        let media = self.media(1e-3 * nm);
        let k0 = TAU / (1e-3 * nm);
        let indices =
            media.backgrounds.iter().chain(&media.inclusions).map(|eta| (eta * eta).re.max(0.0).sqrt());
        let least = k0 * indices.fold(f64::INFINITY, f64::min);
        let height_um = draw.thickness_um / given.cells as f64;
        if least * height_um <= PHASE_LIMIT {
            return None;
        }
        let per_um = self.per_um()?.planes_per_um;
        let degree = given.scheme.degree();
        let found = format!(
            "{per_um} per µm, {degree} for each cell of the grid: cells {} µm high{place}, over which the phase of light of {nm} nm \
             turns by {:.1} rad or more",
            brief(height_um),
            least * height_um
        );
        let mean = k0 * self.embedding_index(1e-3 * nm);
        let cells = (DENSER * mean.max(least) * draw.thickness_um / PHASE_LIMIT).ceil();
        let planes = (cells * degree as f64 / draw.thickness_um).ceil();
        let allowed =
            format!("about {planes} or more: cells over which it turns by {PHASE_LIMIT} rad at most");
        Some(Fault::new("resolution.planes_per_um", found, allowed, REMEDY))
    }
}

/// What to do about a grid that is too coarse.
const REMEDY: &str =
    "raise it, or write accuracy = 1e-2 in the place of points and planes, which finds the grid";
