//! Records: appended in whole batches, stored unchanged, replayed to the same documents.

use edit::{Record, ReplayError};
use protocol::ErrorCode;
use store::{CommitBatch, Store, StoreError};

use crate::support::{Folder, Log, stored_log};

/// Returns the records as the store returns them.
fn all(store: &Store, session: &str) -> Vec<Record> {
    let records = store.records(session, 1, usize::MAX).expect("a log");
    records.into_iter().map(|record| record.try_into().expect("a sound record")).collect()
}

/// Rules: REC-1, HTTP-7
#[test]
fn appended_records_come_back_unchanged() {
    let folder = Folder::new();
    let log = stored_log(&mut folder.store(), "main", 100);
    let store = Store::open(&folder.data()).expect("a store");
    assert_eq!(all(&store, "main"), log.records);
    let row = store.session("main").expect("a session");
    assert_eq!((row.seq, row.hash), (102, log.hash().to_string()));
    let seqs = |from, limit| -> Vec<u64> {
        store.records("main", from, limit).expect("a log").iter().map(|record| record.seq).collect()
    };
    assert_eq!(seqs(100, 2), [100, 101]);
    assert_eq!(seqs(101, 50), [101, 102]);
    assert!(seqs(103, 50).is_empty() && seqs(u64::MAX, 50).is_empty() && seqs(1, 0).is_empty());
}

/// Rules: REC-1, REC-4
#[test]
fn batches_are_committed_all_or_none() {
    let folder = Folder::new();
    let mut store = folder.store();
    for name in ["a", "b"] {
        store.create_session(name).expect("a new name");
    }
    let log = Log::of(5);
    store.append(&[log.batch("a"), log.batch("b"), CommitBatch { records: &[], ..log.batch("a") }]).expect("a commit");

    let other = Log::of(20);
    let next = |records| CommitBatch { records, ..other.batch("a") };
    let of_b = |records| CommitBatch { records, ..other.batch("b") };
    let refused = |store: &mut Store, bad: CommitBatch, why: &str| {
        let error = store.append(&[next(&other.records[7..10]), bad]).expect_err(why);
        assert_eq!(store.session("a").expect("a session").seq, 7, "{why}: nothing of the other batch stays");
        error
    };
    let same_operation = [Record { op_id: "op 1".into(), ..other.records[7].clone() }];
    for (records, seq, why) in [
        (&other.records[8..9], 9, "a gap"),
        (&other.records[6..7], 7, "a record again"),
        (&same_operation, 8, "an operation again"),
    ] {
        let error = refused(&mut store, of_b(records), why);
        assert!(matches!(error, StoreError::ConcurrentWrite(at) if at == seq), "{why}: {error}");
    }
    let nowhere = CommitBatch { records: &other.records[..1], ..other.batch("c") };
    assert!(matches!(refused(&mut store, nowhere, "no session"), StoreError::NoSession(_)));
    store.append(&[next(&other.records[7..10])]).expect("the same without the fault");
}

/// Rules: REC-1
#[test]
fn a_record_over_the_limit_is_refused() {
    let mut store = Folder::new().store_of_main();
    let mut log = Log::of(0);
    log.records[1].actor.name = "x".repeat(store::MAX_RECORD_BYTES);
    let refused = store.append(&[log.batch("main")]).expect_err("too large");
    assert_eq!(refused.code(), ErrorCode::TooLarge, "{refused}");
    assert_eq!(store.session("main").expect("a session").seq, 0);
}

/// Rules: REC-1, REC-4, HTTP-4
#[test]
fn the_database_itself_keeps_a_log_in_order() {
    let folder = Folder::new();
    stored_log(&mut folder.store(), "main", 3);
    let database = folder.database();
    database.execute_batch("PRAGMA foreign_keys = ON").expect("a pragma");
    for forbidden in [
        "INSERT INTO record (session, seq, actor, op_id, json) VALUES (1, 7, 'b', 'x', '')",
        "INSERT INTO record (session, seq, actor, op_id, json) VALUES (1, 5, 'b', 'x', '')",
        "INSERT INTO record (session, seq, actor, op_id, json) VALUES (1, 6, 'a', 'op 5', '')",
        "INSERT INTO record (session, seq, actor, op_id, json) VALUES (2, 1, 'b', 'x', '')",
        "INSERT INTO record (session, seq, actor, op_id, json) VALUES (1, 6, 'b', 'x', NULL)",
        "UPDATE record SET json = '' WHERE seq = 2",
        "UPDATE record SET hash = hash WHERE hash IS NOT NULL",
        "DELETE FROM record WHERE seq = 5",
        "DELETE FROM session",
        "INSERT INTO session (name) VALUES ('main')",
        "INSERT INTO session (name) VALUES ('../main')",
        "INSERT INTO session (name) VALUES ('a b')",
    ] {
        assert!(database.execute(forbidden, []).is_err(), "{forbidden}");
    }
    let allowed = "INSERT INTO record (session, seq, actor, op_id, json) VALUES (1, 6, 'b', 'op 5', '')";
    assert_eq!(database.execute(allowed, []), Ok(1), "the next of another actor");
}

/// Rules: REC-2, LOG-2
#[test]
fn replay_gives_the_document_of_any_record() {
    let folder = Folder::new();
    let mut store = folder.store();
    let log = stored_log(&mut store, "main", 40);
    let replayed = |to| store.replay("main", to).expect("a log");
    assert_eq!(replayed(None).document().hash(), log.hash());
    let mut step_by_step = edit::Session::default();
    assert_eq!(replayed(Some(0)).document().hash(), step_by_step.document().hash());
    for record in &log.records {
        step_by_step.replay(record).expect("it goes on");
        let session = replayed(Some(record.seq));
        assert_eq!((session.seq(), session.document().hash()), (record.seq, step_by_step.document().hash()));
    }
    assert!(matches!(store.replay("main", Some(43)), Err(StoreError::NoRecord { requested: 43, last: 42 })));
}

/// Rules: LOG-2, LOG-3, REC-3
#[test]
fn replay_names_the_record_that_was_tampered_with() {
    let folder = Folder::new();
    let mut store = folder.store();
    stored_log(&mut store, "main", 40);
    let database = folder.database();
    database.execute_batch("DROP TRIGGER record_stays").expect("the trigger that forbids it");
    let error = |change: &str| {
        database.execute_batch(&format!("SAVEPOINT before; {change}; RELEASE before")).expect("a change");
        let store = Store::open(&folder.data()).expect("a store");
        let error = store.replay("main", None).expect_err(change);
        (error.to_string(), error)
    };
    // A value that no later record starts from: only the hash shows the change.
    let (said, last) = error(r"UPDATE record SET json = replace(json, '39.0', '39.5') WHERE seq = 42");
    assert!(matches!(last, StoreError::HashMismatch { seq: 42 }), "{said}");
    let (said, early) = error(r"UPDATE record SET json = replace(json, '[1.0,', '[1.25,') WHERE seq = 4");
    let conflict = matches!(early, StoreError::Replay(ReplayError::Record { seq: 5, .. }));
    assert!(conflict, "the next record starts from the value that was: {said}");
    let (said, broken) = error("UPDATE record SET json = '{' WHERE seq = 2");
    assert!(matches!(broken, StoreError::DamagedRecord { seq: 2, .. }), "{said}");
}
