//! The generated documents are those of the types. Run with `BENDYLIGHTS_BLESS=1` to write them anew.

use std::path::Path;

use protocol::{Face, json_schema, openapi};
use serde_json::Value;

fn agrees(name: &str, value: &Value) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("generated").join(name);
    let text = format!("{value:#}\n");
    if std::env::var_os("BENDYLIGHTS_BLESS").is_some() {
        std::fs::write(&path, &text).expect("written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == text, "{name} is not what the types say: run this test with BENDYLIGHTS_BLESS=1");
}

#[test]
fn schemas_are_those_of_the_types() {
    agrees("schema.json", &json_schema(Face::Read));
    agrees("schema-written.json", &json_schema(Face::Written));
    agrees("openapi.json", &openapi());
}

/// Every reference of `value`.
fn references<'a>(value: &'a Value, found: &mut Vec<&'a str>) {
    match value {
        Value::Object(fields) => {
            found.extend(fields.get("$ref").and_then(Value::as_str));
            fields.values().for_each(|value| references(value, found));
        }
        Value::Array(items) => items.iter().for_each(|value| references(value, found)),
        _ => {}
    }
}

#[test]
fn every_reference_leads_somewhere() {
    let dangling = |document: &Value| {
        let mut found = Vec::new();
        references(document, &mut found);
        assert!(found.len() > 20, "there are references");
        found.iter().any(|reference| document.pointer(reference.trim_start_matches('#')).is_none())
    };
    for mut document in [json_schema(Face::Read), json_schema(Face::Written), openapi()] {
        assert!(!dangling(&document));
        document["planted"] = serde_json::json!({"$ref": "#/$defs/Nothing"});
        assert!(dangling(&document), "a planted dangling reference is caught");
    }
}
