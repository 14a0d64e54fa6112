//! The list of sessions, and operations on whole sessions.

use std::collections::BTreeSet;
use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::IntoResponse;
use edit::Actor;
use protocol::{DemoScene, DemoScenes, Duplicate, LastChange, SessionChange, SessionEntry, SessionList};
use serde::Deserialize;
use store::{SessionSummary, StoreError};

use super::answer::{HandlerResult, created, json};
use super::read::{SessionName, read_json, read_query};
use crate::ServerError;
use crate::scenes::DEMO;
use crate::state::AppState;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ListQuery {
    archived: Option<bool>,
    name: Option<String>,
}

/// Handles `GET /sessions`: lists the sessions. Opens no session and reads no log.
pub async fn list(State(state): State<Arc<AppState>>, uri: Uri) -> HandlerResult {
    let ListQuery { archived, name } = read_query(&uri)?;
    let with_archived = archived.unwrap_or(name.is_some());
    let summaries = state.backend.storage.read(move |store| match name {
        None => store.sessions(),
        Some(name) => match store.summary(&name) {
            Err(StoreError::NoSession(_)) => Ok(Vec::new()),
            found => Ok(vec![found?]),
        },
    });
    let summaries = summaries.await?;
    let clients = state.rooms.clients().await?;
    let listed = summaries.into_iter().filter(|session| with_archived || !session.is_archived);
    let entry = |session: SessionSummary| {
        let here = clients.get(session.name.as_str()).map_or(&[][..], Vec::as_slice);
        entry(session, here)
    };
    Ok(json(&SessionList { sessions: listed.map(entry).collect() }))
}

/// Makes the entry of a session in the list, with its connected clients.
fn entry(session: SessionSummary, clients: &[Actor]) -> SessionEntry {
    let SessionSummary { name, title, epoch, seq, is_archived, made_ms, changed } = session;
    let mut known = BTreeSet::new();
    let people = clients.iter().filter(|actor| known.insert(&actor.id)).map(|actor| actor.name.clone());
    SessionEntry {
        name,
        title,
        epoch,
        seq,
        clients: clients.len(),
        people: people.collect(),
        archived: is_archived,
        made_ms,
        changed: changed.map(|change| LastChange { time_ms: change.time_ms, actor: change.actor_name }),
    }
}

/// Handles `PATCH /sessions/S`: changes the title, or archives or restores the session.
pub async fn change(
    State(state): State<Arc<AppState>>,
    SessionName(name): SessionName,
    headers: HeaderMap,
    body: Bytes,
) -> HandlerResult {
    let SessionChange { title, archived } = read_json(&headers, &body)?;
    let change = store::SessionChange { title, archived };
    let summary = state.backend.storage.change_session(name, change).await?;
    state.rooms.notify_change(&summary.name, &summary.title, summary.is_archived).await;
    let clients = state.rooms.clients().await?;
    let here = clients.get(summary.name.as_str()).map_or(&[][..], Vec::as_slice);
    Ok(json(&entry(summary, here)))
}

/// Handles `POST /sessions/S/duplicate`: copies the session with its whole log.
pub async fn duplicate(
    State(state): State<Arc<AppState>>,
    SessionName(original): SessionName,
    headers: HeaderMap,
    body: Bytes,
) -> HandlerResult {
    let Duplicate { name, title } = read_json(&headers, &body)?;
    let made = state.backend.storage.duplicate_session(original, name, title).await?;
    Ok(created(&entry(made, &[])))
}

/// Handles `DELETE /sessions/S`: deletes an archived session.
pub async fn delete(State(state): State<Arc<AppState>>, SessionName(name): SessionName) -> HandlerResult {
    let asked = name.clone();
    let summary = state.backend.storage.read(move |store| store.summary(&asked)).await?;
    // Checked before its room is closed.
    if !summary.is_archived {
        return Err(ServerError::Store(StoreError::NotArchived(name)));
    }
    state.rooms.delete(&name).await?;
    Ok(StatusCode::NO_CONTENT.into_response())
}

/// Handles `GET /scenes`: lists the demo scenes.
pub fn scenes() -> DemoScenes {
    let demo = |(name, shows): &(&str, &str)| DemoScene {
        scene: format!("{DEMO}{name}"),
        name: (*name).into(),
        shows: (*shows).into(),
    };
    DemoScenes { demos: assets::DEMO_NAMES.iter().map(demo).collect() }
}
