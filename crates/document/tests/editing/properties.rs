//! Properties of every sequence of commands.

use document::{AssetHash, Change, Command, CommandResult, Document, GroupedCommand, execute_group};
use light::SceneBounds;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::random::{command, with_existing_ids};
use crate::support::{ROOM, YARD, content, edit, is_valid, sample, take_back};

const SCENES: &[AssetHash] = &[ROOM, YARD];

/// Executes those of `commands` that are valid, and calls `check` with the document before, the changes, and the
/// document after.
fn each_step(
    commands: Vec<Command>,
    mut check: impl FnMut(&Document, &[Change], &Document) -> Result<(), TestCaseError>,
) -> Result<(), TestCaseError> {
    let mut document = sample();
    for command in commands {
        let command = with_existing_ids(command, &document);
        let Ok(CommandResult { changes, document: after, .. }) = edit(&document, &command) else { continue };
        let again = edit(&document, &command).expect("as before");
        prop_assert_eq!(&again.changes, &changes, "a function");
        let before = document.clone();
        document.apply(&changes).expect("changes just made");
        for outcome in [&after, &again.document] {
            prop_assert_eq!(content(outcome), content(&document), "the changes are all there is");
            prop_assert_eq!(outcome.last_number(), document.last_number());
        }
        check(&before, &changes, &document)?;
    }
    Ok(())
}

/// Returns those of `commands` that are valid in sequence, and the document after them.
fn valid(document: &Document, commands: Vec<Command>) -> (Vec<GroupedCommand>, Document) {
    let mut draft = document.clone();
    let mut grouped = Vec::new();
    for command in commands {
        let command = with_existing_ids(command, &draft);
        let loads = matches!(command, Command::LoadScene { .. });
        let Some(CommandResult { document: after, .. }) = edit(&draft, &command).ok().filter(|_| !loads) else {
            continue;
        };
        draft = after;
        grouped.push(GroupedCommand { command, solved: None });
    }
    (grouped, draft)
}

proptest! {
    /// Rules: CMD-1, CMD-2, CMD-4
    #[test]
    fn a_document_stays_valid_and_a_change_is_a_change(commands in vec(command(SCENES), 1..40)) {
        each_step(commands, |before, changes, after| {
            prop_assert!(is_valid(after));
            prop_assert!(changes.iter().all(|change| *change != change.inverse()), "nothing changes to itself");
            prop_assert_eq!(before.hash() == after.hash(), changes.is_empty());
            Ok(())
        })?;
    }

    /// Rules: REC-2, DOC-2
    #[test]
    fn inverses_give_the_document_back(commands in vec(command(SCENES), 1..40)) {
        each_step(commands, |before, changes, after| {
            let mut back = after.clone();
            take_back(&mut back, changes);
            prop_assert_eq!(content(&back), content(before));
            prop_assert_eq!(back.hash(), before.hash());
            prop_assert!(back.last_number() >= after.last_number(), "numbers stay given out");
            Ok(())
        })?;
    }

    /// Rules: DOC-1, DOC-2
    #[test]
    fn numbers_are_new_when_they_appear_and_layouts_change_with_renumbering(
        commands in vec(command(SCENES), 1..40)
    ) {
        each_step(commands, |before, changes, after| {
            let fresh = |number: u64| number > before.last_number() && number <= after.last_number();
            for (id, placed) in after.lights() {
                let Some(earlier) = before.lights().get(id) else {
                    prop_assert!(fresh(id.0) && fresh(placed.layout.0), "light {}", id);
                    continue;
                };
                let is_renumbered = changes.iter().any(|change| matches!(
                    change,
                    Change::ControlPoints { light, .. } | Change::Light { light, old: Some(_), new: Some(_) }
                        if light == id
                ));
                prop_assert_eq!(placed.layout != earlier.layout, is_renumbered);
                prop_assert!(!is_renumbered || fresh(placed.layout.0));
            }
            for id in after.pins().keys() {
                prop_assert!(before.pins().contains_key(id) || fresh(id.0), "pin {}", id);
            }
            for id in after.cameras().keys() {
                prop_assert!(before.cameras().contains_key(id) || fresh(id.0), "camera {}", id);
            }
            Ok(())
        })?;
    }
}

proptest! {
    /// Rules: CMD-17, REC-2, REC-9
    #[test]
    fn a_group_is_one_change_of_each_property(
        first in vec(command(SCENES), 0..20),
        group in vec(command(SCENES), 1..30),
    ) {
        let (_, before) = valid(&sample(), first);
        let (group, one_by_one) = valid(&before, group);
        let together = execute_group(&before, &group, SceneBounds::default()).expect("valid one by one");
        // Compared by hash: a change from 0 to -0 and back is no change.
        prop_assert_eq!(together.document.hash(), one_by_one.hash());
        for (index, change) in together.changes.iter().enumerate() {
            prop_assert!(*change != change.inverse(), "nothing changes to itself");
            let others = together.changes[..index].iter();
            let pins = |change: &Change| matches!(change, Change::Pin { .. });
            let again = others.filter(|other| pins(other) == pins(change)).find(|other| other.overrides(change));
            prop_assert!(again.is_none(), "{:?} and {:?}", again, change);
        }
        let mut back = together.document.clone();
        take_back(&mut back, &together.changes);
        prop_assert_eq!(back.hash(), before.hash());
    }
}

/// The properties above are meaningful: most random commands of every type are valid.
///
/// Rules: CMD-1
#[test]
fn random_commands_are_mostly_valid() {
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut kinds = std::collections::BTreeMap::new();
    let mut document = sample();
    for _ in 0..4000 {
        let command = command(SCENES).new_tree(&mut runner).expect("a command").current();
        let command = with_existing_ids(command, &document);
        let name = format!("{command:?}").split(['(', ' ']).next().unwrap_or_default().to_owned();
        let count: &mut (u32, u32) = kinds.entry(name).or_default();
        match edit(&document, &command) {
            Ok(after) => {
                document = after.document;
                count.0 += 1;
            }
            Err(_) => count.1 += 1,
        }
    }
    assert_eq!(kinds.len(), 19, "every type of command: {kinds:?}");
    // Only a scene determines the result; `features.rs` has one.
    assert!(kinds.remove("DragFeature").is_some_and(|count| count.0 == 0 && count.1 >= 20));
    assert!(kinds.values().all(|count| count.0 >= 20), "(done, refused): {kinds:?}");
    assert!(kinds.values().map(|count| count.1).sum::<u32>() >= 200, "some are refused: {kinds:?}");
}
