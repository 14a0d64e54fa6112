//! The README's commands do what it says, and a newcomer's first hour leads somewhere.

#[path = "program.rs"]
mod program;

use std::path::Path;
use std::process::Command;

use bench::ServerProcess;

use crate::program::program;

/// The indented lines under the heading `title`.
fn commands(readme: &str, title: &str) -> String {
    let section = readme.split_once(&format!("\n## {title}\n")).expect("the section").1;
    let section = section.split("\n## ").next().unwrap_or_default();
    let lines = section.lines().filter_map(|line| line.strip_prefix("    "));
    lines.collect::<Vec<_>>().join("\n")
}

/// Rules: HTTP-4, HTTP-6, HTTP-8
#[test]
fn curl_alone_makes_a_session_bends_a_light_and_fetches_a_picture() {
    let readme = include_str!("../README.md");
    let script = commands(readme, "Over HTTP");
    assert!(script.matches("curl").count() >= 4, "{script}");
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("bendylights-data");
    let server = ServerProcess::start(program(), &data, &[]).expect("started");
    server.wait_until_ready().expect("ready");

    let run = |script: &str| {
        let mut bash = Command::new("bash");
        let tools = program().parent().expect("a folder");
        let path = format!("{}:{}", tools.display(), std::env::var("PATH").unwrap_or_default());
        bash.args(["-euo", "pipefail", "-c", script]).current_dir(folder.path()).env("PATH", path);
        bash.output().expect("bash runs")
    };
    // The README's server listens on its default port; this one on a free one.
    let here = script.replace("127.0.0.1:8080", &server.address.host);
    assert_ne!(script, here, "the README names the address");
    let done = run(&here);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{said}");
    let colors = |name: &str| image::open(folder.path().join(name)).expect("a picture").to_rgb8();
    let (before, after) = (colors("before.png"), colors("bent.png"));
    assert_eq!(before.dimensions(), after.dimensions());
    let changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a.0[0].abs_diff(b.0[0]) > 16).count();
    assert!(changed > 1_000, "the light has bent: {changed} pixels differ");
    assert!(Path::new(&folder.path().join("shot-010.jsonl")).is_file(), "the log is exported");

    let broken = run(&here.replace("/edits", "/edit"));
    assert!(!broken.status.success(), "a planted fault is caught");
}

/// Runs a script of `tests/hours`, which must come to its end.
fn hour(script: &str, args: &[&std::ffi::OsStr]) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("hours").join(script);
    let profile_dir = program().parent().expect("a folder of the profile");
    let mut bash = Command::new("bash");
    bash.arg(path).args(args).env("CARGO_TARGET_DIR", profile_dir.parent().expect("the target folder"));
    let done = bash.output().expect("bash runs");
    let [said, told] = [&done.stdout, &done.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(done.status.success() && said.ends_with("== done\n"), "{said}\n{told}");
}

#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_strangers_first_hour() {
    hour("stranger.sh", &["dev".as_ref()]);
}

#[test]
#[ignore = "needs the tools for OpenAPI: make openapi-tools"]
fn a_pipeline_engineers_first_hour() {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/openapi-tools/bin/python3");
    hour("engineer.sh", &[program().as_os_str(), python.as_os_str()]);
}
