//! Keys that have newer names: the old ones are read for ever, and whoever uses them is told.

/// The older and the newer name.
const KEYS: [(&str, &str); 4] =
    [("index_above", "index_in"), ("index_below", "index_out"), ("n_below", "n_in"), ("n_above", "n_out")];

/// One line for each older key that a TOML or JSON text sets.
pub fn remarks(text: &str) -> Vec<String> {
    let used = KEYS.iter().filter(|(older, _)| text.lines().any(|line| sets(line, older)));
    used.map(|(older, newer)| format!("{older} is an older name of {newer}; both are read")).collect()
}

/// Whether a line gives a value to the key, quoted or not; comments do not.
fn sets(line: &str, key: &str) -> bool {
    let code = line.split('#').next().unwrap_or("");
    code.match_indices(key).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        let after = code[at + key.len()..].trim_start_matches(['"', '\'']).trim_start();
        !before.is_some_and(|c| c.is_alphanumeric() || c == '_') && after.starts_with(['=', ':'])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn older_keys_are_told_once_each() {
        let toml =
            "[layer]\nindex_above = 1.2 # index_below = 1\nbinder.index = 1.5\nlayer.index_above = 1.3\n";
        assert_eq!(remarks(toml), ["index_above is an older name of index_in; both are read"]);
        assert_eq!(remarks(r#"{ "n_below": 1.5, "n_out" : 1 }"#).len(), 1);
        assert!(remarks("# index_above = 1\nmy_index_above = 1\nn_in = 1\n").is_empty());
    }
}
