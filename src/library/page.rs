//! The page on which the plates of a library are composed: one file that needs nothing else.

use super::gather::GatheredLibrary;

const PAGE: &str = include_str!("page.html");
const ENGINE: &str = include_str!("compose.js");
const CONTROLS: &str = include_str!("page.js");

/// The page with the library in it, and above its plates what is no plate.
///
/// # Errors
/// The library cannot be written as JSON.
pub fn page(gathered: &GatheredLibrary, title: &str) -> serde_json::Result<String> {
    let GatheredLibrary { library, left_out } = gathered;
    // within a script, nothing may look like its end
    let json = serde_json::to_string(library)?.replace("</", "<\\/");
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
    let title = escaped(title);
    let left_out: String =
        left_out.iter().map(|words| format!("<p class=\"soft\">{}</p>\n", escaped(words))).collect();
    let made = format!("{}, method {}", library.program.replace("--", ""), library.method);
    let parts = [
        ("@TITLE@", title.as_str()),
        ("@ENGINE@", ENGINE),
        ("@CONTROLS@", CONTROLS),
        ("@MADE@", made.as_str()),
        ("@LEFT_OUT@", left_out.as_str()),
        ("@LIBRARY@", &json),
    ];
    Ok(parts.iter().fold(PAGE.to_owned(), |page, (place, part)| page.replace(place, part)))
}
