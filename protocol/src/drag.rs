//! Drags of features and pins in JSON: what drag files (`drag_file.rs`), commands and records say alike.

use document::{DragOutcome as Outcome, LightPin, PinId};
use drag::{DragRefusal, Feature, PinKind as Kind, RadiusMode};
use glam::DVec3;
use light::LightId;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Vec3;

/// [`Feature`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

/// [`RadiusMode`] in JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragRadii {
    /// They stay.
    #[default]
    Keep,
    /// Those of the moving points may change.
    Solve,
    /// Those that would make the tube fold shrink, and come back.
    Follow,
}

/// [`drag::PinKind`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

/// [`LightPin`] in JSON: what is to stay as it is at a point while its light is dragged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Pin {
    /// What stays.
    pub kind: PinKind,
    /// Id of the light.
    pub light: u64,
    /// Where, in the world: on a surface.
    pub at: Vec3,
    /// Of a shadow: the node that throws it, by its name or its path; the first that light meets where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub caster: Option<String>,
    /// Whether it stays whatever is asked, or as far as that lets it.
    pub hard: bool,
}

/// A pin of a document.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DocumentPin {
    /// By which commands name it.
    pub id: u64,
    /// What it holds.
    pub pin: Pin,
}

/// [`drag::DragStatus`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragStatus {
    /// Within half a pixel.
    Landed,
    /// As near as the light may bring it.
    Limited,
    /// Nothing was moved.
    Refused,
}

/// [`drag::DragLimit`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
    /// To bring it nearer takes too much work: choose fewer control points, or remove pins.
    TooMuchWork,
}

/// [`DragRefusal`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DragReason {
    /// There is no surface at `from`.
    NothingAtStart,
    /// There is no surface at `to`, or the light may not show on it.
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

/// How a drag of a feature stands, or ended: what a program reads of it besides the light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct DragOutcome {
    /// What solved it.
    pub solver: String,
    /// Of the solver: another one may give another light.
    pub version: u32,
    /// Whether the feature lies under the cursor.
    pub status: DragStatus,
    /// What keeps a limited one from going on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<DragLimit>,
    /// Id of the pin that keeps it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pin: Option<u64>,
    /// On the screen, from `to` to where the feature lies now; `null` where it is not in the picture.
    pub residual_px: Option<f64>,
    /// The node that shadows M' besides the one whose shadow is dragged.
    pub shadowed_by: Option<String>,
    /// Steps of the solver.
    pub iterations: usize,
    /// M.
    pub from_world: Option<Vec3>,
    /// M'.
    pub to_world: Option<Vec3>,
    /// What throws the shadow that is dragged.
    pub pivot_world: Option<Vec3>,
}

/// [`Status`] in parts, as JSON has it: whether it landed, what keeps it, why it is refused, and which pin that is.
pub(crate) fn status_parts(
    status: drag::DragStatus,
) -> (DragStatus, Option<DragLimit>, Option<DragReason>, Option<usize>) {
    match status {
        drag::DragStatus::Converged => (DragStatus::Landed, None, None, None),
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
            (DragStatus::Landed, None) => drag::DragStatus::Converged,
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
