//! The published quantities of a composed layer by name, as values or as values with errors.

use super::prints::PrintNumbers;
use super::published::named_numbers;

named_numbers! {
    /// A layer at one wavelength; R and T are shares of the incident light.
    pub struct LayerNumbers {
        /// R of light at 0°.
        reflectance_normal: Share,
        /// T of light at 0°.
        transmittance_normal: Share,
        /// R of light at 45°.
        reflectance_45: Share,
        /// T of light at 45°.
        transmittance_45: Share,
        /// R of diffuse light.
        reflectance_diffuse: Share,
        /// T of diffuse light.
        transmittance_diffuse: Share,
        /// Ā of unpolarised diffuse light from behind, as the paper sends it.
        absorptance_behind: Share,
        /// Coherent transmittance at 0°, |⟨t⟩|²: what goes straight on, unscattered. (⟨|t|²⟩ of
        /// one order, as single cells have it, depends on the size of the cell: a composed layer
        /// has none.)
        coherent_transmittance: Share,
        /// Share of light at 0° that is mirrored.
        mirrored: Share,
        /// On the paper, under a uniform sky, seen along the normal; a perfect white: 1.
        natural_light: Share,
        /// On the paper, lit at 45° and seen along the normal: π × BRDF.
        lit_at_45: Factor,
        /// At 45:0 over black.
        over_black: Factor,
        /// At 45:0 over white of albedo 0.8.
        over_white: Factor,
    }
}

named_numbers! {
    /// What the packed medium is to light of one wavelength.
    pub struct MediumNumbers {
        /// Index of the mean wave, from its phase behind an inner slab.
        effective_index: Positive "effective index",
        /// Mean free path of coherent light, µm.
        coherent_path_um: Positive "mean free path of coherent light",
        /// k_s of the medium with the slab's coherent transmittance, R̄ and Ā, 1/µm.
        scattering_per_um: Size "scattering coefficient",
        /// k_a of that medium, 1/µm.
        absorption_per_um: Size "absorption coefficient",
        /// g of that medium.
        asymmetry: Cosine "asymmetry",
        /// Transport mean free path 1/(k_s (1 − g)), µm.
        transport_path_um: Positive "transport mean free path",
        /// Kubelka and Munk's K of a thick layer without surfaces, 1/µm.
        kubelka_munk_absorption_per_um: Size "Kubelka and Munk's K",
        /// Their S, 1/µm.
        kubelka_munk_scattering_per_um: Size "Kubelka and Munk's S",
    }
}

/// L*, a*, b* under D65 for the CIE 1931 observer.
pub type Lab<T> = [T; 3];

/// Colours of a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourNumbers<T> {
    /// On the paper under natural light.
    pub natural_light: Lab<T>,
    /// On the paper at 45:0.
    pub lit_at_45: Lab<T>,
    /// At 45:0 over black.
    pub over_black: Lab<T>,
    /// Y over black by Y over white, at 45:0 (ISO 6504-3).
    pub contrast_ratio: T,
    /// X, Y, Z under natural light and at 45:0 beyond those of the factors, where light that the
    /// paper emits under a lamp with lines is no part of these; 0 elsewhere.
    pub beyond_factors: [Lab<T>; 2],
}

/// BRDF and BTDF of light at 0° in the directions of the media in front and behind, 1/sr.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution<T> {
    /// \[node of the medium in front\]
    pub reflected: Vec<T>,
    /// \[node of the medium behind\]
    pub transmitted: Vec<T>,
}

/// A layer of one thickness.
#[derive(Clone, Debug, PartialEq)]
pub struct ThicknessNumbers<T> {
    /// \[wavelength\]
    pub spectra: Vec<LayerNumbers<T>>,
    /// Its colours, where the wavelengths carry any.
    pub colours: Option<ColourNumbers<T>>,
    /// The weighted numbers that the study asks for, in its order.
    pub weighted: Vec<T>,
    /// Its prints, where there are any besides the solid on plain paper.
    pub prints: Vec<PrintNumbers<T>>,
}

/// The thickness that hides, between two whole numbers of slabs.
#[derive(Clone, Debug, PartialEq)]
pub struct HidingNumbers<T> {
    /// The thickest layer of whole slabs that does not hide.
    pub below: ThicknessNumbers<T>,
    /// The thinnest one that does.
    pub above: ThicknessNumbers<T>,
    /// Thickness at which the contrast ratio passes what counts as hiding, µm.
    pub thickness_um: T,
}

/// Densities at 45:0 of a stack of layers at one wavelength: −log₁₀ of the radiance factor over
/// that of the bare paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensityNumbers<T> {
    /// Of the stack.
    pub stack: T,
    /// The sum of those of its layers, each alone.
    pub layers: T,
    /// The first over the second: 1 where the layers only filter each other's light.
    pub ratio: T,
}

/// What a stack of one thickness is without its layers, and what these are by themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOutNumbers<T> {
    /// The stack without the layer, \[layer\].
    pub without: Vec<ThicknessNumbers<T>>,
    /// The layer alone, \[layer\].
    pub alone: Vec<ThicknessNumbers<T>>,
    /// \[wavelength\]
    pub densities: Vec<DensityNumbers<T>>,
}

/// All numbers of a composed layer.
#[derive(Clone, Debug, PartialEq)]
pub struct ComposedNumbers<T> {
    /// \[thickness that the study requests\]
    pub requested: Vec<ThicknessNumbers<T>>,
    /// \[thickness of the curve\]
    pub curve: Vec<ThicknessNumbers<T>>,
    /// The thickness that hides, if any does.
    pub hiding: Option<HidingNumbers<T>>,
    /// \[wavelength\]
    pub medium: Vec<MediumNumbers<T>>,
    /// \[thickness that the study requests\]\[wavelength\]
    pub distributions: Vec<Vec<Distribution<T>>>,
    /// Of a stack: share of light at 0° that each layer absorbs, without paper, \[thickness that
    /// the study requests\]\[wavelength\]\[layer\].
    pub absorbed: Vec<Vec<Vec<T>>>,
    /// Of a stack of several layers, \[thickness that the study requests\].
    pub left_out: Vec<LeftOutNumbers<T>>,
}

/// A new list, item by item from both.
fn each<A, B, C>(one: Vec<A>, other: Vec<B>, item: impl Fn(A, B) -> C) -> Vec<C> {
    assert_eq!(one.len(), other.len(), "numbers of different layers");
    one.into_iter().zip(other).map(|(a, b)| item(a, b)).collect()
}

impl ColourNumbers<f64> {
    /// NaN for all of them.
    pub fn unknown() -> Self {
        let lab = [f64::NAN; 3];
        Self {
            natural_light: lab,
            lit_at_45: lab,
            over_black: lab,
            contrast_ratio: f64::NAN,
            beyond_factors: [lab; 2],
        }
    }
}

impl<T> ColourNumbers<T> {
    /// New numbers, each from those of its name here and in `other`.
    pub fn zipped<V, U>(self, other: ColourNumbers<V>, number: &impl Fn(T, V) -> U) -> ColourNumbers<U> {
        let lab = |[l, a, b]: Lab<T>, [other_l, other_a, other_b]: Lab<V>| {
            [number(l, other_l), number(a, other_a), number(b, other_b)]
        };
        ColourNumbers {
            natural_light: lab(self.natural_light, other.natural_light),
            lit_at_45: lab(self.lit_at_45, other.lit_at_45),
            over_black: lab(self.over_black, other.over_black),
            contrast_ratio: number(self.contrast_ratio, other.contrast_ratio),
            beyond_factors: {
                let [natural, lit] = self.beyond_factors;
                let [other_natural, other_lit] = other.beyond_factors;
                [lab(natural, other_natural), lab(lit, other_lit)]
            },
        }
    }

    /// New numbers, each from this one.
    pub fn map<U>(self, number: impl Fn(T) -> U) -> ColourNumbers<U> {
        ColourNumbers {
            natural_light: self.natural_light.map(&number),
            lit_at_45: self.lit_at_45.map(&number),
            over_black: self.over_black.map(&number),
            contrast_ratio: number(self.contrast_ratio),
            beyond_factors: self.beyond_factors.map(|xyz| xyz.map(&number)),
        }
    }
}

impl<T> Distribution<T> {
    fn zipped<V, U>(self, other: Distribution<V>, number: &impl Fn(T, V) -> U) -> Distribution<U> {
        Distribution {
            reflected: each(self.reflected, other.reflected, number),
            transmitted: each(self.transmitted, other.transmitted, number),
        }
    }
}

impl<T> ThicknessNumbers<T> {
    fn zipped<V, U>(self, other: ThicknessNumbers<V>, number: &impl Fn(T, V) -> U) -> ThicknessNumbers<U> {
        ThicknessNumbers {
            spectra: each(self.spectra, other.spectra, |a, b| a.zipped(b, number)),
            colours: self.colours.zip(other.colours).map(|(a, b)| a.zipped(b, number)),
            weighted: each(self.weighted, other.weighted, number),
            prints: each(self.prints, other.prints, |a, b| a.zipped(b, number)),
        }
    }
}

impl<T> DensityNumbers<T> {
    fn zipped<V, U>(self, other: DensityNumbers<V>, number: &impl Fn(T, V) -> U) -> DensityNumbers<U> {
        DensityNumbers {
            stack: number(self.stack, other.stack),
            layers: number(self.layers, other.layers),
            ratio: number(self.ratio, other.ratio),
        }
    }
}

impl<T> LeftOutNumbers<T> {
    fn zipped<V, U>(self, other: LeftOutNumbers<V>, number: &impl Fn(T, V) -> U) -> LeftOutNumbers<U> {
        LeftOutNumbers {
            without: each(self.without, other.without, |a, b| a.zipped(b, number)),
            alone: each(self.alone, other.alone, |a, b| a.zipped(b, number)),
            densities: each(self.densities, other.densities, |a, b| a.zipped(b, number)),
        }
    }
}

impl<T> HidingNumbers<T> {
    fn zipped<V, U>(self, other: HidingNumbers<V>, number: &impl Fn(T, V) -> U) -> HidingNumbers<U> {
        HidingNumbers {
            below: self.below.zipped(other.below, number),
            above: self.above.zipped(other.above, number),
            thickness_um: number(self.thickness_um, other.thickness_um),
        }
    }
}

impl<T> ComposedNumbers<T> {
    /// Of the requested thicknesses alone.
    pub fn of_requested(requested: Vec<ThicknessNumbers<T>>) -> Self {
        Self {
            requested,
            curve: Vec::new(),
            hiding: None,
            medium: Vec::new(),
            distributions: Vec::new(),
            absorbed: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// New numbers, each from those of its name and place here and in `other`, which is of the same
    /// layer.
    pub fn zipped<V, U>(self, other: ComposedNumbers<V>, number: impl Fn(T, V) -> U) -> ComposedNumbers<U> {
        let number = &number;
        ComposedNumbers {
            requested: each(self.requested, other.requested, |a, b| a.zipped(b, number)),
            curve: each(self.curve, other.curve, |a, b| a.zipped(b, number)),
            hiding: self.hiding.zip(other.hiding).map(|(a, b)| a.zipped(b, number)),
            medium: each(self.medium, other.medium, |a, b| a.zipped(b, number)),
            distributions: each(self.distributions, other.distributions, |a, b| {
                each(a, b, |a, b| a.zipped(b, number))
            }),
            absorbed: each(self.absorbed, other.absorbed, |a, b| each(a, b, |a, b| each(a, b, number))),
            left_out: each(self.left_out, other.left_out, |a, b| a.zipped(b, number)),
        }
    }

    /// New numbers, each from this one.
    pub fn map<U>(self, number: impl Fn(T) -> U) -> ComposedNumbers<U>
    where
        T: Clone,
    {
        let same = self.clone();
        self.zipped(same, |value, _| number(value))
    }
}

impl<T: Clone> ComposedNumbers<T> {
    /// The values of every number in all of these, which are of the same layer; `None` of none.
    pub fn gathered(all: Vec<Self>) -> Option<ComposedNumbers<Vec<T>>> {
        let mut rest = all.into_iter();
        let first = rest.next()?.map(|value| vec![value]);
        Some(rest.fold(first, |gathered, next| {
            gathered.zipped(next, |mut values, value| {
                values.push(value);
                values
            })
        }))
    }
}
