//! Scenes that a log can load: the demos, and those in a data folder.

use cli::print_note;
use document::AssetHash;
use scene::Scene;
use store::Assets;

/// Returns true if the bytes of the asset exist. They need not be a valid scene.
pub fn is_available(assets: &Assets, asset: &AssetHash) -> bool {
    bytes_of(Some(assets), asset).is_some()
}

/// Returns true if the asset is a demo.
pub fn is_demo(asset: &AssetHash) -> bool {
    demo_bytes(asset).is_some()
}

/// Loads the scene of the asset. If it exists but cannot be loaded, prints the reason to standard error and
/// returns `None`.
pub fn load(assets: Option<&Assets>, asset: &AssetHash) -> Option<Scene> {
    let bytes = bytes_of(assets, asset)?;
    let loaded = ::assets::load_bytes(&bytes).inspect_err(|error| print_note(&format!("note: {asset}: {error}")));
    Some(loaded.ok()?.scene)
}

fn bytes_of(assets: Option<&Assets>, asset: &AssetHash) -> Option<Vec<u8>> {
    let stored = assets.map_or(Ok(None), |assets| assets.bytes(asset));
    let stored = stored.unwrap_or_else(|error| {
        print_note(&format!("note: {error}"));
        None
    });
    stored.or_else(|| demo_bytes(asset))
}

fn demo_bytes(asset: &AssetHash) -> Option<Vec<u8>> {
    let mut demos = ::assets::DEMO_NAMES.iter().filter_map(|(name, _)| ::assets::demo_bytes(name));
    demos.find(|bytes| AssetHash::of(bytes) == *asset)
}
