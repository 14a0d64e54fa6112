//! The systemd unit: accepted by systemd, and its command by the program.

use std::process::Command;

use crate::program::{Folder, binary, run};

const UNIT: &str = include_str!("../../../../deploy/bendylights-render@.service");
const INSTALLED: &str = "/usr/local/bin/bendylights";

/// What `systemd-analyze verify` says of the unit, nothing where it is sound; `None` where there is no such
/// program.
fn complaints(unit: &str) -> Option<String> {
    let folder = Folder::new();
    // systemd looks whether the program is there: it is, but where it was built.
    let built = unit.replace(INSTALLED, &binary().display().to_string());
    let file = folder.file("bendylights-render@.service", built);
    let verify = Command::new("systemd-analyze").args(["verify", "--man=no", &file]).output();
    let must_run = std::env::var("CI").is_ok_and(|ci| ci == "true");
    let output = if must_run { verify.expect("systemd-analyze, which CI installs") } else { verify.ok()? };
    Some(String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
}

#[test]
fn systemd_accepts_the_unit() {
    let Some(said) = complaints(UNIT) else {
        println!("skipped: no systemd-analyze here; `apt-get install systemd` brings it");
        return;
    };
    assert_eq!(said, "");
    let misspelt = UNIT.replace("ProtectHome", "ProtecHome");
    assert!(
        complaints(&misspelt).is_some_and(|said| said.contains("ProtecHome")),
        "a planted fault is caught"
    );
}

#[test]
fn the_program_accepts_the_units_command() {
    let command = UNIT.lines().find_map(|line| line.strip_prefix("ExecStart=")).expect("a command");
    let folder = Folder::new();
    let state = folder.path("");
    let command = command.replace("%S/bendylights/", &state).replace("%i", "room");
    let mut words = command.split(' ');
    assert_eq!(words.next(), Some(INSTALLED));
    // There is no scene, so the program must get as far as looking for it.
    let done = run(&words.collect::<Vec<_>>());
    assert_eq!(done.code, 2);
    assert!(done.stderr.starts_with(&format!("error: {state}room.glb: ")), "{}", done.stderr);
}
