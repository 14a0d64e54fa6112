//! Determines the commit that the program is built from, for `--version`.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-env-changed=BENDYLIGHTS_COMMIT");
    // Files that change when HEAD moves to another branch, or to another commit on the same one.
    for of_head in [&["rev-parse", "--git-path", "HEAD"][..], &["rev-parse", "--git-path", "logs/HEAD"]] {
        if let Some(file) = git(of_head).filter(|file| Path::new(file).exists()) {
            println!("cargo::rerun-if-changed={file}");
        }
    }
    // Sources without git, for instance in a distribution's package, give the commit by the variable, or not at
    // all.
    let commit = std::env::var("BENDYLIGHTS_COMMIT").ok().or_else(|| git(&["rev-parse", "--short=10", "HEAD"]));
    let version = env!("CARGO_PKG_VERSION");
    let said = commit.map_or_else(|| version.to_owned(), |commit| format!("{version} ({commit})"));
    println!("cargo::rustc-env=BENDYLIGHTS_VERSION={said}");
}

/// Returns the output of git, or `None` without git or without a repository.
fn git(args: &[&str]) -> Option<String> {
    let output = Command::new("git").args(args).output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned())
}
