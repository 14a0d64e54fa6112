//! Power cuts: acknowledged edits survive, and the log replays to the same document.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command as Program;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use bench::{Client, Incoming, ServerAddress};
use light::parameters::RADIUS;
use protocol::{
    ClientMessage, Command, Drag, DragChoice, DragKind, DragRadii, ErrorCode, LogLine, LogReader, ServerMessage,
};

use crate::processes::output_of;
use crate::program::program;
use crate::sessions::support::{Server, rejected};

const CLIENTS: u64 = 4;
const EDITS: u64 = 1_000;
const KILLS: u64 = 5;
/// Edits in flight per client.
const UNDER_WAY: usize = 4;
/// One in so many edits is the drag of a feature, which is solved for many times as long as others take.
const DRAG_EVERY: u64 = 20;

/// State shared by the clients: the answers that they got, and the address of the server.
struct Shared {
    address: Mutex<ServerAddress>,
    /// Sequence number of each acknowledged operation.
    acknowledged: Mutex<BTreeMap<String, u64>>,
    next_edit: AtomicU64,
    /// Light that most edits change, and the light whose pool is dragged.
    light: u64,
    lamp: u64,
    camera: protocol::Camera,
}

/// Rules: SOCK-4, REC-1, REC-4, LOG-1, LOG-2
#[test]
fn acknowledged_edits_survive_kills_at_random_moments() {
    // The times differ from run to run on purpose; the tested properties do not depend on them.
    let seed = Instant::now().elapsed().subsec_nanos() ^ std::process::id();
    eprintln!("seed {seed}");
    let mut server = Server::start_process();
    let mut setup = server.connect("setup");
    let lamp = setup.add_lamp(60.0, 30.0);
    let shared = &Shared {
        address: Mutex::new(server.address.clone()),
        acknowledged: Mutex::default(),
        next_edit: AtomicU64::new(0),
        light: setup.light(),
        lamp,
        camera: setup.document.cameras().values().next().expect("the demo has a camera").into(),
    };
    let mut random = u64::from(seed) | 1;
    let server = std::thread::scope(|scope| {
        for number in 0..CLIENTS {
            scope.spawn(move || run_client(number, shared));
        }
        for kill in 1..=KILLS {
            // A random time within the next share of the edits.
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let target = EDITS * kill / (KILLS + 1) + (random >> 33) % (EDITS / (2 * KILLS));
            while (shared.acknowledged.lock().expect("no panic").len() as u64) < target {
                std::thread::sleep(Duration::from_micros(random >> 52));
            }
            server = server.restart();
            shared.address.lock().expect("no panic").clone_from(&server.address);
        }
        server
    });

    let acknowledged = shared.acknowledged.lock().expect("no panic").clone();
    assert_eq!(acknowledged.len() as u64, EDITS);
    let (seq, hash) = server.state();
    assert_eq!(seq, EDITS + 2, "each edit once, after the scene and the lamp");

    // A last restart, from the disk alone.
    let (process, data) = server.into_process();
    process.kill().expect("killed");
    let log = data.path().join("main.jsonl");
    let command = |arguments: &[&str]| {
        let mut command = Program::new(program());
        command.args(arguments).arg("--data").arg(data.path());
        command
    };
    output_of(command(&["export", "main"]).arg("-o").arg(&log));
    check_log(&log, &acknowledged, &hash);
    let replayed = output_of(command(&["replay"]).arg(&log));
    let result: serde_json::Value = serde_json::from_str(&replayed).expect("JSON");
    assert_eq!(result["hash"], hash.as_str());
    assert_eq!((result["records"].as_u64(), result["checkpoints_ok"].as_bool()), (Some(seq), Some(true)));
}

/// Makes edits until there are enough. Reconnects if the server is killed meanwhile.
fn run_client(number: u64, shared: &Shared) {
    let mut open: BTreeMap<String, u64> = BTreeMap::new();
    loop {
        let address = shared.address.lock().expect("no panic").clone();
        let Ok(mut client) = Client::connect(&address, "main", &format!("client-{number}"), None) else {
            std::thread::sleep(Duration::from_millis(5));
            continue;
        };
        // Edits that were in flight when the server was killed are sent again, with the same operation ids.
        let resent = open.iter().all(|(op_id, edit)| send(&mut client, shared, op_id, *edit).is_ok());
        if resent && serve_edits(&mut client, shared, number, &mut open) {
            return;
        }
    }
}

/// True if all edits are done, false if the connection broke.
fn serve_edits(client: &mut Client, shared: &Shared, number: u64, open: &mut BTreeMap<String, u64>) -> bool {
    loop {
        while open.len() < UNDER_WAY {
            let edit = shared.next_edit.fetch_add(1, Ordering::Relaxed);
            if edit >= EDITS {
                break;
            }
            let op_id = format!("{number}-{edit}");
            open.insert(op_id.clone(), edit);
            if send(client, shared, &op_id, edit).is_err() {
                return false;
            }
        }
        if open.is_empty() {
            return true;
        }
        match client.receive(Duration::from_millis(200)) {
            Ok(Some(Incoming::Message(message))) => {
                let ServerMessage::EditResult(result) = *message else { continue };
                let Some(seq) = result.outcome.seq() else {
                    // Somebody else dragged the lamp meanwhile, again and again.
                    assert_eq!(rejected(&result.outcome).code, ErrorCode::KeepsChanging, "{result:?}");
                    if send(client, shared, &result.op_id, open[&result.op_id]).is_err() {
                        return false;
                    }
                    continue;
                };
                open.remove(&result.op_id);
                let mut acknowledged = shared.acknowledged.lock().expect("no panic");
                let before = acknowledged.insert(result.op_id, seq);
                assert!(before.is_none_or(|before| before == seq), "one operation, one record");
            }
            Ok(_) => {}
            Err(_) => return false,
        }
    }
}

fn send(client: &mut Client, shared: &Shared, op_id: &str, edit: u64) -> Result<(), bench::BenchError> {
    let command = if edit.is_multiple_of(DRAG_EVERY) { drag(shared, edit) } else { set_radius(shared, edit) };
    let base_seq = client.welcome.seq;
    client.send(&ClientMessage::Edit { op_id: op_id.to_owned(), base_seq, command })
}

fn set_radius(shared: &Shared, edit: u64) -> Command {
    let radius = 1.5 + 0.0001 * edit as f64;
    let parameter = RADIUS.to(radius).into();
    Command::SetPoint { light: shared.light, point: 2, parameter, ignore_pins: false }
}

/// Moves the lamp's pool on the table to and fro, a pixel each time, so that the lamp stays near where it was.
fn drag(shared: &Shared, edit: u64) -> Command {
    let from = [300.5, 320.5];
    let by = if edit.is_multiple_of(2 * DRAG_EVERY) { 1.0 } else { -1.0 };
    Command::DragFeature(Box::new(Drag {
        light: shared.lamp,
        kind: DragKind::Hotspot,
        points: None,
        radii: DragRadii::Keep,
        camera: shared.camera.clone(),
        size: [640, 360],
        from,
        to: [from[0] + by, from[1]],
        pins: None,
        alternative: Some(DragChoice::Best),
        alternatives: false,
        source_outside: None,
    }))
}

/// Tests that the log has every acknowledged operation at its acknowledged position, and that the last checkpoint has
/// the server's hash.
fn check_log(log: &Path, acknowledged: &BTreeMap<String, u64>, hash: &str) {
    let text = std::fs::read_to_string(log).expect("a log");
    let mut found = BTreeMap::new();
    let mut last_hash = String::new();
    let mut reader = LogReader::default();
    for line in text.lines().skip(1) {
        match reader.read(line).expect("a line") {
            LogLine::Record(record) => drop(found.insert(record.op_id, record.seq)),
            LogLine::Checkpoint(checkpoint) => last_hash = checkpoint.hash,
        }
    }
    let missing = |found: &BTreeMap<String, u64>| {
        acknowledged.iter().filter(|(op_id, seq)| found.get(*op_id) != Some(seq)).count()
    };
    assert_eq!(missing(&found), 0);
    assert_eq!(last_hash, hash);
    let lost = acknowledged.keys().next().expect("an edit").clone();
    found.remove(&lost);
    assert_eq!(missing(&found), 1, "a planted loss is seen");
}
