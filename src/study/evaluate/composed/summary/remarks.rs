//! Remarks on slabs that are too thin and wavelengths that are too far apart.

use crate::evaluate::manifest::composed::{ComposedColours, MediumRow};
use crate::input::study::Composed;

/// Part of a bar of L*, a* or b* from which it is said where it comes from.
const LARGE: f64 = 1.0;

/// Slabs thinner than the mean free path of coherent light, where that is longest.
pub(super) fn thin_slabs(composed: &Composed, medium: &[MediumRow]) -> Option<String> {
    let paths = medium.iter().filter_map(|row| Some((row.wavelength_nm, row.medium.coherent_path_um?.value)));
    let (wavelength_nm, path_um) = paths.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let slab_um = composed.slab_um;
    let words = format!(
        "layer.composed.slab_um: found slabs of {slab_um:.2} µm, thinner than the mean free path of coherent light, \
         {path_um:.2} µm at {wavelength_nm} nm; interference between the surfaces is corrected for, that between inner slabs is left \
         to the model's error bar: take thicker slabs, or solve the layer at once"
    );
    (path_um > slab_um).then_some(words)
}

/// Wavelengths so far apart that they make up most of a colour's bar.
pub(super) fn far_apart(nm: &[f64], colours: &[ComposedColours]) -> Option<String> {
    let all = colours.iter().flat_map(|colours| [colours.natural_light, colours.lit_at_45]).flatten();
    let widest = all.flatten().max_by(|a, b| a.wavelengths.total_cmp(&b.wavelengths))?;
    let apart = nm.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let words = format!(
        "light.wavelengths_nm: found {} wavelengths, up to {apart:.0} nm apart; what spectra may be between them is most of \
         the colours' bars, up to {:.1} in L*, a* or b*: list wavelengths {:.0} nm apart or closer, from 400 to 700 nm",
        nm.len(),
        widest.wavelengths,
        (0.5 * apart).min(20.0)
    );
    let most = widest.wavelengths > LARGE && 2.0 * widest.wavelengths.powi(2) > widest.standard_error.powi(2);
    most.then_some(words)
}
