//! A program under measurement: one text in, one text out, within limits of time and memory.
//!
//! Processor time and memory are those of the program and of all that it starts, as `/proc` tells
//! them; where there is no `/proc`, only the wall clock is measured.

use super::ExternalTable;
use super::judge::words;
use crate::compare::error::CompareResult;
use crate::solve::{Account, SolveError, Step, Watch};
use std::io::{Read, Write};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Most bytes of an answer.
const MOST_OUTPUT: usize = 64 << 20;
/// How long the pipes of a program that has ended may stay open.
const LINGER: Duration = Duration::from_secs(1);
/// Ticks of processor time in a second, the same on every Linux.
const TICKS: f64 = 100.0;

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
        let clock = Instant::now();
        let mut child = match command.spawn() {
            Ok(child) => Running(child),
            Err(error) => return Ok(Err(error)),
        };
        if let Some(mut stdin) = child.0.stdin.take() {
            // A program need not read what it is asked.
            std::thread::spawn(move || drop(stdin.write_all(&input)));
        }
        let output = child.0.stdout.take().map(PipeOutput::of);
        let complaint = child.0.stderr.take().map(PipeOutput::of);
        let mut usage = Usage::default();
        let end = loop {
            usage.look(child.0.id());
            if usage.ended || usage.tree.is_none() && child.0.try_wait().is_ok_and(|end| end.is_some()) {
                break None;
            }
            let printed = output.iter().chain(&complaint).map(PipeOutput::len).max().unwrap_or(0);
            let elapsed = clock.elapsed();
            if let Some(reason) = beyond(program, elapsed, usage.bytes, printed) {
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
        // All that the program has left running ends with it, while its number is still its own.
        child.kill();
        let status = child.0.wait().map_err(|error| error.to_string());
        let end = end.map_or(status, Err);
        let [output, complaint] =
            [output, complaint].map(|pipe| pipe.map_or_else(Vec::new, PipeOutput::bytes));
        let Usage { tree: processor_seconds, peak: peak_bytes, .. } = usage;
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

/// A child that never outlives its measurement.
struct Running(Child);

impl Running {
    /// Kills the program and its group.
    fn kill(&mut self) {
        #[cfg(unix)]
        if let Ok(group) = i32::try_from(self.0.id()) {
            let group = nix::unistd::Pid::from_raw(group);
            // Nothing may be left to kill.
            let _ = nix::sys::signal::killpg(group, nix::sys::signal::Signal::SIGKILL);
        }
        drop(self.0.kill());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Ok(None) = self.0.try_wait() {
            self.kill();
            drop(self.0.wait());
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

/// Processor time and memory of a program and of all that it started.
#[derive(Default)]
struct Usage {
    /// Processor time so far, s; none without `/proc`.
    tree: Option<f64>,
    bytes: f64,
    peak: f64,
    /// The program has ended, and waits to be asked how.
    ended: bool,
}

impl Usage {
    fn look(&mut self, root: u32) {
        let Some(own) = process(root) else { return };
        let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let numbers = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        let tree: Vec<Process> =
            numbers.filter_map(process).filter(|p| p.group == root || p.parent == root).collect();
        let memory: Vec<[f64; 2]> = tree.iter().filter_map(|p| memory(p.number)).collect();
        let seconds = tree.iter().map(|p| p.ticks).sum::<f64>() / TICKS;
        self.tree = Some(seconds.max(self.tree.unwrap_or(0.0)));
        self.bytes = memory.iter().map(|m| m[0]).sum();
        self.peak = memory.iter().map(|m| m[1]).sum::<f64>().max(self.peak);
        self.ended = own.state == "Z";
    }
}

/// A line of `/proc/N/stat`.
struct Process {
    number: u32,
    state: String,
    parent: u32,
    group: u32,
    /// Its processor time and that of its children that have ended.
    ticks: f64,
}

fn process(number: u32) -> Option<Process> {
    let line = std::fs::read_to_string(format!("/proc/{number}/stat")).ok()?;
    // The name, in brackets, may hold anything.
    let fields: Vec<&str> = line.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = fields.get(11..15)?.iter().filter_map(|ticks| ticks.parse::<f64>().ok()).sum();
    let (parent, group) = (fields[1].parse().ok()?, fields[2].parse().ok()?);
    Some(Process { number, state: fields[0].into(), parent, group, ticks })
}

/// Memory of a process now and at most so far.
fn memory(number: u32) -> Option<[f64; 2]> {
    let status = std::fs::read_to_string(format!("/proc/{number}/status")).ok()?;
    let bytes = |key: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(key))?;
        Some(1024.0 * line.split_whitespace().next()?.parse::<f64>().ok()?)
    };
    Some([bytes("VmRSS:")?, bytes("VmHWM:")?])
}
