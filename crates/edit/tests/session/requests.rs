//! Requests: outdated, rebased, without effect.

use document::{Command, EditError};
use edit::{EditRefusal, EditRequest};
use light::LightId;

use crate::support::{KEY, TestSession, angle, based, bent_light, insert, radius, softness};

/// Rules: SOCK-5
#[test]
fn points_counted_before_a_renumbering_are_stale() {
    let mut studio = TestSession::new();
    let known = studio.session.seq();
    let renumbering = studio.edit("ben", insert(2)).seq;
    let stale = EditRefusal::Stale { light: "“key”".into(), seq: renumbering };
    for command in [radius(1, 0.3), insert(1), Command::RemovePoint { light: KEY, point: 1, ignore_pins: false }] {
        let refused = studio.ask("ada", based(known, command.clone())).expect_err("outdated");
        assert_eq!(refused, stale);
        let mut aware = studio.clone();
        aware.ask("ada", based(renumbering, command.clone())).expect("counted as they are now");
        let mut silent = studio.clone();
        silent.ask("ada", EditRequest::Edit { base_seq: None, command }).expect("the sender does not say");
    }
    assert!(studio.is_rebased("ada", based(known, angle(30.0))), "what counts no points is only rebased");
    studio.undo("ben");
    let refused = studio.ask("ada", based(renumbering, radius(1, 0.3))).expect_err("renumbered again");
    assert!(matches!(refused, EditRefusal::Stale { .. }), "{refused}");
}

/// Rules: SOCK-5
#[test]
fn rebased_means_that_another_changed_the_same_light() {
    let mut studio = TestSession::new();
    studio.edit("rig", Command::AddLight(bent_light()));
    let known = studio.session.seq();
    studio.edit("ada", angle(30.0));
    assert!(!studio.is_rebased("ada", based(known, angle(31.0))), "only herself");
    studio.edit("ben", Command::RemoveLight(LightId(2)));
    assert!(!studio.is_rebased("ada", based(known, angle(32.0))), "another light");
    let theirs = studio.edit("ben", softness(0.5)).seq;
    assert!(studio.is_rebased("ada", based(known, angle(33.0))));
    assert!(!studio.is_rebased("ada", based(theirs, angle(34.0))), "she knew that");
    assert!(studio.is_rebased("ben", based(theirs, softness(0.6))), "he did not know hers");
}

/// Rules: CMD-3, CMD-4
#[test]
fn nothing_done_is_a_record_and_nothing_there_is_not() {
    let mut studio = TestSession::new();
    let record = studio.edit("ada", angle(25.0));
    assert_eq!((record.seq, record.changes), (2, Vec::new()));
    let gone = EditRequest::Edit { base_seq: None, command: Command::RemoveLight(LightId(9)) };
    let refused = studio.ask("ada", gone).expect_err("no such light");
    assert_eq!(refused, EditError::NoLight(LightId(9)).into());
    assert_eq!(studio.session.seq(), 2);
}
