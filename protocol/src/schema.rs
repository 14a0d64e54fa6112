//! JSON Schema of the wire types.

use schemars::generate::{Contract, SchemaGenerator, SchemaSettings};
use serde_json::{Map, Value, json};

use crate::variants::name_variants;
use crate::{
    ClientMessage, DemoScenes, LogHeader, PROTOCOL, ParameterTable, Record, SceneNodes, ServerMessage, SessionList,
    TraceLine,
};

/// Side that a schema is for: input to the server, or output from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchemaSide {
    /// Input that the server accepts. Fields with defaults are optional.
    Read,
    /// Output that the server writes. Every field is required, except those whose absence has a meaning.
    Written,
}

/// Returns the JSON Schema (draft 2020-12) of every message, log line and table of the protocol, under `$defs`.
pub fn json_schema(side: SchemaSide) -> Value {
    let mut generator = generator(side, "/$defs");
    let any_of = [
        name::<ClientMessage>(&mut generator),
        name::<ServerMessage>(&mut generator),
        name::<LogHeader>(&mut generator),
        name::<Record>(&mut generator),
        name::<crate::CheckpointLine>(&mut generator),
        name::<ParameterTable>(&mut generator),
        name::<SceneNodes>(&mut generator),
        name::<SessionList>(&mut generator),
        name::<DemoScenes>(&mut generator),
        name::<TraceLine>(&mut generator),
    ];
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("BendyLights protocol {PROTOCOL}"),
        "description": "Messages of the socket, lines of a log file, the table of parameters, the nodes of a scene, lists of sessions and of scenes, and lines of a trace; SPEC.md says what they mean.",
        "anyOf": any_of,
        "$defs": definitions(generator, "#/$defs"),
    })
}

/// Takes the definitions out of `generator`. Every variant of a union becomes a named definition. `pointer` is
/// the JSON pointer under which the caller puts them.
pub(crate) fn definitions(mut generator: SchemaGenerator, pointer: &str) -> Map<String, Value> {
    let mut definitions = generator.take_definitions(true);
    definitions.values_mut().for_each(simplify);
    name_variants(&mut definitions, pointer);
    definitions
}

pub(crate) fn generator(side: SchemaSide, definitions: &'static str) -> SchemaGenerator {
    let contract = match side {
        SchemaSide::Read => Contract::Deserialize,
        SchemaSide::Written => Contract::Serialize,
    };
    let configure = |settings: &mut SchemaSettings| {
        settings.definitions_path = definitions.into();
        settings.contract = contract;
    };
    SchemaSettings::draft2020_12().with(configure).into_generator()
}

/// Returns a reference to `T`, and makes the generator define it.
pub(crate) fn name<T: schemars::JsonSchema>(generator: &mut SchemaGenerator) -> Value {
    generator.subschema_for::<T>().to_value()
}

/// Removes traces of Rust from a schema.
///
/// Choices among strings become one `enum` or `const`. Defaults of null go: they only say that a field is
/// optional, and are wrong if its type has no null. Descriptions lose the brackets of links.
fn simplify(schema: &mut Value) {
    match schema {
        Value::Object(fields) => {
            fields.values_mut().for_each(simplify);
            if fields.get("default").is_some_and(Value::is_null) {
                fields.remove("default");
            }
            if let Some(Value::String(description)) = fields.get_mut("description") {
                *description = description.replace("[`", "`").replace("`]", "`");
            }
            plain_choice(fields);
        }
        Value::Array(items) => items.iter_mut().for_each(simplify),
        _ => {}
    }
}

/// Turns a choice among strings, each with a description, into one `enum` or one `const`.
fn plain_choice(fields: &mut Map<String, Value>) {
    let Some(options) = fields.get("oneOf").and_then(Value::as_array) else { return };
    let names: Option<Vec<Value>> = options.iter().map(|option| option.get("const").cloned()).collect();
    let Some(names) = names.filter(|names| names.iter().all(Value::is_string)) else { return };
    let described = described(fields, options);
    fields.remove("oneOf");
    fields.insert("type".into(), "string".into());
    if let [only] = &names[..] {
        fields.insert("const".into(), only.clone());
        fields.insert("default".into(), only.clone());
    } else {
        fields.insert("enum".into(), names.into());
        fields.insert("description".into(), described.into());
    }
}

/// Returns the description of a choice, followed by a list of the descriptions of its options.
fn described(choice: &Map<String, Value>, options: &[Value]) -> String {
    let whole = choice.get("description").and_then(Value::as_str).unwrap_or_default();
    let lines = options.iter().filter_map(|option| {
        let meaning = option["description"].as_str()?.replace('\n', " ");
        Some(format!("\n- `{}`: {meaning}", option["const"].as_str()?))
    });
    let lines: String = lines.collect();
    if lines.is_empty() { whole.into() } else { format!("{whole}\n{lines}") }
}
