//! OpenAPI 3.1 of the HTTP interface (SPEC, section 9).

use std::collections::{BTreeMap, BTreeSet};

use scene::{Aov, View};
use schemars::SchemaGenerator;
use serde_json::{Map, Value, json};

use crate::ErrorCode::{
    self as Code, Ambiguous, BadLog, BadMessage, BadName, BadScene, Busy, DamagedAsset, Drag, Draining, Exists, Fault,
    ForeignHost, ForeignOrigin, InUse, InvalidCamera, InvalidLight, NotArchived, NotFound, NotReady, Render, Source,
    Stalled, Storage, TooLarge, TooMany, Unauthorized, UnknownAsset, UnknownOutcome, UnsupportedMediaType, WarmingUp,
    WrongKind,
};
use crate::drag_file::{DragResult, FileDrag};
use crate::schema::{SchemaSide, definitions, generator, name};
use crate::{
    Aovs, Asset, DemoScenes, Document, Duplicate, EditResults, Edits, ErrorBody, NewSession, PROTOCOL, ParameterTable,
    Pick, Picked, ProbeRequest, Probed, Record, RenderLimits, RenderRequest, SceneNodes, SessionChange, SessionEntry,
    SessionList, SessionState,
};

/// JSON pointer of the schemas in the OpenAPI document.
const SCHEMAS: &str = "#/components/schemas";

/// Error codes of every request: it is refused if it has another host name or comes from another origin.
const ANONYMOUS_CODES: &[Code] = &[ForeignHost, ForeignOrigin];
/// Error codes of every request that needs the token. Such a request must also arrive completely and keep the server's
/// limits.
const TOKEN_CODES: &[Code] = &[Unauthorized, BadMessage, Stalled, TooLarge, TooMany, Busy, Draining, Fault];
/// Error codes of requests that read from the store.
const STORE_CODES: &[Code] = &[Storage];
/// Error codes of requests that open a session, which replays its log and loads its scenes.
const SESSION_CODES: &[Code] = &[NotFound, Storage, BadLog, UnknownAsset, BadScene, DamagedAsset];
/// Error codes of requests with a JSON body.
const JSON_CODES: &[Code] = &[UnsupportedMediaType];
/// Error codes of the request that creates a session and loads a scene into it.
const NEW_SESSION_CODES: &[Code] =
    &[BadName, Exists, UnknownAsset, BadScene, DamagedAsset, InvalidLight, InvalidCamera, Storage, UnknownOutcome];
/// Error codes of requests that change the list of sessions.
const LIST_CODES: &[Code] = &[NotFound, Storage, UnknownOutcome];
/// Error codes of requests that render a picture.
const PICTURE_CODES: &[Code] = &[Render];
/// Error codes of requests that set parameters.
const SET_CODES: &[Code] = &[WrongKind, Source, InvalidLight];
/// Error codes of the request that uploads a scene's file.
const UPLOAD_CODES: &[Code] = &[BadName, BadScene, Storage];
/// Error codes of a server that is not ready.
const READINESS_CODES: &[Code] = &[WarmingUp, NotReady, Draining];

struct Operation {
    path: &'static str,
    method: &'static str,
    id: &'static str,
    summary: &'static str,
    /// Parameters besides the name of the session in the path.
    parameters: Vec<Value>,
    /// Body of the request, by media type; `None` if it has no body.
    body: Option<Value>,
    /// HTTP status of a successful response.
    status: u16,
    /// Body of a successful response, by media type; null if it has no body.
    answer: Value,
    /// Headers of a successful response, by name; null if it has no special ones.
    headers: Value,
    /// True if responses have an `ETag`, and a request with a matching `If-None-Match` gets 304.
    has_tag: bool,
    /// True if the request needs the token.
    needs_token: bool,
    /// Error codes of refusals besides those of every request, in groups.
    codes: &'static [&'static [Code]],
}

/// Returns the document that a server sends at `/openapi.json`.
pub fn openapi() -> Value {
    let mut generator = generator(SchemaSide::Read, "/components/schemas");
    let problem = name::<ErrorBody>(&mut generator);
    // Records occur in the log as lines. The messages of the socket are in schema.json.
    name::<Document>(&mut generator);
    name::<Record>(&mut generator);
    let mut paths: BTreeMap<&str, Map<String, Value>> = BTreeMap::new();
    let of_sessions = [of_session_list, of_sessions, of_pictures].map(|list| ("sessions", list(&mut generator)));
    let others = [("scenes", of_scenes(&mut generator)), ("service", of_service(&mut generator))];
    for (tag, operations) in of_sessions.into_iter().chain(others) {
        for operation in operations {
            let (path, method) = (operation.path, operation.method);
            paths.entry(path).or_default().insert(method.into(), operation.into_json(tag, &problem));
        }
    }
    json!({
        "openapi": "3.1.0",
        "info": {"title": "BendyLights", "version": env!("CARGO_PKG_VERSION"),
            "description": format!("Edit and render lighting sessions; protocol {PROTOCOL}. SPEC.md has the rules.")},
        "security": [{"token": []}],
        "paths": paths,
        "components": {
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer",
                "description": "The part after `#token=` of the address that the server prints."}},
            "schemas": definitions(generator, SCHEMAS),
        },
    })
}

/// Returns a GET that needs the token and has no refusals of its own.
fn get(path: &'static str, id: &'static str, summary: &'static str) -> Operation {
    Operation {
        path,
        method: "get",
        id,
        summary,
        parameters: Vec::new(),
        body: None,
        status: 200,
        answer: Value::Null,
        headers: Value::Null,
        has_tag: false,
        needs_token: true,
        codes: &[],
    }
}

/// Returns a POST with a JSON body.
fn post(path: &'static str, id: &'static str, summary: &'static str, body: &Value) -> Operation {
    Operation { method: "post", body: Some(json_content(body)), ..get(path, id, summary) }
}

/// Returns the operations on the list of sessions and on whole sessions.
fn of_session_list(g: &mut SchemaGenerator) -> Vec<Operation> {
    let entry = json_content(&name::<SessionEntry>(g));
    let archived = query("archived", "Those that are archived too.", &json!({"type": "boolean", "default": false}));
    let named = query("name", "This one alone, where there is one of that name.", &json!({"type": "string"}));
    let make = "Make a session, with its scene or, on an error, not at all.";
    let change = "Say what people call a session, archive it, or bring it back.";
    let duplicate = "Make a session with all of this one's log.";
    vec![
        Operation {
            parameters: vec![archived, named],
            answer: json_content(&name::<SessionList>(g)),
            codes: &[STORE_CODES],
            ..get("/sessions", "listSessions", "List the sessions.")
        },
        Operation {
            status: 201,
            answer: json_content(&name::<SessionState>(g)),
            codes: &[JSON_CODES, NEW_SESSION_CODES],
            ..post("/sessions", "createSession", make, &name::<NewSession>(g))
        },
        Operation {
            method: "patch",
            answer: entry.clone(),
            codes: &[JSON_CODES, LIST_CODES, &[BadName]],
            ..post("/sessions/{session}", "changeSession", change, &name::<SessionChange>(g))
        },
        Operation {
            method: "delete",
            status: 204,
            codes: &[LIST_CODES, &[NotArchived, InUse]],
            ..get("/sessions/{session}", "deleteSession", "Delete an archived session, with its log, for good.")
        },
        Operation {
            status: 201,
            answer: entry,
            codes: &[JSON_CODES, LIST_CODES, &[BadName, Exists, BadLog]],
            ..post("/sessions/{session}/duplicate", "duplicateSession", duplicate, &name::<Duplicate>(g))
        },
    ]
}

fn of_sessions(g: &mut SchemaGenerator) -> Vec<Operation> {
    let nodes = "Paths of the nodes of the session's scene under which something is drawn, for links.";
    let edit = "Carry out edits, undos and redos, in order. What is refused of them stands in the results.";
    let log = "Records in JSON, a line each, as `Record` describes them.";
    vec![
        Operation {
            answer: json_content(&name::<SessionState>(g)),
            has_tag: true,
            codes: &[SESSION_CODES],
            ..get("/sessions/{session}", "getSession", "The session's document, sequence and hash.")
        },
        Operation {
            answer: json_content(&name::<SceneNodes>(g)),
            codes: &[SESSION_CODES],
            ..get("/sessions/{session}/nodes", "getNodes", nodes)
        },
        Operation {
            answer: json_content(&name::<EditResults>(g)),
            codes: &[JSON_CODES, SESSION_CODES],
            ..post("/sessions/{session}/edits", "editSession", edit, &name::<Edits>(g))
        },
        Operation {
            parameters: log_parameters(),
            answer: text("application/jsonl"),
            codes: &[STORE_CODES, &[NotFound]],
            ..get("/sessions/{session}/log", "getLog", log)
        },
    ]
}

/// Returns the operations that use a session's pictures without an edit.
fn of_pictures(g: &mut SchemaGenerator) -> Vec<Operation> {
    let pick = "The point of the scene that a camera has in the middle of its picture.";
    let drag =
        "Where drags of shadows, hotspots, highlights and diffuse light would lead, each from the document as it is.";
    let probe = "Why a pixel is lit or not: what is seen there, and what every light of the document does there.";
    let picture = json!({"schema": binary()});
    vec![
        Operation {
            answer: json_content(&name::<Picked>(g)),
            codes: &[JSON_CODES, SESSION_CODES, &[InvalidCamera]],
            ..post("/sessions/{session}/pick", "pickPoint", pick, &name::<Pick>(g))
        },
        Operation {
            answer: json_content(&list_of(&name::<DragResult>(g))),
            codes: &[JSON_CODES, SESSION_CODES, &[Drag, Ambiguous]],
            ..post("/sessions/{session}/drags", "dragFeatures", drag, &list_of(&name::<FileDrag>(g)))
        },
        Operation {
            answer: json_content(&name::<Probed>(g)),
            codes: &[JSON_CODES, SESSION_CODES, &[InvalidCamera]],
            ..post("/sessions/{session}/probe", "probePixel", probe, &name::<ProbeRequest>(g))
        },
        Operation {
            parameters: picture_parameters(),
            answer: json!({"image/png": picture, "image/x-exr": picture, "application/zip": picture}),
            headers: json!({"x-bendylights-note": {
                "description": "What the picture lacks of its scene, and why a light is left out; one each.",
                "schema": {"type": "string"},
            }}),
            has_tag: true,
            codes: &[SESSION_CODES, PICTURE_CODES, SET_CODES, &[InvalidCamera, Ambiguous]],
            ..get("/sessions/{session}/render", "renderPicture", "A picture of the document.")
        },
    ]
}

fn of_scenes(g: &mut SchemaGenerator) -> Vec<Operation> {
    let name_of_scene = query(
        "name",
        "What people call the scene; by default what its file calls it.",
        &json!({"type": "string", "minLength": 1}),
    );
    let upload = "Make a scene known, for `loadScene`: the bytes of a .glb or self-contained .gltf file, whatever the \
        `Content-Type` says.";
    let list = "The scenes that come with the server, as `createSession` and `loadScene` take them.";
    vec![
        Operation {
            method: "post",
            parameters: vec![name_of_scene],
            body: Some(json!({"application/octet-stream": {"schema": binary()}})),
            status: 201,
            answer: json_content(&name::<Asset>(g)),
            codes: &[UPLOAD_CODES],
            ..get("/assets", "addAsset", upload)
        },
        Operation { answer: json_content(&name::<DemoScenes>(g)), has_tag: true, ..get("/scenes", "listScenes", list) },
    ]
}

fn of_service(g: &mut SchemaGenerator) -> Vec<Operation> {
    let parameters = "All that can be set on lights, control points and cameras: a row each.";
    let readiness = "Whether every pipeline has drawn once; 503 before and while draining.";
    vec![
        Operation {
            answer: json_content(&name::<ParameterTable>(g)),
            has_tag: true,
            ..get("/parameters", "getParameters", parameters)
        },
        Operation {
            answer: text("application/openmetrics-text"),
            ..get("/metrics", "getMetrics", "Counts, in Prometheus' text format.")
        },
        Operation {
            answer: text("text/plain"),
            needs_token: false,
            ..get("/healthz", "getHealth", "Whether the process runs.")
        },
        Operation {
            answer: text("text/plain"),
            needs_token: false,
            codes: &[READINESS_CODES],
            ..get("/readyz", "getReadiness", readiness)
        },
        Operation {
            answer: json_content(&json!({})),
            has_tag: true,
            needs_token: false,
            ..get("/openapi.json", "getOpenapi", "This document.")
        },
    ]
}

impl Operation {
    fn into_json(self, tag: &str, problem: &Value) -> Value {
        let common = [ANONYMOUS_CODES, if self.needs_token { TOKEN_CODES } else { &[] }];
        let codes: BTreeSet<Code> = common.iter().chain(self.codes).copied().flatten().copied().collect();
        let mut by_status: BTreeMap<u16, Vec<Code>> = BTreeMap::new();
        for code in &codes {
            by_status.entry(code.http_status()).or_default().push(*code);
        }
        let mut responses = Map::new();
        let mut done = json!({"description": "Done."});
        if !self.answer.is_null() {
            done["content"] = self.answer;
        }
        if !self.headers.is_null() {
            done["headers"] = self.headers;
        }
        if self.has_tag {
            let tag = json!({"ETag": {"description": "For `If-None-Match`.", "schema": {"type": "string"}}});
            done["headers"] = tag.clone();
            let same = json!({"description": "The client has it, as `If-None-Match` says.", "headers": tag});
            responses.insert("304".into(), same);
        }
        responses.insert(self.status.to_string(), done);
        for (status, codes) in by_status {
            responses.insert(status.to_string(), refused(&codes, problem));
        }
        let mut json = json!({
            "operationId": self.id,
            "tags": [tag],
            "summary": self.summary,
            "responses": responses,
        });
        if !self.needs_token {
            json["security"] = json!([]);
        }
        let session = json!({"name": "session", "in": "path", "required": true, "schema": {"type": "string"},
            "description": "Name of the session."});
        let of_path = self.path.contains("{session}").then_some(session);
        let parameters: Vec<Value> = of_path.into_iter().chain(self.parameters).collect();
        if !parameters.is_empty() {
            json["parameters"] = parameters.into();
        }
        if let Some(content) = self.body {
            json["requestBody"] = json!({"required": true, "content": content});
        }
        json
    }
}

/// Returns the response of a refusal with one of `codes`.
fn refused(codes: &[Code], problem: &Value) -> Value {
    let named: Vec<String> = codes.iter().map(|code| format!("`{code}`")).collect();
    let mut schema = problem.clone();
    schema["properties"] = json!({"error": {"properties": {"code": {"enum": codes}}}});
    let mut refused = json!({
        "description": format!("Refused with {}.", named.join(" or ")),
        "content": json_content(&schema),
    });
    if codes.iter().any(|code| code.http_status() == 503) {
        let seconds = json!({"description": "Seconds to wait.", "schema": {"type": "integer"}});
        refused["headers"] = json!({"Retry-After": seconds});
    }
    refused
}

fn log_parameters() -> Vec<Value> {
    let limit = json!({"type": "integer", "minimum": 0, "maximum": 10_000, "default": 10_000});
    vec![
        query("from", "First record.", &json!({"type": "integer", "minimum": 0, "default": 1})),
        query("limit", "Records at most.", &limit),
    ]
}

fn picture_parameters() -> Vec<Value> {
    let RenderLimits { max_side, max_samples } = RenderLimits::HTTP;
    let RenderRequest { aovs, samples, fill, exposure, .. } = RenderRequest::default();
    let aov = format!("(?:{})", Aov::NAMES.join("|"));
    vec![
        query(
            "camera",
            "Id or name of a camera, or one of your own as JSON, as `Camera` describes it; the first by default.",
            &json!({"type": "string"}),
        ),
        query(
            "size",
            &format!(
                "Width and height in pixels, at most {max_side} each; by default 640x360, or about as many pixels in the \
                    camera's own shape."
            ),
            &json!({"type": "string", "pattern": "^0*[1-9][0-9]*x0*[1-9][0-9]*$"}),
        ),
        query(
            "aov",
            "What the picture shows: names with commas between, or `all`, those of a light then for each light.",
            &json!({"type": "string", "pattern": format!("^({}|{aov}(,{aov})*)$", Aovs::ALL), "default": aovs.names()}),
        ),
        query(
            "samples",
            "Samples a pixel.",
            &json!({"type": "integer", "minimum": 1, "maximum": max_samples, "default": samples}),
        ),
        query(
            "light",
            "Id or name of the light that t, vw, direction, visibility and wireframe are of; the first by default. Refused \
                where nothing is asked for that is of a light.",
            &json!({"type": "string"}),
        ),
        query(
            "lights",
            "Ids or names of the lights that shine, with commas between or as a JSON array; all by default.",
            &json!({"type": "string"}),
        ),
        json!({"name": "set", "in": "query",
            "description": "What is set for this picture alone, without an edit: addresses and values, as the command `set` takes them.",
            "content": {"application/json": {"schema": {"type": "object"}}}}),
        query(
            "background",
            "What a PNG has where nothing is seen.",
            &json!({"type": "string", "enum": ["black", "transparent"], "default": "black"}),
        ),
        query(
            "fill",
            "How much of the scene's fill the beauty has: 0 leaves the lights' own radiance.",
            &json!({"type": "number", "minimum": View::FILL_RANGE.start(), "maximum": View::FILL_RANGE.end(), "default": fill as u32}),
        ),
        query(
            "exposure",
            "Stops by which a PNG of the beauty is brightened, before it is tone-mapped; an EXR holds the radiance itself.",
            &json!({"type": "number", "minimum": View::EXPOSURE_RANGE.start(), "maximum": View::EXPOSURE_RANGE.end(), "default": exposure as u32}),
        ),
        query(
            "at",
            "The document as it was after this record; the latest by default.",
            &json!({"type": "integer", "minimum": 0}),
        ),
        query(
            "format",
            "PNG for people, a file for each AOV; EXR for linear values, all AOVs in one. More than one file comes as a ZIP.",
            &json!({"type": "string", "enum": ["png", "exr", "png,exr"], "default": "png"}),
        ),
    ]
}

fn query(name: &str, description: &str, schema: &Value) -> Value {
    json!({"name": name, "in": "query", "description": description, "schema": schema})
}

fn list_of(schema: &Value) -> Value {
    json!({"type": "array", "items": schema})
}

fn json_content(schema: &Value) -> Value {
    json!({"application/json": {"schema": schema}})
}

fn text(media_type: &str) -> Value {
    json!({media_type: {"schema": {"type": "string"}}})
}

fn binary() -> Value {
    json!({"type": "string", "format": "binary"})
}
