//! The scenes that a log can load: the demos, and those in a data folder.

use cli::say;
use document::AssetHash;
use scene::Scene;
use store::Store;

/// Whether there is a scene of those bytes, whatever it holds.
pub fn is_here(store: &Store, asset: &AssetHash) -> bool {
    bytes_of(Some(store), asset).is_some()
}

/// The scene of those bytes. What stands in the way of one that is there is said on standard error.
pub fn load(store: Option<&Store>, asset: &AssetHash) -> Option<Scene> {
    let bytes = bytes_of(store, asset)?;
    let loaded = assets::load_bytes(&bytes).inspect_err(|error| say(&format!("note: {asset}: {error}")));
    Some(loaded.ok()?.scene)
}

fn bytes_of(store: Option<&Store>, asset: &AssetHash) -> Option<Vec<u8>> {
    let stored = store.map_or(Ok(None), |store| store.asset(asset));
    let stored = stored.unwrap_or_else(|error| {
        say(&format!("note: {error}"));
        None
    });
    stored.or_else(|| {
        let mut demos = assets::DEMO_NAMES.iter().filter_map(|(name, _)| assets::demo_bytes(name));
        demos.find(|bytes| AssetHash::of(bytes) == *asset)
    })
}
