//! `bendylights backup` during edits, and killed at any moment.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs};

use bench::ServerProcess;
use document::AssetHash;
use protocol::{EditResults, SessionState, parse_body};
use serde_json::json;
use store::Store;

use crate::program::program;
use crate::sessions::support::Server;

/// Acknowledged edits per second.
const EDITS_A_SECOND: u32 = 60;
const BACKUPS: u64 = 5;
/// Number of kills of backups and of restores. A copy waits for the disk a dozen times; `BENDYLIGHTS_KILLS=200` takes
/// minutes.
const KILLS: u32 = 20;

/// A copy of a folder, file by file into its final place, that takes at least 20 ms a file on every machine: `cp` can be
/// over before the first kill.
const COPY_IN_PLACE: &str = "
import shutil, sys, time
shutil.copytree(sys.argv[1], sys.argv[2], copy_function=lambda a, b: (time.sleep(0.02), shutil.copy2(a, b)))
";

/// Starts a copy of `data` to `to`.
fn backup(data: &Path, to: &Path) -> Child {
    let mut command = Command::new(program());
    command.args(["backup", "--quiet", "--data"]).arg(data).arg(to).stdout(Stdio::null());
    command.spawn().expect("the program runs")
}

fn back_up(data: &Path, to: &Path) {
    assert!(backup(data, to).wait().expect("it ends").success(), "{}", to.display());
}

/// Rules: SOCK-4, LOG-1
#[test]
fn a_backup_under_60_edits_a_second_holds_all_that_was_acknowledged_before() {
    let server = Server::start();
    let uploaded = server.address.post("/assets?name=room", &assets::demo_bytes("arbor").expect("a demo"));
    assert_eq!(uploaded.expect("answered").status, 201);
    let light = server.connect("setup").light();
    let (acknowledged, is_over) = (AtomicU64::new(1), AtomicBool::new(false));
    let folder = tempfile::tempdir().expect("a folder");
    let copy = |round: u64| folder.path().join(format!("copy-{round}"));
    std::thread::scope(|scope| {
        let edits = scope.spawn(|| {
            let began = Instant::now();
            let mut count = 0;
            while !is_over.load(Ordering::Relaxed) {
                let parameter = json!({"exposure": f64::from(count % 100) / 100.0});
                let command = json!({"type": "setLight", "light": light, "parameter": parameter});
                let answer = server.post("/sessions/main/edits", &json!({"edits": [{"command": command}]}));
                let results: EditResults = parse_body(&answer.text()).expect("results");
                acknowledged.store(results.seq, Ordering::SeqCst);
                count += 1;
                let next = Duration::from_secs(1) * count / EDITS_A_SECOND;
                std::thread::sleep(next.saturating_sub(began.elapsed()));
            }
            f64::from(count) / began.elapsed().as_secs_f64()
        });
        for round in 0..BACKUPS {
            std::thread::sleep(Duration::from_millis(400));
            let before = acknowledged.load(Ordering::SeqCst);
            back_up(server.data.path(), &copy(round));
            let found = Store::open(&copy(round)).expect("a copy").session("main").expect("a session").seq;
            let after = acknowledged.load(Ordering::SeqCst) + 1;
            assert!((before..=after).contains(&found), "{found}, and {before} to {after} were acknowledged");
            assert!(before > round, "edits go on: {before}");
        }
        is_over.store(true, Ordering::Relaxed);
        eprintln!("{:.0} edits a second", edits.join().expect("a thread"));
    });

    // A copy can be served like any other folder, and has the document at the time of the copy.
    let last = copy(BACKUPS - 1);
    let row = Store::open(&last).expect("a copy").session("main").expect("a session");
    let restored = ServerProcess::start(program(), &last, &[]).expect("started");
    let state: SessionState = parse_body(&restored.get("/sessions/main").expect("answered").text()).expect("a session");
    assert_eq!((state.seq, state.hash), (row.seq, row.hash));
}

/// Makes a data folder with a log and some scenes.
fn make_data(data: &Path) {
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("logs/format-4.jsonl");
    let mut import = Command::new(program());
    let imported = import.args(["import", "--quiet", "--data"]).arg(data).arg(log).stdout(Stdio::null()).status();
    assert!(imported.expect("it runs").success());
    let store = Store::open(data).expect("a store");
    for number in 0..3_u8 {
        store.assets.put(&vec![number; 1 << 20]).expect("an asset");
    }
}

/// Sessions with their hashes, and the number of complete scenes; `None` for a folder that is no data folder.
fn holds(data: &Path) -> Option<(BTreeMap<String, String>, usize)> {
    let store = Store::open(data).ok()?;
    let rows = store.sessions().ok()?.into_iter().map(|row| store.session(&row.name));
    let rows = rows.collect::<Result<Vec<_>, _>>().ok()?;
    let sessions = rows.into_iter().map(|row| (row.name.clone(), store.replay(&row.name, None).map(|_| row.hash)));
    let sessions = sessions.map(|(name, hash)| Some((name, hash.ok()?))).collect::<Option<_>>()?;
    let hashes = fs::read_dir(data.join("assets")).ok()?.map(|file| file.expect("a file").file_name());
    let whole = hashes.filter(|hash| {
        let hash = hash.to_str().and_then(|hash| format!("sha256:{hash}").parse::<AssetHash>().ok());
        hash.is_some_and(|hash| store.assets.bytes(&hash).is_ok_and(|bytes| bytes.is_some()))
    });
    Some((sessions, whole.count()))
}

/// Starts backups and kills each at a different time, up to a little after its usual end, and later if the
/// machine is so slow that all were killed before. Returns the number of copies that left something, and of those among
/// them that are not complete.
fn kill_backups(data: &Path, to: &Path, count: u32) -> (u32, u32) {
    let whole = holds(data).expect("data");
    let began = Instant::now();
    assert!(backup(data, to).wait().expect("it ends").success());
    let (took, mut left, mut damaged) = (began.elapsed(), 0, 0);
    for kill in 0..10 * count {
        if kill >= count && left > 0 {
            break;
        }
        if to.exists() {
            fs::remove_dir_all(to).expect("removed");
        }
        let mut copy = backup(data, to);
        std::thread::sleep(took.mul_f64(1.2 * f64::from(kill) / f64::from(count)));
        copy.kill().expect("killed");
        copy.wait().expect("it ends");
        if to.exists() {
            left += 1;
            damaged += u32::from(holds(to).as_ref() != Some(&whole));
        }
    }
    (left, damaged)
}

/// Rules: LOG-1
#[test]
fn a_backup_and_its_restore_that_are_killed_anywhere_leave_all_or_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let [data, copy, again] = ["data", "copy", "again"].map(|name| folder.path().join(name));
    make_data(&data);
    let kills = env::var("BENDYLIGHTS_KILLS").map_or(KILLS, |kills| kills.parse().expect("a number"));
    let check = |from: &Path, to: &Path| {
        let (left, damaged) = kill_backups(from, to, kills);
        eprintln!("{kills} kills: {left} copies were whole by then");
        assert_eq!(damaged, 0, "of {left} that were left");
        assert!((1..kills).contains(&left), "some were killed before they were done, some after: {left}");
        // The next copy removes the rest of the killed ones.
        let _ = fs::remove_dir_all(to);
        back_up(from, to);
        assert_eq!(holds(to), holds(from));
    };
    check(&data, &copy);
    fs::remove_dir_all(&data).expect("all is lost");
    check(&copy, &again);
    let mut names: Vec<_> =
        fs::read_dir(folder.path()).expect("a folder").map(|file| file.expect("a file").file_name()).collect();
    names.sort();
    assert_eq!(names, ["again", "copy"]);
    // The planted fault: a copy file by file into the final place is detected. It is killed once its folder is there.
    let in_place = folder.path().join("in-place");
    let mut python = Command::new("python3");
    python.args(["-c", COPY_IN_PLACE]).args([&copy, &in_place]);
    let mut copying = python.spawn().expect("python3: `apt-get install python3` brings it");
    while !in_place.exists() {
        assert_eq!(copying.try_wait().expect("a process"), None, "it ended without a copy");
        std::thread::sleep(Duration::from_millis(1));
    }
    copying.kill().expect("killed");
    copying.wait().expect("it ends");
    assert_ne!(holds(&in_place), holds(&copy), "a copy in place was whole at once");
}
