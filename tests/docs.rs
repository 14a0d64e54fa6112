//! Runs the commands of README and docs, follows their links, and plays a newcomer's first hour.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use bench::ServerProcess;
use image::RgbImage;

use crate::processes::{openapi_tool, output_of, serve};
use crate::program::program;
use crate::sources::repository;

/// Commands of a page: its indented lines.
fn commands(page: &str) -> String {
    page.lines().filter_map(|line| line.strip_prefix("    ")).collect::<Vec<_>>().join("\n")
}

/// Part of `text` under the heading `title`.
fn section<'a>(text: &'a str, title: &str) -> &'a str {
    let section = text.split_once(&format!("\n## {title}\n")).expect("the section").1;
    section.split("\n## ").next().unwrap_or_default()
}

/// A server on a folder of its own, and scripts that run beside it. The docs assume the server's default port, this
/// server uses a free one.
struct Beside {
    folder: tempfile::TempDir,
    server: ServerProcess,
}

impl Beside {
    fn start() -> Self {
        Self::with_data_in("bendylights-data")
    }

    fn with_data_in(data: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let server = serve(&folder.path().join(data), &[]);
        Self { folder, server }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        std::fs::read_to_string(self.file(name)).expect("a file")
    }

    fn run(&self, script: &str) -> Output {
        let here = script.replace("127.0.0.1:8080", &self.server.address.host);
        let mut bash = Command::new("bash");
        let tools = program().parent().expect("a folder");
        let path = format!("{}:{}", tools.display(), std::env::var("PATH").unwrap_or_default());
        bash.args(["-euo", "pipefail", "-c", &here]).current_dir(self.folder.path()).env("PATH", path);
        bash.output().expect("bash runs")
    }

    /// Runs a script that must succeed. Returns its error output.
    fn succeeds(&self, script: &str) -> String {
        let done = self.run(script);
        let errors = errors_of(&done);
        assert!(done.status.success(), "{script}\n{errors}");
        errors
    }

    fn colors(&self, name: &str) -> RgbImage {
        image::open(self.file(name)).expect("a picture").to_rgb8()
    }
}

fn errors_of(done: &Output) -> String {
    String::from_utf8_lossy(&done.stderr).into_owned()
}

/// Command that runs an example of the protocol.
fn example(script: &str) -> Command {
    let mut python = Command::new("python3");
    python.arg("-B").arg(repository().join("protocol/examples").join(script));
    python
}

/// Script of a page's commands in their order, with smaller pictures. `serve` is left out, since it does not end.
fn script_of(page: &str) -> String {
    let commands = commands(page);
    let lines = commands.lines().filter(|line| !line.starts_with("bendylights serve "));
    let script = lines.collect::<Vec<_>>().join("\n");
    script.replace("--size 1920x1080 --samples 64", "--size 96x54").replace("--samples 16", "")
}

/// The commands of `docs/command-line.md`, from the first to the last, on the files that `example` writes.
#[test]
fn the_commands_of_the_command_line_page_run() {
    let beside = Beside::start();
    beside.succeeds("bendylights example .");
    let script = script_of(include_str!("../docs/command-line.md"));
    beside.succeeds(&script);
    for file in ["vases.png", "room.exr", "shadow.png", "bent.json", "dragged.json", "main.png", "main.zip"] {
        assert!(beside.file(file).is_file(), "{file}");
    }
    let dragged = beside.text("dragged.json");
    assert!(dragged.contains("\"landed\""), "{dragged}");
    // The planted fault is in one option of the first command that writes a picture; it alone makes the script fail.
    let again = script.replace("bendylights example example\n", "");
    let broken = again.replace("-o vases.png", "--nowhere -o vases.png");
    let refused = beside.run(&broken);
    let errors = errors_of(&refused);
    assert!(!refused.status.success() && errors.contains("--nowhere"), "{errors}");
}

/// The commands of `docs/figures.md` write the pictures that it shows. One vase is lit from elsewhere and the rest of the scene
/// stays the same to the bit; a shadow moves and nine in ten pixels of the vase that throws it stay within 8 of 255.
#[test]
#[ignore = "needs jq: make test-packages"]
fn the_figures_come_of_their_commands() {
    let beside = Beside::start();
    let script = script_of(include_str!("../docs/figures.md"));
    beside.succeeds(&script);
    let written = |name: &str| beside.colors(&format!("{name}.png"));
    let before = written("before");
    for name in ["before", "relit", "bent", "copied"] {
        let file = repository().join(format!("crates/bendylights/pictures/figure-5-{name}.png"));
        let shown = image::open(file).expect("the page's picture").to_rgb8();
        let others = differing(&written(name), &shown, 32).count();
        assert!(others < OTHER_SAMPLES, "{name}.png differs in {others} pixels from what the page shows");
    }
    // The box of the blue vase in the picture, by `bendylights probe`.
    let is_near_blue_vase = |[x, y]: [u32; 2]| (91..=232).contains(&x) && (57..=273).contains(&y);
    let spoils = |relit: &RgbImage| differing(&before, relit, 0).any(|pixel| !is_near_blue_vase(pixel));
    assert!(!spoils(&written("relit")));
    let is_blue = |[x, y]: [u32; 2]| {
        let [red, _, blue] = before.get_pixel(x, y).0.map(u32::from);
        is_near_blue_vase([x, y]) && 5 * blue > 8 * red + 40
    };
    let of_blue_vase = before.enumerate_pixels().filter(|(x, y, _)| is_blue([*x, *y])).count();
    for name in ["bent", "copied"] {
        let bent = written(name);
        assert!(differing(&before, &bent, 32).count() > OTHER_SAMPLES, "nothing moves in {name}.png");
        let changed = differing(&before, &bent, 8).filter(|pixel| is_blue(*pixel)).count();
        assert!(10 * changed <= of_blue_vase, "{changed} of {of_blue_vase} pixels of the vase change in {name}.png");
    }
    // The planted fault: the light itself is dragged in place of a copy.
    beside.succeeds(&script.replace("linkedCopy", "wholeLight"));
    assert!(spoils(&written("relit")));
}

/// Number of pixels in which a figure may differ from the page's, which is drawn with more samples: those on edges.
const OTHER_SAMPLES: usize = 640 * 360 / 25;

/// Pixels in which two pictures differ by more than `most` of 255.
fn differing(a: &RgbImage, b: &RgbImage, most: u8) -> impl Iterator<Item = [u32; 2]> {
    let differs = move |(a, b): (&u8, &u8)| a.abs_diff(*b) > most;
    let pairs = a.enumerate_pixels().zip(b.pixels());
    pairs.filter(move |((_, _, a), b)| a.0.iter().zip(&b.0).any(differs)).map(|((x, y, _), _)| [x, y])
}

/// The tour of the README, beside a server that is started as `make demo` does.
#[test]
fn the_tour_of_the_readme_runs() {
    let beside = Beside::with_data_in("demo-data");
    beside.succeeds(&script_of(section(include_str!("../README.md"), "Tour")));
    assert!(beside.file("shot.png").is_file() && beside.file("room.exr").is_file());
}

/// Targets of links in `text`, without those to other sites.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split([')', ' ']).next());
    targets.filter(|target| !target.contains("://") && !target.starts_with('#'))
}

/// Links of a page in `folder` that lead to no file, and paths to code in backticks that name none.
fn dead(folder: &Path, text: &str) -> Vec<String> {
    let is_there = |target: &str| folder.join(target.split('#').next().unwrap_or_default()).exists();
    let mut dead: Vec<String> = links(text).filter(|link| !is_there(link)).map(str::to_owned).collect();
    let spans = text.split('`').skip(1).step_by(2);
    let paths = spans.filter(|span| {
        span.contains('/')
            && !span.contains(['*', ' ', '{', '$'])
            && [".rs", ".ts", ".tsx", ".wgsl", ".mjs"].iter().any(|end| span.ends_with(end))
    });
    let is_file = |path: &&str| ["", "crates"].iter().any(|root| repository().join(root).join(path).is_file());
    dead.extend(paths.filter(|path| !is_file(path)).map(str::to_owned));
    dead
}

#[test]
fn links_and_paths_lead_to_files() {
    let mut count = 0;
    for folder in ["", "docs", "docs/decisions", "protocol"] {
        let folder = repository().join(folder);
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
    assert_eq!(dead(repository(), planted), ["docs/nowhere.md", "stream/src/haste.rs"]);
}

/// The script adds, bends and drags each light once, logs nothing else, and writes the requested files.
///
/// Rules: HTTP-4, HTTP-6, HTTP-29, HTTP-30, REC-8
#[test]
#[ignore = "needs jq: make test-packages"]
fn one_script_lights_a_shot() {
    let script = commands(section(include_str!("../docs/http.md"), "A shot in one script"));
    let script = script.replace("size=1280x720", "size=320x180");
    let beside = Beside::start();
    assert_eq!(beside.succeeds(&script), "");
    let brightness = |ev: &str| {
        let picture = beside.colors(&format!("wedge{ev}.png"));
        picture.pixels().map(|pixel| u64::from(pixel.0[1])).sum::<u64>()
    };
    let wedge = ["-2", "-1", "0", "1", "2"].map(brightness);
    assert!(wedge.is_sorted_by(|a, b| a < b), "{wedge:?}");
    let exr = std::fs::read(beside.file("shot.exr")).expect("an EXR");
    let has = |name: &str| exr.windows(name.len() + 1).any(|bytes| bytes == [name.as_bytes(), b"\0"].concat());
    for channel in ["R", "Z", "N.X", "P.X", "rim.visibility", "key.visibility"] {
        assert!(has(channel), "no channel {channel}");
    }
    assert!(!has("rim.shine"), "a channel that is in no file");
    let log = beside.server.get("/sessions/shot-020/log").expect("answered").text();
    let actions = ["loadScene", "addLight", "bendLight", "dragFeature"];
    assert_eq!(log.lines().count(), 4, "{log}");
    assert!(actions.iter().all(|action| log.contains(&format!(r#""command":{{"type":"{action}""#))), "{log}");
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
    let sections = ["Over HTTP", "Lights in and out", "Commands", "Light groups and sequences", "Run a script again"];
    let scripts = sections.map(|title| commands(section(page, title))).join("\n");
    beside.succeeds(&format!("bendylights example .\n{scripts}"));
    let answers = beside.text("session-lights.json");
    let lights: serde_json::Value = serde_json::from_str(&answers).expect("JSON");
    assert_eq!(lights.as_array().map(Vec::len), Some(2), "{answers}");
    beside.succeeds("bendylights render demo:vases --lights session-lights.json --size 32x18 -o both.png");
}

/// Rules: HTTP-4, HTTP-6, HTTP-8
#[test]
fn curl_alone_makes_a_session_bends_a_light_and_fetches_a_picture() {
    let script = commands(section(include_str!("../docs/http.md"), "Over HTTP"));
    assert!(script.matches("curl").count() >= 4, "{script}");
    let beside = Beside::start();
    beside.succeeds(&script);
    let (before, after) = (beside.colors("before.png"), beside.colors("bent.png"));
    assert_eq!(before.dimensions(), after.dimensions());
    let changed = before.pixels().zip(after.pixels()).filter(|(a, b)| a.0[0].abs_diff(b.0[0]) > 16).count();
    assert!(changed > 1_000, "the light has bent: {changed} pixels differ");
    assert!(beside.file("shot-010.jsonl").is_file(), "the log is exported");

    let broken = beside.run(&script.replace("/edits", "/edit"));
    assert!(!broken.status.success(), "a planted fault is caught");
}

/// Runs a script of `tests/hours`, which must succeed.
fn hour(script: &str, args: &[&std::ffi::OsStr]) {
    let target_dir = program().ancestors().nth(2).expect("the target folder");
    let mut bash = Command::new("bash");
    bash.arg(repository().join("tests/hours").join(script)).args(args).env("CARGO_TARGET_DIR", target_dir);
    let done = bash.output().expect("bash runs");
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success() && said.ends_with("== done\n"), "{said}\n{}", errors_of(&done));
}

#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_first_hour_by_the_docs() {
    hour("stranger.sh", &["dev".as_ref()]);
}

#[test]
#[ignore = "needs the tools for OpenAPI: make openapi-tools"]
fn a_pipeline_engineers_first_hour() {
    hour("engineer.sh", &[program().as_os_str(), openapi_tool("python3").as_os_str()]);
}

/// The example lights a shot and says what the server refuses.
///
/// Rules: HTTP-4, HTTP-6
#[test]
#[ignore = "needs Python"]
fn a_scene_is_lit_over_http_by_the_example() {
    let beside = Beside::start();
    let run = || {
        let url = format!("http://{}", beside.server.address.host);
        let files = ["bendylights-data/token", "out.png"].map(|name| beside.file(name));
        example("light_a_scene.py").arg(url).args(files).output().expect("Python runs")
    };
    let done = run();
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success() && said.contains("\"drag\": \"landed\""), "{said}");
    assert_eq!(beside.colors("out.png").dimensions(), (640, 360));
    // The session is there already.
    let again = run();
    let errors = errors_of(&again);
    assert!(!again.status.success() && errors.contains("shot-030"), "{errors}");
}

/// Rules: REC-1, LOG-1, LOG-4
#[test]
#[ignore = "needs Python"]
fn a_log_is_a_test_case_in_the_example() {
    let done = example("test_shot.py").output().expect("Python runs");
    let errors = errors_of(&done);
    assert!(done.status.success() && errors.contains("Ran 3 tests"), "{errors}");
}

/// The example of `light` prints where points lie in a light before and after it is bent.
#[test]
fn the_light_model_is_a_library_in_the_example() {
    // `cargo test` has built it.
    let said = output_of(&mut Command::new(program().with_file_name("examples").join("bend")));
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 6, "{said}");
    assert!(lines[..3] != lines[3..], "a light that is bent lies elsewhere: {said}");
}

const TABLE: [&str; 2] = ["<!-- parameters: generated -->\n", "<!-- /parameters -->"];

/// The parameters of lights and control points as a table in Markdown, from what the program lists.
fn parameter_table() -> String {
    let listed = |more: &[&str]| output_of(Command::new(program()).arg("parameters").args(more));
    let plain = listed(&[]);
    let mut lines = plain.lines().map(|line| line.chars().collect::<Vec<_>>());
    let head: String = lines.next().expect("a head").into_iter().collect();
    let starts = ["of", "name", "values", "default", "touches"].map(|column| head.find(column).expect("a column"));
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
    let path = repository().join("docs/light-files.md");
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
