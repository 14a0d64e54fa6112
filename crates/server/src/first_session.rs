//! The session that a start leads to: made at the first, or with another scene.

use std::path::Path;

use document::{AssetHash, Command, CommandContext, SceneContents};
use edit::{Actor, EditRequest, EditSources, Session};
use store::{CommitBatch, MAX_NAME_CHARS, Store, StoreError};

use crate::ServerError;
use crate::room::time_ms;
use crate::scenes::DEMO;

/// What the first session loads where nobody says.
const FIRST_SCENE: &str = "demo:vases";
/// Of a scene's session; the rest is for a number behind it.
const MAX_STEM_CHARS: usize = MAX_NAME_CHARS - 4;
/// How many names are tried for a session of a scene whose own name is taken.
const MAX_NAME_TRIES: usize = 100;

/// The session that a start leads to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartSession {
    /// What it is called.
    pub name: String,
    /// What the first session keeps, where that holds another scene than was asked for.
    pub scene_already_there: Option<String>,
}

/// Makes the first session, with its scene as its first record, or nothing. A session that has no record yet, as a start
/// that was cut off could leave it once, is given the scene too. Where it holds another scene than `scene`, that gets a
/// session of its own, which a second start with that scene finds again. A folder that has sessions and not this one, as
/// where people have deleted it, gets it for a scene alone.
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
    let held = store.open_session(name).ok().and_then(|opened| opened.session.document().scene().cloned());
    let kept = Some(held.map_or_else(|| "what it has".to_owned(), |held| held.name));
    let stem = session_name(scene);
    let names = (1..=MAX_NAME_TRIES).map(|n| if n == 1 { stem.clone() } else { format!("{stem}-{n}") });
    for name in names.filter(|tried| tried != name) {
        if !store.sessions()?.into_iter().any(|row| row.name == name && row.seq > 0) {
            begin(store, &name, scene, &bytes)?;
        } else if !uses_scene(store, &name, asset) {
            continue;
        }
        return Ok(StartSession { name, scene_already_there: kept });
    }
    Err(ServerError::NoSessionName(stem))
}

/// Whether a session began with a scene, or holds it now. One that cannot be read does neither: it keeps nobody from starting.
fn uses_scene(store: &Store, session: &str, asset: AssetHash) -> bool {
    let holds = |session: Result<Session, StoreError>| {
        session.is_ok_and(|session| session.document().scene().is_some_and(|scene| scene.asset == asset))
    };
    holds(store.replay(session, Some(1))) || holds(store.open_session(session).map(|opened| opened.session))
}

/// Gives a session that is missing or empty its scene.
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

/// What a session of a scene is called: the file's or the demo's name without its ending, as far as it may name one.
fn session_name(scene: &str) -> String {
    let label = scene_label(scene);
    let label = label.strip_prefix(DEMO).unwrap_or(&label);
    let stem = label.rsplit_once('.').map_or(label, |(stem, _)| stem);
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let name: String = stem.chars().map(|c| if allowed(c) { c } else { '-' }).take(MAX_STEM_CHARS).collect();
    let name = name.trim_start_matches(['-', '_', '.']);
    if name.is_empty() { "scene".into() } else { name.into() }
}

/// One file that holds all of a scene.
fn bytes_of(name: &str) -> Result<Vec<u8>, ServerError> {
    match name.strip_prefix(DEMO) {
        Some(demo) => assets::demo_bytes(demo).ok_or_else(|| ServerError::NoDemo(demo.into())),
        None => Ok(assets::pack(Path::new(name))?),
    }
}

/// Keeps a scene and what it is called; gives what comes with it.
fn store_scene(store: &Store, name: &str, bytes: &[u8]) -> Result<(AssetHash, SceneContents), ServerError> {
    let loaded =
        assets::load_bytes(bytes).map_err(|error| assets::AssetError { file: name.into(), ..error })?;
    let asset = store.assets.put(bytes)?;
    let loaded = loaded.with_default_light();
    if loaded.name.as_deref() != Some(name) {
        store.assets.set_name(&asset, &scene_label(name))?;
    }
    Ok((asset, loaded.contents))
}

/// What people call a scene: a demo by its name, a file by its last part, as far as that is fit to be a name.
fn scene_label(name: &str) -> String {
    let label = Path::new(name).file_name().and_then(|name| name.to_str()).unwrap_or(name);
    let fits = label.char_indices().take_while(|(at, c)| at + c.len_utf8() <= light::MAX_NAME_BYTES);
    let label: String = fits.map(|(_, c)| c).filter(|c| !c.is_control()).collect();
    let label = label.trim();
    if label.is_empty() { "scene".into() } else { label.into() }
}
