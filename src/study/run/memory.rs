//! Default memory of a run: what the machine, the process's limits and its cgroups leave.

use std::path::Path;

/// Assumed free memory where the system does not report it, bytes.
const OTHERWISE: f64 = 4e9;
/// Share of the free memory for solves: packings, pages and other programs need the rest.
const SHARE: f64 = 0.8;
/// Above this a limit is none, bytes: a version 1 cgroup without a limit reports about 2⁶³.
const UNLIMITED: f64 = 1e18;

/// Memory for solves, bytes: most of what is available, where the system reports it (Linux).
pub fn usable() -> f64 {
    let meminfo = read("/proc/meminfo");
    let machine = after(&meminfo, "MemAvailable:").map_or(OTHERWISE, |kilobytes| SHARE * 1024.0 * kilobytes);
    machine.min(allowed())
}

/// Memory for solves within the limits of the process (`ulimit -v`, `ulimit -d`, cgroups), bytes;
/// exceeding them would end the program. Infinite without limits.
pub fn allowed() -> f64 {
    let threads = threads_within_limits(std::thread::available_parallelism().map_or(1, usize::from));
    let products = (threads + 1) as f64 * product_space();
    SHARE * (address_space() - products).max(0.0).min(left_of_cgroups())
}

/// Address space that a run takes besides its solves and its matrix products, bytes, and what each
/// thread adds: arenas of the allocator, stacks.
// Peaks of `examples/yellow.toml`: 0.38, 0.58 and 0.99 GB on 1, 2 and 4 threads, of which 0.04 to
// 0.06 GB are ever touched, with 0.045 GB of the program itself and products on the first thread
// only, beside a cache of 32 MiB.
const RUN_SPACE: f64 = 65e6;
const THREAD_SPACE: f64 = 205e6;

/// Last-level cache assumed where the system does not report it, bytes.
const CACHE_OTHERWISE: f64 = 64e6;
/// Buffers that dense products reserve on every thread that multiplies, the first one included, in
/// caches of the last level (`private-gemm-x86`, behind faer: one for either factor).
const PRODUCT_CACHES: f64 = 2.0;

/// As many of the requested threads as the limits of the process leave address space for; 0 if it
/// is too little for any run.
pub fn threads_within_limits(requested: usize) -> usize {
    let products = product_space();
    (((address_space() - RUN_SPACE - products) / (THREAD_SPACE + products)) as usize).min(requested)
}

/// Smallest limit for a run on one thread, bytes.
pub fn least_space() -> f64 {
    RUN_SPACE + THREAD_SPACE + 2.0 * product_space()
}

/// Whether a limit of the process bounds its address space.
pub fn is_limited() -> bool {
    address_space().is_finite()
}

/// Address space that dense products reserve on each thread, bytes.
fn product_space() -> f64 {
    PRODUCT_CACHES * last_level_cache(Path::new("/sys/devices/system/cpu")).unwrap_or(CACHE_OTHERWISE)
}

/// All caches of the third level together, bytes, by the system's folder of processors: each
/// processor adds its part of the cache that it shares. `None` where there are none.
fn last_level_cache(processors: &Path) -> Option<f64> {
    let mut sum = 0.0;
    for processor in std::fs::read_dir(processors).ok()?.flatten() {
        for cache in std::fs::read_dir(processor.path().join("cache")).into_iter().flatten().flatten() {
            let entry = |name: &str| read(cache.path().join(name)).trim().to_owned();
            if entry("level") == "3" {
                sum += bytes(&entry("size"))? / processors_in(&entry("shared_cpu_list"))?;
            }
        }
    }
    Some(sum).filter(|&sum| sum > 0.0)
}

/// A size like `307200K` in bytes.
fn bytes(text: &str) -> Option<f64> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[digits.len()..] {
        "" => 1.0,
        "K" => 1024.0,
        "M" => 1024.0 * 1024.0,
        "G" => 1024.0 * 1024.0 * 1024.0,
        _ => return None,
    };
    Some(unit * digits.parse::<f64>().ok()?)
}

/// How many processors a list like `0-7,64-71` names.
fn processors_in(list: &str) -> Option<f64> {
    let mut count = 0.0;
    for range in list.split(',') {
        let (first, last) = range.split_once('-').unwrap_or((range, range));
        count += last.parse::<f64>().ok()? - first.parse::<f64>().ok()? + 1.0;
    }
    Some(count)
}

/// Address space that the limits of the process leave, bytes.
fn address_space() -> f64 {
    let limits = read("/proc/self/limits");
    let status = read("/proc/self/status");
    let of_process = [("Max address space", "VmSize:"), ("Max data size", "VmData:")];
    let left = of_process.map(|(limit, used)| left_of_limit(&limits, limit, &status, used));
    left.into_iter().fold(f64::INFINITY, f64::min)
}

fn read(path: impl AsRef<Path>) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

/// The number after a word at the start of a line.
fn after(text: &str, word: &str) -> Option<f64> {
    text.lines().find_map(|line| line.strip_prefix(word))?.split_whitespace().next()?.parse().ok()
}

/// Bytes left of a limit of the process; `None` if it is "unlimited".
fn left_of_limit(limits: &str, limit: &str, status: &str, used: &str) -> f64 {
    let used = 1024.0 * after(status, used).unwrap_or(0.0);
    after(limits, limit).map_or(f64::INFINITY, |most| (most - used).max(0.0))
}

/// Bytes left by the process's cgroup and its ancestors.
fn left_of_cgroups() -> f64 {
    read("/proc/self/cgroup").lines().map(left_of_hierarchy).fold(f64::INFINITY, f64::min)
}

/// Bytes left in one hierarchy, given as `number:controllers:path`: version 2 names no controllers,
/// version 1 names `memory`.
fn left_of_hierarchy(line: &str) -> f64 {
    let [_, controllers, path] = line.splitn(3, ':').collect::<Vec<_>>()[..] else { return f64::INFINITY };
    let (root, names) = match controllers {
        "" => ("/sys/fs/cgroup", ["memory.max", "memory.current", "inactive_file "]),
        "memory" => (
            "/sys/fs/cgroup/memory",
            ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file "],
        ),
        _ => return f64::INFINITY,
    };
    let folders = Path::new(path.trim_start_matches('/')).ancestors();
    folders.map(|folder| left_of_group(&Path::new(root).join(folder), names)).fold(f64::INFINITY, f64::min)
}

/// Bytes left in one group: its limit minus its use, without file pages, which the kernel can drop.
fn left_of_group(folder: &Path, [limit, current, droppable]: [&str; 3]) -> f64 {
    let Some(most) = after(&read(folder.join(limit)), "").filter(|&bytes| bytes < UNLIMITED) else {
        return f64::INFINITY;
    };
    let used = after(&read(folder.join(current)), "").unwrap_or(0.0);
    let files = after(&read(folder.join("memory.stat")), droppable).unwrap_or(0.0);
    (most - (used - files).max(0.0)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_leaves_what_is_not_taken_yet() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units\n\
                      Max data size             unlimited            unlimited            bytes\n\
                      Max address space         204800000            204800000            bytes\n";
        let status = "VmSize:\t  100000 kB\nVmData:\t   50000 kB\n";
        assert_eq!(left_of_limit(limits, "Max address space", status, "VmSize:"), 102_400_000.0);
        assert_eq!(left_of_limit(limits, "Max data size", status, "VmData:"), f64::INFINITY);
    }

    /// Two sockets of two processors each, whose third level has 300 MiB a socket, as the system
    /// lists them.
    #[test]
    fn products_reserve_the_caches_of_the_whole_machine() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(last_level_cache(folder.path()), None);
        for (processor, shared) in [(0, "0-1"), (1, "0-1"), (2, "2,3"), (3, "2,3")] {
            for (index, level, size) in [(0, 1, "48K"), (2, 2, "2M"), (3, 3, "307200K")] {
                let cache = folder.path().join(format!("cpu{processor}/cache/index{index}"));
                std::fs::create_dir_all(&cache).unwrap();
                let put = |name: &str, text: &str| std::fs::write(cache.join(name), text).unwrap();
                put("level", &format!("{level}\n"));
                put("size", &format!("{size}\n"));
                put("shared_cpu_list", &format!("{shared}\n"));
            }
        }
        assert_eq!(last_level_cache(folder.path()), Some(600.0 * 1024.0 * 1024.0));
    }

    #[test]
    fn a_cgroup_leaves_its_limit_less_what_cannot_be_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        let names = ["memory.max", "memory.current", "inactive_file "];
        assert_eq!(left_of_group(folder.path(), names), f64::INFINITY);
        put("memory.max", "max\n");
        assert_eq!(left_of_group(folder.path(), names), f64::INFINITY);
        put("memory.max", "1000000\n");
        put("memory.current", "600000\n");
        put("memory.stat", "anon 300000\ninactive_file 250000\n");
        assert_eq!(left_of_group(folder.path(), names), 650_000.0);
    }
}
