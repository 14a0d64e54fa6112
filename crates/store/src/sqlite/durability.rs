//! Tests that acknowledged records are on disk. They are in the crate, since they inspect its live connection and break
//! it: a test that cannot fail proves nothing.
//!
//! A child process appends records and prints a line for each once [`Store::append`] has returned. One test kills the
//! child and looks for the records it acknowledged. That cannot tell the disk from the system's memory, which outlives
//! a process. So a second test watches the child's system calls for a sync of the write-ahead log before each
//! acknowledgement. A third makes its syncs fail and looks for the records it refused.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::{env, fs};

use document::{CameraId, CameraParameter};
use edit::{Actor, EditRequest, EditSources, Session};
use scene::{Camera, Projection};
use tempfile::TempDir;

use crate::records::insert_batch;
use crate::{CommitBatch, Store, StoreError};

const CHILD: &str = "sqlite::durability::child_that_appends_and_acknowledges";
const FOLDER: &str = "BENDYLIGHTS_CHILD_FOLDER";
const COUNT: &str = "BENDYLIGHTS_CHILD_COUNT";
const FAULT: &str = "BENDYLIGHTS_CHILD_FAULT";
/// Deliberate fault that the tests must detect: records are acknowledged without a commit.
const NO_COMMIT: &str = "no commit";
/// Deliberate fault that the tests must detect: commits do not wait for the disk.
const NO_SYNC: &str = "no sync";
/// Deliberate fault that the tests must detect: the write-ahead log is left as a failed commit leaves it.
const NO_LOG_CLEANUP: &str = "no settling";

#[test]
#[ignore = "the child of the tests below, which they start"]
fn child_that_appends_and_acknowledges() {
    let folder = env::var(FOLDER).expect("started by a test");
    let count: u64 = env::var(COUNT).expect("a count").parse().expect("a number");
    let fault = env::var(FAULT).unwrap_or_default();
    let mut store = Store::create(Path::new(&folder)).expect("a store");
    if fault == NO_SYNC {
        store.database.connection.execute_batch("PRAGMA synchronous = OFF").expect("a pragma");
    }
    if store.session("main").is_err() {
        store.create_session("main").expect("a session");
    }
    let mut session = store.replay("main", None).expect("a log");
    for _ in 0..count {
        let before = session.clone();
        let record = next_record(&mut session);
        let (seq, hash) = (record.seq, session.document().hash());
        let batch = CommitBatch { session: "main", records: &[record], rejections: &[], hash };
        let outcome = match &*fault {
            NO_COMMIT => Ok(()),
            NO_LOG_CLEANUP => append_without_settling(&mut store, &batch),
            _ => store.append(&[batch]).map(drop),
        };
        let said = match outcome {
            Ok(()) => "ack",
            Err(StoreError::UnknownOutcome(_)) => "unknown",
            Err(_) => "refused",
        };
        writeln!(std::io::stdout(), "{said} {seq}").expect("a reader");
        if said != "ack" {
            // Nobody has seen the record. The next one gets the same number.
            session = before;
        }
    }
    // Exits like a kill: nothing is closed, so nothing moves out of the write-ahead log.
    std::process::exit(0);
}

fn append_without_settling(store: &mut Store, batch: &CommitBatch) -> Result<(), StoreError> {
    let writer = store.database.begin()?;
    insert_batch(&writer, &writer.find(batch.session)?, batch)?;
    Ok(writer.commit()?)
}

/// Adds a camera in record 1 and moves it in each later one.
fn next_record(session: &mut Session) -> edit::Record {
    let next = session.seq() + 1;
    let translation = glam::DVec3::splat(next as f64);
    let command = if next == 1 {
        let projection = Projection::Perspective { yfov: 0.7, aspect_ratio: None, znear: 0.1, zfar: None };
        let rotation = glam::DQuat::IDENTITY;
        document::Command::AddCamera(Camera { name: "eye".into(), translation, rotation, projection })
    } else {
        let parameter = CameraParameter::Translation(translation);
        document::Command::SetCamera { camera: CameraId(1), parameter }
    };
    let actor = Actor { id: "a".into(), name: "Ada".into() };
    let request = EditRequest::Edit { base_seq: None, command };
    let sources = EditSources::default();
    session.execute_request(request, &actor, &next.to_string(), 0, sources).expect("a valid edit")
}

/// Returns the command line of the child, alone or as arguments of `tracer`.
fn child(tracer: &[&str], folder: &Path, count: u64, fault: &str) -> Command {
    let test = env::current_exe().expect("this program").display().to_string();
    let words = tracer.iter().copied().chain([&*test, "--exact", CHILD, "--ignored", "--nocapture"]);
    let words: Vec<&str> = words.collect();
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).env(FOLDER, folder).env(COUNT, count.to_string()).env(FAULT, fault);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    command
}

#[test]
fn a_commit_waits_for_the_disk() {
    let folder = TempDir::new().expect("a folder");
    let store = Store::create(folder.path()).expect("a store");
    let pragma = |name: &str| {
        let query = format!("SELECT CAST({name} AS TEXT) FROM pragma_{name}");
        store.database.connection.query_row(&query, [], |row| row.get::<_, String>(0)).expect("a pragma")
    };
    assert_eq!(pragma("synchronous"), "2", "FULL");
    assert_eq!(pragma("journal_mode"), "wal");
    assert_eq!(pragma("foreign_keys"), "1");
}

/// Starts the child, kills it once it has acknowledged `patience` records, and returns the last acknowledged one.
fn killed_after(patience: usize, folder: &Path, fault: &str) -> u64 {
    let mut child = child(&[], folder, 1_000_000, fault).spawn().expect("the child runs");
    let lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    let acknowledged = lines.filter_map(|line| line.expect("text").strip_prefix("ack ")?.parse::<u64>().ok());
    let mut last = 0;
    for (index, seq) in acknowledged.enumerate() {
        last = seq;
        if index + 1 == patience {
            child.kill().expect("it runs");
        }
    }
    child.wait().expect("it ends");
    last
}

/// Returns the number of acknowledged records that are missing from the store.
fn lost(acknowledged: u64, folder: &Path) -> u64 {
    let store = Store::open(folder).expect("a store");
    let session = store.replay("main", None).expect("a log that replays");
    assert_eq!(session.seq(), store.session("main").expect("a session").seq);
    acknowledged.saturating_sub(session.seq())
}

#[test]
fn a_killed_program_loses_nothing_acknowledged() {
    let folder = TempDir::new().expect("a folder");
    let mut before = 0;
    for patience in [1, 2, 3, 17, 60, 250] {
        let acknowledged = killed_after(patience, folder.path(), "");
        assert!(acknowledged >= before + patience as u64, "it went on from record {before}");
        assert_eq!(lost(acknowledged, folder.path()), 0, "of {acknowledged}");
        before = acknowledged;
    }
    let planted = killed_after(5, folder.path(), NO_COMMIT);
    assert!(lost(planted, folder.path()) >= 5, "a child that commits nothing is caught");
}

/// Lists the system calls of a trace. A call that another thread interrupts is on two lines, which are joined.
fn calls(trace: &str) -> Vec<String> {
    let mut unfinished = std::collections::BTreeMap::new();
    let mut calls = Vec::new();
    for line in trace.lines() {
        let (thread, call) = line.split_once(' ').unwrap_or_default();
        let call = call.trim_start();
        if let Some(start) = call.strip_suffix("<unfinished ...>") {
            unfinished.insert(thread, start);
        } else if let Some((_, end)) = call.split_once("resumed>") {
            calls.push(unfinished.remove(thread).unwrap_or_default().to_owned() + end);
        } else {
            calls.push(call.to_owned());
        }
    }
    calls
}

/// Runs the child under strace. Returns the number of acknowledged records, and the number of those that came before
/// the write-ahead log was written and then synced.
fn traced(fault: &str) -> (usize, usize) {
    let folder = TempDir::new().expect("a folder");
    let trace = folder.path().join("trace").display().to_string();
    let calls_of_interest = "trace=write,pwrite64,writev,pwritev,fsync,fdatasync";
    let tracer = ["strace", "-f", "-y", "-s", "16", "-e", calls_of_interest, "-o", &trace];
    let done = child(&tracer, folder.path(), 20, fault).output().expect("strace runs");
    assert!(done.status.success(), "{done:?}");
    let (mut is_written, mut is_synced, mut acknowledged, mut early) = (false, false, 0, 0);
    for call in calls(&fs::read_to_string(&trace).expect("a trace")) {
        let name = call.split('(').next().unwrap_or_default();
        let is_of_log = call.contains("-wal>");
        match name {
            "fsync" | "fdatasync" if is_of_log && call.ends_with("= 0") => is_synced = is_written,
            "write" | "pwrite64" | "writev" | "pwritev" if is_of_log => {
                (is_written, is_synced) = (true, false);
            }
            "write" if call.contains("\"ack ") => {
                acknowledged += 1;
                early += usize::from(!is_synced);
                (is_written, is_synced) = (false, false);
            }
            _ => {}
        }
    }
    (acknowledged, early)
}

/// Output of a child whose disk failed, and the end of its log afterwards.
struct FaultRun {
    /// Each printed word and its record.
    acknowledgements: Vec<(String, u64)>,
    /// The latest record in the log afterwards.
    found: u64,
}

impl FaultRun {
    /// Runs the child with `faults` in the syntax of strace's `inject`: the system calls that fail, the error and the
    /// count.
    fn run(faults: &[String], fault: &str) -> Self {
        let folder = TempDir::new().expect("a folder");
        // The folder exists before anything fails.
        assert!(child(&[], folder.path(), 1, "").output().expect("the child runs").status.success());
        let mut tracer = vec!["strace", "-f", "-o", "/dev/null", "-e", "trace=fsync,fdatasync,pwrite64"];
        let injected: Vec<String> = faults.iter().map(|fault| format!("inject={fault}")).collect();
        tracer.extend(injected.iter().flat_map(|inject| ["-e", inject.as_str()]));
        let done = child(&tracer, folder.path(), 6, fault).output().expect("strace runs");
        let text = String::from_utf8(done.stdout).expect("text");
        let said = text.lines().filter_map(|line| {
            let (word, seq) = line.split_once(' ')?;
            Some((word.to_owned(), seq.parse().ok()?))
        });
        let acknowledgements = said.filter(|(word, _)| ["ack", "refused", "unknown"].contains(&&**word)).collect();
        let found = Store::open(folder.path()).expect("a store").session("main").expect("a session").seq;
        Self { acknowledgements, found }
    }

    fn count(&self, word: &str) -> usize {
        self.acknowledgements.iter().filter(|(said, _)| said == word).count()
    }

    /// True if the log holds the acknowledged records and no refused one.
    fn matches_log(&self) -> bool {
        let acknowledged = 1 + self.count("ack") as u64;
        // Only the last record can have an unknown outcome, and it would follow the acknowledged ones.
        let may_be_more = self.acknowledgements.last().is_some_and(|(word, _)| word == "unknown");
        self.found == acknowledged || may_be_more && self.found == acknowledged + 1
    }
}

/// Counts of records that were not acknowledged.
struct Outcomes {
    refused: usize,
    unknown: usize,
}

/// Runs the child with each list of faults, and checks that its log holds the acknowledged records and no refused one.
fn checked_outcomes(faults: impl Iterator<Item = Vec<String>>) -> Outcomes {
    let mut outcomes = Outcomes { refused: 0, unknown: 0 };
    for faults in faults {
        let run = FaultRun::run(&faults, "");
        assert!(run.matches_log(), "{faults:?}: {:?}, and {} are found", run.acknowledgements, run.found);
        outcomes.refused += run.count("refused");
        outcomes.unknown += run.count("unknown");
    }
    outcomes
}

fn syncs_fail(when: &str) -> String {
    format!("fsync,fdatasync:error=EIO:when={when}")
}

#[test]
#[ignore = "needs strace"]
fn records_that_a_failing_disk_refused_are_not_in_the_log_after_a_crash() {
    let faults = (1..12).flat_map(|sync| [format!("{sync}"), format!("{sync}+")]).map(|when| vec![syncs_fail(&when)]);
    let Outcomes { refused, unknown } = checked_outcomes(faults);
    assert!(refused > 0 && unknown > 0, "{refused} and {unknown}: both were tried");
    let planted = (1..12).map(|sync| FaultRun::run(&[syncs_fail(&sync.to_string())], NO_LOG_CLEANUP));
    let resurrected = planted.filter(|run| !run.matches_log()).count();
    assert!(resurrected > 0, "a store that does not settle a failed commit is caught");
}

/// First the outcome of a record is unknown. Then the disk is full when it is sent again.
///
/// Rules: SOCK-4
#[test]
#[ignore = "needs strace"]
fn records_refused_when_sent_again_are_not_in_the_log() {
    let faults = (4..24).map(|write| vec![syncs_fail("2+"), format!("pwrite64:error=ENOSPC:when={write}+")]);
    let Outcomes { refused, unknown } = checked_outcomes(faults);
    assert!(refused + unknown > 0, "{refused} and {unknown}");
}

#[test]
#[ignore = "needs strace"]
fn the_log_is_synced_before_each_acknowledgement() {
    assert_eq!(traced(""), (20, 0));
    assert_eq!(traced(NO_SYNC), (20, 20), "commits that do not wait for the disk are caught");
}
