//! Texts of people in tables that other programs open.

/// A cell of a CSV table. What a spreadsheet would take for a formula starts with an apostrophe, which makes it text there.
pub fn text(words: &str) -> String {
    let formula = words.starts_with(['=', '+', '-', '@', '\t', '\r']) && words.parse::<f64>().is_err();
    if formula { format!("'{words}") } else { words.to_owned() }
}

/// Words in a line of Markdown: no cell, line or tag ends there.
pub fn markdown(words: &str) -> String {
    words.replace('|', "\\|").replace('<', "&lt;").replace(['\n', '\r'], " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_become_text_and_numbers_stay_numbers() {
        for formula in ["=1+1", "+A1", "-A1", "@SUM(A1)", "\t=1", "=HYPERLINK(\"x\")"] {
            assert_eq!(text(formula), format!("'{formula}"));
        }
        for harmless in ["yellow", "-0.5", "+3e4", "15 %", "a=b", ""] {
            assert_eq!(text(harmless), harmless);
        }
        assert_eq!(markdown("a|b\n<i>"), "a\\|b &lt;i>");
    }
}
