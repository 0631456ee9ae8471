//! The seal of a sweep's own files: what shows that `sweep.json` and the variants' studies are those that were written.

use super::load::Outline;
use serde::{Deserialize, Serialize};

/// The file `sweep.json`.
#[derive(Debug, Serialize, Deserialize)]
pub struct SealedOutline {
    /// All of a sweep but its studies.
    #[serde(flatten)]
    pub outline: Outline,
    /// Checksum of the outline and of every variant's study; none in files of older versions.
    pub seal: Option<String>,
}

/// The first 128 bits of BLAKE3 over the outline and the studies as they are written, in hexadecimal.
///
/// # Errors
/// An outline that JSON does not hold.
pub fn seal<'a>(outline: &Outline, studies: impl Iterator<Item = &'a str>) -> serde_json::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"inkwave sweep/").update(&serde_json::to_vec(outline)?);
    for text in studies {
        // with its length, so that nothing moves from one file to the next unseen
        hasher.update(format!("/{}/", text.len()).as_bytes()).update(text.as_bytes());
    }
    Ok(hasher.finalize().to_hex()[..32].to_owned())
}
