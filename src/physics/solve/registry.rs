//! Registry of strategies by name.
//!
//! The built-in strategies are listed once, in `built_in!`, which generates their names, the choice
//! in study files ([`SolverChoice`]) and the registry used by comparisons, the dense reference and
//! the claims. Strategies of other crates are added with [`Registry::with`].

use super::strategies::{Bicgstab, Born, ConvergentBorn, Direct, Gmres, Idr, Relaxation};
use super::{SolveError, Solver};

/// Constructs a strategy with its default settings.
type Make = Box<dyn Fn() -> Box<dyn Solver> + Send + Sync>;

/// One strategy of a registry.
pub struct Entry {
    /// Name of the strategy.
    pub name: String,
    /// One-line description that helps to choose.
    pub description: String,
    make: Make,
}

impl Entry {
    /// Constructs the strategy with its default settings.
    pub fn build(&self) -> Box<dyn Solver> {
        (self.make)()
    }
}

/// Strategies by name, in the order of tables; [`Registry::default`] holds the built-in ones.
///
/// ```
/// use inkwave_physics::solve::{Gmres, Registry};
///
/// let registry = Registry::default().with("short memory", "GMRES restarted after 10 steps", || {
///     Box::new(Gmres { restart: 10, ..Gmres::default() })
/// })?;
/// assert_eq!(registry.names().last(), Some("short memory"));
/// assert!(registry.build("krilov").is_err());
/// # Ok::<(), inkwave_physics::solve::SolveError>(())
/// ```
pub struct Registry {
    entries: Vec<Entry>,
}

impl Registry {
    /// Adds a strategy.
    ///
    /// # Errors
    /// [`SolveError::Setting`] if the name is empty or taken.
    pub fn with(
        mut self,
        name: &str,
        description: &str,
        make: impl Fn() -> Box<dyn Solver> + Send + Sync + 'static,
    ) -> Result<Registry, SolveError> {
        if name.trim().is_empty() || self.entries.iter().any(|e| e.name == name) {
            let value = format!("{name:?}");
            let allowed = format!("any but {}", self.list());
            return Err(SolveError::setting("name of the strategy", value, &allowed, "choose another name"));
        }
        self.entries.push(Entry { name: name.into(), description: description.into(), make: Box::new(make) });
        Ok(self)
    }

    /// All strategies, in order.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// All names, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|e| e.name.as_str())
    }

    /// Constructs the strategy of that name with its default settings.
    ///
    /// # Errors
    /// [`SolveError::Setting`] with the known names, if the name is unknown.
    pub fn build(&self, name: &str) -> Result<Box<dyn Solver>, SolveError> {
        let known = self.entries.iter().find(|e| e.name == name);
        known.map(Entry::build).ok_or_else(|| unknown(name, self.list()))
    }

    fn list(&self) -> String {
        self.names().collect::<Vec<_>>().join(", ")
    }
}

fn unknown(name: &str, known: String) -> SolveError {
    SolveError::setting("solver", name, &known, "choose one of these")
}

/// Generates the choice, its names and the registry from the list of built-in strategies.
macro_rules! built_in {
    ($($name:literal => $variant:ident($settings:ty), $description:literal;)+) => {
        /// A built-in strategy with its settings, as a study file writes it.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        pub enum SolverChoice {
            $(
                #[doc = $description]
                #[cfg_attr(feature = "serde", serde(rename = $name))]
                $variant($settings),
            )+
        }

        impl SolverChoice {
            /// All names, the default first.
            pub const NAMES: &'static [&'static str] = &[$($name),+];

            /// The strategy of that name with its default settings.
            ///
            /// # Errors
            /// [`SolveError::Setting`] with the known names, if the name is unknown.
            pub fn named(name: &str) -> Result<SolverChoice, SolveError> {
                match name {
                    $($name => Ok(SolverChoice::$variant(Default::default())),)+
                    _ => Err(unknown(name, Self::NAMES.join(", "))),
                }
            }

            /// Constructs the strategy with these settings.
            pub fn build(&self) -> Box<dyn Solver> {
                match *self {
                    $(SolverChoice::$variant(settings) => Box::new(settings),)+
                }
            }
        }

        impl Default for Registry {
            fn default() -> Registry {
                let entries = vec![$(Entry {
                    name: $name.into(),
                    description: $description.into(),
                    make: Box::new(|| Box::new(<$settings>::default())),
                }),+];
                Registry { entries }
            }
        }
    };
}

built_in! {
    "krylov" => Krylov(Gmres), "GMRES; guided modes of the mean slab and the lowest harmonics of strong scatterers are solved exactly.";
    "bicgstab" => Bicgstab(Bicgstab), "BiCGSTAB: little memory, erratic without absorption.";
    "idr" => Idr(Idr), "IDR(s): short recurrences for strong scatterers without absorption.";
    "born" => Born(Born), "The Born series (P2 section 2): plain and fast where it converges.";
    "convergent_born" => ConvergentBorn(ConvergentBorn), "The convergent Born series: sure and slow.";
    "relaxation" => Relaxation(Relaxation), "The source paper's relaxation (P2 section 3), with its sign corrected.";
    "direct" => Direct(Direct), "Dense LU for tiny grids: the referee.";
}

impl Default for SolverChoice {
    fn default() -> SolverChoice {
        SolverChoice::Krylov(Gmres::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_agree_everywhere() {
        let registry = Registry::default();
        assert!(registry.names().eq(SolverChoice::NAMES.iter().copied()));
        for entry in registry.entries() {
            let choice = SolverChoice::named(&entry.name).expect("a built-in name");
            assert_eq!(choice.build().name(), entry.build().name());
            let written = serde_json::to_value(choice).expect("settings are plain");
            assert!(written.get(&entry.name).is_some(), "{written}");
        }
    }

    #[test]
    fn a_taken_name_is_refused() {
        let twice = Registry::default().with("born", "again", || Box::new(Born::default()));
        assert!(twice.is_err_and(|e| e.to_string().contains("born")));
    }
}
