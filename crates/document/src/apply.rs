//! Conversion of commands into changes, and application of changes to the document.

use std::collections::BTreeMap;
use std::sync::Arc;

use drag::{DragOutcome, RadiusMode};
use light::parameters::{ROTATION, TRANSLATION};
use light::{CheckedLight, Light, LightId, LightShape, MAX_NAME_BYTES, ParameterOwner, SceneBounds, Setting};
use scene::Camera;

use crate::bending::{BendRequest, reshape_change};
use crate::camera::{camera_parameter, set_camera};
use crate::features::feature_drag_changes;
use crate::naming::quoted;
use crate::pins::{MAX_PINS, check_pin, pin_addition, pin_change, pin_removals};
use crate::points::{point_move_changes, renumbering_change};
use crate::solution::{check_solution, slid_light};
use crate::{
    AssetHash, CameraId, CameraParameter, Change, Command, CommandSolution, Document, EditError, NumberedLight,
    SceneContents, SceneRef,
};

/// Maximum number of lights in a document. Each has a shadow map.
pub const MAX_LIGHTS: usize = 256;
/// Maximum number of cameras in a document.
pub const MAX_CAMERAS: usize = 1024;
/// Largest id or point numbering. A JSON reader that has only f64 numbers represents it exactly.
const MAX_NUMBER: u64 = (1 << 53) - 1;

/// Data about scenes that a command needs and that a document does not contain.
#[derive(Clone, Copy, Debug, Default)]
pub struct CommandContext<'a> {
    /// Bounds of the document's scene, against which its lights are measured.
    pub scene_bounds: SceneBounds,
    /// Contents of the scene that a command loads; `None` if it is not available.
    pub loaded: Option<&'a SceneContents>,
    /// Part of this command's result in this document that its scene determines, by [`crate::solve_command`]; `None` if
    /// it is not available.
    pub solved: Option<&'a CommandSolution>,
}

/// Result of a command.
#[derive(Clone, Debug)]
pub struct CommandResult {
    /// Changes to make; empty if the document already has the requested values.
    pub changes: Vec<Change>,
    /// Valid document after the changes.
    pub document: Document,
    /// Outcome of a drag of a feature; `None` for other commands.
    pub outcome: Option<DragOutcome>,
}

/// Executes `command` on `document`.
///
/// The result depends on the arguments alone: added objects get the document's next numbers as ids. The document after
/// the changes is valid: lights can be evaluated, cameras make pictures, limits are kept.
pub fn execute_command(
    document: &Document,
    command: &Command,
    context: CommandContext,
) -> Result<CommandResult, EditError> {
    let changes = changes_of(document, command, context)?;
    check_solution(document, command, context.solved)?;
    let changes: Vec<_> = changes.into_iter().filter(|change| change != &change.inverse()).collect();
    let mut after = document.clone();
    after.apply(&changes)?;
    // A scene brings its lights without this check.
    if !matches!(command, Command::LoadScene { .. }) {
        check_lights_are_drawable(document, &after, &changes, context.scene_bounds)?;
    }
    let outcome = match (command, context.solved) {
        (Command::DragFeature { .. }, Some(CommandSolution::Drag(solved))) => Some(solved.outcome.clone()),
        _ => None,
    };
    Ok(CommandResult { changes, document: after, outcome })
}

fn changes_of(document: &Document, command: &Command, context: CommandContext) -> Result<Vec<Change>, EditError> {
    Ok(match command {
        Command::LoadScene { asset, name } => load_scene(document, *asset, name, context.loaded)?,
        Command::AddLight(light) => vec![Change::added_light(document.next_number(), light)],
        Command::RemoveLight(id) => {
            let gone = Change::Light { light: *id, old: Some(light(document, *id)?.clone()), new: None };
            [vec![gone], pin_removals(document, |pin| pin.light == *id)].concat()
        }
        Command::PlaceLight { light: id, translation, rotation, scale, .. } => {
            light(document, *id)?;
            let slid = slid_light(context.solved).map(CheckedLight::light);
            let settings = [
                translation.map(|to| TRANSLATION.to(slid.map_or(to, |slid| slid.get(TRANSLATION)))),
                rotation.map(|to| ROTATION.to(slid.map_or(to, |slid| slid.get(ROTATION)))),
                scale.map(|scale| light::parameters::SCALE.to(scale)),
            ];
            let changes = settings.into_iter().flatten().map(|setting| light_change(document, *id, setting));
            changes.collect::<Result<_, _>>()?
        }
        Command::SetLight { light: id, setting, .. } => vec![light_change(document, *id, setting.clone())?],
        Command::SetPoint { light: id, point, setting, .. } => {
            vec![point_change(document, *id, *point, setting.clone())?]
        }
        Command::DragPoint { light: id, point, position, radii_follow, .. } => {
            // Gives the errors of a set position, and the change if there is nothing to solve, as for NaN.
            let set = point_change(document, *id, *point, light::parameters::POSITION.to(*position))?;
            let radii = if *radii_follow { RadiusMode::Follow } else { RadiusMode::Keep };
            let placed = light(document, *id)?;
            let slid = slid_light(context.solved).cloned();
            let slid = slid.or_else(|| {
                let slide = drag::slide_point(&placed.light, *point, *position, radii)?;
                Some(slide.light)
            });
            match slid {
                // The change of the dragged point comes first, since the description of a step names its first change.
                Some(slid) => {
                    let moved = point_move_changes(*id, placed, slid.light().points());
                    let (dragged, others): (Vec<_>, Vec<_>) =
                        moved.into_iter().partition(|change| change.overrides(&set));
                    [dragged, others].concat()
                }
                None => vec![set],
            }
        }
        Command::DragFeature { light: id, .. } => {
            let placed = light(document, *id)?;
            let Some(CommandSolution::Drag(solved)) = context.solved else {
                return Err(EditError::NotSolved(document.light_name(*id)));
            };
            feature_drag_changes(document, *id, placed, solved)?
        }
        Command::AddPin(pin) => vec![pin_addition(document, pin)?],
        Command::RemovePin(id) => vec![pin_change(document, *id, |_| None)?],
        Command::SetPin { pin, is_hard } => vec![pin_change(document, *pin, |mut held| {
            held.pin.is_hard = *is_hard;
            Some(held)
        })?],
        Command::InsertPoint { light, .. } | Command::RemovePoint { light, .. } => {
            vec![renumbering_change(document, *light, bendy_light(document, *light)?, command)?]
        }
        Command::BendLight { light: id, segments, range, cone_angle, toward, .. } => {
            let bending = BendRequest { segments: *segments, range: *range, cone_angle: *cone_angle, toward: *toward };
            vec![reshape_change(document, *id, light(document, *id)?, |straight| bending.bend(straight))?]
        }
        Command::StraightenLight { light: id, .. } => {
            vec![reshape_change(document, *id, light(document, *id)?, light::straighten)?]
        }
        Command::AddCamera(camera) => {
            let id = CameraId(document.next_number());
            vec![Change::Camera { camera: id, old: None, new: Some(camera.clone()) }]
        }
        Command::RemoveCamera(id) => {
            vec![Change::Camera { camera: *id, old: Some(camera(document, *id)?.clone()), new: None }]
        }
        Command::PlaceCamera { camera: id, translation, rotation } => {
            let now = camera(document, *id)?;
            let parameters = [translation.map(CameraParameter::Translation), rotation.map(CameraParameter::Rotation)];
            parameters.into_iter().flatten().map(|p| camera_change(*id, now, p)).collect()
        }
        Command::SetCamera { camera: id, parameter } => {
            vec![camera_change(*id, camera(document, *id)?, parameter.clone())]
        }
    })
}

/// Refuses to move a light out of the range that pictures can show. A light may already be out of range, because of an
/// old record or of its scene. Such a light may be moved step by step until it is within the range again.
fn check_lights_are_drawable(
    before: &Document,
    after: &Document,
    changes: &[Change],
    reach: SceneBounds,
) -> Result<(), EditError> {
    for id in changes.iter().filter_map(Change::light) {
        let was_in_reach = || before.lights.get(&id).is_none_or(|was| reach.check(&was.light).is_ok());
        if let Some(now) = after.lights.get(&id)
            && let Err(error) = reach.check(&now.light)
            && was_in_reach()
        {
            return Err(error.into());
        }
    }
    Ok(())
}

/// Copy of a document to which changes are being applied, with the ids of lights that are not checked yet.
struct Draft {
    after: Document,
    unchecked: BTreeMap<LightId, Light>,
}

impl Document {
    /// Applies `changes`, all of them or, on an error, none. Each light that they touch is checked once.
    ///
    /// Errors are changes whose old values the document does not hold ([`EditError::Conflict`]), and changes that leave
    /// an invalid document.
    pub fn apply(&mut self, changes: &[Change]) -> Result<(), EditError> {
        let mut draft = Draft { after: self.clone(), unchecked: BTreeMap::new() };
        changes.iter().try_for_each(|change| draft.apply_change(change))?;
        let after = draft.into_checked()?;
        changes.iter().try_for_each(|change| after.check(change))?;
        *self = after;
        Ok(())
    }

    /// Returns true if the document holds the old value of `change`.
    pub fn holds_old_value_of(&self, change: &Change) -> bool {
        let light = change.light().and_then(|id| self.lights.get(&id));
        self.holds_old_value_with(change, light.map(|placed| placed.light.light()))
    }

    /// Returns true if the document holds the old value of `change`, with `light` as the current state of the change's
    /// light.
    fn holds_old_value_with(&self, change: &Change, light: Option<&Light>) -> bool {
        let layout = || change.light().and_then(|id| self.lights.get(&id)).map(|placed| placed.layout);
        match change {
            Change::Scene { old, .. } => self.scene == *old,
            Change::Light { light: id, old: Some(old), .. } => {
                self.lights.get(id) == Some(old) && light == Some(old.light.light())
            }
            Change::Light { light: id, old: None, .. } => !self.lights.contains_key(id),
            Change::LightParameter { parameter, old, .. } => {
                light.and_then(|light| light.value(parameter)) == Some(old)
            }
            Change::Point { layout: at, point, parameter, old, .. } => {
                let point = light.and_then(|light| light.points().get(*point));
                layout() == Some(*at) && point.and_then(|point| point.value(parameter)).as_ref() == Some(old)
            }
            Change::ControlPoints { old, .. } => {
                layout() == Some(old.layout)
                    && light.is_some_and(|light| !light.points().is_empty() && light.points() == old.points)
            }
            Change::Camera { camera, old, .. } => self.cameras.get(camera) == old.as_ref(),
            Change::Pin { pin, old, .. } => self.pins.get(pin) == old.as_ref(),
            Change::CameraParameter { camera, old, .. } => {
                self.cameras.get(camera).map(|now| camera_parameter(now, old)).as_ref() == Some(old)
            }
        }
    }

    /// Checks that the object that `change` touches is valid.
    fn check(&self, change: &Change) -> Result<(), EditError> {
        for (what, count, limit) in [
            ("lights", self.lights.len(), MAX_LIGHTS),
            ("cameras", self.cameras.len(), MAX_CAMERAS),
            ("pins", self.pins.len(), MAX_PINS),
        ] {
            if count > limit {
                return Err(EditError::TooMany { what, limit });
            }
        }
        if let Change::Pin { new: Some(pin), .. } = change {
            check_pin(pin)?;
        }
        if let Change::Scene { new: Some(scene), .. } = change {
            check_name(&scene.name)?;
        }
        if let Change::Camera { camera, .. } | Change::CameraParameter { camera, .. } = change
            && let Some(camera) = self.cameras.get(camera)
        {
            check_name(&camera.name)?;
            camera.check().map_err(EditError::InvalidCamera)?;
        }
        Ok(())
    }
}

impl Draft {
    fn apply_change(&mut self, change: &Change) -> Result<(), EditError> {
        let conflict = |draft: &Self| Err(EditError::Conflict(change.subject(&draft.after)));
        let light = change.light().and_then(|id| self.light(id));
        if !self.after.holds_old_value_with(change, light)
            || !change.is_of_one_property()
            || change.largest_new_number() > MAX_NUMBER
        {
            return conflict(self);
        }
        match change {
            Change::Scene { new, .. } => self.after.scene.clone_from(new),
            Change::Light { light, new, .. } => {
                self.unchecked.remove(light);
                insert_or_remove(&mut self.after.lights, *light, new.as_ref());
            }
            Change::LightParameter { light, parameter, new, .. } => {
                self.edit(*light, |light| light.set(Setting { parameter, value: new.clone() }));
            }
            Change::Point { light, point, parameter, new, .. } => self.edit(*light, |light| {
                if let Some(point) = light.points_mut().and_then(|points| points.get_mut(*point)) {
                    point.set(&Setting { parameter, value: new.clone() });
                }
            }),
            Change::ControlPoints { light, new, .. } => {
                self.edit(*light, |light| {
                    if let Some(points) = light.points_mut() {
                        points.clone_from(&new.points);
                    }
                });
                if let Some(placed) = self.after.lights.get_mut(light) {
                    placed.layout = new.layout;
                }
            }
            Change::Camera { camera, new, .. } => {
                insert_or_remove(&mut self.after.cameras, *camera, new.as_ref());
            }
            Change::Pin { pin, new, .. } => insert_or_remove(&mut self.after.pins, *pin, new.as_ref()),
            Change::CameraParameter { camera, new, .. } => match self.after.cameras.get_mut(camera) {
                Some(camera) => set_camera(camera, new),
                None => return conflict(self),
            },
        }
        self.after.take_number(change.largest_new_number());
        Ok(())
    }

    /// Returns the light after the changes so far.
    fn light(&self, id: LightId) -> Option<&Light> {
        self.unchecked.get(&id).or_else(|| Some(self.after.lights.get(&id)?.light.light()))
    }

    fn edit(&mut self, id: LightId, change: impl FnOnce(&mut Light)) {
        let Some(mut light) = self.light(id).cloned() else { return };
        change(&mut light);
        self.unchecked.insert(id, light);
    }

    /// Checks the changed lights and returns the document.
    fn into_checked(mut self) -> Result<Document, EditError> {
        for (id, light) in self.unchecked {
            let name = quoted(light.name()).unwrap_or_else(|| format!("light {id}"));
            let invalid = |reason| EditError::InvalidLight { light: name, reason };
            let checked = CheckedLight::new(light).map_err(invalid)?;
            if let Some(placed) = self.after.lights.get_mut(&id) {
                placed.light = Arc::new(checked);
            }
        }
        Ok(self.after)
    }
}

/// Gives the object `id` its new value, or removes it if it has none.
fn insert_or_remove<Id: Ord, T: Clone>(objects: &mut BTreeMap<Id, T>, id: Id, new: Option<&T>) {
    match new {
        Some(new) => objects.insert(id, new.clone()),
        None => objects.remove(&id),
    };
}

fn check_name(name: &str) -> Result<(), EditError> {
    let too_long = EditError::TooLong { field: "name", limit: MAX_NAME_BYTES };
    if name.len() <= MAX_NAME_BYTES { Ok(()) } else { Err(too_long) }
}

fn light(document: &Document, id: LightId) -> Result<&NumberedLight, EditError> {
    document.lights.get(&id).ok_or(EditError::NoLight(id))
}

fn camera(document: &Document, id: CameraId) -> Result<&Camera, EditError> {
    document.cameras.get(&id).ok_or(EditError::NoCamera(id))
}

/// Finds a light that has control points.
fn bendy_light(document: &Document, id: LightId) -> Result<&NumberedLight, EditError> {
    let placed = light(document, id)?;
    if placed.light.light().owner() == ParameterOwner::Bendy {
        Ok(placed)
    } else {
        wrong_shape(document, id, "control points")
    }
}

fn wrong_shape<T>(document: &Document, id: LightId, what: &'static str) -> Result<T, EditError> {
    let kind = match light(document, id)?.light.light().shape() {
        LightShape::Spot => "spotlight",
        LightShape::Directional => "directional light",
        LightShape::Omni => "omni light",
        LightShape::Bendy(_) => "BendyLight",
    };
    Err(EditError::WrongKind { light: document.light_name(id), kind, what })
}

/// Removes all lights and cameras of the old scene and adds those of the new one.
fn load_scene(
    document: &Document,
    asset: AssetHash,
    name: &str,
    loaded: Option<&SceneContents>,
) -> Result<Vec<Change>, EditError> {
    let SceneContents { lights, cameras } = loaded.ok_or(EditError::UnknownAsset(asset))?;
    let gone = document.lights.iter();
    let mut changes: Vec<_> =
        gone.map(|(&light, old)| Change::Light { light, old: Some(old.clone()), new: None }).collect();
    let gone = document.cameras.iter();
    changes.extend(gone.map(|(&camera, old)| Change::Camera { camera, old: Some(old.clone()), new: None }));
    changes.extend(pin_removals(document, |_| true));
    let new = Some(SceneRef { asset, name: name.into() });
    changes.push(Change::Scene { old: document.scene.clone(), new });
    let mut numbers = document.next_number()..;
    changes.extend(numbers.by_ref().zip(lights).map(|(number, light)| Change::added_light(number, light)));
    changes.extend(numbers.zip(cameras).map(|(number, camera)| Change::Camera {
        camera: CameraId(number),
        old: None,
        new: Some(camera.clone()),
    }));
    Ok(changes)
}

fn light_change(document: &Document, id: LightId, setting: Setting) -> Result<Change, EditError> {
    let Setting { parameter, value: new } = setting;
    match light(document, id)?.light.light().value(parameter).cloned() {
        Some(old) => Ok(Change::LightParameter { light: id, parameter, old, new }),
        None => wrong_shape(document, id, parameter.name),
    }
}

fn point_change(document: &Document, id: LightId, point: usize, setting: Setting) -> Result<Change, EditError> {
    let Setting { parameter, value: new } = setting;
    let placed = bendy_light(document, id)?;
    if point == 0 && *parameter == *light::parameters::POSITION {
        return Err(EditError::Source);
    }
    let points = placed.light.light().points();
    let no_point = || EditError::NoPoint { light: document.light_name(id), point, count: points.len() };
    let old = points.get(point).ok_or_else(no_point)?.value(parameter);
    let old = old.ok_or(EditError::NoPointParameter(parameter.name))?;
    Ok(Change::Point { light: id, layout: placed.layout, point, parameter, old, new })
}

fn camera_change(id: CameraId, now: &Camera, new: CameraParameter) -> Change {
    Change::CameraParameter { camera: id, old: camera_parameter(now, &new), new }
}
