//! A light in JSON, and its conversion from and to the domain.
//!
//! Field names are the JSON's in camelCase. Unknown fields are refused by name. Lengths are light-local units
//! (of a [`Bendy`]) or world units (of a [`Spot`]), angles are degrees, colours are linear RGB.

use glam::{DQuat, DVec3};
use light::LightKind;
use light::{BendyLight, Decay, Direction, EndMode, Frame, LightError, SpotLight, Tube, check_spot};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};

/// One light. In JSON the field `type` says which.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Light {
    /// `"type": "bendy"`: light along a spline.
    Bendy(Bendy),
    /// `"type": "spot"`: light along straight lines.
    Spot(Spot),
}

/// The `type` of a [`Bendy`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(inline)]
pub enum BendyType {
    /// The only one.
    #[default]
    Bendy,
}

/// The `type` of a [`Spot`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
#[schemars(inline)]
pub enum SpotType {
    /// The only one.
    #[default]
    Spot,
}

/// [`BendyLight`] in JSON. Only `type`, `points` and `radii` are required.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Bendy {
    /// `"bendy"`.
    pub r#type: BendyType,
    /// Name for people and for `--light`; empty by default.
    #[serde(default)]
    pub name: String,
    /// Placement in the world; the identity by default.
    #[serde(default)]
    pub transform: Transform,
    /// Control points, three or more; the first is the source, `[0, 0, 0]`.
    pub points: Vec<[f64; 3]>,
    /// One a control point, zero or more.
    pub radii: Vec<f64>,
    /// One a control point; white by default.
    #[serde(default)]
    #[schemars(with = "Vec<[f64; 3]>")]
    pub colors: Option<Vec<[f64; 3]>>,
    /// One a control point; 1 by default.
    #[serde(default)]
    #[schemars(with = "Vec<f64>")]
    pub intensities: Option<Vec<f64>>,
    /// Orients the cross-section at the source; `[0, 1, 0]` by default.
    #[serde(default = "default_up")]
    pub up: [f64; 3],
    /// Half angle, `0 < coneAngle < 90`; 25 by default.
    #[serde(default = "default_cone_angle")]
    pub cone_angle: f64,
    /// Share of the cone angle over which the profile falls to zero, 0 to 1; 0.2 by default.
    #[serde(default = "default_cone_softness")]
    pub cone_softness: f64,
    /// `"rotationMinimizing"` (default) or `"up"`.
    #[serde(default, with = "FrameName")]
    #[schemars(with = "FrameName")]
    pub frame: Frame,
    /// `"tube"` (default) or `"path"`.
    #[serde(default, with = "DirectionName")]
    #[schemars(with = "DirectionName")]
    pub direction: Direction,
    /// `"cut"` (default) or `"extend"`.
    #[serde(default, with = "EndModeName")]
    #[schemars(with = "EndModeName")]
    pub end_mode: EndMode,
    /// `"none"` (default), `"linear"` or `"inverseSquare"`.
    #[serde(default, with = "DecayName")]
    #[schemars(with = "DecayName")]
    pub decay: Decay,
}

/// [`SpotLight`] in JSON. Only `type` is required; the rest defaults to [`SpotLight::default`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct Spot {
    /// `"spot"`.
    pub r#type: SpotType,
    /// Name for people and for `--light`; empty by default.
    pub name: String,
    /// Placement in the world; the identity by default. The light shines along its local -Z.
    pub transform: Transform,
    /// White by default.
    pub color: [f64; 3],
    /// 1 by default; candela with inverse-square decay.
    pub intensity: f64,
    /// Half angle, `0 < coneAngle < 90`; 25 by default.
    pub cone_angle: f64,
    /// Share of the cone angle over which the profile falls to zero, 0 to 1; 0.2 by default.
    pub cone_softness: f64,
    /// World distance along the axis at which the light ends; endless by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<f64>,
    /// `"none"`, `"linear"` or `"inverseSquare"` (default).
    #[serde(with = "DecayName")]
    #[schemars(with = "DecayName")]
    pub decay: Decay,
}

/// [`light::Transform`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct Transform {
    /// World position of the light's origin.
    pub translation: [f64; 3],
    /// Quaternion `[x, y, z, w]`, light-local to world axes.
    pub rotation: [f64; 4],
    /// World units per light-local unit, more than 0.
    pub scale: f64,
}

/// [`light::Frame`] in JSON.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Frame", rename_all = "camelCase")]
#[schemars(rename = "Frame")]
pub(crate) enum FrameName {
    RotationMinimizing,
    Up,
}

/// [`light::Direction`] in JSON.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Direction", rename_all = "camelCase")]
#[schemars(rename = "Direction")]
pub(crate) enum DirectionName {
    Tube,
    Path,
}

/// [`light::EndMode`] in JSON.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "EndMode", rename_all = "camelCase")]
#[schemars(rename = "EndMode")]
pub(crate) enum EndModeName {
    Cut,
    Extend,
}

/// [`light::Decay`] in JSON.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Decay", rename_all = "camelCase")]
#[schemars(rename = "Decay")]
pub(crate) enum DecayName {
    None,
    Linear,
    InverseSquare,
}

impl<'de> Deserialize<'de> for Light {
    /// By `type`; the reason for a refusal names the field.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = serde_json::Value::deserialize(deserializer)?;
        let refused = |error: serde_path_to_error::Error<serde_json::Error>| match error.path().to_string() {
            root if root == "." => de::Error::custom(format!("light: {}", error.into_inner())),
            field => de::Error::custom(format!("light.{field}: {}", error.into_inner())),
        };
        match value.get("type").and_then(serde_json::Value::as_str) {
            Some("bendy") => serde_path_to_error::deserialize(value).map(Self::Bendy).map_err(refused),
            Some("spot") => serde_path_to_error::deserialize(value).map(Self::Spot).map_err(refused),
            _ => Err(de::Error::custom("light.type: expected \"bendy\" or \"spot\"")),
        }
    }
}

fn default_up() -> [f64; 3] {
    DVec3::Y.to_array()
}

fn default_cone_angle() -> f64 {
    light::DEFAULT_CONE_ANGLE
}

fn default_cone_softness() -> f64 {
    light::DEFAULT_CONE_SOFTNESS
}

impl Default for Spot {
    fn default() -> Self {
        Self::new(String::new(), &SpotLight::default())
    }
}

impl Default for Transform {
    fn default() -> Self {
        Self::from(light::Transform::default())
    }
}

impl From<light::Transform> for Transform {
    fn from(t: light::Transform) -> Self {
        Self { translation: t.translation.to_array(), rotation: t.rotation.to_array(), scale: t.scale }
    }
}

impl From<Transform> for light::Transform {
    fn from(t: Transform) -> Self {
        Self { translation: t.translation.into(), rotation: DQuat::from_array(t.rotation), scale: t.scale }
    }
}

impl From<&light::Light> for Light {
    fn from(light: &light::Light) -> Self {
        let name = light.name.clone();
        match &light.kind {
            LightKind::Bendy(bendy) => Self::Bendy(Bendy::new(name, bendy)),
            LightKind::Spot(spot) => Self::Spot(Spot::new(name, spot)),
        }
    }
}

impl TryFrom<Light> for light::Light {
    type Error = LightError;

    /// Every light that comes out can be evaluated: the model's own checks run here.
    fn try_from(light: Light) -> Result<Self, LightError> {
        match light {
            Light::Bendy(wire) => {
                let name = wire.name.clone();
                let bendy = BendyLight::from(wire);
                Tube::<f64>::new(&bendy)?;
                Ok(Self { name, kind: LightKind::Bendy(bendy) })
            }
            Light::Spot(wire) => {
                let name = wire.name.clone();
                let spot = SpotLight::from(wire);
                check_spot(&spot)?;
                Ok(Self { name, kind: LightKind::Spot(spot) })
            }
        }
    }
}

impl Bendy {
    fn new(name: String, light: &BendyLight) -> Self {
        Self {
            r#type: BendyType::Bendy,
            name,
            transform: light.transform.into(),
            points: light.points.iter().map(DVec3::to_array).collect(),
            radii: light.radii.clone(),
            colors: Some(light.colors.iter().map(DVec3::to_array).collect()),
            intensities: Some(light.intensities.clone()),
            up: light.up.to_array(),
            cone_angle: light.cone_angle,
            cone_softness: light.cone_softness,
            frame: light.frame,
            direction: light.direction,
            end_mode: light.end_mode,
            decay: light.decay,
        }
    }
}

impl From<Bendy> for BendyLight {
    fn from(wire: Bendy) -> Self {
        let points = wire.points.into_iter().map(DVec3::from).collect();
        let defaults = Self::new(points, wire.radii);
        Self {
            transform: wire.transform.into(),
            colors: wire.colors.map_or(defaults.colors, |c| c.into_iter().map(DVec3::from).collect()),
            intensities: wire.intensities.unwrap_or(defaults.intensities),
            up: wire.up.into(),
            cone_angle: wire.cone_angle,
            cone_softness: wire.cone_softness,
            frame: wire.frame,
            direction: wire.direction,
            end_mode: wire.end_mode,
            decay: wire.decay,
            points: defaults.points,
            radii: defaults.radii,
        }
    }
}

impl Spot {
    fn new(name: String, light: &SpotLight) -> Self {
        Self {
            r#type: SpotType::Spot,
            name,
            transform: light.transform.into(),
            color: light.color.to_array(),
            intensity: light.intensity,
            cone_angle: light.cone_angle,
            cone_softness: light.cone_softness,
            range: light.range,
            decay: light.decay,
        }
    }
}

impl From<Spot> for SpotLight {
    fn from(wire: Spot) -> Self {
        Self {
            transform: wire.transform.into(),
            color: wire.color.into(),
            intensity: wire.intensity,
            cone_angle: wire.cone_angle,
            cone_softness: wire.cone_softness,
            range: wire.range,
            decay: wire.decay,
        }
    }
}
