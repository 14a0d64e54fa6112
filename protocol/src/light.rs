//! Lights in JSON, and their conversion from and to the domain.
//!
//! The fields are the rows of the parameter table, by their paths. A BendyLight has lists with the parameters
//! of its control points. Unknown fields are refused by name. Lengths are in light-local or world units as the
//! rows say. Colors are linear RGB.

use std::borrow::Cow;
use std::fmt;

use document::was_in_format_2;
use light::{
    CheckedLight, ControlPoint, LightError, LightShape, MAX_NAME_BYTES, Parameter, ParameterOwner, Setting, Value,
};
use schemars::generate::Contract;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{self, DeserializeSeed, IgnoredAny, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, json};

use crate::parameter::{ValueListSeed, ValueSeed, WireValue, WireValues, schema, unknown};
use crate::words::json_wording;

/// Light in JSON. The field `type` gives its type.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    owner: ParameterOwner,
    /// Parameters that are given, in the order of the table.
    settings: Vec<Setting>,
    /// Lists that are given for a BendyLight, each with one value per control point.
    lists: Vec<(&'static Parameter, Vec<Value>)>,
}

/// Type of a light in JSON.
struct Type {
    /// Value of the field `type`.
    name: &'static str,
    owner: ParameterOwner,
    schema_name: &'static str,
    /// Sentence about the type in schemas.
    doc: &'static str,
}

/// All types of lights.
const TYPES: [Type; 4] = [
    Type {
        name: "bendy",
        owner: ParameterOwner::Bendy,
        schema_name: "Bendy",
        doc: "Light along a spline. Each list has one value a control point, three or more; the first is the source.",
    },
    Type {
        name: "spot",
        owner: ParameterOwner::Spot,
        schema_name: "Spot",
        doc: "Light along straight lines, in a cone.",
    },
    Type { name: "omni", owner: ParameterOwner::Omni, schema_name: "Omni", doc: "Light from a point to all sides." },
    Type {
        name: "directional",
        owner: ParameterOwner::Directional,
        schema_name: "Directional",
        doc: "Light along parallel lines from infinitely far away.",
    },
];

fn type_of(owner: ParameterOwner) -> &'static str {
    TYPES.iter().find(|known| known.owner == owner).map_or("", |known| known.name)
}

/// Parses the value of the field `type`.
pub(crate) struct WireLightType(pub ParameterOwner);

impl<'de> Deserialize<'de> for WireLightType {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        let known = TYPES.iter().find(|known| known.name == word);
        let known = known.ok_or_else(|| unknown("variant", &word, TYPES.iter().map(|known| known.name)))?;
        Ok(Self(known.owner))
    }
}

/// Field of a light's JSON object.
#[derive(Clone, Copy, PartialEq)]
enum Field {
    Type,
    /// Object of the parameters whose paths begin with this name.
    Group(&'static str),
    Parameter(&'static Parameter),
    List(&'static Parameter),
}

impl Field {
    /// Returns the fields of a light, in the order of serialization.
    fn all(owner: ParameterOwner) -> Vec<Self> {
        let mut fields = vec![Self::Type];
        for &row in light::parameters_of(owner) {
            match row.path.split_once('.') {
                None => fields.push(Self::Parameter(row)),
                Some((group, _)) if fields.contains(&Self::Group(group)) => {}
                Some((group, _)) => {
                    fields.push(Self::Group(group));
                    let lists = light::parameters_of(ParameterOwner::Point).iter().copied().map(Self::List);
                    fields.extend(lists.filter(|_| owner == ParameterOwner::Bendy));
                }
            }
        }
        fields
    }

    fn name(self) -> &'static str {
        match self {
            Self::Type => "type",
            Self::Group(name) => name,
            Self::Parameter(row) | Self::List(row) => row.path,
        }
    }
}

/// Returns the parameters of a group of fields, each with its name inside the group.
fn group(owner: ParameterOwner, name: &str) -> impl Iterator<Item = (&'static Parameter, &'static str)> {
    let rows = light::parameters_of(owner).iter();
    rows.filter_map(move |row| row.path.strip_prefix(name)?.strip_prefix('.').map(|field| (*row, field)))
}

impl Serialize for Light {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        struct Group<'a>(&'a Light, &'static str);
        impl Serialize for Group<'_> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let mut map = serializer.serialize_map(None)?;
                for (row, field) in group(self.0.owner, self.1) {
                    if let Some(value) = self.0.value(row) {
                        map.serialize_entry(field, &WireValue(value))?;
                    }
                }
                map.end()
            }
        }
        let mut map = serializer.serialize_map(None)?;
        for field in Field::all(self.owner) {
            match field {
                Field::Type => map.serialize_entry("type", type_of(self.owner))?,
                Field::Group(name) => map.serialize_entry(name, &Group(self, name))?,
                Field::Parameter(row) => {
                    if let Some(value) = self.value(row) {
                        map.serialize_entry(row.path, &WireValue(value))?;
                    }
                }
                Field::List(row) => {
                    if let Some((_, values)) = self.lists.iter().find(|(known, _)| *known == row) {
                        map.serialize_entry(row.path, &WireValues(values))?;
                    }
                }
            }
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Light {
    /// Parses the object according to its field `type`. An error names the field at fault.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let said = |error: &serde_json::Error| json_wording(&error.to_string());
        let value = serde_json::Value::deserialize(deserializer)?;
        let named = value.get("type").unwrap_or(&serde_json::Value::Null);
        let WireLightType(owner) = WireLightType::deserialize(named)
            .map_err(|error| de::Error::custom(format!("light.type: {}", said(&error))))?;
        let mut track = serde_path_to_error::Track::new();
        let tracked = serde_path_to_error::Deserializer::new(value, &mut track);
        LightSeed(owner).deserialize(tracked).map_err(|error| match track.path().to_string() {
            root if root == "." => de::Error::custom(format!("light: {}", said(&error))),
            field => de::Error::custom(format!("light.{field}: {}", said(&error))),
        })
    }
}

/// Parses a light of the given type.
#[derive(Clone, Copy)]
pub(crate) struct LightSeed(pub ParameterOwner);

impl<'de> DeserializeSeed<'de> for LightSeed {
    type Value = Light;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Light, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for LightSeed {
    type Value = Light;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a light")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Light, A::Error> {
        let fields = Field::all(self.0);
        let names: Vec<_> = fields.iter().map(|field| field.name()).collect();
        let mut given = vec![false; fields.len()];
        let mut light = Light { owner: self.0, settings: Vec::new(), lists: Vec::new() };
        while let Some(index) = map.next_key_seed(FieldNameSeed(&names))? {
            if std::mem::replace(&mut given[index], true) {
                return Err(de::Error::duplicate_field(names[index]));
            }
            match fields[index] {
                Field::Type => drop(map.next_value::<IgnoredAny>()?),
                Field::Group(name) => light.settings.extend(map.next_value_seed(GroupSeed(self.0, name))?),
                Field::Parameter(parameter) => {
                    let value = map.next_value_seed(ValueSeed(parameter))?;
                    light.settings.push(Setting { parameter, value });
                }
                Field::List(row) => {
                    light.lists.extend(map.next_value_seed(ValueListSeed(row))?.map(|values| (row, values)));
                }
            }
        }
        for (field, given) in fields.iter().zip(given) {
            let required = match field {
                Field::Type => true,
                Field::List(row) => row.default(ParameterOwner::Point).is_none(),
                Field::Group(_) | Field::Parameter(_) => false,
            };
            if required && !given {
                return Err(de::Error::missing_field(field.name()));
            }
        }
        // Sorts by the table, so that two lights are equal if only the order of their fields differs.
        light.settings.retain(|setting| is_written(self.0, setting.parameter, &setting.value));
        light.settings.sort_by_key(|setting| row_index(self.0, setting.parameter));
        light.lists.sort_by_key(|(row, _)| row_index(ParameterOwner::Point, row));
        Ok(light)
    }
}

/// Returns true if the value is written to the JSON. An absent value is left out if absence is its default.
fn is_written(owner: ParameterOwner, row: &Parameter, value: &Value) -> bool {
    *value != Value::Absent || row.default(owner) != Some(Value::Absent)
}

/// Returns the index of a parameter in its owner's list.
fn row_index(owner: ParameterOwner, row: &Parameter) -> Option<usize> {
    light::parameters_of(owner).iter().position(|known| **known == *row)
}

/// Parses the settings of a group.
struct GroupSeed(ParameterOwner, &'static str);

impl<'de> DeserializeSeed<'de> for GroupSeed {
    type Value = Vec<Setting>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Vec<Setting>, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for GroupSeed {
    type Value = Vec<Setting>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an object: a {}", self.1)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Vec<Setting>, A::Error> {
        let (rows, names): (Vec<_>, Vec<_>) = group(self.0, self.1).unzip();
        let mut settings: Vec<Setting> = Vec::new();
        while let Some(index) = map.next_key_seed(FieldNameSeed(&names))? {
            let parameter = rows[index];
            if settings.iter().any(|setting| setting.parameter == parameter) {
                return Err(de::Error::duplicate_field(names[index]));
            }
            settings.push(Setting { parameter, value: map.next_value_seed(ValueSeed(parameter))? });
        }
        Ok(settings)
    }
}

/// Parses the name of a field and returns its index.
struct FieldNameSeed<'a>(&'a [&'static str]);

impl<'de> DeserializeSeed<'de> for FieldNameSeed<'_> {
    type Value = usize;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<usize, D::Error> {
        let name = String::deserialize(deserializer)?;
        let index = self.0.iter().position(|known| *known == name);
        index.ok_or_else(|| unknown("field", &name, self.0.iter().copied()))
    }
}

impl Light {
    /// Returns the name of a parameter or type in the light that formats 1 and 2 did not have.
    pub(crate) fn missing_in_format_2(&self) -> Option<&'static str> {
        // In those formats lights of every type had a name, so a type without one is unknown to them.
        let is_known = was_in_format_2(self.owner, light::parameters::NAME.name);
        let settings = self.settings.iter().map(|setting| (self.owner, setting.parameter));
        let lists = self.lists.iter().map(|(row, _)| (ParameterOwner::Point, *row));
        let mut younger = settings.chain(lists).filter(|(owner, row)| !was_in_format_2(*owner, row.name));
        if is_known { younger.next().map(|(_, row)| row.path) } else { Some(type_of(self.owner)) }
    }

    /// Cuts a name that is longer than the limit of documents.
    pub(crate) fn cut_name(&mut self) {
        for Setting { parameter, value } in &mut self.settings {
            if **parameter == *light::parameters::NAME
                && let Value::Text(name) = value
            {
                name.truncate(name.floor_char_boundary(MAX_NAME_BYTES));
            }
        }
    }

    fn value(&self, row: &Parameter) -> Option<&Value> {
        self.settings.iter().find(|setting| *setting.parameter == *row).map(|setting| &setting.value)
    }

    /// Returns the control points that the lists describe, or an error if their lengths differ.
    fn points(&self) -> Result<Vec<ControlPoint>, LightError> {
        let given = |row: &Parameter| self.lists.iter().find(|(known, _)| **known == *row);
        let rows = light::parameters_of(ParameterOwner::Point);
        let count = given(&light::parameters::POSITION).map_or(0, |(_, positions)| positions.len());
        if count < 3 {
            return Err(LightError::TooFewPoints(count));
        }
        let mut points = vec![ControlPoint::new(glam::DVec3::ZERO, 0.0); count];
        for (row, values) in rows.iter().filter_map(|row| given(row)) {
            if values.len() != count {
                return Err(LightError::LengthMismatch { field: row.path, count: values.len(), points: count });
            }
            for (point, value) in points.iter_mut().zip(values) {
                point.set(&Setting { parameter: row, value: value.clone() });
            }
        }
        Ok(points)
    }
}

impl From<&light::Light> for Light {
    fn from(light: &light::Light) -> Self {
        let owner = light.owner();
        let given = light.values().filter(|(row, value)| is_written(owner, row, value));
        let settings = given.map(|(parameter, value)| Setting { parameter, value: value.clone() });
        let lists = light::parameters_of(ParameterOwner::Point).iter().filter(|_| owner == ParameterOwner::Bendy);
        let list =
            |row: &&'static Parameter| (*row, light.points().iter().filter_map(|point| point.value(row)).collect());
        Self { owner, settings: settings.collect(), lists: lists.map(list).collect() }
    }
}

impl From<&CheckedLight> for Light {
    fn from(light: &CheckedLight) -> Self {
        light.light().into()
    }
}

impl TryFrom<Light> for CheckedLight {
    type Error = LightError;

    fn try_from(wire: Light) -> Result<Self, LightError> {
        let shape = match wire.owner {
            ParameterOwner::Bendy => LightShape::Bendy(wire.points()?),
            ParameterOwner::Omni => LightShape::Omni,
            ParameterOwner::Directional => LightShape::Directional,
            // No light is a control point or a camera.
            ParameterOwner::Spot | ParameterOwner::Point | ParameterOwner::Camera => LightShape::Spot,
        };
        let mut light = light::Light::new(shape);
        wire.settings.into_iter().for_each(|setting| light.set(setting));
        CheckedLight::new(light)
    }
}

/// Schema of the type of light with this index in [`TYPES`].
struct LightTypeSchema<const TYPE: usize>;

fn light_schema(owner: ParameterOwner, doc: &str, generator: &SchemaGenerator) -> Schema {
    let written = generator.settings().contract == Contract::Serialize;
    let with_default = |row: &Parameter, of: ParameterOwner| {
        let mut schema = schema(row);
        if let Some(default) = row.default(of).filter(|default| *default != Value::Absent)
            && let Ok(default) = serde_json::to_value(WireValue(&default))
        {
            schema.insert("default".into(), default);
        }
        schema
    };
    let object = |properties: Map<String, serde_json::Value>, required: Vec<&str>| json!({"type": "object", "properties": properties, "required": required, "additionalProperties": false});
    let optional = |row: &Parameter| row.default(owner) == Some(Value::Absent);
    let (mut properties, mut required) = (Map::new(), vec!["type"]);
    for field in Field::all(owner) {
        let schema = match field {
            Field::Type => json!({"type": "string", "const": type_of(owner), "default": type_of(owner)}),
            Field::Group(name) => {
                let rows = || group(owner, name);
                let properties = rows().map(|(row, field)| (field.into(), with_default(row, owner).into()));
                object(properties.collect(), rows().map(|(_, field)| field).filter(|_| written).collect())
            }
            Field::Parameter(row) => with_default(row, owner).into(),
            Field::List(row) => {
                let mut items = schema(row);
                items.remove("description");
                json!({"type": "array", "items": items, "description": format!("{} One a control point.", row.doc)})
            }
        };
        let needed = match field {
            Field::Type => false,
            Field::Group(_) => written,
            Field::Parameter(row) => written && !optional(row),
            Field::List(row) => written || row.default(ParameterOwner::Point).is_none(),
        };
        required.extend(needed.then_some(field.name()));
        properties.insert(field.name().into(), schema);
    }
    let mut schema = object(properties, required);
    schema["description"] = doc.into();
    schema.try_into().unwrap_or_default()
}

impl<const TYPE: usize> JsonSchema for LightTypeSchema<TYPE> {
    fn schema_name() -> Cow<'static, str> {
        TYPES[TYPE].schema_name.into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let Type { owner, doc, .. } = TYPES[TYPE];
        light_schema(owner, doc, generator)
    }
}

impl JsonSchema for Light {
    fn schema_name() -> Cow<'static, str> {
        "Light".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let shapes = [
            generator.subschema_for::<LightTypeSchema<0>>(),
            generator.subschema_for::<LightTypeSchema<1>>(),
            generator.subschema_for::<LightTypeSchema<2>>(),
            generator.subschema_for::<LightTypeSchema<3>>(),
        ];
        schemars::json_schema!({"description": "One light. The field `type` says which.", "anyOf": shapes})
    }
}
