//! Lights that no picture can show: refused, or left out with a note.

use std::path::Path;
use std::process::Command;

use bench::{Client, Incoming};
use protocol::{ErrorCode, LogLine, LogReader, Problem, ServerMessage};

use crate::processes::serve;
use crate::program::program;
use crate::sessions::support::{DEMO, Server, own_view, rejected, view_message};

/// Rules: CMD-2
#[test]
fn a_light_out_of_reach_is_refused_and_pictures_go_on() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    for x in [1.1e15, 3.4e38, 1e300] {
        let (light, translation) = (ada.light(), Some([x, 0.0, 0.0]));
        let refused = ada.edited(protocol::Command::PlaceLight {
            light,
            translation,
            rotation: None,
            scale: None,
            ignore_pins: false,
        });
        let Problem { code, message } = rejected(&refused);
        assert_eq!(*code, ErrorCode::InvalidLight);
        assert!(message.contains("1e15") && message.contains('`'), "{message}");
    }
    let picture = server.get("/sessions/main/render?size=64x36");
    assert_eq!((picture.status, picture.notes), (200, Vec::new()));
}

/// A log of an earlier version, with a light at 3.4e38.
fn old_log() -> String {
    let lamp = r#"{"type": "spot", "name": "moon", "transform": {"translation": [3.4e38, 0, 0], "rotation": [0, 0, 0, 1], "scale": 1}}"#;
    let record = format!(
        r#"{{"format": 1, "seq": 1, "timeMs": 1790000001717, "actor": {{"id": "ada", "name": "Ada"}}, "opId": "ada-1",
            "action": {{"type": "edit", "command": {{"type": "addLight", "light": {lamp}}}}},
            "changes": [{{"type": "light", "light": 1, "old": null, "new": {{"layout": 1, "light": {lamp}}}}}]}}"#
    );
    let record = record.replace('\n', "");
    let Ok(LogLine::Record(parsed)) = LogReader::default().read(&record) else { panic!("a record") };
    let parsed = edit::Record::try_from(*parsed).expect("a valid record");
    let mut document = document::Document::default();
    document.apply(&parsed.changes).expect("it applies");
    let hash = document.hash_of_format(1);
    format!("{{\"format\":1,\"session\":\"far\"}}\n{record}\n{{\"checkpoint\":{{\"seq\":1,\"hash\":\"{hash}\"}}}}\n")
}

/// Rules: FRAME-8
#[test]
fn a_light_of_an_old_log_is_left_out_with_a_note() {
    let data = tempfile::tempdir().expect("a folder");
    let (log, picture) = (data.path().join("far.jsonl"), data.path().join("far.png"));
    std::fs::write(&log, old_log()).expect("written");
    let store = data.path().join("data");
    let run = |arguments: &[&Path]| {
        Command::new(program()).args(arguments).arg("--data").arg(&store).output().expect("it runs")
    };
    let imported = run(&[Path::new("import"), &log]);
    assert!(imported.status.success(), "{}", String::from_utf8_lossy(&imported.stderr));
    let replayed = run(&[Path::new("replay"), &log, Path::new("--render"), &picture]);
    let said = String::from_utf8_lossy(&replayed.stderr);
    assert!(replayed.status.success() && said.contains("note: ") && said.contains("`moon`"), "{said}");

    let server = serve(&store, DEMO);
    let picture = server.get("/sessions/far/render?size=64x36").expect("answered");
    assert_eq!(picture.status, 200, "{}", picture.text());
    assert!(matches!(&picture.notes[..], [note] if note.contains("`moon`")), "{:?}", picture.notes);
    // The light itself has no picture.
    let own = server.get("/sessions/far/render?size=64x36&aov=t").expect("answered");
    assert!(own.status != 200 && own.text().contains("`moon`"), "{}", own.text());

    let mut client = Client::connect(&server.address, "far", "ada", None).expect("welcome");
    client.send(&view_message(own_view(&client), [64, 36], None, false)).expect("sent");
    let note = client.wait_for("a note", |incoming| match incoming {
        Incoming::Message(message) => match *message {
            ServerMessage::Error { message, fatal, .. } => Some((message, fatal)),
            _ => None,
        },
        Incoming::Frame(..) => None,
    });
    let (message, fatal) = note.expect("a note");
    assert!(message.contains("`moon`") && !fatal, "{message}");

    // After a move near the scene, it shines.
    let edits = r#"{"edits": [{"command": {"type": "placeLight", "light": 1, "translation": [0, 3, 0]}}]}"#;
    assert_eq!(server.post("/sessions/far/edits", edits.as_bytes()).expect("answered").status, 200);
    let picture = server.get("/sessions/far/render?size=64x36").expect("answered");
    assert_eq!((picture.status, picture.notes), (200, Vec::new()));
}
