//! Checksum of a sweep's own files, which shows whether `sweep.json` and the variants' studies are
//! as written.

use super::load::Outline;
use serde::{Deserialize, Serialize};

/// Content of `sweep.json`.
#[derive(Debug, Serialize, Deserialize)]
pub struct SealedOutline {
    /// Everything about the sweep except its studies.
    #[serde(flatten)]
    pub outline: Outline,
    /// Checksum of the outline and all studies; `None` in files of older versions.
    pub seal: Option<String>,
}

/// The first 128 bits of BLAKE3 over the outline and the studies as written, in hexadecimal.
///
/// # Errors
/// The outline cannot be written as JSON.
pub fn seal<'a>(outline: &Outline, studies: impl Iterator<Item = &'a str>) -> serde_json::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"inkwave sweep/").update(&serde_json::to_vec(outline)?);
    for text in studies {
        // including its length, so that text moved between files is noticed
        hasher.update(format!("/{}/", text.len()).as_bytes()).update(text.as_bytes());
    }
    Ok(hasher.finalize().to_hex()[..32].to_owned())
}
