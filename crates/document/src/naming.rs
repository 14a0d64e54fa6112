//! Names of lights, cameras and properties for messages.

use std::fmt::Write;

use drag::{PinKind, PinTarget};
use light::{LightId, ParameterOwner};

use crate::{CameraId, Change, Document, LightPin, PinId};

/// Maximum number of characters of a quoted name.
const MAX_QUOTED_CHARS: usize = 40;

impl Document {
    /// Returns the name of a light, in quotes; `light` and its id if it has no name or does not exist.
    pub fn light_name(&self, id: LightId) -> String {
        let name = self.lights().get(&id).map(|placed| placed.light.light().name());
        quoted(name.unwrap_or_default()).unwrap_or_else(|| format!("light {id}"))
    }

    /// Returns the name of a camera, as [`Self::light_name`].
    pub fn camera_name(&self, id: CameraId) -> String {
        let name = self.cameras().get(&id).map(|camera| camera.name.as_str());
        quoted(name.unwrap_or_default()).unwrap_or_else(|| format!("camera {id}"))
    }

    /// Returns the description of a pin, in quotes, as on the page: `“This shadow of blue vase”`.
    pub fn pin_name(&self, id: PinId) -> String {
        let Some(LightPin { pin, .. }) = self.pins().get(&id) else { return format!("pin {id}") };
        let kept = match pin.kind {
            PinKind::Direction => "Direction",
            PinKind::Look => "Look",
            PinKind::Lit => "Lit",
            PinKind::Shadowed => "In shadow",
            PinKind::Shadow => "This shadow",
            PinKind::Coordinates => "Light coordinates",
        };
        let node = if let PinTarget::Node(node) = &pin.at { Some(node) } else { None };
        let on_node = node.map_or_else(|| kept.into(), |node| format!("{kept} of {node}"));
        let text = pin.caster.as_ref().map_or(on_node, |caster| format!("{kept} of {caster}"));
        quoted(&text).unwrap_or(text)
    }
}

/// Puts a name in quotes, shortened if it is long; `None` for an empty one.
pub fn quoted(name: &str) -> Option<String> {
    let mut said: String =
        name.trim().chars().take(MAX_QUOTED_CHARS).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if name.trim().chars().nth(MAX_QUOTED_CHARS).is_some() {
        said.push('…');
    }
    (!said.is_empty()).then(|| format!("“{said}”"))
}

impl Change {
    /// Describes the changed property, for people, with names from `document`:
    /// `the radius of control point 2 of “key”`.
    pub fn subject(&self, document: &Document) -> String {
        let light = |id: &LightId| self.own_light_name().unwrap_or_else(|| document.light_name(*id));
        match self {
            Self::Scene { .. } => "the scene".into(),
            Self::Light { light: id, .. } => light(id),
            Self::LightParameter { light: id, parameter, .. } => {
                format!("the {} of {}", words(parameter.name), light(id))
            }
            Self::Point { light: id, point, parameter, .. } => {
                format!("the {} of control point {point} of {}", words(parameter.name), light(id))
            }
            Self::ControlPoints { light: id, .. } => format!("the control points of {}", light(id)),
            Self::Camera { camera, old, new } => {
                let name = old.as_ref().or(new.as_ref()).and_then(|camera| quoted(&camera.name));
                name.unwrap_or_else(|| document.camera_name(*camera))
            }
            Self::Pin { .. } => {
                let whose = self.light().map_or_else(String::new, |id| format!(" of {}", document.light_name(id)));
                format!("a pin{whose}")
            }
            Self::CameraParameter { camera, new, .. } => {
                format!("the {} of {}", words(new.name()), document.camera_name(*camera))
            }
        }
    }

    /// Describes the change, for people: `adding “key”`, `the radius of control point 2 of “key”`.
    fn describe(&self, document: &Document) -> String {
        let subject = self.subject(document);
        match self {
            Self::Scene { new: Some(scene), .. } => {
                format!("loading {}", quoted(&scene.name).unwrap_or(subject))
            }
            Self::Light { old: None, .. } | Self::Camera { old: None, .. } | Self::Pin { old: None, .. } => {
                format!("adding {subject}")
            }
            Self::Light { old: Some(old), new: Some(new), .. } => {
                match [old, new].map(|placed| placed.light.light().owner() == ParameterOwner::Bendy) {
                    [false, true] => format!("bending {subject}"),
                    [true, false] => format!("straightening {subject}"),
                    // A change of a group, which has several effects.
                    _ => subject,
                }
            }
            Self::Light { new: None, .. } | Self::Camera { new: None, .. } | Self::Pin { new: None, .. } => {
                format!("removing {subject}")
            }
            Self::Scene { .. }
            | Self::LightParameter { .. }
            | Self::Point { .. }
            | Self::ControlPoints { .. }
            | Self::Camera { .. }
            | Self::CameraParameter { .. }
            | Self::Pin { .. } => subject,
        }
    }

    /// Returns the name of the light in the change itself, if the change adds or removes the light.
    fn own_light_name(&self) -> Option<String> {
        match self {
            Self::Light { old, new, .. } => {
                old.as_ref().or(new.as_ref()).and_then(|placed| quoted(placed.light.light().name()))
            }
            _ => None,
        }
    }
}

/// Describes the effect of `changes`, for people, with names from `document`. The first of several changes stands for
/// all, and a scene stands for its lights and cameras.
pub fn describe_changes(changes: &[Change], document: &Document) -> String {
    let scene = changes.iter().find(|change| matches!(change, Change::Scene { .. }));
    let Some(first) = scene.or(changes.first()) else { return "nothing".into() };
    let mut said = first.describe(document);
    if scene.is_none() && changes.len() > 1 {
        let _ = write!(said, " and {} more", changes.len() - 1);
    }
    said
}

/// Splits a camelCase name into words: `cone angle` for `coneAngle`.
fn words(name: &str) -> String {
    name.chars().fold(String::new(), |mut words, c| {
        if c.is_uppercase() {
            words.push(' ');
        }
        words.extend(c.to_lowercase());
        words
    })
}
