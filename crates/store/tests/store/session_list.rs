//! The list of sessions, and operations on whole sessions.

use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use protocol::ErrorCode;
use rusqlite::Connection;
use store::{CommitBatch, LastChange, SessionChange, Store, StoreError, replay_log};

use crate::support::{DATABASE, Folder, Log, exported, of_format_1, stored_log};

fn titled(title: &str) -> SessionChange {
    SessionChange { title: Some(title.into()), archived: None }
}

fn archived(archived: bool) -> SessionChange {
    SessionChange { title: None, archived: Some(archived) }
}

/// Finds the words that occur in a file of the database.
fn found(data: &Path, words: &[&str]) -> Vec<String> {
    let files = [DATABASE, "bendylights.sqlite-wal"].map(|file| fs::read(data.join(file)).unwrap_or_default());
    let holds = |word: &&&str| files.iter().any(|file| file.windows(word.len()).any(|at| at == word.as_bytes()));
    words.iter().filter(holds).map(|word| (*word).to_owned()).collect()
}

/// Rules: HTTP-32
#[test]
fn a_list_says_when_a_session_was_made_and_changed_last() {
    let mut store = Folder::new().store();
    store.create_session("empty").expect("a new name");
    let log = stored_log(&mut store, "main", 3);
    let rows = store.sessions().expect("a list");
    let [empty, main] = &rows[..] else { panic!("{rows:?}") };
    assert_eq!((&*empty.name, &*empty.title, empty.seq, &empty.changed), ("empty", "empty", 0, &None));
    let changed = LastChange { time_ms: 1_790_000_000_000, actor_name: "Ada".into() };
    assert_eq!((main.seq, &main.changed), (log.session.seq(), &Some(changed)));
    let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("a clock");
    let made = Duration::from_millis(main.made_ms.expect("made here"));
    assert!(made <= now && now < made + Duration::from_hours(1), "{made:?} of {now:?}");
    assert_eq!(store.summary("main").expect("a session"), *main);
    assert_eq!(store.summary("no").expect_err("none").code(), ErrorCode::NotFound);
}

/// Removes every line of every log. The list still works.
///
/// Rules: HTTP-32
#[test]
fn a_list_reads_no_log() {
    let folder = Folder::new();
    let mut store = folder.store();
    for name in ["a", "b"] {
        stored_log(&mut store, name, 40);
    }
    let before = store.sessions().expect("a list");
    folder.plant("DROP TRIGGER record_stays; UPDATE record SET json = 'gone', hash = NULL");
    assert_eq!(store.sessions().expect("a list"), before);
    assert!(store.open_session("a").is_err(), "a session that is opened does read it");
}

/// Rules: HTTP-33
#[test]
fn a_title_and_the_archive_leave_name_and_log_alone() {
    let mut store = Folder::new().store();
    stored_log(&mut store, "main", 3);
    let log = exported(&store, "main");
    let row = store.change_session("main", &titled("Shot 10, évening")).expect("a title");
    assert_eq!((&*row.name, &*row.title, row.is_archived), ("main", "Shot 10, évening", false));
    let row = store.change_session("main", &archived(true)).expect("archived");
    assert_eq!((&*row.title, row.is_archived), ("Shot 10, évening", true), "what is not named stays");
    assert_eq!(exported(&store, "main"), log);
    let mut longer = Log::of(3);
    longer.add_long_light();
    store.append(&[CommitBatch { records: &longer.records[5..], ..longer.batch("main") }]).expect("it goes on");
    assert!(!store.change_session("main", &archived(false)).expect("brought back").is_archived);
    for title in ["", " a", "a ", "a\nb", &"x".repeat(257)] {
        let refused = store.change_session("main", &titled(title)).expect_err(title);
        assert_eq!(refused.code(), ErrorCode::BadName, "{title:?}: {refused}");
    }
    let both = SessionChange { title: Some(" ".into()), archived: Some(true) };
    store.change_session("main", &both).expect_err("a bad title");
    assert!(!store.summary("main").expect("a session").is_archived, "all of a change or nothing");
    assert!(matches!(store.change_session("no", &titled("x")), Err(StoreError::NoSession(_))));
}

/// Rules: HTTP-34, LOG-4
#[test]
fn a_duplicate_has_the_whole_log_and_proofs_of_its_own() {
    let folder = Folder::new();
    let mut store = folder.store();
    let mut log = stored_log(&mut store, "main", 40);
    let copy = store.duplicate_session("main", "copy", Some("Main copy")).expect("a new name");
    let main = store.summary("main").expect("a session");
    assert_eq!((&*copy.title, copy.seq, &copy.changed), ("Main copy", main.seq, &main.changed));
    assert_ne!(copy.epoch, main.epoch, "another history from here on");
    let files = ["main", "copy"].map(|name| exported(&store, name));
    let [of_main, of_copy] = files.each_ref().map(|file| file.lines().collect::<Vec<_>>());
    let records = |lines: &[&str]| -> Vec<String> {
        lines.iter().filter(|line| line.starts_with("{\"format\":6,\"seq\"")).map(|line| (*line).into()).collect()
    };
    assert_eq!(records(&of_main), records(&of_copy));
    assert_eq!(records(&of_main).len(), 42);
    assert_ne!(of_main.last(), of_copy.last(), "the proofs cover the name");
    let replayed = replay_log(files[1].as_bytes(), None).expect("a log");
    assert!(replayed.first_difference.is_none(), "{:?}", replayed.first_difference);
    // Deliberate fault that the check must detect: the proofs of the original do not fit the copy.
    let planted = [&of_copy[..1], &of_main[1..]].concat().join("\n") + "\n";
    assert!(replay_log(planted.as_bytes(), None).expect("a log").first_difference.is_some());
    // The copy can undo, and original and copy do not have each other's new records.
    log.undo();
    let more = CommitBatch { records: &log.records[42..], ..log.batch("copy") };
    store.append(&[more]).expect("it goes on");
    assert_eq!(store.open_session("copy").expect("a log").session.document().hash(), log.hash());
    assert_eq!(store.summary("main").expect("a session"), main);
    assert!(matches!(store.duplicate_session("main", "copy", None), Err(StoreError::Exists(_))));
    assert!(matches!(store.duplicate_session("no", "other", None), Err(StoreError::NoSession(_))));
    assert!(matches!(store.duplicate_session("main", "a b", None), Err(StoreError::BadName(_))));
    assert_eq!(store.sessions().expect("a list").len(), 2, "what is refused leaves nothing");
}

/// Rules: HTTP-34, LOG-4
#[test]
fn a_duplicate_proves_no_line_that_was_changed() {
    let folder = Folder::new();
    let mut store = folder.store();
    stored_log(&mut store, "main", 20);
    folder.plant("DROP TRIGGER record_stays; UPDATE record SET json = replace(json, 'Ada', 'Eve') WHERE seq = 7");
    let refused = store.duplicate_session("main", "copy", None).expect_err("a changed line");
    assert_eq!(refused.code(), ErrorCode::BadLog);
    assert!(matches!(refused, StoreError::ProofMismatch { seq: 10 }), "the next that has a proof: {refused}");
    assert_eq!(store.sessions().expect("a list").len(), 1, "nothing of it is left");
}

/// Rules: HTTP-34, REC-5
#[test]
fn a_log_of_an_earlier_format_is_duplicated_as_it_stands() {
    let folder = Folder::new();
    fs::create_dir_all(folder.data().join("assets")).expect("a folder");
    let database = folder.database();
    database.execute_batch(include_str!("../../src/sqlite/schema-1.sql")).expect("version 1");
    database.execute("INSERT INTO session (name) VALUES ('old')", []).expect("a session");
    let log = Log::of(9);
    let hash = log.session.document().hash_of_format(1).to_string();
    for record in &log.records {
        let hash = (record.seq == log.session.seq()).then_some(&hash);
        let row = rusqlite::params![record.seq, record.op_id, of_format_1(record), hash];
        let insert = "INSERT INTO record (session, seq, actor, op_id, json, hash) VALUES (1, ?, 'a', ?, ?, ?)";
        database.execute(insert, row).expect("a record");
    }
    drop(database);
    let mut store = Store::open(&folder.data()).expect("brought up to date");
    let old = store.summary("old").expect("a session");
    let changed = LastChange { time_ms: 1_790_000_000_000, actor_name: "Ada".into() };
    assert_eq!((old.made_ms, &old.changed), (Some(1_790_000_000_000), &Some(changed)), "as its records say");
    store.duplicate_session("old", "copy", None).expect("a new name");
    let replayed = store.replay("copy", None).expect("a log that is proven");
    assert_eq!(replayed.document().hash(), log.hash());
    let header = |name| exported(&store, name).lines().next().map(str::to_owned);
    assert_eq!(header("copy"), header("old").map(|line| line.replace("old", "copy")));
}

/// Rules: HTTP-35, REC-1
#[test]
fn a_deleted_session_alone_is_gone_from_the_disk() {
    let folder = Folder::new();
    let mut store = folder.store();
    let scene = store.assets.put(b"a scene").expect("a file");
    let kept = stored_log(&mut store, "kept", 20);
    stored_log(&mut store, "gone-with-all", 400);
    store.change_session("gone-with-all", &titled("a title to be forgotten")).expect("a title");
    let opened = store.open_session("gone-with-all").expect("a log").session;
    let checkpoint = protocol::SessionCheckpoint::from(&opened);
    store.keep_checkpoint("gone-with-all", &checkpoint).expect("kept");
    let marks = ["gone-with-all", "a title to be forgotten", "op 402"];
    assert_eq!(found(&folder.data(), &marks), marks);

    let refused = store.delete_session("gone-with-all").expect_err("it is not archived");
    assert_eq!(refused.code(), ErrorCode::NotArchived);
    store.change_session("gone-with-all", &archived(true)).expect("archived");
    store.delete_session("gone-with-all").expect("deleted");
    assert_eq!(found(&folder.data(), &marks), Vec::<String>::new());
    assert_eq!(store.delete_session("gone-with-all").expect_err("none").code(), ErrorCode::NotFound);
    let names: Vec<_> = store.sessions().expect("a list").into_iter().map(|row| row.name).collect();
    assert_eq!(names, ["kept"]);
    assert_eq!(store.replay("kept", None).expect("a log").document().hash(), kept.hash());
    assert!(store.assets.bytes(&scene).expect("whole").is_some(), "others may load it");
    // The free name starts another history.
    store.create_session("gone-with-all").expect("free again");
    assert_eq!(store.summary("gone-with-all").expect("a session").seq, 0);
}

/// Rules: HTTP-35, REC-1
#[test]
fn no_program_takes_a_part_of_a_log() {
    let folder = Folder::new();
    let mut store = folder.store();
    stored_log(&mut store, "main", 3);
    let mut database = folder.database();
    database.execute_batch("PRAGMA foreign_keys = ON").expect("a pragma");
    let refused = |database: &Connection, sql: &str| database.execute_batch(sql).expect_err(sql).to_string();
    assert!(refused(&database, "DELETE FROM record WHERE seq = 5").contains("only grows"));
    assert!(refused(&database, "DELETE FROM session").contains("only an archived session goes"));
    store.change_session("main", &archived(true)).expect("archived");
    assert!(refused(&database, "DELETE FROM record WHERE seq = 5").contains("only grows"));
    assert!(refused(&database, "DELETE FROM session").contains("FOREIGN KEY"));
    // Some of its records without the rest, after its row.
    let some = database.transaction().expect("a transaction");
    some.execute_batch("PRAGMA defer_foreign_keys = ON; DELETE FROM session; DELETE FROM record WHERE seq = 5")
        .expect("not committed yet");
    assert!(some.commit().expect_err("records of no session").to_string().contains("FOREIGN KEY"));
    assert_eq!(store.replay("main", None).expect("all of it").seq(), 5);
}
