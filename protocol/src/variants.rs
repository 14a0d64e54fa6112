//! Names for the variants of unions, so that code generated from a schema has them too.

use serde_json::{Map, Value, json};

/// Prefix and suffix of the name of each variant, per union.
const UNIONS: &[(&str, [&str; 2])] = &[
    ("Action", ["", "Action"]),
    ("CameraParameter", ["Camera", ""]),
    ("Change", ["", "Change"]),
    ("ClientMessage", ["Client", ""]),
    ("Command", ["", ""]),
    ("Light", ["", ""]),
    ("LightParameter", ["Light", ""]),
    ("ParameterKind", ["", "Kind"]),
    ("ParameterNeeded", ["Needed", ""]),
    ("PointParameter", ["Point", ""]),
    ("ProbeCamera", ["Probe", "Camera"]),
    ("Projection", ["", "Projection"]),
    ("ServerMessage", ["Server", ""]),
    ("State", ["", "State"]),
    ("TraceWhat", ["Traced", ""]),
    ("ViewSource", ["", "View"]),
];

/// Gives each variant of each union a definition, and each union that `type` discriminates a discriminator.
/// `pointer` is the JSON pointer of the definitions.
pub fn name_variants(definitions: &mut Map<String, Value>, pointer: &str) {
    for (union, affixes) in UNIONS {
        let Some(mut definition) = definitions.remove(*union) else { continue };
        let Some(variants) = variants_of(&mut definition) else { continue };
        let (mut named, mut mapping) = (Vec::new(), Map::new());
        for variant in variants {
            let reference = match variant.get("$ref").filter(|_| tag(&variant).is_none()) {
                Some(reference) => reference.clone(),
                None => define(definitions, variant, *affixes, pointer),
            };
            let name = reference.as_str().and_then(|text| text.rsplit('/').next()).unwrap_or_default();
            if let Some(tag) = definitions.get(name).and_then(tag) {
                mapping.insert(tag.to_owned(), reference.clone());
            }
            named.push(json!({"$ref": reference}));
        }
        if mapping.len() == named.len() {
            definition["discriminator"] = json!({"propertyName": "type", "mapping": mapping});
        }
        definition["oneOf"] = named.into();
        let before = definitions.insert((*union).into(), definition);
        assert!(before.is_none(), "{union} is the name of a variant too");
    }
}

/// Removes the variants from the definition of a union, and returns them.
fn variants_of(definition: &mut Value) -> Option<Vec<Value>> {
    let fields = definition.as_object_mut()?;
    match fields.remove("oneOf").or_else(|| fields.remove("anyOf"))? {
        Value::Array(variants) => Some(variants),
        _ => None,
    }
}

/// Defines a variant, and the object in its one field if the variant has no tag. Returns a reference to the
/// variant.
fn define(
    definitions: &mut Map<String, Value>,
    mut variant: Value,
    [before, after]: [&str; 2],
    pointer: &str,
) -> Value {
    let mut define = |name: &str, definition: Value| {
        let clash = definitions.insert(name.to_owned(), definition);
        assert!(clash.is_none(), "two definitions are called {name}");
        json!(format!("{pointer}/{name}"))
    };
    let own = if let Some(tag) = tag(&variant) {
        pascal_case(tag)
    } else {
        let only = variant["properties"].as_object_mut().and_then(|fields| fields.iter_mut().next());
        let (field, value) = only.expect("a variant without a tag has a field");
        let own = pascal_case(field);
        if value["type"] == "object" {
            *value = json!({"$ref": define(&own, value.take())});
        }
        own
    };
    // With a default, code that constructs a generated class need not repeat the tag.
    if let Some(kind) = variant.pointer_mut("/properties/type") {
        kind["default"] = kind["const"].clone();
    }
    define(&format!("{before}{own}{after}"), variant)
}

/// Returns the value of `type` that identifies a variant.
fn tag(definition: &Value) -> Option<&str> {
    definition.pointer("/properties/type/const")?.as_str()
}

fn pascal_case(camel_case: &str) -> String {
    let mut letters = camel_case.chars();
    letters.next().map(|first| first.to_ascii_uppercase()).into_iter().chain(letters).collect()
}
