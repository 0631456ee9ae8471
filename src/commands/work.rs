//! Options and output folders of commands that solve; `--memory-gb` and the memory limits of the
//! process.

use super::diagnostics::folder_report;
use super::terminal::this_command;
use clap::Args;
use inkwave::input::load::stem;
use inkwave::run::RunSettings;
use inkwave::run::memory::{allowed, is_limited, least_space, threads_within_limits};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use miette::{Result, miette};
use std::path::{Path, PathBuf};

/// Where the results go, and what the solves may take.
#[derive(Debug, Args)]
pub struct WorkArgs {
    /// Output folder (created if missing; interrupted work is resumed)
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Number of parallel solves (default: number of processors); fewer take less memory
    #[arg(long, short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Memory for all parallel solves, GB (default: four fifths of the free memory)
    #[arg(long, value_name = "GB", allow_negative_numbers = true)]
    pub memory_gb: Option<f64>,
    /// Print the expected time and memory, after a short trial, and exit
    #[arg(long)]
    pub plan: bool,
}

impl WorkArgs {
    /// Settings of a run.
    ///
    /// # Errors
    /// `--memory-gb` is not a number above 0.
    pub fn settings(&self) -> Result<RunSettings> {
        let otherwise = RunSettings::default();
        let memory = self.memory_gb.map_or(Ok(otherwise.memory), bytes)?;
        Ok(RunSettings { jobs: self.jobs.map(usize::from), memory, ..otherwise })
    }

    /// `--output`, else `out/<name of the file>` and what follows the name.
    pub fn folder(&self, file: &Path, end: &str) -> PathBuf {
        self.output.clone().unwrap_or_else(|| Path::new("out").join(stem(file) + end))
    }
}

/// Opens an output folder, whose work this command resumes.
///
/// # Errors
/// The folder cannot be written, or holds something else.
pub fn opened(path: &Path, holds: Holds) -> Result<OutputFolder> {
    Ok(OutputFolder::open(path, holds).map_err(folder_report)?.going_on_with(this_command()))
}

/// Converts GB to bytes, capped by the process's limits.
///
/// # Errors
/// `gb` is not a number above 0.
pub fn bytes(gb: f64) -> Result<f64> {
    if gb.is_nan() || gb <= 0.0 {
        miette::bail!("--memory-gb is {gb}; it must be above 0: try 4");
    }
    Ok((1e9 * gb).min(allowed()))
}

/// Memory needed besides the solves, bytes: packings, pages and pictures.
const LEAST_LEFT: f64 = 96e6;

/// Largest block that is kept for the next one after it is freed, bytes.
const KEPT: usize = 16 << 20;

/// Lets the GNU allocator keep what solves free: it adapts its limits to the largest block freed,
/// and otherwise returns every solve's arrays to the system, at a fifth of a study's processor
/// time. The block is never touched; other allocators ignore it.
fn keep_freed_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(KEPT)));
}

/// Starts the thread pool, on fewer threads where the limits of the process leave no room for all,
/// after a check that there is enough memory to begin.
///
/// # Errors
/// The system refuses threads, or leaves less memory than any command needs; later an error could
/// no longer be printed.
pub fn start_threads() -> Result<()> {
    let by_user = std::env::var("RAYON_NUM_THREADS").ok().and_then(|n| n.parse().ok()).filter(|&n| n > 0);
    let requested =
        by_user.or_else(|| std::thread::available_parallelism().ok().map(usize::from)).unwrap_or(1);
    let threads = threads_within_limits(requested);
    if threads == 0 || allowed() < LEAST_LEFT {
        let help = "raise the limit (ulimit -v, ulimit -d, or the cgroup's), or use another machine";
        let megabytes = |bytes: f64| (1e-6 * bytes).floor();
        let left = megabytes(allowed());
        let least = megabytes(LEAST_LEFT);
        let space = megabytes(least_space());
        return Err(miette!(
            help = help,
            "this process has {left} MB of memory left for solves; a run on one thread needs {space} MB of address space, {least} MB for solves among them"
        ));
    }
    if threads < requested {
        note!(
            "using {threads} of {requested} threads: the limit of address space (ulimit -v) is too low for more"
        );
    }
    if is_limited() {
        // A product on many threads may begin another one while it waits, which reserves its
        // buffers again.
        faer::set_global_parallelism(faer::Par::Seq);
    }
    keep_freed_memory();
    let started = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    let help = "allow more processes or memory (ulimit -u, ulimit -v), or fewer threads: RAYON_NUM_THREADS=1";
    started.map_err(|error| miette!(help = help, "cannot start threads: {error}"))
}
