//! Drags: live for all clients, one record, and a lock that ends with the connection.

use std::time::Duration;

use glam::DVec3;
use light::parameters::RADIUS;
use protocol::{Command, DragRadii, ErrorCode, GestureStatus, Scope};

use crate::sessions::support::{Mirror, Server, committed, has_ended, move_point, moved, rejected, rename, state_of};

/// Drags control point 2 by this vector.
fn drag_point(mirror: &mut Mirror, update: u64, by: [f64; 3]) {
    mirror.update("drag", update, move_point(mirror.light(), 2, moved(mirror.point(2), by)));
}

/// Sets the radius at control point 2 in a gesture.
fn widen(mirror: &mut Mirror, update: u64, radius: f64) {
    let command =
        Command::SetPoint { light: mirror.light(), point: 2, parameter: RADIUS.to(radius).into(), ignore_pins: false };
    mirror.update("widen", update, command);
}

/// Rules: GEST-1, GEST-2, GEST-5
#[test]
fn a_drag_is_live_for_all_and_one_record() {
    let (_server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let (light, seq, start) = (ada.light(), ada.seq, ada.point(2));
    ada.begin("drag");
    for step in 1..=10 {
        drag_point(&mut ada, step, [0.0, 0.0, 0.02 * step as f64]);
    }
    let seen = state_of(&mut ben, |state| state.update == 10);
    assert_eq!((seen.light, seen.changes.len()), (light, 1));
    assert!(seen.live_revision >= 10);

    // Edits of other clients are refused, and the answer names the actor who holds the light.
    let refused = ben.edited(rename(light, "mine now"));
    let problem = rejected(&refused);
    assert_eq!(problem.code, ErrorCode::Locked);
    assert!(problem.message.contains("ada"));
    ben.begin("second");
    let refused = state_of(&mut ben, |state| state.gesture == "second");
    assert!(matches!(&refused.status, GestureStatus::Rejected(problem) if problem.code == ErrorCode::Locked));

    ada.commit("drag");
    assert_eq!(committed(&ada.result("commit")), seq + 1, "ten updates are one record");
    assert_eq!(ada.point(2), moved(start, [0.0, 0.0, 0.2]), "the last update counts");
    ben.catch_up(seq + 1);
    committed(&ben.edited(rename(light, "mine now")));
}

/// Rules: GEST-3
#[test]
fn a_drag_ends_with_its_connection() {
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    ada.begin("drag");
    drag_point(&mut ada, 1, [0.0, 0.3, 0.0]);
    state_of(&mut ben, |state| state.update == 1);
    drop(ada);
    let ended = state_of(&mut ben, has_ended);
    assert_eq!(ended.status, GestureStatus::Cancelled { refused: None });
    let (seq, hash) = server.state();
    assert_eq!((seq, hash), (ben.seq, ben.document.hash().to_string()), "the light is as it was");
    committed(&ben.edited(rename(ben.light(), "free")));
}

/// Rules: GEST-4, CMD-2
#[test]
fn a_fold_leaves_the_last_valid_state() {
    let (_server, [mut ada]) = Server::start_with(["ada"]);
    ada.begin("widen");
    let mut widened = |update: u64, radius: f64| {
        widen(&mut ada, update, radius);
        state_of(&mut ada, |state| state.update == update)
    };
    let valid = widened(1, 1.6);
    assert_eq!(valid.status, GestureStatus::Held { refused: None });
    let folded = widened(2, 50.0);
    let GestureStatus::Held { refused: Some(problem) } = folded.status else { panic!("{folded:?}") };
    assert_eq!(problem.code, ErrorCode::InvalidLight);
    assert!(problem.message.contains("folds"));
    assert_eq!(folded.changes, valid.changes, "what is shown is the last valid one");
    ada.commit("widen");
    committed(&ada.result("commit"));
    assert_eq!(ada.radius(2), 1.6);
}

/// A drag past the fold is not refused: the gesture is held, and the point goes as far as the tube can bend. If the
/// cursor comes back, so does the point, whatever the path between.
///
/// Rules: CMD-14, GEST-1, REC-2
#[test]
fn a_control_point_slides_along_the_wall() {
    let (_server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let (light, seq, start) = (ada.light(), ada.seq, ada.point(2));
    let (past_the_wall, near) = (moved(start, [0.0, 40.0, 0.0]), moved(start, [0.0, 0.0, 0.02]));
    let refused = ada.edited(move_point(light, 2, past_the_wall));
    assert!(rejected(&refused).message.contains("folds"), "there is a wall");

    ada.begin("drag");
    let mut dragged = |update: u64, position: [f64; 3], radii: DragRadii| {
        ada.update("drag", update, Command::DragPoint { light, point: 2, position, radii, ignore_pins: false });
        let state = state_of(&mut ada, |state| state.update == update || state.status.problem().is_some());
        assert_eq!(state.status, GestureStatus::Held { refused: None });
        state.changes
    };
    let there = dragged(1, near, DragRadii::Keep);
    let wall = dragged(2, past_the_wall, DragRadii::Keep);
    assert_eq!(dragged(3, near, DragRadii::Keep), there, "it comes back");
    let followed = dragged(4, past_the_wall, DragRadii::Follow);
    assert!(followed.len() > 1, "radii follow: {followed:?}");
    assert_eq!(dragged(5, past_the_wall, DragRadii::Keep), wall, "begin and cursor alone count");
    ada.commit("drag");
    assert_eq!(committed(&ada.result("commit")), seq + 1);

    let distance = |a: [f64; 3], b: [f64; 3]| DVec3::from(a).distance(b.into());
    let slid = ada.point(2);
    assert!(distance(slid, start) > 0.1, "it moved");
    assert!(distance(slid, past_the_wall) < distance(start, past_the_wall), "and nearer to the cursor");
    ben.catch_up(seq + 1);
    assert_eq!(ben.point(2), slid);
    committed(&ada.undo(Scope::Mine));
    assert_eq!(ada.point(2), start, "one step takes it back");
}

/// A commit of a drag without a valid state is a cancel, and the last reason is the answer.
///
/// Rules: GEST-4, GEST-1
#[test]
fn a_drag_without_a_valid_state_is_cancelled_with_the_last_reason() {
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let (light, seq) = (ada.light(), ada.seq);
    ada.begin("widen");
    widen(&mut ada, 1, -1.0);
    widen(&mut ada, 2, 50.0);
    ada.commit("widen");
    let ends = [&mut ada, &mut ben].map(|mirror| state_of(mirror, has_ended));
    let answer = ada.result("commit");
    let problem = rejected(&answer);
    assert_eq!(problem.code, ErrorCode::InvalidLight);
    let (sentence, name) = (&problem.message, ada.name());
    assert!(sentence.starts_with(&format!("“{name}”: ")) && sentence.contains("folds"), "{sentence}");
    for ended in ends {
        assert_eq!(ended.status, GestureStatus::Cancelled { refused: Some(problem.clone()) });
    }
    assert_eq!(server.state().0, seq);
    committed(&ben.edited(rename(light, "free")));
}

/// Rules: GEST-1
#[test]
fn a_cancelled_drag_leaves_no_trace() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    ada.open_view();
    let before = ada.settled(ada.seq);
    ada.begin("drag");
    drag_point(&mut ada, 1, [0.0, 0.4, 0.3]);
    let dragged = ada.settled(ada.seq);
    assert_ne!(before, dragged, "the drag shows in the picture");
    ada.cancel("drag");
    assert_eq!(ada.settled(ada.seq), before, "and is gone from it");
    assert_eq!(server.state().0, ada.seq);
    assert!(ada.client.receive(Duration::from_millis(1)).is_ok());
}
