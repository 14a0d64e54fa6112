//! Commands carried out one after the other as one step, and their changes as those of one step.

use std::collections::BTreeSet;
use std::mem::discriminant;

use light::{LightId, SceneBounds};

use crate::{
    CameraId, Change, Command, CommandContext, CommandResult, ControlPoints, Document, DragOutcome,
    EditError, NumberedLight, PinId, SolvedDrag, execute_command,
};

/// A command of a group, and where the drag in it leads.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupedCommand {
    /// What to do in the document that the commands before it leave.
    pub command: Command,
    /// As in [`CommandContext::solved`], found for that document.
    pub solved: Option<SolvedDrag>,
}

/// What commands of a group come to.
#[derive(Clone, Debug)]
pub struct GroupResult {
    /// What changes; each property once.
    pub changes: Vec<Change>,
    /// The document after that, valid.
    pub document: Document,
    /// How the drag of a feature ended, for each command.
    pub outcomes: Vec<Option<DragOutcome>>,
}

/// Carries out `commands` one after the other, all or none. On an error says which is refused, by its index.
///
/// Each sees what those before it did, with the ids that they gave out. Of the changes each property has one, from its value
/// before the first command to the one after the last: so undo takes back each as a whole, and what came and went again is none.
pub fn execute_group<'a>(
    document: &Document,
    commands: impl IntoIterator<Item = &'a GroupedCommand>,
    reach: SceneBounds,
) -> Result<GroupResult, (usize, EditError)> {
    let (mut draft, mut changes, mut outcomes) = (document.clone(), Vec::new(), Vec::new());
    for (index, GroupedCommand { command, solved }) in commands.into_iter().enumerate() {
        let context = CommandContext { scene_bounds: reach, loaded: None, solved: solved.as_ref() };
        let edited = execute_command(&draft, command, context).map_err(|error| (index, error))?;
        let CommandResult { changes: more, document: after, outcome } = edited;
        changes.extend(more);
        outcomes.push(outcome);
        draft = after;
    }
    let changes = merge_changes(document, &draft, &changes);
    // Not the draft: it may have given out numbers that no change says, and a replay would not.
    let mut after = document.clone();
    after.apply(&changes).map_err(|error| (outcomes.len().saturating_sub(1), error))?;
    Ok(GroupResult { changes, document: after, outcomes })
}

/// The changes from `from` to `to` of what `changes` touch, which lead there one after the other.
fn merge_changes(before: &Document, after: &Document, changes: &[Change]) -> Vec<Change> {
    let camera = |change: &Change| match change {
        Change::Camera { camera, .. } | Change::CameraParameter { camera, .. } => Some(*camera),
        _ => None,
    };
    let lights: BTreeSet<LightId> = changes.iter().filter_map(Change::light).collect();
    let cameras: BTreeSet<CameraId> = changes.iter().filter_map(camera).collect();
    // A light and its pins in a row, which are taken back together: a pin is nowhere without its light.
    let of_lights = lights.into_iter().flat_map(|id| {
        [merged_light_changes(id, [before, after], changes), merged_pin_changes(id, [before, after], changes)]
            .concat()
    });
    let of_cameras = cameras.into_iter().flat_map(|id| merged_camera_changes(id, [before, after], changes));
    // Scenes are loaded by themselves: none comes in a group.
    of_lights.chain(of_cameras).filter(|change| *change != change.inverse()).collect()
}

fn merged_light_changes(id: LightId, documents: [&Document; 2], changes: &[Change]) -> Vec<Change> {
    let [old, new] = documents.map(|document| document.lights.get(&id));
    let is_own = |change: &&Change| change.light() == Some(id) && !matches!(change, Change::Pin { .. });
    let own = || changes.iter().filter(is_own);
    let (Some(was), Some(is), false) = (old, new, own().any(|change| matches!(change, Change::Light { .. })))
    else {
        return vec![Change::Light { light: id, old: old.cloned(), new: new.cloned() }];
    };
    let points = |placed: &NumberedLight| ControlPoints {
        layout: placed.layout,
        points: placed.light.light().points().to_vec(),
    };
    let renumbers = own().any(|change| matches!(change, Change::ControlPoints { .. }));
    let all = renumbers.then(|| Change::ControlPoints { light: id, old: points(was), new: points(is) });
    let is_left = |change: &&Change| !renumbers || matches!(change, Change::LightParameter { .. });
    all.into_iter().chain(merge_by_property(own().filter(is_left), Change::overrides)).collect()
}

fn merged_camera_changes(id: CameraId, documents: [&Document; 2], changes: &[Change]) -> Vec<Change> {
    let is_parameter =
        |change: &&Change| matches!(change, Change::CameraParameter { camera, .. } if *camera == id);
    let comes_or_goes = |change: &Change| matches!(change, Change::Camera { camera, .. } if *camera == id);
    if changes.iter().any(comes_or_goes) {
        let [old, new] = documents.map(|document| document.cameras.get(&id).cloned());
        return vec![Change::Camera { camera: id, old, new }];
    }
    let same = |a: &Change, b: &Change| match (a, b) {
        (Change::CameraParameter { new: a, .. }, Change::CameraParameter { new: b, .. }) => {
            discriminant(a) == discriminant(b)
        }
        _ => false,
    };
    merge_by_property(changes.iter().filter(is_parameter), same)
}

fn merged_pin_changes(light: LightId, documents: [&Document; 2], changes: &[Change]) -> Vec<Change> {
    let pin = |change: &Change| match change {
        Change::Pin { pin, .. } if change.light() == Some(light) => Some(*pin),
        _ => None,
    };
    let pins: BTreeSet<PinId> = changes.iter().filter_map(pin).collect();
    let of_pin = |pin: PinId| {
        let [old, new] = documents.map(|document| document.pins.get(&pin).cloned());
        Change::Pin { pin, old, new }
    };
    pins.into_iter().map(of_pin).collect()
}

/// One change for each property, where `same` says whether two are of one: from what the first has before to what the last has
/// after.
fn merge_by_property<'a>(
    changes: impl Iterator<Item = &'a Change>,
    same: impl Fn(&Change, &Change) -> bool,
) -> Vec<Change> {
    let mut merged: Vec<Change> = Vec::new();
    for change in changes {
        match merged.iter_mut().find(|earlier| same(change, earlier)) {
            Some(earlier) => earlier.extend_with(change),
            None => merged.push(change.clone()),
        }
    }
    merged
}
