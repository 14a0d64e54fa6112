//! Opening from a checkpoint: the same session, for the cost of the later records.

use document::Command;
use protocol::{ErrorCode, SessionCheckpoint};
use store::{RecordTail, Store};

use crate::support::{Folder, Log, SCENE, exported, is_here, of_format_1, stored_log};

fn opened(store: &Store) -> store::OpenedSession {
    store.open_session("main").expect("a log")
}

/// Returns a session of 62 records with a checkpoint after record 42.
fn with_checkpoint(folder: &Folder) -> (Store, Log) {
    let mut store = folder.store();
    let mut log = stored_log(&mut store, "main", 40);
    store.keep_checkpoint("main", &SessionCheckpoint::from(&log.session)).expect("kept");
    let known = log.records.len();
    for _ in 0..10 {
        log.edit(Command::LoadScene { asset: SCENE, name: "again".into() });
        log.undo();
    }
    store.append(&[store::CommitBatch { records: &log.records[known..], ..log.batch("main") }]).expect("a commit");
    (store, log)
}

/// Rules: LOG-5, REC-2
#[test]
fn only_what_follows_a_checkpoint_is_replayed() {
    let folder = Folder::new();
    let (store, log) = with_checkpoint(&folder);
    let found = opened(&store);
    assert_eq!(found.tail.records, 20, "of 62");
    assert!(!found.checkpoint_failed && found.checkpoint_bytes > 0);
    assert_eq!((found.session.seq(), found.row.seq), (62, 62));
    assert_eq!(found.session.document().hash(), log.hash());
    assert_eq!(found.session.session_history(), log.session.session_history(), "undo reaches past the checkpoint");
    // The log alone gives the same history.
    let replayed = store.replay("main", None).expect("a log");
    assert_eq!(replayed.session_history(), log.session.session_history());
}

/// Rules: LOG-5
#[test]
fn a_checkpoint_that_the_log_does_not_prove_is_passed_over() {
    let planted = [
        "UPDATE checkpoint SET json = replace(json, 'key', 'kez')",
        "UPDATE checkpoint SET digest = replace(digest, substr(digest, 1, 1), 'x')",
        "UPDATE checkpoint SET json = ''",
        "UPDATE checkpoint SET seq = 32",
    ];
    for fault in planted {
        let folder = Folder::new();
        let (store, log) = with_checkpoint(&folder);
        assert!(folder.database().execute(fault, []).expect(fault) == 1);
        let found = opened(&store);
        assert!(found.checkpoint_failed, "{fault}");
        assert_eq!((found.tail.records, found.session.document().hash()), (62, log.hash()), "{fault}");
    }
    // A valid checkpoint of another document.
    let folder = Folder::new();
    let (mut store, log) = with_checkpoint(&folder);
    let other = SessionCheckpoint { seq: 42, ..SessionCheckpoint::from(&Log::of(39).session) };
    store.keep_checkpoint("main", &other).expect("kept");
    assert_eq!((opened(&store).tail.records, opened(&store).session.document().hash()), (62, log.hash()));
}

/// The thousands of steps of one actor are numbers, whatever the actor's name: each checkpoint holds them all.
///
/// Rules: LOG-5
#[test]
fn a_step_takes_a_few_bytes_of_a_checkpoint() {
    let bytes = |edits: u64| SessionCheckpoint::from(&Log::of(edits).session).to_json().len();
    let (few, many) = (bytes(700), bytes(1_400));
    // One of seven edits undoes another, so five are in effect. A number of four digits takes a comma.
    assert!(many - few < 500 * 6, "{} bytes for 500 steps", many - few);
}

/// Rules: LOG-2, LOG-4
#[test]
fn records_after_a_checkpoint_are_proven() {
    let folder = Folder::new();
    let (store, _) = with_checkpoint(&folder);
    let database = folder.database();
    database.execute_batch("DROP TRIGGER record_stays").expect("the trigger that forbids it");
    for (was, now) in [("Ada", "Eve"), ("17900", "17800"), ("again", "agaim")] {
        let fault = format!("UPDATE record SET json = replace(json, '{was}', '{now}') WHERE seq = 61");
        database.execute_batch(&fault).expect("a change");
        let error = store.open_session("main").expect_err(was);
        assert_eq!(error.code(), ErrorCode::BadLog, "{was}: {error}");
        let back = format!("UPDATE record SET json = replace(json, '{now}', '{was}') WHERE seq = 61");
        database.execute_batch(&back).expect("a change");
        opened(&store);
    }
}

/// A document near its limits, replaced and restored many times: the log holds its values once, and opening does not
/// read them again and again.
///
/// Rules: REC-6, LOG-5
#[test]
fn a_log_does_not_grow_by_what_it_holds() {
    let folder = Folder::new();
    let mut store = folder.store_of_main();
    let mut log = Log::default();
    for _ in 0..16 {
        log.add_long_light();
    }
    let bytes_of = |records: &[edit::Record]| -> usize {
        records.iter().map(|record| protocol::Record::from(record).to_json().len()).sum()
    };
    let lights = bytes_of(&log.records);
    for _ in 0..20 {
        log.edit(Command::LoadScene { asset: SCENE, name: "empty".into() });
        log.undo();
    }
    store.append(&[log.batch("main")]).expect("a commit");
    let in_full = bytes_of(&log.records);
    let text = exported(&store, "main");
    assert!(in_full > 15 * lights, "each of 40 records holds the lights: {in_full} of {lights}");
    assert!(text.len() < lights, "{} bytes of {in_full}, the lights alone stand there twice: {lights}", text.len());
    let replayed = store.replay("main", None).expect("a log");
    assert_eq!(replayed.document().hash(), log.hash());
    let again = store.records("main", 40, 3).expect("from the middle");
    let wire: Vec<_> = log.records[39..42].iter().map(protocol::Record::from).collect();
    assert_eq!(again, wire, "in full");
    // The same through a log file.
    let other = Folder::new();
    let row = other.store().import(text.as_bytes(), None, &is_here).expect("a sound log");
    assert_eq!((row.seq, row.hash, row.proof), (56, log.hash().to_string(), store.session("main").unwrap().proof));
    store.keep_checkpoint("main", &SessionCheckpoint::from(&log.session)).expect("kept");
    assert_eq!(opened(&store).tail, RecordTail::default());
    // A file of format 1, which holds every value in full, gives the same session.
    let lines: Vec<_> = log.records.iter().map(of_format_1).collect();
    let header = r#"{"format":1,"session":"old"}"#;
    let checkpoint = format!(r#"{{"checkpoint":{{"seq":56,"hash":"{}"}}}}"#, log.session.document().hash_of_format(1));
    let old = format!("{header}\n{}\n{checkpoint}\n", lines.join("\n"));
    assert_eq!(store::replay_log(old.as_bytes(), None).expect("format 1").first_difference, None);
    // Deliberate fault that the check must detect: the hash of today's format, which a log of that time cannot have.
    let planted = old.replace(&log.session.document().hash_of_format(1).to_string(), &log.hash().to_string());
    assert_eq!(
        store::replay_log(planted.as_bytes(), None).expect("format 1").first_difference.map(|how| how.seq),
        Some(56)
    );
    let younger = old.replacen(r#""type":"bendy""#, r#""type":"bendy","exposure":50"#, 1);
    let refused = store.import(younger.as_bytes(), None, &is_here).expect_err("a parameter of today");
    assert!(refused.to_string().contains("record 1: format 1 has no `exposure`"), "{refused}");
    let row = other.store().import(old.as_bytes(), Some("again"), &is_here).expect("format 1");
    let today = old.replace(r#""format":1,"opId""#, r#""format":6,"opId""#);
    let today = today.replace(&log.session.document().hash_of_format(1).to_string(), &log.hash().to_string());
    let of_today = store.import(today.as_bytes(), Some("again"), &is_here).expect("format 6");
    assert_eq!(row.proof, of_today.proof, "upgraded");
    other.store().replay("again", None).expect("a log");
}
