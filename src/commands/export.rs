//! `inkwave export FOLDER`: files for renderers, colour programs, NumPy, ParaView and archives.

use super::again::quoted;
use super::progress::Progress;
use super::run::folder_report;
use super::say::say;
use super::stop::StopFlag;
use clap::{Args, ValueEnum};
use inkwave::export::run::{Format, NearField, Request, export};
use inkwave::export::stored::{Stored, StoredError};
use inkwave::store::folder::OutputFolder;
use inkwave::store::marker::Holds;
use inkwave::store::partial;
use miette::{IntoDiagnostic, miette};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Turn a finished study into files that other programs open.
#[derive(Debug, Args)]
pub struct ExportArgs {
    /// Folder that `inkwave run` has written, or one variant of a sweep (SWEEP/variants/NAME).
    pub folder: PathBuf,
    /// Formats, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', required = true, value_name = "FORMAT,…")]
    pub to: Vec<To>,
    /// Folder for the files; FOLDER/export when left out.
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Solve once more at this wavelength (nm) and angle (degrees, 0 when left out) and add near-field.vti.
    #[arg(long, value_name = "NM[:DEG]", value_parser = near_field)]
    pub near_field: Option<NearField>,
}

/// The formats by name.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum To {
    /// Material for Mitsuba 3 (spectral and RGB), scenes, tables to check it by.
    Mitsuba,
    /// Spectra with Lab, CxF3.
    Cxf,
    /// Spectra with Lab, CGATS.17 and ArgyllCMS's sp.
    Cgats,
    /// Far fields as NumPy arrays.
    Npz,
    /// Contrast of the first packing as a VTK image.
    Vti,
    /// The first packing as a page to turn and to cut in a browser.
    Viewer,
    /// RO-Crate and Data Package.
    Crate,
}

impl From<To> for Format {
    fn from(to: To) -> Format {
        match to {
            To::Mitsuba => Format::Mitsuba,
            To::Cxf => Format::Cxf,
            To::Cgats => Format::Cgats,
            To::Npz => Format::Npz,
            To::Vti => Format::Vti,
            To::Viewer => Format::Viewer,
            To::Crate => Format::Crate,
        }
    }
}

/// Reads the folder and writes the files.
pub fn run(args: &ExportArgs) -> miette::Result<()> {
    let stored = Stored::read(&args.folder).map_err(|error| not_stored(&error, &args.folder))?;
    let folder = args.output.clone().unwrap_or_else(|| args.folder.join("export"));
    let folder = OutputFolder::open(&folder, Holds::Exports).map_err(folder_report)?;
    let progress = Progress::new(StopFlag::listen());
    let request = Request {
        formats: args.to.iter().map(|&to| to.into()).collect(),
        near_field: args.near_field,
        created: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
    };
    let exported = export(&stored, &request, &progress);
    progress.finish();
    let exported = exported.inspect_err(|_| folder.discard_when_empty()).into_diagnostic()?;
    for file in &exported.files {
        folder.write(&file.name, &file.bytes).map_err(folder_report)?;
        say(format_args!("{}: {}", folder.path().join(&file.name).display(), file.about))?;
    }
    exported.remarks.iter().try_for_each(say)
}

fn not_stored(error: &StoredError, folder: &Path) -> miette::Report {
    let help = match error {
        StoredError::Unfinished { .. } => format!("to go on: {}", to_go_on(folder)),
        _ => error.remedy().to_owned(),
    };
    miette!(help = help, "{error}")
}

/// The command that was typed for an unfinished folder, or the form of it.
fn to_go_on(folder: &Path) -> String {
    let sweep = folder.parent().and_then(Path::parent);
    let marked = partial::go_on(folder).or_else(|| partial::go_on(sweep?));
    marked.unwrap_or_else(|| format!("inkwave run STUDY.toml --output {}", quoted(&folder.to_string_lossy())))
}

/// `550` or `550:30`.
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
