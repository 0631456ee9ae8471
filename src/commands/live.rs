//! Report pages during a run: rewritten from the finished solves, so that they can be opened at any
//! time.

use super::progress::Progress;
use super::say::note;
use inkwave::input::study::{Point, Study};
use inkwave::report::publish::publish;
use inkwave::run::runner::Collected;
use inkwave::run::watch::RunWatch;
use inkwave::store::folder::OutputFolder;
use inkwave::store::queue::QueueStanding;
use inkwave::sweep::Sweep;
use inkwave::sweep::publish::Publisher;
use std::cell::RefCell;
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
            note(format_args!("{} shows the finished solves and is updated during the run", page.display()));
        }
    }
}

/// Whether the page was written recently, for example by another process working on the same sweep.
fn is_new(page: &Path) -> bool {
    let age = page.metadata().and_then(|file| file.modified()).map(|time| time.elapsed().unwrap_or_default());
    age.is_ok_and(|age| age < PAUSE)
}

/// Keeps the page of a running study up to date.
pub struct LivePage<'a> {
    study: &'a Study,
    folder: &'a OutputFolder,
    rhythm: RefCell<Rhythm>,
}

impl<'a> LivePage<'a> {
    /// Schedules the first page after a pause.
    pub fn new(study: &'a Study, folder: &'a OutputFolder) -> Self {
        Self { study, folder, rhythm: RefCell::new(Rhythm::new()) }
    }

    /// Writes the page when it is due.
    pub fn show(&self, collected: &Collected) {
        let write = || publish(self.study, collected, self.folder).is_ok();
        self.rhythm.borrow_mut().keep(self.folder, write);
    }
}

/// Forwards a sweep's progress and keeps its pages up to date.
pub struct LiveSweep<'a> {
    progress: &'a Progress,
    folder: &'a OutputFolder,
    page: Mutex<(Rhythm, Publisher<'a>)>,
}

impl<'a> LiveSweep<'a> {
    /// Schedules the first page after a pause.
    pub fn new(sweep: &'a Sweep, folder: &'a OutputFolder, progress: &'a Progress) -> Self {
        Self { progress, folder, page: Mutex::new((Rhythm::new(), Publisher::new(sweep))) }
    }

    /// Writes the pages if they are due, while the other threads continue.
    fn show(&self) {
        // another thread is writing them now, or has panicked while doing so
        let Ok(mut page) = self.page.try_lock() else { return };
        let (rhythm, publisher) = &mut *page;
        rhythm.keep(self.folder, || !self.progress.stop() && publisher.publish(self.folder).is_ok());
    }
}

impl RunWatch for LiveSweep<'_> {
    fn stop(&self) -> bool {
        self.progress.stop()
    }

    fn begins(&self, study: &Study, kept: usize) {
        self.progress.begins(study, kept);
    }

    fn stage(&self, what: &str) {
        self.progress.stage(what);
    }

    fn standing(&self, standing: &QueueStanding) {
        self.progress.standing(standing);
    }

    fn solving(&self, study: &Study, point: &Point) {
        self.progress.solving(study, point);
    }

    fn kept(&self, study: &Study, solves: usize) {
        self.progress.kept(study, solves);
        self.show();
    }

    fn ended(&self) {
        self.progress.ended();
    }

    fn solved(&self, study: &Study, point: &Point, failure: Option<&str>) {
        self.progress.solved(study, point, failure);
        self.show();
    }
}
