//! Reconstructs the command line that was typed.

/// The whole command line, quoted for a shell where that is needed.
pub fn this_command() -> String {
    std::env::args_os().map(|word| quoted(&word.to_string_lossy())).collect::<Vec<_>>().join(" ")
}

/// How to go on after a stop.
pub fn to_resume() -> String {
    format!("to resume: {}", this_command())
}

/// Puts a word in single quotes unless every character is harmless to a shell.
pub(super) fn quoted(word: &str) -> String {
    if !word.is_empty() && word.chars().all(|c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c)) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn a_shell_reads_the_same_words() {
        assert_eq!(quoted("--output=out/yellow"), "--output=out/yellow");
        assert_eq!(quoted("my ink.toml"), "'my ink.toml'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
