//! A last line that shows whether a generated page is still as it was generated.

/// What the seal's line begins with.
const MARK: &str = "<!-- generated; seal ";
/// Digits of the hash.
const DIGITS: usize = 16;

/// Why a page is not as it was generated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Broken {
    /// There is no seal.
    #[error("the page has no seal: make it with its script")]
    Missing,
    /// The text is not the one that was sealed.
    #[error("the page was edited after it was made: make it again with its script")]
    Edited,
}

/// The text with its seal, in place of one that it has.
pub fn sealed(text: &str) -> String {
    let body = body(text).trim_end();
    format!("{body}\n\n{MARK}{} -->\n", hash(body))
}

/// Whether a text is as it was sealed.
///
/// # Errors
/// It has no seal, or was edited.
pub fn check(text: &str) -> Result<(), Broken> {
    let body = body(text);
    let seal =
        text[body.len()..].strip_prefix(MARK).and_then(|rest| rest.get(..DIGITS)).ok_or(Broken::Missing)?;
    let whole = sealed(body) == text && seal == hash(body.trim_end());
    if whole { Ok(()) } else { Err(Broken::Edited) }
}

/// What stands before the seal.
fn body(text: &str) -> &str {
    text.rfind(MARK).map_or(text, |i| &text[..i])
}

fn hash(body: &str) -> String {
    blake3::hash(body.as_bytes()).to_hex()[..DIGITS].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seal_holds_until_a_letter_changes() {
        let page = sealed("# Report\n\nAll is well.\n");
        assert_eq!(check(&page), Ok(()));
        assert_eq!(sealed(&page), page);
        assert_eq!(check(&page.replace("well", "fine")), Err(Broken::Edited));
        assert_eq!(check(&format!("{page}More.\n")), Err(Broken::Edited));
        assert_eq!(check("# Report\n"), Err(Broken::Missing));
    }
}
