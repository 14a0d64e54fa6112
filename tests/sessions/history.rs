//! The next undo and redo steps, which clients are told in advance.

use light::parameters::{CONE_ANGLE, CONE_SOFTNESS, RADIUS};
use protocol::{ClientMessage, Command, ErrorCode, History, Problem, Scope, ServerMessage};

use crate::sessions::support::{Mirror, Server, committed, rejected, rename};

fn history(mirror: &mut Mirror) -> History {
    mirror.send(&ClientMessage::History {});
    mirror.wait_for("a history", |message| match message {
        ServerMessage::History(history) => Some(History::clone(history)),
        _ => None,
    })
}

/// Record that record `seq` undoes.
fn target(server: &Server, seq: u64) -> u64 {
    let log = server.get(&format!("/sessions/main/log?from={seq}&limit=1"));
    let record: serde_json::Value = serde_json::from_str(&log.text()).expect("a record");
    record["action"]["target"].as_u64().expect("an undo's or a redo's target")
}

/// Rules: UNDO-8
#[test]
fn the_history_names_the_step_the_light_and_the_actor() {
    let (_server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let at_first = history(&mut ada);
    assert_eq!((at_first.undo.mine, at_first.redo.mine, at_first.redo.session), (None, None, None));
    let first = at_first.undo.session.expect("the scene was loaded");
    assert_eq!(first.what, "loading “demo:vases”");

    ada.edited(rename(ada.light(), "sun"));
    ben.edited(Command::SetPoint {
        light: ben.light(),
        point: 2,
        parameter: RADIUS.to(1.5).into(),
        ignore_pins: false,
    });
    ada.catch_up(ben.seq);
    let both = history(&mut ada);
    assert_eq!(both.seq, ada.seq);
    let (mine, all) = (both.undo.mine.expect("hers"), both.undo.session.expect("his"));
    assert_eq!((mine.what.as_str(), mine.actor.id.as_str()), ("the name of “sun”", "ada"));
    assert_eq!((all.what.as_str(), all.actor.id.as_str()), ("the radius of control point 2 of “sun”", "ben"));

    ada.undo(Scope::Session);
    let undone = history(&mut ada);
    let redo = undone.redo.session.expect("it can be redone");
    assert_eq!((redo.what, redo.actor.id.as_str()), (all.what, "ben"));
    assert_eq!((undone.redo.mine, undone.undo.session), (None, Some(mine)));
}

/// The announced step is the one that undo then takes back, until none is left and over a restart; steps that later
/// records of others have overtaken are not announced.
///
/// Rules: UNDO-8, UNDO-7, UNDO-5
#[test]
fn undo_takes_the_step_that_the_history_names() {
    let (server, [mut ada, mut ben]) = Server::start_process().with(["ada", "ben"]);
    let light = ada.light();
    let angle = |degrees| Command::SetLight { light, parameter: CONE_ANGLE.to(degrees).into(), ignore_pins: false };
    let softness = |share| Command::SetLight { light, parameter: CONE_SOFTNESS.to(share).into(), ignore_pins: false };
    for command in [angle(31.0), softness(0.4), angle(32.0), rename(light, "sun"), angle(33.0), softness(0.5)] {
        ada.edited(command);
    }
    ben.catch_up(ada.seq);
    ben.edited(angle(20.0));
    let server = server.restart();
    let mut ada = server.connect("ada");
    let mut taken = Vec::new();
    while let Some(step) = history(&mut ada).undo.mine {
        let undone = ada.undo(Scope::Mine);
        assert_eq!(target(&server, committed(&undone)), step.seq);
        taken.push((step.what, step.passed));
    }
    let overtaken = |light: &str| vec![format!("ben has changed the cone angle of “{light}” since")];
    let expected = [
        ("the cone softness of “sun”", Vec::new()),
        ("the name of “sun”", overtaken("sun")),
        ("the cone softness of “key”", overtaken("key")),
    ];
    assert_eq!(taken, expected.map(|(what, passed)| (what.to_owned(), passed)));
    let seq = ada.seq;
    let refused = ada.undo(Scope::Mine);
    let Problem { code, message } = rejected(&refused);
    let sentence = "there is nothing to undo: ben has changed the cone angle of “key” since";
    assert_eq!((*code, message.as_str()), (ErrorCode::NothingToUndo, sentence));
    assert_eq!(server.state().0, seq, "it is no step");
}
