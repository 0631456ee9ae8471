//! Memory that a run may use when nobody says how much.

/// Where the system does not tell what is free.
const OTHERWISE: f64 = 4e9;
/// Of what is free: the packing, the pages and the rest of the machine need some.
const SHARE: f64 = 0.8;

/// Bytes that solves may take: most of what is available, where the system tells it (Linux).
pub fn usable() -> f64 {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let available = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kilobytes = available.and_then(|rest| rest.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kilobytes.map_or(OTHERWISE, |kb| SHARE * 1024.0 * kb)
}
