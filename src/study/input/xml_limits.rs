//! Refuses XML files whose sizes would make the parser slow: its time grows with their squares.

/// Maximum number of attributes of one element.
const MOST_ATTRIBUTES: usize = 256;
/// Maximum nesting depth of elements.
const DEEPEST: usize = 64;
/// Maximum number of namespace declarations in the whole file.
const MOST_NAMESPACES: usize = 4096;

/// Describes what is too large, if anything. The text need not be well formed.
pub(super) fn too_large(text: &str) -> Option<String> {
    let namespaces = text.matches("xmlns").count();
    if namespaces > MOST_NAMESPACES {
        return Some(format!("{namespaces} declarations of namespaces; at most {MOST_NAMESPACES} are read"));
    }
    let (mut rest, mut depth) = (text, 0usize);
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        let (tag, after) = tag(rest);
        rest = after;
        depth = match tag.as_bytes().first() {
            Some(b'!' | b'?') => depth,
            Some(b'/') => depth.saturating_sub(1),
            _ if tag.ends_with('/') => depth,
            _ => depth + 1,
        };
        let attributes =
            tag.split(['"', '\'']).step_by(2).map(|part| part.matches('=').count()).sum::<usize>();
        if !tag.starts_with('!') && attributes > MOST_ATTRIBUTES {
            return Some(format!(
                "{attributes} attributes of one element; at most {MOST_ATTRIBUTES} are read"
            ));
        }
        if depth > DEEPEST {
            return Some(format!("more than {DEEPEST} elements inside one another"));
        }
    }
    None
}

/// The text between `<` and its end, and the rest; comments and character data have their own ends.
fn tag(rest: &str) -> (&str, &str) {
    let end =
        |words: &str| rest.find(words).map_or((rest, ""), |at| (&rest[..at], &rest[at + words.len()..]));
    if rest.starts_with("!--") {
        return end("-->");
    }
    if rest.starts_with("![CDATA[") {
        return end("]]>");
    }
    let mut quote = None;
    for (at, c) in rest.char_indices() {
        match (quote, c) {
            (None, '>') => return (&rest[..at], &rest[at + 1..]),
            (None, '"' | '\'') => quote = Some(c),
            (Some(open), c) if c == open => quote = None,
            _ => {}
        }
    }
    (rest, "")
}

#[cfg(test)]
mod tests {
    use super::too_large;

    #[test]
    fn what_would_take_a_parser_long_is_refused_and_the_usual_is_not() {
        let usual = "<?xml version=\"1.0\"?><!-- < a = 'b' --><c:CxF xmlns:c=\"x\"><c:O Name=\"a > b = c\" Id='1'/></c:CxF>";
        assert_eq!(too_large(usual), None);
        let many: String = (0..60_000).map(|i| format!(" a{i}=\"1\"")).collect();
        assert!(too_large(&format!("<CxF{many}/>")).unwrap().contains("60000 attributes"));
        let nested: String = (0..3000).map(|i| format!("<a xmlns:n{i}=\"u{i}\">")).collect();
        assert!(too_large(&nested).unwrap().contains("inside one another"));
        let side_by_side: String = (0..5000).map(|i| format!("<a xmlns:n{i}=\"u{i}\"/>")).collect();
        assert!(too_large(&side_by_side).unwrap().contains("5000 declarations"));
        for unfinished in ["<", "<a b=\"", "<!-- ", "<![CDATA[ <a>", "a < b"] {
            assert_eq!(too_large(unfinished), None, "{unfinished}");
        }
    }
}
