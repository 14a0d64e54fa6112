//! Drags of features, and pins, in JSON: types that drag files (`drag_file.rs`), commands and records share.

use document::{DragOutcome as Outcome, LightPin, PinId};
use drag::{DragRefusal, Feature, PinKind as Kind, RadiusMode};
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

/// [`drag::PinKind`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum PinKind {
    /// Direction from which light arrives.
    Direction,
    /// Fact that light arrives.
    Lit,
    /// Fact that an occluder blocks the light.
    Shadowed,
    /// Shadow of one point of the caster.
    Shadow,
}

/// [`LightPin`] in JSON: a property at a point that a drag of the light preserves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Pin {
    /// Property to preserve.
    pub kind: PinKind,
    /// Id of the light.
    pub light: u64,
    /// World position on a surface.
    pub at: Vec3,
    /// Caster of a pinned shadow, by the node's name or path. Default: the first occluder along the light path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub caster: Option<String>,
    /// True if every drag keeps the pin. False if a drag keeps it only as far as it can.
    pub hard: bool,
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
    /// The feature lies as near to the cursor as the limits of the light allow.
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
    /// Limit that stopped a `limited` drag.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<DragLimit>,
    /// Id of the pin that stopped the drag.
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
pub(crate) struct StatusFields {
    pub status: DragStatus,
    pub limit: Option<DragLimit>,
    /// Reason of a refusal.
    pub reason: Option<DragReason>,
    /// Number of the pin that stopped the drag.
    pub pin: Option<usize>,
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
                let pin = if let DragRefusal::PinDoesNotHold(pin) = refusal { Some(pin) } else { None };
                Self { status: DragStatus::Refused, reason: Some(refusal.into()), pin, ..landed }
            }
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
    fn from(Pin { kind, light, at, caster, hard }: Pin) -> Self {
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
        let StatusFields { status, limit, pin, .. } = outcome.status.into();
        Self {
            solver: outcome.solver.clone(),
            version: outcome.version,
            status,
            limit,
            pin: pin.map(|pin| pin as u64),
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
                DragLimit::Radius => drag::DragLimit::Radius,
                DragLimit::TubeEdge => drag::DragLimit::TubeEdge,
                DragLimit::NoDescent => drag::DragLimit::NoDescent,
                DragLimit::SourceInside => drag::DragLimit::SourceInside,
                DragLimit::TooMuchWork => drag::DragLimit::TooMuchWork,
                DragLimit::Pin => {
                    drag::DragLimit::Pin(wire.pin.ok_or("a drag that a pin limits names the pin")? as usize)
                }
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
same_variants!(DragRadii = RadiusMode { Keep, Solve, Follow });
same_variants!(PinKind = Kind { Direction, Lit, Shadowed, Shadow });
same_variants!(drag::DragLimit => DragLimit {
    Fold, Radius, TubeEdge, NoDescent, SourceInside, TooMuchWork; Pin
});
same_variants!(DragRefusal => DragReason {
    NothingAtStart, NothingAtEnd, OutsideTheLight, NoShadow, NotBendy, NoSuchPoint, NoWeight; PinDoesNotHold
});
