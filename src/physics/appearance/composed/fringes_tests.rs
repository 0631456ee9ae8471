use super::film_matrix::FilmMatrix;
use super::slab_film::unwrap;
use super::stack_film::{FilmElement, Mirrors, SolvedElement};
use super::*;
use crate::appearance::composed::ordinates::Ordinates;
use num_complex::Complex64;
use std::f64::consts::TAU;

const WAVELENGTH_UM: f64 = 0.55;
const SLAB_UM: f64 = 1.0;

fn medium(index: f64) -> Hemisphere {
    let ordinates = Ordinates::new(index, &[], [3, 3]);
    Hemisphere { ordinates, polarisations: 1, oblique_deg: None }
}

/// k_z of the film, 1/µm; absorbing films have a complex one.
fn normal(index: Complex64, sine: f64) -> Complex64 {
    TAU / WAVELENGTH_UM * (index * index - sine * sine).sqrt()
}

/// Fresnel's amplitude of s light from air.
fn fresnel(index: Complex64, sine: f64) -> Complex64 {
    let outer = (1.0 - sine * sine).sqrt();
    let inner = (index * index - sine * sine).sqrt();
    (outer - inner) / (outer + inner)
}

/// Real index of the half-spaces that slabs of this medium are solved between.
fn embedding(index: Complex64) -> f64 {
    (index * index).re.sqrt()
}

/// A film of slabs of 1 µm in air, s-polarised, whose amplitudes are those of Airy's formula
/// between the half-spaces of each.
fn film(index: Complex64) -> CoherentFilm {
    let media = [1.0, embedding(index), 1.0].map(medium);
    let sines = || [0.0].into_iter().chain(media[0].ordinates.sines.iter().copied());
    let slab = |before: f64, behind: f64| -> Vec<Vec<[Complex64; 2]>> {
        sines().map(|sine| vec![slab_between([before, behind], index, sine)]).collect()
    };
    let within = media[1].ordinates.index;
    let both = |before: f64, behind: f64| [slab(before, behind), slab(behind, before)];
    CoherentFilm {
        slabs: [both(1.0, within), both(within, within), both(within, 1.0)],
        permittivity: index * index,
        media,
        slab_um: SLAB_UM,
        wavelength_um: WAVELENGTH_UM,
        fewer_directions: false,
    }
}

/// r and t of one slab between two half-spaces, t scaled to the roots of the fluxes.
fn slab_between(between: [f64; 2], index: Complex64, sine: f64) -> [Complex64; 2] {
    let normal_in = |index: Complex64| (index * index - sine * sine).sqrt();
    let [before, behind] = between.map(|index| normal_in(index.into()));
    let own = normal_in(index);
    let [front, back] = [(before - own) / (before + own), (own - behind) / (own + behind)];
    let once = (Complex64::I * normal(index, sine) * SLAB_UM).exp();
    let many = 1.0 / (1.0 + front * back * once * once);
    let passed = 4.0 * (before * behind).sqrt() * own / ((before + own) * (own + behind));
    [(front + back * once * once) * many, passed * once * many]
}

/// Airy's R of a film of this thickness, and that without interference.
fn airy(index: Complex64, thickness_um: f64, sine: f64) -> [f64; 2] {
    let r = fresnel(index, sine);
    let round = (2.0 * Complex64::I * normal(index, sine) * thickness_um).exp();
    let through = 1.0 - r * r;
    let coherent = r * (1.0 - round) / (1.0 - r * r * round);
    let rho = (r * r * round).norm_sqr();
    let back = (through * round * r).norm_sqr() / (1.0 - rho);
    [coherent.norm_sqr(), r.norm_sqr() + back]
}

/// Mean of one of both over the hemisphere, by the midpoint rule: a thousandth of a fringe and
/// finer.
fn mean_over_hemisphere(index: Complex64, thickness_um: f64, which: usize) -> f64 {
    let steps = 400_000;
    let integrand = |k: usize| {
        let cosine = (k as f64 + 0.5) / f64::from(steps);
        2.0 * cosine * airy(index, thickness_um, (1.0 - cosine * cosine).sqrt())[which]
    };
    (0..steps as usize).map(integrand).sum::<f64>() / f64::from(steps)
}

/// The film without interference at 0° and at the nodes: nothing is scattered.
fn composed(film: &CoherentFilm, index: Complex64, count: f64) -> Vec<Lobes> {
    let sines = [0.0].into_iter().chain(film.media[0].ordinates.sines.iter().copied());
    let lobes = |sine: f64| {
        let reflected = airy(index, count * SLAB_UM, sine)[1];
        Lobes { reflected, transmitted: 1.0 - reflected }
    };
    sines.map(lobes).collect()
}

/// A medium whose index is off by 0.17 is out of phase by −π − 0.3 to −π + 0.4 over 1 µm.
#[test]
fn logarithms_do_not_jump_between_angles() {
    let phases = [-0.3, -0.2, 0.1, 0.4];
    let mut slow = phases.map(|by| {
        let slab = Complex64::from_polar(0.5, by - 0.5 * TAU).ln();
        Slow { slab, ..Slow::default() }
    });
    unwrap(&mut slow);
    for (k, pair) in slow.windows(2).enumerate() {
        let step = pair[1].slab.im - pair[0].slab.im;
        assert!((step - (phases[k + 1] - phases[k])).abs() < 1e-12, "{k}: {step}");
    }
}

/// Airy's film of any thickness, also between whole slabs, at any angle. *Planted*: the count
/// rounded.
#[test]
fn a_clear_film_of_any_thickness_has_its_fringes() {
    let index = Complex64::from(1.5);
    let film = film(index);
    for count in [2.0, 2.3, 4.0, 5.3, 127.5] {
        let interference = film.interference(count, 0, &composed(&film, index, count));
        for sine in [0.0, 0.3, 0.7, 0.99] {
            let [with, without] = airy(index, count * SLAB_UM, sine);
            let change = interference.change(sine);
            assert!((change.reflected - (with - without)).abs() < 1e-9, "{count} {sine}: {change:?}");
            assert!((change.reflected + change.transmitted).abs() < 1e-12, "{count} {sine}");
            let mirrored = interference.mirrored(sine);
            assert!((mirrored[0] - with).abs() < 1e-9 && (mirrored[1] - without).abs() < 1e-9);
        }
        assert!((interference.change_of_beam().reflected - interference.change(0.0).reflected).abs() < 1e-12);
        let nodes = film.media[0].ordinates.sines.iter().zip(&film.media[0].ordinates.weights);
        let few: f64 = nodes.map(|(s, w)| w * airy(index, count * SLAB_UM, *s)[1]).sum();
        let fine = mean_over_hemisphere(index, count * SLAB_UM, 0);
        let change = interference.change_of_diffuse();
        // quadrature with eight nodes a fringe, against the midpoint rule
        assert!((change.reflected - (fine - few)).abs() < 1e-6, "{count}: {change:?} {}", fine - few);
        assert!((change.reflected + change.transmitted).abs() < 1e-12, "{count}: {change:?}");
    }
}

/// More fringes than are followed: the mean over all phases is as near as is said.
#[test]
fn very_thick_films_have_the_mean_over_all_phases() {
    let index = Complex64::from(1.5);
    let film = film(index);
    let interference = film.interference(1000.0, 0, &composed(&film, index, 1000.0));
    assert!(interference.fringes() > MOST_FRINGES);
    let few: f64 = interference.incoherent[1..]
        .iter()
        .zip(&film.media[0].ordinates.weights)
        .map(|(i, w)| w * i.reflected)
        .sum();
    let fine = mean_over_hemisphere(index, 1.0, 1);
    assert!((interference.change_of_diffuse().reflected - (fine - few)).abs() < 1e-9);
}

/// A film that absorbs, seen from either side: what the field loses is absorbed, and T is the same
/// from behind, where the medium is denser.
#[test]
fn a_layer_turned_over_transmits_alike() {
    let index = Complex64::new(1.5, 0.01);
    let film = film(index);
    let turned = film.turned();
    assert_eq!(turned.media[0], film.media[2]);
    for count in [2.0, 3.4] {
        let absorbing: Vec<Lobes> = composed(&film, index, count)
            .into_iter()
            .map(|lobes| Lobes { transmitted: 0.5 * lobes.transmitted, ..lobes })
            .collect();
        let change = film.interference(count, 0, &absorbing).change(0.4);
        let turned_change = turned.interference(count, 0, &absorbing).change(0.4);
        assert!((change.transmitted - turned_change.transmitted).abs() < 1e-12);
        assert!((change.reflected - turned_change.reflected).abs() < 1e-12);
        assert!((change.reflected - (airy(index, count, 0.4)[0] - airy(index, count, 0.4)[1])).abs() < 0.02);
    }
}

/// R of this number of slabs as they were solved, without interference.
fn powers_of(film: &CoherentFilm, count: usize, direction: usize) -> f64 {
    let slab = |k: usize| {
        let [front, behind] = film.slabs[k].each_ref().map(|side| side[direction][0]);
        let reflected = [front[0].norm_sqr(), behind[0].norm_sqr()];
        FilmMatrix { reflected, transmitted: front[1].norm_sqr() }
    };
    let inner = (2..count).fold(slab(0), |whole, _| whole.then(slab(1)));
    inner.then(slab(2)).reflected[0]
}

/// R of an absorbing film in the directions that were solved is Airy's, though its slabs were
/// solved between half-spaces of a real index, to which each of them has steps: in closed form, and
/// as a stack; what composing makes of it has them. *Planted*: the steps left in the front and the
/// back slab; in the inner ones; inner slabs that mirror nothing where they are composed.
#[test]
fn an_absorbing_film_has_no_steps_between_its_slabs() {
    for index in [Complex64::new(1.5, 0.06), Complex64::new(1.5, 0.2)] {
        let film = film(index);
        for count in [2.0, 2.4, 3.0, 5.0] {
            let composed = composed(&film, index, count);
            let stack = as_stack(&film, count);
            let [closed, star] = [film.interference(count, 0, &composed), stack.interference(0, &composed)];
            for (direction, sine) in known_sines(&film.media[0]).into_iter().enumerate() {
                let wanted = airy(index, count * SLAB_UM, sine)[0];
                for [found, composed] in [closed.mirrored(sine), star.mirrored(sine)] {
                    assert!((found - wanted).abs() < 1e-12, "{index} {count} {sine}: {found} {wanted}");
                    if count.fract() == 0.0 {
                        let powers = powers_of(&film, count as usize, direction);
                        assert!(
                            (composed - powers).abs() < 1e-12,
                            "{index} {count} {sine}: {composed} {powers}"
                        );
                    }
                }
            }
        }
    }
}

/// Nothing is negative and nothing more than all, whatever a correction says.
#[test]
fn what_is_changed_stays_within_the_light_that_there_is() {
    let lobes = Lobes { reflected: 0.02, transmitted: 0.9 };
    let changed = lobes.changed(Lobes { reflected: -0.05, transmitted: 0.05 });
    assert_eq!(changed.reflected, 0.0);
    assert!((changed.transmitted - 0.92).abs() < 1e-15);
    let more = lobes.changed(Lobes { reflected: 0.5, transmitted: 0.1 });
    assert!((more.reflected + more.transmitted - 1.0).abs() < 1e-15 && more.transmitted >= 0.0);
}

/// At 45° light is shared among the nodes behind the front slab, and between nodes R and T are
/// polynomials: both are off by a per cent for a plain film, and mended. *Planted*: the shares
/// taken as exact.
#[test]
fn what_nodes_leave_out_of_a_film_is_known() {
    let index = Complex64::from(1.5);
    let film = film(index);
    let count = 3.4;
    let sine = 0.5_f64.sqrt();
    let interference = film.interference(count, 0, &composed(&film, index, count));
    let ordinates = &film.media[0].ordinates;
    // what a composed film has: its front is exact, what comes back through it is shared
    let front = |s: f64| fresnel(index, s).norm_sqr();
    let behind = |s: f64| (airy(index, count, s)[1] - front(s)) / (1.0 - front(s));
    let shared: f64 =
        ordinates.shares(sine).into_iter().map(|(node, w)| w * behind(ordinates.sines[node])).sum();
    let reflected = front(sine) + (1.0 - front(sine)) * shared;
    let change = interference.change_of_shared(sine);
    let want = airy(index, count, sine)[0];
    assert!((reflected - airy(index, count, sine)[1]).abs() > 1e-3);
    assert!((reflected + change.reflected - want).abs() < 1e-9, "{reflected} {change:?} {want}");
    assert!((change.reflected + change.transmitted).abs() < 1e-9, "{change:?}");
    let places: Vec<f64> =
        [1.0].into_iter().chain(ordinates.sines.iter().map(|s| (1.0 - s * s).sqrt())).collect();
    let weights = lagrange(&places, sine);
    let between: f64 =
        weights.iter().zip(&interference.incoherent).map(|(w, lobes)| w * lobes.reflected).sum();
    let change = interference.change_of_interpolated(sine);
    assert!((between + change.reflected - want).abs() < 1e-9, "{between} {change:?} {want}");
}

/// A film as a stack of a front slab, inner ones and a back slab.
fn as_stack(film: &CoherentFilm, count: f64) -> StackFilm {
    let [before, within, behind] = film.media.each_ref().map(|medium| medium.ordinates.index);
    let element = |k: usize, between: [f64; 2], mirrors: Mirrors, count: f64| {
        FilmElement::Solved(SolvedElement {
            amplitudes: film.slabs[k].clone(),
            between,
            index: within,
            permittivity: film.permittivity,
            thickness_um: film.slab_um,
            mirrors,
            count,
            part_first: false,
        })
    };
    StackFilm {
        elements: vec![
            element(0, [before, within], Mirrors::InFront, 1.0),
            element(1, [within; 2], Mirrors::Nowhere, count - 2.0),
            element(2, [within, behind], Mirrors::Behind, 1.0),
        ],
        media: [film.media[0].clone(), film.media[2].clone()],
        wavelength_um: film.wavelength_um,
        fewer_directions: false,
    }
}

/// A layer of three kinds of slabs is a stack: star products give the closed form, also in
/// directions between the nodes and from behind. *Planted*: r' of the element in front taken for r;
/// an element left where it was when the stack is turned over.
#[test]
fn a_layer_is_a_stack_of_slabs() {
    for (index, between_nodes) in [(Complex64::from(1.5), 1e-9), (Complex64::new(1.5, 0.01), 2e-3)] {
        let film = film(index);
        for count in [2.0, 3.4, 12.0] {
            let stack = as_stack(&film, count);
            let composed = composed(&film, index, count);
            let closed = film.interference(count, 0, &composed);
            let star = stack.interference(0, &composed);
            let turned = stack.turned();
            let from_behind = turned.interference(0, &composed);
            let node = film.media[0].ordinates.sines[1];
            for (sine, tolerance) in [(0.0, 1e-9), (node, 1e-9), (0.5, between_nodes), (0.9, between_nodes)] {
                let want = closed.change(sine);
                for got in [star.change(sine), from_behind.change(sine)] {
                    let apart = (got.reflected - want.reflected).abs();
                    assert!(apart < tolerance, "{index} {count} {sine}: {got:?} {want:?}");
                    assert!((got.transmitted - want.transmitted).abs() < tolerance);
                }
            }
            let want = closed.change_of_diffuse();
            let got = star.change_of_diffuse();
            assert!((got.reflected - want.reflected).abs() < between_nodes, "{got:?} {want:?}");
            let want = closed.change_of_shared(0.7);
            let got = star.change_of_shared(0.7);
            assert!((got.reflected - want.reflected).abs() < between_nodes, "{got:?} {want:?}");
        }
    }
}
