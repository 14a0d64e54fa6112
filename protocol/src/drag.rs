//! Drags of features, and pins, in JSON: types that drag files (`drag_file.rs`), commands and records share.

use std::fmt;

use document::{LightPin, PinId};
use drag::{
    Alternative, Constraint, DragChoice as Choice, DragOutcome as Outcome, DragRefusal, Feature, NumberedPin,
    PinKind as Kind, PinTarget as Target, RadiusMode, Viewport,
};
use light::LightId;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::conversion::same_variants;
use crate::vector::Vec3;

/// [`Feature`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragKind {
    /// Moves the shadow at M: M' gets the light coordinates (v, w) of the caster that shadows M, and lies
    /// behind it.
    Shadow,
    /// Moves the hotspot: M' gets the light coordinates (v, w) of M.
    Hotspot,
    /// Moves the highlight: light arrives at M' along the mirror direction.
    Highlight,
    /// Moves the brightest side: light arrives at M' along the normal.
    Diffuse,
}

/// [`RadiusMode`] in JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragRadii {
    /// Keeps all radii.
    #[default]
    Keep,
    /// Solves for the radii of the moving points.
    Solve,
    /// Shrinks radii that would make the tube fold, and restores them when they no longer would.
    Follow,
}

/// [`drag::DragChoice`] in JSON: the alternative to solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragChoice {
    /// The alternative that lands and changes least of what is lit, without a linked copy.
    Best,
    ControlPoints,
    Narrower,
    WholeLight,
    PastCaster,
    LinkedCopy,
}

/// [`drag::Alternative`] in JSON: the part of a light that follows a dragged feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragAlternative {
    /// Control points, with their radii.
    ControlPoints,
    /// Control points whose radii shrink where the tube would fold, by a fifth at most.
    Narrower,
    /// Placement of the light.
    WholeLight,
    /// Control points that change the light past the caster of a dragged shadow alone.
    PastCaster,
    /// The light without the caster of a dragged shadow, which a copy of the light as it was illuminates. Another feature
    /// moves on its surface alone, and the copy illuminates all else.
    LinkedCopy,
}

/// [`drag::PinKind`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum PinKind {
    /// Direction from which light arrives.
    Direction,
    /// Look of the surface: how much light arrives, from where, and that it does or does not.
    Look,
    /// Fact that light arrives, at least half as much as before.
    Lit,
    /// Fact that an occluder blocks the light.
    Shadowed,
    /// Shadow of one point of the caster.
    Shadow,
    /// Light coordinates across the light, (v, w).
    Coordinates,
}

/// [`drag::PinTarget`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "a position of three numbers, or a node's name or path")]
pub enum PinTarget {
    /// World position on a surface.
    Point(Vec3),
    /// Node, by its name or path: the pin holds on what the picture shows of it.
    Node(String),
}

// A command has the light's id and a camera with all its values, a drag file the name or index of each.
/// [`drag::Drag`] in JSON, with its light. M is the surface seen at `from`, M' the surface seen at `to`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Drag<L, C> {
    /// Light: its id, or in a drag file its name or its index.
    pub light: L,
    /// Feature to drag.
    pub kind: DragKind,
    /// Alternative that follows the feature. Default: what `points` and `radii` say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alternative: Option<DragChoice>,
    /// Indices of the control points that may move. Default: the light moves as a whole; with `alternative`, all points
    /// past the source.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<usize>>,
    /// Mode of the radii. Default: `keep`.
    #[serde(default)]
    pub radii: DragRadii,
    /// Camera of the picture. In a drag file it is a name or an index; default: the first camera, or one that frames
    /// the scene.
    pub camera: C,
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// Position of the feature in the picture, in pixels from the top left corner. The centre of a pixel is at .5.
    pub from: [f64; 2],
    /// Target of the feature in the picture, in pixels from the top left corner, like `from`.
    pub to: [f64; 2],
    /// Pins that the drag keeps, in a drag file. Default: the document's pins of the light, if there is a document. A
    /// command has none of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pins: Option<Vec<DragPin>>,
    /// True for all alternatives in the answer, in a drag file. A command has one.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub alternatives: bool,
    /// True if the source may not pass through a surface. By default true with `alternative` or
    /// `alternatives`, and else false.
    #[serde(default, alias = "source_outside", skip_serializing_if = "Option::is_none")]
    pub source_outside: Option<bool>,
}

impl<L, C> Drag<L, C> {
    /// Converts a drag of the light to JSON, without what a command does not have: pins and alternatives.
    pub(crate) fn new(light: L, camera: C, drag: &drag::Drag) -> Self {
        let drag::Drag { feature, choice, points, radii, view, from, to, source_outside, .. } = drag;
        Self {
            light,
            kind: (*feature).into(),
            alternative: choice.map(Into::into),
            points: points.clone(),
            radii: (*radii).into(),
            camera,
            size: view.size,
            from: from.to_array(),
            to: to.to_array(),
            pins: None,
            alternatives: false,
            source_outside: Some(*source_outside).filter(|is_outside| *is_outside || choice.is_some()),
        }
    }

    /// Converts to the domain, with the camera that `camera` refers to. Leaves out the pins for which `is_dragged` is
    /// false, and numbers the others by their index in `pins`.
    pub fn to_domain(&self, camera: scene::Camera, is_dragged: impl Fn(&NameOrIndex) -> bool) -> drag::Drag {
        let pins = self.pins.as_ref().map(|pins| {
            let numbered = pins.iter().zip(0..).filter(|(pin, _)| is_dragged(&pin.light));
            numbered.map(|(pin, number)| NumberedPin { number, pin: pin.to_domain() }).collect()
        });
        drag::Drag {
            feature: self.kind.into(),
            choice: self.alternative.map(Into::into),
            points: self.points.clone(),
            radii: self.radii.into(),
            view: Viewport { camera, size: self.size },
            from: self.from.into(),
            to: self.to.into(),
            pins,
            source_outside: self.source_outside.unwrap_or(self.alternative.is_some() || self.alternatives),
        }
    }
}

/// Property at a point that a drag of the light preserves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DragPin {
    /// Property to preserve.
    pub kind: PinKind,
    /// Light, by its name or its index.
    pub light: NameOrIndex,
    /// World position on a surface, or the name or path of a node.
    pub at: PinTarget,
    /// Caster of a pinned shadow, by the node's name or path. Default: the first occluder along the light path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub caster: Option<String>,
    /// True if the pin always holds. False if it holds as far as the drag allows.
    pub hard: bool,
}

/// [`LightPin`] in JSON: a property at a point that a drag of the light preserves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Pin {
    /// Property to preserve.
    pub kind: PinKind,
    /// Id of the light.
    pub light: u64,
    /// World position on a surface, or the name or path of a node.
    pub at: PinTarget,
    /// Caster of a pinned shadow, by the node's name or path. Default: the first occluder along the light path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub caster: Option<String>,
    /// True if every drag keeps the pin. False if a drag keeps it only as far as it can.
    pub hard: bool,
}

/// Name or index of a light or a camera.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

/// Pin of a document, with its id.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DocumentPin {
    /// Id of the pin in commands.
    pub id: u64,
    pub pin: Pin,
}

/// [`drag::DragStatus`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragStatus {
    /// The feature lies within half a pixel of the cursor.
    Landed,
    /// The feature lies on the straight way to the cursor, as far as the limits of the light allow.
    Limited,
    /// The light did not change.
    Refused,
}

/// [`drag::DragLimit`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragLimit {
    /// The tube would fold.
    Fold,
    /// Distant parts of the tube would overlap. Set the light's `allowOverlap` to let them.
    Overlap,
    /// A radius would become negative.
    Radius,
    /// M' would lie outside the light, or in another part of it.
    TubeEdge,
    /// No small change brings the feature nearer to the cursor.
    NoDescent,
    /// The source would pass through a surface.
    SourceInside,
    /// The drag cannot keep a hard pin. `pin` names it.
    Pin,
    /// The solver reached its work limit. Choose fewer control points, or remove pins.
    TooMuchWork,
}

/// [`DragRefusal`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragReason {
    /// No surface is visible at `from`.
    NothingAtStart,
    /// No surface is visible at `to`, or `lightLink` of the light excludes it.
    NothingAtEnd,
    /// M lies outside the light, or `lightLink` of the light excludes it.
    OutsideTheLight,
    /// Nothing shadows M.
    NoShadow,
    /// The drag names control points, but the light has none.
    NotBendy,
    /// The light has no such control point, or the point is its source.
    NoSuchPoint,
    /// The chosen control points have no influence on the light at M.
    NoWeight,
    /// A hard pin is not fulfilled when the drag begins. `pin` names it.
    PinDoesNotHold,
    /// The caster lies too near to the shadow for the light to bend between them, or there is no control point past it.
    TooLittleRoom,
    /// The feature can go less than a third of the way. `limit` says why.
    Limited,
}

/// [`drag::Constraint`] in JSON: what a drag relaxes where the feature does not land else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragConstraint {
    /// The rest of the picture changes little. Relaxed, it counts a tenth.
    Picture,
    /// Soft pins hold. Relaxed, they do not count.
    SoftPins,
    /// Radii stay. Relaxed, they shrink where the tube would fold.
    Radii,
}

/// Outcome of a drag of a feature, besides the light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DragOutcome {
    /// Name of the solver.
    pub solver: String,
    /// Version of the solver. Another version may give another light.
    pub version: u32,
    pub status: DragStatus,
    /// Alternative that the light follows, if the drag has an `alternative`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alternative: Option<DragAlternative>,
    /// Share of the picture's pixels that change visibly, 0 to 1, measured at 256 of them. A `refused` drag has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub changed_share: Option<f64>,
    /// Largest change of what a picture shows at a point of an object that a hard pin holds, 0 to 1, where 1 is the
    /// brightness of its brightest point before the drag. Only with such a pin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pinned_change: Option<f64>,
    /// Constraints that gave way so that the feature lands. From one cursor to the next the light may jump where they change.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub relaxed: Vec<DragConstraint>,
    /// Limit that stopped a drag that is `limited`, or `refused` for the reason `limited`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<DragLimit>,
    /// Reason of a `refused` drag. Records have none, since such a drag changes nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<DragReason>,
    /// Pin that stopped the drag: its id in the document, or its index in the drag's own `pins`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pin: Option<u64>,
    /// Distance in pixels from `to` to the feature; `null` if the feature is not in the picture.
    pub residual_px: Option<f64>,
    /// Node that shadows M', other than the caster of the dragged shadow.
    pub shadowed_by: Option<String>,
    /// Number of solver iterations.
    pub iterations: usize,
    /// World position of M.
    pub from_world: Option<Vec3>,
    /// World position of M'.
    pub to_world: Option<Vec3>,
    /// World position on the caster of the dragged shadow.
    pub pivot_world: Option<Vec3>,
}

/// Fields of the JSON that hold a [`drag::DragStatus`].
struct StatusFields {
    pub status: DragStatus,
    pub limit: Option<DragLimit>,
    /// Reason of a refusal.
    pub reason: Option<DragReason>,
    /// Number of the pin that stopped the drag.
    pub pin: Option<u64>,
}

impl From<drag::DragStatus> for StatusFields {
    fn from(status: drag::DragStatus) -> Self {
        let landed = Self { status: DragStatus::Landed, limit: None, reason: None, pin: None };
        match status {
            drag::DragStatus::Landed => landed,
            drag::DragStatus::Limited(limit) => {
                let pin = if let drag::DragLimit::Pin(pin) = limit { Some(pin) } else { None };
                Self { status: DragStatus::Limited, limit: Some(limit.into()), pin, ..landed }
            }
            drag::DragStatus::Refused(refusal) => {
                let limit = if let DragRefusal::Limited(limit) = refusal { Some(limit) } else { None };
                let pin = match (refusal, limit) {
                    (DragRefusal::PinDoesNotHold(pin), _) | (_, Some(drag::DragLimit::Pin(pin))) => Some(pin),
                    _ => None,
                };
                let limit = limit.map(Into::into);
                Self { status: DragStatus::Refused, limit, reason: Some(refusal.into()), pin }
            }
        }
    }
}

impl From<DragChoice> for Choice {
    fn from(choice: DragChoice) -> Self {
        match choice {
            DragChoice::Best => Self::Best,
            DragChoice::ControlPoints => Self::Only(Alternative::ControlPoints),
            DragChoice::Narrower => Self::Only(Alternative::Narrower),
            DragChoice::WholeLight => Self::Only(Alternative::WholeLight),
            DragChoice::PastCaster => Self::Only(Alternative::PastCaster),
            DragChoice::LinkedCopy => Self::Only(Alternative::LinkedCopy),
        }
    }
}

impl From<Choice> for DragChoice {
    fn from(choice: Choice) -> Self {
        match choice {
            Choice::Best => Self::Best,
            Choice::Only(Alternative::ControlPoints) => Self::ControlPoints,
            Choice::Only(Alternative::Narrower) => Self::Narrower,
            Choice::Only(Alternative::WholeLight) => Self::WholeLight,
            Choice::Only(Alternative::PastCaster) => Self::PastCaster,
            Choice::Only(Alternative::LinkedCopy) => Self::LinkedCopy,
        }
    }
}

impl DragPin {
    fn to_domain(&self) -> drag::DragPin {
        drag::DragPin {
            kind: self.kind.into(),
            at: self.at.clone().into(),
            caster: self.caster.clone(),
            is_hard: self.hard,
        }
    }
}

impl From<PinTarget> for Target {
    fn from(target: PinTarget) -> Self {
        match target {
            PinTarget::Point(at) => Self::Point(at.into()),
            PinTarget::Node(node) => Self::Node(node),
        }
    }
}

impl From<Target> for PinTarget {
    fn from(target: Target) -> Self {
        match target {
            Target::Point(at) => Self::Point(at.into()),
            Target::Node(node) => Self::Node(node),
        }
    }
}

impl From<&LightPin> for Pin {
    fn from(LightPin { light, pin }: &LightPin) -> Self {
        let drag::DragPin { kind, at, caster, is_hard } = pin.clone();
        Self { kind: kind.into(), light: light.0, at: at.into(), caster, hard: is_hard }
    }
}

impl From<Pin> for LightPin {
    fn from(pin: Pin) -> Self {
        let Pin { kind, light, at, caster, hard } = pin;
        let pin = drag::DragPin { kind: kind.into(), at: at.into(), caster, is_hard: hard };
        Self { light: LightId(light), pin }
    }
}

impl From<(PinId, &LightPin)> for DocumentPin {
    fn from((id, pin): (PinId, &LightPin)) -> Self {
        Self { id: id.0, pin: pin.into() }
    }
}

impl From<&Outcome> for DragOutcome {
    fn from(outcome: &Outcome) -> Self {
        let StatusFields { status, limit, reason, pin } = outcome.status.into();
        Self {
            solver: outcome.solver.clone(),
            version: outcome.version,
            status,
            alternative: outcome.alternative.map(Into::into),
            changed_share: outcome.changed_share,
            pinned_change: outcome.pinned_change,
            relaxed: outcome.relaxed.iter().map(|constraint| (*constraint).into()).collect(),
            limit,
            reason,
            pin,
            residual_px: Some(outcome.residual_px).filter(|residual| residual.is_finite()),
            shadowed_by: outcome.shadowed_by.clone(),
            iterations: outcome.iterations,
            from_world: outcome.from_world.map(Into::into),
            to_world: outcome.to_world.map(Into::into),
            pivot_world: outcome.pivot_world.map(Into::into),
        }
    }
}

impl TryFrom<DragOutcome> for Outcome {
    type Error = &'static str;

    fn try_from(wire: DragOutcome) -> Result<Self, &'static str> {
        let limit = |limit| {
            Ok(match limit {
                DragLimit::Fold => drag::DragLimit::Fold,
                DragLimit::Overlap => drag::DragLimit::Overlap,
                DragLimit::Radius => drag::DragLimit::Radius,
                DragLimit::TubeEdge => drag::DragLimit::TubeEdge,
                DragLimit::NoDescent => drag::DragLimit::NoDescent,
                DragLimit::SourceInside => drag::DragLimit::SourceInside,
                DragLimit::TooMuchWork => drag::DragLimit::TooMuchWork,
                DragLimit::Pin => drag::DragLimit::Pin(wire.pin.ok_or("a drag that a pin limits names the pin")?),
            })
        };
        let status = match (wire.status, wire.limit) {
            (DragStatus::Landed, None) => drag::DragStatus::Landed,
            (DragStatus::Limited, Some(what)) => drag::DragStatus::Limited(limit(what)?),
            (DragStatus::Refused, _) => return Err("a drag that was refused leaves no record"),
            _ => return Err("a drag has a `limit` where it is limited, and there alone"),
        };
        Ok(Self {
            solver: wire.solver,
            version: wire.version,
            status,
            alternative: wire.alternative.map(Into::into),
            changed_share: wire.changed_share,
            pinned_change: wire.pinned_change,
            relaxed: wire.relaxed.into_iter().map(Into::into).collect(),
            residual_px: wire.residual_px.unwrap_or(f64::INFINITY),
            shadowed_by: wire.shadowed_by,
            iterations: wire.iterations,
            from_world: wire.from_world.map(Into::into),
            to_world: wire.to_world.map(Into::into),
            pivot_world: wire.pivot_world.map(Into::into),
        })
    }
}

same_variants!(DragKind = Feature { Shadow, Hotspot, Highlight, Diffuse });
same_variants!(DragAlternative = Alternative { ControlPoints, Narrower, WholeLight, PastCaster, LinkedCopy });
same_variants!(DragConstraint = Constraint { Picture, SoftPins, Radii });
same_variants!(DragRadii = RadiusMode { Keep, Solve, Follow });
same_variants!(PinKind = Kind { Direction, Look, Lit, Shadowed, Shadow, Coordinates });
same_variants!(drag::DragLimit => DragLimit {
    Fold, Overlap, Radius, TubeEdge, NoDescent, SourceInside, TooMuchWork; Pin
});
same_variants!(DragRefusal => DragReason {
    NothingAtStart, NothingAtEnd, OutsideTheLight, NoShadow, NotBendy, NoSuchPoint, NoWeight, TooLittleRoom; PinDoesNotHold, Limited
});
