//! The layer of another study, which an area bears, from its results.

use super::{DotsReader, SLACK};
use crate::appearance::paper_series::{AreaOptics, LayerOptics};
use crate::input::file::RESULTS;
use crate::wave::Wave;

impl DotsReader<'_, '_> {
    /// The layer of a results file at this study's wavelengths, or what is found, allowed and to
    /// be done.
    pub(super) fn layer(&self, folder: &str) -> Result<LayerOptics, [String; 3]> {
        #[derive(serde::Deserialize)]
        struct Solved {
            #[serde(default)]
            wave: Wave,
        }
        #[derive(serde::Deserialize)]
        struct Results {
            #[serde(default)]
            status: String,
            study: Solved,
            optics: Option<LayerOptics>,
        }
        if folder.trim().is_empty() {
            let found = if folder.is_empty() { "nothing" } else { "blanks alone" };
            let remedy = "write the folder of that study's results, such as results = \"out/cyan\"";
            return Err([found, "a folder", remedy].map(str::to_owned));
        }
        let path = self.tables.folder.join(folder).join(RESULTS);
        let allowed = "a folder of results of a study on paper";
        let refused = |found: String| {
            [found, allowed.to_owned(), "run that study first: inkwave run STUDY.toml".to_owned()]
        };
        let text = std::fs::read_to_string(&path)
            .map_err(|error| refused(format!("{}: {error}", path.display())))?;
        let results: Results = serde_json::from_str(&text)
            .map_err(|error| refused(format!("{}, which is no results file: {error}", path.display())))?;
        if results.status == "partial" {
            let found = format!("{}, of a run that was interrupted", path.display());
            return Err([found, allowed.to_owned(), "give that run's command again: it goes on".to_owned()]);
        }
        let Some(layer) = results.optics else {
            return Err(refused(format!("{}, which holds no layer on paper", path.display())));
        };
        let wave = self.file.light.wave;
        if results.study.wave != wave {
            let found = format!("a layer of the {} wave", results.study.wave.name());
            let allowed = format!("one of this study's, the {} wave", wave.name());
            return Err([found, allowed, "give both studies one light.wave".to_owned()]);
        }
        let index_out = self.file.layer.index_out;
        if (layer.index_out - index_out).abs() > SLACK {
            let found = format!("a layer over a medium of index {}", layer.index_out);
            let allowed = format!("one over the medium below this layer, {index_out}");
            return Err([found, allowed, "give both studies one index_out and one contact".to_owned()]);
        }
        let ends = |all: &[f64]| all.first().copied().zip(all.last().copied());
        let of_study = ends(self.tables.wavelengths_nm);
        let is_sound = |rows: &Vec<AreaOptics>| rows.len() == layer.wavelengths_nm.len();
        let rows = layer.replicates.iter().chain(&layer.moved).chain([&layer.whole]);
        if let (Some((from, to)), Some((first, last))) = (of_study, ends(&layer.wavelengths_nm)) {
            if first > from + SLACK || last < to - SLACK || !rows.into_iter().all(is_sound) {
                let found = format!("wavelengths from {first} to {last} nm");
                let allowed = format!("those of this study, {from} to {to} nm");
                return Err([found, allowed, "give both studies one [light]".to_owned()]);
            }
            return Ok(layer.at(self.tables.wavelengths_nm));
        }
        Err(refused(format!("{}, which has no wavelengths", path.display())))
    }
}
