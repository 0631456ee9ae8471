//! What the elimination leaves, against the operator itself, and the memory it takes.

use super::*;
use crate::ink::Sphere;
use crate::wave::maxwell::{Averaging, NormalMoments};
use crate::wave::{Body, BodyShape, Field, Incidence, Mean, Media, Scatter, Scene, Scheme, Side};
use std::sync::Arc;

fn problem([nx, ny, cells]: [usize; 3]) -> Arc<VectorProblem> {
    let ball = Sphere { center_um: [0.1, 0.13, 0.08], radius_um: 0.07 };
    let scene = Scene::layer([0.3, 0.26], 0.2, vec![Body::new(BodyShape::Balls(vec![ball]), 0)]);
    let one = Complex64::ONE;
    let pigment = Complex64::new(2.4, 0.1);
    let media =
        Media { incident: one, exit: 1.5 * one, backgrounds: vec![1.558.into()], inclusions: vec![pigment] };
    let incidence =
        Incidence { wavelength_um: 0.75, polar_deg: 25.0, azimuth_deg: 40.0, from: Side::Incident };
    let grid = Resolution { nx, ny, cells, scheme: Scheme::Quadratic };
    let moments = NormalMoments::new(&scene, grid).expect("moments");
    VectorProblem::new(&Arc::new(moments), &media, &incidence, Mean::default(), Averaging::Normal)
        .expect("a problem")
}

/// A field without symmetry.
fn some_field(shape: (usize, usize)) -> Field {
    Field::from_shape_fn(shape, |(r, c)| {
        let phase = 1.3 * r as f64 + 0.7 * (c * c) as f64;
        Complex64::new(phase.sin(), (0.4 * phase).cos())
    })
}

/// G V v: what sources cause within their cells.
fn within_cells(problem: &VectorProblem, v: &Field) -> Field {
    let mut sources = Field::zeros(v.dim());
    problem.operator().contrast_product(v.view(), &mut sources);
    let mut out = Field::zeros(v.dim());
    for j in 0..v.nrows() / CELL_ROWS {
        let responses = problem.operator().mean.unit_responses(j);
        for (k, r) in (0..CELL_ROWS * CELL_ROWS).map(|n| (n / CELL_ROWS, n % CELL_ROWS)) {
            for i in 0..v.ncols() {
                out[[CELL_ROWS * j + r, i]] += responses.sources[k][r][i] * sources[[CELL_ROWS * j + k, i]];
            }
        }
    }
    out
}

/// Identity, up to single precision times a condition number of up to a hundred, if all harmonics
/// are eliminated.
///
/// *Planted*: an eliminated node's factors in the wrong order, h without its unit in the loads, the
/// first plane's contrast on both, or nodes whose coupling through the mean medium is left out.
#[test]
fn what_is_left_acts_within_single_cells() {
    for size in [[1, 1, 1], [1, 3, 2], [5, 1, 3], [3, 5, 2], [6, 4, 3], [5, 5, 5]] {
        let problem = problem(size);
        let harmonics = problem.harmonics.len();
        let space = VectorCoarsePlan::new(&problem, 1e3).carried_out(&problem);
        assert_eq!(space.plan.columns.len(), harmonics);
        let v = some_field((CELL_ROWS * size[2], harmonics));
        let mut factor = v.clone();
        space.apply(problem.narrow_operator(), factor.as_slice_mut().expect("contiguous"));
        let mut found = Field::zeros(v.dim());
        problem.operator().scatter(factor.view(), &mut found);
        found += &factor;
        let expected = within_cells(&problem, &v) + &v;
        let error = found.iter().zip(&expected).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let change = factor.iter().zip(&v).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(change > 1e-3, "{size:?}: nothing done ({change:e})");
        assert!(error < 2e-5, "{size:?}: {error:e}");
    }
}

/// Other harmonics than those eliminated stay as they are.
#[test]
fn higher_harmonics_stay() {
    let problem = problem([7, 7, 2]);
    let plan = VectorCoarsePlan::new(&problem, 1.0);
    let space = plan.clone().carried_out(&problem);
    let v = some_field((2 * CELL_ROWS, 49));
    let mut changed = v.clone();
    space.apply(problem.narrow_operator(), changed.as_slice_mut().expect("contiguous"));
    assert!((1..49).contains(&plan.columns.len()), "{}", plan.columns.len());
    for i in 0..49 {
        let stays = v.column(i) == changed.column(i);
        assert_eq!(stays, !plan.columns.contains(&i), "harmonic {i}");
    }
}

/// The memory planned holds what is kept; a plan for less memory takes fewer harmonics, or there is
/// none.
///
/// *Planted*: a plan without the cells' matrices.
#[test]
fn the_memory_is_planned() {
    let problem = problem([15, 15, 12]);
    let plan = VectorCoarsePlan::new(&problem, 3.0);
    let planned = plan.bytes();
    let kept = plan.carried_out(&problem).bytes() as f64;
    assert!(kept < planned && planned < 2.0 * kept, "{planned:e} for {kept:e}");
    let whole = VectorCoarsePlan::within(&problem, f64::INFINITY).expect("a plan");
    let less = VectorCoarsePlan::within(&problem, 0.9 * whole.bytes()).expect("a smaller plan");
    assert!(less.columns.len() < whole.columns.len() && less.bytes() <= 0.9 * whole.bytes());
    assert_eq!(VectorCoarsePlan::within(&problem, 0.0), None);
}

/// What one polarisation made, the other takes, once.
#[test]
fn both_polarisations_share_an_elimination() {
    let problem = problem([5, 5, 2]);
    let plan = VectorCoarsePlan::new(&problem, 1.0);
    let [first, second, third] = [(); 3].map(|()| problem.eliminated(plan.clone()));
    assert!(Arc::ptr_eq(&first, &second) && !Arc::ptr_eq(&second, &third));
    let other = problem.eliminated(VectorCoarsePlan::new(&problem, 1e3));
    assert_ne!(other.plan, third.plan, "another plan is another space");
}
