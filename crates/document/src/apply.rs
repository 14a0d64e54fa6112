//! Commands into changes, and changes into the document.

use std::sync::Arc;

use light::{BendyLight, LightError, Tube, check_spot};

use crate::points::renumbered;
use crate::property::{camera_parameter, light_parameter, point_parameter, set_camera, set_light, set_point};
use crate::{
    AssetHash, CameraId, CameraParameter, Change, Command, ControlPoints, Document, EditError, Layout,
    LightParameter, PlacedLight, PointParameter, SceneRef,
};
use light::{Light, LightId, LightKind};
use scene::{Camera, Scene};

/// Lights that a document holds at most; each has a shadow map.
pub const MAX_LIGHTS: usize = 256;
/// Cameras that a document holds at most.
pub const MAX_CAMERAS: usize = 1024;
/// Bytes that a name has at most.
pub const MAX_NAME_BYTES: usize = 256;
/// Largest number of an id or a layout: what a reader of JSON that knows only f64 keeps exactly.
const MAX_NUMBER: u64 = (1 << 53) - 1;

/// Finds a scene by its bytes' hash; `None` where it is not at hand.
pub type FindScene<'a> = &'a dyn Fn(&AssetHash) -> Option<Arc<Scene>>;

/// What `command` would change in `document`; empty where everything is so already.
///
/// A function of its arguments alone: ids of what is added are the document's next numbers. The document
/// after the changes is valid: lights can be evaluated, cameras make pictures, limits hold.
pub fn changes_of(
    document: &Document,
    command: &Command,
    find_scene: FindScene,
) -> Result<Vec<Change>, EditError> {
    let changes = match command {
        Command::LoadScene { asset, name } => load_scene(document, *asset, name, find_scene)?,
        Command::AddLight(light) => vec![added_light(document.next_number(), light)],
        Command::RemoveLight(id) => {
            vec![Change::Light { light: *id, old: Some(Box::new(light(document, *id)?.clone())), new: None }]
        }
        Command::PlaceLight { light: id, translation, rotation, scale } => {
            light(document, *id)?;
            let parameters = [
                translation.map(LightParameter::Translation),
                rotation.map(LightParameter::Rotation),
                scale.map(LightParameter::Scale),
            ];
            let changes = parameters.into_iter().flatten().map(|p| parameter_change(document, *id, p));
            changes.collect::<Result<_, _>>()?
        }
        Command::SetLight { light: id, parameter } => {
            vec![parameter_change(document, *id, parameter.clone())?]
        }
        Command::SetPoint { light: id, point, parameter } => {
            let (placed, bendy) = bendy(document, *id)?;
            if *point == 0 && matches!(parameter, PointParameter::Position(_)) {
                return Err(EditError::Source);
            }
            let count = bendy.points.len();
            let no_point = || EditError::NoPoint { light: document.light_name(*id), point: *point, count };
            let old = point_parameter(bendy, *point, parameter).ok_or_else(no_point)?;
            vec![Change::Point { light: *id, layout: placed.layout, point: *point, old, new: *parameter }]
        }
        Command::InsertPoint { light, .. } | Command::RemovePoint { light, .. } => {
            vec![renumbered(document, *light, bendy(document, *light)?, command)?]
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
            let parameters =
                [translation.map(CameraParameter::Translation), rotation.map(CameraParameter::Rotation)];
            parameters.into_iter().flatten().map(|p| camera_change(*id, now, p)).collect()
        }
        Command::SetCamera { camera: id, parameter } => {
            vec![camera_change(*id, camera(document, *id)?, parameter.clone())]
        }
    };
    let changes: Vec<_> = changes.into_iter().filter(|change| change != &change.inverse()).collect();
    let mut after = document.clone();
    after.apply(&changes, find_scene)?;
    // A scene brings its lights as they are.
    if !matches!(command, Command::LoadScene { .. }) {
        stays_in_reach(document, &after, &changes)?;
    }
    Ok(changes)
}

/// Refuses to take a light out of where pictures can show it. One that is there already, by an old record or with its
/// scene, may be changed in steps until it is back.
fn stays_in_reach(before: &Document, after: &Document, changes: &[Change]) -> Result<(), EditError> {
    let reach = after.reach();
    for id in changes.iter().filter_map(Change::light) {
        let was_in_reach = || before.lights().get(&id).is_none_or(|was| reach.check(&was.light).is_ok());
        if let Some(now) = after.lights().get(&id)
            && let Err(error) = reach.check(&now.light)
            && was_in_reach()
        {
            return Err(error.into());
        }
    }
    Ok(())
}

impl Document {
    /// Makes `changes`, all of them or, on an error, none.
    ///
    /// Refused are changes whose old values the document does not hold ([`EditError::Conflict`]), and those
    /// that leave something invalid.
    pub fn apply(&mut self, changes: &[Change], find_scene: FindScene) -> Result<(), EditError> {
        let mut after = self.clone();
        for change in changes {
            after.make(change, find_scene)?;
        }
        for change in changes {
            after.check(change)?;
        }
        *self = after;
        Ok(())
    }

    /// Whether the document holds what `change` starts from.
    pub fn holds_old_of(&self, change: &Change) -> bool {
        match change {
            Change::Scene { old, .. } => self.scene_ref() == old.as_ref(),
            Change::Light { light, old, .. } => self.lights().get(light) == old.as_deref(),
            Change::LightParameter { light, old, .. } => {
                self.lights().get(light).and_then(|now| light_parameter(&now.light, old)) == Some(old.clone())
            }
            Change::Point { light, layout, point, old, .. } => match self.lights().get(light) {
                Some(PlacedLight { layout: now, light: Light { kind: LightKind::Bendy(bendy), .. } }) => {
                    now == layout && point_parameter(bendy, *point, old) == Some(*old)
                }
                _ => false,
            },
            Change::ControlPoints { light, old, .. } => {
                self.lights().get(light).and_then(ControlPoints::of).as_ref() == Some(old)
            }
            Change::Camera { camera, old, .. } => self.cameras().get(camera) == old.as_ref(),
            Change::CameraParameter { camera, old, .. } => {
                self.cameras().get(camera).map(|now| camera_parameter(now, old)).as_ref() == Some(old)
            }
        }
    }

    fn make(&mut self, change: &Change, find_scene: FindScene) -> Result<(), EditError> {
        let conflict = |document: &Self| EditError::Conflict(change.subject(document));
        if !self.holds_old_of(change) || !change.is_of_one_property() || change.number() > MAX_NUMBER {
            return Err(conflict(self));
        }
        match change {
            Change::Scene { new, .. } => {
                let find = |r: &SceneRef| find_scene(&r.asset).ok_or(EditError::UnknownAsset(r.asset));
                let scene = new.as_ref().map_or(Ok(Arc::default()), find)?;
                self.set_scene(new.clone(), scene);
            }
            Change::Light { light, new: Some(new), .. } => {
                self.lights_mut().insert(*light, PlacedLight::clone(new));
            }
            Change::Light { light, new: None, .. } => {
                self.lights_mut().remove(light);
            }
            Change::LightParameter { light, new, .. } => {
                let Some(placed) = self.lights_mut().get_mut(light) else { return Err(conflict(self)) };
                set_light(&mut placed.light, new);
            }
            Change::Point { light, point, new, .. } => {
                let Some(bendy) = self.bendy_mut(*light) else { return Err(conflict(self)) };
                set_point(bendy, *point, *new);
            }
            Change::ControlPoints { light, new, .. } => {
                let Some(placed) = self.lights_mut().get_mut(light) else { return Err(conflict(self)) };
                let LightKind::Bendy(bendy) = &mut placed.light.kind else { return Err(conflict(self)) };
                (bendy.points, bendy.radii) = (new.points.clone(), new.radii.clone());
                (bendy.colors, bendy.intensities) = (new.colors.clone(), new.intensities.clone());
                placed.layout = new.layout;
            }
            Change::Camera { camera, new: Some(new), .. } => {
                self.cameras_mut().insert(*camera, new.clone());
            }
            Change::Camera { camera, new: None, .. } => {
                self.cameras_mut().remove(camera);
            }
            Change::CameraParameter { camera, new, .. } => {
                let Some(camera) = self.cameras_mut().get_mut(camera) else { return Err(conflict(self)) };
                set_camera(camera, new);
            }
        }
        self.take_number(change.number());
        Ok(())
    }

    fn bendy_mut(&mut self, light: LightId) -> Option<&mut BendyLight> {
        match &mut self.lights_mut().get_mut(&light)?.light.kind {
            LightKind::Bendy(bendy) => Some(bendy),
            LightKind::Spot(_) => None,
        }
    }

    /// Whether what `change` touched is valid.
    fn check(&self, change: &Change) -> Result<(), EditError> {
        let too_many = |what, limit| Err(EditError::TooMany { what, limit });
        if self.lights().len() > MAX_LIGHTS {
            return too_many("lights", MAX_LIGHTS);
        }
        if self.cameras().len() > MAX_CAMERAS {
            return too_many("cameras", MAX_CAMERAS);
        }
        if let Change::Scene { new: Some(scene), .. } = change {
            check_name(&scene.name)?;
        }
        if let Some(id) = change.light()
            && let Some(placed) = self.lights().get(&id)
        {
            check_name(&placed.light.name)?;
            let invalid = |reason| EditError::InvalidLight { light: self.light_name(id), reason };
            check_light(&placed.light).map_err(invalid)?;
        }
        if let Change::Camera { camera, .. } | Change::CameraParameter { camera, .. } = change
            && let Some(camera) = self.cameras().get(camera)
        {
            check_name(&camera.name)?;
            camera.check().map_err(EditError::InvalidCamera)?;
        }
        Ok(())
    }
}

fn check_name(name: &str) -> Result<(), EditError> {
    let too_long = EditError::TooMany { what: "bytes in a name", limit: MAX_NAME_BYTES };
    if name.len() <= MAX_NAME_BYTES { Ok(()) } else { Err(too_long) }
}

fn check_light(light: &Light) -> Result<(), LightError> {
    match &light.kind {
        LightKind::Bendy(bendy) => Tube::<f64>::new(bendy).map(drop),
        LightKind::Spot(spot) => check_spot(spot),
    }
}

fn light(document: &Document, id: LightId) -> Result<&PlacedLight, EditError> {
    document.lights().get(&id).ok_or(EditError::NoLight(id))
}

fn camera(document: &Document, id: CameraId) -> Result<&Camera, EditError> {
    document.cameras().get(&id).ok_or(EditError::NoCamera(id))
}

fn bendy(document: &Document, id: LightId) -> Result<(&PlacedLight, &BendyLight), EditError> {
    let placed = light(document, id)?;
    match &placed.light.kind {
        LightKind::Bendy(bendy) => Ok((placed, bendy)),
        LightKind::Spot(_) => {
            let light = document.light_name(id);
            Err(EditError::WrongKind { light, kind: "spotlight", what: "control points" })
        }
    }
}

fn added_light(number: u64, light: &Light) -> Change {
    let placed = PlacedLight { layout: Layout(number), light: light.clone() };
    Change::Light { light: LightId(number), old: None, new: Some(Box::new(placed)) }
}

/// Everything of the scene before goes, everything of the new one comes.
fn load_scene(
    document: &Document,
    asset: AssetHash,
    name: &str,
    find_scene: FindScene,
) -> Result<Vec<Change>, EditError> {
    let scene = find_scene(&asset).ok_or(EditError::UnknownAsset(asset))?;
    let lights = document.lights().iter();
    let mut changes: Vec<_> = lights
        .map(|(&light, old)| Change::Light { light, old: Some(Box::new(old.clone())), new: None })
        .collect();
    let cameras = document.cameras().iter();
    changes.extend(cameras.map(|(&camera, old)| Change::Camera {
        camera,
        old: Some(old.clone()),
        new: None,
    }));
    let new = Some(SceneRef { asset, name: name.into() });
    changes.push(Change::Scene { old: document.scene_ref().cloned(), new });
    let mut numbers = document.next_number()..;
    changes.extend(numbers.by_ref().zip(&scene.lights).map(|(number, light)| added_light(number, light)));
    changes.extend(numbers.zip(&scene.cameras).map(|(number, camera)| Change::Camera {
        camera: CameraId(number),
        old: None,
        new: Some(camera.clone()),
    }));
    Ok(changes)
}

fn parameter_change(document: &Document, id: LightId, new: LightParameter) -> Result<Change, EditError> {
    let now = &light(document, id)?.light;
    let kind = match now.kind {
        LightKind::Bendy(_) => "BendyLight",
        LightKind::Spot(_) => "spotlight",
    };
    let missing = || EditError::WrongKind { light: document.light_name(id), kind, what: new.name() };
    let old = light_parameter(now, &new).ok_or_else(missing)?;
    Ok(Change::LightParameter { light: id, old, new })
}

fn camera_change(id: CameraId, now: &Camera, new: CameraParameter) -> Change {
    Change::CameraParameter { camera: id, old: camera_parameter(now, &new), new }
}
