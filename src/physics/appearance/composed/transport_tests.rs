use super::*;
use crate::appearance::composed::ordinates::Ordinates;

fn medium(index: f64, counts: [usize; 2]) -> Hemisphere {
    Hemisphere { ordinates: Ordinates::new(index, &[], counts), polarisations: 1, oblique_deg: None }
}

/// Unpolarised Fresnel reflectance for light with cosine `mu` in a medium of relative index 1/n.
fn fresnel(n: f64, mu: f64) -> f64 {
    let inner = (1.0 - (1.0 - mu * mu) / (n * n)).sqrt();
    let [s, p] = [(mu - n * inner) / (mu + n * inner), (n * mu - inner) / (n * mu + inner)];
    0.5 * (s * s + p * p)
}

/// A plane surface from air to a medium.
fn surface(air: &Hemisphere, inside: &Hemisphere, n: f64) -> Plate {
    let mus = air.cosines();
    let r: Vec<f64> = mus.iter().map(|&mu| fresnel(n, mu)).collect();
    let (a, b) = (air.states(), inside.states());
    let at = |i: usize, j: usize, value: f64| if i == j { value } else { 0.0 };
    Plate {
        reflection: [
            Mat::from_fn(a, a, |i, j| at(i, j, r[i])),
            Mat::from_fn(b, b, |i, j| at(i, j, r.get(i).copied().unwrap_or(1.0))),
        ],
        transmission: [
            Mat::from_fn(b, a, |i, j| at(i, j, 1.0 - r[j])),
            Mat::from_fn(a, b, |i, j| at(i, j, 1.0 - r[i])),
        ],
    }
}

/// Tables of van de Hulst (1980) and of Prahl's adding–doubling, as iadpython prints them: a = 0.5,
/// b = 1, g = 0.9; UR1, UT1, URU, UTU to five digits, free and between faces of n = 1.4.
#[test]
fn adding_reproduces_published_tables() {
    let light = Transport { scattering_per_um: 0.5, absorption_per_um: 0.5, asymmetry: 0.9 };
    let air = medium(1.0, [16, 16]);
    let free = light.layer(&air, 1.0);
    let beam = |e: &Plate| {
        let from = |m: &Mat<f64>| (0..m.nrows()).map(|i| m[(i, 0)]).sum::<f64>();
        [from(&e.reflection[0]), from(&e.transmission[0])]
    };
    let printed = |got: [f64; 4], want: [f64; 4]| {
        for (got, want) in got.into_iter().zip(want) {
            assert!((got - want).abs() < 6e-6, "{got} {want}");
        }
    };
    let all = |e: &Plate| [beam(e)[0], beam(e)[1], means(e, &air)[0], means(e, &air)[1]];
    printed(all(&free), [0.00585, 0.59232, 0.01641, 0.42287]);
    let inside = medium(1.4, [16, 16]);
    let face = surface(&air, &inside, 1.4);
    let faced = face.then(&light.layer(&inside, 1.0)).then(&face.turned());
    printed(all(&faced), [0.03859, 0.54038, 0.06527, 0.45887]);
}

/// Three directions in either zone against sixteen: a conserving and an absorbing medium between
/// surfaces, 4 to 30 µm.
#[test]
fn three_and_three_directions_suffice() {
    for [k_a, g] in [[0.0, 0.54], [0.01, 0.3]] {
        let light = Transport { scattering_per_um: 0.75, absorption_per_um: k_a, asymmetry: g };
        for thickness_um in [4.0, 10.0, 30.0] {
            let means_of = |counts: [usize; 2]| {
                let (air, inside) = (medium(1.0, counts), medium(1.58, counts));
                let face = surface(&air, &inside, 1.58);
                let layer = face.then(&light.layer(&inside, thickness_um)).then(&face.turned());
                means(&layer, &air)
            };
            let [few, many] = [means_of([3, 3]), means_of([16, 16])];
            for k in 0..2 {
                assert!((few[k] - many[k]).abs() < 5e-4, "{g} {thickness_um} {few:?} {many:?}");
            }
        }
    }
}

/// A conserving layer stays one at any thickness, and repeating is doubling.
#[test]
fn nothing_is_lost_on_the_way() {
    let light = Transport { scattering_per_um: 0.75, absorption_per_um: 0.0, asymmetry: 0.5 };
    let inside = medium(1.6, [3, 3]);
    let slab = light.layer(&inside, 2.0);
    let thick = slab.repeated(50);
    let [r, t] = means(&thick, &inside);
    assert!((r + t - 1.0).abs() < 1e-9 && t < 0.05, "{r} {t}");
    let one_by_one = (0..4).fold(slab.clone(), |sum, _| sum.then(&slab));
    let [a, b] = [means(&slab.repeated(5), &inside), means(&one_by_one, &inside)];
    assert!((a[1] - b[1]).abs() < 1e-13);
    // the furnace: on a perfect white all light comes back
    let white = Plate::lambertian(1.0, &inside.weights());
    assert!((means(&thick.then(&white), &inside)[0] - 1.0).abs() < 1e-8);
}

/// The coefficients of a slab that has some are found again.
#[test]
fn coefficients_are_found_again() {
    for [k_s, k_a, g] in [[0.75, 0.0, 0.54], [0.4, 0.05, 0.7], [2.0, 0.0, 0.3]] {
        let want = Transport { scattering_per_um: k_s, absorption_per_um: k_a, asymmetry: g };
        let inside = medium(1.6, [3, 3]);
        let slab = want.layer(&inside, 2.0);
        let got = Transport::of_slab(&slab, &inside, 2.0).unwrap();
        assert!((got.scattering_per_um - k_s).abs() < 1e-4 * k_s, "{got:?}");
        assert!((got.asymmetry - g).abs() < 1e-4, "{got:?}");
        let munk = two_flux(&slab, &inside, 2.0).unwrap();
        if k_a == 0.0 {
            // diffusion: S = 3/4 k_s (1 − g), K = 0
            let s = 0.75 * k_s * (1.0 - g);
            assert!((munk.scattering_per_um / s - 1.0).abs() < 0.01, "{munk:?} {s}");
            assert!(munk.absorption_per_um < 1e-6);
        }
    }
}
