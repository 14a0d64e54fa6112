//! Several people in one session.

use light::parameters::{CONE_SOFTNESS, RADIUS};
use protocol::{ClientMessage, Command, Committed, ErrorCode, Outcome, Presence, Scope, ServerMessage};

use crate::sessions::support::{Server, committed, move_point, moved, rejected, rename};

/// Rules: SOCK-3, SOCK-4, SOCK-5, DOC-4, REC-1, REC-2
#[test]
fn two_clients_end_with_the_same_document() {
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let light = ada.light();
    let mut last = String::new();
    for step in 0..20 {
        let shift = f64::from(step) * 0.01;
        last = ada.edit(move_point(light, 2, moved(ada.point(2), [shift, 0.0, 0.0])));
        ben.edit(Command::SetLight { light, parameter: CONE_SOFTNESS.to(0.2 + shift).into(), ignore_pins: false });
    }
    ada.result(&last);
    let seq = ben.edited(rename(light, "key, by Ben")).seq().expect("committed");
    // All clients get all records, in one order; `Mirror` checks each record's hash.
    ada.catch_up(seq);
    ben.catch_up(seq);
    let (server_seq, server_hash) = server.state();
    for mirror in [&ada, &ben] {
        assert_eq!((mirror.seq, mirror.document.hash().to_string()), (server_seq, server_hash.clone()));
    }
    // One record for the scene, 20 of each client, and one name.
    assert_eq!(server_seq, 42);
}

/// Rules: SOCK-5
#[test]
fn edits_of_what_others_changed_are_rebased_and_outdated_numbers_rejected() {
    let (_server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let light = ada.light();
    let known = ben.seq;
    let insert = Command::InsertPoint {
        light,
        point: 2,
        position: None,
        radius: None,
        color: None,
        intensity: None,
        ignore_pins: false,
    };
    committed(&ada.edited(insert));
    ben.catch_up(ada.seq);

    let mut from_before = |command: Command| {
        let op_id = ben.op_id();
        ben.send(&ClientMessage::Edit { op_id: op_id.clone(), base_seq: known, command });
        ben.result(&op_id)
    };
    let stale = from_before(move_point(light, 2, [0.0, 0.0, -1.0]));
    assert_eq!(rejected(&stale).code, ErrorCode::Stale);
    let is_rebased = |outcome| matches!(outcome, Outcome::Committed(committed) if committed.rebased);
    assert!(is_rebased(from_before(rename(light, "still fine"))));
    let own = from_before(rename(light, "mine since"));
    assert!(is_rebased(own), "Ada's insertion is still unknown to the sender");
}

/// Rules: UNDO-1, UNDO-2, REC-4
#[test]
fn undo_takes_back_ones_own_and_survives_a_restart() {
    let (server, [mut ada, mut ben]) = Server::start_process().with(["ada", "ben"]);
    let light = ada.light();
    let start = ada.document.hash();
    let first_name = ada.name().to_owned();
    ada.edited(rename(light, "Ada's"));
    ben.catch_up(ada.seq);
    ben.edited(Command::SetPoint { light, point: 2, parameter: RADIUS.to(1.5).into(), ignore_pins: false });

    let server = server.restart();
    let mut ada = server.connect("ada");
    let op_id = "undo-after-restart".to_owned();
    let undo = ClientMessage::Undo { op_id: op_id.clone(), scope: Scope::Mine };
    ada.send(&undo);
    let undone = ada.result(&op_id);
    let Outcome::Committed(Committed { seq, rebased: false, skipped, .. }) = undone else { panic!("{undone:?}") };
    assert!(skipped.is_empty(), "{skipped:?}");
    assert_eq!((ada.name(), ada.radius(2)), (&*first_name, 1.5), "Ada's name is gone, Ben's radius stays");
    assert_ne!(ada.document.hash(), start);

    // The same operation again gets the first answer and is not carried out.
    ada.send(&undo);
    let again = ada.wait_for("a result", |message| match message {
        ServerMessage::EditResult(result) => Some(result.outcome.clone()),
        _ => None,
    });
    assert_eq!(committed(&again), seq);
    assert_eq!(server.state().0, seq);
}

/// Rules: SOCK-8
#[test]
fn everybody_sees_who_is_here() {
    let (_server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let light = ada.light();
    ben.send(&ClientMessage::Presence { selection: Some(light) });
    let mut wait_for_clients = |what, is_so: &dyn Fn(&[Presence]) -> bool| {
        ada.wait_for(what, |message| {
            matches!(message, ServerMessage::Presence { clients } if is_so(clients)).then_some(())
        });
    };
    wait_for_clients("Ben's selection", &|clients| {
        clients.iter().any(|client| client.actor.id == "ben" && client.selection == Some(light))
    });
    drop(ben);
    wait_for_clients("Ben's leaving", &|clients| matches!(clients, [client] if client.actor.id == "ada"));
}
