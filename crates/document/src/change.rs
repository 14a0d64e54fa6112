//! What a command does: changes, each of one property, with its old and its new value.

use std::mem::discriminant;

use drag::DragRefusal;
use light::{LightError, LightId, Parameter, ParameterTouches, UndrawableLight, Value};
use thiserror::Error;

use crate::{
    AssetHash, CameraId, CameraParameter, ControlPoints, LightPin, NumberedLight, PinId, PointNumbering,
    SceneRef,
};

use scene::Camera;

/// One property's old and new value. Per property and not per object, so that taking one person's change back
/// leaves another's of the same light.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Another scene's geometry.
    Scene {
        /// Before.
        old: Option<SceneRef>,
        /// After.
        new: Option<SceneRef>,
    },
    /// A light that comes (`old` is `None`) or goes (`new` is `None`).
    Light {
        /// Its id.
        light: LightId,
        /// The light that was there.
        old: Option<NumberedLight>,
        /// The light that is there now.
        new: Option<NumberedLight>,
    },
    /// A parameter of a light.
    LightParameter {
        /// The light.
        light: LightId,
        /// The row of the table.
        parameter: &'static Parameter,
        /// The value that it had.
        old: Value,
        /// The value that it has now.
        new: Value,
    },
    /// A parameter of a control point.
    Point {
        /// The light.
        light: LightId,
        /// The numbering that `point` counts in.
        layout: PointNumbering,
        /// The control point's index.
        point: usize,
        /// The row of the table.
        parameter: &'static Parameter,
        /// The value that it had.
        old: Value,
        /// The value that it has now.
        new: Value,
    },
    /// Control points that were renumbered.
    ControlPoints {
        /// Of which light.
        light: LightId,
        /// Before.
        old: ControlPoints,
        /// After.
        new: ControlPoints,
    },
    /// A camera that comes or goes.
    Camera {
        /// Which.
        camera: CameraId,
        /// Before.
        old: Option<Camera>,
        /// After.
        new: Option<Camera>,
    },
    /// A pin that comes, goes, or becomes another.
    Pin {
        /// The pin that it is of.
        pin: PinId,
        /// What it held; `None` where it comes.
        old: Option<LightPin>,
        /// What it holds; `None` where it goes.
        new: Option<LightPin>,
    },
    /// A parameter of a camera; both values are of the same parameter.
    CameraParameter {
        /// Of which.
        camera: CameraId,
        /// Before.
        old: CameraParameter,
        /// After.
        new: CameraParameter,
    },
}

/// Why a command or a change is refused. Each sentence says what to do.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EditError {
    /// No such light.
    #[error("there is no light {0}: choose one of the document's lights")]
    NoLight(LightId),
    /// No such camera.
    #[error("there is no camera {0}: choose one of the document's cameras")]
    NoCamera(CameraId),
    /// No such pin.
    #[error("there is no pin {0}: choose one of the document's pins")]
    NoPin(PinId),
    /// Nothing of that id or name.
    #[error("there is no {what} {name}: give the id or the name of one of the document's")]
    UnknownName {
        /// A light or a camera.
        what: &'static str,
        /// In quotes, as it was called.
        name: String,
    },
    /// A name that several have.
    #[error("{name} is the name of more than one {what}, with ids {ids}: give one of these")]
    AmbiguousName {
        /// A light or a camera.
        what: &'static str,
        /// In quotes.
        name: String,
        /// The first of these, with commas between.
        ids: String,
    },
    /// A pin that lies nowhere.
    #[error("a pin lies at three finite numbers: give it a place on a surface")]
    InvalidPin,
    /// A picture without pixels, or a place in none.
    #[error("a drag is made in a picture: give its size, 1 or more each way, and where it begins and ends")]
    EmptyViewport,
    /// A drag of a feature whose scene is not at hand.
    #[error("the scene is not at hand, and where {0} lies in it unknown: send the drag again")]
    DragNotSolved(String),
    /// A feature that cannot be dragged.
    #[error("{light}: {}", sentence(*reason))]
    DragRefused {
        /// Which light, as [`Document::light_name`](crate::Document::light_name) says it.
        light: String,
        /// Why, other than for a pin.
        reason: DragRefusal,
    },
    /// A pin that holds what is not so, which no drag can keep.
    #[error("{light}: its pin {pin} does not hold before anything moves: remove it, or make it soft")]
    PinDoesNotHold {
        /// Which light, as [`Document::light_name`](crate::Document::light_name) says it.
        light: String,
        /// What the pin keeps, in quotes.
        pin: String,
    },
    /// No such control point.
    #[error("{light} has {count} control points and none with index {point}: choose 0 to {}", count - 1)]
    NoPoint {
        /// Of which light, as [`Document::light_name`](crate::Document::light_name) says it.
        light: String,
        /// The index.
        point: usize,
        /// How many it has.
        count: usize,
    },
    /// A parameter that control points do not have.
    #[error("a control point has no {0}: set one of its position, radius, intensity and color")]
    NoPointParameter(&'static str),
    /// The light has no such property, being of the other kind.
    #[error("{light} is a {kind} and has no {what}: choose a light of the other kind")]
    WrongKind {
        /// Which, as [`Document::light_name`](crate::Document::light_name) says it.
        light: String,
        /// What it is.
        kind: &'static str,
        /// What it does not have.
        what: &'static str,
    },
    /// The source cannot be edited as a control point.
    #[error("control point 0 is the light's source: place the whole light instead")]
    Source,
    /// The light could not be evaluated.
    #[error("{light}: {reason}")]
    InvalidLight {
        /// Which, as [`Document::light_name`](crate::Document::light_name) says it.
        light: String,
        /// What is wrong with it.
        reason: LightError,
    },
    /// No picture could show the light.
    #[error("{0}")]
    Undrawable(#[from] UndrawableLight),
    /// The camera makes no picture.
    #[error("the camera's {0}: correct it")]
    InvalidCamera(&'static str),
    /// A scene that is not at hand.
    #[error("the scene {0} is not here: add its file to the assets first")]
    UnknownAsset(AssetHash),
    /// Too much was chosen for a drag.
    #[error("at most {limit} {what} can be chosen for a drag: choose fewer")]
    TooManyChosen {
        /// Control points or pins.
        what: &'static str,
        /// Count of these that one drag takes.
        limit: usize,
    },
    /// The document would hold too much.
    #[error("a document holds at most {limit} {what}: remove some first")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many it may hold.
        limit: usize,
    },
    /// Text of a camera or a scene that is too long.
    #[error("`{field}` has more than {limit} bytes: shorten it")]
    TooLong {
        /// Which.
        field: &'static str,
        /// How many it may have.
        limit: usize,
    },
    /// The document does not hold a change's old value.
    #[error("the document does not hold what the change of {0} starts from: the log does not belong to it")]
    Conflict(String),
}

impl Change {
    /// The change that takes this one back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        match self.clone() {
            Self::Scene { old, new } => Self::Scene { old: new, new: old },
            Self::Light { light, old, new } => Self::Light { light, old: new, new: old },
            Self::LightParameter { light, parameter, old, new } => {
                Self::LightParameter { light, parameter, old: new, new: old }
            }
            Self::Point { light, layout, point, parameter, old, new } => {
                Self::Point { light, layout, point, parameter, old: new, new: old }
            }
            Self::ControlPoints { light, old, new } => Self::ControlPoints { light, old: new, new: old },
            Self::Camera { camera, old, new } => Self::Camera { camera, old: new, new: old },
            Self::Pin { pin, old, new } => Self::Pin { pin, old: new, new: old },
            Self::CameraParameter { camera, old, new } => {
                Self::CameraParameter { camera, old: new, new: old }
            }
        }
    }

    /// Leads to where `later`, a change of the same property of a light or camera, does.
    pub(crate) fn extend_with(&mut self, later: &Self) {
        match (self, later) {
            (Self::LightParameter { new, .. }, Self::LightParameter { new: later, .. })
            | (Self::Point { new, .. }, Self::Point { new: later, .. }) => new.clone_from(later),
            (Self::CameraParameter { new, .. }, Self::CameraParameter { new: later, .. }) => {
                new.clone_from(later);
            }
            _ => {}
        }
    }

    /// Whether old and new are values of one property that can be.
    pub(crate) fn is_of_one_property(&self) -> bool {
        match self {
            Self::LightParameter { parameter, new, .. } | Self::Point { parameter, new, .. } => {
                parameter.accepts_type_of(new)
            }
            Self::CameraParameter { old, new, .. } => discriminant(old) == discriminant(new),
            Self::Scene { .. }
            | Self::Light { .. }
            | Self::ControlPoints { .. }
            | Self::Camera { .. }
            | Self::Pin { .. } => true,
        }
    }

    /// The largest number that it brings into the document as an id or a layout, 0 where it brings none.
    pub(crate) fn largest_new_number(&self) -> u64 {
        match self {
            Self::Light { light, new: Some(new), .. } => light.0.max(new.layout.0),
            Self::ControlPoints { new, .. } => new.layout.0,
            Self::Camera { camera, new: Some(_), .. } => camera.0,
            Self::Pin { pin, new: Some(_), .. } => pin.0,
            _ => 0,
        }
    }

    /// The light that it touches.
    pub fn light(&self) -> Option<LightId> {
        match *self {
            Self::Pin { ref old, ref new, .. } => old.as_ref().or(new.as_ref()).map(|pin| pin.light),
            Self::Light { light, .. }
            | Self::LightParameter { light, .. }
            | Self::Point { light, .. }
            | Self::ControlPoints { light, .. } => Some(light),
            Self::Scene { .. } | Self::Camera { .. } | Self::CameraParameter { .. } => None,
        }
    }

    /// Whether it gives a new value to what `earlier`, a change of a light, is of.
    pub fn overrides(&self, earlier: &Self) -> bool {
        let is_of_points = |change: &Self| matches!(change, Self::Point { .. } | Self::ControlPoints { .. });
        let same_parameter = match (self, earlier) {
            (Self::Light { .. }, _) | (_, Self::Light { .. }) => true,
            (Self::LightParameter { parameter: a, .. }, Self::LightParameter { parameter: b, .. }) => a == b,
            (Self::Point { point: p, parameter: a, .. }, Self::Point { point: q, parameter: b, .. }) => {
                p == q && a == b
            }
            (Self::Pin { pin: a, .. }, Self::Pin { pin: b, .. }) => a == b,
            _ => is_of_points(self) && is_of_points(earlier),
        };
        same_parameter && self.light().is_some() && self.light() == earlier.light()
    }

    /// What it makes stale of what is kept from picture to picture. A camera never shows: views have cameras of their own, and a pin
    /// holds only what is dragged later.
    pub fn touches(&self) -> ParameterTouches {
        match self {
            Self::Scene { .. } => ParameterTouches::Scene,
            Self::Light { .. } | Self::ControlPoints { .. } => ParameterTouches::ShadowMap,
            Self::LightParameter { parameter, .. } | Self::Point { parameter, .. } => parameter.touches(),
            Self::Camera { .. } | Self::CameraParameter { .. } | Self::Pin { .. } => {
                ParameterTouches::Nothing
            }
        }
    }

    /// Whether a picture can show it.
    pub fn changes_picture(&self) -> bool {
        self.touches() > ParameterTouches::Nothing
    }
}

/// Why a feature is not dragged, and what to do.
fn sentence(reason: DragRefusal) -> String {
    match reason {
        DragRefusal::NothingAtStart => "there is no surface where the drag begins: begin on one".into(),
        DragRefusal::NothingAtEnd => {
            "there is no surface under the cursor, or its links leave that out: go to one that it lights"
                .into()
        }
        DragRefusal::OutsideTheLight => {
            "the surface where the drag begins is not in its light or left out by its links: begin on another"
                .into()
        }
        DragRefusal::NoShadow => {
            "it throws no shadow where the drag begins: begin in one of its shadows".into()
        }
        DragRefusal::NotBendy => "it has no control points: drag it as a whole, or bend it first".into(),
        DragRefusal::NoSuchPoint => {
            "control points that can be dragged are 1 to the last: choose of those".into()
        }
        DragRefusal::NoWeight => {
            "no control point that is chosen does anything where the drag begins: choose one that does".into()
        }
        DragRefusal::PinDoesNotHold(_) => {
            "a pin of it does not hold before anything moves: remove it, or make it soft".into()
        }
    }
}

impl CameraParameter {
    /// Its name, as in JSON.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Name(_) => "name",
            Self::Translation(_) => "translation",
            Self::Rotation(_) => "rotation",
            Self::Projection(_) => "projection",
        }
    }
}
