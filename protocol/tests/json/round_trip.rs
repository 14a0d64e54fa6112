//! Tests that documents and records survive JSON bit for bit.

use document::{AssetHash, CameraId, CameraParameter, Command, CommandContext, SceneContents};
use edit::{Actor, EditRequest, EditSources, Session, UndoScope};
use proptest::collection::vec;
use proptest::prelude::*;
use protocol::{Document, ErrorCode, LogLine, LogReader, Record, Refused, SessionCheckpoint};

#[path = "../../../crates/document/tests/editing/random.rs"]
mod random;

const SCENES: &[AssetHash] = &[AssetHash([1; 32]), AssetHash([2; 32])];

/// Executes `requests`, and returns the session and the log of the valid ones.
fn logged(requests: Vec<Result<Command, UndoScope>>) -> (Session, Vec<edit::Record>) {
    let (mut session, mut log) = (Session::default(), Vec::new());
    for (index, request) in requests.into_iter().enumerate() {
        let request = match request {
            Ok(command) => {
                let command = random::with_existing_ids(command, session.document());
                EditRequest::Edit { base_seq: None, command }
            }
            Err(scope) if index % 2 == 0 => EditRequest::Undo(scope),
            Err(scope) => EditRequest::Redo(scope),
        };
        let actor = Actor { id: format!("actor {}", index % 2), name: "\u{1f4a1} \"A\"".into() };
        let time_ms = 1_790_000_000_000 + index as u64;
        let record = |seq: u64| log.get(seq as usize - 1).cloned();
        let Ok(taken_back) = session.find_revert(&request, &actor.id, &record) else { continue };
        let contents = SceneContents::default();
        let context = CommandContext { loaded: Some(&contents), ..CommandContext::default() };
        let sources = EditSources { context, reverted: taken_back };
        if let Ok(record) = session.execute_request(request, &actor, &index.to_string(), time_ms, sources) {
            log.push(record);
        }
    }
    (session, log)
}

fn requests() -> impl Strategy<Value = Vec<Result<Command, UndoScope>>> {
    let scope = prop_oneof![Just(UndoScope::Mine), Just(UndoScope::Session)];
    vec(prop_oneof![4 => random::command(SCENES).prop_map(Ok), 1 => scope.prop_map(Err)], 1..40)
}

fn through_json(record: &edit::Record) -> edit::Record {
    let line = LogLine::Record(Box::new(record.into())).to_json();
    assert!(!line.contains('\n'), "a record is a line");
    let read = LogReader::default().read(&line).expect("what was written");
    let LogLine::Record(read) = read else { panic!("a record") };
    (*read).try_into().expect("a sound record")
}

proptest! {
    /// Rules: LOG-1, LOG-2, REC-2
    #[test]
    fn a_log_survives_json(requests in requests()) {
        let (session, log) = logged(requests);
        let mut replayed = Session::default();
        for record in &log {
            let read = through_json(record);
            prop_assert_eq!(&read, record);
            replayed.replay(&read).expect("the same log");
        }
        prop_assert_eq!(replayed.document().hash(), session.document().hash());
    }

    /// Rules: REC-2, UNDO-1
    #[test]
    fn a_session_survives_json(requests in requests()) {
        let session = logged(requests).0;
        let checkpoint = SessionCheckpoint::from(&session);
        let read: SessionCheckpoint = protocol::parse_body(&checkpoint.to_json()).expect("what was written");
        prop_assert_eq!(&read, &checkpoint);
        let read = read.into_domain().expect("a sound session");
        prop_assert_eq!((read.seq(), read.session_history()), (session.seq(), session.session_history()));
        prop_assert_eq!(read.document().hash(), session.document().hash());
        prop_assert_eq!(read.document().last_number(), session.document().last_number());
    }

    /// Rules: DOC-1, DOC-4
    #[test]
    fn a_document_survives_json(requests in requests()) {
        let document = logged(requests).0.document().clone();
        let text = serde_json::to_string(&Document::from(&document)).expect("plain data");
        let wire: Document = protocol::parse_body(&text).expect("what was written");
        prop_assert!(wire.lights.is_sorted_by_key(|light| light.id));
        prop_assert!(wire.cameras.is_sorted_by_key(|camera| camera.id));
        let read = wire.into_domain(0).expect("a sound document");
        prop_assert_eq!(read.hash(), document.hash());
        prop_assert_eq!((read.lights(), read.cameras()), (document.lights(), document.cameras()));
        prop_assert_eq!(read.scene(), document.scene());
    }

    /// Covers every finite number.
    ///
    /// Rules: LOG-2
    #[test]
    fn a_number_keeps_its_bits(bits in any::<u64>(), place in 0..3_usize) {
        let number = f64::from_bits(bits);
        prop_assume!(number.is_finite());
        let mut vector = [0.5; 3];
        vector[place] = number;
        let parameter = CameraParameter::Translation(vector.into());
        let command = Command::SetCamera { camera: CameraId(1), parameter };
        let text = serde_json::to_string(&protocol::Command::from(&command)).expect("plain data");
        let read: protocol::Command = protocol::parse_body(&text).expect("what was written");
        let Ok(Command::SetCamera { parameter: CameraParameter::Translation(read), .. }) = read.try_into() else {
            panic!("another command");
        };
        prop_assert_eq!(read[place].to_bits(), bits);
    }
}

/// The comparisons above detect the smallest difference.
///
/// Rules: DOC-4, LOG-2
#[test]
fn a_planted_bit_is_seen() {
    let light = |angle: &str| {
        let text = format!(
            r#"{{"scene": null, "cameras": [], "lights": [{{"id": 1, "layout": 1, "light":
                {{"type": "spot", "coneAngle": {angle}}}}}]}}"#
        );
        let wire: Document = protocol::parse_body(&text).expect("a document");
        wire.into_domain(0).expect("a sound document").hash()
    };
    assert_eq!(light("30"), light("30.0"));
    assert_eq!(light("30.000000000000004"), light("3.0000000000000004e1"));
    assert_ne!(light("30"), light("30.000000000000004"), "the next number after 30");
}

/// Rules: CMD-2, DOC-5, CMD-6
#[test]
fn commands_without_a_meaning_are_refused() {
    let command = |text: &str| {
        let wire: protocol::Command = protocol::parse_body(text).expect("the right shape");
        Command::try_from(wire)
    };
    let fold =
        r#"{"type": "addLight", "light": {"type": "bendy", "points": [[0,0,0],[0,0,-1],[1,0,-1]], "radii": [5,5,5]}}"#;
    assert_eq!(command(fold).expect_err("it folds").code(), ErrorCode::InvalidLight);
    let unnamed = command(r#"{"type": "loadScene", "scene": "vases"}"#).expect_err("no hash");
    assert!(matches!(unnamed, Refused::Asset(_)), "{unnamed}");
}

/// Rules: REC-5
#[test]
fn a_record_of_a_later_format_is_refused_by_its_number() {
    let (_, log) = logged(vec![Ok(Command::RemoveLight(light::LightId(1))), Err(UndoScope::Mine)]);
    assert!(log.is_empty(), "nothing to remove");
    let text = r#"{"format":1,"seq":1,"timeMs":0,"actor":{"id":"a","name":""},"opId":"x",
        "action":{"type":"edit","command":{"type":"removeLight","light":1}},"changes":[]}"#;
    let record = Record::parse(text).expect("format 1");
    edit::Record::try_from(record.clone()).expect("a sound record");
    for found in ["0", "7", "4000000000"] {
        let other = text.replace("\"format\":1", &format!("\"format\":{found},\"later\":[]"));
        let said = Record::parse(&other).expect_err("another format").to_string();
        assert!(said.contains(&format!("format {found} ")), "not by the field it does not know: {said}");
    }
    let made = Record { format: 7, ..record };
    assert_eq!(edit::Record::try_from(made), Err(Refused::Format { found: 7 }));
}
