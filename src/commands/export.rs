//! `inkwave export FOLDER`: files for renderers, colour programs, NumPy, ParaView and archives.

use super::diagnostics::folder_report;
use super::progress::Progress;
use super::terminal::say;
use clap::Args;
use inkwave::export::folder::StoredFolder;
use inkwave::export::request::{ExportError, Format, NearField, Request};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::{self, Holds, shell_word};
use miette::{MietteDiagnostic, Result, miette};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Write files for other programs from a finished study
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// Folder of a finished `inkwave run`, or of one variant of a sweep (SWEEP/variants/NAME)
    pub folder: PathBuf,
    /// Formats, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', required = true, value_name = "FORMAT,…")]
    pub to: Vec<Format>,
    /// Output folder (default: FOLDER/export)
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Also write near-field.vti, from a new solve at this wavelength (nm) and angle (degrees,
    /// default 0)
    #[arg(long, value_name = "NM[:DEG]", value_parser = near_field)]
    pub near_field: Option<NearField>,
    /// Thickness of the layer to export, for a composed study (µm; default: its first)
    #[arg(long, value_name = "UM")]
    pub thickness: Option<f64>,
}

/// Reads the folder and writes the files.
pub fn run(args: &ExportArgs) -> Result<()> {
    let refused = |error: ExportError| refusal(&error, &args.folder);
    let finished = StoredFolder::read(&args.folder).map_err(refused)?;
    let folder = args.output.clone().unwrap_or_else(|| args.folder.join("export"));
    let folder = OutputFolder::open(&folder, Holds::Exports).map_err(folder_report)?;
    let progress = Progress::new();
    let request = Request {
        formats: args.to.iter().copied().collect(),
        near_field: args.near_field,
        thickness_um: args.thickness,
        created: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
    };
    let exported = progress.during(|| finished.export(&request, &progress));
    let exported = exported.inspect_err(|_| folder.discard_when_empty()).map_err(refused)?;
    for file in &exported.files {
        folder.write(&file.name, &file.bytes).map_err(folder_report)?;
        say!("{}: {}", folder.path().join(&file.name).display(), file.about)?;
    }
    exported.remarks.iter().try_for_each(say)
}

fn refusal(error: &ExportError, folder: &Path) -> miette::Report {
    match error {
        ExportError::Unfinished { .. } => {
            miette!(help = format!("to resume: {}", to_go_on(folder)), "{error}")
        }
        _ => {
            let help = error.remedy().map(str::to_owned);
            MietteDiagnostic { help, ..MietteDiagnostic::new(error.to_string()) }.into()
        }
    }
}

/// The command that resumes an unfinished folder: the recorded one, or else its general form.
fn to_go_on(folder: &Path) -> String {
    let marked = marker::go_on(folder).or_else(|| marker::go_on(folder.parent().and_then(Path::parent)?));
    marked.unwrap_or_else(|| {
        format!("inkwave run STUDY.toml --output {}", shell_word(&folder.to_string_lossy()))
    })
}

/// Parses `550` or `550:30`: nm, and degrees if given.
fn near_field(text: &str) -> Result<NearField, String> {
    let (nm, deg) = text.split_once(':').unwrap_or((text, "0"));
    let number = |part: &str| part.trim().parse::<f64>().ok().filter(|x| x.is_finite());
    match (number(nm), number(deg)) {
        (Some(wavelength_nm), Some(polar_deg)) if (0.0..90.0).contains(&polar_deg) => {
            Ok(NearField { wavelength_nm, polar_deg })
        }
        _ => Err("write a wavelength in nm, or wavelength:angle with 0 ≤ angle < 90, such as 550:30".into()),
    }
}
