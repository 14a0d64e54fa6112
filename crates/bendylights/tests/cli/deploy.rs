//! The systemd units: accepted by systemd, and their commands by the program.

use std::process::Command;

use crate::program::{Folder, binary, run};

/// Name and text of each.
const UNITS: [(&str, &str); 2] = [
    ("bendylights-render@.service", include_str!("../../../../deploy/bendylights-render@.service")),
    ("bendylights.service", include_str!("../../../../deploy/bendylights.service")),
];
const INSTALLED: &str = "/usr/local/bin/bendylights";

/// What `systemd-analyze verify` says of the unit, nothing where it is sound.
fn complaints(name: &str, unit: &str) -> String {
    let folder = Folder::new();
    // systemd looks whether the program is there: it is, but where it was built.
    let built = unit.replace(INSTALLED, &binary().display().to_string());
    let file = folder.file(name, built);
    let verify = Command::new("systemd-analyze").args(["verify", "--man=no", &file]).output();
    let output = verify.expect("systemd-analyze: `apt-get install systemd` brings it");
    String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned()
}

#[test]
#[ignore = "needs systemd-analyze"]
fn systemd_accepts_the_units() {
    for (name, unit) in UNITS {
        assert_eq!(complaints(name, unit), "", "{name}");
        let misspelt = unit.replace("ProtectHome", "ProtecHome");
        let caught = complaints(name, &misspelt).contains("ProtecHome");
        assert!(caught, "{name}: a planted fault is caught");
    }
}

/// The words of the unit's command after the program's name, its state in `state`.
fn command(unit: &str, state: &str) -> Vec<String> {
    let command = unit.lines().find_map(|line| line.strip_prefix("ExecStart=")).expect("a command");
    let command = command.replace("%S/bendylights", state.trim_end_matches('/')).replace("%i", "room");
    let mut words = command.split(' ').map(str::to_owned);
    assert_eq!(words.next().as_deref(), Some(INSTALLED));
    words.collect()
}

#[test]
fn the_program_accepts_the_units_commands() {
    let folder = Folder::new();
    let state = folder.path("");
    let run_unit = |unit: &str, more: &[&str]| {
        let words = command(unit, &state);
        run(&words.iter().map(String::as_str).chain(more.iter().copied()).collect::<Vec<_>>())
    };
    // There is no scene, so the program must get as far as looking for it.
    let done = run_unit(UNITS[0].1, &[]);
    assert_eq!(done.code, 2);
    assert!(done.stderr.starts_with(&format!("error: {state}room.glb: ")), "{}", done.stderr);
    // The server would run for ever; a scene that is not there stops it after its command line was taken.
    let done = run_unit(UNITS[1].1, &["--scene", "nowhere.glb"]);
    assert_eq!(done.code, 2, "{}", done.stderr);
    assert!(done.stderr.contains("nowhere.glb"), "{}", done.stderr);
}
