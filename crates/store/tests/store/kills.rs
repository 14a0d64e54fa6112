//! A program that is killed while it duplicates and deletes sessions leaves each of them complete or not there.
//!
//! A child process copies a session, deletes the copy before it, and prints a line for each step.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{env, thread};

use rusqlite::Connection;
use store::{SessionChange, Store};

use crate::support::{Folder, stored_log};

const CHILD: &str = "kills::child_that_duplicates_and_deletes";
const FOLDER: &str = "BENDYLIGHTS_CHILD_FOLDER";
const FIRST: &str = "BENDYLIGHTS_CHILD_FIRST";
const KILLS: u32 = 12;
/// Length of the copied log: enough for a kill to hit the middle of a step.
const EDITS: u64 = 400;

#[test]
#[ignore = "the child of the tests below, which they start"]
fn child_that_duplicates_and_deletes() {
    let folder = env::var(FOLDER).expect("started by a test");
    let first: u64 = env::var(FIRST).expect("a number").parse().expect("a number");
    let mut store = Store::open(Path::new(&folder)).expect("a store");
    let archived = SessionChange { archived: Some(true), ..SessionChange::default() };
    for number in first.. {
        store.duplicate_session("main", &format!("copy-{number}"), None).expect("a new name");
        writeln!(std::io::stdout(), "made {number}").expect("a reader");
        let Some(before) = number.checked_sub(1).map(|before| format!("copy-{before}")) else { continue };
        store.change_session(&before, &archived).expect("archived");
        store.delete_session(&before).expect("deleted");
        writeln!(std::io::stdout(), "gone {}", number - 1).expect("a reader");
    }
}

/// Starts the child and kills it that long after its first copy. Returns the last copy and the last deletion that it
/// printed.
fn killed(data: &Path, first: u64, after: Duration) -> (Option<u64>, Option<u64>) {
    let mut child = Command::new(env::current_exe().expect("this program"));
    child.args(["--exact", CHILD, "--ignored", "--nocapture"]).env(FOLDER, data).env(FIRST, first.to_string());
    child.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = child.spawn().expect("the child runs");
    let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
    let (mut made, mut gone) = (None, None);
    let mut note = |line: &str| match line.split_once(' ') {
        Some(("made", number)) => made = number.parse().ok(),
        Some(("gone", number)) => gone = number.parse().ok(),
        _ => {}
    };
    for line in lines.by_ref() {
        let line = line.expect("text");
        note(&line);
        if line.starts_with("made ") {
            break;
        }
    }
    thread::sleep(after);
    child.kill().expect("it runs");
    lines.for_each(|line| note(&line.expect("text")));
    child.wait().expect("it ends");
    (made, gone)
}

/// Lists the sessions that are neither complete nor gone.
fn damage(data: &Path) -> Vec<String> {
    let store = Store::open(data).expect("a store");
    let main = store.replay("main", None).expect("a log").document().hash();
    let is_whole = |name: &str| store.replay(name, None).is_ok_and(|session| session.document().hash() == main);
    let names = store.sessions().expect("a list").into_iter().map(|session| session.name);
    let mut damage: Vec<String> = names.filter(|name| !is_whole(name)).collect();
    let database = Connection::open(data.join("bendylights.sqlite")).expect("a database");
    let mut check = database.prepare("PRAGMA foreign_key_check").expect("a pragma");
    let orphans = check.query_map([], |row| row.get::<_, String>(0)).expect("rows");
    damage.extend(orphans.map(|table| format!("a row of {} of no session", table.expect("a name"))));
    damage
}

/// Rules: HTTP-34, HTTP-35
#[test]
fn sessions_are_whole_or_gone_after_a_kill() {
    let folder = Folder::new();
    let data = folder.data();
    let mut store = folder.store();
    stored_log(&mut store, "main", EDITS);
    let began = Instant::now();
    store.duplicate_session("main", "timed", None).expect("a new name");
    let took = began.elapsed();
    drop(store);
    let mut next = 0;
    for kill in 0..KILLS {
        // The kill moves from one of the two transactions into the next.
        let (made, gone) = killed(&data, next, took.mul_f64(2.0 * f64::from(kill) / f64::from(KILLS)));
        assert_eq!(damage(&data), Vec::<String>::new(), "after {made:?} and {gone:?}");
        let made = made.expect("it was waited for");
        let store = Store::open(&data).expect("a store");
        let is_there = |number: u64| store.summary(&format!("copy-{number}")).is_ok();
        assert!(is_there(made), "what was acknowledged is there");
        assert!(gone.is_none_or(|gone| !is_there(gone)), "what was deleted stays so");
        next = if is_there(made + 1) { made + 2 } else { made + 1 };
    }
    let database = Connection::open(data.join("bendylights.sqlite")).expect("a database");
    database.execute_batch("INSERT INTO session (name) VALUES ('a-part')").expect("planted");
    database
        .execute_batch("PRAGMA foreign_keys = OFF; INSERT INTO held_value VALUES (99, printf('%064d', 0), 1, 1)")
        .expect("planted");
    assert_eq!(damage(&data), ["a-part", "a row of held_value of no session"], "planted damage is seen");
}
