//! Table of parameters in JSON. The page and programs build their controls from it.

use std::collections::BTreeMap;
use std::ops::Bound;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::conversion::same_variants;
use crate::parameter::WireValue;

/// Table of all parameters that can be set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ParameterTable {
    /// Rows, in the order of presentation.
    pub parameters: Vec<Parameter>,
}

/// [`light::Parameter`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Parameter {
    /// Name in commands, light files and logs.
    pub name: String,
    /// Owners of the parameter: types of lights, control points or cameras.
    pub of: Vec<ParameterOwner>,
    /// Address in a document by owner, for the command `set`: `/lights/ID/coneAngle`.
    pub address: BTreeMap<String, String>,
    /// Kind and range of the values.
    pub kind: ParameterKind,
    /// Default by owner, as in light files. An owner that must have a value of its own is left out.
    pub default: BTreeMap<String, Value>,
    /// Path in the owner's JSON, with `/` between nested fields. For a control point, the path of the light's
    /// list.
    pub path: String,
    /// Results that become stale when the parameter changes.
    pub touches: ParameterTouches,
    /// True if keyframes may drive the parameter.
    pub animates: bool,
    /// Required value of another parameter of the same owner. Without it this parameter has no effect. Left out
    /// if the parameter always has an effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needs: Option<ParameterNeeds>,
    /// Owners that keep the parameter only for later, such as a spotlight that may be bent. It has no effect on
    /// their pictures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub idle_of: Vec<ParameterOwner>,
    /// Heading of the parameter's group.
    pub group: String,
    /// Name for people.
    pub label: String,
    /// One sentence about the parameter.
    pub doc: String,
}

/// [`light::ParameterNeeds`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct ParameterNeeds {
    /// Name of the other parameter.
    pub parameter: String,
    pub value: ParameterNeeded,
}

/// [`light::ParameterNeeded`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ParameterNeeded {
    /// Values of which the other parameter has one.
    OneOf(#[schemars(schema_with = "values")] Vec<Value>),
    /// Values of which the other parameter has none.
    NoneOf(#[schemars(schema_with = "values")] Vec<Value>),
}

/// Returns a schema with explicit item types, because client generators reject the schema `true` for items.
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
    /// No picture.
    Nothing,
    /// Factors by which pictures add the light's contribution.
    Weight,
    /// Contribution of the light to pictures.
    Radiance,
    /// Contribution of the light and its shadow map.
    ShadowMap,
    /// All pictures and maps.
    Scene,
}

/// [`light::ParameterKind`] in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase", rename_all_fields = "camelCase", deny_unknown_fields)]
pub enum ParameterKind {
    /// Number.
    Number {
        /// Unit; empty for none.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        unit: String,
        /// Minimum, inclusive.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        min: Option<f64>,
        /// Maximum, inclusive.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max: Option<f64>,
        /// Minimum, exclusive.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        exclusive_min: Option<f64>,
        /// Maximum, exclusive.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        exclusive_max: Option<f64>,
        /// Ends of a slider. A typed value may lie beyond them, within the range.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        slider: Option<[f64; 2]>,
        /// Step of a control.
        step: f64,
        /// Scale of a slider.
        scale: ParameterScale,
        /// Meaning of `null`, for people. If left out, the value must be a number.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        none: Option<String>,
    },
    /// Boolean.
    Flag,
    /// One of several names.
    Choice { choices: Vec<ParameterChoice> },
    /// Color in linear RGB.
    Color,
    /// Vector of three numbers.
    Vector {
        /// Unit of each number; empty for none.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        unit: String,
        /// Step of a control for each number.
        step: f64,
    },
    /// Rotation as a unit quaternion `[x, y, z, w]`.
    Rotation,
    /// Text.
    Text {
        /// Maximum length in bytes of UTF-8.
        max_bytes: usize,
    },
    /// Set of nodes of the scene: `{"include": [PATH, ...], "exclude": [PATH, ...]}`, or `null` for all nodes.
    Links {
        /// Maximum number of paths in both lists together.
        max_paths: usize,
        /// Maximum length of all paths together, in bytes of UTF-8.
        max_bytes: usize,
    },
    /// Number as a function of an angle: `[[DEGREES, NUMBER], ...]`, or `null` for none. Degrees ascend from 0
    /// to less than 360. The number is linear between pairs, and from the last pair around to the first.
    PeriodicCurve {
        /// Maximum number of pairs.
        max_knots: usize,
        /// Minimum of the number.
        min: f64,
        /// Maximum of the number.
        max: f64,
        /// Step of a control.
        step: f64,
        /// Meaning of `null`, for people.
        none: String,
    },
    /// Projection of a camera as a whole.
    Projection,
}

/// [`light::ParameterScale`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum ParameterScale {
    /// Linear scale.
    Linear,
    /// Logarithmic scale.
    Logarithmic,
}

/// [`light::ParameterChoice`] in JSON.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterChoice {
    /// Name in JSON.
    pub name: String,
    /// Name for people.
    pub label: String,
}

/// Returns the table of all parameters of lights, control points and cameras in this version of the program.
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

    /// Returns the start of addresses of the owner's parameters.
    fn address_prefix(self) -> &'static str {
        match self {
            Self::Spot | Self::Bendy | Self::Omni | Self::Directional => "/lights/ID",
            Self::Point => "/lights/ID/points/INDEX",
            Self::Camera => "/cameras/ID",
        }
    }
}

same_variants!(light::ParameterOwner => ParameterOwner { Spot, Bendy, Omni, Directional, Point, Camera });
same_variants!(light::ParameterTouches => ParameterTouches { Nothing, Weight, Radiance, ShadowMap, Scene });
same_variants!(light::ParameterScale => ParameterScale { Linear, Logarithmic });

impl From<&light::Parameter> for Parameter {
    fn from(row: &light::Parameter) -> Self {
        let of: Vec<_> = row.owners.iter().map(|of| ParameterOwner::from(of.owner)).collect();
        let default = |of: &light::ParameterOf| {
            let default = serde_json::to_value(WireValue(&row.default(of.owner)?)).ok()?;
            Some((ParameterOwner::from(of.owner).name().into(), default))
        };
        let address =
            |owner: &ParameterOwner| (owner.name().into(), format!("{}/{}", owner.address_prefix(), row.name));
        Self {
            name: row.name.into(),
            address: of.iter().map(address).collect(),
            of,
            kind: row.kind.into(),
            default: row.owners.iter().filter_map(default).collect(),
            path: row.path.replace('.', "/"),
            touches: row.touches().into(),
            animates: row.animates,
            needs: row.needs.map(Into::into),
            idle_of: row.owners.iter().filter(|of| row.has_no_effect_on(of.owner)).map(|of| of.owner.into()).collect(),
            group: row.group.into(),
            label: row.label.into(),
            doc: row.doc.into(),
        }
    }
}

impl From<light::ParameterNeeds> for ParameterNeeds {
    fn from(light::ParameterNeeds { parameter, value }: light::ParameterNeeds) -> Self {
        let written = |values: &[light::Value<&'static str>]| {
            let json = |value: &light::Value<&'static str>| serde_json::to_value(WireValue(&value.to_value()));
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
                    scale: number.scale.into(),
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
