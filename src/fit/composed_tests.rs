//! The fit of opaque coats on a table whose values are a closed form, so that the inversion alone is
//! judged.

use super::*;
use crate::fit::file::KnownN;
use crate::fit::load::load;
use crate::fit::run::coverage_tests::pigment;
use crate::numerics::Draws;

const FIT: &str = "[base]\n[base.layer]\nthickness_um = 20.0\nperiod_um = 0.8\nbinder.index = 1.5\n[base.layer.composed]\nslab_um = 1.0\n\
                   [[base.pigment]]\nname = \"a\"\ndiameter_nm = 200\nvolume_fraction = 0.15\n[base.light]\nwave = \"unpolarised\"\n\
                   from_nm = 400\nto_nm = 700\nstep_nm = 20\n[base.run]\nrealisations = 8\n[[measured]]\nfile = \"masstone.csv\"\nbacking = 0.04\n\
                   [fit]\nn = [1.6, 2.4]\nkappa = [0.0, 0.6]\n";

fn read(text: &str) -> Result<FitTask, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fit.toml");
    let rows = "wavelength_nm,reflectance\n400,0.1\n700,0.5\n";
    std::fs::write(folder.path().join("masstone.csv"), rows).unwrap();
    std::fs::write(&path, text).unwrap();
    load(&path).map_err(|error| format!("{error:?}"))
}

/// Kubelka and Munk behind a surface: S in proportion to (n − n_binder)², K to κ, both to powers of the
/// wavelength.
fn closed_form(nm: f64, [n, kappa]: [f64; 2]) -> f64 {
    let scattering = 4.0 * (n - 1.5).powi(2) * (500.0 / nm).powi(2);
    let absorption = 40.0 * kappa / (nm / 500.0);
    let x = absorption / (10.0 * scattering);
    let inner = 1.0 / (1.0 + x + (x * x + 2.0 * x).sqrt());
    0.96 * 0.4 * inner / (1.0 - 0.6 * inner)
}

fn table(task: &FitTask) -> NodeTable {
    let [n, kappa] = axes(task);
    let nm = task.wavelengths_nm();
    let node = |_: usize, w: usize, i: usize, j: usize| {
        let value = closed_form(nm[w], [n[i], kappa[j]]);
        NodeValue { value, thicker: value, error: 0.001 }
    };
    NodeTable::of((1, nm.len(), n.len(), kappa.len()), 1.5, [n.clone(), kappa.clone()], node)
}

/// Pigments above the binder, with 0.3 % of noise and n known at one wavelength: where the coat is neither white nor black
/// κ is within 10 % for half of them, and its intervals hold. Without the known n, n is said to be undetermined.
///
/// κ goes with scattering, so with (n − n_binder)², and n from one wavelength to the others depends on absorption that
/// were not measured: 3 to 30 % are usual (median 7 %).
#[test]
fn opaque_coats_give_kappa_where_n_is_known() {
    let mut task = read(FIT).expect("sound");
    assert!(task.is_composed());
    let nm = task.wavelengths_nm().to_vec();
    let table = table(&task);
    let mut draws = Draws::new(9, 0);
    let mut each = Vec::new();
    let (mut count, mut inside) = (0.0, 0.0);
    for _ in 0..12 {
        let mut truth = pigment(&nm, &mut draws);
        // lifts n off the binder's, which leaves it causal
        let lowest = truth.iter().map(|row| row[0]).fold(f64::INFINITY, f64::min);
        truth.iter_mut().for_each(|row| row[0] += (1.95 - lowest).max(0.0));
        let noisy = nm.iter().zip(&truth).map(|(nm, eta)| closed_form(*nm, *eta) + 0.003 * draws.normal());
        task.measured[0].values = Some(noisy.collect());
        task.settings.known_n = None;
        let free = table.fitted(&task).expect("a fit");
        assert!(!free.n_is_determined, "{:?}", free.remarks);
        assert!(free.remarks[0].contains("fit.known_n"), "{:?}", free.remarks);
        task.settings.known_n = Some(KnownN { n_nm: nm[8], n: truth[8][0], n_error: 0.01 });
        let fit = table.fitted(&task).expect("a fit");
        let mut relative = Vec::new();
        for ((row, truth), nm) in fit.index.iter().zip(&truth).zip(&nm) {
            if (0.03..0.33).contains(&closed_form(*nm, *truth)) {
                let off = row.kappa - truth[1];
                relative.push(off / truth[1]);
                count += 1.0;
                inside += f64::from(u8::from(off.abs() < 1.96 * row.kappa_error.unwrap_or(0.0)));
            }
        }
        if !relative.is_empty() {
            each.push(rms(relative));
        }
    }
    each.sort_by(f64::total_cmp);
    let median = each[each.len() / 2];
    assert!(count > 60.0 && median < 0.10, "κ off by {each:?} of itself");
    assert!(inside / count > 0.8, "inside 95 %: {}", inside / count);
}

/// Between the nodes the table is as accurate as stated, and its derivatives are its own.
#[test]
fn the_table_is_accurate_between_its_nodes() {
    let task = read(FIT).expect("sound");
    let table = table(&task);
    let nm = task.wavelengths_nm();
    for n in [1.65, 1.9, 2.3] {
        for kappa in [0.001, 0.004, 0.03, 0.15, 0.5] {
            let index = vec![[n, kappa]; nm.len()];
            let response = table.response(&index, 0.0);
            for (w, nm) in nm.iter().enumerate() {
                let off = response.values[0][w] - closed_form(*nm, [n, kappa]);
                assert!(off.abs() < 0.004, "{n} {kappa} {nm}: {off}");
                let more = table.response(&vec![[n, 1.01 * kappa]; index.len()], 0.0).values[0][w];
                let slope = (more - response.values[0][w]) / (0.01 * kappa);
                assert!((slope - response.slopes[1][0][w]).abs() < 0.02 * slope.abs() + 1e-6);
            }
        }
    }
}

#[test]
fn what_a_composed_base_cannot_is_refused() {
    let refusal = |from: &str, to: &str| read(&FIT.replace(from, to)).expect_err("refused");
    for (from, to, says) in [
        (
            "n = [1.6, 2.4]",
            "n = [1.3, 2.0]",
            ["fit.n", "[1.3, 2]", "above or all below the binder's 1.500", "1.60"],
        ),
        (
            "backing = 0.04",
            "backing = 0.04\ngeometry = \"d:8\"",
            ["measured[0].geometry", "d:8", "45:0", "fit thin coats"],
        ),
        (
            "[fit]",
            "[fit]\nknown_n = { n_nm = 100, n = 1.65 }",
            ["fit.known_n.n_nm", "100", "from 250", "the pole of the ultraviolet"],
        ),
        (
            "[fit]",
            "[fit]\nprior = \"smooth\"\nknown_n = { n_nm = 589, n = 1.65 }",
            ["fit.known_n", "smooth", "kramers-kronig", "remove fit.known_n"],
        ),
        (
            "[fit]",
            "[fit]\nknown_n = { n_nm = 589, n = 1.65, n_error = 0 }",
            ["fit.known_n.n_error", "0", "0.0001", "0.01 is usual"],
        ),
    ] {
        let said = refusal(from, to);
        assert!(says.iter().all(|part| said.contains(part)), "{said}");
    }
}
