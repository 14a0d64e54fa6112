//! The scenes that a log can load: the demos, and those in a data folder.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use document::AssetHash;
use scene::Scene;
use store::Store;

use crate::say;

/// Finds scenes and keeps those it has found.
pub struct KnownScenes {
    store: Option<Store>,
    found: RefCell<BTreeMap<AssetHash, Option<Arc<Scene>>>>,
}

impl KnownScenes {
    /// The demos, and what `store` holds.
    pub fn new(store: Option<Store>) -> Self {
        Self { store, found: RefCell::default() }
    }

    /// The scene of those bytes. What stands in the way of one that is there is said on standard error.
    pub fn find(&self, asset: &AssetHash) -> Option<Arc<Scene>> {
        self.found.borrow_mut().entry(*asset).or_insert_with(|| self.load(asset)).clone()
    }

    fn load(&self, asset: &AssetHash) -> Option<Arc<Scene>> {
        let stored = self.store.as_ref().map_or(Ok(None), |store| store.asset(asset));
        let bytes = stored.unwrap_or_else(|error| {
            say(&format!("note: {error}"));
            None
        });
        let bytes = bytes.or_else(|| demo_of(asset))?;
        let loaded = assets::load_bytes(&bytes).inspect_err(|error| say(&format!("note: {asset}: {error}")));
        Some(Arc::new(loaded.ok()?.scene))
    }
}

/// The bytes of the demo scene of that hash.
fn demo_of(asset: &AssetHash) -> Option<Vec<u8>> {
    let mut demos = assets::DEMO_NAMES.iter().filter_map(|(name, _)| assets::demo_bytes(name));
    demos.find(|bytes| AssetHash::of(bytes) == *asset)
}
