//! Tests of `serve --trace`: a line for each picture.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use ::bench::{Client, Incoming, ServerAddress};
use protocol::{Cause, ClientMessage, FrameQuality, Pass, TraceLine, TraceWhat, ViewSource};

use crate::program::{Folder, binary, run};

const READY_WITHIN: Duration = Duration::from_mins(3);

/// Server whose standard error goes to a file. It is killed when dropped.
struct Served {
    child: Child,
    address: ServerAddress,
    said: String,
}

impl Served {
    fn start(folder: &Folder, trace: &str) -> Self {
        let said = folder.path("said");
        let mut child = Command::new(binary())
            .args(["serve", "--listen", "127.0.0.1:0", "--data", &folder.path("data"), "--trace", trace])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(File::create(&said).expect("a file"))
            .spawn()
            .expect("the binary runs");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut line).expect("a line");
        let served = Self { child, address: line.parse().expect("an address"), said };
        let until = Instant::now() + READY_WITHIN;
        while served.address.get("/readyz").expect("answered").status != 200 {
            assert!(Instant::now() < until, "it is not ready");
            std::thread::sleep(Duration::from_millis(50));
        }
        served
    }

    fn still(&self) {
        self.still_as("png");
    }

    fn still_as(&self, format: &str) {
        let path = format!("/sessions/main/render?size=64x36&format={format}");
        let answer = self.address.get(&path).expect("answered");
        assert_eq!(answer.status, 200, "{}", answer.text());
    }

    /// Returns the lines of standard error about the trace.
    fn said_of_trace(&self) -> Vec<String> {
        let said = std::fs::read_to_string(&self.said).expect("text");
        said.lines().filter(|line| line.contains("trace")).map(str::to_owned).collect()
    }

    /// Stops the server by a signal, and waits until it has ended.
    fn stop(mut self) {
        let kill = Command::new("kill").arg(self.child.id().to_string()).status().expect("kill runs");
        assert!(kill.success());
        assert!(self.child.wait().expect("it ends").success());
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn settled(client: &mut Client) {
    let is_settled =
        |incoming| matches!(incoming, Incoming::Frame(header, _) if header.flags.is_settled).then_some(());
    client.wait_for("a lossless frame", is_settled).expect("a lossless frame");
}

/// Rules: TRACE-1
#[test]
fn every_picture_has_a_line_that_says_what_ran() {
    let folder = Folder::new();
    let trace = folder.path("trace.jsonl");
    let server = Served::start(&folder, &trace);
    let mut client = Client::connect(&server.address, "main", "ada", None).expect("welcome");
    let (source, number) = (ViewSource::Own(client.welcome.camera.clone()), client.welcome.client);
    let (width, height, camera_revision, settings, interaction) = (160, 90, 1, None, None);
    let stats = false;
    let open =
        ClientMessage::OpenView { source, width, height, camera_revision, settings, interaction, stats };
    client.send(&open).expect("sent");
    settled(&mut client);
    let edit = r#"{"edits": [{"command": {"type": "set", "target": "/lights/1/exposure", "value": 0.5}}]}"#;
    let edited = server.address.post("/sessions/main/edits", edit.as_bytes()).expect("answered");
    assert_eq!(edited.status, 200, "{}", edited.text());
    settled(&mut client);
    server.still();
    let mode = std::fs::metadata(&trace).expect("a file").permissions().mode() & 0o777;
    assert_eq!(mode, 0o600, "sessions' names are nobody else's");
    assert_eq!(server.said_of_trace(), [""; 0]);
    server.stop();

    let text = std::fs::read_to_string(&trace).expect("text");
    let lines: Vec<TraceLine> =
        text.lines().map(|line| serde_json::from_str(line).expect("a line")).collect();
    let of = |line: &TraceLine| (line.what, line.quality, line.size);
    let view = TraceWhat::View { client: number };
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
        let done = run(&["serve", "--data", &folder.path("data"), "--trace", &trace]);
        assert_eq!((done.code, done.stdout.as_str()), (2, ""), "{}", done.stderr);
        let says = |words: &str| done.stderr.contains(words);
        assert!(
            done.stderr.starts_with("error: ") && says(&trace) && says("check the folder"),
            "{}",
            done.stderr
        );
        assert_eq!(done.stderr.lines().count(), 1, "{}", done.stderr);
    }
    assert_eq!(folder.names(), [""; 0], "nothing is begun");
}

/// Rules: TRACE-1
#[test]
fn a_disk_that_fails_later_is_told_once_and_stops_nothing() {
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
