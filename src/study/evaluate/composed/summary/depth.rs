//! Fluxes against depth.

use crate::appearance::composed::plate::{Plate, total};
use crate::appearance::composed::stack::PlateStack;
use crate::evaluate::composed::level::Slabs;
use crate::evaluate::composed::numbers::LayerTask;
use crate::evaluate::composed::spectral::lights;
use crate::evaluate::manifest::composed::DepthRow;
use crate::evaluate::wavelengths::nearest;

/// Wavelength of the fluxes against depth, nm: the nearest one of the study is taken.
const SHOWN_NM: f64 = 550.0;
/// Most joints of the profile.
const MOST_JOINTS: usize = 60;

/// Fluxes against depth in the first thickness, rounded to whole slabs, on the paper.
pub(super) fn depth(task: &LayerTask, slabs: &[Slabs]) -> (f64, Vec<DepthRow>) {
    let nm = &task.study.wavelengths_nm;
    let w = nearest(nm.iter().copied(), SHOWN_NM);
    let count = (task.composed.thicknesses_um[0] / task.composed.slab_um).round() as usize;
    let [before, _, behind] = &slabs[w].media;
    let light = &lights(before, task.study.wave)[0];
    let paper = Plate::lambertian(task.albedos[w], &behind.weights());
    let row = |depth_um: f64, [down, up]: [f64; 2]| DepthRow { depth_um, down, up };
    let depth_at = |k: usize| k as f64 * task.composed.slab_um;
    let whole = slabs[w].layer(count as f64);
    let mut rows = vec![row(0.0, [1.0, total(&(&whole.then(&paper).reflection[0] * light))])];
    for k in (1..count).step_by(count.div_ceil(MOST_JOINTS)) {
        let [front, back] = slabs[w].parted(count, k);
        rows.push(row(depth_at(k), front.between(&back.then(&paper), light).map(|flux| total(&flux))));
    }
    rows.push(row(depth_at(count), whole.between(&paper, light).map(|flux| total(&flux))));
    (nm[w], rows)
}

/// Fluxes against depth at the joints of a stack of the first thickness, on the paper.
pub(super) fn depth_of_stack(task: &LayerTask, stacks: &[PlateStack]) -> (f64, Vec<DepthRow>) {
    let nm = &task.study.wavelengths_nm;
    let w = nearest(nm.iter().copied(), SHOWN_NM);
    let stack = &stacks[w];
    let light = &lights(stack.before(), task.study.wave)[0];
    let paper = Plate::lambertian(task.albedos[w], &stack.behind().weights());
    let reflected = total(&(&stack.plate().then(&paper).reflection[0] * light));
    let mut rows = vec![DepthRow { depth_um: 0.0, down: 1.0, up: reflected }];
    for joint in stack.joints(light, &paper) {
        rows.push(DepthRow { depth_um: joint.depth_um, down: joint.down, up: joint.up });
    }
    (nm[w], rows)
}
