//! Drag files: a JSON array of drags, and what comes of them.

use std::fmt;

use drag::{Feature, Landing, Limit, PinKind as Kind, Radii, Refusal, Status};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::error::from_json;
use crate::{FileError, Light};

/// A drag as it is written down. M is the surface seen at `from`, M' the one seen at `to`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drag {
    /// The light, by its name or its index.
    pub light: NameOrIndex,
    /// What is dragged.
    pub kind: DragKind,
    /// The control points that take part; `null` moves the light as a whole.
    #[serde(default)]
    pub points: Option<Vec<usize>>,
    /// What becomes of radii.
    #[serde(default)]
    pub radii: DragRadii,
    /// The camera, by its name or its index; `null` for the first, or one that frames the scene.
    #[serde(default)]
    pub camera: Option<NameOrIndex>,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// Where the feature is taken, in pixels from the top left corner; a pixel's centre is at .5.
    pub from: [f64; 2],
    /// Where it goes.
    pub to: [f64; 2],
    /// What is to stay as it is; pins of other lights than the dragged one stay anyway.
    #[serde(default)]
    pub pins: Vec<DragPin>,
    /// Whether the source may not go through a surface.
    #[serde(default)]
    pub source_outside: bool,
}

/// What is to stay as it is at a point while a light is dragged.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DragPin {
    /// What stays.
    pub kind: PinKind,
    /// Whose, by its name or its index.
    pub light: NameOrIndex,
    /// Where, in the world: on a surface.
    pub at: [f64; 3],
    /// Of a shadow: the node that throws it, by its name or its path; the first that light meets where it is left out.
    #[serde(default)]
    pub caster: Option<String>,
    /// Whether it stays whatever is asked, or as far as that lets it.
    pub hard: bool,
}

/// [`drag::PinKind`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum PinKind {
    /// The direction from which light arrives.
    Direction,
    /// That light arrives.
    Lit,
    /// That something stands in the light's way.
    Shadowed,
    /// The shadow of the very point of the caster that throws it.
    Shadow,
}

/// What names a light or a camera.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged, expecting = "a name or an index")]
pub enum NameOrIndex {
    /// Its place in the list, from 0.
    Index(usize),
    /// Its name.
    Name(String),
}

impl fmt::Display for NameOrIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Index(index) => index.fmt(f),
            Self::Name(name) => name.fmt(f),
        }
    }
}

/// [`Feature`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum DragKind {
    /// M' comes to lie behind what shadows M.
    Shadow,
    /// M' comes to lie where M was in the light.
    Hotspot,
    /// At M' light arrives along the mirror direction.
    Highlight,
    /// At M' light arrives along the normal.
    Diffuse,
}

/// [`Radii`] in JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum DragRadii {
    /// They stay.
    #[default]
    Keep,
    /// Those of the moving points may change.
    Solve,
    /// Those that would make the tube fold shrink.
    Follow,
}

/// What came of a drag.
#[derive(Clone, Debug, Serialize)]
pub struct Dragged {
    /// Whether the feature lies under the cursor.
    pub status: DragStatus,
    /// What keeps a limited one from going on.
    pub limit: Option<DragLimit>,
    /// Why a refused one is.
    pub reason: Option<DragReason>,
    /// The pin that keeps it, by its index in the drag.
    pub pin: Option<usize>,
    /// On the screen, from `to` to where the feature lies now; `null` where it is not in the picture.
    pub residual_px: Option<f64>,
    /// The node that shadows M' besides the one whose shadow is dragged.
    pub shadowed_by: Option<String>,
    /// Steps of the solver.
    pub iterations: usize,
    /// How long it took, picks included.
    pub seconds: f64,
    /// M.
    pub from_world: Option<[f64; 3]>,
    /// M'.
    pub to_world: Option<[f64; 3]>,
    /// What throws the shadow that is dragged.
    pub pivot_world: Option<[f64; 3]>,
    /// The light as it is then.
    pub light: Light,
}

/// [`Status`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum DragStatus {
    /// Within half a pixel.
    Landed,
    /// As near as the light may bring it.
    Limited,
    /// Nothing was moved.
    Refused,
}

/// [`Limit`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum DragLimit {
    /// The tube would fold.
    Fold,
    /// A radius would be less than 0.
    Radius,
    /// M' would lie outside the light, or elsewhere in it.
    TubeEdge,
    /// No small change brings the feature nearer.
    NoDescent,
    /// The source would go through a surface.
    SourceInside,
    /// What is pinned would not stay: see `pin`.
    Pin,
}

/// [`Refusal`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum DragReason {
    /// There is no surface at `from`.
    NothingAtStart,
    /// There is no surface at `to`.
    NothingAtEnd,
    /// M lies outside the light, or the light may not show on it.
    OutsideTheLight,
    /// Nothing shadows M.
    NoShadow,
    /// Control points were named of a light that has none.
    NotBendy,
    /// The light has no such control point, or it is its source.
    NoSuchPoint,
    /// The control points do nothing to the light at M.
    NoWeight,
    /// A hard pin holds what is not so: see `pin`.
    PinDoesNotHold,
}

/// Reads a drag file's text.
pub fn parse(text: &str) -> Result<Vec<Drag>, FileError> {
    from_json(text)
}

impl Drag {
    /// What is asked of the light, where `is_dragged` says of which lights the names are that light's; and for each of its pins
    /// which of this drag's pins that is.
    pub fn to_domain(&self, is_dragged: impl Fn(&NameOrIndex) -> bool) -> (drag::Drag, Vec<usize>) {
        let of_light = self.pins.iter().enumerate().filter(|(_, pin)| is_dragged(&pin.light));
        let (indices, pins) = of_light.map(|(index, pin)| (index, pin.to_domain())).unzip();
        let drag = drag::Drag {
            feature: match self.kind {
                DragKind::Shadow => Feature::Shadow,
                DragKind::Hotspot => Feature::Hotspot,
                DragKind::Highlight => Feature::Highlight,
                DragKind::Diffuse => Feature::Diffuse,
            },
            points: self.points.clone(),
            radii: match self.radii {
                DragRadii::Keep => Radii::Keep,
                DragRadii::Solve => Radii::Solve,
                DragRadii::Follow => Radii::Follow,
            },
            from: self.from.into(),
            to: self.to.into(),
            pins,
            source_outside: self.source_outside,
        };
        (drag, indices)
    }
}

impl DragPin {
    fn to_domain(&self) -> drag::Pin {
        drag::Pin {
            kind: match self.kind {
                PinKind::Direction => Kind::Direction,
                PinKind::Lit => Kind::Lit,
                PinKind::Shadowed => Kind::Shadowed,
                PinKind::Shadow => Kind::Shadow,
            },
            at: self.at.into(),
            caster: self.caster.clone(),
            is_hard: self.hard,
        }
    }
}

impl Dragged {
    /// What came of a drag in a scene whose nodes are called `name`, after so many seconds; `pins` are the indices that
    /// [`Drag::to_domain`] gave.
    pub fn new(landing: &Landing, pins: &[usize], name: impl Fn(usize) -> String, seconds: f64) -> Self {
        let pin = match landing.status {
            Status::Limited(Limit::Pin(pin)) | Status::Refused(Refusal::PinDoesNotHold(pin)) => {
                pins.get(pin).copied()
            }
            _ => None,
        };
        let (status, limit, reason) = match landing.status {
            Status::Landed => (DragStatus::Landed, None, None),
            Status::Limited(limit) => (DragStatus::Limited, Some(limit.into()), None),
            Status::Refused(refusal) => (DragStatus::Refused, None, Some(refusal.into())),
        };
        let array = |position: Option<DVec3>| position.map(|position| position.to_array());
        Self {
            status,
            limit,
            reason,
            pin,
            residual_px: Some(landing.residual_px).filter(|residual| residual.is_finite()),
            shadowed_by: landing.shadowed_by.map(name),
            iterations: landing.iterations,
            seconds,
            from_world: array(landing.from_world),
            to_world: array(landing.to_world),
            pivot_world: array(landing.pivot_world),
            light: Light::from(&landing.light),
        }
    }
}

impl From<Limit> for DragLimit {
    fn from(limit: Limit) -> Self {
        match limit {
            Limit::Fold => Self::Fold,
            Limit::Radius => Self::Radius,
            Limit::TubeEdge => Self::TubeEdge,
            Limit::NoDescent => Self::NoDescent,
            Limit::SourceInside => Self::SourceInside,
            Limit::Pin(_) => Self::Pin,
        }
    }
}

impl From<Refusal> for DragReason {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::NothingAtStart => Self::NothingAtStart,
            Refusal::NothingAtEnd => Self::NothingAtEnd,
            Refusal::OutsideTheLight => Self::OutsideTheLight,
            Refusal::NoShadow => Self::NoShadow,
            Refusal::NotBendy => Self::NotBendy,
            Refusal::NoSuchPoint => Self::NoSuchPoint,
            Refusal::NoWeight => Self::NoWeight,
            Refusal::PinDoesNotHold(_) => Self::PinDoesNotHold,
        }
    }
}
