//! The prints of a composed layer, as they are published.

use crate::appearance::bare_paper::PaperGeometry;
use crate::evaluate::printed::Prints;
use crate::evaluate::prints::{PrintNumbers, PrintTask};
use crate::evaluate::published::ErrorParts;
use crate::evaluate::quantities::ThicknessNumbers;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;

/// The prints of layers of some thicknesses, µm, whose numbers have their bars; `None` where there
/// is only a solid on plain paper.
pub(super) fn prints(study: &Study, layers: &[(f64, &ThicknessNumbers<ErrorParts>)]) -> Option<Prints> {
    let task = PrintTask::new(study)?;
    let mut prints = Vec::new();
    for (um, layer) in layers {
        let mut plain: Vec<PrintNumbers<f64>> = Vec::new();
        let mut bars: Vec<PrintNumbers<Estimate>> = Vec::new();
        for print in &layer.prints {
            let values = print.clone().map(&|parts: ErrorParts| parts.value);
            let mut estimates = print.clone().map(&|parts: ErrorParts| parts.estimate());
            let open = task.between_wavelengths(&values.factors);
            for (lab, open) in estimates.lab.iter_mut().zip(open) {
                lab.standard_error = lab.standard_error.map(|error| error.hypot(open));
            }
            plain.push(values);
            bars.push(estimates);
        }
        prints.extend(task.notes(Some(*um), &plain, &bars));
    }
    Some(Prints { conditions: task.viewing.clone(), geometry: PaperGeometry::LitAt45.name(), prints })
}
