//! The session that a start opens: made at the first start, or for another scene.

use std::path::Path;

use document::{AssetHash, Command, CommandContext, SceneContents};
use edit::{Actor, EditRequest, EditSources, Session};
use store::{CommitBatch, MAX_NAME_CHARS, Store, StoreError};

use crate::ServerError;
use crate::room::time_ms;
use crate::scenes::DEMO;

/// Default scene of the first session.
const FIRST_SCENE: &str = "demo:vases";
/// Greatest length of a session name from a scene. The rest is for a number behind it.
const MAX_STEM_CHARS: usize = MAX_NAME_CHARS - 4;
/// Number of names to try for a scene's session if its own name is taken.
const MAX_NAME_TRIES: usize = 100;

/// Sessions that a start of the server opens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartSession {
    pub name: String,
    /// Name of the scene in the first session, if it is not the requested one.
    pub scene_already_there: Option<String>,
}

/// Makes the first session with its scene as first record, completely or not at all. A session without records, which
/// an interrupted start could once leave, gets the scene too. If the first session has another scene than `scene`, that
/// scene gets its own session, which a second start with that scene finds again. In a folder with sessions but without
/// the first one, since people deleted it, the first session is made only for a given `scene`.
pub fn ensure(store: &mut Store, name: &str, scene: Option<&str>) -> Result<StartSession, ServerError> {
    let sessions = store.sessions()?;
    let is_begun = sessions.iter().any(|row| row.name == name && row.seq > 0);
    let first = StartSession { name: name.into(), scene_already_there: None };
    let has_only_others = !sessions.is_empty() && sessions.iter().all(|row| row.name != name);
    if has_only_others && scene.is_none() {
        return Ok(first);
    }
    if !is_begun {
        let scene = scene.unwrap_or(FIRST_SCENE);
        begin(store, name, scene, &bytes_of(scene)?)?;
        return Ok(first);
    }
    let Some(scene) = scene else { return Ok(first) };
    let bytes = bytes_of(scene)?;
    let asset = AssetHash::of(&bytes);
    if uses_scene(store, name, asset) {
        return Ok(first);
    }
    let own_scene = store.open_session(name).ok().and_then(|opened| opened.session.document().scene().cloned());
    let own_scene = Some(own_scene.map_or_else(|| "what it has".to_owned(), |scene| scene.name));
    let stem = session_name(scene);
    let names = (1..=MAX_NAME_TRIES).map(|n| if n == 1 { stem.clone() } else { format!("{stem}-{n}") });
    for name in names.filter(|tried| tried != name) {
        if !store.sessions()?.into_iter().any(|row| row.name == name && row.seq > 0) {
            begin(store, &name, scene, &bytes)?;
        } else if !uses_scene(store, &name, asset) {
            continue;
        }
        return Ok(StartSession { name, scene_already_there: own_scene });
    }
    Err(ServerError::NoSessionName(stem))
}

/// True if a session began with a scene or has it now. False for a session that cannot be read, so that it does not
/// prevent a start.
fn uses_scene(store: &Store, session: &str, asset: AssetHash) -> bool {
    let has_it = |session: Result<Session, StoreError>| {
        session.is_ok_and(|session| session.document().scene().is_some_and(|scene| scene.asset == asset))
    };
    has_it(store.replay(session, Some(1))) || has_it(store.open_session(session).map(|opened| opened.session))
}

/// Adds its scene to a session that is missing or empty.
fn begin(store: &mut Store, name: &str, scene: &str, bytes: &[u8]) -> Result<(), ServerError> {
    let (asset, contents) = store_scene(store, scene, bytes)?;
    let actor = Actor { id: "server".into(), name: "Server".into() };
    let command = Command::LoadScene { asset, name: scene_label(scene) };
    let request = EditRequest::Edit { base_seq: None, command };
    let mut session = Session::default();
    let context = CommandContext { loaded: Some(&contents), ..CommandContext::default() };
    let sources = EditSources { context, reverted: None };
    let record = session.execute_request(request, &actor, "first-scene", time_ms(), sources)?;
    let (records, hash) = (&[record], session.document().hash());
    let first = CommitBatch { session: name, records, rejections: &[], hash };
    match store.session(name) {
        Err(StoreError::NoSession(_)) => drop(store.begin_session(&first, None)?),
        Err(error) => return Err(error.into()),
        Ok(_) => drop(store.append(&[first])?),
    }
    Ok(())
}

/// Returns the session name for a scene: the name of the file or demo without its extension, limited to valid
/// characters.
fn session_name(scene: &str) -> String {
    let label = scene_label(scene);
    let label = label.strip_prefix(DEMO).unwrap_or(&label);
    let stem = label.rsplit_once('.').map_or(label, |(stem, _)| stem);
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let name: String = stem.chars().map(|c| if allowed(c) { c } else { '-' }).take(MAX_STEM_CHARS).collect();
    let name = name.trim_start_matches(['-', '_', '.']);
    if name.is_empty() { "scene".into() } else { name.into() }
}

/// Reads a scene into the bytes of one file.
fn bytes_of(name: &str) -> Result<Vec<u8>, ServerError> {
    match name.strip_prefix(DEMO) {
        Some(demo) => assets::demo_bytes(demo).ok_or_else(|| ServerError::NoDemo(demo.into())),
        None => Ok(assets::pack(Path::new(name))?),
    }
}

/// Stores a scene and its display name. Returns the scene's contents.
fn store_scene(store: &Store, name: &str, bytes: &[u8]) -> Result<(AssetHash, SceneContents), ServerError> {
    let loaded = assets::load_bytes(bytes).map_err(|error| assets::AssetError { file: name.into(), ..error })?;
    let asset = store.assets.put(bytes)?;
    let loaded = loaded.with_default_light();
    if loaded.name.as_deref() != Some(name) {
        store.assets.set_name(&asset, &scene_label(name))?;
    }
    Ok((asset, loaded.contents))
}

/// Returns the display name of a scene: the name of a demo, or the last part of a path, limited to valid characters.
fn scene_label(name: &str) -> String {
    let label = Path::new(name).file_name().and_then(|name| name.to_str()).unwrap_or(name);
    let fits = label.char_indices().take_while(|(at, c)| at + c.len_utf8() <= light::MAX_NAME_BYTES);
    let label: String = fits.map(|(_, c)| c).filter(|c| !c.is_control()).collect();
    let label = label.trim();
    if label.is_empty() { "scene".into() } else { label.into() }
}
