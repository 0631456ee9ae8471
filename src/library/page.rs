//! The page on which the plates of a library are composed: one file that needs nothing else.

use crate::evaluate::composed::library::Library;

const PAGE: &str = include_str!("page.html");
const ENGINE: &str = include_str!("compose.js");
const CONTROLS: &str = include_str!("page.js");

/// The page with the library in it.
///
/// # Errors
/// The library cannot be written as JSON.
pub fn page(library: &Library, title: &str) -> serde_json::Result<String> {
    // within a script, nothing may look like its end
    let json = serde_json::to_string(library)?.replace("</", "<\\/");
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    let made = format!("{}, method {}", library.program.replace("--", ""), library.method);
    let parts = [
        ("@TITLE@", title.as_str()),
        ("@ENGINE@", ENGINE),
        ("@CONTROLS@", CONTROLS),
        ("@MADE@", made.as_str()),
        ("@LIBRARY@", &json),
    ];
    Ok(parts.iter().fold(PAGE.to_owned(), |page, (place, part)| page.replace(place, part)))
}
