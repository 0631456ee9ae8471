use super::*;
use crate::ink::Sphere;
use crate::solve::{Bicgstab, Coverages, Silent};
use crate::wave::{Body, BodyShape, Mean, Media, Precision, Scene, Scheme, Wave};

/// A cell with two absorbing spheres.
fn scene() -> Scene {
    let ball = |center_um| Body::new(BodyShape::Balls(vec![Sphere { center_um, radius_um: 0.1 }]), 0);
    Scene::layer([0.7, 0.6], 0.4, vec![ball([0.15, 0.2, 0.15]), ball([0.5, 0.35, 0.27])])
}

fn media() -> Media {
    let inclusions = vec![num_complex::Complex64::new(1.4, 0.05)];
    Media { incident: 1.0.into(), exit: 1.3.into(), backgrounds: vec![1.558.into()], inclusions }
}

/// Directions on both sides, the flattest in the middle of the list.
fn lights() -> Vec<Incidence> {
    let light =
        |polar_deg: f64, azimuth_deg, from| Incidence { wavelength_um: 0.5, polar_deg, azimuth_deg, from };
    let above = [10.0, 0.0, 35.0, 75.0, 60.0, 22.0].map(|polar| light(polar, 3.0 * polar, Side::Incident));
    let below = [5.0, 48.0, 30.0].map(|polar| light(polar, 200.0 - polar, Side::Exit));
    [&above[..], &below[..]].concat()
}

fn with_task<T>(wave: Wave, light: Incidence, work: impl FnOnce(&Task) -> T) -> T {
    let scene = scene();
    let media = media();
    let coverages = Coverages::new(wave, &scene, Precision::EXACT);
    let solver = Bicgstab::default();
    let scheme = wave.scheme(Scheme::Cubic);
    let goal = Goal { tolerance: 1e-5, ..Goal::default() };
    let coverages = &coverages;
    let media = &media;
    let incidence = &light;
    let task = Task {
        coverages,
        media,
        incidence,
        mean: Mean::default(),
        scheme,
        solver: &solver,
        goal,
        memory: 1e9,
    };
    work(&task)
}

#[test]
fn the_steepest_and_the_flattest_of_both_sides_are_compared() {
    assert_eq!(compared_directions(&lights()), [1, 3, 6, 7]);
    assert_eq!(compared_directions(&lights()[..1]), [0]);
    assert_eq!(compared_directions(&[]), [0; 0]);
    assert_eq!(compared_directions(&[lights()[3]; 3]), [0], "the first of equals");
}

/// Shared set-up changes no digit of a direction, and the shared estimate holds the true error:
/// that to a grid twice as fine.
#[test]
fn a_direction_on_a_shared_grid_is_the_same_solve() {
    for wave in [Wave::Scalar, Wave::Unpolarised] {
        let lights = lights();
        let scene = scene();
        let media = media();
        let coverages = Coverages::new(wave, &scene, Precision::EXACT);
        let solver = Bicgstab::default();
        let scheme = wave.scheme(Scheme::Cubic);
        let goal = Goal { tolerance: 1e-5, ..Goal::default() };
        let task = |incidence| Task {
            coverages: &coverages,
            media: &media,
            incidence,
            mean: Mean::default(),
            scheme,
            solver: &solver,
            goal,
            memory: 1e9,
        };
        let compared: Vec<Task> = compared_directions(&lights).iter().map(|&i| task(&lights[i])).collect();
        let shared = SharedGrid::found(&compared, 1e-2, &mut Silent).expect("a grid");
        let mut held = 0;
        let mut largest_share = 0.0_f64;
        for light in &lights {
            let here = shared.solve(&task(light), &mut Silent).expect("a solve");
            let grid = here.system().grid().resolution;
            let alone = with_task(wave, *light, |alone| {
                let (solved, _) = alone.solve(grid, &mut Silent).expect("a solve");
                solved.iter().map(Solved::far_field).collect::<Vec<_>>()
            });
            assert_eq!(here.far_fields, alone, "{wave:?}, {} degrees", light.polar_deg);
            let Resolution { nx, ny, cells, scheme } = grid;
            let finer = Resolution { nx: 2 * nx, ny: 2 * ny, cells: 2 * cells, scheme };
            let (truth, _) = task(light).solve(finer, &mut Silent).expect("a solve");
            let truth: Vec<FarField> = truth.iter().map(Solved::far_field).collect();
            let error = super::super::largest_of_all(&here.far_fields, &truth);
            held += usize::from(error <= here.error_estimate);
            largest_share = largest_share.max(error / here.error_estimate);
        }
        assert!(largest_share > 0.1, "{wave:?}: errors are estimated ten times too large");
        // estimates cover nine cases of ten (`SAFETY`)
        assert!(held >= 8, "{wave:?}: {held} of {} held", lights.len());
    }
}

/// A given grid too coarse for a flat direction is an error, not a worse answer.
#[test]
fn a_given_grid_is_not_replaced() {
    with_task(Wave::Scalar, lights()[0], |task| {
        let coarse = Resolution { nx: 3, ny: 3, cells: 2, scheme: Scheme::Cubic };
        assert!(matches!(SharedGrid::given(&[*task], coarse, &mut Silent), Err(AccuracyError::Wave(_))));
        let fine = Resolution { nx: 8, ny: 8, cells: 4, ..coarse };
        let shared = SharedGrid::given(&[*task], fine, &mut Silent).expect("a grid");
        assert_eq!(shared.resolution, fine);
        let alone = task.solve_with_estimate(fine, &mut Silent).expect("a solve");
        assert_eq!(shared.parts, alone.parts);
        let here = shared.solve(task, &mut Silent).expect("a solve");
        assert_eq!(here.error_estimate, alone.error_estimate);
    });
}
