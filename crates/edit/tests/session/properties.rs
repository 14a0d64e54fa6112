//! Properties of every sequence of requests.

use document::{Command, CommandContext, GroupedCommand, execute_command};
use edit::{EditRequest, GroupedEdit, Session, UndoScope};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::random::{command, with_existing_ids};
use crate::support::{SCENES, TestSession};

/// Step of a random session.
#[derive(Clone, Debug)]
pub enum RandomStep {
    Edit(Box<Command>),
    Group(Vec<Command>),
    Undo(UndoScope),
    Redo(UndoScope),
}

/// Steps with their actors.
pub type RandomSteps = Vec<(&'static str, RandomStep)>;

/// Generates steps of any of `actors`. A third of them are undo and redo.
pub fn random_steps(actors: &'static [&'static str], steps: usize) -> impl Strategy<Value = RandomSteps> {
    let scope = || prop_oneof![2 => Just(UndoScope::Mine), 1 => Just(UndoScope::Session)];
    let step = prop_oneof![
        4 => command(SCENES).prop_map(|command| RandomStep::Edit(Box::new(command))),
        1 => vec(command(SCENES), 1..8).prop_map(RandomStep::Group),
        1 => scope().prop_map(RandomStep::Undo),
        1 => scope().prop_map(RandomStep::Redo),
    ];
    vec((proptest::sample::select(actors), step), 1..steps)
}

/// Makes the request of a step, with ids that exist.
pub fn request(step: RandomStep, studio: &TestSession) -> EditRequest {
    match step {
        RandomStep::Edit(command) => {
            EditRequest::Edit { base_seq: None, command: with_existing_ids(*command, studio.session.document()) }
        }
        RandomStep::Group(commands) => {
            let mut draft = studio.session.document().clone();
            let mut edits = Vec::new();
            for command in commands {
                let command = with_existing_ids(command, &draft);
                // `groups` has the test of a group with a refused command.
                let Ok(after) = execute_command(&draft, &command, CommandContext::default()) else {
                    continue;
                };
                draft = after.document;
                edits.push(grouped(command));
            }
            EditRequest::Group(edits)
        }
        RandomStep::Undo(scope) => EditRequest::Undo(scope),
        RandomStep::Redo(scope) => EditRequest::Redo(scope),
    }
}

/// Returns the command of a group that drags no feature.
pub fn grouped(command: Command) -> GroupedEdit {
    GroupedEdit { base_seq: None, grouped: GroupedCommand { command, solved: None } }
}

fn played(play: RandomSteps) -> TestSession {
    let mut studio = TestSession::new();
    for (who, step) in play {
        // A refusal leaves everything unchanged, as a test below shows.
        let _ = studio.ask(who, request(step, &studio));
    }
    studio
}

/// Repeats `what` until it is refused, at most `limit` times, and returns the number of times it was executed.
fn repeat(studio: &mut TestSession, who: &str, what: &EditRequest, limit: usize) -> usize {
    (0..limit).take_while(|_| studio.ask(who, what.clone()).is_ok()).count()
}

const ALONE: &[&str] = &["ada"];
const THREE: &[&str] = &["ada", "ben", "cyd"];

proptest! {
    /// Rules: UNDO-4, UNDO-3
    #[test]
    fn as_many_redos_as_undos_change_nothing(
        alone in any::<bool>(),
        plays in (random_steps(ALONE, 30), random_steps(THREE, 30)),
        count in 1..40_usize,
        is_session in any::<bool>(),
    ) {
        let mut studio = played(if alone { plays.0 } else { plays.1 });
        let scope = if is_session { UndoScope::Session } else { UndoScope::Mine };
        let before = studio.hash();
        let undone = repeat(&mut studio, "ada", &EditRequest::Undo(scope), count);
        for _ in 0..undone {
            let redo = studio.done("ada", EditRequest::Redo(scope));
            prop_assert!(redo.action.skipped().is_empty(), "{:?}", redo.action);
        }
        prop_assert_eq!(studio.hash(), before);
    }

    /// Rules: UNDO-4, UNDO-1
    #[test]
    fn undoing_everything_leaves_nothing(commands in vec((proptest::sample::select(THREE), command(SCENES)), 1..30)) {
        let steps = commands.into_iter().map(|(who, command)| (who, RandomStep::Edit(Box::new(command))));
        let mut studio = played(steps.collect());
        let steps = studio.log.iter().filter(|record| !record.changes.is_empty()).count();
        prop_assert_eq!(repeat(&mut studio, "cyd", &EditRequest::Undo(UndoScope::Session), steps + 1), steps);
        prop_assert_eq!(studio.hash(), Session::default().document().hash());
    }

    /// Rules: CMD-1, UNDO-5, REC-1
    #[test]
    fn a_refusal_leaves_everything_as_it_was(play in random_steps(THREE, 40)) {
        let mut studio = TestSession::new();
        for (who, step) in play {
            let (before, seq) = (studio.hash(), studio.session.seq());
            match studio.ask(who, request(step, &studio)) {
                Ok(_) => prop_assert_eq!(studio.session.seq(), seq + 1),
                Err(refusal) => {
                    prop_assert_eq!((studio.hash(), studio.session.seq()), (before, seq));
                    let sentence = refusal.to_string();
                    prop_assert!(sentence.len() > 10, "{}", sentence);
                }
            }
        }
    }

    /// Rules: REC-2, LOG-2, UNDO-1
    #[test]
    fn replay_and_restore_give_the_same_session(
        play in random_steps(THREE, 40),
        cut in any::<prop::sample::Index>(),
        is_restored in any::<bool>(),
    ) {
        let studio = played(play);
        let cut = cut.index(studio.log.len() + 1);
        let (mut replayed, mut document) = (TestSession::default(), document::Document::default());
        for record in &studio.log[..cut] {
            replayed.session.replay(record).expect("a log just made");
        }
        replayed.log = studio.log[..cut].to_vec();
        // Restored as from a checkpoint, which replays nothing.
        if is_restored {
            let past = replayed.session.session_history();
            replayed.session = Session::restore(replayed.session.document().clone(), cut as u64, &past);
            prop_assert_eq!(replayed.session.session_history(), past);
        }
        // Later requests give the same results too: histories and numbers were rebuilt.
        for record in &studio.log[cut..] {
            let request = match record.action.clone() {
                edit::Action::Edit { command, .. } | edit::Action::Gesture { command, .. } => {
                    EditRequest::Edit { base_seq: None, command }
                }
                edit::Action::Group { edits, .. } => {
                    EditRequest::Group(edits.into_iter().map(|edit| grouped(edit.command)).collect())
                }
                edit::Action::Undo { scope, .. } => EditRequest::Undo(scope),
                edit::Action::Redo { scope, .. } => EditRequest::Redo(scope),
            };
            prop_assert_eq!(&replayed.done(&record.actor.id, request), record);
        }
        prop_assert_eq!(replayed.hash(), studio.hash());
        for record in &studio.log {
            document.apply(&record.changes).expect("changes alone are enough");
        }
        prop_assert_eq!(document.hash(), studio.hash());
    }
}
