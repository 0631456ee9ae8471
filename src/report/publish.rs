//! Writes the results of the finished solves: `results.json`, tables, picture and page.

use super::columns::FolderTables;
use super::numbers;
use super::page::on_study;
use super::sheet::{colour_in_words, missed_target, sheet};
use super::tables::{self, NamedTable};
use crate::appearance::bdf::BdfError;
use crate::appearance::picture::InkPicture;
use crate::draw::OutputError;
use crate::draw::figure::Bitmap;
use crate::draw::picture::{PictureStyle, render};
use crate::evaluate::ink::InkError;
use crate::evaluate::manifest::{Manifest, Status};
use crate::evaluate::published::Withheld;
use crate::evaluate::seen::{Seen, see};
use crate::evaluate::summary::summarise;
use crate::input::study::Study;
use crate::run::Collected;
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

/// What was published.
#[derive(Clone, Debug, PartialEq)]
pub struct Published {
    /// Whether anything is missing.
    pub status: Status,
    /// L*, a*, b* and C* under natural light in words, where there is a colour.
    pub colour: Option<String>,
    /// Why there is no colour, where there is none.
    pub no_colour: Option<String>,
    /// Weighted numbers in words.
    pub numbers: Vec<String>,
    /// The widest 95 % interval of a colour, ΔE₀₀, where it is beyond `run.target_delta_e`.
    pub widest: Option<f64>,
    /// Numbers that were withheld, and why.
    pub withheld: Vec<String>,
}

/// Writes everything that the finished solves allow; removes the mark of partial results when all
/// are finished.
///
/// # Errors
/// Files that cannot be written, or records that do not belong together.
pub fn publish(study: &Study, collected: &Collected, folder: &OutputFolder) -> PublishResult<Published> {
    let seen = see(study, collected)?;
    let process_seconds = processor_seconds();
    publish_seen(&Manifest { process_seconds, ..summarise(study, collected, &seen) }, &seen, folder)
}

/// Publishes a study that has been evaluated.
pub(crate) fn publish_seen(
    manifest: &Manifest<&Study>,
    seen: &Seen,
    folder: &OutputFolder,
) -> PublishResult<Published> {
    let study = manifest.study;
    if let Some(what) = manifest.unphysical() {
        folder.begin()?;
        return Err(PublishError::Unphysical(what));
    }
    if let Some(what) = manifest.tried_packings.refusal(study.failed_packings) {
        folder.begin()?;
        return Err(PublishError::NoRoom(what));
    }
    // the picture shows the same curves at other angles
    let is_weighted = |number: &str| study.numbers.iter().any(|wanted| wanted.name == number);
    let is_sound = manifest.withheld.iter().all(|withheld| is_weighted(&withheld.number));
    let pictures = if is_sound { pictures(study, seen)? } else { None };
    let page = sheet(manifest, seen, pictures.as_ref().map(|p| p.labelled.as_slice()))?;
    Publication {
        study,
        status: manifest.origin.status,
        tables: tables_of(manifest, seen)?,
        results: serde_json::to_vec_pretty(manifest)?,
        page: on_study(include_str!("sheet.html"), page)?,
        pictures: pictures.into_iter().map(|pictures| NamedPictures::new("picture", pictures)).collect(),
    }
    .write(folder)?;
    let colour = colour_in_words(manifest);
    let withheld = manifest.withheld.iter().map(Withheld::in_words).collect();
    let no_colour = manifest.no_colour.clone();
    let widest = missed_target(manifest);
    let numbers = numbers::in_words(&manifest.numbers);
    Ok(Published { status: manifest.origin.status, colour, no_colour, numbers, widest, withheld })
}

/// All tables of a layer that is solved as a whole.
fn tables_of(manifest: &Manifest<&Study>, seen: &Seen) -> csv::Result<Vec<NamedTable>> {
    let amplitude_error = manifest.certainty.amplitude_error_estimate;
    let bdf = tables::distributions(&seen.bdfs, amplitude_error, manifest.study.layer.index_out)?;
    let mut all = vec![
        ("spectra.csv", tables::rows(&manifest.spectra)?, "spectra of the layer alone, and on its paper"),
        ("bdf.csv", bdf, "distributions of the layer alone, order by order"),
    ];
    all.extend(tables::absorbed(&manifest.absorbed)?);
    let factor = manifest.certainty.coverage_factor_95;
    all.extend(tables::ink_maker(manifest.ink_maker.as_ref(), factor)?);
    all.extend(numbers::numbers_table(&manifest.numbers)?);
    all.extend(tables::prints(manifest.prints.as_ref())?);
    all.extend(tables::print_spectra(manifest.prints.as_ref(), &manifest.study.wavelengths_nm)?);
    Ok(all)
}

/// What a study's folder holds beside its records, whichever evaluator made the numbers.
pub(super) struct Publication<'a> {
    pub(super) study: &'a Study,
    pub(super) status: Status,
    pub(super) pictures: Vec<NamedPictures>,
    pub(super) tables: Vec<NamedTable>,
    /// `results.json`.
    pub(super) results: Vec<u8>,
    /// `report.html`.
    pub(super) page: String,
}

impl Publication<'_> {
    /// Writes all files; removes the mark of partial results where these are complete.
    pub(super) fn write(self, folder: &OutputFolder) -> PublishResult {
        folder.begin()?;
        for NamedPictures { name, pictures } in &self.pictures {
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
pub(super) struct NamedPictures {
    name: String,
    pub(super) pictures: Pictures,
}

impl NamedPictures {
    pub(super) fn new(name: impl Into<String>, pictures: Pictures) -> Self {
        Self { name: name.into(), pictures }
    }
}

/// The picture of P1 Fig. 6 as PNG, with and without axes.
pub(super) struct Pictures {
    pub(super) plain: Vec<u8>,
    pub(super) labelled: Vec<u8>,
}

impl Pictures {
    pub(super) fn new(picture: &InkPicture, study: &Study) -> PublishResult<Self> {
        let style = PictureStyle { side_px: study.output.picture_pixels, ..PictureStyle::default() };
        let plain = png(picture, &style, study)?;
        let labelled = png(picture, &PictureStyle { labels: true, ..style }, study)?;
        Ok(Self { plain, labelled })
    }
}

/// Angles of the picture, degrees.
pub(super) fn picture_angles(study: &Study) -> Vec<f64> {
    let step = study.angles.picture_max_deg / (PICTURE_ANGLES - 1) as f64;
    (0..PICTURE_ANGLES).map(|i| i as f64 * step).collect()
}

/// `None` if the wavelengths or angles do not suffice for a colour.
fn pictures(study: &Study, seen: &Seen) -> PublishResult<Option<Pictures>> {
    let Ok(ink) = &seen.ink else { return Ok(None) };
    match ink.picture(&picture_angles(study), study.output.mirrored_sky) {
        Err(InkError::Colour(_)) => Ok(None),
        picture => Ok(Some(Pictures::new(&picture?, study)?)),
    }
}

fn png(picture: &InkPicture, style: &PictureStyle, study: &Study) -> PublishResult<Vec<u8>> {
    let bitmap: Bitmap = render(picture, style)?;
    let key = study.key().to_string();
    let program = crate::evaluate::summary::program();
    Ok(bitmap.png(&[("Title", study.title.as_str()), ("Software", &program), ("Study", &key)])?)
}
