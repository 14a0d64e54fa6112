//! The table of parameters in JSON: what pages and programs make their controls of.

use std::collections::BTreeMap;
use std::ops::Bound;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::parameter::WireValue;

/// A row for each thing that can be set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ParameterTable {
    /// The rows, in the order in which people see them.
    pub parameters: Vec<Parameter>,
}

/// [`light::Parameter`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Parameter {
    /// The word for it in commands, light files and logs.
    pub name: String,
    /// What has it.
    pub of: Vec<ParameterOwner>,
    /// What it is called in a document, by owner: `/lights/ID/coneAngle`, for the command `set`.
    pub address: BTreeMap<String, String>,
    /// What its values are.
    pub kind: ParameterKind,
    /// By owner, the value where none is given, as in light files; none where the owner must have one of its own.
    pub default: BTreeMap<String, Value>,
    /// Where it stands in its owner's JSON, fields within fields parted by `/`. Of a control point, the light's list.
    pub path: String,
    /// What becomes stale when it changes.
    pub touches: ParameterTouches,
    /// Whether keyframes may drive it.
    pub animates: bool,
    /// What another of the same owner has to be for it to have an effect; left out where it always has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needs: Option<ParameterNeeds>,
    /// Which of those that have it have it for later alone, such as a spotlight that may be bent: no picture shows it of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub idle_of: Vec<ParameterOwner>,
    /// The heading that it stands under.
    pub group: String,
    /// Its name for people.
    pub label: String,
    /// A sentence about it.
    pub doc: String,
}

/// [`light::ParameterNeeds`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ParameterNeeds {
    /// The other's name.
    pub parameter: String,
    /// What it has to be.
    pub value: ParameterNeeded,
}

/// [`light::ParameterNeeded`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ParameterNeeded {
    /// One of these.
    OneOf(#[schemars(schema_with = "values")] Vec<Value>),
    /// Any but these.
    NoneOf(#[schemars(schema_with = "values")] Vec<Value>),
}

/// Makers of clients take no `true` for what any item may be.
fn values(_: &mut SchemaGenerator) -> Schema {
    json_schema!({"type": "array", "items": {"type": ["boolean", "number", "string", "null"]}})
}

/// [`light::ParameterOwner`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ParameterOwner {
    /// A light of type `spot`.
    Spot,
    /// A light of type `bendy`.
    Bendy,
    /// A light of type `omni`.
    Omni,
    /// A light of type `directional`.
    Directional,
    /// A control point of a `bendy` light.
    Point,
    /// A camera.
    Camera,
}

/// [`light::ParameterTouches`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ParameterTouches {
    /// No picture shows it.
    Nothing,
    /// By which factors it adds what it adds to pictures.
    Weight,
    /// What the light adds to pictures.
    Radiance,
    /// That and the light's shadow map.
    ShadowMap,
    /// Everything.
    Scene,
}

/// [`light::ParameterKind`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum ParameterKind {
    /// A number.
    Number {
        /// What it counts.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        unit: String,
        /// The least that it may be.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        min: Option<f64>,
        /// The most that it may be.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max: Option<f64>,
        /// What it must be more than.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        exclusive_min: Option<f64>,
        /// What it must be less than.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        exclusive_max: Option<f64>,
        /// The ends of a slider; what is typed may go on to the range.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        slider: Option<[f64; 2]>,
        /// What a step of a control changes it by.
        step: f64,
        /// How a slider is divided.
        scale: ParameterScale,
        /// What `null` means, for people; where it is left out there has to be a number.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        none: Option<String>,
    },
    /// Yes or no.
    Flag,
    /// One of several words.
    Choice {
        /// The words.
        choices: Vec<ParameterChoice>,
    },
    /// Linear RGB.
    Color,
    /// Three numbers.
    Vector {
        /// What they count.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        unit: String,
        /// What a step of a control changes one by.
        step: f64,
    },
    /// A unit quaternion `[x, y, z, w]`.
    Rotation,
    /// Text.
    Text {
        /// Bytes of UTF-8 that it has at most.
        max_bytes: usize,
    },
    /// Some nodes of the scene: `{"include": [PATH, ...], "exclude": [PATH, ...]}`, or `null` for all of them.
    Links {
        /// Nodes that both lists name at most.
        max_paths: usize,
        /// Bytes of UTF-8 that all their paths have at most.
        max_bytes: usize,
    },
    /// A number over an angle: `[[DEGREES, NUMBER], ...]`, the degrees ascending from 0 to less than 360, linear from one to the
    /// next and from the last on around to the first; or `null` for none.
    PeriodicCurve {
        /// Pairs that it has at most.
        max_knots: usize,
        /// The least that the number may be.
        min: f64,
        /// The most.
        max: f64,
        /// What a step of a control changes it by.
        step: f64,
        /// What `null` means, for people.
        none: String,
    },
    /// How a camera projects, as a whole.
    Projection,
}

/// [`light::ParameterScale`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ParameterScale {
    /// Evenly.
    Linear,
    /// Evenly in the logarithm.
    Logarithmic,
}

/// [`light::ParameterChoice`] in JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterChoice {
    /// The word.
    pub name: String,
    /// For people.
    pub label: String,
}

/// The table that this program goes by.
pub fn parameter_table() -> ParameterTable {
    ParameterTable { parameters: document::parameters().map(Parameter::from).collect() }
}

impl ParameterOwner {
    fn name(self) -> &'static str {
        match self {
            Self::Spot => "spot",
            Self::Bendy => "bendy",
            Self::Omni => "omni",
            Self::Directional => "directional",
            Self::Point => "point",
            Self::Camera => "camera",
        }
    }

    /// How addresses of what it has begin.
    fn address_prefix(self) -> &'static str {
        match self {
            Self::Spot | Self::Bendy | Self::Omni | Self::Directional => "/lights/ID",
            Self::Point => "/lights/ID/points/INDEX",
            Self::Camera => "/cameras/ID",
        }
    }
}

impl From<light::ParameterOwner> for ParameterOwner {
    fn from(owner: light::ParameterOwner) -> Self {
        match owner {
            light::ParameterOwner::Spot => Self::Spot,
            light::ParameterOwner::Bendy => Self::Bendy,
            light::ParameterOwner::Omni => Self::Omni,
            light::ParameterOwner::Directional => Self::Directional,
            light::ParameterOwner::Point => Self::Point,
            light::ParameterOwner::Camera => Self::Camera,
        }
    }
}

impl From<&light::Parameter> for Parameter {
    fn from(row: &light::Parameter) -> Self {
        let of: Vec<_> = row.owners.iter().map(|of| ParameterOwner::from(of.owner)).collect();
        let default = |of: &light::ParameterOf| {
            let default = serde_json::to_value(WireValue(&row.default(of.owner)?)).ok()?;
            Some((ParameterOwner::from(of.owner).name().into(), default))
        };
        let address = |owner: &ParameterOwner| {
            (owner.name().into(), format!("{}/{}", owner.address_prefix(), row.name))
        };
        Self {
            name: row.name.into(),
            address: of.iter().map(address).collect(),
            of,
            kind: row.kind.into(),
            default: row.owners.iter().filter_map(default).collect(),
            path: row.path.replace('.', "/"),
            touches: match row.touches() {
                light::ParameterTouches::Nothing => ParameterTouches::Nothing,
                light::ParameterTouches::Weight => ParameterTouches::Weight,
                light::ParameterTouches::Radiance => ParameterTouches::Radiance,
                light::ParameterTouches::ShadowMap => ParameterTouches::ShadowMap,
                light::ParameterTouches::Scene => ParameterTouches::Scene,
            },
            animates: row.animates,
            needs: row.needs.map(Into::into),
            idle_of: row
                .owners
                .iter()
                .filter(|of| row.has_no_effect_on(of.owner))
                .map(|of| of.owner.into())
                .collect(),
            group: row.group.into(),
            label: row.label.into(),
            doc: row.doc.into(),
        }
    }
}

impl From<light::ParameterNeeds> for ParameterNeeds {
    fn from(light::ParameterNeeds { parameter, value }: light::ParameterNeeds) -> Self {
        let written = |values: &[light::Value<&'static str>]| {
            let json =
                |value: &light::Value<&'static str>| serde_json::to_value(WireValue(&value.to_value()));
            values.iter().filter_map(|value| json(value).ok()).collect()
        };
        let value = match value {
            light::ParameterNeeded::OneOf(values) => ParameterNeeded::OneOf(written(values)),
            light::ParameterNeeded::NoneOf(values) => ParameterNeeded::NoneOf(written(values)),
        };
        Self { parameter: parameter.into(), value }
    }
}

impl From<light::ParameterKind> for ParameterKind {
    fn from(kind: light::ParameterKind) -> Self {
        match kind {
            light::ParameterKind::Number(number) => {
                let included = |bound| if let Bound::Included(end) = bound { Some(end) } else { None };
                let excluded = |bound| if let Bound::Excluded(end) = bound { Some(end) } else { None };
                Self::Number {
                    unit: number.unit.into(),
                    min: included(number.min),
                    max: included(number.max),
                    exclusive_min: excluded(number.min),
                    exclusive_max: excluded(number.max),
                    slider: number.slider,
                    step: number.step,
                    scale: match number.scale {
                        light::ParameterScale::Linear => ParameterScale::Linear,
                        light::ParameterScale::Logarithmic => ParameterScale::Logarithmic,
                    },
                    none: number.absent.map(Into::into),
                }
            }
            light::ParameterKind::Flag => Self::Flag,
            light::ParameterKind::Choice(choices) => {
                let choice = |choice: &light::ParameterChoice| ParameterChoice {
                    name: choice.name.into(),
                    label: choice.label.into(),
                };
                Self::Choice { choices: choices.iter().map(choice).collect() }
            }
            light::ParameterKind::Color => Self::Color,
            light::ParameterKind::Vector { unit, step } => Self::Vector { unit: unit.into(), step },
            light::ParameterKind::Rotation => Self::Rotation,
            light::ParameterKind::Text { max_bytes } => Self::Text { max_bytes },
            light::ParameterKind::Links => {
                Self::Links { max_paths: light::MAX_LINKS, max_bytes: light::MAX_LINK_BYTES }
            }
            light::ParameterKind::PeriodicCurve { min, max, step, absent } => {
                Self::PeriodicCurve { max_knots: light::MAX_KNOTS, min, max, step, none: absent.into() }
            }
            light::ParameterKind::Projection => Self::Projection,
        }
    }
}
