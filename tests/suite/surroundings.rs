//! What surrounds the program: readers that go, disks that are full, names that are no text, little memory, no folder for
//! temporary files, titles that a terminal or a browser would obey.
#![cfg(target_os = "linux")]

use crate::run_support::{TINY, command, study, succeed};
use std::fs::File;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

fn inkwave() -> Command {
    Command::new(env!("CARGO_BIN_EXE_inkwave"))
}

/// A finished run that the tests share; its study's title is one that terminals and browsers would obey.
fn finished() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let make = || {
        let folder = tempfile::tempdir().unwrap();
        let text = TINY.replace("Tiny yellow", "<!--<script>");
        let done = command(&study(folder.path(), &text), &folder.path().join("out"), &[]).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let said = [done.stdout, done.stderr].concat();
        assert!(!said.contains(&0x1b) && !said.contains(&7), "{}", String::from_utf8_lossy(&said));
        folder
    };
    FOLDER.get_or_init(make).path()
}

fn no_panic(done: &Output) -> String {
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.code().is_some_and(|code| code != 101), "{:?}: {said}", done.status);
    assert!(!said.contains("panicked") && !said.contains("memory allocation"), "{said}");
    said
}

#[test]
fn readers_that_go_and_full_disks_end_no_command_with_a_panic() {
    let export = || {
        let mut export = inkwave();
        export.arg("export").arg(finished().join("out")).args(["--to", "cgats,cxf"]);
        export
    };
    let mut man = inkwave();
    man.arg("man").arg(finished().join("man"));
    let mut completions = inkwave();
    completions.args(["completions", "bash"]);
    for mut command in [export(), man, completions] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let done = command.stdout(full).stderr(Stdio::piped()).output().unwrap();
        assert!(no_panic(&done).contains("cannot write to standard output"));
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let done = command.stdout(writer).output().unwrap();
        assert_eq!(no_panic(&done), "", "a reader that has gone has heard enough");
    }
}

#[test]
fn names_that_are_no_text_are_names_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join(std::ffi::OsStr::from_bytes(b"out\xff"));
    let done = command(&study(folder.path(), TINY), &out, &[]).output().unwrap();
    no_panic(&done);
    assert!(done.status.success() && out.join("results.json").exists());
}

/// Runs a study within this address space.
fn within(kilobytes: u32, text: &str) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let study = study(folder.path(), text);
    let out = folder.path().join("out");
    let line = format!("ulimit -v {kilobytes}; exec \"$0\" run \"$1\" --output \"$2\"");
    let mut shell = Command::new("bash");
    shell.args(["-c", &line, env!("CARGO_BIN_EXE_inkwave")]).arg(study).arg(out);
    shell.env("RUST_BACKTRACE", "0").output().unwrap()
}

/// The number of megabytes before these words of a refusal.
fn megabytes(refusal: &str, of: [&str; 3]) -> Option<u32> {
    let separates = |c: char| c.is_whitespace() || "│,;".contains(c);
    let words: Vec<&str> = refusal.split(separates).filter(|word| !word.is_empty()).collect();
    let place = words.windows(4).position(|four| four[0] == "MB" && four[1..] == of)?;
    words[place.checked_sub(1)?].parse().ok()
}

/// Megabytes of address space that a refusal says are needed: they grow with the machine's caches, of which the
/// libraries behind matrix products reserve a multiple.
fn space_needed_mb(refusal: &str) -> Option<u32> {
    megabytes(refusal, ["of", "address", "space"])
}

#[test]
fn little_memory_is_said_and_ends_nothing_by_force() {
    let refusal = no_panic(&within(200_000, TINY));
    let needed = space_needed_mb(&refusal).unwrap_or_else(|| panic!("{refusal}"));
    for percent in [45, 70, 95, 140, 300, 1000] {
        let done = within(10 * percent * needed, TINY);
        let said = no_panic(&done);
        // a little is refused with a reason, enough of it suffices
        assert!(done.status.success() || said.contains("memory"), "{percent} % of {needed} MB: {said}");
        assert!(done.status.success() || percent < 140, "{percent} % of {needed} MB: {said}");
    }
}

/// A study whose evaluation multiplies matrices, on one thread: what the refusal names suffices, with what the program itself takes.
#[test]
fn the_memory_that_a_refusal_names_suffices() {
    let yellow = include_str!("../../examples/yellow.toml");
    let refusal = no_panic(&within(300_000, yellow));
    let needed = space_needed_mb(&refusal).unwrap_or_else(|| panic!("{refusal}"));
    let left = megabytes(&refusal, ["of", "memory", "left"]).unwrap_or_else(|| panic!("{refusal}"));
    // what the program has taken before its check depends on how it was built; ulimit counts in 1024 bytes
    let program = 308 - left;
    let done = within(1000 * (needed + program), yellow);
    assert!(done.status.success(), "{needed} MB: {}", no_panic(&done));
}

#[test]
fn a_missing_folder_for_temporary_files_is_not_missed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let done =
        command(&study(folder.path(), TINY), &out, &[]).env("TMPDIR", "/no/such/folder").output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(out.join("picture.png").exists());
}

#[test]
fn titles_do_not_open_elements_in_the_data_of_pages() {
    let export =
        |to: &str| inkwave().arg("export").arg(finished().join("out")).args(["--to", to]).output().unwrap();
    assert!(export("viewer").status.success());
    let page = std::fs::read_to_string(finished().join("out/export/packing.html")).unwrap();
    assert!(
        page.contains(r"\u003c!--\u003cscript>") && !page.contains("<!--<script"),
        "the title's words are escaped"
    );
    let sweep = finished().join("sweep.toml");
    let axis = "base = \"study.toml\"\n[[axis]]\nfield = \"paper.albedo\"\nvalues = [0.5, 0.9]\n";
    std::fs::write(&sweep, format!("title = \"<!--<script>\"\n{axis}")).unwrap();
    let done = inkwave().arg("sweep").arg(&sweep).arg("-o").arg(finished().join("swept")).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let page = std::fs::read_to_string(finished().join("swept/explore.html")).unwrap();
    assert!(
        page.contains(r"\u003c!--\u003cscript>") && !page.contains("<!--<script"),
        "the title's words are escaped"
    );
}

#[test]
fn a_step_alone_is_one_of_the_visible_range() {
    let folder = tempfile::tempdir().unwrap();
    let text = TINY.replace("from_nm = 400\nto_nm = 700\n", "");
    let out = folder.path().join("out");
    succeed(&study(folder.path(), &text), &out, &[]);
    let spectra = std::fs::read_to_string(out.join("spectra.csv")).unwrap();
    for nm in ["400", "500", "600", "700"] {
        assert!(spectra.lines().any(|line| line.starts_with(nm)), "{nm}");
    }
}
