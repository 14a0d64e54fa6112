//! The README's commands do what it says, and a newcomer's first hour leads somewhere.

#[path = "program.rs"]
mod program;

use std::path::Path;
use std::process::{Command, Output};

use bench::ServerProcess;
use image::RgbImage;

use crate::program::program;

/// The indented lines under the heading `title`.
fn commands(readme: &str, title: &str) -> String {
    let section = readme.split_once(&format!("\n## {title}\n")).expect("the section").1;
    let section = section.split("\n## ").next().unwrap_or_default();
    let lines = section.lines().filter_map(|line| line.strip_prefix("    "));
    lines.collect::<Vec<_>>().join("\n")
}

/// A server on a folder of its own, and how a script runs beside it: the README's server listens on its default port, this one on a
/// free one.
struct Beside {
    folder: tempfile::TempDir,
    server: ServerProcess,
}

impl Beside {
    fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let server = ServerProcess::start(program(), &folder.path().join("bendylights-data"), &[]);
        let server = server.expect("started");
        server.wait_until_ready().expect("ready");
        Self { folder, server }
    }

    fn run(&self, script: &str) -> Output {
        let here = script.replace("127.0.0.1:8080", &self.server.address.host);
        assert_ne!(script, here, "the README names the address");
        let mut bash = Command::new("bash");
        let tools = program().parent().expect("a folder");
        let path = format!("{}:{}", tools.display(), std::env::var("PATH").unwrap_or_default());
        bash.args(["-euo", "pipefail", "-c", &here]).current_dir(self.folder.path()).env("PATH", path);
        bash.output().expect("bash runs")
    }

    fn colors(&self, name: &str) -> RgbImage {
        image::open(self.folder.path().join(name)).expect("a picture").to_rgb8()
    }
}

/// Each light is added, bent and dragged once, and nothing else is in the log; what was asked for is there.
///
/// Rules: HTTP-4, HTTP-6, HTTP-29, HTTP-30, REC-8
#[test]
#[ignore = "needs jq: make test-packages"]
fn ten_lines_light_a_shot() {
    let script = commands(include_str!("../README.md"), "A shot in ten lines");
    let beside = Beside::start();
    let done = beside.run(&script);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success() && said.is_empty(), "{said}");
    let brightness = |ev: &str| {
        let picture = beside.colors(&format!("wedge{ev}.png"));
        picture.pixels().map(|pixel| u64::from(pixel.0[1])).sum::<u64>()
    };
    let wedge = ["-2", "-1", "0", "1", "2"].map(brightness);
    assert!(wedge.is_sorted_by(|a, b| a < b), "{wedge:?}");
    let exr = std::fs::read(beside.folder.path().join("shot.exr")).expect("an EXR");
    let has =
        |name: &str| exr.windows(name.len() + 1).any(|bytes| bytes == [name.as_bytes(), b"\0"].concat());
    for channel in ["R", "Z", "N.X", "P.X", "rim.visibility", "key.visibility"] {
        assert!(has(channel), "no channel {channel}");
    }
    assert!(!has("rim.shine"), "a channel that is in no file");
    let log = beside.server.get("/sessions/shot-020/log").expect("answered").text();
    let deeds = ["loadScene", "addLight", "bendLight", "dragFeature"];
    assert!(
        log.lines().count() == 4
            && deeds.iter().all(|deed| log.contains(&format!(r#""command":{{"type":"{deed}""#)))
    );
    let refused = beside.run(&script.replace("shot-020", "shot-021").replace("bendLight", "straightenLight"));
    assert!(!refused.status.success(), "a planted fault is caught");
}

/// Rules: HTTP-4, HTTP-6, HTTP-8
#[test]
fn curl_alone_makes_a_session_bends_a_light_and_fetches_a_picture() {
    let readme = include_str!("../README.md");
    let script = commands(readme, "Over HTTP");
    assert!(script.matches("curl").count() >= 4, "{script}");
    let beside = Beside::start();
    let done = beside.run(&script);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{said}");
    let (before, after) = (beside.colors("before.png"), beside.colors("bent.png"));
    assert_eq!(before.dimensions(), after.dimensions());
    let changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a.0[0].abs_diff(b.0[0]) > 16).count();
    assert!(changed > 1_000, "the light has bent: {changed} pixels differ");
    assert!(beside.folder.path().join("shot-010.jsonl").is_file(), "the log is exported");

    let broken = beside.run(&script.replace("/edits", "/edit"));
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
