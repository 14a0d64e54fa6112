//! A disk that fails while the server runs: strace makes its syncs fail.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use protocol::{ClientMessage, EditResult, EditStatus, ErrorCode};

use crate::support::{Mirror, Server, rename};

/// Edits that are tried until the disk fails, or works again.
const TRIES: usize = 200;

/// A disk that fails as long as this lives.
struct FailingDisk(Child);

impl FailingDisk {
    /// `None` where strace cannot attach to a process that runs.
    fn of(pid: u32) -> Option<Self> {
        let inject = "inject=fsync,fdatasync:error=EIO";
        let mut strace = Command::new("strace");
        strace.args([
            "-f",
            "-e",
            "trace=fsync,fdatasync",
            "-e",
            inject,
            "-o",
            "/dev/null",
            "-p",
            &pid.to_string(),
        ]);
        let mut strace = strace.stdin(Stdio::null()).stderr(Stdio::piped()).spawn().ok()?;
        let said = BufReader::new(strace.stderr.take()?).lines().map_while(Result::ok).next();
        if said.is_some_and(|line| line.contains("attached")) {
            return Some(Self(strace));
        }
        let _ = strace.wait();
        None
    }

    fn mend(mut self) {
        // Asked to end it lets go of the server; killed it might leave it stopped.
        let asked = Command::new("kill").args(["-TERM", &self.0.id().to_string()]).status();
        assert!(asked.is_ok_and(|status| status.success()));
        self.0.wait().expect("it ends");
    }
}

/// Sends renamings under names of their own until one is answered as `wanted`; that one's name, and the answer.
fn edit_until(ada: &mut Mirror, light: u64, wanted: EditStatus) -> (String, EditResult) {
    for _ in 0..TRIES {
        let op_id = ada.edit(rename(light, "renamed"));
        let result = ada.result(&op_id);
        if result.status == wanted {
            return (op_id, result);
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    panic!("none of {TRIES} edits was answered with {wanted:?}");
}

/// Rules: SOCK-4, REC-4
#[test]
fn an_outcome_that_is_not_known_is_said_to_be_so_and_settled_by_sending_it_again() {
    let mut server = Server::start();
    let mut ada = server.connect("ada");
    let light = ada.light();
    let Some(disk) = FailingDisk::of(server.process.pid()) else {
        assert_ne!(
            std::env::var("CI").as_deref(),
            Ok("true"),
            "strace cannot attach: install it, allow ptrace"
        );
        println!("skipped: strace cannot attach to the server");
        return;
    };
    let (op_id, unknown) = edit_until(&mut ada, light, EditStatus::Unknown);
    assert_eq!((unknown.code.map(ErrorCode::name), unknown.seq), (Some("unknownOutcome"), None));
    disk.mend();

    let again =
        ClientMessage::Edit { op_id: op_id.clone(), base_seq: ada.seq, command: rename(light, "again") };
    ada.send(&again);
    let settled = ada.result(&op_id);
    assert_eq!(settled.status, EditStatus::Committed, "{settled:?}");
    let (seq, hash) = server.state();
    assert_eq!(settled.seq, Some(seq));
    server = server.restart();
    assert_eq!(server.state(), (seq, hash), "it is in the log once, and nothing else has come back");
    let mut ada = server.connect("ada");
    ada.send(&again);
    assert_eq!(ada.result(&op_id), settled);
}
