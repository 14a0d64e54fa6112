//! Sessions: their names, their epochs, and folders that hold none.

use store::{MAX_NAME_CHARS, Store, StoreError};

use crate::support::{Folder, empty_hash};

/// Rules: SOCK-2
#[test]
fn sessions_are_listed_by_name_and_have_epochs_of_their_own() {
    let folder = Folder::new();
    let mut store = folder.store();
    assert_eq!(store.sessions().expect("a list"), []);
    let epochs = ["main", "b.2", "A_1-x"].map(|name| store.create_session(name).expect("a new name"));
    assert!(epochs.iter().all(|epoch| epoch.len() == 32), "128 bits: {epochs:?}");
    assert!(epochs[0] != epochs[1] && epochs[1] != epochs[2] && epochs[0] != epochs[2]);
    let rows = store.sessions().expect("a list");
    let names: Vec<_> = rows.iter().map(|row| row.name.as_str()).collect();
    assert_eq!(names, ["A_1-x", "b.2", "main"]);
    assert_eq!((rows[2].seq, &rows[2].hash, &rows[2].epoch), (0, &empty_hash(), &epochs[0]));
    drop(store);
    let again = Store::open(&folder.data()).expect("a store");
    assert_eq!(again.session("main").expect("it stays"), rows[2], "an epoch outlives a restart");
}

/// Rules: HTTP-4
#[test]
fn names_that_are_taken_or_unfit_are_refused() {
    let mut store = Folder::new().store();
    let longest = "x".repeat(MAX_NAME_CHARS);
    store.create_session(&longest).expect("64 characters");
    assert!(matches!(store.create_session(&longest), Err(StoreError::Exists(_))));
    for name in ["", ".", "-a", "_a", "a b", "a/b", "../a", "a\n", "ä", &format!("{longest}x")] {
        let refused = store.create_session(name).expect_err(name);
        assert_eq!(refused.code(), "badName", "{name:?}: {refused}");
    }
    assert_eq!(store.session("no").expect_err("none").code(), "notFound");
    assert_eq!(store.sessions().expect("a list").len(), 1);
}

#[test]
fn a_folder_without_data_is_not_made_by_looking() {
    let folder = Folder::new();
    assert!(matches!(Store::open(&folder.data()), Err(StoreError::NoData(_))));
    assert!(!folder.data().exists());
}

#[test]
fn a_database_of_a_newer_program_is_left_alone() {
    let folder = Folder::new();
    drop(folder.store());
    let database = rusqlite::Connection::open(folder.data().join("bendylights.sqlite")).expect("a database");
    database.execute_batch("PRAGMA user_version = 2").expect("a pragma");
    drop(database);
    assert!(matches!(Store::create(&folder.data()), Err(StoreError::Newer { found: 2, .. })));
    assert!(matches!(Store::open(&folder.data()), Err(StoreError::Newer { found: 2, .. })));
}
