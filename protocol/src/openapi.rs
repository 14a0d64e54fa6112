//! OpenAPI 3.1 of the HTTP interface (SPEC, section 9).

use std::collections::{BTreeMap, BTreeSet};

use scene::{Aov, View};
use schemars::SchemaGenerator;
use serde_json::{Map, Value, json};

use crate::ErrorCode as Code;
use crate::drag_file::{Dragged, FileDrag};
use crate::schema::{SchemaSide, definitions, generator, name};
use crate::{
    Aovs, Asset, DemoScenes, Document, Duplicate, EditResults, Edits, ErrorBody, NewSession, PROTOCOL,
    ParameterTable, Pick, Picked, ProbeRequest, Probed, Record, RenderLimits, RenderRequest, SceneNodes,
    SessionChange, SessionEntry, SessionList, SessionState,
};

/// JSON pointer of the schemas in the OpenAPI document.
const SCHEMAS: &str = "#/components/schemas";

/// Error codes of every request: it is refused if it has another host name or comes from another origin.
const ANONYMOUS_CODES: &[Code] = &[Code::ForeignHost, Code::ForeignOrigin];
/// Error codes of every request that needs the token. Such a request must also arrive completely and keep the server's
/// limits.
const TOKEN_CODES: &[Code] = &[
    Code::Unauthorized,
    Code::BadMessage,
    Code::Stalled,
    Code::TooLarge,
    Code::TooMany,
    Code::Busy,
    Code::Draining,
    Code::Fault,
];
/// Error codes of requests that read from the store.
const STORE_CODES: &[Code] = &[Code::Storage];
/// Error codes of requests that open a session, which replays its log and loads its scenes.
const SESSION_CODES: &[Code] =
    &[Code::NotFound, Code::Storage, Code::BadLog, Code::UnknownAsset, Code::BadScene, Code::DamagedAsset];
/// Error codes of requests with a JSON body.
const JSON_CODES: &[Code] = &[Code::UnsupportedMediaType];
/// Error codes of the request that creates a session and loads a scene into it.
const NEW_SESSION_CODES: &[Code] = &[
    Code::BadName,
    Code::Exists,
    Code::UnknownAsset,
    Code::BadScene,
    Code::DamagedAsset,
    Code::InvalidLight,
    Code::InvalidCamera,
    Code::Storage,
    Code::UnknownOutcome,
];
/// Error codes of requests that change the list of sessions.
const LIST_CODES: &[Code] = &[Code::NotFound, Code::Storage, Code::UnknownOutcome];
/// Error codes of requests that render a picture.
const PICTURE_CODES: &[Code] = &[Code::Render];
/// Error codes of requests that set parameters.
const SET_CODES: &[Code] = &[Code::WrongKind, Code::Source, Code::InvalidLight];
/// Error codes of the request that uploads a scene's file.
const UPLOAD_CODES: &[Code] = &[Code::BadName, Code::BadScene, Code::Storage];
/// Error codes of a server that is not ready.
const READINESS_CODES: &[Code] = &[Code::WarmingUp, Code::NotReady, Code::Draining];

#[derive(Clone)]
struct Operation {
    path: &'static str,
    method: &'static str,
    id: &'static str,
    tag: &'static str,
    summary: &'static str,
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
    /// Error codes of refusals, in groups.
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
    let operations = of_session_list(&mut generator)
        .into_iter()
        .chain(of_sessions(&mut generator))
        .chain(of_pictures(&mut generator))
        .chain(of_scenes(&mut generator))
        .chain(of_service(&mut generator));
    for operation in operations {
        let (path, method) = (operation.path, operation.method);
        paths.entry(path).or_default().insert(method.into(), operation.into_json(&problem));
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

/// Returns the common part of every operation on one session.
fn of_session() -> Operation {
    let session = json!({"name": "session", "in": "path", "required": true, "schema": {"type": "string"},
        "description": "Name of the session."});
    Operation { parameters: vec![session], tag: "sessions", ..Operation::default() }
}

/// Returns the operations on the list of sessions and on whole sessions.
fn of_session_list(g: &mut SchemaGenerator) -> Vec<Operation> {
    let entry = json_content(&name::<SessionEntry>(g));
    let of_session = of_session();
    let of_all = Operation { tag: "sessions", ..Operation::default() };
    let archived =
        query("archived", "Those that are archived too.", &json!({"type": "boolean", "default": false}));
    let named = query("name", "This one alone, where there is one of that name.", &json!({"type": "string"}));
    vec![
        Operation {
            path: "/sessions",
            id: "listSessions",
            summary: "List the sessions.",
            answer: json_content(&name::<SessionList>(g)),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, STORE_CODES],
            ..of_all.clone().with(vec![archived, named])
        },
        Operation {
            path: "/sessions",
            method: "post",
            id: "createSession",
            summary: "Make a session, with its scene or, on an error, not at all.",
            body: Some(json_content(&name::<NewSession>(g))),
            status: 201,
            answer: json_content(&name::<SessionState>(g)),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, JSON_CODES, NEW_SESSION_CODES],
            ..of_all
        },
        Operation {
            path: "/sessions/{session}",
            method: "patch",
            id: "changeSession",
            summary: "Say what people call a session, archive it, or bring it back.",
            body: Some(json_content(&name::<SessionChange>(g))),
            answer: entry.clone(),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, JSON_CODES, LIST_CODES, &[Code::BadName]],
            ..of_session.clone()
        },
        Operation {
            path: "/sessions/{session}",
            method: "delete",
            id: "deleteSession",
            summary: "Delete an archived session, with its log, for good.",
            status: 204,
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, LIST_CODES, &[Code::NotArchived, Code::InUse]],
            ..of_session.clone()
        },
        Operation {
            path: "/sessions/{session}/duplicate",
            method: "post",
            id: "duplicateSession",
            summary: "Make a session with all of this one's log.",
            body: Some(json_content(&name::<Duplicate>(g))),
            status: 201,
            answer: entry,
            codes: &[
                ANONYMOUS_CODES,
                TOKEN_CODES,
                JSON_CODES,
                LIST_CODES,
                &[Code::BadName, Code::Exists, Code::BadLog],
            ],
            ..of_session
        },
    ]
}

fn of_sessions(g: &mut SchemaGenerator) -> Vec<Operation> {
    let state = json_content(&name::<SessionState>(g));
    let of_session = of_session();
    vec![
        Operation {
            path: "/sessions/{session}",
            id: "getSession",
            summary: "The session's document, sequence and hash.",
            answer: state,
            has_tag: true,
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, SESSION_CODES],
            ..of_session.clone()
        },
        Operation {
            path: "/sessions/{session}/nodes",
            id: "getNodes",
            summary: "Paths of the nodes of the session's scene under which something is drawn, for links.",
            answer: json_content(&name::<SceneNodes>(g)),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, SESSION_CODES],
            ..of_session.clone()
        },
        Operation {
            path: "/sessions/{session}/edits",
            method: "post",
            id: "editSession",
            summary: "Carry out edits, undos and redos, in order. What is refused of them stands in the results.",
            body: Some(json_content(&name::<Edits>(g))),
            answer: json_content(&name::<EditResults>(g)),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, JSON_CODES, SESSION_CODES],
            ..of_session.clone()
        },
        Operation {
            path: "/sessions/{session}/log",
            id: "getLog",
            summary: "Records in JSON, a line each, as `Record` describes them.",
            answer: text("application/jsonl"),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, STORE_CODES, &[Code::NotFound]],
            ..of_session.clone().with(log_parameters())
        },
    ]
}

/// Returns the operations that use a session's pictures without an edit.
fn of_pictures(g: &mut SchemaGenerator) -> Vec<Operation> {
    let of_session = of_session();
    vec![
        Operation {
            path: "/sessions/{session}/pick",
            method: "post",
            id: "pickPoint",
            summary: "The point of the scene that a camera has in the middle of its picture.",
            body: Some(json_content(&name::<Pick>(g))),
            answer: json_content(&name::<Picked>(g)),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, JSON_CODES, SESSION_CODES, &[Code::InvalidCamera]],
            ..of_session.clone()
        },
        Operation {
            path: "/sessions/{session}/drags",
            method: "post",
            id: "dragFeatures",
            summary: "Where drags of shadows, hotspots, highlights and diffuse light would lead, each from the document as it is.",
            body: Some(json_content(&list_of(&name::<FileDrag>(g)))),
            answer: json_content(&list_of(&name::<Dragged>(g))),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, JSON_CODES, SESSION_CODES, &[Code::Drag, Code::Ambiguous]],
            ..of_session.clone()
        },
        Operation {
            path: "/sessions/{session}/probe",
            method: "post",
            id: "probePixel",
            summary: "Why a pixel is lit or not: what is seen there, and what every light of the document does there.",
            body: Some(json_content(&name::<ProbeRequest>(g))),
            answer: json_content(&name::<Probed>(g)),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES, JSON_CODES, SESSION_CODES, &[Code::InvalidCamera]],
            ..of_session.clone()
        },
        Operation {
            path: "/sessions/{session}/render",
            id: "renderPicture",
            summary: "A picture of the document.",
            answer: json!({"image/png": {"schema": binary()}, "image/x-exr": {"schema": binary()}, "application/zip": {"schema": binary()}}),
            headers: json!({"x-bendylights-note": {
                "description": "What the picture lacks of its scene, and why a light is left out; one each.",
                "schema": {"type": "string"},
            }}),
            has_tag: true,
            codes: &[
                ANONYMOUS_CODES,
                TOKEN_CODES,
                SESSION_CODES,
                PICTURE_CODES,
                SET_CODES,
                &[Code::InvalidCamera, Code::Ambiguous],
            ],
            ..of_session.with(picture_parameters())
        },
    ]
}

fn of_scenes(g: &mut SchemaGenerator) -> Vec<Operation> {
    let name_of_scene = query(
        "name",
        "What people call the scene; by default what its file calls it.",
        &json!({"type": "string", "minLength": 1}),
    );
    let upload = Operation {
        path: "/assets",
        method: "post",
        id: "addAsset",
        tag: "scenes",
        summary: "Make a scene known, for `loadScene`: the bytes of a .glb or self-contained .gltf file, whatever the \
            `Content-Type` says.",
        body: Some(json!({"application/octet-stream": {"schema": binary()}})),
        status: 201,
        answer: json_content(&name::<Asset>(g)),
        codes: &[ANONYMOUS_CODES, TOKEN_CODES, UPLOAD_CODES],
        ..Operation::default()
    };
    let listed = Operation {
        path: "/scenes",
        id: "listScenes",
        tag: "scenes",
        summary: "The scenes that come with the server, as `createSession` and `loadScene` take them.",
        answer: json_content(&name::<DemoScenes>(g)),
        has_tag: true,
        codes: &[ANONYMOUS_CODES, TOKEN_CODES],
        ..Operation::default()
    };
    vec![upload.with(vec![name_of_scene]), listed]
}

fn of_service(g: &mut SchemaGenerator) -> Vec<Operation> {
    let open = Operation { tag: "service", codes: &[ANONYMOUS_CODES], ..Operation::default() };
    vec![
        Operation {
            path: "/parameters",
            id: "getParameters",
            summary: "All that can be set on lights, control points and cameras: a row each.",
            answer: json_content(&name::<ParameterTable>(g)),
            has_tag: true,
            codes: &[ANONYMOUS_CODES, TOKEN_CODES],
            ..open.clone()
        },
        Operation {
            path: "/metrics",
            id: "getMetrics",
            summary: "Counts, in Prometheus' text format.",
            answer: text("application/openmetrics-text"),
            codes: &[ANONYMOUS_CODES, TOKEN_CODES],
            ..open.clone()
        },
        Operation {
            path: "/healthz",
            id: "getHealth",
            summary: "Whether the process runs.",
            answer: text("text/plain"),
            ..open.clone()
        },
        Operation {
            path: "/readyz",
            id: "getReadiness",
            summary: "Whether every pipeline has drawn once; 503 before and while draining.",
            answer: text("text/plain"),
            codes: &[ANONYMOUS_CODES, READINESS_CODES],
            ..open.clone()
        },
        Operation {
            path: "/openapi.json",
            id: "getOpenapi",
            summary: "This document.",
            answer: json_content(&json!({})),
            has_tag: true,
            ..open
        },
    ]
}

impl Default for Operation {
    /// Returns a GET without refusals.
    fn default() -> Self {
        Self {
            path: "",
            method: "get",
            id: "",
            tag: "",
            summary: "",
            parameters: Vec::new(),
            body: None,
            status: 200,
            answer: Value::Null,
            headers: Value::Null,
            has_tag: false,
            codes: &[],
        }
    }
}

impl Operation {
    /// Adds parameters.
    fn with(mut self, parameters: Vec<Value>) -> Self {
        self.parameters.extend(parameters);
        self
    }

    fn into_json(self, problem: &Value) -> Value {
        let codes: BTreeSet<Code> = self.codes.iter().copied().flatten().copied().collect();
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
            "tags": [self.tag],
            "summary": self.summary,
            "responses": responses,
        });
        if !codes.contains(&Code::Unauthorized) {
            json["security"] = json!([]);
        }
        if !self.parameters.is_empty() {
            json["parameters"] = self.parameters.into();
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
