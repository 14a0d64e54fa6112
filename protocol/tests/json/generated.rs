//! Tests that the generated documents match the types. With `BENDYLIGHTS_BLESS=1` they write the documents
//! anew.

use std::collections::BTreeSet;

use protocol::{ErrorCode, SchemaSide, json_schema, openapi};
use serde_json::Value;

use crate::assert_committed;

#[test]
fn schemas_are_those_of_the_types() {
    for (name, value) in [
        ("schema.json", json_schema(SchemaSide::Read)),
        ("schema-written.json", json_schema(SchemaSide::Written)),
        ("openapi.json", openapi()),
    ] {
        assert_committed(&format!("generated/{name}"), &format!("{value:#}\n"));
    }
}

/// Collects every reference in `value`.
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
    for mut document in [json_schema(SchemaSide::Read), json_schema(SchemaSide::Written), openapi()] {
        assert!(!dangling(&document));
        document["planted"] = serde_json::json!({"$ref": "#/$defs/Nothing"});
        assert!(dangling(&document), "a planted dangling reference is caught");
    }
}

/// Returns the names of definitions that choose among objects without names.
fn unnamed_variants(definitions: &Value) -> Vec<&str> {
    let is_object = |variant: &&Value| variant.get("properties").is_some();
    let definitions = definitions.as_object().expect("definitions").iter();
    let unnamed = definitions.filter(|(_, definition)| {
        let variants = ["oneOf", "anyOf"].iter().filter_map(|choice| definition.get(*choice)?.as_array());
        variants.flatten().any(|variant| is_object(&variant))
    });
    unnamed.map(|(name, _)| name.as_str()).collect()
}

/// Code generated from the schemas then has classes `SetPoint` and `AddLight`, not `CommandType5` and
/// `CommandType1`.
#[test]
fn every_variant_of_a_union_has_a_name() {
    for (mut document, place) in [
        (json_schema(SchemaSide::Read), "/$defs"),
        (json_schema(SchemaSide::Written), "/$defs"),
        (openapi(), "/components/schemas"),
    ] {
        let definitions = document.pointer_mut(place).expect("definitions");
        assert_eq!(unnamed_variants(definitions), Vec::<&str>::new());
        let union = definitions["Command"]["oneOf"].as_array().expect("variants").clone();
        assert!(union.iter().any(|variant| variant["$ref"].as_str() == Some(&format!("#{place}/SetPoint"))));
        assert_eq!(definitions["SetPoint"]["properties"]["type"]["const"], "setPoint");
        definitions["Command"]["oneOf"][0] = definitions["SetPoint"].clone();
        assert_eq!(unnamed_variants(definitions), ["Command"], "a planted variant without a name is caught");
    }
}

/// Returns every operation of the HTTP interface.
fn operations(document: &Value) -> impl Iterator<Item = &Value> {
    let paths = document["paths"].as_object().expect("paths").values();
    paths.flat_map(|path| path.as_object().expect("operations").values())
}

#[test]
fn operations_have_names_and_say_why_they_can_be_refused() {
    let document = openapi();
    let names: Vec<&str> = operations(&document).filter_map(|o| o["operationId"].as_str()).collect();
    let distinct: BTreeSet<&str> = names.iter().copied().collect();
    assert_eq!((distinct.len(), names.len()), (names.len(), operations(&document).count()));
    for operation in operations(&document) {
        for (status, response) in operation["responses"].as_object().expect("responses") {
            let schema = &response["content"]["application/json"]["schema"];
            let codes = schema.pointer("/properties/error/properties/code/enum").and_then(Value::as_array);
            let codes: Vec<_> = codes.into_iter().flatten().filter_map(Value::as_str).collect();
            let statuses = codes.iter().map(|code| ErrorCode::named(code).expect("a code").http_status());
            assert!(statuses.clone().all(|of_code| of_code.to_string() == *status), "{status}: {codes:?}");
            let is_refused = !status.starts_with('2') && status != "304";
            assert_eq!(statuses.len() > 0, is_refused, "{status}: {codes:?}");
        }
    }
}
