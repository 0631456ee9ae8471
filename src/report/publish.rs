//! Writes the results of the finished solves: `results.json`, tables, picture and page.

use super::columns::{FolderTables, NamedTable};
use super::numbers;
use super::page::on_study;
use super::sheet::{ShownFiles, main_results, missed_target, sheet};
use super::tables;
use crate::appearance::bdf::BdfError;
use crate::appearance::picture::InkPicture;
use crate::draw::OutputError;
use crate::draw::figure::Bitmap;
use crate::draw::picture::{PictureStyle, render};
use crate::evaluate::evaluated::{EvaluateError, Evaluated, FinishedSolves};
use crate::evaluate::ink::InkError;
use crate::evaluate::manifest::{Count, Status};
use crate::evaluate::published::Withheld;
use crate::input::study::Study;
use crate::run::crew::processor_seconds;
use crate::store::folder::{FolderError, OutputFolder};

/// Rows and columns of the picture.
const PICTURE_ANGLES: usize = 61;

/// Why the results could not be written.
#[derive(Debug, thiserror::Error)]
pub enum PublishError {
    /// The folder of results.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A result that is unphysical.
    #[error(
        "{0}: no result, so nothing is published; every solve is kept. Curves through few wavelengths and cells overshoot: try \
         more realisations or a smaller light.step_nm, or else a finer grid"
    )]
    Unphysical(String),
    /// Too many packings failed.
    #[error(
        "{0}. Nothing is published; every solve is kept. Lower pigment.volume_fraction, use smaller grains or a thicker layer, or \
         try a smaller layer.period_um, which takes fewer grains per packing"
    )]
    NoRoom(String),
    /// Too few solves of a composed layer.
    #[error("{0}: nothing is published; every solve is kept")]
    Slabs(String),
    /// A plot or picture.
    #[error(transparent)]
    Figure(#[from] OutputError),
    /// Ink on paper.
    #[error(transparent)]
    Ink(#[from] InkError),
    /// A distribution function.
    #[error(transparent)]
    Bdf(#[from] BdfError),
    /// A table.
    #[error("cannot write a table: {0}")]
    Table(#[from] csv::Error),
    /// A summary.
    #[error("cannot write the results as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// The page.
    #[error("cannot write the report: {0}")]
    Page(#[from] minijinja::Error),
    /// The folder's records.
    #[error("cannot read the results: {0}")]
    Records(#[from] std::io::Error),
}

/// What publishing gives.
pub type PublishResult<T = ()> = Result<T, PublishError>;

impl From<EvaluateError> for PublishError {
    fn from(error: EvaluateError) -> Self {
        match error {
            EvaluateError::Slabs(reason) => Self::Slabs(reason),
            EvaluateError::Ink(error) => Self::Ink(error),
            EvaluateError::Bdf(error) => Self::Bdf(error),
        }
    }
}

/// What was published.
#[derive(Clone, Debug, PartialEq)]
pub struct Published {
    /// Whether anything is missing.
    pub status: Status,
    /// Requested and finished solves.
    pub solves: Count,
    /// Number of solves that failed; of a composed layer, of packings as well.
    pub failed_solves: usize,
    /// How many packings have no room, if any.
    pub missing_packings: Option<String>,
    /// The main results in a line each.
    pub lines: Vec<String>,
    /// What to change in the study for better numbers.
    pub remarks: Vec<String>,
    /// Why there is no colour, where there is none.
    pub no_colour: Option<String>,
    /// Weighted numbers in words.
    pub numbers: Vec<String>,
    /// The widest 95 % interval of a colour, ΔE₀₀, where it is beyond `run.target_delta_e`, and
    /// what would make it narrower.
    pub widest: Option<(f64, &'static str)>,
    /// Numbers that were withheld, and why.
    pub withheld: Vec<String>,
}

/// Evaluates a single study and publishes it, with the time that this process has taken.
///
/// # Errors
/// As [`publish`]; slabs without a complete realisation, or records that do not belong together.
pub fn evaluate_and_publish(
    study: &Study,
    solved: &FinishedSolves,
    folder: &OutputFolder,
) -> PublishResult<Published> {
    let mut evaluated = Evaluated::new(study, solved)?;
    evaluated.manifest.process_seconds = processor_seconds();
    publish(&evaluated, folder)
}

/// Writes everything that the finished solves allow; removes the mark of partial results when all
/// are finished.
///
/// # Errors
/// Numbers that cannot be, too few packings with room, files that cannot be written.
pub fn publish(evaluated: &Evaluated, folder: &OutputFolder) -> PublishResult<Published> {
    let manifest = &evaluated.manifest;
    let study = manifest.study;
    if let Some(what) = manifest.unphysical() {
        folder.begin()?;
        return Err(PublishError::Unphysical(what));
    }
    if let Some(what) = manifest.refusal() {
        folder.begin()?;
        return Err(PublishError::NoRoom(what));
    }
    let pictures = pictures(evaluated)?;
    let tables = tables::of_study(manifest, evaluated.seen())?;
    let names = tables.iter().map(|(name, ..)| *name).collect();
    let first = pictures.first();
    let shown = ShownFiles {
        picture: first.map(|first| first.pictures.labelled.as_slice()),
        pictured_um: first.and_then(|first| first.thickness_um),
        tables: names,
    };
    let page = sheet(evaluated, &shown)?;
    Publication {
        study,
        status: manifest.origin.status,
        tables,
        results: serde_json::to_vec_pretty(manifest)?,
        page: on_study(page)?,
        pictures,
    }
    .write(folder)?;
    Ok(Published {
        status: manifest.origin.status,
        solves: manifest.solves,
        failed_solves: manifest.failed_solves(),
        missing_packings: manifest.missing_packings(),
        lines: main_results(manifest),
        remarks: manifest.remarks().to_vec(),
        no_colour: manifest.no_colour.clone(),
        numbers: numbers::in_words(&manifest.numbers),
        widest: missed_target(manifest),
        withheld: manifest.withheld.iter().map(Withheld::in_words).collect(),
    })
}

/// What a study's folder holds beside its records.
struct Publication<'a> {
    study: &'a Study,
    status: Status,
    pictures: Vec<NamedPictures>,
    tables: Vec<NamedTable>,
    /// `results.json`.
    results: Vec<u8>,
    /// `report.html`.
    page: String,
}

impl Publication<'_> {
    /// Writes all files; removes the mark of partial results where these are complete.
    fn write(self, folder: &OutputFolder) -> PublishResult {
        folder.begin()?;
        for NamedPictures { name, pictures, .. } in &self.pictures {
            folder.write(&format!("{name}.png"), &pictures.plain)?;
            folder.write(&format!("{name}-with-axes.png"), &pictures.labelled)?;
        }
        let mut written = FolderTables::new(folder);
        for (name, table, about) in &self.tables {
            written.write(name, table, about, &[])?;
        }
        written.describe(&self.study.title)?;
        folder.write("results.json", &self.results)?;
        folder.write("report.html", self.page.as_bytes())?;
        if self.status == Status::Complete {
            folder.complete()?;
        }
        Ok(())
    }
}

/// Pictures of a layer and the name of their files.
struct NamedPictures {
    name: String,
    /// Thickness of the layer in µm, where the study has layers of several thicknesses.
    thickness_um: Option<f64>,
    pictures: Pictures,
}

/// The picture of P1 Fig. 6 as PNG, with and without axes.
struct Pictures {
    plain: Vec<u8>,
    labelled: Vec<u8>,
}

impl Pictures {
    fn new(picture: &InkPicture, study: &Study) -> PublishResult<Self> {
        let style = PictureStyle { side_px: study.output.picture_pixels, ..PictureStyle::default() };
        let plain = png(picture, &style, study)?;
        let labelled = png(picture, &PictureStyle { labels: true, ..style }, study)?;
        Ok(Self { plain, labelled })
    }
}

/// The pictures of all layers, the first without its thickness in the name; none of a layer that is
/// solved as a whole and has impossible numbers: they show the same curves at other angles.
fn pictures(evaluated: &Evaluated) -> PublishResult<Vec<NamedPictures>> {
    let manifest = &evaluated.manifest;
    let study = manifest.study;
    let is_weighted = |number: &str| study.numbers.iter().any(|wanted| wanted.name == number);
    let of_others = |withheld: &Withheld| is_weighted(&withheld.number) || withheld.is_of_a_part(study);
    let is_sound = manifest.withheld.iter().all(of_others);
    if manifest.whole().is_some() && !is_sound {
        return Ok(Vec::new());
    }
    let step = study.angles.picture_max_deg / (PICTURE_ANGLES - 1) as f64;
    let angles: Vec<f64> = (0..PICTURE_ANGLES).map(|i| i as f64 * step).collect();
    let mut all = Vec::new();
    for (k, layer) in evaluated.pictures(&angles)?.into_iter().enumerate() {
        let name = match layer.thickness_um.filter(|_| k > 0) {
            Some(um) => format!("picture-{um}um"),
            None => "picture".to_owned(),
        };
        let pictures = Pictures::new(&layer.picture, study)?;
        all.push(NamedPictures { name, thickness_um: layer.thickness_um, pictures });
    }
    Ok(all)
}

fn png(picture: &InkPicture, style: &PictureStyle, study: &Study) -> PublishResult<Vec<u8>> {
    let bitmap: Bitmap = render(picture, style)?;
    let key = study.key().to_string();
    let program = crate::evaluate::summary::program();
    Ok(bitmap.png(&[("Title", study.title.as_str()), ("Software", &program), ("Study", &key)])?)
}
