//! Replay refuses logs that were changed by hand and names the record.

use document::{AssetHash, Change, Command, EditError};
use edit::{Action, EditRefusal, EditRequest, Record, ReplayError, Session, UndoScope};
use light::parameters::CONE_ANGLE;
use light::{LightId, Value};

use crate::support::{SCENES, TestSession, angle, insert, radius, softness};

/// Returns nine records: a scene, edits of two people, undo and redo.
fn log() -> Vec<Record> {
    let mut studio = TestSession::default();
    studio.edit("rig", Command::LoadScene { asset: SCENES[0], name: "room".into() });
    studio.edit("ada", angle(30.0));
    studio.edit("ada", angle(40.0));
    studio.edit("ben", softness(0.5));
    studio.edit("ben", insert(2));
    studio.edit("ada", radius(3, 0.5));
    studio.undo("ada");
    studio.redo("ada");
    studio.edit("ben", angle(50.0));
    studio.log
}

fn replayed(log: &[Record]) -> Result<Session, ReplayError> {
    let mut session = Session::default();
    log.iter().try_for_each(|record| session.replay(record))?;
    Ok(session)
}

/// Replays the log with a fault and returns the error.
fn with(fault: impl Fn(&mut Vec<Record>)) -> ReplayError {
    let mut log = log();
    replayed(&log).expect("without the fault");
    fault(&mut log);
    replayed(&log).expect_err("a planted fault")
}

/// Rules: REC-1
#[test]
fn gaps_and_repetitions_are_refused() {
    assert_eq!(with(|log| drop(log.remove(3))), ReplayError::Gap { found: 5, after: 3 });
    assert_eq!(with(|log| log.swap(3, 4)), ReplayError::Gap { found: 5, after: 3 });
    assert_eq!(with(|log| log.insert(4, log[3].clone())), ReplayError::Gap { found: 4, after: 4 });
    assert_eq!(with(|log| drop(log.remove(0))), ReplayError::Gap { found: 2, after: 0 });
    assert_eq!(with(|log| log[0].seq = u64::MAX), ReplayError::Gap { found: u64::MAX, after: 0 });
}

/// Rules: REC-3
#[test]
fn values_that_do_not_follow_are_refused() {
    let parameter = |old, new| {
        let (old, new) = (Value::Number(old), Value::Number(new));
        vec![Change::LightParameter { light: LightId(1), parameter: CONE_ANGLE.row(), old, new }]
    };
    let conflict = |error: ReplayError, at: u64| {
        let is_conflict = matches!(&error, ReplayError::Record { seq, reason: EditError::Conflict(_) } if *seq == at);
        assert!(is_conflict, "{error}");
    };
    conflict(with(|log| log[2].changes = parameter(31.0, 40.0)), 3);
    conflict(with(|log| log[1].changes = parameter(25.0, 31.0)), 3);
    conflict(with(|log| log[1].changes.clear()), 3);
    // Two records that are swapped with their sequences: each starts from the values that the other leaves.
    conflict(
        with(|log| {
            log.swap(1, 2);
            (log[1].seq, log[2].seq) = (2, 3);
        }),
        2,
    );
    let invalid = with(|log| log[8].changes = parameter(40.0, 90.0));
    assert!(matches!(invalid, ReplayError::Record { seq: 9, reason: EditError::InvalidLight { .. } }), "{invalid}");
}

/// Rules: UNDO-1, UNDO-3
#[test]
fn undo_of_what_is_not_in_effect_is_refused() {
    let undo = |target| Action::Undo { scope: UndoScope::Mine, target, skipped: Vec::new() };
    let redo = |target| Action::Redo { scope: UndoScope::Mine, target, skipped: Vec::new() };
    assert_eq!(with(|log| log[6].action = undo(99)), ReplayError::TargetNotInEffect { seq: 7, target: 99 });
    assert_eq!(with(|log| log[6].action = undo(7)), ReplayError::TargetNotInEffect { seq: 7, target: 7 });
    assert_eq!(with(|log| log[7].action = redo(6)), ReplayError::TargetNotInEffect { seq: 8, target: 6 });
    assert_eq!(with(|log| log[7].action = undo(6)), ReplayError::TargetNotInEffect { seq: 8, target: 6 });
}

/// Replay needs no scene. The document names the scene that a renderer needs.
///
/// Rules: LOG-3, CMD-6
#[test]
fn a_scene_that_is_missing_is_named() {
    let nowhere = AssetHash([9; 32]);
    let load = Command::LoadScene { asset: nowhere, name: "nowhere".into() };
    let mut studio = TestSession::new();
    let before = (studio.hash(), studio.session.seq());
    let missing = studio.ask("ada", EditRequest::Edit { base_seq: None, command: load }).expect_err("no scene");
    assert_eq!(missing, EditRefusal::Edit(EditError::UnknownAsset(nowhere)));
    assert!(missing.to_string().contains(&nowhere.hex()));
    assert_eq!((studio.hash(), studio.session.seq()), before);

    let session = replayed(&log()[..1]).expect("a sound log");
    assert_eq!(session.document().scene().map(|scene| scene.asset), Some(SCENES[0]));
}

/// Rules: REC-3, CMD-1
#[test]
fn a_refused_record_leaves_the_session_as_it_was() {
    let log = log();
    let mut session = replayed(&log[..6]).expect("a sound log");
    let (before, seq) = (session.document().hash(), session.seq());
    let mut bad = log[6].clone();
    bad.action = Action::Undo { scope: UndoScope::Mine, target: 99, skipped: Vec::new() };
    session.replay(&bad).expect_err("a bad target");
    let mut bad = log[6].clone();
    bad.changes[0] = bad.changes[0].inverse();
    session.replay(&bad).expect_err("a bad value");
    assert_eq!((session.document().hash(), session.seq()), (before, seq));
    for record in &log[6..] {
        session.replay(record).expect("it goes on where it stood");
    }
    assert_eq!(session.document().hash(), replayed(&log).expect("a sound log").document().hash());
}
