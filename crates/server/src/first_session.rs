//! The session that a server makes at its first start.

use std::path::Path;

use document::{AssetHash, Command, Context, SceneContents};
use edit::{Actor, Request, Sources};
use store::{Batch, Store};

use crate::ServerError;
use crate::room::time_ms;
use crate::scenes::DEMO;

/// Makes the first session, with its scene as its first record, or nothing. A session that has no record yet, as a start
/// that was cut off could leave it once, is given the scene too.
pub fn ensure(store: &mut Store, name: &str, scene: &str) -> Result<(), ServerError> {
    let known = store.sessions()?.into_iter().find(|row| row.name == name);
    if known.as_ref().is_some_and(|row| row.seq > 0) {
        return Ok(());
    }
    let (asset, contents) = first_scene(store, scene)?;
    let actor = Actor { id: "server".into(), name: "Server".into() };
    let command = Command::LoadScene { asset, name: scene_label(scene) };
    let request = Request::Edit { base_seq: None, command };
    let mut session = edit::Session::default();
    let context = Context { loaded: Some(&contents), ..Context::default() };
    let sources = Sources { context, taken_back: None };
    let record = session.request(request, &actor, "first-scene", time_ms(), sources)?;
    let (records, hash) = (&[record], session.document().hash());
    let first = Batch { session: name, records, rejections: &[], hash };
    match known {
        None => drop(store.begin_session(&first)?),
        Some(_) => drop(store.append(&[first])?),
    }
    Ok(())
}

fn first_scene(store: &Store, name: &str) -> Result<(AssetHash, SceneContents), ServerError> {
    let bytes = match name.strip_prefix(DEMO) {
        Some(demo) => assets::demo_bytes(demo).ok_or_else(|| ServerError::NoDemo(demo.into()))?,
        None => assets::pack(Path::new(name))?,
    };
    let loaded =
        assets::load_bytes(&bytes).map_err(|error| assets::AssetError { file: name.into(), ..error })?;
    let asset = store.put_asset(&bytes)?;
    let loaded = loaded.lit();
    if loaded.name.as_deref() != Some(name) {
        store.name_asset(&asset, &scene_label(name))?;
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
