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

/// Whether the page was written recently, for example by another process working on the same sweep.
fn is_new(page: &Path) -> bool {
    let age = page.metadata().and_then(|file| file.modified()).map(|time| time.elapsed().unwrap_or_default());
    age.is_ok_and(|age| age < PAUSE)
}

/// Forwards the progress of a run and keeps its pages up to date.
pub struct Live<'a> {
    progress: &'a Progress,
    folder: &'a OutputFolder,
    pages: Mutex<Pages<'a>>,
}

/// When the next page is due, whether the first one has been announced, and what writes them.
type Pages<'a> = (Instant, bool, Box<Write<'a>>);

/// Writes the pages; false if that fails.
pub type Write<'a> = dyn FnMut() -> bool + Send + 'a;

impl<'a> Live<'a> {
    pub fn new(folder: &'a OutputFolder, progress: &'a Progress, write: Box<Write<'a>>) -> Self {
        Self { progress, folder, pages: Mutex::new((Instant::now() + PAUSE, false, write)) }
    }

    /// Writes the page if it is due and no other thread is writing. A failure does not stop the
    /// run: it is reported at the end.
    fn show(&self) {
        let Ok(mut pages) = self.pages.try_lock() else { return };
        let (due, told, write) = &mut *pages;
        let (clock, page) = (Instant::now(), self.folder.path().join(PAGE));
        if clock < *due || is_new(&page) {
            return;
        }
        let written = !self.progress.stop() && write();
        *due = Instant::now() + PAUSE.max(SHARE * clock.elapsed());
        if written && !std::mem::replace(told, true) {
            note!("{} shows the finished solves and is updated during the run", page.display());
        }
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
