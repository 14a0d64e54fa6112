//! Runs the commands of README and docs, follows their links, and plays a newcomer's first hour.

use std::path::Path;
use std::process::{Command, Output};

use bench::ServerProcess;
use image::RgbImage;

use crate::program::program;

/// Blocks of indented lines in `text`.
fn blocks(text: &str) -> Vec<String> {
    let mut blocks: Vec<String> = Vec::new();
    let mut is_open = false;
    for line in text.lines() {
        match line.strip_prefix("    ") {
            Some(command) if is_open => {
                let block = blocks.last_mut().expect("an open block");
                *block = [&**block, command].join("\n");
            }
            Some(command) => blocks.push(command.to_owned()),
            None if line.is_empty() && is_open => continue,
            None => {}
        }
        is_open = line.starts_with("    ");
    }
    blocks
}

/// Part of `text` under the heading `title`.
fn section<'a>(text: &'a str, title: &str) -> &'a str {
    let section = text.split_once(&format!("\n## {title}\n")).expect("the section").1;
    section.split("\n## ").next().unwrap_or_default()
}

fn commands(text: &str, title: &str) -> String {
    blocks(section(text, title)).join("\n")
}

/// A server on a folder of its own, and scripts that run beside it. The docs assume the server's default port, this
/// server uses a free one.
struct Beside {
    folder: tempfile::TempDir,
    server: ServerProcess,
}

impl Beside {
    fn start() -> Self {
        Self::with("bendylights-data", &[])
    }

    fn with(data: &str, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let server = ServerProcess::start(program(), &folder.path().join(data), arguments).expect("started");
        server.wait_until_ready().expect("ready");
        Self { folder, server }
    }

    fn run(&self, script: &str) -> Output {
        let here = script.replace("127.0.0.1:8080", &self.server.address.host);
        let mut bash = Command::new("bash");
        let tools = program().parent().expect("a folder");
        let path = format!("{}:{}", tools.display(), std::env::var("PATH").unwrap_or_default());
        bash.args(["-euo", "pipefail", "-c", &here]).current_dir(self.folder.path()).env("PATH", path);
        bash.output().expect("bash runs")
    }

    /// Runs a script that must succeed, and returns its output.
    fn ends_well(&self, script: &str) -> String {
        let done = self.run(script);
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{script}\n{said}");
        String::from_utf8_lossy(&done.stdout).into_owned()
    }

    fn colors(&self, name: &str) -> RgbImage {
        image::open(self.folder.path().join(name)).expect("a picture").to_rgb8()
    }
}

/// Script of a page's commands in their order, with smaller pictures. `serve` is left out, since it does not end.
fn script_of(page: &str) -> String {
    let commands = blocks(page).join("\n");
    let lines = commands.lines().filter(|line| !line.starts_with("bendylights serve "));
    let script = lines.collect::<Vec<_>>().join("\n");
    script.replace("--size 1920x1080 --samples 64", "--size 96x54").replace("--samples 16", "")
}

/// The commands of `docs/command-line.md`, from the first to the last, on the files that `example` writes.
#[test]
fn the_commands_of_the_command_line_page_run() {
    let beside = Beside::start();
    beside.ends_well("bendylights example .");
    let script = script_of(include_str!("../docs/command-line.md"));
    beside.ends_well(&script);
    for file in ["vases.png", "room.exr", "shadow.png", "bent.json", "dragged.json", "main.png", "main.zip"] {
        assert!(beside.folder.path().join(file).is_file(), "{file}");
    }
    let dragged = std::fs::read_to_string(beside.folder.path().join("dragged.json")).expect("an answer");
    assert!(dragged.contains("\"landed\""), "{dragged}");
    // The planted fault is in one option of the first command that writes a picture; it alone makes the script fail.
    let broken = script.replace("-o vases.png", "--nowhere -o vases.png");
    let refused = beside.run(&broken);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success() && said.contains("--nowhere"), "{said}");
}

/// The tour of the README, beside a server that is started as `make demo` does.
#[test]
fn the_tour_of_the_readme_runs() {
    let beside = Beside::with("demo-data", &[]);
    beside.ends_well(&script_of(section(include_str!("../README.md"), "Tour")));
    assert!(
        beside.folder.path().join("shot.png").is_file() && beside.folder.path().join("room.exr").is_file()
    );
}

/// Targets of links in `text`, without those to other sites.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split([')', ' ']).next());
    targets.filter(|target| !target.contains("://") && !target.starts_with('#'))
}

/// Links of a page in `folder` that lead to no file, and paths to code in backticks that name none.
fn dead(folder: &Path, text: &str) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository");
    let is_there = |target: &str| folder.join(target.split('#').next().unwrap_or_default()).exists();
    let mut dead: Vec<String> = links(text).filter(|link| !is_there(link)).map(str::to_owned).collect();
    let spans = text.split('`').skip(1).step_by(2);
    let paths = spans.filter(|span| {
        span.contains('/')
            && !span.contains(['*', ' ', '{', '$'])
            && [".rs", ".ts", ".tsx", ".wgsl", ".mjs"].iter().any(|end| span.ends_with(end))
    });
    let is_file = |path: &&str| root.join(path).is_file() || root.join("crates").join(path).is_file();
    dead.extend(paths.filter(|path| !is_file(path)).map(str::to_owned));
    dead
}

#[test]
fn links_and_paths_lead_to_files() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the repository");
    let mut count = 0;
    for folder in ["", "docs", "docs/decisions", "protocol"] {
        let folder = root.join(folder);
        for entry in std::fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.extension().is_none_or(|extension| extension != "md") {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("text");
            assert_eq!(dead(&folder, &text), [""; 0], "{}", path.display());
            count += links(&text).count();
        }
    }
    assert!(count > 60, "{count} links");
    let planted = "[a](docs/nowhere.md) [b](README.md#start) `stream/src/pace.rs` or `stream/src/haste.rs`";
    assert_eq!(dead(root, planted), ["docs/nowhere.md", "stream/src/haste.rs"]);
}

/// The script adds, bends and drags each light once, logs nothing else, and writes the requested files.
///
/// Rules: HTTP-4, HTTP-6, HTTP-29, HTTP-30, REC-8
#[test]
#[ignore = "needs jq: make test-packages"]
fn ten_lines_light_a_shot() {
    let script = commands(include_str!("../docs/http.md"), "A shot in ten lines");
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
    let actions = ["loadScene", "addLight", "bendLight", "dragFeature"];
    assert!(
        log.lines().count() == 4
            && actions.iter().all(|action| log.contains(&format!(r#""command":{{"type":"{action}""#)))
    );
    let refused = beside.run(&script.replace("shot-020", "shot-021").replace("bendLight", "straightenLight"));
    assert!(!refused.status.success(), "a planted fault is caught");
}

/// Lights of a file go into a session and out of it as a file that renders.
///
/// Rules: HTTP-4, HTTP-6
#[test]
#[ignore = "needs jq: make test-packages"]
fn lights_go_in_and_out_of_a_session() {
    let page = include_str!("../docs/http.md");
    let beside = Beside::start();
    let script = [commands(page, "Over HTTP"), commands(page, "Lights in and out")].join("\n");
    beside.ends_well(&["bendylights example .", &*script].join("\n"));
    let answers = std::fs::read_to_string(beside.folder.path().join("session-lights.json")).expect("a file");
    let lights: serde_json::Value = serde_json::from_str(&answers).expect("JSON");
    assert_eq!(lights.as_array().map(Vec::len), Some(2), "{answers}");
    beside.ends_well("bendylights render demo:vases --lights session-lights.json --size 32x18 -o both.png");
}

/// Rules: HTTP-4, HTTP-6, HTTP-8
#[test]
fn curl_alone_makes_a_session_bends_a_light_and_fetches_a_picture() {
    let script = commands(include_str!("../docs/http.md"), "Over HTTP");
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

/// Runs a script of `tests/hours`, which must succeed.
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
fn a_first_hour_by_the_docs() {
    hour("stranger.sh", &["dev".as_ref()]);
}

#[test]
#[ignore = "needs the tools for OpenAPI: make openapi-tools"]
fn a_pipeline_engineers_first_hour() {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/openapi-tools/bin/python3");
    hour("engineer.sh", &[program().as_os_str(), python.as_os_str()]);
}

/// The example lights a shot and says what the server refuses.
///
/// Rules: HTTP-4, HTTP-6
#[test]
#[ignore = "needs Python"]
fn a_scene_is_lit_over_http_by_the_example() {
    let beside = Beside::start();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../protocol/examples/light_a_scene.py");
    let run = || {
        let mut python = Command::new("python3");
        let host = &beside.server.address.host;
        let [token, out] = ["bendylights-data/token", "out.png"].map(|name| beside.folder.path().join(name));
        python.arg(&script).arg(format!("http://{host}")).args([token, out]);
        python.output().expect("Python runs")
    };
    let done = run();
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success() && said.contains("\"drag\": \"landed\""), "{said}");
    assert_eq!(beside.colors("out.png").dimensions(), (640, 360));
    // The session is there already.
    let again = run();
    let said = String::from_utf8_lossy(&again.stderr);
    assert!(!again.status.success() && said.contains("shot-030"), "{said}");
}

/// Rules: REC-1, LOG-1, LOG-4
#[test]
#[ignore = "needs Python"]
fn a_log_is_a_test_case_in_the_example() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../protocol/examples/test_shot.py");
    let done = Command::new("python3").arg("-B").arg(script).output().expect("Python runs");
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success() && said.contains("Ran 3 tests"), "{said}");
}

/// The example of `light` prints where points lie in a light before and after it is bent.
#[test]
fn the_light_model_is_a_library_in_the_example() {
    let example = program().parent().expect("a folder").join("examples/bend");
    let done = Command::new(example).output().expect("`cargo test` has built it");
    let said = String::from_utf8_lossy(&done.stdout);
    let lines: Vec<&str> = said.lines().collect();
    assert!(done.status.success() && lines.len() == 6, "{said}");
    assert!(lines[..3] != lines[3..], "a light that is bent lies elsewhere: {said}");
}

const TABLE: [&str; 2] = ["<!-- parameters: generated -->\n", "<!-- /parameters -->"];

/// The parameters of lights and control points as a table in Markdown, from what the program lists.
fn parameter_table() -> String {
    let listed = |more: &[&str]| {
        let done = Command::new(program()).arg("parameters").args(more).output().expect("the program runs");
        String::from_utf8(done.stdout).expect("UTF-8")
    };
    let plain = listed(&[]);
    let mut lines = plain.lines().map(|line| line.chars().collect::<Vec<_>>());
    let head: String = lines.next().expect("a head").into_iter().collect();
    let starts =
        ["of", "name", "values", "default", "touches"].map(|column| head.find(column).expect("a column"));
    let json: serde_json::Value = serde_json::from_str(&listed(&["--json"])).expect("JSON");
    let mut table = String::from("| field | of | values | default | meaning |\n|---|---|---|---|---|\n");
    for (line, row) in lines.zip(json["parameters"].as_array().expect("rows")) {
        let cell = |index: usize| {
            let end = starts.get(index + 1).map_or(line.len(), |end| *end.min(&line.len()));
            let text: String = line.get(starts[index]..end).unwrap_or_default().iter().collect();
            text.trim().replace('|', "\\|")
        };
        if cell(0) == "camera" {
            continue;
        }
        let [path, doc] = ["path", "doc"].map(|field| row[field].as_str().expect("text"));
        let field = path.replace('/', ".");
        let cells = [format!("`{field}`"), cell(0), cell(2), format!("`{}`", cell(3)), doc.into()];
        table += &["| ", &cells.join(" | "), " |\n"].concat();
    }
    table
}

/// docs/light-files.md has the parameters of the program; `BENDYLIGHTS_BLESS=1` writes them anew.
#[test]
fn light_files_have_the_parameters_of_the_program() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/light-files.md");
    let page = std::fs::read_to_string(&path).expect("the page");
    let (before, rest) = page.split_once(TABLE[0]).expect("where the table begins");
    let (committed, after) = rest.split_once(TABLE[1]).expect("where it ends");
    let table = format!("\n{}\n", parameter_table());
    if std::env::var_os("BENDYLIGHTS_BLESS").is_some() {
        std::fs::write(&path, [before, TABLE[0], &table, TABLE[1], after].concat()).expect("written");
    } else {
        assert!(committed == table, "the table is not the program's: run this test with BENDYLIGHTS_BLESS=1");
    }
    assert!(table.contains("`coneAngle`") && table.lines().count() > 40, "{table}");
}
