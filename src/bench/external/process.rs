//! A program under measurement: one text in, one text out, within limits of time and memory.
//!
//! Processor time and memory are those of the program and of all that it starts, also of what it
//! sends to the background, and all of it ends with the measurement. Where there is no `/proc`, only
//! the wall clock is measured, and only the program's process group is sure to end.

use super::ExternalTable;
use super::judge::words;
use super::tree::{MARK, ProcessTree};
use crate::error::CompareResult;
use crate::solve::{Account, SolveError, Step, Watch};
use std::io::{Read, Write};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Most bytes of an answer.
const MOST_OUTPUT: usize = 64 << 20;
/// How long the pipes of a program that has ended may stay open.
const LINGER: Duration = Duration::from_secs(1);
/// Rounds of killing what a program goes on starting while it is killed.
const ROUNDS: usize = 100;
/// Runs so far in this process, for their marks.
static RUNS: AtomicUsize = AtomicUsize::new(0);

/// A run that has ended.
pub struct ProgramRun {
    /// Wall time, s.
    pub seconds: f64,
    /// Processor time, s.
    pub processor_seconds: Option<f64>,
    /// Most memory at a time, 0 where it is not known.
    pub peak_bytes: f64,
    end: Result<ExitStatus, String>,
    output: Vec<u8>,
    complaint: Vec<u8>,
}

impl ProgramRun {
    /// Runs a command; the inner error says why it cannot be started.
    ///
    /// # Errors
    /// The user stopped it.
    pub fn of(
        mut command: Command,
        input: Vec<u8>,
        program: &ExternalTable,
        watch: &mut dyn Watch,
    ) -> CompareResult<Result<ProgramRun, std::io::Error>> {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mark = format!("{}-{}", std::process::id(), RUNS.fetch_add(1, Ordering::Relaxed));
        command.env(MARK, &mark);
        let clock = Instant::now();
        let mut running = match command.spawn() {
            Ok(child) => Running { tree: ProcessTree::new(child.id(), &mark), child, waited: false },
            Err(error) => return Ok(Err(error)),
        };
        if let Some(mut stdin) = running.child.stdin.take() {
            // A program need not read what it is asked.
            std::thread::spawn(move || drop(stdin.write_all(&input)));
        }
        let output = running.child.stdout.take().map(PipeOutput::of);
        let complaint = running.child.stderr.take().map(PipeOutput::of);
        let end = loop {
            if running.has_ended() {
                break None;
            }
            let printed = output.iter().chain(&complaint).map(PipeOutput::len).max().unwrap_or(0);
            let elapsed = clock.elapsed();
            if let Some(reason) = beyond(program, elapsed, running.tree.bytes, printed) {
                break Some(reason);
            }
            if watch.step(&Step { step: 0, applications: 0, residual: 1.0 }).is_break() {
                return Err(SolveError::Cancelled { account: Box::new(Account::default()) }.into());
            }
            std::thread::sleep((elapsed / 50).clamp(Duration::from_millis(2), Duration::from_millis(50)));
        };
        let seconds = clock.elapsed().as_secs_f64();
        // A program may die of the pipe that was closed for its flood before it is killed for it.
        let end = end.or_else(|| output.iter().chain(&complaint).find_map(|pipe| flood(pipe.len())));
        let status = running.end().map_err(|error| error.to_string());
        let end = end.map_or(status, Err);
        let output = output.map_or_else(Vec::new, PipeOutput::bytes);
        let complaint = complaint.map_or_else(Vec::new, PipeOutput::bytes);
        let processor_seconds = running.tree.seconds;
        let peak_bytes = running.tree.peak;
        Ok(Ok(ProgramRun { seconds, processor_seconds, peak_bytes, end, output, complaint }))
    }

    /// What it printed, where it ended well.
    ///
    /// # Errors
    /// It was killed, or ended with a failure.
    pub fn outcome(&self) -> Result<&[u8], String> {
        match &self.end {
            Err(reason) => Err(format!("killed: {reason}")),
            Ok(status) if status.success() => Ok(&self.output),
            Ok(status) => {
                let last = self.complaint.rsplit(|byte| *byte == b'\n').find(|line| !line.is_empty());
                let last = last.map_or_else(String::new, |line| format!(": {}", words(line)));
                Err(format!("ended with {}{last}", status.to_string().replacen(": ", " ", 1)))
            }
        }
    }
}

/// Why a program is killed, where it is beyond a limit.
fn beyond(program: &ExternalTable, elapsed: Duration, bytes: f64, printed: usize) -> Option<String> {
    let ExternalTable { time_limit_s, memory_gb, .. } = program;
    if elapsed.as_secs_f64() > *time_limit_s {
        return Some(format!("it took longer than time_limit_s = {time_limit_s} s"));
    }
    if bytes > 1e9 * memory_gb {
        return Some(format!("it took more than memory_gb = {memory_gb} GB"));
    }
    flood(printed)
}

/// What is said of a program that prints more than any answer needs.
fn flood(printed: usize) -> Option<String> {
    (printed > MOST_OUTPUT).then(|| format!("it printed more than {} MB", MOST_OUTPUT >> 20))
}

/// A program that never outlives its measurement, nor does anything that it started.
struct Running {
    child: Child,
    tree: ProcessTree,
    /// It was waited for: its number may be another process's by now.
    waited: bool,
}

impl Running {
    /// Whether the program itself has ended; what it started may still run.
    fn has_ended(&mut self) -> bool {
        self.tree.look();
        let unknown = self.tree.seconds.is_none();
        self.tree.ended || unknown && self.child.try_wait().is_ok_and(|end| end.is_some())
    }

    /// Kills the program with all that it has started, and waits for it.
    fn end(&mut self) -> std::io::Result<ExitStatus> {
        self.kill();
        self.waited = true;
        self.child.wait()
    }

    /// Kills the program's group, and what has left the group, until nothing more is started.
    fn kill(&mut self) {
        #[cfg(unix)]
        for _ in 0..ROUNDS {
            self.tree.look();
            let running = self.tree.running();
            kill_group(self.child.id());
            if running.is_empty() {
                break;
            }
            running.into_iter().for_each(kill_process);
            std::thread::sleep(Duration::from_millis(1));
        }
        drop(self.child.kill());
    }
}

/// Sends SIGKILL to a process group; nothing may be left to kill.
#[cfg(unix)]
fn kill_group(leader: u32) {
    if let Ok(group) = i32::try_from(leader) {
        let group = nix::unistd::Pid::from_raw(group);
        let _ = nix::sys::signal::killpg(group, nix::sys::signal::Signal::SIGKILL);
    }
}

/// Sends SIGKILL to a process, which may have ended by itself.
#[cfg(unix)]
fn kill_process(number: u32) {
    if let Ok(number) = i32::try_from(number) {
        let number = nix::unistd::Pid::from_raw(number);
        let _ = nix::sys::signal::kill(number, nix::sys::signal::Signal::SIGKILL);
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if !self.waited {
            drop(self.end());
        }
    }
}

/// What a pipe brings, read by a thread of its own.
struct PipeOutput {
    bytes: Arc<Mutex<Vec<u8>>>,
    end: Receiver<()>,
}

impl PipeOutput {
    fn of(mut pipe: impl Read + Send + 'static) -> PipeOutput {
        let (bytes, (sender, end)) = (Arc::new(Mutex::new(Vec::new())), channel());
        let shared = bytes.clone();
        std::thread::spawn(move || {
            read(&mut pipe, &shared);
            drop(sender);
        });
        PipeOutput { bytes, end }
    }

    fn len(&self) -> usize {
        self.bytes.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// All that came until the pipe was closed, or soon after the program has ended.
    fn bytes(self) -> Vec<u8> {
        // Closed, or held by a process that has left the group: either way nothing more counts.
        let _ = self.end.recv_timeout(LINGER);
        std::mem::take(&mut self.bytes.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Reads a pipe to its end, or to more than an answer may have.
fn read(pipe: &mut impl Read, into: &Mutex<Vec<u8>>) {
    let mut part = vec![0; 1 << 16];
    while let Ok(count @ 1..) = pipe.read(&mut part) {
        let mut all = into.lock().unwrap_or_else(PoisonError::into_inner);
        if all.len() > MOST_OUTPUT {
            return;
        }
        all.extend_from_slice(&part[..count]);
    }
}
