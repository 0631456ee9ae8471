//! [`DiffuseFaces`] on two-flux layers and on a Monte Carlo simulation of photons.

use super::*;
use crate::numerics::Draws;

const INDEX: f64 = 1.5;

/// K and S of a layer with faces are recovered at every thickness. *Planted*: without the
/// correction they are not.
#[test]
fn coefficients_come_back_through_the_faces() {
    let faces = DiffuseFaces::plane(0.092, INDEX);
    for [absorption_per_um, scattering_per_um] in [[0.1, 2.0], [0.5, 0.3], [0.0, 1.0]] {
        let ink = KubelkaMunk { absorption_per_um, scattering_per_um };
        for thickness in [1.0, 2.0, 4.0] {
            let [r, t] = ink.layer(thickness);
            let [r, t] = faces.put_on(r, t);
            let [bare_r, bare_t] = faces.taken_off(r, t).unwrap();
            let back = KubelkaMunk::from_layer(bare_r, bare_t, thickness).unwrap();
            // identity: rounding
            assert!((back.absorption_per_um - absorption_per_um).abs() < 1e-7, "{ink:?} {back:?}");
            assert!((back.scattering_per_um - scattering_per_um).abs() < 1e-7, "{ink:?} {back:?}");
            let with_faces = KubelkaMunk::from_layer(r, t, thickness).unwrap();
            assert!((with_faces.scattering_per_um / scattering_per_um - 1.0).abs() > 0.1, "{with_faces:?}");
        }
    }
    // a lossless layer stays lossless, and faces without reflection have no effect
    let [r, t] = faces.put_on(0.3, 0.7);
    assert!((r + t - 1.0).abs() < 1e-15);
    let bare = DiffuseFaces::plane(0.0, 1.0).taken_off(0.3, 0.6).unwrap();
    assert!((bare[0] - 0.3).abs() < 1e-15 && (bare[1] - 0.6).abs() < 1e-15);
}

/// R of s light at a plane face and the cosine behind it (0 in total reflection).
fn face(cosine: f64, [from, to]: [f64; 2]) -> (f64, f64) {
    let squared = 1.0 - (from / to).powi(2) * (1.0 - cosine * cosine);
    if squared <= 0.0 {
        return (1.0, 0.0);
    }
    let behind = squared.sqrt();
    (((from * cosine - to * behind) / (from * cosine + to * behind)).powi(2), behind)
}

/// Fate of a photon: 0 reflected, 1 transmitted, 2 absorbed.
fn photon(scattering: f64, absorption: f64, thickness: f64, draws: &mut Draws) -> usize {
    let (mirrored, mut cosine) = face(draws.uniform().sqrt(), [1.0, INDEX]);
    if draws.uniform() < mirrored {
        return 0;
    }
    let extinction = scattering + absorption;
    let mut z = 0.0;
    loop {
        let next = z - cosine * (1.0 - draws.uniform()).ln() / extinction;
        if (0.0..=thickness).contains(&next) {
            if draws.uniform() * extinction < absorption {
                return 2;
            }
            (z, cosine) = (next, 2.0 * draws.uniform() - 1.0);
            continue;
        }
        if draws.uniform() >= face(cosine.abs(), [INDEX, 1.0]).0 {
            return usize::from(next > 0.0);
        }
        (z, cosine) = (if next < 0.0 { 0.0 } else { thickness }, -cosine);
    }
}

/// Isotropic scattering between plane faces: with little direct transmission, K is twice the
/// absorption per path and S is independent of the thickness, to a few percent (the assumptions of
/// Kubelka and Munk are not exact). *Planted*: without the correction, S at 1 µm is a tenth above
/// that at 4 µm or more, and K three quarters too large.
#[test]
fn coefficients_of_photons_do_not_depend_on_the_thickness() {
    const PHOTONS: usize = 60_000;
    let points = 4000;
    let share = |i: usize| face(((i as f64 + 0.5) / points as f64).sqrt(), [1.0, INDEX]).0 / points as f64;
    let faces = DiffuseFaces::plane((0..points).map(share).sum(), INDEX);
    let mut draws = Draws::new(7, 0);
    let [one, four] = [1.0, 3.0].map(|thickness| {
        let mut ends = [0.0; 3];
        for _ in 0..PHOTONS {
            ends[photon(8.0, 0.1, thickness, &mut draws)] += 1.0 / PHOTONS as f64;
        }
        let [r, t] = faces.taken_off(ends[0], ends[1]).unwrap();
        let bare = KubelkaMunk::from_layer(r, t, thickness).unwrap();
        let whole = KubelkaMunk::from_layer(ends[0], ends[1], thickness).unwrap();
        println!("{thickness} µm: {ends:?} {bare:?} with faces {whole:?}");
        [bare, whole]
    });
    let change = |i: usize| (four[i].scattering_per_um / one[i].scattering_per_um - 1.0).abs();
    assert!(change(0) < 0.04 && change(1) > 0.08, "{} {}", change(0), change(1));
    for layer in [one, four] {
        // 2 α = 0.2/µm
        assert!((layer[0].absorption_per_um / 0.2 - 1.0).abs() < 0.05, "{layer:?}");
        assert!(layer[1].absorption_per_um > 0.33, "{layer:?}");
    }
}
