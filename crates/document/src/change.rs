//! Changes: the effect of a command, each on one property, with its old and new value.

use std::mem::{discriminant, swap};
use std::sync::Arc;

use drag::{DragLimit, DragRefusal};
use light::{CheckedLight, LightError, LightId, Parameter, ParameterTouches, UndrawableLight, Value};
use thiserror::Error;

use crate::{
    AssetHash, CameraId, CameraParameter, ControlPoints, LightPin, NumberedLight, PinId, PointNumbering, SceneRef,
};

use scene::Camera;

/// Old and new value of one property. A change is of a property and not of an object, so that an undo of one person's
/// change leaves another person's change of the same light.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Another scene.
    Scene {
        old: Option<SceneRef>,
        new: Option<SceneRef>,
    },
    /// Addition (`old` is `None`), removal (`new` is `None`) or replacement of a light.
    Light {
        light: LightId,
        old: Option<NumberedLight>,
        new: Option<NumberedLight>,
    },
    LightParameter {
        light: LightId,
        parameter: &'static Parameter,
        old: Value,
        new: Value,
    },
    Point {
        light: LightId,
        /// Numbering of the light's control points, in which `point` is an index.
        layout: PointNumbering,
        point: usize,
        parameter: &'static Parameter,
        old: Value,
        new: Value,
    },
    /// Insertion or removal of control points, which renumbers them.
    ControlPoints {
        light: LightId,
        old: ControlPoints,
        new: ControlPoints,
    },
    /// Addition or removal of a camera.
    Camera {
        camera: CameraId,
        old: Option<Camera>,
        new: Option<Camera>,
    },
    /// Addition, removal or replacement of a pin.
    Pin {
        pin: PinId,
        /// `None` for an addition.
        old: Option<LightPin>,
        /// `None` for a removal.
        new: Option<LightPin>,
    },
    /// Parameter of a camera. Both values are of the same parameter.
    CameraParameter {
        camera: CameraId,
        old: CameraParameter,
        new: CameraParameter,
    },
}

/// Reason why a command or a change is refused. The message says what to do.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EditError {
    #[error("there is no light {0}: choose one of the document's lights")]
    NoLight(LightId),
    #[error("there is no camera {0}: choose one of the document's cameras")]
    NoCamera(CameraId),
    #[error("there is no pin {0}: choose one of the document's pins")]
    NoPin(PinId),
    /// Id or name that no light or camera has.
    #[error("there is no {what} {name}: give the id or the name of one of the document's")]
    UnknownName {
        /// Kind: a light or a camera.
        what: &'static str,
        /// Name as given, in quotes.
        name: String,
    },
    /// Name that several lights or cameras have.
    #[error("{name} is the name of more than one {what}, with ids {ids}: give one of these")]
    AmbiguousName {
        /// Kind: a light or a camera.
        what: &'static str,
        /// In quotes.
        name: String,
        /// First of their ids, separated by commas.
        ids: String,
    },
    /// Pin whose position is not finite.
    #[error("a pin lies at three finite numbers: give it a place on a surface")]
    InvalidPin,
    /// Drag in a picture without pixels, or from or to a position that is not finite.
    #[error("a drag is made in a picture: give its size, 1 or more each way, and where it begins and ends")]
    EmptyViewport,
    /// Drag of a feature, or edit of a light with hard pins, without its scene. The field is the light's name.
    #[error("the scene is not at hand, and where {0} lies in it unknown: send the edit again")]
    NotSolved(String),
    /// Feature that cannot be dragged.
    #[error("{light}: {}", sentence(*reason))]
    DragRefused {
        /// Light by its [`Document::light_name`](crate::Document::light_name).
        light: String,
        /// Reason that the drag is refused, other than a pin.
        reason: DragRefusal,
    },
    /// Pin whose condition does not hold at the start, so that no drag can keep it.
    #[error("{light}: its pin {pin} does not hold before anything moves: remove it, or make it soft")]
    PinDoesNotHold {
        /// Light by its [`Document::light_name`](crate::Document::light_name).
        light: String,
        /// Condition of the pin, in quotes.
        pin: String,
    },
    /// Pin that keeps a feature from a third of its way.
    #[error(
        "{light}: its pin {pin} holds the feature back before a third of the way: drag less far, remove it, or make it \
         soft"
    )]
    PinLimits {
        /// Light by its [`Document::light_name`](crate::Document::light_name).
        light: String,
        /// Condition of the pin, in quotes.
        pin: String,
    },
    /// Hard pin that an edit other than a drag of a feature would break.
    #[error("{light}: its pin {pin} would no longer hold: change less, remove the pin, make it soft, or ignore pins")]
    PinBreaks {
        /// Light by its [`Document::light_name`](crate::Document::light_name).
        light: String,
        /// Condition of the pin, in quotes.
        pin: String,
    },
    #[error("{light} has {count} control points and none with index {point}: choose 0 to {}", count - 1)]
    NoPoint {
        /// Light by its [`Document::light_name`](crate::Document::light_name).
        light: String,
        point: usize,
        /// Number of the light's control points.
        count: usize,
    },
    /// Parameter that control points do not have.
    #[error("a control point has no {0}: set one of its position, radius, intensity and color")]
    NoPointParameter(&'static str),
    /// Property that lights of this shape do not have.
    #[error("{light} is a {kind} and has no {what}: choose a light of the other kind")]
    WrongKind {
        /// Light by its [`Document::light_name`](crate::Document::light_name).
        light: String,
        /// Shape of the light.
        kind: &'static str,
        /// Missing property.
        what: &'static str,
    },
    /// Edit of the source as a control point.
    #[error("control point 0 is the light's source: place the whole light instead")]
    Source,
    /// Light that could not be evaluated.
    #[error("{light}: {reason}")]
    InvalidLight {
        /// Light by its [`Document::light_name`](crate::Document::light_name).
        light: String,
        reason: LightError,
    },
    /// Light that no picture could show.
    #[error("{0}")]
    Undrawable(#[from] UndrawableLight),
    /// Camera that makes no picture.
    #[error("the camera's {0}: correct it")]
    InvalidCamera(&'static str),
    /// Scene that is not in the assets.
    #[error("the scene {0} is not here: add its file to the assets first")]
    UnknownAsset(AssetHash),
    /// Too many control points or pins chosen for a drag.
    #[error("at most {limit} {what} can be chosen for a drag: choose fewer")]
    TooManyChosen {
        /// Kind: control points or pins.
        what: &'static str,
        /// Maximum number for one drag.
        limit: usize,
    },
    /// Too many objects of one kind in the document.
    #[error("a document holds at most {limit} {what}: remove some first")]
    TooMany { what: &'static str, limit: usize },
    /// Text of a camera or a scene that is too long.
    #[error("`{field}` has more than {limit} bytes: shorten it")]
    TooLong {
        field: &'static str,
        /// Maximum number of bytes.
        limit: usize,
    },
    /// Old value of a change that the document does not hold. The field is the property's name.
    #[error("the document does not hold what the change of {0} starts from: the log does not belong to it")]
    Conflict(String),
}

impl Change {
    /// Returns the change with old and new value exchanged.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let mut inverse = self.clone();
        match &mut inverse {
            Self::Scene { old, new } => swap(old, new),
            Self::Light { old, new, .. } => swap(old, new),
            Self::LightParameter { old, new, .. } | Self::Point { old, new, .. } => swap(old, new),
            Self::ControlPoints { old, new, .. } => swap(old, new),
            Self::Camera { old, new, .. } => swap(old, new),
            Self::Pin { old, new, .. } => swap(old, new),
            Self::CameraParameter { old, new, .. } => swap(old, new),
        }
        inverse
    }

    /// Returns the changes that take `changes` back.
    pub fn inverses(changes: &[Self]) -> Vec<Self> {
        changes.iter().rev().map(Self::inverse).collect()
    }

    /// Takes the new value of `later`, a change of the same property of a light or camera.
    pub(crate) fn extend_with(&mut self, later: &Self) {
        match (self, later) {
            (Self::LightParameter { new, .. }, Self::LightParameter { new: later, .. })
            | (Self::Point { new, .. }, Self::Point { new: later, .. }) => new.clone_from(later),
            (Self::CameraParameter { new, .. }, Self::CameraParameter { new: later, .. }) => new.clone_from(later),
            _ => {}
        }
    }

    /// Returns true if old and new are values of one property, of its type.
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

    /// Returns the largest id or numbering that the change adds to the document; 0 if it adds none.
    pub(crate) fn largest_new_number(&self) -> u64 {
        match self {
            Self::Light { light, new: Some(new), .. } => light.0.max(new.layout.0),
            Self::ControlPoints { new, .. } => new.layout.0,
            Self::Camera { camera, new: Some(_), .. } => camera.0,
            Self::Pin { pin, new: Some(_), .. } => pin.0,
            _ => 0,
        }
    }

    /// Returns the light that the change touches.
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

    /// Returns true if the change sets the property of `earlier`, a change of a light.
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

    /// Caches that the change invalidates. A camera invalidates none, since views have their own cameras. A pin affects
    /// only later drags.
    pub fn touches(&self) -> ParameterTouches {
        match self {
            Self::Scene { .. } => ParameterTouches::Scene,
            Self::Light { .. } | Self::ControlPoints { .. } => ParameterTouches::ShadowMap,
            Self::LightParameter { parameter, .. } | Self::Point { parameter, .. } => parameter.touches(),
            Self::Camera { .. } | Self::CameraParameter { .. } | Self::Pin { .. } => ParameterTouches::Nothing,
        }
    }

    /// Makes the change that adds a light under the number `number`.
    pub(crate) fn added_light(number: u64, light: &Arc<CheckedLight>) -> Self {
        let placed = NumberedLight { layout: PointNumbering(number), light: Arc::clone(light) };
        Self::Light { light: LightId(number), old: None, new: Some(placed) }
    }

    /// Returns true if a picture can show the change.
    pub fn changes_picture(&self) -> bool {
        self.touches() > ParameterTouches::Nothing
    }
}

/// Describes why a feature cannot be dragged, and what to do.
fn sentence(reason: DragRefusal) -> String {
    match reason {
        DragRefusal::NothingAtStart => "there is no surface where the drag begins: begin on one".into(),
        DragRefusal::NothingAtEnd => {
            "there is no surface under the cursor, or its links leave that out: go to one that it lights".into()
        }
        DragRefusal::OutsideTheLight => {
            "the surface where the drag begins is not in its light or left out by its links: begin on another".into()
        }
        DragRefusal::NoShadow => "it throws no shadow where the drag begins: begin in one of its shadows".into(),
        DragRefusal::NotBendy => "it has no control points: drag it as a whole, or bend it first".into(),
        DragRefusal::NoSuchPoint => "control points that can be dragged are 1 to the last: choose of those".into(),
        DragRefusal::NoWeight => {
            "no control point that is chosen does anything where the drag begins: choose one that does".into()
        }
        DragRefusal::TooLittleRoom => {
            "there is too little room, or no control point, behind what throws the shadow: choose another way".into()
        }
        DragRefusal::PinDoesNotHold(_) => {
            "a pin of it does not hold before anything moves: remove it, or make it soft".into()
        }
        DragRefusal::Limited(limit) => {
            format!("before a third of the way {}: drag less far, or choose other control points", limit_clause(limit))
        }
    }
}

/// Describes what would happen if a feature went on.
fn limit_clause(limit: DragLimit) -> &'static str {
    match limit {
        DragLimit::Fold => "the tube would fold",
        DragLimit::Overlap => "the tube would overlap itself, which `allowOverlap` of the light allows",
        DragLimit::Radius => "a radius would be negative",
        DragLimit::TubeEdge => "the feature would lie outside of the light",
        DragLimit::NoDescent => "no light nearby has the feature where it can be seen",
        DragLimit::SourceInside => "the source would go through a surface",
        DragLimit::Pin(_) => "a pin would not hold",
        DragLimit::TooMuchWork => "the search takes too much work",
    }
}

impl CameraParameter {
    /// Returns the name, as in JSON.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Name(_) => "name",
            Self::Translation(_) => "translation",
            Self::Rotation(_) => "rotation",
            Self::Projection(_) => "projection",
        }
    }
}
