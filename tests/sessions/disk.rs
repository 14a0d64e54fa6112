//! A disk that fails while the server runs: strace makes its syncs fail.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use protocol::{ClientMessage, ErrorCode, Outcome, Problem};

use crate::sessions::support::{Mirror, Server, committed, rename};

/// Maximum number of edits until the disk fails, or works again.
const TRIES: usize = 200;

/// Makes the disk fail until it is mended.
struct FailingDisk(Child);

impl FailingDisk {
    fn of(pid: u32) -> Self {
        let inject = "inject=fsync,fdatasync:error=EIO";
        let mut strace = Command::new("strace");
        strace.args(["-f", "-e", "trace=fsync,fdatasync", "-e", inject, "-o", "/dev/null", "-p", &pid.to_string()]);
        let mut strace = strace.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().expect("strace");
        let mut said = String::new();
        BufReader::new(strace.stderr.take().expect("a pipe")).read_line(&mut said).expect("text");
        assert!(said.contains("attached"), "strace cannot attach to a process that runs, allow ptrace: {said}");
        Self(strace)
    }

    fn mend(mut self) {
        // strace detaches from the server on TERM; if killed, it could leave the server stopped.
        let sent = Command::new("kill").args(["-TERM", &self.0.id().to_string()]).status();
        assert!(sent.is_ok_and(|status| status.success()));
        self.0.wait().expect("it ends");
    }
}

/// Sends renames, each with a new operation id, until one has an unknown outcome. Returns its id and the answer.
fn unknown_edit(ada: &mut Mirror) -> (String, Problem) {
    for _ in 0..TRIES {
        let op_id = ada.edit(rename(ada.light(), "renamed"));
        if let Outcome::Unknown(problem) = ada.result(&op_id) {
            return (op_id, problem);
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    panic!("of each of {TRIES} edits it was known what became of it");
}

/// Rules: SOCK-4, REC-4
#[test]
#[ignore = "needs strace"]
fn an_unknown_outcome_is_settled_by_resending() {
    let (mut server, [mut ada]) = Server::start_process().with(["ada"]);
    let disk = FailingDisk::of(server.pid());
    let (op_id, unknown) = unknown_edit(&mut ada);
    assert_eq!(unknown.code, ErrorCode::UnknownOutcome);
    disk.mend();

    let command = rename(ada.light(), "again");
    let again = ClientMessage::Edit { op_id: op_id.clone(), base_seq: ada.seq, command };
    ada.send(&again);
    let settled = ada.result(&op_id);
    let (seq, hash) = server.state();
    assert_eq!(committed(&settled), seq);
    server = server.restart();
    assert_eq!(server.state(), (seq, hash), "it is in the log once, and nothing else has come back");
    let mut ada = server.connect("ada");
    ada.send(&again);
    assert_eq!(ada.result(&op_id), settled);
}
