//! Number of checks of a light: one for a request, for an update of a gesture and for a replayed record.

use document::CommandContext;
use edit::{EditRequest, Session};
use light::CheckedLight;

use crate::support::{KEY, TestSession, actor, angle, bent_light, insert, position, radius};

/// Counts the checks that `work` makes.
fn checks<T>(work: impl FnOnce() -> T) -> u64 {
    let before = CheckedLight::check_count();
    work();
    CheckedLight::check_count() - before
}

/// Rules: CMD-2, UNDO-1, UNDO-3, REC-2
#[test]
fn a_step_checks_its_light_once() {
    let mut studio = TestSession::new();
    for command in [angle(40.0), radius(1, 0.3), insert(2)] {
        assert_eq!(checks(|| studio.edit("ada", command)), 1);
    }
    // The check that a step can be reverted happens in the search for it.
    assert_eq!(checks(|| studio.undo("ada")), 1);
    assert_eq!(checks(|| studio.redo("ada")), 1);
    let mut session = Session::default();
    let replay = || studio.log.iter().try_for_each(|record| session.replay(record)).expect("a log just made");
    assert_eq!(checks(replay), 5, "the light itself comes checked");
    assert_eq!(checks(bent_light), 1, "the count counts");
}

/// Rules: CMD-2, GEST-1, GEST-4
#[test]
fn a_drag_checks_its_light_at_each_update() {
    let mut studio = TestSession::new();
    let ada = actor("ada");
    studio.session.begin_gesture("g", KEY, 1, 7, &ada, 0).expect("nobody holds the light");
    for (update, command, is_valid) in
        [(1, position(2, 0.5, -4.0), true), (2, position(2, 30.0, -1.0), false), (3, angle(40.0), true)]
    {
        let session = &mut studio.session;
        let mut was_valid = !is_valid;
        let move_it = || {
            let moved = session.update_gesture("g", update, command, &ada, 0, CommandContext::default());
            was_valid = moved.is_ok();
        };
        assert_eq!(checks(move_it), 1);
        assert_eq!(was_valid, is_valid);
        assert_eq!(checks(|| studio.session.live_document()), 0, "who looks on checks nothing");
    }
    assert_eq!(checks(|| studio.done("ada", EditRequest::Commit("g".into()))), 1);
    assert_eq!(studio.angle(), 40.0);
}
