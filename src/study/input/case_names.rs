//! Names of a case's bodies as in its file, where a scene uses numbers.

use super::case_inputs::CaseError;
use super::fault::Fault;
use crate::wave::WaveError;

/// Replaces the numbers in a scene's error by the file's names.
pub(super) fn with_names(error: WaveError, names: &[String]) -> CaseError {
    let name = |body: usize| names.get(body).cloned().unwrap_or_else(|| format!("body {body}"));
    match error {
        WaveError::Overlap { first, second, overlap_um } => {
            let both = format!("{} and {}", name(first), name(second));
            let allowed = "bodies apart, or a sphere wholly inside another";
            Fault::new(both, format!("an overlap by {overlap_um:.3e} µm"), allowed, "move them apart").into()
        }
        WaveError::OverlapsImage { body, overlap_um } => {
            let found = format!("an overlap with its own periodic image by {overlap_um:.3e} µm");
            let remedy = "make the period L larger or the body smaller";
            Fault::new(name(body), found, "a body apart from its image", remedy).into()
        }
        WaveError::OutsideLayer { body, low_um, high_um, thickness_um } => {
            let found = format!("a body from z = {low_um} to {high_um} µm");
            let remedy = "move it, make it smaller, or make the layer thicker";
            Fault::new(name(body), found, format!("0 … {thickness_um} µm, the layer"), remedy).into()
        }
        other => other.into(),
    }
}

#[cfg(test)]
mod tests {
    use crate::input::case::Case;

    fn refusal(bodies: &str) -> String {
        let text = format!("wavelength = 0.5\nL = 1.0\n{bodies}");
        Case::parse(&text, true).unwrap_err().to_string()
    }

    #[test]
    fn bodies_are_called_as_in_the_file() {
        let binder = "H = 1.0\neta_binder = [1.5, 0]\n";
        let cylinder = "[[cylinders]]\nx = 0.5\nz = 0.5\nradius = 0.2\neta = [1.4, 0]\n";
        let sphere = "[[spheres]]\ncenter = [0.6, 0.5, 0.5]\nradius = 0.2\neta = [1.4, 0]\n";
        let said = refusal(&format!("{binder}{sphere}{cylinder}"));
        assert!(said.contains("spheres[0] and cylinders[0]: found an overlap by 3.000e-1 µm"), "{said}");
        let film = "[[sublayers_from_z0]]\nthickness = 0\neta_background = [1.5, 0]\n\
            bars = [{ x0 = 0, x1 = 0.5, eta = [1.4, 0] }]\n";
        let bars = "[[sublayers_from_z0]]\nthickness = 0.5\neta_background = [1.5, 0]\n\
            bars = [{ x0 = 0, x1 = 0.5, eta = [1.4, 0] }, { x0 = 0.25, x1 = 0.7, eta = [1.4, 0] }]\n";
        let said = refusal(&format!("{film}{bars}"));
        assert!(said.contains("sublayers_from_z0[1].bars[0] and sublayers_from_z0[1].bars[1]:"), "{said}");
    }
}
