//! The list of sessions, and operations on whole sessions.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use axum::extract::State;
use axum::http::{StatusCode, Uri};
use axum::response::IntoResponse;
use edit::Actor;
use protocol::{DemoScene, DemoScenes, Duplicate, LastChange, SessionChange, SessionEntry, SessionList};
use serde::Deserialize;
use store::{SessionSummary, Store, StoreError};

use super::answer::{HandlerResult, created, json};
use super::read::{JsonBody, SessionName, read_query};
use crate::ServerError;
use crate::scenes::DEMO;
use crate::state::App;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ListQuery {
    archived: Option<bool>,
    name: Option<String>,
}

/// Handles `GET /sessions`: lists the sessions. Opens no session and reads no log.
pub async fn list(State(state): App, uri: Uri) -> HandlerResult {
    let ListQuery { archived, name } = read_query(&uri)?;
    let with_archived = archived.unwrap_or(name.is_some());
    let summaries = state.services.storage.read(move |store| match name {
        None => store.sessions(),
        Some(name) => match store.summary(&name) {
            Err(StoreError::NoSession(_)) => Ok(Vec::new()),
            found => Ok(vec![found?]),
        },
    });
    let summaries = summaries.await?;
    let clients = state.rooms.clients().await?;
    let listed = summaries.into_iter().filter(|session| with_archived || !session.is_archived);
    Ok(json(&SessionList { sessions: listed.map(|session| entry(session, &clients)).collect() }))
}

/// Makes the entry of a session in the list, with its clients among those of all sessions.
fn entry(session: SessionSummary, clients: &BTreeMap<Arc<str>, Vec<Actor>>) -> SessionEntry {
    let SessionSummary { name, title, epoch, seq, is_archived, made_ms, changed } = session;
    let clients = clients.get(name.as_str()).map_or(&[][..], Vec::as_slice);
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
    State(state): App,
    SessionName(name): SessionName,
    JsonBody(SessionChange { title, archived }): JsonBody<SessionChange>,
) -> HandlerResult {
    let change = store::SessionChange { title, archived };
    let summary = state.services.storage.run_exclusive(move |store| store.change_session(&name, &change)).await?;
    state.rooms.notify_change(&summary.name, &summary.title, summary.is_archived).await;
    let clients = state.rooms.clients().await?;
    Ok(json(&entry(summary, &clients)))
}

/// Handles `POST /sessions/S/duplicate`: copies the session with its whole log.
pub async fn duplicate(
    State(state): App,
    SessionName(original): SessionName,
    JsonBody(Duplicate { name, title }): JsonBody<Duplicate>,
) -> HandlerResult {
    let duplicate = move |store: &mut Store| store.duplicate_session(&original, &name, title.as_deref());
    let made = state.services.storage.run_exclusive(duplicate).await?;
    Ok(created(&entry(made, &BTreeMap::new())))
}

/// Handles `DELETE /sessions/S`: deletes an archived session.
pub async fn delete(State(state): App, SessionName(name): SessionName) -> HandlerResult {
    let session = name.clone();
    let summary = state.services.storage.read(move |store| store.summary(&session)).await?;
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
