//! Values of parameters in JSON, by the rows of the table.

use std::fmt;

use glam::{DQuat, DVec3};
use light::{MAX_KNOTS, MAX_LINKS, Parameter, ParameterChoice, ParameterKind, ParameterOwner, PeriodicCurve, Value};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, DeserializeSeed, MapAccess, Visitor};
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, json};

use crate::error::excerpt;

/// [`light::Links`] in JSON, for parsing.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Links {
    #[serde(default)]
    include: Vec<String>,
    #[serde(default)]
    exclude: Vec<String>,
}

/// Serializes a value.
pub(crate) struct WireValue<'a>(pub &'a Value);

impl Serialize for WireValue<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Value::Number(number) => number.serialize(serializer),
            Value::Absent => serializer.serialize_none(),
            Value::Flag(flag) => flag.serialize(serializer),
            Value::Choice(name) => name.serialize(serializer),
            Value::Vector(vector) => vector.to_array().serialize(serializer),
            Value::Rotation(rotation) => rotation.to_array().serialize(serializer),
            Value::Text(text) => text.serialize(serializer),
            Value::PeriodicCurve(curve) => curve.knots().serialize(serializer),
            Value::Links(links) => {
                let mut map = serializer.serialize_map(None)?;
                let lists = [("include", links.include()), ("exclude", links.exclude())];
                let mut lists = lists.into_iter().filter(|(_, paths)| !paths.is_empty());
                lists.try_for_each(|(name, paths)| map.serialize_entry(name, paths))?;
                map.end()
            }
        }
    }
}

/// Serializes values as a JSON array.
pub(crate) struct WireValues<'a>(pub &'a [Value]);

impl Serialize for WireValues<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.0.len()))?;
        self.0.iter().try_for_each(|value| list.serialize_element(&WireValue(value)))?;
        list.end()
    }
}

/// Parses a value of the type that the parameter has. `light::Parameter::check` checks the range later.
#[derive(Clone, Copy)]
pub(crate) struct ValueSeed(pub &'static Parameter);

impl<'de> DeserializeSeed<'de> for ValueSeed {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        Ok(match self.0.kind {
            ParameterKind::Number(number) if number.absent.is_some() => {
                Option::<f64>::deserialize(deserializer)?.map_or(Value::Absent, Value::Number)
            }
            ParameterKind::Number(_) => Value::Number(f64::deserialize(deserializer)?),
            ParameterKind::Flag => Value::Flag(bool::deserialize(deserializer)?),
            ParameterKind::Color | ParameterKind::Vector { .. } => {
                Value::Vector(DVec3::from(<[f64; 3]>::deserialize(deserializer)?))
            }
            ParameterKind::Rotation => Value::Rotation(DQuat::from_array(<[f64; 4]>::deserialize(deserializer)?)),
            ParameterKind::Text { .. } => Value::Text(String::deserialize(deserializer)?),
            ParameterKind::Choice(choices) => {
                let word = String::deserialize(deserializer)?;
                let known = choices.iter().find(|choice| choice.name == word);
                Value::Choice(known.ok_or_else(|| unknown("variant", &word, names(choices)))?.name)
            }
            ParameterKind::Links => {
                let links = Option::<Links>::deserialize(deserializer)?;
                links
                    .and_then(|links| light::Links::new(links.include, links.exclude))
                    .map_or(Value::Absent, Value::Links)
            }
            ParameterKind::PeriodicCurve { .. } => Option::<Vec<[f64; 2]>>::deserialize(deserializer)?
                .and_then(PeriodicCurve::new)
                .map_or(Value::Absent, Value::PeriodicCurve),
            ParameterKind::Projection => return Err(de::Error::custom("a projection is set with setCamera")),
        })
    }
}

/// Parses an array of values of the type that the parameter has. If the parameter has a default, `null` gives `None`,
/// as if the array were left out.
#[derive(Clone, Copy)]
pub(crate) struct ValueListSeed(pub &'static Parameter);

impl<'de> DeserializeSeed<'de> for ValueListSeed {
    type Value = Option<Vec<Value>>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Option<Vec<Value>>, D::Error> {
        if self.0.default(ParameterOwner::Point).is_some() {
            return deserializer.deserialize_option(self);
        }
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for ValueListSeed {
    type Value = Option<Vec<Value>>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a sequence")
    }

    fn visit_unit<E: de::Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_none<E: de::Error>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_seq(self)
    }

    fn visit_seq<A: de::SeqAccess<'de>>(self, mut items: A) -> Result<Self::Value, A::Error> {
        let values = std::iter::from_fn(|| items.next_element_seed(ValueSeed(self.0)).transpose());
        values.collect::<Result<_, _>>().map(Some)
    }
}

fn names(choices: &[ParameterChoice]) -> impl Iterator<Item = &'static str> {
    choices.iter().map(|choice| choice.name)
}

/// Returns the error for a name that is none of `expected`.
pub(crate) fn unknown<E: de::Error>(what: &str, word: &str, expected: impl IntoIterator<Item = &'static str>) -> E {
    let expected: Vec<_> = expected.into_iter().map(|name| format!("`{name}`")).collect();
    let expected = match &expected[..] {
        [a, b] => format!("{a} or {b}"),
        all => format!("one of {}", all.join(", ")),
    };
    de::Error::custom(format!("unknown {what} `{}`, expected {expected}", excerpt(word)))
}

/// Returns the JSON Schema of a parameter's values.
pub(crate) fn schema(row: &Parameter) -> Map<String, serde_json::Value> {
    use std::ops::Bound::{Excluded, Included};
    let vector = |length: usize| json!({"type": "array", "items": {"type": "number", "format": "double"}, "minItems": length, "maxItems": length});
    let mut schema = match row.kind {
        ParameterKind::Number(number) => {
            let mut schema = if number.absent.is_some() {
                json!({"type": ["number", "null"], "format": "double"})
            } else {
                json!({"type": "number", "format": "double"})
            };
            for (bound, included, excluded) in
                [(number.min, "minimum", "exclusiveMinimum"), (number.max, "maximum", "exclusiveMaximum")]
            {
                match bound {
                    Included(end) => schema[included] = end.into(),
                    Excluded(end) => schema[excluded] = end.into(),
                    std::ops::Bound::Unbounded => {}
                }
            }
            schema
        }
        ParameterKind::Flag => json!({"type": "boolean"}),
        ParameterKind::Choice(choices) => {
            json!({"type": "string", "enum": names(choices).collect::<Vec<_>>()})
        }
        ParameterKind::Color | ParameterKind::Vector { .. } => vector(3),
        ParameterKind::Rotation => vector(4),
        ParameterKind::Text { .. } => json!({"type": "string"}),
        ParameterKind::Links => {
            let paths = |description| json!({"type": "array", "items": {"type": "string"}, "maxItems": MAX_LINKS, "description": description});
            json!({
                "type": ["object", "null"],
                "properties": {
                    "include": paths("Paths of nodes; where there are none, all nodes."),
                    "exclude": paths("Paths of nodes that are left out."),
                },
                "additionalProperties": false,
            })
        }
        ParameterKind::PeriodicCurve { .. } => {
            json!({"type": ["array", "null"], "items": vector(2), "maxItems": MAX_KNOTS})
        }
        ParameterKind::Projection => json!({}),
    };
    schema["description"] = row.doc.into();
    match schema {
        serde_json::Value::Object(fields) => fields,
        _ => Map::new(),
    }
}

/// Defines a type for settings in JSON, of the parameters that any of some owners has: an object with one field, named
/// like the parameter.
macro_rules! setting {
    ($(#[$doc:meta])* $name:ident of $owners:expr) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name(pub light::Setting);

        impl $name {
            fn row(name: &str) -> Option<&'static Parameter> {
                $owners.iter().find_map(|owner| light::parameter_of(*owner, name))
            }

            pub(crate) fn rows() -> Vec<&'static Parameter> {
                let of_any = |row: &&'static Parameter| $owners.iter().any(|owner| row.for_owner(*owner).is_some());
                light::parameters().iter().copied().filter(of_any).collect()
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let mut map = serializer.serialize_map(Some(1))?;
                map.serialize_entry(self.0.parameter.name, &WireValue(&self.0.value))?;
                map.end()
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct One;
                impl<'de> Visitor<'de> for One {
                    type Value = $name;

                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        f.write_str("an object with one parameter")
                    }

                    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<$name, A::Error> {
                        let Some(name) = map.next_key::<String>()? else {
                            return Err(de::Error::custom("expected an object with one parameter"));
                        };
                        let names = || $name::rows().into_iter().map(|row| row.name);
                        let parameter = $name::row(&name).ok_or_else(|| unknown("parameter", &name, names()))?;
                        let value = map.next_value_seed(ValueSeed(parameter))?;
                        if let Some(second) = map.next_key::<String>()? {
                            let second = excerpt(&second);
                            let sentence = format!("expected an object with one parameter, not `{name}` and `{second}`");
                            return Err(de::Error::custom(sentence));
                        }
                        Ok($name(light::Setting { parameter, value }))
                    }
                }
                deserializer.deserialize_map(One)
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                let one = |row: &'static Parameter| {
                    json!({
                        "type": "object",
                        "description": row.doc,
                        "properties": {row.name: schema(row)},
                        "required": [row.name],
                        "additionalProperties": false,
                    })
                };
                let options: Vec<_> = Self::rows().into_iter().map(one).collect();
                json_schema!({"description": "A parameter and its value: an object with one field.", "oneOf": options})
            }
        }

        impl From<light::Setting> for $name {
            fn from(setting: light::Setting) -> Self {
                Self(setting)
            }
        }

        impl From<$name> for light::Setting {
            fn from(wire: $name) -> Self {
                wire.0
            }
        }
    };
}

setting! {
    /// [`light::Setting`] of a light in JSON: an object with one field.
    LightParameter of [ParameterOwner::Spot, ParameterOwner::Bendy, ParameterOwner::Omni, ParameterOwner::Directional]
}
setting! {
    /// [`light::Setting`] of a control point in JSON: an object with one field.
    PointParameter of [ParameterOwner::Point]
}
