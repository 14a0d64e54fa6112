//! Runs other renderers by their own scripts, for comparison.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Deserialize;

use crate::{BenchError, Quantiles};

/// Script that measures one renderer: `DIR/NAME/bench.py FRAMES`.
const SCRIPT: &str = "bench.py";
/// Number of runs of each script, each in a new process.
pub(crate) const RUNS: usize = 3;
/// Minimum frames of a run, so that its median is meaningful.
pub(crate) const FEWEST_FRAMES: usize = 10;

/// Other renderers to measure beside this one: a benchmark script for each, and the Python interpreter in whose
/// environment the renderers are installed.
#[derive(Clone, Debug)]
pub struct Peers {
    python: PathBuf,
    scripts: Vec<PathBuf>,
}

/// Line that a script prints: the time of frames that are read back. The light moves in each frame.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct PeerTiming {
    pub name: String,
    pub version: String,
    pub ms_median: f64,
}

/// Times of one renderer over all its runs.
#[derive(Clone, Debug)]
pub(crate) struct Peer {
    pub name: String,
    pub version: String,
    /// Milliseconds per frame: quantiles of the medians of the runs. The fastest single frame is not used, because
    /// nothing may have moved in it.
    pub wall_ms: Quantiles,
}

impl Peer {
    /// Groups the lines of all runs by name, in order of first appearance.
    pub(crate) fn all(lines: &[PeerTiming]) -> Vec<Self> {
        let mut peers: Vec<Self> = Vec::new();
        for PeerTiming { name, version, .. } in lines {
            if peers.iter().all(|peer| peer.name != *name) {
                let of_it = lines.iter().filter(|line| line.name == *name);
                let wall_ms = Quantiles::of(of_it.map(|line| line.ms_median));
                peers.push(Self { name: name.clone(), version: version.clone(), wall_ms });
            }
        }
        peers
    }
}

impl Peers {
    /// Finds the scripts in `folder`, one folder each. If `python` is `None`, uses the interpreter of the virtual
    /// environment `.venv` or `venv` in `folder`.
    pub fn find(folder: &Path, python: Option<&Path>) -> Result<Self, BenchError> {
        let mut scripts = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(|_| BenchError::NoPeers(folder.into()))? {
            let script = entry?.path().join(SCRIPT);
            if script.is_file() {
                scripts.push(script);
            }
        }
        // The order of the file system is not deterministic.
        scripts.sort();
        if scripts.is_empty() {
            return Err(BenchError::NoPeers(folder.into()));
        }
        let beside = || [".venv", "venv"].map(|venv| folder.join(venv).join("bin/python"));
        let found = || beside().into_iter().find(|python| python.is_file());
        let python = python.map(Path::to_owned).or_else(found);
        Ok(Self { python: python.ok_or_else(|| BenchError::NoPython(folder.into()))?, scripts })
    }

    /// Returns the number of scripts.
    pub(crate) fn count(&self) -> usize {
        self.scripts.len()
    }

    /// Runs each script once. Calls `begins` before each.
    pub(crate) fn run_all(&self, frames: usize, mut begins: impl FnMut()) -> Result<Vec<PeerTiming>, BenchError> {
        let mut lines = Vec::new();
        for script in &self.scripts {
            begins();
            lines.extend(self.run(script, frames)?);
        }
        Ok(lines)
    }

    /// Runs a script for `frames` frames in a process of its own.
    fn run(&self, script: &Path, frames: usize) -> Result<Vec<PeerTiming>, BenchError> {
        let failed = |reason: String| BenchError::Peer { script: script.into(), python: self.python.clone(), reason };
        // Pictures that a script writes are discarded.
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
        let lines: Vec<PeerTiming> = said.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        if lines.is_empty() {
            return Err(failed("it printed no line of JSON with `name`, `version` and `ms_median`".into()));
        }
        Ok(lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_without_peers_is_refused_with_advice() {
        let folder = tempfile::tempdir().expect("a folder");
        let said = |python| Peers::find(folder.path(), python).map(|_| ()).expect_err("refused").to_string();
        assert!(said(None).contains("bench.py"), "{}", said(None));
        let peer = folder.path().join("peer");
        std::fs::create_dir(&peer).expect("a folder");
        let says = |script: &str| std::fs::write(peer.join("bench.py"), script).expect("written");
        says("echo '{\"name\": \"peer\", \"version\": \"1\", \"ms_median\": 4}'; echo more");
        assert!(said(None).contains("--python"), "{}", said(None));
        let shell = Path::new("/bin/sh");
        let peers = Peers::find(folder.path(), Some(shell)).expect("found");
        let lines = peers.run_all(1, || {}).expect("measured");
        assert_eq!((lines.len(), lines[0].name.as_str(), lines[0].ms_median), (1, "peer", 4.0));
        says("echo broken >&2; exit 1");
        assert!(peers.run_all(1, || {}).expect_err("it failed").to_string().contains("broken"));
        says("echo nothing");
        assert!(peers.run_all(1, || {}).is_err());
    }

    #[test]
    fn a_peer_has_the_least_and_the_middle_of_its_runs() {
        let line = |name: &str, ms_median| PeerTiming { name: name.into(), version: "1".into(), ms_median };
        let lines = [line("b", 9.0), line("a", 2.0), line("b", 7.0), line("a", 5.0), line("b", 8.0)];
        let found: Vec<_> =
            Peer::all(&lines).into_iter().map(|Peer { name, wall_ms, .. }| (name, wall_ms.min, wall_ms.p50)).collect();
        let expected = [("b", 7.0, 8.0), ("a", 2.0, 2.0)];
        let expected = expected.map(|(name, min, median)| (name.to_owned(), min, median));
        assert_eq!(found, expected);
    }
}
