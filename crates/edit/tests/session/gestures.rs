//! Gestures in progress.

use document::{Command, CommandContext, EditError};
use edit::{Action, EditRefusal, EditRequest, Gesture, LEASE_MS, MAX_GESTURES, UndoScope};
use light::LightId;
use light::parameters::CONE_ANGLE;

use crate::support::{KEY, TestSession, actor, angle, bent_light, insert, position, radius, softness};

fn is_stale(refusal: &EditRefusal) -> bool {
    matches!(refusal, EditRefusal::Stale { .. })
}

impl TestSession {
    /// Makes a session in which Ada has begun the gesture "g" on its light.
    fn dragged_by_ada() -> Self {
        let mut studio = Self::new();
        studio.begin("ada", "g").expect("nobody holds the light");
        studio
    }

    fn begin(&mut self, who: &str, id: &str) -> Result<Gesture, EditRefusal> {
        let seq = self.session.seq();
        self.session.begin_gesture(id, KEY, seq, 7, &actor(who), 0).cloned()
    }

    fn update(&mut self, who: &str, id: &str, update: u64, command: Command) -> Result<Gesture, EditRefusal> {
        self.session.update_gesture(id, update, command, &actor(who), 0, CommandContext::default()).cloned()
    }

    /// Updates Ada's gesture "g" at the time `now_ms`.
    fn update_at(&mut self, now_ms: u64, command: Command) -> Result<(), EditRefusal> {
        self.session.update_gesture("g", 1, command, &actor("ada"), now_ms, CommandContext::default()).map(drop)
    }

    fn live_angle(&self) -> f64 {
        self.session.live_document().lights()[&KEY].light.light().get(CONE_ANGLE)
    }
}

/// Rules: GEST-1
#[test]
fn a_drag_is_live_while_it_lasts_and_one_record_in_the_end() {
    let mut studio = TestSession::dragged_by_ada();
    for (update, degrees) in [(1, 30.0), (2, 40.0), (3, 50.0)] {
        let gesture = studio.update("ada", "g", update, angle(degrees)).expect("a valid state");
        assert_eq!((gesture.update, gesture.changes().len()), (update, 1));
        assert_eq!((studio.live_angle(), studio.angle()), (degrees, 25.0), "live, not yet done");
    }
    assert_eq!(studio.session.seq(), 1, "nothing is logged");
    let record = studio.done("ada", EditRequest::Commit("g".into()));
    assert_eq!(record.action, Action::Gesture { command: angle(50.0), rebased: false, outcome: None });
    assert_eq!((studio.angle(), studio.live_angle()), (50.0, 50.0));
    assert_eq!(studio.session.gestures().count(), 0);
    studio.undo("ada");
    assert_eq!(studio.angle(), 25.0, "a drag is one step");
}

/// Rules: GEST-1
#[test]
fn a_cancelled_drag_leaves_no_trace() {
    let mut studio = TestSession::new();
    let before = studio.hash();
    studio.begin("ada", "g").expect("nobody holds the light");
    studio.update("ada", "g", 1, angle(50.0)).expect("a valid state");
    assert_ne!(studio.session.live_document().hash(), before);
    studio.session.end_gesture("g", &actor("ada")).expect("it is hers");
    assert_eq!((studio.hash(), studio.session.live_document().hash()), (before, before));
    let ended = studio.session.end_gesture("g", &actor("ada"));
    assert_eq!(ended, Err(EditRefusal::NoGesture("g".into())));
}

/// Rules: GEST-2
#[test]
fn a_held_light_is_locked_for_others() {
    let mut studio = TestSession::new();
    studio.edit("ben", softness(0.5));
    studio.begin("ada", "g").expect("nobody holds the light");
    let locked = EditRefusal::Locked { light: "“key”".into(), holder: "ADA".into() };
    let before = studio.hash();
    for request in [
        EditRequest::Edit { base_seq: None, command: angle(40.0) },
        EditRequest::Edit { base_seq: None, command: Command::RemoveLight(KEY) },
        EditRequest::Undo(UndoScope::Mine),
        EditRequest::Undo(UndoScope::Session),
    ] {
        assert_eq!(studio.ask("ben", request).expect_err("ada holds it"), locked);
    }
    assert_eq!(studio.begin("ben", "h").expect_err("ada holds it"), locked);
    assert_eq!(studio.hash(), before);
    studio.edit("ben", Command::AddLight(bent_light()));
    studio.edit("ada", angle(30.0));
    studio.session.end_gesture("g", &actor("ada")).expect("it is hers");
    studio.edit("ben", angle(40.0));
}

/// Rules: GEST-3
#[test]
fn a_drag_ends_with_its_connection_or_its_lease() {
    let mut studio = TestSession::new();
    let light = |ended: &[Gesture]| ended.iter().map(|gesture| gesture.light).collect::<Vec<_>>();
    studio.begin("ada", "g").expect("nobody holds the light");
    assert!(studio.session.end_gestures_of(8).is_empty(), "another connection");
    assert_eq!(light(&studio.session.end_gestures_of(7)), [KEY]);

    studio.begin("ada", "g").expect("it is free again");
    let later = 20_000;
    studio.update_at(later, angle(50.0)).expect("a valid state");
    assert!(studio.session.expire_gestures(LEASE_MS + later).is_empty(), "30 seconds after the update");
    assert_eq!(light(&studio.session.expire_gestures(LEASE_MS + later + 1)), [KEY]);
    assert_eq!(studio.live_angle(), 25.0, "the light is as it was");
    assert_eq!(studio.update_at(later, angle(50.0)), Err(EditRefusal::NoGesture("g".into())));
}

/// Rules: GEST-4, CMD-2
#[test]
fn an_invalid_state_leaves_the_last_valid_one() {
    let mut studio = TestSession::dragged_by_ada();
    studio.update("ada", "g", 1, position(2, 0.5, -4.0)).expect("a valid state");
    let live = studio.session.live_document().hash();
    let refused = studio.update("ada", "g", 2, position(2, 30.0, -1.0)).expect_err("it folds");
    assert!(matches!(refused, EditRefusal::Edit(EditError::InvalidLight { .. })), "{refused}");
    let gesture = studio.session.gestures().next().expect("it goes on").clone();
    assert_eq!((gesture.update, gesture.command), (1, Some(position(2, 0.5, -4.0))));
    assert_eq!(studio.session.live_document().hash(), live);
    let record = studio.done("ada", EditRequest::Commit("g".into()));
    assert_eq!(
        (record.action, studio.hash()),
        (Action::Gesture { command: position(2, 0.5, -4.0), rebased: false, outcome: None }, live)
    );
}

/// Rules: GEST-3, GEST-4
#[test]
fn an_invalid_state_renews_the_lease() {
    let mut studio = TestSession::dragged_by_ada();
    studio.update_at(20_000, angle(90.0)).expect_err("no cone");
    assert!(studio.session.expire_gestures(LEASE_MS + 1).is_empty());
}

/// Rules: GEST-3
#[test]
fn the_lease_of_one_who_waits_is_renewed() {
    let mut studio = TestSession::dragged_by_ada();
    studio.session.renew_gestures_of(&actor("ben"), 30_000);
    studio.session.renew_gestures_of(&actor("ada"), 20_000);
    assert!(studio.session.expire_gestures(LEASE_MS + 20_000).is_empty());
    let expired = studio.session.expire_gestures(LEASE_MS + 20_001);
    assert_eq!(expired.iter().map(|gesture| gesture.light).collect::<Vec<_>>(), [KEY]);
}

/// Rules: GEST-1, GEST-2
#[test]
fn a_drag_keeps_to_its_light_and_its_holder() {
    let mut studio = TestSession::new();
    studio.edit("rig", Command::AddLight(bent_light()));
    studio.begin("ada", "g").expect("nobody holds the light");
    let elsewhere = Command::RemovePoint { light: LightId(2), point: 1, ignore_pins: false };
    for command in [elsewhere, Command::RemoveLight(KEY), Command::AddLight(bent_light())] {
        assert_eq!(studio.update("ada", "g", 1, command), Err(EditRefusal::OtherLight("“key”".into())));
    }
    assert_eq!(studio.update("ben", "g", 1, angle(40.0)), Err(EditRefusal::NoGesture("g".into())));
    let commit = |studio: &mut TestSession, who| studio.ask(who, EditRequest::Commit("g".into())).expect_err("refused");
    assert_eq!(commit(&mut studio, "ben"), EditRefusal::NoGesture("g".into()));
    assert_eq!(studio.begin("ada", "h"), Err(EditRefusal::GestureExists("h".into())), "one a light");
    assert_eq!(commit(&mut studio, "ada"), EditRefusal::OtherLight("“key”".into()), "the last reason");
    studio.begin("ada", "g").expect("nobody holds the light");
    assert_eq!(commit(&mut studio, "ada"), EditRefusal::EmptyGesture("g".into()), "nothing to commit");
    let nowhere = studio.session.begin_gesture("g", LightId(9), 0, 7, &actor("ada"), 0).cloned();
    assert_eq!(nowhere.expect_err("no such light"), EditError::NoLight(LightId(9)).into());
}

/// Rules: GEST-4, GEST-1
#[test]
fn a_drag_without_a_valid_state_says_why_when_it_is_committed() {
    let mut studio = TestSession::dragged_by_ada();
    for (update, command) in [(1, softness(2.0)), (2, angle(90.0))] {
        studio.update("ada", "g", update, command).expect_err("no such light");
    }
    let before = studio.hash();
    let refused = studio.ask("ada", EditRequest::Commit("g".into())).expect_err("nothing to commit");
    assert!(matches!(refused, EditRefusal::Edit(EditError::InvalidLight { .. })), "{refused}");
    assert!(refused.to_string().starts_with("“key”: ") && refused.to_string().contains("90"), "{refused}");
    assert_eq!((studio.session.gestures().count(), studio.hash()), (0, before), "the drag is over");
}

/// An actor's own undo can renumber the points during a drag. The drag must not move another point then.
///
/// Rules: SOCK-5, GEST-1
#[test]
fn a_drag_counts_points_as_they_were_when_it_began() {
    let mut studio = TestSession::new();
    let known = studio.session.seq();
    studio.edit("ada", insert(1));
    let stale = studio.session.begin_gesture("g", KEY, known, 7, &actor("ada"), 0).cloned();
    assert!(is_stale(&stale.expect_err("outdated")));

    studio.begin("ada", "g").expect("nobody holds the light");
    studio.update("ada", "g", 1, radius(2, 0.5)).expect("a valid state");
    let mut renumbered = studio.clone();
    renumbered.undo("ada");
    assert!(is_stale(&renumbered.update("ada", "g", 2, radius(2, 0.55)).expect_err("outdated")));
    renumbered.update("ada", "g", 3, angle(40.0)).expect("what counts no points");
    studio.undo("ada");
    let refused = studio.ask("ada", EditRequest::Commit("g".into())).expect_err("outdated");
    assert!(is_stale(&refused));
    assert_eq!(studio.radius(2), 0.6);
}

/// Rules: SOCK-5
#[test]
fn a_drag_is_rebased_on_what_its_holder_did_not_know() {
    let mut studio = TestSession::new();
    let known = studio.session.seq();
    studio.edit("ben", softness(0.5));
    studio.session.begin_gesture("g", KEY, known, 7, &actor("ada"), 0).expect("nobody holds the light");
    studio.update("ada", "g", 1, angle(40.0)).expect("a valid state");
    assert!(studio.is_rebased("ada", EditRequest::Commit("g".into())));
    studio.begin("ada", "h").expect("she let go");
    studio.update("ada", "h", 1, angle(50.0)).expect("a valid state");
    assert!(!studio.is_rebased("ada", EditRequest::Commit("h".into())));
}

/// Rules: GEST-1
#[test]
fn a_session_has_so_many_drags_at_once() {
    let mut studio = TestSession::new();
    for _ in 0..MAX_GESTURES {
        studio.edit("rig", Command::AddLight(bent_light()));
    }
    let lights: Vec<_> = studio.session.document().lights().keys().copied().collect();
    let mut begun = lights.iter().enumerate().map(|(index, &light)| {
        let id = index.to_string();
        studio.session.begin_gesture(&id, light, studio.session.seq(), 7, &actor("ada"), 0).map(drop)
    });
    assert!(begun.by_ref().take(MAX_GESTURES).all(|begun| begun.is_ok()));
    let refused = begun.next().expect("one more light").expect_err("too many");
    assert!(matches!(refused, EditRefusal::TooMany { .. }), "{refused}");
}
