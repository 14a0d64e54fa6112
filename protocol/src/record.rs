//! Changes and records in JSON.

use std::sync::Arc;

use document::{CameraId, EditError, PinId, PointNumbering, was_in_format_2};
use light::{ControlPoint, LightError, LightId, ParameterOwner, Setting};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::conversion::same_variants;
use crate::error::{check_format, from_json};
use crate::format::FORMAT;
use crate::vector::Vec3;
use crate::{
    Camera, CameraParameter, Command, DragOutcome, FileError, Light, LightParameter, Pin, PointParameter, Refused,
    SceneRef,
};

/// Maximum bytes of a record's JSON in full. A record that replaces a document at its limits (256 lights of 258
/// control points) by another such document takes 28 MiB.
pub const MAX_RECORD_BYTES: usize = 32 << 20;

/// [`document::Change`] in JSON. `type` selects the variant (SPEC, section 3).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", deny_unknown_fields)]
pub enum Change {
    /// Replacement of the scene's geometry.
    Scene { old: Option<SceneRef>, new: Option<SceneRef> },
    /// Addition, removal or replacement of a light.
    Light { light: u64, old: Option<Box<PlacedLight>>, new: Option<Box<PlacedLight>> },
    /// Change of a light's parameter.
    LightParameter { light: u64, old: LightParameter, new: LightParameter },
    /// Change of a control point's parameter.
    Point { light: u64, layout: u64, point: usize, old: PointParameter, new: PointParameter },
    /// Renumbering of a light's control points.
    ControlPoints { light: u64, old: ControlPoints, new: ControlPoints },
    /// Addition or removal of a camera.
    Camera { camera: u64, old: Option<Camera>, new: Option<Camera> },
    /// Change of one parameter of a camera, such as its position.
    CameraParameter { camera: u64, old: CameraParameter, new: CameraParameter },
    /// Addition, removal or change of a pin.
    Pin { pin: u64, old: Option<Pin>, new: Option<Pin> },
}

/// [`document::NumberedLight`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct PlacedLight {
    /// Numbering of the control points (DOC-2).
    pub layout: u64,
    pub light: Light,
}

/// [`document::ControlPoints`] in JSON. Each list has one entry per control point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ControlPoints {
    /// Numbering of the control points (DOC-2).
    pub layout: u64,
    /// Light-local positions.
    pub points: Vec<Vec3>,
    /// Light-local radii.
    pub radii: Vec<f64>,
    /// Colors in linear RGB.
    pub colors: Vec<Vec3>,
    pub intensities: Vec<f64>,
}

/// [`edit::Actor`] in JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Actor {
    /// Id of a person or program, the same over all connections.
    pub id: String,
    /// Name for people.
    pub name: String,
}

/// [`edit::UndoScope`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Scope {
    /// Steps of the actor who asks.
    Mine,
    /// Steps of all actors.
    Session,
}

/// [`edit::Action`] in JSON. `type` selects the variant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", deny_unknown_fields)]
pub enum Action {
    /// Execution of one command.
    Edit {
        command: Command,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        rebased: bool,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        outcome: Option<Box<DragOutcome>>,
    },
    /// Last command of a drag.
    Gesture {
        command: Command,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        rebased: bool,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        outcome: Option<Box<DragOutcome>>,
    },
    /// Commands committed as one step.
    Group {
        edits: Vec<RecordedCommand>,
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        rebased: bool,
    },
    /// Undo of a step.
    Undo { scope: Scope, target: u64, skipped: Vec<String> },
    /// Redo of a step that was undone.
    Redo { scope: Scope, target: u64, skipped: Vec<String> },
}

/// [`edit::RecordedCommand`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct RecordedCommand {
    pub command: Command,
    /// Outcome, if the command drags a feature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outcome: Option<Box<DragOutcome>>,
}

/// [`edit::Record`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Record {
    /// Format of the record: [`FORMAT`].
    pub format: u32,
    /// Sequence number. Records count from 1 without gaps.
    pub seq: u64,
    /// Milliseconds since 1970 UTC.
    pub time_ms: u64,
    pub actor: Actor,
    /// Operation id, chosen by the sender.
    pub op_id: String,
    /// Request that led to the record.
    pub action: Action,
    /// Changes of the document.
    pub changes: Vec<Change>,
}

impl Record {
    /// Parses a record in full, of any format up to [`FORMAT`]. Fields that a later format added get their
    /// defaults.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        // Checks the format first, because a later format may have unknown fields.
        Self::format_of(text)?;
        from_json(text)
    }

    /// Returns the format of a record, or an error if it is unknown.
    pub fn format_of(text: &str) -> Result<u32, FileError> {
        #[derive(Deserialize)]
        struct Versioned {
            format: u32,
        }
        let Versioned { format } = from_json(text)?;
        check_format(format).map_err(FileError::Format)?;
        Ok(format)
    }

    /// Returns the name of something in the record that formats 1 and 2 did not have. Hashes of those formats
    /// would ignore it.
    fn missing_in_format_2(&self) -> Option<&'static str> {
        let of_command = |command: &Command| match command {
            Command::AddLight { light } => light.missing_in_format_2(),
            Command::SetLight { parameter, .. } => {
                name_missing_in_format_2(&[ParameterOwner::Spot, ParameterOwner::Bendy], &parameter.0)
            }
            Command::SetPoint { parameter, .. } => name_missing_in_format_2(&[ParameterOwner::Point], &parameter.0),
            _ => None,
        };
        let commanded = match &self.action {
            Action::Edit { command, .. } | Action::Gesture { command, .. } => of_command(command),
            Action::Group { .. } => Some("group"),
            Action::Undo { .. } | Action::Redo { .. } => None,
        };
        commanded.or_else(|| self.changes.iter().find_map(Change::missing_in_format_2))
    }

    /// Returns the record as one line of JSON, in full.
    pub fn to_json(&self) -> String {
        crate::log_line::to_line(self)
    }
}

impl Change {
    fn missing_in_format_2(&self) -> Option<&'static str> {
        match self {
            Self::Light { old, new, .. } => {
                [old, new].into_iter().flatten().find_map(|placed| placed.light.missing_in_format_2())
            }
            // Old and new value belong to the same parameter, or the conversion refuses the change.
            Self::LightParameter { new, .. } => name_missing_in_format_2(&[ParameterOwner::Spot, ParameterOwner::Bendy], &new.0),
            Self::Point { new, .. } => name_missing_in_format_2(&[ParameterOwner::Point], &new.0),
            Self::Scene { .. }
            | Self::ControlPoints { .. }
            | Self::Camera { .. }
            | Self::CameraParameter { .. }
            // Hashes of formats 1 and 2 cover pins.
            | Self::Pin { .. } => None,
        }
    }
}

/// Returns the name of the parameter if no owner in `owners` had it in formats 1 and 2.
fn name_missing_in_format_2(owners: &[ParameterOwner], setting: &Setting) -> Option<&'static str> {
    let name = setting.parameter.name;
    (!owners.iter().any(|owner| was_in_format_2(*owner, name))).then_some(name)
}

impl From<&document::NumberedLight> for PlacedLight {
    fn from(placed: &document::NumberedLight) -> Self {
        Self { layout: placed.layout.0, light: Light::from(&*placed.light) }
    }
}

impl TryFrom<PlacedLight> for document::NumberedLight {
    type Error = Refused;

    fn try_from(wire: PlacedLight) -> Result<Self, Refused> {
        Ok(Self { layout: PointNumbering(wire.layout), light: Arc::new(wire.light.try_into()?) })
    }
}

impl From<document::ControlPoints> for ControlPoints {
    fn from(domain: document::ControlPoints) -> Self {
        let points = domain.points.iter();
        Self {
            layout: domain.layout.0,
            points: points.clone().map(|point| point.position.to_array()).collect(),
            radii: points.clone().map(|point| point.radius).collect(),
            colors: points.clone().map(|point| point.color.to_array()).collect(),
            intensities: points.map(|point| point.intensity).collect(),
        }
    }
}

impl TryFrom<ControlPoints> for document::ControlPoints {
    type Error = Refused;

    fn try_from(wire: ControlPoints) -> Result<Self, Refused> {
        let ControlPoints { layout, points, radii, colors, intensities } = wire;
        for (field, count) in [("radii", radii.len()), ("colors", colors.len()), ("intensities", intensities.len())] {
            if count != points.len() {
                return Err(LightError::LengthMismatch { field, count, points: points.len() }.into());
            }
        }
        let point = |i: usize| ControlPoint {
            position: points[i].into(),
            radius: radii[i],
            color: colors[i].into(),
            intensity: intensities[i],
        };
        Ok(Self { layout: PointNumbering(layout), points: (0..points.len()).map(point).collect() })
    }
}

/// Converts the old and the new value of a change, or returns an error if they belong to different parameters.
fn of_one(old: impl Into<Setting>, new: impl Into<Setting>) -> Result<(Setting, Setting), Refused> {
    let (old, new) = (old.into(), new.into());
    if old.parameter == new.parameter {
        return Ok((old, new));
    }
    Err(EditError::Conflict(format!("{} into {}", old.parameter.name, new.parameter.name)).into())
}

fn converted<T, W: for<'a> From<&'a T>>(value: Option<T>) -> Option<W> {
    value.map(|value| (&value).into())
}

impl From<&document::Change> for Change {
    fn from(change: &document::Change) -> Self {
        use document::Change as C;
        match change.clone() {
            C::Scene { old, new } => Self::Scene { old: converted(old), new: converted(new) },
            C::Light { light, old, new } => {
                Self::Light { light: light.0, old: converted(old).map(Box::new), new: converted(new).map(Box::new) }
            }
            C::LightParameter { light, parameter, old, new } => {
                let [old, new] = [old, new].map(|value| Setting { parameter, value }.into());
                Self::LightParameter { light: light.0, old, new }
            }
            C::Point { light, layout, point, parameter, old, new } => {
                let [old, new] = [old, new].map(|value| Setting { parameter, value }.into());
                Self::Point { light: light.0, layout: layout.0, point, old, new }
            }
            C::ControlPoints { light, old, new } => {
                Self::ControlPoints { light: light.0, old: old.into(), new: new.into() }
            }
            C::Camera { camera, old, new } => {
                Self::Camera { camera: camera.0, old: converted(old), new: converted(new) }
            }
            C::Pin { pin, old, new } => Self::Pin { pin: pin.0, old: converted(old), new: converted(new) },
            C::CameraParameter { camera, old, new } => {
                Self::CameraParameter { camera: camera.0, old: old.into(), new: new.into() }
            }
        }
    }
}

impl TryFrom<Change> for document::Change {
    type Error = Refused;

    fn try_from(wire: Change) -> Result<Self, Refused> {
        let scene = |scene: Option<SceneRef>| scene.map(document::SceneRef::try_from).transpose();
        let placed =
            |placed: Option<Box<PlacedLight>>| placed.map(|p| document::NumberedLight::try_from(*p)).transpose();
        Ok(match wire {
            Change::Scene { old, new } => Self::Scene { old: scene(old)?, new: scene(new)? },
            Change::Light { light, old, new } => {
                Self::Light { light: LightId(light), old: placed(old)?, new: placed(new)? }
            }
            Change::LightParameter { light, old, new } => {
                let (Setting { value: old, .. }, Setting { parameter, value: new }) = of_one(old, new)?;
                Self::LightParameter { light: LightId(light), parameter, old, new }
            }
            Change::Point { light, layout, point, old, new } => {
                let (Setting { value: old, .. }, Setting { parameter, value: new }) = of_one(old, new)?;
                Self::Point { light: LightId(light), layout: PointNumbering(layout), point, parameter, old, new }
            }
            Change::ControlPoints { light, old, new } => {
                Self::ControlPoints { light: LightId(light), old: old.try_into()?, new: new.try_into()? }
            }
            Change::Camera { camera, old, new } => {
                Self::Camera { camera: CameraId(camera), old: old.map(Into::into), new: new.map(Into::into) }
            }
            Change::Pin { pin, old, new } => {
                Self::Pin { pin: PinId(pin), old: old.map(Into::into), new: new.map(Into::into) }
            }
            Change::CameraParameter { camera, old, new } => {
                Self::CameraParameter { camera: CameraId(camera), old: old.into(), new: new.into() }
            }
        })
    }
}

impl From<&edit::Actor> for Actor {
    fn from(actor: &edit::Actor) -> Self {
        Self { id: actor.id.clone(), name: actor.name.clone() }
    }
}

impl From<Actor> for edit::Actor {
    fn from(wire: Actor) -> Self {
        Self { id: wire.id, name: wire.name }
    }
}

same_variants!(Scope = edit::UndoScope { Mine, Session });

fn to_outcome(wire: Option<Box<DragOutcome>>) -> Result<Option<Box<document::DragOutcome>>, Refused> {
    wire.map(|wire| (*wire).try_into().map(Box::new).map_err(Refused::Outcome)).transpose()
}

impl From<&edit::Record> for Record {
    fn from(record: &edit::Record) -> Self {
        let boxed = |outcome: Option<Box<_>>| outcome.map(|outcome| Box::new(DragOutcome::from(&*outcome)));
        let action = match record.action.clone() {
            edit::Action::Edit { command, rebased, outcome } => {
                Action::Edit { command: (&command).into(), rebased, outcome: boxed(outcome) }
            }
            edit::Action::Gesture { command, rebased, outcome } => {
                Action::Gesture { command: (&command).into(), rebased, outcome: boxed(outcome) }
            }
            edit::Action::Group { edits, rebased } => {
                let recorded = |edit: edit::RecordedCommand| RecordedCommand {
                    command: (&edit.command).into(),
                    outcome: boxed(edit.outcome),
                };
                Action::Group { edits: edits.into_iter().map(recorded).collect(), rebased }
            }
            edit::Action::Undo { scope, target, skipped } => Action::Undo { scope: scope.into(), target, skipped },
            edit::Action::Redo { scope, target, skipped } => Action::Redo { scope: scope.into(), target, skipped },
        };
        Self {
            format: FORMAT,
            seq: record.seq,
            time_ms: record.time_ms,
            actor: (&record.actor).into(),
            op_id: record.op_id.clone(),
            action,
            changes: record.changes.iter().map(Change::from).collect(),
        }
    }
}

impl TryFrom<Record> for edit::Record {
    type Error = Refused;

    fn try_from(wire: Record) -> Result<Self, Refused> {
        check_format(wire.format)?;
        if let (1 | 2, Some(what)) = (wire.format, wire.missing_in_format_2()) {
            return Err(Refused::Younger { format: wire.format, what });
        }
        let action = match wire.action {
            Action::Edit { command, rebased, outcome } => {
                edit::Action::Edit { command: command.try_into()?, rebased, outcome: to_outcome(outcome)? }
            }
            Action::Gesture { command, rebased, outcome } => {
                edit::Action::Gesture { command: command.try_into()?, rebased, outcome: to_outcome(outcome)? }
            }
            Action::Group { edits, rebased } => {
                let recorded = |RecordedCommand { command, outcome }: RecordedCommand| {
                    let (command, outcome) = (command.try_into()?, to_outcome(outcome)?);
                    Ok::<_, Refused>(edit::RecordedCommand { command, outcome })
                };
                let edits = edits.into_iter().map(recorded).collect::<Result<_, _>>()?;
                edit::Action::Group { edits, rebased }
            }
            Action::Undo { scope, target, skipped } => edit::Action::Undo { scope: scope.into(), target, skipped },
            Action::Redo { scope, target, skipped } => edit::Action::Redo { scope: scope.into(), target, skipped },
        };
        Ok(Self {
            seq: wire.seq,
            time_ms: wire.time_ms,
            actor: wire.actor.into(),
            op_id: wire.op_id,
            action,
            changes: wire.changes.into_iter().map(document::Change::try_from).collect::<Result<_, _>>()?,
        })
    }
}
