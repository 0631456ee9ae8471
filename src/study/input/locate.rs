//! Finds a field in the study file, so that an error can show its line.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Where a field stands, in bytes of the text.
struct FieldPlace {
    /// Its name; of an entry of a list, the entry.
    key: Range<usize>,
    /// Its value; of a table, which may be spread over the file, its name.
    value: Range<usize>,
}

/// Position in bytes of the value at `field` (such as `pigment[0].index.k`), or of the deepest
/// existing table on the way to it. `None` if the text is not TOML or contains no such table.
pub fn span_of(text: &str, field: &str) -> Option<Range<usize>> {
    place_of(text, field).map(|place| place.value)
}

/// Position of the name of a field instead of its value.
pub fn key_span_of(text: &str, field: &str) -> Option<Range<usize>> {
    place_of(text, field).map(|place| place.key)
}

fn place_of(text: &str, field: &str) -> Option<FieldPlace> {
    let document = DeTable::parse(text).ok()?;
    let mut steps = steps(field);
    let (key, mut value) = document.get_ref().get_key_value(steps.next()?)?;
    let mut place = FieldPlace { key: key.span(), value: outline(key.span(), value) };
    for step in steps {
        match value.get_ref() {
            DeValue::Table(table) => {
                let Some((key, entry)) = table.get_key_value(step) else { break };
                place = FieldPlace { key: key.span(), value: outline(key.span(), entry) };
                value = entry;
            }
            DeValue::Array(items) => {
                let Some(item) = step.parse().ok().and_then(|i: usize| items.get(i)) else { break };
                place = FieldPlace { key: item.span(), value: item.span() };
                value = item;
            }
            _ => break,
        }
    }
    Some(place)
}

/// `pigment[0].index.k` → `pigment`, `0`, `index`, `k`.
pub fn steps(field: &str) -> impl Iterator<Item = &str> {
    field.split(['.', '[', ']']).filter(|step| !step.is_empty())
}

/// Position of a value; for a table, which may be spread over the file, that of its name.
fn outline(key: Range<usize>, value: &Spanned<DeValue>) -> Range<usize> {
    if let DeValue::Table(_) = value.get_ref() { key } else { value.span() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[layer]\nthickness_um = 1.0\nbinder.index = 1.5\n\
        [[pigment]]\nname = 'a'\n[[pigment]]\nname = 'b'\nindex = { n = 1.4, k = -0.1 }\n\
        [light]\nwavelengths_nm = [400.0, nan]\n";

    fn shown(field: &str) -> Option<&'static str> {
        span_of(TEXT, field).map(|span| &TEXT[span])
    }

    #[test]
    fn a_field_is_found_wherever_it_stands() {
        assert_eq!(shown("layer.thickness_um"), Some("1.0"));
        assert_eq!(shown("layer.binder.index"), Some("1.5"));
        assert_eq!(shown("pigment[1].index.k"), Some("-0.1"));
        assert_eq!(shown("light.wavelengths_nm[1]"), Some("nan"));
        let key = |field: &str| key_span_of(TEXT, field).map(|span| &TEXT[span]);
        assert_eq!(key("layer.thickness_um"), Some("thickness_um"));
        assert_eq!(key("pigment[1].index.k"), Some("k"));
    }

    #[test]
    fn a_missing_field_points_at_its_table() {
        assert_eq!(shown("light.step_nm"), Some("light"));
        assert_eq!(shown("pigment[0].index"), Some("[[pigment]]"));
        assert_eq!(shown("paper.albedo"), None);
    }
}
