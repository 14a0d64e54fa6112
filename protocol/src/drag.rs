//! Drags of features, and pins, in JSON: types that drag files (`drag_file.rs`), commands and records share.

use document::{DragOutcome as Outcome, LightPin, PinId};
use drag::{DragRefusal, Feature, PinKind as Kind, RadiusMode};
use glam::DVec3;
use light::LightId;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

/// Splits a `drag::DragStatus` into the fields of the JSON: status, limit, reason of a refusal, and index of
/// the pin.
pub(crate) fn status_parts(
    status: drag::DragStatus,
) -> (DragStatus, Option<DragLimit>, Option<DragReason>, Option<usize>) {
    match status {
        drag::DragStatus::Landed => (DragStatus::Landed, None, None, None),
        drag::DragStatus::Limited(limit) => {
            let pin = if let drag::DragLimit::Pin(pin) = limit { Some(pin) } else { None };
            (DragStatus::Limited, Some(limit.into()), None, pin)
        }
        drag::DragStatus::Refused(refusal) => {
            let pin = if let DragRefusal::PinDoesNotHold(pin) = refusal { Some(pin) } else { None };
            (DragStatus::Refused, None, Some(refusal.into()), pin)
        }
    }
}

impl From<&LightPin> for Pin {
    fn from(LightPin { light, pin }: &LightPin) -> Self {
        Self {
            kind: pin.kind.into(),
            light: light.0,
            at: pin.at.to_array(),
            caster: pin.caster.clone(),
            hard: pin.is_hard,
        }
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
        let (status, limit, _, pin) = status_parts(outcome.status);
        let array = |position: Option<DVec3>| position.map(|position| position.to_array());
        Self {
            solver: outcome.solver.clone(),
            version: outcome.version,
            status,
            limit,
            pin: pin.map(|pin| pin as u64),
            residual_px: Some(outcome.residual_px).filter(|residual| residual.is_finite()),
            shadowed_by: outcome.shadowed_by.clone(),
            iterations: outcome.iterations,
            from_world: array(outcome.from_world),
            to_world: array(outcome.to_world),
            pivot_world: array(outcome.pivot_world),
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
        let vector = |position: Option<Vec3>| position.map(DVec3::from);
        Ok(Self {
            solver: wire.solver,
            version: wire.version,
            status,
            residual_px: wire.residual_px.unwrap_or(f64::INFINITY),
            shadowed_by: wire.shadowed_by,
            iterations: wire.iterations,
            from_world: vector(wire.from_world),
            to_world: vector(wire.to_world),
            pivot_world: vector(wire.pivot_world),
        })
    }
}

impl From<DragKind> for Feature {
    fn from(kind: DragKind) -> Self {
        match kind {
            DragKind::Shadow => Self::Shadow,
            DragKind::Hotspot => Self::Hotspot,
            DragKind::Highlight => Self::Highlight,
            DragKind::Diffuse => Self::Diffuse,
        }
    }
}

impl From<Feature> for DragKind {
    fn from(feature: Feature) -> Self {
        match feature {
            Feature::Shadow => Self::Shadow,
            Feature::Hotspot => Self::Hotspot,
            Feature::Highlight => Self::Highlight,
            Feature::Diffuse => Self::Diffuse,
        }
    }
}

impl From<DragRadii> for RadiusMode {
    fn from(radii: DragRadii) -> Self {
        match radii {
            DragRadii::Keep => Self::Keep,
            DragRadii::Solve => Self::Solve,
            DragRadii::Follow => Self::Follow,
        }
    }
}

impl From<RadiusMode> for DragRadii {
    fn from(radii: RadiusMode) -> Self {
        match radii {
            RadiusMode::Keep => Self::Keep,
            RadiusMode::Solve => Self::Solve,
            RadiusMode::Follow => Self::Follow,
        }
    }
}

impl From<PinKind> for Kind {
    fn from(kind: PinKind) -> Self {
        match kind {
            PinKind::Direction => Self::Direction,
            PinKind::Lit => Self::Lit,
            PinKind::Shadowed => Self::Shadowed,
            PinKind::Shadow => Self::Shadow,
        }
    }
}

impl From<Kind> for PinKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Direction => Self::Direction,
            Kind::Lit => Self::Lit,
            Kind::Shadowed => Self::Shadowed,
            Kind::Shadow => Self::Shadow,
        }
    }
}

impl From<drag::DragLimit> for DragLimit {
    fn from(limit: drag::DragLimit) -> Self {
        match limit {
            drag::DragLimit::Fold => Self::Fold,
            drag::DragLimit::Radius => Self::Radius,
            drag::DragLimit::TubeEdge => Self::TubeEdge,
            drag::DragLimit::NoDescent => Self::NoDescent,
            drag::DragLimit::SourceInside => Self::SourceInside,
            drag::DragLimit::TooMuchWork => Self::TooMuchWork,
            drag::DragLimit::Pin(_) => Self::Pin,
        }
    }
}

impl From<DragRefusal> for DragReason {
    fn from(refusal: DragRefusal) -> Self {
        match refusal {
            DragRefusal::NothingAtStart => Self::NothingAtStart,
            DragRefusal::NothingAtEnd => Self::NothingAtEnd,
            DragRefusal::OutsideTheLight => Self::OutsideTheLight,
            DragRefusal::NoShadow => Self::NoShadow,
            DragRefusal::NotBendy => Self::NotBendy,
            DragRefusal::NoSuchPoint => Self::NoSuchPoint,
            DragRefusal::NoWeight => Self::NoWeight,
            DragRefusal::PinDoesNotHold(_) => Self::PinDoesNotHold,
        }
    }
}
