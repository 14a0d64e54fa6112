//! Drag files: a JSON array of drags, and what comes of them.

use std::fmt;

use drag::DragResult;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::drag::status_parts;
use crate::error::from_json;
use crate::{DragKind, DragLimit, DragRadii, DragReason, DragStatus, FileError, Light, PinKind};

/// A drag as it is written down. M is the surface seen at `from`, M' the one seen at `to`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct FileDrag {
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
    /// What is to stay as it is; pins of other lights than the dragged one stay anyway. Without a list it is what is pinned in the
    /// document, where there is one.
    #[serde(default)]
    pub pins: Option<Vec<DragPin>>,
    /// Whether the source may not go through a surface.
    #[serde(default, alias = "source_outside")]
    pub source_outside: bool,
}

/// What is to stay as it is at a point while a light is dragged.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
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

/// What names a light or a camera.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a name or an index")]
pub enum NameOrIndex {
    /// Its place in the list, from 0.
    Index(usize),
    /// Its name.
    Name(String),
}

impl NameOrIndex {
    /// The place in a list of what it names, the first of several of one name. `names` are those of the list.
    pub fn place_in<'a>(&self, mut names: impl ExactSizeIterator<Item = &'a str>) -> Option<usize> {
        match self {
            Self::Index(index) => (*index < names.len()).then_some(*index),
            Self::Name(wanted) => names.position(|name| name == wanted),
        }
    }
}

impl fmt::Display for NameOrIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Index(index) => index.fmt(f),
            Self::Name(name) => name.fmt(f),
        }
    }
}

/// What came of a drag.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
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

/// Reads a drag file's text.
pub fn parse(text: &str) -> Result<Vec<FileDrag>, FileError> {
    from_json(text)
}

impl FileDrag {
    /// What is asked of the light, where `is_dragged` says of which lights the names are that light's; and for each of its pins
    /// which of this drag's pins that is.
    pub fn to_domain(&self, is_dragged: impl Fn(&NameOrIndex) -> bool) -> (drag::Drag, Vec<usize>) {
        let of_light = self.pins.iter().flatten().enumerate().filter(|(_, pin)| is_dragged(&pin.light));
        let (indices, pins) = of_light.map(|(index, pin)| (index, pin.to_domain())).unzip();
        let drag = drag::Drag {
            feature: self.kind.into(),
            points: self.points.clone(),
            radii: self.radii.into(),
            from: self.from.into(),
            to: self.to.into(),
            pins,
            source_outside: self.source_outside,
        };
        (drag, indices)
    }
}

impl DragPin {
    fn to_domain(&self) -> drag::DragPin {
        drag::DragPin {
            kind: self.kind.into(),
            at: self.at.into(),
            caster: self.caster.clone(),
            is_hard: self.hard,
        }
    }
}

impl Dragged {
    /// What came of a drag in a scene whose nodes are called `name`, after so many seconds; `pins` are the indices that
    /// [`FileDrag::to_domain`] gave.
    pub fn new(landing: &DragResult, pins: &[usize], name: impl Fn(usize) -> String, seconds: f64) -> Self {
        let (status, limit, reason, pin) = status_parts(landing.status);
        let array = |position: Option<DVec3>| position.map(|position| position.to_array());
        Self {
            status,
            limit,
            reason,
            pin: pin.and_then(|pin| pins.get(pin).copied()),
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
