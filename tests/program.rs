//! Path of the program that the tests of this package run, built in the same profile.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Builds the program once, and returns its path. It is built together with all tests: alone, its crates would be
/// compiled again without the features that only tests enable.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let tests = std::env::current_exe().expect("the path of this test");
        let profile_dir = tests.ancestors().nth(2).expect("a folder of the profile");
        let target_dir = profile_dir.parent().expect("the target folder");
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut build = Command::new(cargo);
        build
            .args(["build", "--workspace", "--bins", "--tests", "--quiet", "--locked", "--target-dir"])
            .arg(target_dir);
        if !cfg!(debug_assertions) {
            build.arg("--release");
        }
        let status = build.current_dir(env!("CARGO_MANIFEST_DIR")).status().expect("cargo runs");
        assert!(status.success(), "the program builds");
        profile_dir.join("bendylights")
    })
}
