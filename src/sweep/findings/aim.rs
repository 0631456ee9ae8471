//! The target colour of a variant, and its distance from it.

use crate::evaluate::ink_maker::InkMaker;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;

/// The target set by `[colour] target_lab`.
#[derive(Clone, Debug, PartialEq)]
pub struct Aim {
    /// Target L*, a*, b*.
    pub lab: [f64; 3],
    /// Illuminant, observer and summation rule; lit at 45°, viewed along the normal.
    pub conditions: String,
    /// The result, once the variant has a colour.
    pub found: Option<AimFound>,
}

/// Results of a variant with a target.
#[derive(Clone, Debug, PartialEq)]
pub struct AimFound {
    /// ΔE₀₀ to the target.
    pub delta_e_2000: Estimate,
    /// Number of each realisation and its contribution to the difference.
    pub deviations: Vec<(usize, f64)>,
    /// Contrast ratio: Y over black divided by Y over white.
    pub contrast_ratio: Estimate,
    /// `#rrggbb` of the print, adapted to the illuminant.
    pub hex: String,
}

impl AimFound {
    /// The results, if the study sets a target.
    fn of(maker: &InkMaker) -> Option<Self> {
        let target = maker.target.as_ref()?;
        Some(Self {
            delta_e_2000: target.delta_e_2000,
            deviations: target.deviations.clone(),
            contrast_ratio: maker.contrast_ratio,
            hex: maker.print.hex.clone(),
        })
    }
}

impl Aim {
    /// The target of a study, if it sets one.
    pub fn of(study: &Study) -> Option<Self> {
        let lab = study.judgement.target_lab?;
        Some(Self { lab, conditions: study.judgement.viewing.name(), found: None })
    }

    /// Adds the result of a variant.
    pub fn with(self, maker: Option<&InkMaker>) -> Self {
        Self { found: maker.and_then(AimFound::of), ..self }
    }

    /// Formats the target: `L* 70, a* 5, b* −40 (D65, 2° observer)`.
    pub fn in_words(&self) -> String {
        let [l, a, b] = self.lab.map(|x| x.to_string().replace('-', "−"));
        format!("L* {l}, a* {a}, b* {b} ({})", self.conditions)
    }
}
