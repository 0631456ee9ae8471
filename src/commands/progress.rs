//! Progress of a run on stderr: a progress bar on a terminal, otherwise a line every ten seconds.

use super::say::note;
use super::stop::StopFlag;
use indicatif::{HumanDuration, ProgressBar, ProgressStyle};
use inkwave::input::study::{Point, Study};
use inkwave::run::watch::{Event, RunWatch};
use inkwave::store::queue::QueueStanding;
use inkwave::wave::Side;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

const BETWEEN_LINES: Duration = Duration::from_secs(10);
/// Fewest solves whose mean time is used to estimate the time left.
const TOO_FEW: usize = 20;

/// Measures the time during which at least one solve is running.
struct Busy {
    begun: Instant,
    under_way: usize,
    since: Instant,
    busy: Duration,
}

impl Busy {
    fn new() -> Self {
        let now = Instant::now();
        Self { begun: now, under_way: 0, since: now, busy: Duration::ZERO }
    }

    fn begin(&mut self) {
        if self.under_way == 0 {
            self.since = Instant::now();
        }
        self.under_way += 1;
    }

    fn end(&mut self) {
        self.under_way -= 1;
        if self.under_way == 0 {
            self.busy += self.since.elapsed();
        }
    }

    /// Time with at least one solve running, up to now.
    fn so_far(&self) -> Duration {
        let now = if self.under_way > 0 { self.since.elapsed() } else { Duration::ZERO };
        self.busy + now
    }
}

/// Shows a run's progress and forwards the user's request to stop.
pub struct Progress {
    stop: StopFlag,
    bar: ProgressBar,
    begun: Instant,
    /// None on a terminal; elsewhere the time of the last line.
    last_line: Option<Mutex<Instant>>,
    solved: AtomicUsize,
    left: AtomicUsize,
    busy: Mutex<Busy>,
    /// Solves that were already stored.
    kept: AtomicUsize,
    /// Processes that share the work.
    workers: AtomicUsize,
    /// Whether `run.target_delta_e` may end the run before all solves are done.
    ends_early: AtomicBool,
}

impl Progress {
    pub fn new(stop: StopFlag) -> Self {
        let plain = !std::io::stderr().is_terminal();
        let bar = ProgressBar::no_length();
        let template = "{bar:32} {pos}/{len} solves  {msg}  {elapsed} elapsed, {prefix}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style.progress_chars("━╸ "));
        }
        if !plain {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        Self {
            stop,
            bar,
            begun: Instant::now(),
            last_line: plain.then(|| Mutex::new(Instant::now())),
            solved: AtomicUsize::new(0),
            left: AtomicUsize::new(0),
            busy: Mutex::new(Busy::new()),
            kept: AtomicUsize::new(0),
            workers: AtomicUsize::new(1),
            ends_early: AtomicBool::new(false),
        }
    }

    /// Sets the number of solves to come; with `ends_early`, `run.target_delta_e` may need fewer.
    pub fn expect(&self, solves: usize, ends_early: bool) {
        self.ends_early.store(ends_early, Ordering::Relaxed);
        self.bar.set_length(solves as u64);
        self.left.store(solves, Ordering::Relaxed);
    }

    /// Removes the progress bar and prints the throughput.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
        let (kept, all) = (self.kept.load(Ordering::Relaxed), self.bar.length().unwrap_or(0));
        if kept > 0 {
            note(format_args!("{kept} of {all} solves were already stored"));
        }
        let (solved, Ok(busy)) = (self.solved.load(Ordering::Relaxed), self.busy.lock()) else { return };
        if solved > 0 {
            let seconds = busy.begun.elapsed().as_secs_f64();
            let idle = 100.0 * (1.0 - busy.busy.as_secs_f64() / seconds);
            let an_hour = solved as f64 * 3600.0 / seconds;
            note(format_args!(
                "{solved} solves in {seconds:.0} s: {an_hour:.0} per hour, {idle:.0} % of the time outside solves"
            ));
        }
    }

    /// True when the user has asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.is_raised()
    }

    fn fewer_left(&self, solves: usize) {
        let fewer = |left: usize| Some(left.saturating_sub(solves));
        let _ = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fewer);
    }

    fn say(&self, text: &str) {
        match self.last_line {
            Some(_) => note(format_args!("{text}")),
            None => self.bar.println(text),
        }
    }

    /// Mean time per solve of this run times the number of solves left. Stored solves and grid
    /// searches do not count: they come first and would inflate the estimate to years.
    fn time_left(&self) -> String {
        let (solved, left) = (self.solved.load(Ordering::Relaxed), self.left.load(Ordering::Relaxed));
        let Ok(busy) = self.busy.lock() else { return String::new() };
        if solved < TOO_FEW.min(self.bar.length().unwrap_or(0) as usize / 2).max(1) {
            return "time left unknown".into();
        }
        let workers = self.workers.load(Ordering::Relaxed);
        let seconds = busy.so_far().as_secs_f64() * left as f64 / (solved * workers) as f64;
        let left = HumanDuration(Duration::from_secs_f64(seconds));
        let most = if self.ends_early.load(Ordering::Relaxed) { "at most" } else { "about" };
        if workers == 1 {
            format!("{most} {left} left")
        } else {
            format!("{most} {left} left for {workers} processes")
        }
    }

    /// Reports now and then that a long stage is still running, where there is no progress bar.
    fn waiting_line(&self) {
        let Some(mut last) = self.last_line.as_ref().and_then(|last| last.try_lock().ok()) else { return };
        if last.elapsed() >= BETWEEN_LINES {
            *last = Instant::now();
            let seconds = self.begun.elapsed().as_secs();
            note(format_args!(
                "still working after {seconds} s: {} (--plan estimates the total)",
                self.bar.message()
            ));
        }
    }

    fn line_when_due(&self) {
        let Some(last) = self.last_line.as_ref().and_then(|last| last.lock().ok()) else { return };
        let mut last = last;
        if last.elapsed() >= BETWEEN_LINES {
            *last = Instant::now();
            let (done, all) = (self.bar.position(), self.bar.length().unwrap_or(0));
            note(format_args!("{done}/{all} solves, {}, {}", self.bar.message(), self.time_left()));
        }
    }

    fn standing(&self, standing: &QueueStanding) {
        let (all, done) = (self.bar.length().unwrap_or(0), self.bar.position().max(standing.solves as u64));
        self.bar.set_position(done);
        self.left.store(all.saturating_sub(done) as usize, Ordering::Relaxed);
        self.workers.store(standing.workers.max(1), Ordering::Relaxed);
    }

    fn kept(&self, solves: usize) {
        self.kept.fetch_add(solves, Ordering::Relaxed);
        self.pass(solves);
    }

    /// Counts solves that need no work.
    fn pass(&self, solves: usize) {
        self.bar.inc(solves as u64);
        self.fewer_left(solves);
    }

    fn show_stage(&self, what: &str) {
        self.bar.set_message(what.to_owned());
        if self.last_line.is_some() {
            note(format_args!("{what}"));
        }
    }

    fn solving(&self, study: &Study, point: &Point) {
        if let Ok(mut busy) = self.busy.lock() {
            busy.begin();
        }
        let Point { realisation, incidence, .. } = point;
        let (nm, angle) = (1e3 * incidence.wavelength_um, incidence.polar_deg);
        let side = if incidence.from == Side::Exit { " from the exit side" } else { "" };
        let of = study.realisations;
        self.bar
            .set_message(format!("realisation {}/{of} · {nm:.0} nm · {angle:.0}°{side}", realisation + 1));
        self.bar.set_prefix(self.time_left());
    }

    fn ended(&self) {
        if let Ok(mut busy) = self.busy.lock() {
            busy.end();
        }
    }

    fn solved(&self, point: &Point, failure: Option<&str>) {
        self.solved.fetch_add(1, Ordering::Relaxed);
        self.fewer_left(1);
        self.bar.inc(1);
        if let Some(failure) = failure {
            let nm = 1e3 * point.incidence.wavelength_um;
            self.say(&format!("no result at {nm:.0} nm, {:.0}°: {failure}", point.incidence.polar_deg));
        }
        self.line_when_due();
    }
}

impl RunWatch for Progress {
    fn stop(&self) -> bool {
        self.waiting_line();
        self.stop.is_raised()
    }

    fn hear(&self, event: Event) {
        match event {
            Event::Stage(what) => self.show_stage(what),
            Event::Standing(standing) => self.standing(standing),
            Event::Solving(study, point) => self.solving(study, point),
            Event::Kept(solves) => self.kept(solves),
            Event::Dropped(solves) => self.pass(solves),
            Event::Ended => self.ended(),
            Event::Solved(point, failure) => self.solved(point, failure),
        }
    }
}
