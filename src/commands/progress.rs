//! Progress of a run: on stderr a progress bar on a terminal, otherwise a line every ten seconds, or
//! as often as `$INKWAVE_PROGRESS_SECONDS` asks; and report pages during the run, rewritten from
//! the finished solves, so that they can be opened at any time.

use super::terminal::StopFlag;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use inkwave::input::study::{Point, Study};
use inkwave::run::watch::{Event, RunWatch};
use inkwave::store::folder::OutputFolder;
use inkwave::store::queue::QueueStanding;
use inkwave::wave::Side;
use std::io::IsTerminal;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Shortest time between two lines of progress: what the environment asks for, which programs that
/// draw a bar of their own do, from a tenth of a second to an hour; else ten seconds.
fn between_lines() -> Duration {
    let asked = std::env::var("INKWAVE_PROGRESS_SECONDS").ok().and_then(|text| text.parse::<f64>().ok());
    Duration::from_secs_f64(asked.filter(|seconds| (0.1..=3600.0).contains(seconds)).unwrap_or(10.0))
}

/// Fewest solves whose mean time is used to estimate the time left.
const TOO_FEW: usize = 20;

/// The style of a bar or a spinner.
pub fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("a template that indicatif knows")
}

/// What a run has done so far.
struct RunState {
    begun: Instant,
    /// Solves that are running.
    under_way: usize,
    /// When the first of them began.
    since: Instant,
    /// Time before that with at least one solve running.
    busy: Duration,
    solved: usize,
    /// Solves that were already stored.
    kept: usize,
    /// Processes that share the work.
    workers: usize,
    /// Whether `run.target_delta_e` may end the run before all solves are done.
    ends_early: bool,
    /// Time of the last line, where there is no progress bar.
    last_line: Instant,
    /// Time from one line to the next.
    between: Duration,
}

impl RunState {
    fn new() -> Self {
        let begun = Instant::now();
        Self {
            begun,
            under_way: 0,
            since: begun,
            busy: Duration::ZERO,
            solved: 0,
            kept: 0,
            workers: 1,
            ends_early: false,
            last_line: begun,
            between: between_lines(),
        }
    }

    fn end(&mut self) {
        self.under_way -= 1;
        if self.under_way == 0 {
            self.busy += self.since.elapsed();
        }
    }

    /// Mean time per solve of this run times the number of solves left: of `all`, `done` are over.
    /// Stored solves and grid searches do not count: they come first and would inflate the estimate
    /// to years.
    fn time_left(&self, done: u64, all: u64) -> String {
        if self.solved < TOO_FEW.min(all as usize / 2).max(1) {
            return "time left unknown".into();
        }
        let running = if self.under_way > 0 { self.since.elapsed() } else { Duration::ZERO };
        let shared = (self.solved * self.workers) as f64;
        let seconds = (self.busy + running).as_secs_f64() * all.saturating_sub(done) as f64 / shared;
        let left = HumanDuration(Duration::from_secs_f64(seconds));
        let most = if self.ends_early { "at most" } else { "about" };
        let by = if self.workers == 1 { String::new() } else { format!(" for {} processes", self.workers) };
        format!("{most} {left} left{by}")
    }

    /// Whether the next line is due, which it is once.
    fn is_due(&mut self) -> bool {
        let due = self.last_line.elapsed() >= self.between;
        if due {
            self.last_line = Instant::now();
        }
        due
    }
}

/// Shows a run's progress and forwards the user's request to stop.
pub struct Progress {
    stop: StopFlag,
    bar: ProgressBar,
    /// Whether lines are printed instead of a bar, without a terminal.
    plain: bool,
    state: Mutex<RunState>,
}

impl Progress {
    pub fn new() -> Self {
        let plain = !std::io::stderr().is_terminal();
        let bar = ProgressBar::no_length();
        let style = style("{bar:32} {pos}/{len} solves  {msg}  {elapsed} elapsed, {prefix}");
        bar.set_style(style.progress_chars("━╸ "));
        if !plain {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        let stop = StopFlag::listen();
        stop.end_at_once(true);
        Self { stop, bar, plain, state: Mutex::new(RunState::new()) }
    }

    fn state(&self) -> MutexGuard<'_, RunState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of solves, 0 if unknown.
    fn all(&self) -> u64 {
        self.bar.length().unwrap_or(0)
    }

    /// Sets the number of solves to come; with `ends_early`, `run.target_delta_e` may need fewer.
    pub fn expect(&self, solves: usize, ends_early: bool) {
        self.bar.set_length(solves as u64);
        self.state().ends_early = ends_early;
    }

    /// Shows the progress of some work, then removes the progress bar and prints the throughput.
    pub fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        let done = work();
        self.bar.finish_and_clear();
        let RunState { begun, busy, solved, kept, .. } = *self.state();
        if kept > 0 {
            let all = self.all().max((kept + solved) as u64);
            note!("{kept} of {all} solves were already stored");
        }
        if solved > 0 {
            let seconds = begun.elapsed().as_secs_f64();
            let idle = 100.0 * (1.0 - busy.as_secs_f64() / seconds);
            let an_hour = solved as f64 * 3600.0 / seconds;
            note!(
                "{solved} solves in {seconds:.0} s: {an_hour:.0} per hour, {idle:.0} % of the time outside solves"
            );
        }
        done
    }

    /// True when the user has asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.is_raised()
    }

    fn standing(&self, standing: &QueueStanding) {
        self.bar.set_position(self.bar.position().max(standing.solves as u64));
        self.state().workers = standing.workers.max(1);
    }

    fn solving(&self, study: &Study, point: &Point) {
        let Point { realisation, incidence, .. } = point;
        let nm = 1e3 * incidence.wavelength_um;
        let angle = incidence.polar_deg;
        let side = if incidence.from == Side::Exit { " from the exit side" } else { "" };
        let number = realisation + 1;
        let count = study.realisations;
        self.bar.set_message(format!("realisation {number}/{count} · {nm:.0} nm · {angle:.0}°{side}"));
        let mut state = self.state();
        if state.under_way == 0 {
            state.since = Instant::now();
        }
        state.under_way += 1;
        self.bar.set_prefix(state.time_left(self.bar.position(), self.all()));
    }

    fn solved(&self, point: &Point, failure: Option<&str>) {
        self.bar.inc(1);
        if let Some(failure) = failure {
            let nm = 1e3 * point.incidence.wavelength_um;
            let deg = point.incidence.polar_deg;
            let line = format!("no result at {nm:.0} nm, {deg:.0}°: {failure}");
            if self.plain { note!("{line}") } else { self.bar.println(line) }
        }
        let mut state = self.state();
        state.solved += 1;
        if self.plain && state.is_due() {
            let done = self.bar.position();
            let all = self.all();
            note!("{done}/{all} solves, {}, {}", self.bar.message(), state.time_left(done, all));
        }
    }
}

impl RunWatch for Progress {
    /// Reports now and then that a long stage is still running, where there is no progress bar.
    fn stop(&self) -> bool {
        if let (true, Ok(mut state)) = (self.plain, self.state.try_lock())
            && state.is_due()
        {
            let seconds = state.begun.elapsed().as_secs();
            note!("still working after {seconds} s: {} (--plan estimates the total)", self.bar.message());
        }
        self.stop.is_raised()
    }

    fn hear(&self, event: Event) {
        match event {
            Event::Stage(what) => {
                self.bar.set_message(what.to_owned());
                self.plain.then(|| note!("{what}"));
            }
            Event::Grid(_) => {}
            Event::Begun => self.stop.end_at_once(false),
            Event::Over => self.stop.end_at_once(true),
            Event::Standing(standing) => self.standing(standing),
            Event::Solving(study, point) => self.solving(study, point),
            Event::Kept(solves) => {
                self.state().kept += solves;
                self.bar.inc(solves as u64);
            }
            Event::Dropped(solves) => self.bar.inc(solves as u64),
            Event::Ended => self.state().end(),
            Event::Solved(point, failure) => self.solved(point, failure),
        }
    }
}

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
        let clock = Instant::now();
        let page = self.folder.path().join(PAGE);
        if clock < *due || is_new(&page) {
            return;
        }
        // What is written comes from stored solves: a stop need not wait for it.
        self.progress.stop.end_at_once(true);
        let written = !self.progress.stop() && write();
        self.progress.stop.end_at_once(false);
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
