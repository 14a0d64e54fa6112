//! Runs the real binary in temporary folders.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// BendyLight of one segment, straight down -Z, whose radius grows from 0.1.
pub const BENDY: &str =
    r#"{"type": "bendy", "name": "key", "points": [[0,0,0],[0,0,-1],[0,0,-2]], "radii": [0.1,0.4,0.8]}"#;

/// Spotlight with a range.
pub const SPOT: &str = r#"{"type": "spot", "name": "lamp", "coneAngle": 20, "range": 6}"#;

/// glTF file with one triangle, 2 units wide, in the plane z = 0, and one camera called `front` 4 units before
/// it.
pub const TRIANGLE: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "nodes": [{"mesh": 0}, {"name": "front", "camera": 0, "translation": [0, 0, 4]}],
    "cameras": [{"name": "front", "type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
        "min": [-1, -1, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36,
        "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]}"#;

/// Result of a run.
pub struct Done {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

/// Temporary folder of one test.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(TempDir::new().expect("a temporary folder"))
    }

    /// Returns the path of a file in the folder, which need not exist.
    pub fn path(&self, name: &str) -> String {
        self.0.path().join(name).display().to_string()
    }

    /// Writes a file and returns its path.
    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        std::fs::write(self.path(name), content).expect("a file");
        self.path(name)
    }

    /// Returns the names of the files in the folder, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("a folder");
        let mut names: Vec<_> = entries.map(|e| e.expect("an entry").file_name().display().to_string()).collect();
        names.sort();
        names
    }
}

/// Runs `bendylights` with nothing on standard input.
pub fn run(args: &[&str]) -> Done {
    run_with_input(args, "")
}

/// Runs `bendylights` with `input` on standard input.
pub fn run_with_input(args: &[&str], input: &str) -> Done {
    let mut child = Command::new(binary())
        .args(args)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    // A program that refuses its arguments does not read its input.
    let _ = child.stdin.take().expect("a pipe").write_all(input.as_bytes());
    let output = child.wait_with_output().expect("the binary ends");
    Done {
        code: output.status.code().expect("an exit code: no signal, no panic"),
        stdout: String::from_utf8(output.stdout).expect("UTF-8"),
        stderr: without_advice(&String::from_utf8(output.stderr).expect("UTF-8")),
    }
}

/// Runs a command, which must succeed without output on standard error. Returns its answer.
pub fn printed(args: &[&str]) -> String {
    printed_for(args, "")
}

/// Runs a command as [`printed`] does, with `input` on standard input.
pub fn printed_for(args: &[&str], input: &str) -> String {
    let done = run_with_input(args, input);
    assert_eq!((done.code, done.stderr.as_str()), (0, ""), "{args:?}");
    done.stdout
}

/// Runs a command as [`printed`] does. Returns its JSON.
pub fn json_of(args: &[&str]) -> Value {
    json_for(args, "")
}

/// Runs a command as [`printed_for`] does. Returns its JSON.
pub fn json_for(args: &[&str], input: &str) -> Value {
    serde_json::from_str(&printed_for(args, input)).expect("JSON")
}

/// Runs a command that must be refused with one sentence that contains all of `words`. Returns the run.
pub fn refused(args: &[&str], input: &str, words: &[&str]) -> Done {
    let done = run_with_input(args, input);
    assert_eq!(done.code, 2, "{args:?}: {}", done.stderr);
    assert_eq!(done.stderr.lines().count(), 1, "{args:?}: {}", done.stderr);
    assert!(done.stderr.starts_with("error: "), "{}", done.stderr);
    for words in words {
        assert!(done.stderr.contains(words), "{args:?}: `{words}` is missing from: {}", done.stderr);
    }
    done
}

/// Removes the lines that depend on the machine: advice about an old driver, and progress of work that takes
/// longer than a second there.
fn without_advice(said: &str) -> String {
    let is_progress = |line: &str| line.split_once(" %").is_some_and(|(share, _)| share.parse::<u32>().is_ok());
    said.split_inclusive('\n').filter(|line| !line.starts_with("note: Mesa ") && !is_progress(line)).collect()
}

/// Returns the path of the binary under test.
pub fn binary() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_bendylights"))
}
