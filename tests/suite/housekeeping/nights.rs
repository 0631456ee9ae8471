//! Scripts that run at night, and checks of dependencies, in a home of their own.

use super::root;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A home without rustup and a cargo that only notes how it is called.
struct Home(tempfile::TempDir);

impl Home {
    fn new() -> Home {
        let home = Home(tempfile::tempdir().expect("a folder"));
        std::fs::create_dir(home.path("bin")).expect("a folder");
        let cargo = home.path("bin/cargo");
        std::fs::write(&cargo, "#!/bin/sh\necho \"$@\" >> \"$HOME/calls\"\n").expect("a file");
        let executable = Command::new("chmod").arg("+x").arg(&cargo).status().expect("chmod");
        assert!(executable.success());
        home
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn night(&self, nights: Option<&Path>, arguments: &[&str], bin: &str) -> std::process::Output {
        let mut night = Command::new(root().join("scripts/schedule/night"));
        night.args(arguments).env_clear().env("HOME", self.0.path());
        night.env("PATH", format!("{bin}:/usr/bin:/bin"));
        nights.iter().for_each(|folder| _ = night.env("INKWAVE_NIGHTS", folder));
        night.output().expect("the script starts")
    }

    fn bin(&self) -> String {
        self.path("bin").display().to_string()
    }
}

#[cfg(target_os = "linux")]
#[test]
fn scheduled_nights_write_outside_of_the_clone() {
    let home = Home::new();
    let done = home.night(None, &[], &home.bin());
    assert!(done.status.success(), "{done:?}");
    let calls = std::fs::read_to_string(home.path("calls")).expect("cargo was called");
    let nights = home.path("inkwave-nights").display().to_string();
    assert!(calls.contains(&format!("--out {nights}/latest")), "{calls}");
    assert!(
        calls.contains(&format!("--history {nights}/history.csv")) && !calls.contains("--readme"),
        "{calls}"
    );
    assert!(home.path("inkwave-nights/log").exists() && home.path("inkwave-nights/history.csv").exists());

    let inside = home.night(Some(&root().join("target/nights")), &[], &home.bin());
    let said = String::from_utf8_lossy(&inside.stderr).into_owned();
    assert!(!inside.status.success() && said.contains("outside"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_failed_night_says_so_in_one_line_on_standard_error() {
    use std::os::unix::fs::PermissionsExt;
    let home = Home::new();
    assert!(home.night(None, &[], &home.bin()).stderr.is_empty(), "a good night mails nothing");
    let cargo = home.path("bin/cargo");
    std::fs::write(&cargo, "#!/bin/sh\necho much to say\nexit 3\n").expect("a script");
    std::fs::set_permissions(&cargo, std::fs::Permissions::from_mode(0o755)).expect("made executable");
    for arguments in [&[][..], &["benchmarks"], &["nonsense"]] {
        let done = home.night(None, arguments, &home.bin());
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(!done.status.success() && said.lines().count() == 1, "{arguments:?}: {said}");
        assert!(said.contains("failed with status") && said.contains("log"), "{said}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_schedule_without_cargo_says_so() {
    if Path::new("/usr/bin/cargo").exists() || Path::new("/usr/local/bin/cargo").exists() {
        return;
    }
    let home = Home::new();
    let done = home.night(None, &[], "/nowhere");
    let log = std::fs::read_to_string(home.path("inkwave-nights/log")).expect("a log");
    assert!(done.status.code() == Some(127) && log.contains("cargo is not found"), "{log}");
}

/// The checks of dependencies run where their tools and databases are, and say what they skip. *Planted*: a tool that is there and not
/// called; a failure of one that passes for a skip.
#[cfg(target_os = "linux")]
#[test]
fn checks_of_dependencies_run_or_say_that_they_are_skipped() {
    let home = Home::new();
    let check = |cargo: &str| {
        std::fs::write(
            home.path("bin/cargo"),
            format!("#!/bin/sh\necho \"$@\" >> \"$HOME/calls\"\n{cargo}\n"),
        )
        .expect("a script");
        std::fs::write(home.path("calls"), "").expect("a file");
        let mut check = Command::new(root().join("scripts/check-dependencies"));
        check.env_clear().env("HOME", home.0.path()).env("PATH", format!("{}:/usr/bin:/bin", home.bin()));
        let done = check.output().expect("the script starts");
        let calls = std::fs::read_to_string(home.path("calls")).expect("calls");
        (done.status.success(), String::from_utf8_lossy(&done.stdout).into_owned(), calls)
    };
    let (passed, said, _) = check("exit 101");
    assert!(
        passed && said.contains("cargo deny (not installed)") && said.contains("cargo audit (not installed)")
    );

    let (passed, said, calls) = check("exit 0");
    assert!(passed && said.matches("(no database in").count() == 2, "{said}");
    assert!(calls.contains("check licenses bans sources") && !calls.contains("advisories"), "{calls}");

    for database in ["advisory-dbs", "advisory-db"] {
        std::fs::create_dir_all(home.path(".cargo").join(database)).expect("a folder");
    }
    let (passed, said, calls) = check("exit 0");
    assert!(
        passed && said.is_empty() && calls.contains("advisories") && calls.contains("audit --no-fetch"),
        "{said} {calls}"
    );
    let (passed, said, _) = check("case \"$*\" in *advisories*) exit 1;; esac");
    assert!(!passed, "an advisory is no reason to go on: {said}");
}

/// A report tells of margins and times that have moved, and of no others.
#[test]
fn small_changes_are_none() {
    use inkwave_validation::claim::has_changed;
    assert!(!has_changed(1.1, 1.0, 1.2) && !has_changed(0.9, 1.0, 1.2));
    assert!(has_changed(1.3, 1.0, 1.2) && has_changed(0.7, 1.0, 1.2));
    assert!(!has_changed(f64::NAN, 1.0, 1.2) && !has_changed(f64::INFINITY, 1.0, 1.2));
}
