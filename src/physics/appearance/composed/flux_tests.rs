use super::*;

/// Orders of any directions with any powers that add up to 1 − A.
fn orders(state: &mut u64, absorptance: f64) -> Vec<Order> {
    let mut draw = || {
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let powers: Vec<f64> = (0..24).map(|_| draw()).collect();
    let scale = (1.0 - absorptance) / powers.iter().sum::<f64>();
    (0..12)
        .map(|k| Order {
            m: k,
            n: 0,
            direction: [0.99 * draw(), 0.0],
            reflected_propagates: true,
            transmitted_propagates: true,
            reflected: draw().into(),
            transmitted: draw().into(),
            reflected_efficiency: scale * powers[2 * k as usize],
            transmitted_efficiency: scale * powers[2 * k as usize + 1],
            further: Default::default(),
        })
        .collect()
}

/// An ensemble of made-up solves between air and a binder.
fn made_up(absorptance: f64) -> (Sides, Vec<Fluxes>) {
    let medium = |index: f64| Hemisphere {
        ordinates: Ordinates::new(index, &[], [3, 3]),
        polarisations: 1,
        oblique_deg: (index == 1.0).then_some(45.0),
    };
    let sides = Sides { media: [medium(1.0), medium(1.5)], alike: false };
    let mut state = 7;
    let mut ensemble = Vec::new();
    for _ in 0..4 {
        let mut solved = Vec::new();
        for (from, medium) in [Side::Incident, Side::Exit].into_iter().zip(&sides.media) {
            let count = medium.directions_deg().len();
            solved.extend((0..count).map(|direction| (from, direction, orders(&mut state, absorptance))));
        }
        ensemble.push(sides.fluxes(solved.iter().map(|(from, direction, orders)| Lit {
            from: *from,
            direction: *direction,
            polarisation: 0,
            absorptance,
            orders,
        })));
    }
    (sides, ensemble)
}

/// Whatever the solves say, the mean is reciprocal and has their energy balance; so a matrix
/// that is transposed, or a weight that is forgotten, is seen here.
#[test]
fn the_mean_is_reciprocal_and_balanced() {
    let absorptance = 0.2;
    let (sides, ensemble) = made_up(absorptance);
    let mean = sides.mean(&ensemble, None);
    let [outer, inner] = sides.media.each_ref().map(Hemisphere::weights);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
    for i in 1..outer.len() - 1 {
        let r = &mean.reflection[0];
        (1..outer.len() - 1).for_each(|j| near(r[(i, j)] / outer[i], r[(j, i)] / outer[j]));
        for j in 1..inner.len() {
            near(mean.transmission[1][(i, j)] / outer[i], mean.transmission[0][(j, i)] / inner[j]);
        }
    }
    for (side, states) in [(0, outer.len()), (1, inner.len())] {
        for j in 0..states {
            let all = [&mean.reflection[side], &mean.transmission[side]];
            near(all.map(|m| (0..m.nrows()).map(|i| m[(i, j)]).sum::<f64>()).iter().sum(), 1.0 - absorptance);
        }
    }
}

/// Without the highest moment every state sends out as much light, and what goes straight on goes
/// on. *Planted*: the moment of light that comes in taken away as well.
#[test]
fn fewer_directions_lose_no_light() {
    let (sides, ensemble) = made_up(0.2);
    let mean = sides.mean(&ensemble, None);
    let coherent = sides.coherent(&ensemble, None);
    let fewer = mean.with_fewer_directions(&sides.media, &coherent);
    let [outer, inner] = sides.media.each_ref().map(Hemisphere::states);
    for (before, after, states) in [
        (&mean.reflection[0], &fewer.reflection[0], outer),
        (&mean.transmission[0], &fewer.transmission[0], outer),
        (&mean.reflection[1], &fewer.reflection[1], inner),
        (&mean.transmission[1], &fewer.transmission[1], inner),
    ] {
        let sum = |m: &Mat<f64>, j: usize| m.col(j).iter().sum::<f64>();
        for j in 0..states {
            assert!((sum(before, j) - sum(after, j)).abs() < 1e-12, "{j}");
        }
        assert!((before - after).norm_max() > 1e-3);
    }
    // nothing but what goes straight on
    let mut straight = Mat::zeros(outer, outer);
    let mut mirrors = coherent.clone();
    for (node, means) in mirrors[0].iter_mut().enumerate().skip(1).take(3) {
        means[0] = [Complex64::ONE; 2];
        straight[(node, node)] = 0.5;
    }
    let mirror = Plate { reflection: [straight, mean.reflection[1].clone()], ..mean };
    let kept = mirror.with_fewer_directions(&sides.media, &mirrors);
    assert!((&kept.reflection[0] - &mirror.reflection[0]).norm_max() < 1e-15);
}

/// A matrix that is reciprocal and balanced stays as it is; étendues of Gauss's nodes differ.
#[test]
fn nothing_is_changed_that_is_right() {
    let ordinates = Ordinates::new(1.5, &[], [3, 3]);
    let medium = Hemisphere { ordinates, polarisations: 1, oblique_deg: None };
    let sides = Sides { media: [medium.clone(), medium], alike: false };
    let weights = sides.weights();
    let n = weights.len();
    let whole = weights.iter().sum::<f64>();
    let flux = |i: usize, j: usize| if weights[j] > 0.0 { 0.8 * weights[i] / whole } else { 0.0 };
    let mut all = Mat::from_fn(n, n, flux);
    sides.balance(&mut all, &vec![0.2; n], [[0.0; 2]; 2]);
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)).filter(|&(i, j)| weights[i] * weights[j] > 0.0) {
        assert!((all[(i, j)] - flux(i, j)).abs() < 1e-12, "{i} {j}");
    }
}

/// A face to a medium that is a little less dense, without nodes for the directions beyond its
/// critical angle: no symmetric scaling keeps the energy, and it is kept. *Planted*: what the
/// rounds end with (R + T = −10).
#[test]
fn energy_is_kept_where_no_scaling_keeps_reciprocity_too() {
    let medium = |index: f64| Hemisphere {
        ordinates: Ordinates::new(index, &[], [3, 3]),
        polarisations: 1,
        oblique_deg: None,
    };
    let sides = Sides { media: [medium(1.5), medium(1.4805)], alike: false };
    let n = sides.states();
    let mut all: Mat<f64> = Mat::zeros(n, n);
    for side in 0..2 {
        for (node, &sine) in sides.media[side].ordinates.sines.iter().enumerate() {
            let from = sides.first(side) + node + 1;
            if sine > sides.media[1 - side].ordinates.index {
                all[(from, from)] = 1.0;
                continue;
            }
            for (to, share) in sides.media[1 - side].ordinates.shares(sine) {
                all[(sides.first(1 - side) + to + 1, from)] = share;
            }
        }
    }
    sides.balance(&mut all, &vec![0.0; n], [[0.0; 2]; 2]);
    for j in (0..n).filter(|&j| sides.weights()[j] > 0.0) {
        let sum: f64 = (0..n).map(|i| all[(i, j)]).sum();
        // rounding
        assert!((sum - 1.0).abs() < 1e-12, "{j}: {sum}");
    }
}
