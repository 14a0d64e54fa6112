//! Tests of `serve --trace`: a line for each picture.

use std::fs::File;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

use ::bench::{Client, ServerProcess};
use protocol::{Cause, FrameQuality, Pass, TraceLine, TraceWhat};

use crate::program::{Folder, binary, refused};

/// Server whose standard error goes to a file.
struct Served {
    server: ServerProcess,
    said: String,
}

impl Served {
    fn start(folder: &Folder, trace: &str) -> Self {
        let said = folder.path("said");
        let mut command = Command::new(binary());
        command.args(["serve", "--listen", "127.0.0.1:0", "--data", &folder.path("data"), "--trace", trace]);
        command.stderr(File::create(&said).expect("a file"));
        let server = ServerProcess::spawn(&mut command).expect("the binary runs");
        server.wait_until_ready().expect("it is ready");
        Self { server, said }
    }

    fn still(&self) {
        self.still_as("png");
    }

    fn still_as(&self, format: &str) {
        let path = format!("/sessions/main/render?size=64x36&format={format}");
        let answer = self.server.get(&path).expect("answered");
        assert_eq!(answer.status, 200, "{}", answer.text());
    }

    /// Returns the lines of standard error about the trace.
    fn said_of_trace(&self) -> Vec<String> {
        let said = std::fs::read_to_string(&self.said).expect("text");
        said.lines().filter(|line| line.contains("trace")).map(str::to_owned).collect()
    }

    /// Stops the server by a signal, and waits until it has ended.
    fn stop(self) {
        let kill = Command::new("kill").arg(self.server.pid().to_string()).status().expect("kill runs");
        assert!(kill.success());
        assert_eq!(self.server.wait().expect("it ends"), Some(0));
    }
}

/// Rules: TRACE-1
#[test]
fn every_picture_has_a_line_that_says_what_ran() {
    let folder = Folder::new();
    let trace = folder.path("trace.jsonl");
    let server = Served::start(&folder, &trace);
    let mut client = Client::connect(&server.server.address, "main", "ada", None).expect("welcome");
    client.open_view([160, 90], None).expect("sent");
    client.wait_until_settled("a lossless frame").expect("a lossless frame");
    let edit = r#"{"edits": [{"command": {"type": "set", "target": "/lights/1/exposure", "value": 0.5}}]}"#;
    let edited = server.server.post("/sessions/main/edits", edit.as_bytes()).expect("answered");
    assert_eq!(edited.status, 200, "{}", edited.text());
    client.wait_until_settled("a lossless frame").expect("a lossless frame");
    server.still();
    let mode = std::fs::metadata(&trace).expect("a file").permissions().mode() & 0o777;
    assert_eq!(mode, 0o600, "sessions' names are nobody else's");
    assert_eq!(server.said_of_trace(), [""; 0]);
    server.stop();

    let text = std::fs::read_to_string(&trace).expect("text");
    let lines: Vec<TraceLine> = text.lines().map(|line| serde_json::from_str(line).expect("a line")).collect();
    let of = |line: &TraceLine| (line.what, line.quality, line.size);
    let view = TraceWhat::View { client: client.welcome.client };
    let (moving, settled) = (FrameQuality::Moving, FrameQuality::Settled);
    let [first, _, edited, _, still] = &lines[..] else { panic!("{} pictures:\n{text}", lines.len()) };
    let expected = [
        (view, moving, [160, 90]),
        (view, settled, [160, 90]),
        (view, moving, [160, 90]),
        (view, settled, [160, 90]),
        (TraceWhat::Still {}, settled, [64, 36]),
    ];
    assert_eq!(lines.iter().map(of).collect::<Vec<_>>(), expected, "{text}");
    assert!(lines.iter().all(|line| line.session == "main" && line.render_us > 0 && line.left_out == 0));
    assert!(lines.iter().all(|line| line.encode_us.is_some_and(|us| us > 0)), "{text}");
    assert!(lines.iter().map(|line| line.time).is_sorted() && lines[0].time > 0.0, "{text}");
    let map = |line: &TraceLine| line.passes.iter().find(|run| run.pass == Pass::ShadowMap).copied();
    assert_eq!(map(first).map(|run| (run.light, run.cause)), Some((Some(1), Cause::First)));
    assert_eq!(edited.passes.iter().map(|run| run.pass).collect::<Vec<_>>(), [Pass::Display]);
    assert!(still.passes.iter().any(|run| run.pass == Pass::Lighting), "{text}");
}

/// Rules: HTTP-30
#[test]
fn two_files_of_a_picture_are_one_drawing() {
    let folder = Folder::new();
    let trace = folder.path("trace.jsonl");
    let server = Served::start(&folder, &trace);
    // Deliberate fault that the check must detect: four lines, if each file were drawn by itself.
    for format in ["png", "exr", "png,exr"] {
        server.still_as(format);
    }
    server.stop();
    assert_eq!(std::fs::read_to_string(&trace).expect("text").lines().count(), 3);
}

#[test]
fn a_trace_that_cannot_be_written_is_refused_at_the_start() {
    let folder = Folder::new();
    for file in ["missing/trace.jsonl", ""] {
        let trace = folder.path(file);
        let serve = ["serve", "--data", &folder.path("data"), "--trace", &trace];
        assert_eq!(refused(&serve, "", &[&trace, "check the folder"]).stdout, "");
    }
    assert_eq!(folder.names(), [""; 0], "nothing is begun");
}

/// Rules: TRACE-1
#[test]
fn a_disk_that_fails_later_is_reported_once_and_stops_nothing() {
    let folder = Folder::new();
    let server = Served::start(&folder, "/dev/full");
    assert_eq!(server.said_of_trace(), [""; 0]);
    for _ in 0..3 {
        server.still();
    }
    let said = server.said_of_trace();
    assert!(said.len() == 1 && said[0].contains("WARN") && said[0].contains("/dev/full"), "{said:?}");
    server.stop();
}
