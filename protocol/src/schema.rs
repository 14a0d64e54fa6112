//! JSON Schema and OpenAPI, made from the wire types themselves.

use std::slice;

use scene::Aov;
use schemars::generate::{Contract, SchemaGenerator, SchemaSettings};
use serde_json::{Value, json};

use crate::{
    Asset, ClientMessage, Document, EditResults, Edits, ErrorBody, LogHeader, NewSession, PROTOCOL, Record,
    ServerMessage, SessionList, SessionState,
};

/// Which of a type's two faces a schema describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// What is understood: fields with defaults may be left out.
    Read,
    /// What is written: every field is there, but for those that say something by their absence.
    Written,
}

/// JSON Schema (draft 2020-12) of every shape of the protocol, under `$defs`.
pub fn json_schema(face: Face) -> Value {
    let mut generator = generator(face, "/$defs");
    let messages = [name::<ClientMessage>(&mut generator), name::<ServerMessage>(&mut generator)];
    let lines = [
        name::<LogHeader>(&mut generator),
        name::<Record>(&mut generator),
        name::<crate::CheckpointLine>(&mut generator),
    ];
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("BendyLights protocol {PROTOCOL}"),
        "description": "Messages of the socket and lines of a log file; SPEC.md says what they mean.",
        "anyOf": messages.into_iter().chain(lines).collect::<Vec<_>>(),
        "$defs": generator.take_definitions(true),
    })
}

fn generator(face: Face, definitions: &'static str) -> SchemaGenerator {
    let contract = match face {
        Face::Read => Contract::Deserialize,
        Face::Written => Contract::Serialize,
    };
    let place = |settings: &mut SchemaSettings| {
        settings.definitions_path = definitions.into();
        settings.contract = contract;
    };
    SchemaSettings::draft2020_12().with(place).into_generator()
}

/// A reference to `T`, which the generator then defines.
fn name<T: schemars::JsonSchema>(generator: &mut SchemaGenerator) -> Value {
    generator.subschema_for::<T>().to_value()
}

/// OpenAPI 3.1 of the HTTP interface (SPEC, section 9).
pub fn openapi() -> Value {
    let mut generator = generator(Face::Read, "/components/schemas");
    let g = &mut generator;
    let problem = name::<ErrorBody>(g);
    let state = name::<SessionState>(g);
    let session = json!({"name": "session", "in": "path", "required": true, "schema": {"type": "string"},
        "description": "Name of the session."});
    // Light documents and records stand in the log and in session states; the socket's messages are in schema.json.
    name::<Document>(g);
    let paths = json!({
        "/sessions": {
            "get": operation("List the sessions.", &[], None, 200, &json_content(&name::<SessionList>(g)), &problem),
            "post": operation("Make a session.", &[], Some(json_content(&name::<NewSession>(g))), 201,
                &json_content(&state), &problem),
        },
        "/sessions/{session}": {
            "get": operation("The session's document, sequence and hash.", slice::from_ref(&session), None, 200,
                &json_content(&state), &problem),
        },
        "/sessions/{session}/edits": {
            "post": operation("Carry out edits, undos and redos, in order.", slice::from_ref(&session),
                Some(json_content(&name::<Edits>(g))), 200, &json_content(&name::<EditResults>(g)), &problem),
        },
        "/sessions/{session}/log": {
            "get": operation("Records, a line each.", &[session.clone(),
                query("from", "First record.", &json!({"type": "integer", "minimum": 1, "default": 1})),
                query("limit", "Records at most.", &json!({"type": "integer", "minimum": 1, "maximum": 10_000, "default": 10_000})),
            ], None, 200, &json!({"application/jsonl": {"schema": name::<Record>(g)}}), &problem),
        },
        "/sessions/{session}/render": {
            "get": operation("A picture of the document.", &[session,
                query("camera", "Id or name of a camera; the first by default.", &json!({"type": "string"})),
                query("size", "Width and height in pixels; by default 640x360, or about as many pixels in the camera's own shape.",
                    &json!({"type": "string", "pattern": "^[0-9]+x[0-9]+$"})),
                query("aov", "What the picture shows.", &json!({"enum": Aov::NAMES, "default": "beauty"})),
                query("samples", "Samples a pixel.", &json!({"type": "integer", "minimum": 1, "maximum": 64, "default": 1})),
                query("light", "Id or name of the light that t, vw, direction, visibility and wireframe are of; the first by default.", &json!({"type": "string"})),
                query("at", "The document as it was after this record; the latest by default.", &json!({"type": "integer", "minimum": 0})),
                query("format", "PNG for people, EXR for linear values.", &json!({"enum": ["png", "exr"], "default": "png"})),
            ], None, 200, &json!({"image/png": {}, "image/x-exr": {}}), &problem),
        },
        "/assets": {
            "post": operation("Make a scene known, for `loadScene`.", &[],
                Some(json!({"model/gltf-binary": {}, "model/gltf+json": {}, "application/octet-stream": {}})), 201,
                &json_content(&name::<Asset>(g)), &problem),
        },
        "/healthz": {"get": operation("Whether the process runs.", &[], None, 200, &text(), &problem)},
        "/readyz": {"get": operation("Whether every pipeline has drawn once; 503 before and while draining.", &[], None, 200, &text(), &problem)},
        "/metrics": {"get": operation("Counts, in Prometheus' text format.", &[], None, 200, &text(), &problem)},
        "/openapi.json": {"get": operation("This document.", &[], None, 200, &json!({"application/json": {}}), &problem)},
    });
    json!({
        "openapi": "3.1.0",
        "info": {"title": "BendyLights", "version": env!("CARGO_PKG_VERSION"),
            "description": "Edit and render lighting sessions. SPEC.md has the rules."},
        "security": [{"token": []}],
        "paths": paths,
        "components": {
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer",
                "description": "The part after `#token=` of the address that the server prints."}},
            "schemas": generator.take_definitions(true),
        },
    })
}

fn json_content(schema: &Value) -> Value {
    json!({"application/json": {"schema": schema}})
}

fn text() -> Value {
    json!({"text/plain": {"schema": {"type": "string"}}})
}

fn query(name: &str, description: &str, schema: &Value) -> Value {
    json!({"name": name, "in": "query", "description": description, "schema": schema})
}

fn operation(
    summary: &str,
    parameters: &[Value],
    body: Option<Value>,
    status: u16,
    content: &Value,
    problem: &Value,
) -> Value {
    let mut operation = json!({
        "summary": summary,
        "responses": {
            status.to_string(): {"description": "Done.", "content": content},
            "default": {"description": "Refused; the message says what to do.",
                "content": {"application/json": {"schema": problem}}},
        },
    });
    if !parameters.is_empty() {
        operation["parameters"] = parameters.into();
    }
    if let Some(content) = body {
        operation["requestBody"] = json!({"required": true, "content": content});
    }
    operation
}
