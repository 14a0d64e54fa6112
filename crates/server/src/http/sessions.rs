//! Sessions: create, read, edit. Pictures are in `render`, the list in `session_list`.

use axum::Extension;
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, Uri, header};
use axum::response::IntoResponse;
use document::{Command, Document};
use edit::{Actor, EditRequest, EditSources, Session};
use futures_util::stream::{iter, try_unfold};
use protocol::{Edit, Edits, NewSession, SceneNodes, SessionState, json_around_document};
use serde::Deserialize;
use store::{CommitBatch, Store};
use tokio::task::spawn_blocking;
use tokio_util::sync::CancellationToken;

use super::answer::{HandlerResult, created, json, json_text};
use super::constant::{not_modified, tag};
use super::read::{JsonBody, SessionName, read_query};
use crate::ServerError;
use crate::access::{Credential, Principal, random_digits};
use crate::charges::Payer;
use crate::connections::Connection;
use crate::error::check_size;
use crate::in_flight::ByteBudget;
use crate::limits::{
    LOG_PAGE_BYTES, MAX_EDITS, MAX_GROUP_EDITS, MAX_LOG_RECORDS, MAX_NODES_LISTED, MESSAGE_COST_EDITS,
};
use crate::request::{RecordAction, RecordRequest, RequestedEdit, actor, requested_edit, step};
use crate::room::{RoomMessage, in_group_error, time_ms};
use crate::scenes::{DecodedScene, SceneCache};
use crate::state::App;
use crate::storage::Storage;

/// Handles `POST /sessions`: creates a session.
pub async fn create(State(state): App, JsonBody(request): JsonBody<NewSession>) -> HandlerResult {
    let NewSession { name, title, scene, actor } = request;
    let actor = actor_or_program(actor)?;
    let mut session = Session::default();
    let (mut records, mut notes) = (Vec::new(), Vec::new());
    if let Some(scene) = scene {
        let command = protocol::Command::LoadScene { scene, name: None };
        let requested = requested_edit(command, None, &state.services.scenes).await?;
        let command = requested.command.of(&Document::default())?;
        let scene = match &command {
            Command::LoadScene { asset, .. } => state.services.scenes.load(*asset).await?,
            _ => DecodedScene::default(),
        };
        notes = scene.notes.to_vec();
        let sources = EditSources { context: scene.context(Some(&scene.contents), None), reverted: None };
        let load = EditRequest::Edit { base_seq: None, command };
        records.push(session.execute_request(load, &actor, &new_op_id()?, time_ms(), sources)?);
    }
    let hash = session.document().hash();
    let session_name = name.clone();
    let begin = move |store: &mut Store| {
        let first = CommitBatch { session: &session_name, records: &records, rejections: &[], hash };
        store.begin_session(&first, title.as_deref())
    };
    let epoch = state.services.storage.run_exclusive(begin).await?;
    let (seq, document) = (session.seq(), session.document().into());
    Ok(created(&SessionState { name, epoch, seq, hash: hash.to_string(), document, notes }))
}

/// Handles `GET /sessions/S`: the session's state with its document. All requests share the document's text.
pub async fn show(
    State(state): App,
    Extension(connection): Extension<Connection>,
    SessionName(name): SessionName,
    headers: HeaderMap,
) -> HandlerResult {
    let snapshot = state.rooms.snapshot(&name).await?;
    let hash = snapshot.document.hash().to_string();
    let tag = tag(&format!("{}.{}.{hash}", snapshot.epoch, snapshot.seq));
    if let Some(answer) = not_modified(&headers, &tag) {
        return Ok(answer);
    }
    state.services.in_flight.check()?;
    let state = SessionState {
        name: snapshot.name,
        epoch: snapshot.epoch,
        seq: snapshot.seq,
        hash,
        document: protocol::Document::default(),
        notes: snapshot.scene.notes.to_vec(),
    };
    let (before, after) = json_around_document(&state);
    let text = snapshot.text;
    let document = spawn_blocking(move || text.bytes()).await.map_err(|_| ServerError::Internal)?;
    let pieces = [before.into(), connection.with_delivery_timeout(document), Bytes::from(after + "\n")];
    let length: usize = pieces.iter().map(Bytes::len).sum();
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("application/json")),
        (header::CONTENT_LENGTH, length.into()),
        (header::ETAG, tag),
    ];
    Ok((headers, Body::from_stream(iter(pieces.map(Ok::<_, ServerError>)))).into_response())
}

/// Handles `GET /sessions/S/nodes`: lists the nodes of the session's scene.
pub async fn nodes(State(state): App, SessionName(name): SessionName) -> HandlerResult {
    let snapshot = state.rooms.snapshot(&name).await?;
    let posed = snapshot.scene.posed;
    let listed = spawn_blocking(move || posed.node_tree().drawn_paths(MAX_NODES_LISTED, scene::MAX_PATH_BYTES));
    let (paths, left_out) = listed.await.map_err(|_| ServerError::Internal)?;
    Ok(json(&SceneNodes { paths, left_out }))
}

/// Handles `POST /sessions/S/edits`: carries out edits, undos and redos of a program.
pub async fn edit(
    State(state): App,
    Extension(credential): Extension<Credential>,
    SessionName(name): SessionName,
    JsonBody(Edits { actor, edits, atomic, op_id }): JsonBody<Edits>,
) -> HandlerResult {
    check_size("a request", edits.len(), MAX_EDITS, "edits")?;
    let principal = Principal { credential, actor: actor_or_program(actor)? };
    let count = edits.len();
    let steps = match (atomic, op_id) {
        (true, op_id) => vec![parse_group(op_id, edits, &state.services.scenes).await?],
        (false, None) => {
            let mut steps = Vec::with_capacity(count);
            for edit in edits {
                steps.push(parse_edit(edit, &state.services.scenes).await?);
            }
            steps
        }
        (false, Some(_)) => {
            return Err(ServerError::bad_message(
                "`opId` beside `edits` names one step: give each edit its own, or ask for `\"atomic\": true`",
            ));
        }
    };
    let room = state.rooms.find(&name).await?;
    let payer = Payer::new(&name.as_str().into(), &principal.actor.id);
    state.services.edit_pacing.wait(&payer, MESSAGE_COST_EDITS + count as f64).await;
    // If the connection ends, this future is dropped.
    let cancellation = CancellationToken::new();
    let _guard = cancellation.clone().drop_guard();
    Ok(json(&room.request(|reply| RoomMessage::Edit { principal, steps, reply, cancellation }).await?))
}

/// Converts an edit. An error of its command becomes its own result and not that of the request.
async fn parse_edit(edit: Edit, scenes: &SceneCache) -> Result<RecordRequest, ServerError> {
    let Edit { op_id, base_seq, command, undo, redo } = edit;
    let request = match (command, undo, redo) {
        (Some(command), None, None) => requested_edit(command, base_seq, scenes).await.map(RecordAction::Edit),
        (None, Some(scope), None) => Ok(RecordAction::Undo(scope.into())),
        (None, None, Some(scope)) => Ok(RecordAction::Redo(scope.into())),
        _ => Err(ServerError::bad_message("an edit has exactly one of `command`, `undo` and `redo`: divide it")),
    };
    step(op_id.map_or_else(new_op_id, Ok)?, request)
}

/// Converts edits that make one step. An error of one edit is the error of the step.
async fn parse_group(
    op_id: Option<String>,
    edits: Vec<Edit>,
    scenes: &SceneCache,
) -> Result<RecordRequest, ServerError> {
    check_size("an atomic request", edits.len(), MAX_GROUP_EDITS, "edits")?;
    let op_id = op_id.map_or_else(new_op_id, Ok)?;
    let mut requested = Vec::with_capacity(edits.len());
    for (index, edit) in edits.into_iter().enumerate() {
        match parse_grouped(edit, scenes).await {
            Ok(edit) => requested.push(edit),
            Err(error) => return step(op_id, Err(in_group_error(index, error))),
        }
    }
    step(op_id, Ok(RecordAction::Group(requested)))
}

async fn parse_grouped(edit: Edit, scenes: &SceneCache) -> Result<RequestedEdit, ServerError> {
    let sentence = match edit {
        Edit { command: Some(protocol::Command::LoadScene { .. }), .. } => {
            "`loadScene` changes what all else is about: send it in a request of its own"
        }
        Edit { op_id: None, base_seq, command: Some(command), undo: None, redo: None } => {
            return requested_edit(command, base_seq, scenes).await;
        }
        Edit { op_id: Some(_), .. } => "an atomic request is one step: give it one `opId`, beside `edits`",
        _ => "an edit of an atomic request has a `command` and no `undo` or `redo`: send those by themselves",
    };
    Err(ServerError::bad_message(sentence))
}

/// Converts the actor of a request. A request without one is of the actor `api`.
fn actor_or_program(wire: Option<protocol::Actor>) -> Result<Actor, ServerError> {
    wire.map_or_else(|| Ok(Actor { id: "api".into(), name: "API".into() }), actor)
}

fn new_op_id() -> Result<String, ServerError> {
    random_digits().map_err(|error| {
        tracing::error!("the system gives no random numbers: {error}");
        ServerError::Internal
    })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LogQuery {
    from: Option<u64>,
    limit: Option<usize>,
}

/// Handles `GET /sessions/S/log`: the log file, sent while it is read.
pub async fn log(State(state): App, SessionName(name): SessionName, uri: Uri) -> HandlerResult {
    let LogQuery { from, limit } = read_query(&uri)?;
    let limit = limit.unwrap_or(MAX_LOG_RECORDS);
    check_size("an answer", limit, MAX_LOG_RECORDS, "records")?;
    let storage = state.services.storage.clone();
    let session = name.clone();
    storage.read(move |store| store.session(&session)).await?;
    let in_flight = state.services.in_flight.clone();
    let pages = try_unfold((from.unwrap_or(1).max(1), limit), move |(from, left)| {
        page(storage.clone(), in_flight.clone(), name.clone(), from, left)
    });
    Ok(([(header::CONTENT_TYPE, "application/jsonl")], Body::from_stream(pages)).into_response())
}

/// Returns the lines of records from `from` on, and the start of the next page. Returns `None` past the last record.
async fn page(
    storage: Storage,
    in_flight: ByteBudget,
    session: String,
    from: u64,
    left: usize,
) -> Result<Option<(Bytes, (u64, usize))>, ServerError> {
    let records = storage.read(move |store| store.page(&session, from, left, LOG_PAGE_BYTES)).await?;
    let Some(last) = records.last() else { return Ok(None) };
    let next = (last.seq + 1, left - records.len());
    let lines: String = records.iter().map(json_text).collect();
    Ok(Some((in_flight.reserve_unchecked(lines.len()).attach_to(lines), next)))
}
