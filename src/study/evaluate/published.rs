//! Published numbers by name: what each of them is and can be, for the manifests, gates, tables and
//! pages of plain and of composed layers.

use super::uncertainty::nothing;
use crate::numerics::estimate::Estimate;
use serde::{Deserialize, Serialize};

/// Kind of a published number, which sets its allowed range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A share of the light, such as R or T: 0 to 1.
    Share,
    /// A reflectance factor in one direction, such as 45:0; a perfect white has 1.
    Factor,
    /// A quantity with a unit that is 0 or more, such as a coefficient, a length or a density.
    Size,
    /// A quantity that is above 0, such as a mean free path or an index.
    Positive,
    /// A mean cosine: −1 to 1.
    Cosine,
}

/// A number that was withheld.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Withheld {
    /// Which number.
    pub number: String,
    /// The reason.
    pub reason: String,
}

impl Withheld {
    /// The number and the reason in one line.
    pub fn in_words(&self) -> String {
        format!("{}: {}", self.number, self.reason)
    }
}

/// A number with its standard error and what that is made of, all in the number's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorParts {
    /// The number.
    pub value: f64,
    /// One standard error: the root of the sum of the squares of all that follow.
    pub standard_error: f64,
    /// Jackknife over the realisations of all portions.
    pub chance: f64,
    /// The error of composing incoherently: what slabs of half the thickness change, beyond chance.
    pub model: f64,
    /// What the grid's error of R changes; of parts of a stack that is solved as a whole all that
    /// is not chance.
    pub grid: f64,
    /// What few directions leave open: the changes when fringes between them follow from one less,
    /// and when scattered light loses the highest moment that they resolve.
    pub directions: f64,
    /// Of colours, what the spectrum may be between and beyond the wavelengths.
    pub wavelengths: f64,
    /// Errors of the tables of indices, taken as common to all wavelengths; absent without any.
    #[serde(skip_serializing_if = "nothing")]
    pub inputs: f64,
}

impl ErrorParts {
    /// With the sum of its parts.
    pub fn summed(self) -> Self {
        let parts = [self.chance, self.model, self.grid, self.directions, self.wavelengths, self.inputs];
        Self { standard_error: parts.into_iter().fold(0.0, f64::hypot), ..self }
    }

    /// With a further error of the model.
    pub fn with_model(self, further: f64) -> Self {
        let standard_error = self.standard_error.hypot(further);
        Self { standard_error, model: self.model.hypot(further), ..self }
    }

    /// As a value with its standard error.
    pub fn estimate(&self) -> Estimate {
        Estimate { value: self.value, standard_error: Some(self.standard_error) }
    }
}

/// A weighted number that the study asks for, with its error and what that is made of; `null` is a
/// number that is withheld as impossible.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NumberNote {
    /// Its name in the study.
    pub name: String,
    /// Thickness of the layer, µm, of layers composed for a list of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thickness_um: Option<f64>,
    /// The number.
    pub value: Option<f64>,
    /// One standard error: the root of the sum of the squares of all that follow; `null` if a
    /// single realisation leaves it unknown.
    pub standard_error: Option<f64>,
    /// What it is made of.
    pub parts: NumberParts,
    /// Number of each realisation and its contribution; numbers of the same realisations have
    /// correlated errors.
    #[serde(skip)]
    pub deviations: Vec<(usize, f64)>,
    /// What it is, in words.
    pub about: String,
}

/// Contributions to the error of a weighted number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NumberParts {
    /// Jackknife over the realisations.
    pub chance: f64,
    /// What composing slabs changes, beyond chance; 0 of layers that are solved as a whole.
    pub model: f64,
    /// The grid and the solver's residual.
    pub grid: f64,
    /// How few directions stand for the light in a composed layer.
    pub directions: f64,
    /// What the spectrum may be between and beyond the wavelengths.
    pub wavelengths: f64,
    /// Errors of the tables of indices.
    pub inputs: f64,
}

impl NumberParts {
    /// The root of the sum of their squares.
    pub fn together(&self) -> f64 {
        let Self { chance, model, grid, directions, wavelengths, inputs } = *self;
        [chance, model, grid, directions, wavelengths, inputs].into_iter().fold(0.0, f64::hypot)
    }
}

impl NumberNote {
    /// The number with its standard error; `None` if it is withheld.
    pub fn estimate(&self) -> Option<Estimate> {
        Some(Estimate { value: self.value?, standard_error: self.standard_error })
    }
}

/// A published number of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NamedNumber {
    /// Its key in `results.json` and its column in tables, which also tells unit and meaning.
    pub name: &'static str,
    /// What it is in words, for the reason why it is withheld.
    pub in_words: &'static str,
    /// What it can be.
    pub quantity: Quantity,
    /// Its value and standard error; `None` if it is withheld.
    pub estimate: Option<Estimate>,
}

/// A row of published numbers, such as a layer at one wavelength.
pub trait PublishedRow {
    /// Names of the columns that tell which row it is.
    const PLACE: &'static [&'static str];

    /// Names of its numbers, in the order of tables.
    fn names() -> Vec<&'static str>;

    /// Values of the columns that tell which row it is.
    fn place(&self) -> Vec<f64>;

    /// Vacuum wavelength, nm.
    fn wavelength_nm(&self) -> f64;

    /// Its numbers, in that order.
    fn numbers(&self) -> Vec<NamedNumber>;
}

/// A struct of numbers of one type, which are named once: as fields, as keys of `results.json` and
/// as columns of tables. Each has the [`Quantity`] that it is, and words if its name does not do.
macro_rules! named_numbers {
    (@words $field:ident) => { stringify!($field) };
    (@words $field:ident $words:literal) => { $words };
    (
        $(#[$about:meta])* pub struct $name:ident {
            $( $(#[$doc:meta])* $field:ident: $quantity:ident $($words:literal)?, )*
        }
    ) => {
        $(#[$about])* #[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)] pub struct $name<T> {
            $( $(#[$doc])* pub $field: T, )*
        }

        impl<T> $name<T> {
            /// Names of all numbers.
            pub fn names() -> Vec<&'static str> {
                vec![$( stringify!($field), )*]
            }

            /// New numbers, each from those of its name here and in `other`.
            pub fn zipped<V, U>(self, other: $name<V>, number: impl Fn(T, V) -> U) -> $name<U> {
                $name { $( $field: number(self.$field, other.$field), )* }
            }

            /// New numbers, each from this one.
            pub fn map<U>(self, mut number: impl FnMut(T) -> U) -> $name<U> {
                $name { $( $field: number(self.$field), )* }
            }
        }

        impl<T: Copy> $name<T> {
            /// New numbers, each from those of its name in all `rows`.
            pub fn combined<U>(rows: &[Self], number: impl Fn(&[T]) -> U) -> $name<U> {
                let combine = |field: fn(&Self) -> T| number(&rows.iter().map(field).collect::<Vec<T>>());
                $name { $( $field: combine(|row| row.$field), )* }
            }
        }

        impl $name<Option<$crate::evaluate::published::ErrorParts>> {
            /// All numbers with their names.
            pub fn named(&self) -> Vec<$crate::evaluate::published::NamedNumber> {
                vec![$( $crate::evaluate::published::NamedNumber {
                    name: stringify!($field),
                    in_words: named_numbers!(@words $field $($words)?),
                    quantity: $crate::evaluate::published::Quantity::$quantity,
                    estimate: self.$field.map(|number| number.estimate()),
                }, )*]
            }

            /// Leaves out the number of this name.
            pub fn withhold(&mut self, name: &str) {
                $( if name == stringify!($field) { self.$field = None; } )*
            }
        }
    };
}
pub(super) use named_numbers;
