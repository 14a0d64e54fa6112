//! Other renderers, run by their own scripts.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Deserialize;

use crate::BenchError;

/// What measures one renderer: `DIR/NAME/bench.py FRAMES`.
const SCRIPT: &str = "bench.py";

/// A folder of other renderers and the Python that has them.
#[derive(Clone, Debug)]
pub struct Peers {
    python: PathBuf,
    scripts: Vec<PathBuf>,
}

/// A line that a script prints: frames of which the light moved in each, read back.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Line {
    pub name: String,
    pub version: String,
    pub ms_median: f64,
}

impl Peers {
    /// Those whose scripts lie in `folder`, one folder each. Without `python` it is that of the virtual environment
    /// `.venv` or `venv` beside them.
    pub fn find(folder: &Path, python: Option<&Path>) -> Result<Self, BenchError> {
        let mut scripts = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(|_| BenchError::NoPeers(folder.into()))? {
            let script = entry?.path().join(SCRIPT);
            if script.is_file() {
                scripts.push(script);
            }
        }
        // In an order that does not depend on the file system.
        scripts.sort();
        if scripts.is_empty() {
            return Err(BenchError::NoPeers(folder.into()));
        }
        let beside = || [".venv", "venv"].map(|venv| folder.join(venv).join("bin/python"));
        let found = || beside().into_iter().find(|python| python.is_file());
        let python = python.map(Path::to_owned).or_else(found);
        Ok(Self { python: python.ok_or_else(|| BenchError::NoPython(folder.into()))?, scripts })
    }

    /// How many scripts there are.
    pub(super) fn count(&self) -> usize {
        self.scripts.len()
    }

    /// Has script `index` draw so many frames in a process of its own.
    pub(super) fn run(&self, index: usize, frames: usize) -> Result<Vec<Line>, BenchError> {
        let script = &self.scripts[index];
        let failed =
            |reason: String| BenchError::Peer { script: script.clone(), python: self.python.clone(), reason };
        // Pictures that a script keeps are nobody's.
        let pictures = tempfile::tempdir()?;
        let done = Command::new(&self.python)
            .arg(script)
            .arg(frames.to_string())
            .env("PEERS_OUT", pictures.path())
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .stdin(Stdio::null())
            .output()
            .map_err(|error| failed(error.to_string()))?;
        if !done.status.success() {
            let said = String::from_utf8_lossy(&done.stderr);
            return Err(failed(said.lines().last().unwrap_or("it says nothing").trim().to_owned()));
        }
        let said = String::from_utf8_lossy(&done.stdout);
        let lines: Vec<Line> = said.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        if lines.is_empty() {
            return Err(failed("it printed no line of JSON with `name`, `version` and `ms_median`".into()));
        }
        Ok(lines)
    }
}
