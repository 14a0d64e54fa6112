//! What holds for every sequence of requests.

use document::{Command, Context, GroupedCommand, edited};
use edit::{GroupedEdit, Request, Scope, Session};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::random::{aimed, command};
use crate::support::{SCENES, Studio};

/// One step of a random session.
#[derive(Clone, Debug)]
pub enum Step {
    Edit(Box<Command>),
    Group(Vec<Command>),
    Undo(Scope),
    Redo(Scope),
}

/// Who does what.
pub type Play = Vec<(&'static str, Step)>;

/// Steps of any of `actors`; a third of them undo and redo.
pub fn play(actors: &'static [&'static str], steps: usize) -> impl Strategy<Value = Play> {
    let scope = || prop_oneof![2 => Just(Scope::Mine), 1 => Just(Scope::Session)];
    let step = prop_oneof![
        4 => command(SCENES).prop_map(|command| Step::Edit(Box::new(command))),
        1 => vec(command(SCENES), 1..8).prop_map(Step::Group),
        1 => scope().prop_map(Step::Undo),
        1 => scope().prop_map(Step::Redo),
    ];
    vec((proptest::sample::select(actors), step), 1..steps)
}

/// The request of a step, aimed at what is there.
pub fn request(step: Step, studio: &Studio) -> Request {
    match step {
        Step::Edit(command) => {
            Request::Edit { base_seq: None, command: aimed(*command, studio.session.document()) }
        }
        Step::Group(commands) => {
            let mut draft = studio.session.document().clone();
            let mut edits = Vec::new();
            for command in commands {
                let command = aimed(command, &draft);
                // A group that is refused for one of them is shown in `groups`.
                let Ok(after) = edited(&draft, &command, Context::default()) else { continue };
                draft = after.document;
                edits.push(grouped(command));
            }
            Request::Group(edits)
        }
        Step::Undo(scope) => Request::Undo(scope),
        Step::Redo(scope) => Request::Redo(scope),
    }
}

/// A command of a group, which drags no feature.
pub fn grouped(command: Command) -> GroupedEdit {
    GroupedEdit { base_seq: None, grouped: GroupedCommand { command, solved: None } }
}

fn played(play: Play) -> Studio {
    let mut studio = Studio::new();
    for (who, step) in play {
        // Some are refused, which leaves everything as it was; that is shown below.
        let _ = studio.ask(who, request(step, &studio));
    }
    studio
}

/// How many of `what` are carried out until there is nothing left, `limit` at most.
fn repeat(studio: &mut Studio, who: &str, what: &Request, limit: usize) -> usize {
    (0..limit).take_while(|_| studio.ask(who, what.clone()).is_ok()).count()
}

const ALONE: &[&str] = &["ada"];
const THREE: &[&str] = &["ada", "ben", "cyd"];

proptest! {
    /// Rules: UNDO-4, UNDO-3
    #[test]
    fn as_many_redos_as_undos_change_nothing(
        alone in any::<bool>(),
        plays in (play(ALONE, 30), play(THREE, 30)),
        count in 1..40_usize,
        is_session in any::<bool>(),
    ) {
        let mut studio = played(if alone { plays.0 } else { plays.1 });
        let scope = if is_session { Scope::Session } else { Scope::Mine };
        let before = studio.hash();
        let undone = repeat(&mut studio, "ada", &Request::Undo(scope), count);
        for _ in 0..undone {
            let redo = studio.done("ada", Request::Redo(scope));
            prop_assert!(redo.action.skipped().is_empty(), "{:?}", redo.action);
        }
        prop_assert_eq!(studio.hash(), before);
    }

    /// Rules: UNDO-4, UNDO-1
    #[test]
    fn undoing_everything_leaves_nothing(commands in vec((proptest::sample::select(THREE), command(SCENES)), 1..30)) {
        let steps = commands.into_iter().map(|(who, command)| (who, Step::Edit(Box::new(command))));
        let mut studio = played(steps.collect());
        let steps = studio.log.iter().filter(|record| !record.changes.is_empty()).count();
        prop_assert_eq!(repeat(&mut studio, "cyd", &Request::Undo(Scope::Session), steps + 1), steps);
        prop_assert_eq!(studio.hash(), Session::default().document().hash());
    }

    /// Rules: CMD-1, UNDO-5, REC-1
    #[test]
    fn a_refusal_leaves_everything_as_it_was(play in play(THREE, 40)) {
        let mut studio = Studio::new();
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
        play in play(THREE, 40),
        cut in any::<prop::sample::Index>(),
        is_restored in any::<bool>(),
    ) {
        let studio = played(play);
        let cut = cut.index(studio.log.len() + 1);
        let (mut replayed, mut document) = (Studio::default(), document::Document::default());
        for record in &studio.log[..cut] {
            replayed.session.replay(record).expect("a log just made");
        }
        replayed.log = studio.log[..cut].to_vec();
        // As from a checkpoint, which replays nothing.
        if is_restored {
            let past = replayed.session.past();
            replayed.session = Session::restore(replayed.session.document().clone(), cut as u64, &past);
            prop_assert_eq!(replayed.session.past(), past);
        }
        // What comes after a restart is the same too: histories and numbers were rebuilt.
        for record in &studio.log[cut..] {
            let request = match record.action.clone() {
                edit::Action::Edit { command, .. } | edit::Action::Gesture { command, .. } => {
                    Request::Edit { base_seq: None, command }
                }
                edit::Action::Group { edits, .. } => {
                    Request::Group(edits.into_iter().map(|edit| grouped(edit.command)).collect())
                }
                edit::Action::Undo { scope, .. } => Request::Undo(scope),
                edit::Action::Redo { scope, .. } => Request::Redo(scope),
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
