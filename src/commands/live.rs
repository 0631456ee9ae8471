//! The page of a study while it runs: written anew from what is finished, so that it can be opened at any time.

use super::say::note;
use inkwave::input::study::Study;
use inkwave::report::publish::publish;
use inkwave::run::runner::Collected;
use inkwave::store::folder::OutputFolder;
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Least time between two pages.
const PAUSE: Duration = Duration::from_secs(20);
/// Pages take at most one part in so many of the run's time.
const SHARE: u32 = 20;

/// Writes the page now and then.
pub struct LivePage<'a> {
    study: &'a Study,
    folder: &'a OutputFolder,
    due: Cell<Instant>,
    told: Cell<bool>,
}

impl<'a> LivePage<'a> {
    /// A first page is due after a pause.
    pub fn new(study: &'a Study, folder: &'a OutputFolder) -> Self {
        Self { study, folder, due: Cell::new(Instant::now() + PAUSE), told: Cell::new(false) }
    }

    /// Writes the page when it is due. That it cannot be written now is no reason to stop: the end of the run will say so.
    pub fn show(&self, collected: &Collected) {
        let clock = Instant::now();
        if clock < self.due.get() {
            return;
        }
        let written = publish(self.study, collected, self.folder);
        self.due.set(Instant::now() + PAUSE.max(SHARE * clock.elapsed()));
        if written.is_ok() && !self.told.replace(true) {
            let page = self.folder.path().join("report.html");
            note(format_args!("{} shows what is finished, and is written anew now and then", page.display()));
        }
    }
}
