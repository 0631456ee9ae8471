//! Where a report's numbers come from.

use crate::claim::Level;
use inkwave::store::identity::METHOD_VERSION;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;
use std::process::Command;

/// Everything needed to make the numbers again; seeds are fixed in the claims, whose code the commit names.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Manifest {
    pub date: String,
    pub level: Level,
    pub version: String,
    /// Version of the method that was measured.
    pub method: u32,
    pub commit: String,
    /// Whether files differed from the commit.
    pub changed: bool,
    pub toolchain: String,
    pub cpu: String,
    pub threads: usize,
    /// BLAKE3 of the program that measured.
    pub program_hash: String,
    /// BLAKE3 of each file of reference data.
    pub data_hashes: Vec<(String, String)>,
}

/// First line of a command's output; "unknown" where it cannot run.
fn asked(program: &str, args: &[&str]) -> String {
    let output = Command::new(program).args(args).output().ok().filter(|o| o.status.success());
    let text = output.map(|o| String::from_utf8_lossy(&o.stdout).lines().next().unwrap_or("").to_string());
    text.unwrap_or_else(|| "unknown".into())
}

fn cpu() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|l| l.strip_prefix("model name")?.split(':').nth(1));
    model.map_or_else(|| std::env::consts::ARCH.into(), |m| m.trim().into())
}

fn hash(path: &Path) -> io::Result<String> {
    Ok(blake3::hash(&std::fs::read(path)?).to_hex().to_string())
}

impl Manifest {
    /// # Errors
    /// The program or the reference data cannot be read.
    pub fn gather(date: &str, level: Level) -> io::Result<Self> {
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation/data");
        let mut files: Vec<_> = std::fs::read_dir(data)?.collect::<io::Result<_>>()?;
        // Folders hold what tests compare with, not what claims are judged by.
        files.retain(|file| file.path().is_file());
        files.sort_by_key(std::fs::DirEntry::file_name);
        let named =
            |f: &std::fs::DirEntry| Ok((f.file_name().to_string_lossy().into_owned(), hash(&f.path())?));
        Ok(Self {
            date: date.into(),
            level,
            version: env!("CARGO_PKG_VERSION").into(),
            method: METHOD_VERSION,
            commit: asked("git", &["rev-parse", "--short=12", "HEAD"]),
            changed: !matches!(
                asked("git", &["status", "--porcelain", "--untracked-files=no"]).as_str(),
                "" | "unknown"
            ),
            toolchain: asked("rustc", &["--version"]),
            cpu: cpu(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            program_hash: hash(&std::env::current_exe()?)?,
            data_hashes: files.iter().map(named).collect::<io::Result<_>>()?,
        })
    }
}
