//! Tests of [`super`].

use super::*;

fn forms() -> [Form; 4] {
    [
        Form::Ellipsoid { semi_axes_um: [0.3, 0.2, 0.1] },
        Form::Disc { radius_um: 0.3, half_length_um: 0.05 },
        Form::Prism { corners_um: centred(&[[0.0, 0.0], [0.4, 0.0], [0.1, 0.3]]), half_length_um: 0.2 },
        Form::cuboid([0.3, 0.2, 0.1]),
    ]
}

/// Volume of the closed surface by the divergence theorem, which knows nothing of the forms.
#[test]
fn triangles_enclose_the_stated_volume() {
    for form in forms() {
        let solid = Solid {
            form: form.clone(),
            center_um: [0.1, -0.2, 0.3],
            rotation: Rotation::by([0.3, 1.0, -0.5]),
        };
        let enclosed = |steps| {
            let parts = solid.triangles(steps).into_iter().map(|[a, b, c]| dot(a, cross(b, c)) / 6.0);
            parts.sum::<f64>() / form.volume_um3()
        };
        // Order: the area between an arc and its chord falls as 1/steps².
        assert!((enclosed(100) - 1.0).abs() < 1e-3, "{form:?}: {}", enclosed(100));
        assert!((enclosed(200) - 1.0).abs() < 0.26 * (enclosed(100) - 1.0).abs() + 1e-12, "{form:?}");
    }
}

#[test]
fn no_point_of_the_surface_is_farther_than_the_support_says() {
    for form in forms() {
        let solid =
            Solid { form: form.clone(), center_um: [0.0; 3], rotation: Rotation::by([0.7, -0.2, 0.4]) };
        for direction in [[1.0, 0.0, 0.0], [0.3, -0.9, 0.2], [0.0, 0.0, -1.0], [-0.5, 0.5, 0.7]] {
            let points = solid.triangles(200).into_iter().flatten();
            let most = points.map(|p| dot(p, direction)).fold(f64::MIN, f64::max);
            let support = dot(solid.arm(direction), direction);
            assert!(most <= support + 1e-12 && most > support - 1e-4, "{form:?}: {most} {support}");
        }
        assert!(2.0 * form.reach_um() >= form.longest_um() - 1e-12);
    }
}

/// The volume is the sum of the chords of parallel lines, in any direction.
#[test]
fn chords_sum_up_to_the_volume() {
    for form in forms() {
        let rotation = Rotation::by([0.3, 1.0, -0.5]);
        let solid = Solid { form: form.clone(), center_um: [0.1, -0.2, 0.3], rotation };
        let [[x0, x1], [y0, y1]] = [0, 1].map(|axis| solid.extent_um(axis));
        let n = 400;
        let step = [(x1 - x0) / f64::from(n), (y1 - y0) / f64::from(n)];
        let line = |k: i32| {
            let from =
                [x0 + (f64::from(k % n) + 0.5) * step[0], y0 + (f64::from(k / n) + 0.5) * step[1], 0.0];
            solid.chord(from, [0.0, 0.0, 1.0]).map_or(0.0, |[a, b]| b - a)
        };
        let volume = (0..n * n).map(line).sum::<f64>() * step[0] * step[1];
        // Order: midpoint sums over 400 × 400 lines with steep chords at the rim only.
        assert!((volume / form.volume_um3() - 1.0).abs() < 2e-3, "{form:?}: {volume}");
    }
}

#[test]
fn convexity_is_distinguished_from_dents_and_crossings() {
    let star: Vec<[f64; 2]> = (0..5).map(|i| (0.8 * PI * f64::from(i)).sin_cos().into()).collect();
    for (corners, convex) in [
        (vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], true),
        (vec![[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]], true),
        (vec![[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]], false),
        (vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]], false),
        (vec![[0.0, 0.0], [1.0, 0.0]], false),
        (star, false),
    ] {
        assert_eq!(is_convex(&corners), convex, "{corners:?}");
    }
}
