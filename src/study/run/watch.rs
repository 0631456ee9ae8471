//! Observes a running study and can stop it; why a run ends early.

use crate::ink::PackError;
use crate::input::study::{Point, Study};
use crate::solve::GridTrial;
use crate::solve::accuracy::AccuracyError;
use crate::solve::demand::TooLarge;
use crate::store::folder::FolderError;
use crate::store::queue::{QueueError, QueueStanding};
use crate::wave::WaveError;
use std::io;

/// An event of a run.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// A stage other than the solves begins, such as "packing realisation 2".
    Stage(&'a str),
    /// The search of a grid, which has its own stage, tries one or knows its error.
    Grid(&'a GridTrial),
    /// Packing and solving begin: what is under way ends in order when the run is stopped.
    Begun,
    /// No packing or solve is under way; what follows uses what is stored, so nothing is lost if
    /// the process ends at once.
    Over,
    /// Progress of all workers of a folder.
    Standing(&'a QueueStanding),
    /// A solve begins.
    Solving(&'a Study, &'a Point),
    /// Number of solves that are already stored.
    Kept(usize),
    /// Number of solves that cannot be computed for lack of a packing or a grid.
    Dropped(usize),
    /// A solve has ended, successfully or not.
    Ended,
    /// A solve is stored, or has failed for the given reason.
    Solved(&'a Point, Option<&'a str>),
}

/// Receives the events of a run, from several threads.
pub trait RunWatch: Sync {
    /// True if the run should stop; checked at every step of solvers and packings.
    fn stop(&self) -> bool {
        false
    }

    /// Receives an event.
    fn hear(&self, _event: Event) {}

    /// Announces a stage.
    fn stage(&self, what: &str) {
        self.hear(Event::Stage(what));
    }
}

/// Ignores all events and never stops.
impl RunWatch for () {}

/// Why a run has no results.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A part of the study, such as a layer of a stack, has no result.
    #[error("{name}: {source}")]
    Part {
        /// Its name.
        name: String,
        /// The reason.
        source: Box<RunError>,
    },
    /// A realisation could not be packed.
    #[error("realisation {}: {source}", realisation + 1)]
    Packing {
        /// Number of the realisation, from 0.
        realisation: usize,
        /// The reason.
        source: PackError,
    },
    /// No grid reaches the requested accuracy.
    #[error(transparent)]
    Resolution(#[from] AccuracyError),
    /// The solves do not fit into memory.
    #[error(transparent)]
    Memory(#[from] TooLarge),
    /// The scene cannot be discretised.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The output folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A record could not be stored.
    #[error("cannot store a result: {0}")]
    Store(#[from] io::Error),
    /// The queue of tasks failed.
    #[error(transparent)]
    Queue(#[from] QueueError),
    /// Threads could not be started.
    #[error("cannot start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The user asked to stop; finished solves are kept.
    #[error("stopped before the first solve")]
    Stopped,
}

impl RunError {
    /// The error of a part of this name; of the study itself where the name is empty.
    pub fn of_part(self, name: &str) -> Self {
        match name {
            "" => self,
            name => Self::Part { name: name.to_owned(), source: Box::new(self) },
        }
    }

    /// The error itself, without the name of the part.
    pub fn cause(&self) -> &Self {
        if let Self::Part { source, .. } = self { source.cause() } else { self }
    }

    /// Turns every error caused by a stop into [`RunError::Stopped`]: a stop is not a failure of
    /// packing or grid.
    pub fn stopped(self) -> Self {
        match self {
            Self::Packing { source: PackError::Stopped { .. }, .. } | Self::Wave(WaveError::Stopped) => {
                Self::Stopped
            }
            Self::Resolution(error) if error.is_stop() => Self::Stopped,
            other => other,
        }
    }

    /// True if the study itself is the cause, so that another one may well have results: its grains
    /// find no room, or no grid reaches its accuracy.
    pub fn is_of_the_study(&self) -> bool {
        match self.cause() {
            Self::Resolution(error) => !error.is_stop(),
            Self::Wave(error) => *error != WaveError::Stopped,
            other => other.has_no_room(),
        }
    }

    /// True if the grains of one realisation found no room, which does not affect the others.
    pub fn has_no_room(&self) -> bool {
        matches!(
            self.cause(),
            Self::Packing { source: PackError::Blocked { .. } | PackError::NotReached { .. }, .. }
        )
    }
}
