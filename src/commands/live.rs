//! Report pages during a run: rewritten from the finished solves, so that they can be opened at any
//! time.

use super::progress::Progress;
use inkwave::run::watch::{Event, RunWatch};
use inkwave::store::folder::OutputFolder;
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Shortest time between two versions of a page.
const PAUSE: Duration = Duration::from_secs(20);
/// Writing pages takes at most 1/`SHARE` of the time of a run.
const SHARE: u32 = 20;
/// File name of the page.
const PAGE: &str = "report.html";

/// When the next page is due, and whether the first one has been announced.
struct Rhythm {
    due: Instant,
    told: bool,
}

impl Rhythm {
    /// Schedules the first page after a pause.
    fn new() -> Self {
        Self { due: Instant::now() + PAUSE, told: false }
    }

    /// Calls `write` if a page is due. A failure does not stop the run: it is reported at the end.
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
            note!("{} shows the finished solves and is updated during the run", page.display());
        }
    }
}

/// Whether the page was written recently, for example by another process working on the same sweep.
fn is_new(page: &Path) -> bool {
    let age = page.metadata().and_then(|file| file.modified()).map(|time| time.elapsed().unwrap_or_default());
    age.is_ok_and(|age| age < PAUSE)
}

/// Forwards the progress of a run and keeps its pages up to date.
pub struct Live<'a> {
    progress: &'a Progress,
    folder: &'a OutputFolder,
    pages: Mutex<(Rhythm, Box<Write<'a>>)>,
}

/// Writes the pages; false if that fails.
pub type Write<'a> = dyn FnMut() -> bool + Send + 'a;

impl<'a> Live<'a> {
    /// Schedules the first page after a pause.
    pub fn new(folder: &'a OutputFolder, progress: &'a Progress, write: Box<Write<'a>>) -> Self {
        Self { progress, folder, pages: Mutex::new((Rhythm::new(), write)) }
    }

    /// Writes the pages if they are due, while the other threads continue.
    fn show(&self) {
        // another thread is writing them now, or has panicked while doing so
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
