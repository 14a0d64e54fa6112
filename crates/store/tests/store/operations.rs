//! Outcomes of operations.

use document::Command;
use edit::Action;
use light::LightId;
use protocol::{Committed, ErrorCode, Outcome, Problem};
use store::{CommitBatch, MAX_REJECTIONS, Rejection, Store, StoreError};

use crate::support::{Folder, Log, exported, stored_log};

fn folded(message: &str) -> Problem {
    Problem { code: ErrorCode::InvalidLight, message: message.into() }
}

fn rejection(actor_id: &str, op_id: &str, message: &str) -> Rejection {
    let (actor_id, op_id) = (actor_id.into(), op_id.into());
    Rejection { actor_id, op_id, problem: folded(message) }
}

fn reject(store: &mut Store, session: &str, rejections: &[Rejection]) {
    let hash = Log::default().hash();
    store.append(&[CommitBatch { session, records: &[], rejections, hash }]).expect("a commit");
}

/// Rules: REC-4
#[test]
fn an_operation_has_its_first_outcome() {
    let folder = Folder::new();
    let mut store = folder.store();
    stored_log(&mut store, "main", 20);
    store.create_session("other").expect("a new name");
    reject(&mut store, "main", &[rejection("a", "x", "it folds"), rejection("b", "x", "it is gone")]);
    reject(&mut store, "main", &[rejection("a", "x", "a second answer")]);
    drop(store);
    let store = folder.store();
    let outcome = |session: &str, actor: &str, op: &str| store.outcome(session, actor, op).expect("an answer");
    let committed = Outcome::Committed(Committed { seq: 7, ..Committed::default() });
    assert_eq!(outcome("main", "a", "op 7"), Some(committed));
    assert_eq!(outcome("main", "a", "x"), Some(Outcome::Rejected(folded("it folds"))));
    for (session, actor, op) in [("main", "c", "x"), ("other", "a", "op 7"), ("other", "a", "x"), ("main", "a", "y")] {
        assert_eq!(outcome(session, actor, op), None, "{session} {actor} {op}");
    }
    assert!(matches!(store.outcome("none", "a", "x"), Err(StoreError::NoSession(_))));
}

/// Rules: REC-4
#[test]
fn a_refusal_with_a_code_of_a_newer_program_is_named() {
    let folder = Folder::new();
    let mut store = folder.store_of_main();
    reject(&mut store, "main", &[rejection("a", "x", "it folds")]);
    folder.plant("UPDATE rejection SET code = 'tooBright'");
    let error = store.outcome("main", "a", "x").expect_err("it is not known");
    assert!(matches!(&error, StoreError::UnknownCode(code) if code == "tooBright"), "{error}");
    assert_eq!(error.code(), ErrorCode::Storage);
}

/// A record that restores a long light refers to the record that holds it. A repeated operation is answered without
/// resolving that, which takes long in a large document.
///
/// Rules: REC-4, REC-6
#[test]
fn an_outcome_is_read_of_its_own_line_alone() {
    let folder = Folder::new();
    let mut store = folder.store_of_main();
    let mut log = Log::default();
    log.add_long_light();
    log.edit(Command::RemoveLight(LightId(1)));
    log.undo();
    store.append(&[log.batch("main")]).expect("a commit");
    folder.plant("DROP TRIGGER record_stays; UPDATE record SET json = '' WHERE seq = 1");
    store.records("main", 3, 1).expect_err("the light is gone");
    let committed = Outcome::Committed(Committed { seq: 3, ..Committed::default() });
    assert_eq!(store.outcome("main", "a", "op 3").expect("an answer"), Some(committed));
}

/// A long list of skipped records is itself replaced by a reference if it comes again.
///
/// Rules: REC-4, REC-6
#[test]
fn an_outcome_that_is_referred_to_is_found() {
    let folder = Folder::new();
    let mut store = folder.store_of_main();
    let mut log = Log::of(5);
    log.undo();
    log.undo();
    let skipped: Vec<String> = (0..40).map(|n| format!("light {n}'s radius has been changed since")).collect();
    for record in &mut log.records {
        if let Action::Undo { skipped: said, .. } = &mut record.action {
            said.clone_from(&skipped);
        }
    }
    store.append(&[log.batch("main")]).expect("a commit");
    for seq in [8, 9] {
        let skipped = skipped.clone();
        let committed = Outcome::Committed(Committed { seq, skipped, ..Committed::default() });
        assert_eq!(store.outcome("main", "a", &format!("op {seq}")).expect("an answer"), Some(committed));
    }
}

/// Rules: REC-4
#[test]
fn an_actors_latest_rejections_are_kept() {
    let mut store = Folder::new().store_of_main();
    let many: Vec<_> = (0..=MAX_REJECTIONS).map(|op| rejection("a", &op.to_string(), "no")).collect();
    reject(&mut store, "main", &[rejection("b", "0", "no")]);
    reject(&mut store, "main", &many);
    let is_kept = |actor, op: u64| store.outcome("main", actor, &op.to_string()).expect("an answer").is_some();
    assert!(!is_kept("a", 0) && is_kept("a", 1) && is_kept("a", MAX_REJECTIONS));
    assert!(is_kept("b", 0), "another's flood takes none of his");
}

/// Rules: REC-4
#[test]
fn a_log_file_with_an_operation_twice_is_refused() {
    let mut store = Folder::new().store();
    stored_log(&mut store, "main", 5);
    let text = exported(&store, "main").replace("\"opId\":\"op 4\"", "\"opId\":\"op 3\"");
    let error = store::replay_log(text.as_bytes(), None).expect_err("twice");
    assert_eq!(error.to_string().split(':').next(), Some("record 4 repeats operation op 3 of the same actor"));
}
