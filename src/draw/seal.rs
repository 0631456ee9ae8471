//! Seals of generated pages: a last line that shows whether the page was edited, and the version of
//! its method.

use crate::store::identity::METHOD_VERSION;

/// What the seal's line begins with.
const MARK: &str = "<!-- generated; seal ";
/// What stands before the version of the method, in seals and in footers.
const METHOD: &str = ", method ";
/// Digits of the hash.
const DIGITS: usize = 16;

/// Why a seal does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Broken {
    /// There is no seal.
    #[error("the page has no seal: generate it with its script")]
    Missing,
    /// The text was changed after it was sealed.
    #[error("the page was edited after it was generated: generate it again with its script")]
    Edited,
}

/// Seals a text, in place of an older seal, with the current version of the method.
pub fn sealed(text: &str) -> String {
    sealed_by(text, METHOD_VERSION)
}

/// Seals a text whose numbers were made by another version of the method.
pub fn sealed_by(text: &str, method: u32) -> String {
    with_method(text, Some(method))
}

fn with_method(text: &str, method: Option<u32>) -> String {
    let body = body(text).trim_end();
    let method = method.map_or_else(String::new, |version| format!("{METHOD}{version}"));
    format!("{body}\n\n{MARK}{}{method} -->\n", hash(&format!("{body}{method}")))
}

/// Version of the method behind a page's numbers, if its seal or footer states it.
pub fn method_of(page: &str) -> Option<u32> {
    let digits = page.rsplit_once(METHOD)?.1;
    let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

/// Checks that a text is unchanged since it was sealed.
///
/// # Errors
/// It has no seal, or was edited.
pub fn check(text: &str) -> Result<(), Broken> {
    let seal = &text[body(text).len()..];
    if !seal.starts_with(MARK) {
        return Err(Broken::Missing);
    }
    if with_method(text, method_of(seal)) == text { Ok(()) } else { Err(Broken::Edited) }
}

/// The text before the seal.
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
        let older = page.replace(&format!("method {METHOD_VERSION}"), "method 0");
        assert_eq!((check(&older), method_of(&page)), (Err(Broken::Edited), Some(METHOD_VERSION)));
        assert_eq!(method_of("of some method"), None);
    }
}
