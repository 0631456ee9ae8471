//! The colour that a variant shall have, and how near to it it has come.

use crate::evaluate::ink_maker::InkMaker;
use crate::input::study::Study;
use crate::numerics::estimate::Estimate;

/// What `[colour] target_lab` of a variant asks.
#[derive(Clone, Debug, PartialEq)]
pub struct Aim {
    /// L*, a*, b* wanted.
    pub lab: [f64; 3],
    /// Light, observer and rule of summation; lit at 45°, seen along the normal.
    pub conditions: String,
    /// What the variant has, once it has a colour.
    pub found: Option<AimFound>,
}

/// The ink maker's numbers of a variant with an aim.
#[derive(Clone, Debug, PartialEq)]
pub struct AimFound {
    /// ΔE₀₀ to the wanted colour.
    pub delta_e_2000: Estimate,
    /// Number of each realisation and what it moves the difference by.
    pub deviations: Vec<(usize, f64)>,
    /// Y over black divided by Y over white.
    pub contrast_ratio: Estimate,
    /// `#rrggbb` of the print, adapted to the light.
    pub hex: String,
}

impl AimFound {
    /// The numbers of a variant that states a colour.
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
    /// The aim of a study that states one.
    pub fn of(study: &Study) -> Option<Self> {
        let lab = study.judgement.target_lab?;
        Some(Self { lab, conditions: study.judgement.viewing.name(), found: None })
    }

    /// The target together with the result of a variant.
    pub fn with(self, maker: Option<&InkMaker>) -> Self {
        Self { found: maker.and_then(AimFound::of), ..self }
    }

    /// `L* 70, a* 5, b* −40 (D65, 2° observer)`.
    pub fn in_words(&self) -> String {
        let [l, a, b] = self.lab.map(|x| x.to_string().replace('-', "−"));
        format!("L* {l}, a* {a}, b* {b} ({})", self.conditions)
    }
}
