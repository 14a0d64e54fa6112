//! Backups: complete with everything acknowledged before, or not there.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;

use protocol::ErrorCode;
use store::{Backup, CommitBatch, Store, back_up};

use crate::support::{Folder, Log, stored_log};

/// Returns the names in the folder that holds the data and its backups.
fn names(folder: &Folder) -> Vec<String> {
    let parent = folder.data().parent().expect("a parent").to_owned();
    let files = fs::read_dir(parent).expect("a folder");
    let mut names: Vec<_> = files.map(|file| file.expect("a file").file_name().display().to_string()).collect();
    names.sort();
    names
}

fn seq(data: &Path) -> u64 {
    Store::open(data).expect("a backup").session("main").expect("a session").seq
}

#[test]
fn a_backup_is_a_data_folder_of_its_own() {
    let folder = Folder::new();
    let mut store = folder.store();
    let log = stored_log(&mut store, "main", 40);
    stored_log(&mut store, "second", 3);
    let asset = store.assets.put(b"room").expect("a file");
    store.assets.set_name(&asset, "Room").expect("a name");
    fs::write(folder.data().join("assets/.incoming-left"), "half").expect("a leftover");
    let to = folder.data().with_file_name("copy");
    let (mut told, mut all) = (0, 0);
    let backup = back_up(&folder.data(), &to, |step, bytes| (told, all) = (told + step, bytes)).expect("backed up");
    assert_eq!(backup, Backup { sessions: 2, records: 42 + 5, files: 2, bytes: all });
    assert_eq!(told, all, "all of it was told");
    // The open store continues, and the copy has nothing of that.
    stored_log(&mut store, "third", 3);
    let copy = Store::open(&to).expect("a store");
    let names: Vec<_> = copy.sessions().expect("a list").into_iter().map(|row| row.name).collect();
    assert_eq!(names, ["main", "second"]);
    assert_eq!(copy.replay("main", None).expect("a log").document().hash(), log.hash());
    assert_eq!(copy.assets.bytes(&asset).expect("whole").as_deref(), Some(&b"room"[..]));
    assert_eq!(copy.assets.name_of(&asset).expect("whole").as_deref(), Some("Room"));
    assert_eq!(fs::read_dir(to.join("assets")).expect("a folder").count(), 2, "no leftovers");
    for (file, mode) in [("", 0o700), ("bendylights.sqlite", 0o600), ("assets", 0o700)] {
        let found = fs::metadata(to.join(file)).expect("there").permissions().mode() & 0o777;
        assert_eq!(found, mode, "{file:?}: for nobody but its owner");
    }
}

#[test]
fn a_backup_is_never_written_over_and_leaves_nothing_where_it_fails() {
    let folder = Folder::new();
    let to = folder.data().with_file_name("copy");
    let refused = |to: &Path| back_up(&folder.data(), to, |_, _| {}).expect_err("refused");
    assert!(refused(&to).to_string().contains("holds no sessions"), "there is nothing to copy");
    let mut store = folder.store();
    stored_log(&mut store, "main", 3);
    for (path, file) in [("full", "full/notes.txt"), ("file", "file")] {
        let to = folder.data().with_file_name(path);
        let file = folder.data().with_file_name(file);
        if path != file.file_name().expect("a name") {
            fs::create_dir(&to).expect("a folder");
        }
        fs::write(&file, "mine").expect("a file");
        let refused = refused(&to);
        assert_eq!(refused.code(), ErrorCode::Storage);
        assert!(refused.to_string().contains("never written over"), "{refused}");
        assert_eq!(fs::read_to_string(&file).expect("still there"), "mine");
    }
    // A database of a newer version is refused.
    let newer = folder.database();
    newer.pragma_update(None, "user_version", 99).expect("a pragma");
    assert!(refused(&to).to_string().contains("schema 99"));
    newer.pragma_update(None, "user_version", 4).expect("a pragma");
    // A damaged page in the middle of the file.
    stored_log(&mut store, "second", 400);
    drop((store, newer));
    let database = folder.data().join("bendylights.sqlite");
    let mut bytes = fs::read(&database).expect("a file");
    let middle = bytes.len() / 2 / 4096 * 4096;
    bytes[middle..middle + 512].fill(0xA5);
    fs::write(&database, &bytes).expect("a planted fault");
    let damaged = back_up(&folder.data(), &to, |_, _| {});
    assert!(damaged.is_err(), "{damaged:?}");
    assert_eq!(names(&folder), ["data", "file", "full"], "nothing is left");
}

#[test]
fn leftovers_of_a_killed_backup_are_removed_and_one_in_progress_is_not() {
    let folder = Folder::new();
    stored_log(&mut folder.store(), "main", 3);
    let left = folder.data().with_file_name(".bendylights-backup-left");
    let under_way = folder.data().with_file_name(".bendylights-backup-under-way");
    for half in [&left, &under_way] {
        fs::create_dir(half).expect("a folder");
        fs::write(half.join("bendylights.sqlite"), "half").expect("a file");
    }
    let lock = fs::File::open(&under_way).expect("a folder");
    lock.lock().expect("the lock of who is at work there");
    back_up(&folder.data(), &folder.data().with_file_name("copy"), |_, _| {}).expect("backed up");
    assert_eq!(names(&folder), [".bendylights-backup-under-way", "copy", "data"]);
}

/// One thread writes as fast as the disk allows while others back up. Each copy has everything acknowledged before it
/// began.
#[test]
fn backups_beside_a_writer_hold_all_that_was_acknowledged() {
    let folder = Folder::new();
    let mut store = folder.store();
    let log = stored_log(&mut store, "main", 20);
    let (acknowledged, is_over) = (AtomicU64::new(log.records.len() as u64), AtomicBool::new(false));
    thread::scope(|scope| {
        scope.spawn(|| {
            let mut log: Log = log;
            while !is_over.load(Ordering::Relaxed) {
                let known = log.records.len();
                log.add_long_light();
                log.undo();
                let batch = CommitBatch { records: &log.records[known..], ..log.batch("main") };
                store.append(&[batch]).expect("a commit");
                acknowledged.store(log.records.len() as u64, Ordering::SeqCst);
            }
        });
        let rounds: Vec<_> = (0..2)
            .map(|thread| {
                let (folder, acknowledged) = (&folder, &acknowledged);
                scope.spawn(move || {
                    for round in 0..10 {
                        let to = folder.data().with_file_name(format!("copy-{thread}-{round}"));
                        let before = acknowledged.load(Ordering::SeqCst);
                        back_up(&folder.data(), &to, |_, _| {}).expect("backed up");
                        let found = seq(&to);
                        assert!(found >= before, "{found} of {before}");
                        // Every record of the copy is complete, and gives the document of the copy's hash.
                        let copy = Store::open(&to).expect("a store");
                        let hash = copy.session("main").expect("a session").hash;
                        let document = copy.replay("main", None).expect("a log");
                        assert_eq!(document.document().hash().to_string(), hash);
                    }
                })
            })
            .collect();
        for round in rounds {
            round.join().expect("sound");
        }
        is_over.store(true, Ordering::Relaxed);
    });
    let last = seq(&folder.data().with_file_name("copy-0-9"));
    assert!(last > 22, "the writer got on meanwhile: {last}");
}
