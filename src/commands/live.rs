//! Pages while the work goes on: written anew from what is finished, so that they can be opened at any time.

use super::progress::Progress;
use super::say::note;
use inkwave::run::watch::{Event, RunWatch};
use inkwave::store::folder::OutputFolder;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Least time between two pages.
const PAUSE: Duration = Duration::from_secs(20);
/// Pages take at most one part in so many of the run's time.
const SHARE: u32 = 20;
/// The page of a folder.
const PAGE: &str = "report.html";

/// When the next page is due, and whether it was said that there is one.
struct Rhythm {
    due: Instant,
    told: bool,
}

impl Rhythm {
    /// A first page is due after a pause.
    fn new() -> Self {
        Self { due: Instant::now() + PAUSE, told: false }
    }

    /// Lets `write` write the page when it is due. That it cannot be written now is no reason to stop: the end of the run
    /// will say so.
    fn keep(&mut self, folder: &OutputFolder, write: impl FnOnce() -> bool) {
        let clock = Instant::now();
        let page = folder.path().join(PAGE);
        if clock < self.due || is_new(&page) {
            return;
        }
        let written = write();
        self.due = Instant::now() + PAUSE.max(SHARE * clock.elapsed());
        if written && !self.told {
            self.told = true;
            note(format_args!("{} shows what is finished, and is written anew now and then", page.display()));
        }
    }
}

/// Whether a page was written a short time ago: by another process that works on the same sweep.
fn is_new(page: &Path) -> bool {
    let age = page.metadata().and_then(|file| file.modified()).map(|time| time.elapsed().unwrap_or_default());
    age.is_ok_and(|age| age < PAUSE)
}

/// Passes the progress of a run on and writes its pages when they are due.
pub struct Live<'a> {
    progress: &'a Progress,
    folder: &'a OutputFolder,
    pages: Mutex<(Rhythm, Box<Write<'a>>)>,
}

/// Writes the pages; false where that fails.
pub type Write<'a> = dyn FnMut() -> bool + Send + 'a;

impl<'a> Live<'a> {
    /// A first page is due after a pause.
    pub fn new(folder: &'a OutputFolder, progress: &'a Progress, write: Box<Write<'a>>) -> Self {
        Self { progress, folder, pages: Mutex::new((Rhythm::new(), write)) }
    }

    /// Writes the pages when they are due, while the other threads go on.
    fn show(&self) {
        // another thread writes them now, or has failed at it
        let Ok(mut pages) = self.pages.try_lock() else { return };
        let (rhythm, write) = &mut *pages;
        rhythm.keep(self.folder, || !self.progress.stop() && write());
    }
}

impl RunWatch for Live<'_> {
    fn stop(&self) -> bool {
        self.progress.stop()
    }

    fn hear(&self, event: Event) {
        self.progress.hear(event);
        if matches!(event, Event::Kept(_) | Event::Solved(..)) {
            self.show();
        }
    }
}
