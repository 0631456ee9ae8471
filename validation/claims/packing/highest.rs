//! The highest shares of random packings without walls, beside published ones.

use crate::claim::{Bound, Findings, Level, Reason, Table};
use inkwave::ink::{
    MethodChoice, PackError, PackingRequest, PigmentGrains, RelaxationSettings, Shape, ShareRule, pack,
};
use rayon::prelude::*;
use std::f64::consts::PI;

/// A body whose densest random packings are published.
struct Known {
    what: &'static str,
    shape: Shape,
    /// The largest share published, its error, and how far a packing may stay below it.
    published: [f64; 3],
    source: &'static str,
    /// Shares asked for at either level.
    asked: [&'static [f64]; 2],
}

const DONEV: &str = "A. Donev et al., Science 303 (2004) 990: 0.68 to 0.71, ± 0.01 in a cell of 48 bodies; the relaxation does not compress";
const TRIAXIAL: &str = "A. Donev et al., Science 303 (2004) 990: 0.735, ± 0.01 in a cell of 48 bodies; the relaxation does not compress";
const WILLIAMS: &str = "S. R. Williams, A. P. Philipse, Phys. Rev. E 67 (2003) 051301: 0.695, and 0.72 by other ways of packing since";
/// The last is more than was ever packed at random.
const CONVEX: [&[f64]; 2] = [&[0.62], &[0.62, 0.64, 0.66, 0.68, 0.739]];
const BEADED: [&[f64]; 2] = [&[0.64, 0.735], &[0.64, 0.66, 0.68, 0.735]];

fn known() -> [Known; 4] {
    [
        Known {
            what: "prolate spheroid 1 : 1 : 1.5",
            shape: ellipsoid([1.0, 1.0, 1.5]),
            published: [0.71, 0.01, 0.1],
            source: DONEV,
            asked: CONVEX,
        },
        Known {
            what: "oblate spheroid 1.9 : 1.9 : 1",
            shape: ellipsoid([1.9, 1.9, 1.0]),
            published: [0.71, 0.01, 0.1],
            source: DONEV,
            asked: CONVEX,
        },
        Known {
            what: "ellipsoid 1.25 : 1 : 0.8",
            shape: ellipsoid([1.25, 1.0, 0.8]),
            published: [0.735, 0.01, 0.12],
            source: TRIAXIAL,
            asked: CONVEX,
        },
        Known {
            what: "spherocylinder of beads, length 0.4 diameters",
            shape: beaded(),
            published: [0.695, 0.025, 0.06],
            source: WILLIAMS,
            asked: BEADED,
        },
    ]
}

fn ellipsoid(axes: [f64; 3]) -> Shape {
    Shape::Ellipsoid { axes }
}

/// Nine beads, a tenth of a radius apart: within 10⁻³ of the cylinder's volume.
fn beaded() -> Shape {
    Shape::Cylinder { length_in_radii: 2.8, spheres: 9 }
}

/// Bodies in the cell: two of its sides are three bodies long.
const GRAINS: f64 = 48.0;
const DIAMETER_NM: f64 = 200.0;

impl Known {
    /// What was packed of this share, and whether all of it was. Of what no one has packed a few steps are enough:
    /// bodies are then taken out until the others fit.
    fn packed(&self, share: f64) -> (f64, bool) {
        let side = 1e-3 * DIAMETER_NM * (GRAINS * PI / 6.0 / share).cbrt();
        let grains = PigmentGrains::of(self.shape.clone(), DIAMETER_NM, share);
        let max_steps = if share > self.published[0] { 60 } else { 1000 };
        let request = PackingRequest {
            period_um: [side, side],
            thickness_um: side,
            walls: false,
            pigments: vec![PigmentGrains { share: ShareRule::ScaleSizes, ..grains }],
            method: MethodChoice::Relaxation,
            relaxation: RelaxationSettings { max_steps, ..Default::default() },
            seed: 23,
            ..Default::default()
        };
        match pack(&request, &mut ()) {
            Ok(packing) => (packing.achieved_fraction(0), true),
            Err(PackError::NotReached { reached, .. }) => (reached.map_or(0.0, |r| r.fraction), false),
            Err(other) => panic!("{}: {other}", self.what),
        }
    }

    /// The largest share packed. After a refusal only the share that is too large for any packing is asked for.
    fn reached(&self, level: Level) -> f64 {
        let mut most = 0.0f64;
        let mut refused = false;
        for &share in level.pick(self.asked[0], self.asked[1]) {
            if !refused || share > self.published[0] {
                let (packed, all) = self.packed(share);
                (most, refused) = (most.max(packed), !all);
            }
        }
        most
    }
}

pub fn measure(level: Level, findings: &mut Findings) {
    let known = known();
    let reached: Vec<f64> = known.par_iter().map(|body| body.reached(level)).collect();
    let mut rows = Vec::new();
    for (body, share) in known.iter().zip(reached) {
        let [published, error, short] = body.published;
        let below = published - share;
        let cells = [published, share, below].map(|x| format!("{x:.3}"));
        rows.push([vec![body.what.to_string()], cells.to_vec()].concat());
        let what = format!("published share less that packed, {}", body.what);
        findings.check(what, below, Bound::Within([-error, short]), Reason::Promise, body.source);
    }
    let columns = ["body", "published", "packed", "below"].map(String::from).to_vec();
    findings.tables.push(Table { title: "Highest shares without walls".into(), columns, rows });
}
