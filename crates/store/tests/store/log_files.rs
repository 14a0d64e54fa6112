//! Log files: written, read back, and refused after a change.

use protocol::{ErrorCode, FIRST_PROOF, next_proof};
use store::{Difference, DifferingPart, StoreError, replay_log};

use crate::support::{Folder, Log, empty_hash, exported, is_here, stored_log};

/// Returns the log of `edits` steps as a file, and the log itself.
fn log_file(edits: u64) -> (String, Log) {
    let mut store = Folder::new().store();
    let log = stored_log(&mut store, "main", edits);
    (exported(&store, "main"), log)
}

fn import(text: &str, name: Option<&str>) -> Result<store::SessionRow, StoreError> {
    Folder::new().store().import(text.as_bytes(), name, &is_here)
}

/// Rules: LOG-1, LOG-2, SOCK-2
#[test]
fn a_log_goes_out_and_comes_in_again() {
    let folder = Folder::new();
    let mut store = folder.store();
    let log = stored_log(&mut store, "main", 250);
    let text = exported(&store, "main");
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[0], r#"{"format":6,"session":"main"}"#);
    assert_eq!(lines.len(), 1 + 252 + 26, "records 10, 20, ..., 250 and 252 have checkpoints");
    let is_covered = |line: &&&str| line.starts_with("{\"format\":6,");
    let proof = lines.iter().filter(is_covered).fold(String::new(), |proof, line| next_proof(&proof, line));
    assert_eq!(lines.last(), Some(&&*checkpoint(252, &log.hash().to_string(), &proof)));

    let row = store.import(text.as_bytes(), Some("copy"), &is_here).expect("a sound log");
    assert_eq!((row.name.as_str(), row.seq, &row.hash), ("copy", 252, &log.hash().to_string()));
    assert_ne!(row.epoch, store.session("main").expect("a session").epoch, "another history");
    // The same records under another header, which the proofs cover.
    let records = |text: &str| {
        let lines = text.lines().filter(|line| line.starts_with("{\"format\":6,\"seq\""));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(records(&exported(&store, "copy")), records(&text));
    let renamed = text.replace("\"session\":\"main\"", "\"session\":\"copy\"");
    let replayed = replay_log(renamed.as_bytes(), None).expect("a log");
    let expected = Difference { part: DifferingPart::Lines, last_matching_seq: 0, seq: 10 };
    assert_eq!(replayed.first_difference, Some(expected), "a header that was changed");
    let copy = store.replay("copy", None).expect("a log");
    assert_eq!(copy.document().hash(), log.hash());
    let taken = store.import(text.as_bytes(), None, &is_here).expect_err("`main` is there");
    assert_eq!(taken.code(), ErrorCode::Exists);
}

/// Rules: LOG-1
#[test]
fn an_empty_log_is_a_log() {
    let mut store = Folder::new().store_of_main();
    let text = exported(&store, "main");
    let header = r#"{"format":6,"session":"main"}"#;
    let checkpoint = checkpoint(0, &empty_hash(), &next_proof("", header));
    assert_eq!(text, format!("{header}\n{checkpoint}\n"));
    let row = store.import(text.as_bytes(), Some("copy"), &|_| false).expect("a log");
    assert_eq!((row.seq, row.hash), (0, empty_hash()));
    assert!(matches!(store.export("none", &mut Vec::new()), Err(StoreError::NoSession(_))));
}

/// Rules: LOG-2
#[test]
fn a_log_file_replays_to_any_record() {
    let (text, log) = log_file(30);
    let replayed = |to| replay_log(text.as_bytes(), to);
    let whole = replayed(None).expect("a log");
    assert_eq!((whole.session.document().hash(), whole.first_difference), (log.hash(), None));
    for to in [0, 1, 17, 32] {
        let session = replayed(Some(to)).expect("a log").session;
        assert_eq!((session.seq(), session.document().hash()), (to, log.hash_after(to)));
    }
    assert!(matches!(replayed(Some(33)), Err(StoreError::NoRecord { requested: 33, last: 32 })));
}

/// Rules: LOG-1, LOG-2, REC-1, REC-3, REC-4
#[test]
fn a_changed_log_is_refused_by_line_or_record() {
    let (text, log) = log_file(20);
    import(&text, None).expect("as it was written");
    let lines: Vec<_> = text.lines().map(String::from).collect();
    let refused = |what: &str, expected: &str, change: &dyn Fn(&mut Vec<String>)| {
        let mut lines = lines.clone();
        change(&mut lines);
        let error = import(&(lines.join("\n") + "\n"), None).expect_err(what);
        assert!(error.to_string().contains(expected), "{what}: {error}");
        assert_eq!(error.code(), ErrorCode::BadLog, "{what}");
    };
    // Up to record 10 the index of a line is its sequence number. A checkpoint follows each tenth record.
    refused("dropped", "record 10 follows record 8", &|l| drop(l.remove(9)));
    refused("swapped", "record 10 follows record 8", &|l| l.swap(9, 10));
    refused("doubled", "record 9 follows record 9", &|l| l.insert(10, l[9].clone()));
    refused("cut", "cut short", &|l| drop(l.pop()));
    refused("no header", "line 1", &|l| drop(l.remove(0)));
    refused("header alone", "cut short", &|l| l.truncate(1));
    refused("a value", "record 5: ", &|l| l[4] = l[4].replace("[1.0,", "[1.25,"));
    refused("the last value", "after record 22", &|l| l[24] = l[24].replace("19.0", "19.5"));
    refused("an operation", "record 9 repeats operation op 8", &|l| l[9] = l[9].replace("op 9", "op 8"));
    let (target, later) = ("\"target\":8", "\"target\":22");
    refused("an undo's target", "record 9 takes back record 22", &|l| l[9] = l[9].replace(target, later));
    let hash = log.hash().to_string();
    // The last line, of index 25, is the checkpoint of record 22.
    assert_eq!(lines.len(), 26);
    let without_proof = format!(r#"{{"checkpoint":{{"seq":22,"hash":"{hash}"}}}}"#);
    refused("a hash", "after record 22", &|l| l[25] = l[25].replace(&hash, &empty_hash()));
    refused("a proof", "records 21 to 22", &|l| l[25] = checkpoint(22, &hash, FIRST_PROOF));
    refused("no proof", "records 21 to 22", &|l| l[25].clone_from(&without_proof));
    refused("a checkpoint's place", "checkpoint of record 21", &|l| l[25] = l[25].replace("\"seq\":22", "\"seq\":21"));
    let twice = "line 27: a checkpoint of record 22 does not stand directly";
    refused("a checkpoint twice", twice, &|l| l.push(l[25].clone()));
    // Data that no document holds: actor, time and operation id.
    for (was, now) in [("Ada", "Eve"), ("\"id\":\"a\"", "\"id\":\"e\""), ("17900", "17800"), ("op 21", "op x")] {
        refused(was, "records 21 to 22", &|l| l[23] = l[23].replace(was, now));
    }
    let in_header = "the header or a line of records 1 to 10";
    refused("a session's name", in_header, &|l| l[0] = l[0].replace("main", "other"));
    refused("an older header", "the header or a line", &|l| l[0] = l[0].replace("\"format\":6", "\"format\":3"));
    refused("CR LF", "end in CR LF", &|l| l.iter_mut().for_each(|line| line.push('\r')));
    refused("a newer format", "format 7", &|l| l[0] = l[0].replace("\"format\":6", "\"format\":7"));
    let newer = "\"format\":7,\"later\":0";
    refused("a newer record", "line 5: format 7", &|l| l[4] = l[4].replace("\"format\":6", newer));
    refused("an unknown field", "`gobo`", &|l| l[4] = l[4].replacen('{', "{\"gobo\":1,", 1));
    refused("no JSON", "line 5: ", &|l| l[4] = "{".into());
}

fn checkpoint(seq: u64, hash: &str, proof: &str) -> String {
    format!(r#"{{"checkpoint":{{"seq":{seq},"hash":"{hash}","proof":"{proof}"}}}}"#)
}

/// Rules: LOG-1
#[test]
fn a_refused_log_leaves_nothing_behind() {
    let folder = Folder::new();
    let mut store = folder.store();
    let (text, _) = log_file(20);
    let cut = &text[..text.len() - 80];
    store.import(cut.as_bytes(), None, &is_here).expect_err("cut");
    store.import(text.as_bytes(), None, &|_| false).expect_err("no scene");
    store.import(text.as_bytes(), Some("a b"), &is_here).expect_err("no name");
    let latin1: &[u8] = b"{\"format\":1,\"session\":\"\xe9\"}\n";
    store.import(latin1, None, &is_here).expect_err("not UTF-8");
    let endless = std::io::BufReader::new(std::io::repeat(b' '));
    let refused = store.import(endless, None, &is_here).expect_err("a line without end");
    assert_eq!(refused.code(), ErrorCode::TooLarge);
    assert_eq!(store.sessions().expect("a list"), []);
    store.import(text.as_bytes(), None, &is_here).expect("the name is free");
}

/// Rules: LOG-2
#[test]
fn a_replay_says_which_checkpoint_differs_and_goes_on() {
    let (text, log) = log_file(250);
    let planted = text.replace("\"seq\":100,\"hash\":\"", "\"seq\":100,\"hash\":\"0");
    let planted_at = Difference { part: DifferingPart::Document, last_matching_seq: 90, seq: 100 };
    let replayed = replay_log(planted.as_bytes(), None).expect("a log");
    assert_eq!((replayed.first_difference, replayed.session.document().hash()), (Some(planted_at), log.hash()));
    let before = replay_log(planted.as_bytes(), Some(99)).expect("a log");
    assert_eq!(before.first_difference, None);
    let there = replay_log(planted.as_bytes(), Some(100)).expect("a log");
    assert_eq!(there.first_difference, Some(planted_at), "the checkpoint of the last record counts");
}
