//! Drag files: a JSON array of drags, and the results of such drags.

use std::fmt;

use drag::DragResult;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::drag::StatusFields;
use crate::error::from_json;
use crate::{DragKind, DragLimit, DragRadii, DragReason, DragStatus, FileError, Light, PinKind};

/// Drag in a file. M is the surface seen at `from`, M' the surface seen at `to`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[schemars(rename = "Drag")]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct FileDrag {
    /// Light, by its name or its index.
    pub light: NameOrIndex,
    /// Feature to drag.
    pub kind: DragKind,
    /// Indices of the control points that may move; `null` moves the light as a whole.
    #[serde(default)]
    pub points: Option<Vec<usize>>,
    /// Mode of the radii.
    #[serde(default)]
    pub radii: DragRadii,
    /// Camera, by its name or its index; `null` for the first camera, or one that frames the scene.
    #[serde(default)]
    pub camera: Option<NameOrIndex>,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// Position of the feature in the picture, in pixels from the top left corner. The centre of a pixel is at
    /// .5.
    pub from: [f64; 2],
    /// Target of the feature in the picture, in pixels from the top left corner, like `from`.
    pub to: [f64; 2],
    /// Pins that the drag keeps. Pins of other lights have no effect on it. Default: the pins of the document, if there
    /// is one.
    #[serde(default)]
    pub pins: Option<Vec<DragPin>>,
    /// True if the source may not pass through a surface.
    #[serde(default, alias = "source_outside")]
    pub source_outside: bool,
}

/// Property at a point that a drag of the light preserves.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DragPin {
    /// Property to preserve.
    pub kind: PinKind,
    /// Light, by its name or its index.
    pub light: NameOrIndex,
    /// World position on a surface.
    pub at: [f64; 3],
    /// Caster of a pinned shadow, by the node's name or path. Default: the first occluder along the light path.
    #[serde(default)]
    pub caster: Option<String>,
    /// True if the pin always holds. False if it holds as far as the drag allows.
    pub hard: bool,
}

/// Name or index of a light or a camera.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a name or an index")]
pub enum NameOrIndex {
    /// Index in the list, from 0.
    Index(usize),
    /// Name. The first object of that name is meant.
    Name(String),
}

impl NameOrIndex {
    /// Returns the index of the referenced object in a list with these `names`, or `None` if there is none. If
    /// several objects share a name, the first one counts.
    pub fn index_in<'a>(&self, mut names: impl ExactSizeIterator<Item = &'a str>) -> Option<usize> {
        match self {
            Self::Index(index) => (*index < names.len()).then_some(*index),
            Self::Name(expected) => names.position(|name| name == expected),
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

/// Result of a drag.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct Dragged {
    pub status: DragStatus,
    /// Limit that stopped a `limited` drag.
    pub limit: Option<DragLimit>,
    /// Reason of a `refused` drag.
    pub reason: Option<DragReason>,
    /// Index of the pin that stopped the drag, in the drag's `pins`.
    pub pin: Option<usize>,
    /// Distance in pixels from `to` to the feature; `null` if the feature is not in the picture.
    pub residual_px: Option<f64>,
    /// Node that shadows M', other than the caster of the dragged shadow.
    pub shadowed_by: Option<String>,
    /// Number of solver iterations.
    pub iterations: usize,
    /// Duration of the drag in seconds, picks included.
    pub seconds: f64,
    /// World position of M.
    pub from_world: Option<[f64; 3]>,
    /// World position of M'.
    pub to_world: Option<[f64; 3]>,
    /// World position on the caster of the dragged shadow.
    pub pivot_world: Option<[f64; 3]>,
    /// Light after the drag.
    pub light: Light,
}

/// Parses the text of a drag file.
pub fn parse(text: &str) -> Result<Vec<FileDrag>, FileError> {
    from_json(text)
}

impl FileDrag {
    /// Converts to the domain. `is_dragged` returns true for references to the dragged light; pins of other
    /// lights are left out. Also returns, for each pin of the result, its index in `pins` of this drag.
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
        drag::DragPin { kind: self.kind.into(), at: self.at.into(), caster: self.caster.clone(), is_hard: self.hard }
    }
}

impl Dragged {
    /// Converts the result of a drag that took `seconds`. `name` returns the name of a node. `pins` are the
    /// indices that [`FileDrag::to_domain`] returned.
    pub fn new(result: &DragResult, pins: &[usize], name: impl Fn(usize) -> String, seconds: f64) -> Self {
        let StatusFields { status, limit, reason, pin } = result.status.into();
        Self {
            status,
            limit,
            reason,
            pin: pin.and_then(|pin| pins.get(pin).copied()),
            residual_px: Some(result.residual_px).filter(|residual| residual.is_finite()),
            shadowed_by: result.shadowed_by.map(name),
            iterations: result.iterations,
            seconds,
            from_world: result.from_world.map(Into::into),
            to_world: result.to_world.map(Into::into),
            pivot_world: result.pivot_world.map(Into::into),
            light: Light::from(&result.light),
        }
    }
}
