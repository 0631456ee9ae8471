//! The text of a file, whatever its encoding.

use crate::numerics::files::{self, FileError};
use std::borrow::Cow;
use std::path::Path;

/// Text of a file in UTF-8, in UTF-16 with a byte order mark, or else in Latin-1.
///
/// # Errors
/// The file cannot be read, is too large, or is no text.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    let bytes = files::read_bytes(path, files::TABLE);
    decode(&bytes.map_err(|error| FileError::new(path.display(), error))?)
        .map(|text| with_line_feeds(&text).into_owned())
        .map_err(|reason| FileError::new(path.display(), reason))
}

/// The text with a line feed at the end of each line, where some end by a carriage return alone.
pub fn with_line_feeds(text: &str) -> Cow<'_, str> {
    let mut rest = text.bytes().zip(text.bytes().skip(1).chain([0]));
    if rest.any(|pair| pair.0 == b'\r' && pair.1 != b'\n') {
        Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n"))
    } else {
        Cow::Borrowed(text)
    }
}

fn decode(bytes: &[u8]) -> Result<String, &'static str> {
    const NO_TEXT: &str = "it is not plain text (a spreadsheet's own format?): save it as CSV in UTF-8";
    let wide = |unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        String::from_utf16(&units).map_err(|_| NO_TEXT)
    };
    match bytes {
        [0xff, 0xfe, ..] => return wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => return wide(u16::from_be_bytes),
        _ => {}
    }
    if bytes.contains(&0) {
        return Err(NO_TEXT);
    }
    // Latin-1: every byte is the character of that number
    let text = std::str::from_utf8(bytes)
        .map_or_else(|_| bytes.iter().map(|&b| char::from(b)).collect(), str::to_owned);
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_end_by_carriage_returns_alone_are_lines() {
        assert_eq!(with_line_feeds("a\rb\r\nc\r"), "a\nb\nc\n");
        assert_eq!(with_line_feeds("a\r\nb"), "a\r\nb");
    }

    #[test]
    fn utf_16_and_latin_1_are_read_and_other_bytes_are_no_text() {
        let wide: Vec<u8> =
            [0xff, 0xfe].into_iter().chain("nm;°\n".encode_utf16().flat_map(u16::to_le_bytes)).collect();
        assert_eq!(decode(&wide).unwrap(), "nm;°\n");
        assert_eq!(decode(b"2\xb0").unwrap(), "2°");
        assert!(decode(b"PK\x03\x04\0\0").is_err());
    }
}
