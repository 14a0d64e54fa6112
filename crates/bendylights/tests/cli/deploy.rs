//! Tests of the systemd units: systemd accepts them, and the program accepts their commands.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::program::{Folder, TRIANGLE, binary, run};

/// Name and text of each unit.
const UNITS: [(&str, &str); 2] = [
    ("bendylights-render@.service", include_str!("../../../../deploy/bendylights-render@.service")),
    ("bendylights.service", include_str!("../../../../deploy/bendylights.service")),
];
const INSTALLED: &str = "/usr/local/bin/bendylights";

/// Returns the output of `systemd-analyze verify` for the unit; empty if it is valid.
fn complaints(name: &str, unit: &str) -> String {
    let folder = Folder::new();
    // systemd checks that the program exists, so the unit gets the path of the build.
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

/// Returns the value of `key` in a unit, with `folder` as its state and cache, and `room` as its instance.
fn setting(unit: &str, key: &str, folder: &str) -> String {
    let value = unit.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_else(|| panic!("no {key}"));
    value.replace("%S", folder).replace("%C", &format!("{folder}/cache")).replace("%i", "room")
}

/// Returns the arguments of the unit's command.
fn command(unit: &str, folder: &str) -> Vec<String> {
    let command = setting(unit, "ExecStart=", folder);
    let mut words = command.split(' ').map(str::to_owned);
    assert_eq!(words.next().as_deref(), Some(INSTALLED));
    words.collect()
}

#[test]
fn the_program_accepts_the_units_commands() {
    let folder = Folder::new();
    let state = folder.path("").trim_end_matches('/').to_owned();
    let run_unit = |unit: &str, more: &[&str]| {
        let words = command(unit, &state);
        run(&words.iter().map(String::as_str).chain(more.iter().copied()).collect::<Vec<_>>())
    };
    // There is no scene, so the program must get as far as looking for it.
    fs::create_dir(folder.path("bendylights-render")).expect("a folder");
    let done = run_unit(UNITS[0].1, &[]);
    assert_eq!(done.code, 2);
    assert!(done.stderr.starts_with(&format!("error: {state}/bendylights-render/room.glb: ")), "{}", done.stderr);
    // The server would run forever. A missing scene stops it after it has accepted its command line.
    let done = run_unit(UNITS[1].1, &["--scene", "nowhere.glb"]);
    assert_eq!(done.code, 2, "{}", done.stderr);
    assert!(done.stderr.contains("nowhere.glb"), "{}", done.stderr);
}

/// systemd gives a unit's folder to the unit's user. Two units with one folder would take it from each other.
#[test]
fn each_unit_has_folders_of_its_own() {
    for key in ["StateDirectory=", "CacheDirectory="] {
        let [render, serve] = UNITS.map(|(_, unit)| setting(unit, key, ""));
        assert_ne!(render, serve, "{key}");
        for (name, unit) in UNITS {
            let folder = setting(unit, key, "");
            let place = if key == "StateDirectory=" { "%S" } else { "%C" };
            assert!(unit.contains(&format!("{place}/{folder}")), "{name} uses its {key}");
        }
    }
}

/// A service has no HOME, in which the driver would cache shaders by default.
#[test]
fn the_units_keep_compiled_shaders() {
    let folder = Folder::new();
    let root = folder.path("").trim_end_matches('/').to_owned();
    fs::create_dir(folder.path("bendylights-render")).expect("a folder");
    folder.file("bendylights-render/room.glb", TRIANGLE);
    let (_, unit) = UNITS[0];
    let small = |word: String| match word.as_str() {
        "1920x1080" => "64x36".into(),
        "64" => "1".into(),
        _ => word,
    };
    // Without a GPU the program would compile no shaders by itself.
    let wgpu = ["--backend", "wgpu"].map(String::from);
    let words = command(unit, &root).into_iter().map(small).chain(wgpu);
    let environment = setting(unit, "Environment=", &root);
    let (name, cache) = environment.split_once('=').expect("a setting");
    let mut render = Command::new(binary());
    render.args(words).env_clear().env(name, cache);
    assert!(render.output().expect("it runs").status.success());
    assert!(fs::exists(folder.path("bendylights-render/room.png")).expect("a folder"), "a picture");
    let files = walk(Path::new(cache));
    assert!(files > 0, "{cache} holds shaders");
    for (_, unit) in UNITS {
        assert!(setting(unit, "Environment=", "").starts_with("MESA_SHADER_CACHE_DIR="));
    }
}

/// Counts the files under a folder.
fn walk(folder: &Path) -> usize {
    let Ok(files) = fs::read_dir(folder) else { return 0 };
    files.map(|file| file.expect("a file").path()).map(|path| if path.is_dir() { walk(&path) } else { 1 }).sum()
}
