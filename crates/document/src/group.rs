//! Groups of commands that form one step, with merged changes.

use std::collections::BTreeSet;
use std::mem::discriminant;

use drag::DragOutcome;
use light::{LightId, SceneBounds};

use crate::{
    CameraId, Change, Command, CommandContext, CommandSolution, ControlPoints, Document, EditError, NumberedLight,
    PinId, execute_command,
};

/// Command of a group, with the part of its result that the scene determines.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupedCommand {
    /// Command, for the document as the commands before it leave it.
    pub command: Command,
    /// Solution of the command in that document, as in [`CommandContext::solved`].
    pub solved: Option<CommandSolution>,
}

/// Result of the commands of a group.
#[derive(Clone, Debug)]
pub struct GroupResult {
    /// Changes, one for each property.
    pub changes: Vec<Change>,
    /// Valid document after the changes.
    pub document: Document,
    /// Outcome of each command's drag of a feature; `None` for other commands.
    pub outcomes: Vec<Option<DragOutcome>>,
}

/// Executes `commands` in order, all or none. An error has the index of the refused command.
///
/// Each command sees the effects of those before it, with the ids that they used. Each property has one change, from
/// its value before the first command to its value after the last. So an undo reverts each property as a whole, and an
/// object that is added and removed again gives no change.
pub fn execute_group<'a>(
    document: &Document,
    commands: impl IntoIterator<Item = &'a GroupedCommand>,
    reach: SceneBounds,
) -> Result<GroupResult, (usize, EditError)> {
    let (mut draft, mut changes, mut outcomes) = (document.clone(), Vec::new(), Vec::new());
    for (index, GroupedCommand { command, solved }) in commands.into_iter().enumerate() {
        let context = CommandContext { scene_bounds: reach, loaded: None, solved: solved.as_ref() };
        let edited = execute_command(&draft, command, context).map_err(|error| (index, error))?;
        changes.extend(edited.changes);
        outcomes.push(edited.outcome);
        draft = edited.document;
    }
    let changes = merge_changes(document, &draft, &changes);
    // Not the draft: it may have used numbers that are in no change, and a replay would not use them.
    let mut after = document.clone();
    after.apply(&changes).map_err(|error| (outcomes.len().saturating_sub(1), error))?;
    Ok(GroupResult { changes, document: after, outcomes })
}

/// Merges `changes`, which lead step by step from `before` to `after`, into direct changes.
fn merge_changes(before: &Document, after: &Document, changes: &[Change]) -> Vec<Change> {
    let camera = |change: &Change| match change {
        Change::Camera { camera, .. } | Change::CameraParameter { camera, .. } => Some(*camera),
        // A change of an object that is neither a light, with its pins, nor a camera would be lost here.
        Change::Scene { .. }
        | Change::Light { .. }
        | Change::LightParameter { .. }
        | Change::Point { .. }
        | Change::ControlPoints { .. }
        | Change::Pin { .. } => None,
    };
    let lights: BTreeSet<LightId> = changes.iter().filter_map(Change::light).collect();
    let cameras: BTreeSet<CameraId> = changes.iter().filter_map(camera).collect();
    // The changes of a light and its pins are adjacent and are undone together: a pin needs its light.
    let of_lights = lights.into_iter().flat_map(|id| {
        [merged_light_changes(id, [before, after], changes), merged_pin_changes(id, [before, after], changes)].concat()
    });
    let of_cameras = cameras.into_iter().flat_map(|id| merged_camera_changes(id, [before, after], changes));
    // A scene is loaded alone and never in a group.
    of_lights.chain(of_cameras).filter(|change| *change != change.inverse()).collect()
}

fn merged_light_changes(id: LightId, documents: [&Document; 2], changes: &[Change]) -> Vec<Change> {
    let [old, new] = documents.map(|document| document.lights.get(&id));
    let is_own = |change: &&Change| change.light() == Some(id) && !matches!(change, Change::Pin { .. });
    let own = || changes.iter().filter(is_own);
    let (Some(was), Some(is), false) = (old, new, own().any(|change| matches!(change, Change::Light { .. }))) else {
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
    let is_parameter = |change: &&Change| matches!(change, Change::CameraParameter { camera, .. } if *camera == id);
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

/// Merges changes that `same` assigns to one property: from the old value of the first to the new value of the last.
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
