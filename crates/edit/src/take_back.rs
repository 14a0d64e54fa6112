//! Taking back changes where later ones may stand in the way.

use scene::{Change, Document, FindScene};

/// What taking back comes to.
pub(crate) struct TakenBack {
    /// The changes to make.
    pub changes: Vec<Change>,
    /// What stays, and why, a sentence each.
    pub skipped: Vec<String>,
}

/// The changes that take back `changes` in `document` as it is now.
///
/// A property that no longer has the value it was given stays: somebody has changed it since. What is left of a
/// light is taken back as a whole or, where that would leave a light that cannot be evaluated, not at all.
pub(crate) fn take_back(document: &Document, changes: &[Change], find_scene: FindScene) -> TakenBack {
    let mut after = document.clone();
    let mut taken = TakenBack { changes: Vec::new(), skipped: Vec::new() };
    let inverses: Vec<Change> = changes.iter().rev().map(Change::inverse).collect();
    for group in inverses.chunk_by(|a, b| a.light().is_some() && a.light() == b.light()) {
        let (held, changed): (Vec<_>, Vec<_>) =
            group.iter().cloned().partition(|change| after.holds_old_of(change));
        let since = |change: &Change| format!("{} has been changed since", change.subject());
        taken.skipped.extend(changed.iter().map(since));
        match after.apply(&held, find_scene) {
            Ok(()) => taken.changes.extend(held),
            Err(error) => {
                let why = |change: &Change| format!("{} stays: {error}", change.subject());
                taken.skipped.extend(held.iter().map(why));
            }
        }
    }
    taken
}
