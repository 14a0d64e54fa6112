//! Assets: named by the hash of their bytes, and checked against it.

use std::fs;

use protocol::ErrorCode;
use store::StoreError;

use crate::support::Folder;

/// Rules: DOC-5
#[test]
fn an_asset_comes_back_by_its_hash() {
    let folder = Folder::new();
    let store = folder.store();
    let asset = store.assets.put(b"abc").expect("a file");
    // The example of FIPS 180-2, which `printf abc | sha256sum` prints.
    assert_eq!(asset.hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert_eq!(store.assets.put(b"abc").expect("the same again"), asset);
    assert_eq!(store.assets.bytes(&asset).expect("a file"), Some(b"abc".to_vec()));
    let empty = store.assets.put(b"").expect("a file");
    assert_eq!(store.assets.bytes(&empty).expect("a file"), Some(Vec::new()));
    assert_eq!(store.assets.bytes(&document::AssetHash([0; 32])).expect("no error"), None);
    let files = fs::read_dir(folder.data().join("assets")).expect("a folder");
    assert_eq!(files.count(), 2, "nothing but the two");
}

/// Rules: HTTP-10
#[test]
fn an_asset_is_called_what_it_was_last_called() {
    let folder = Folder::new();
    let store = folder.store();
    let asset = store.assets.put(b"room").expect("a file");
    assert_eq!(store.assets.name_of(&asset).expect("no error"), None);
    let longest = "ü".repeat(128);
    for name in ["Kitchen", "../Küche ☕", &longest] {
        store.assets.set_name(&asset, name).expect("a file");
        assert_eq!(folder.store().assets.name_of(&asset).expect("a name").as_deref(), Some(name));
    }
    for name in ["", " room", "room ", "ro\nom", "ro\u{7f}om", &format!("{longest}x")] {
        let refused = store.assets.set_name(&asset, name).expect_err("no name");
        assert_eq!(refused.code(), ErrorCode::BadName, "{name:?}: {refused}");
    }
    assert_eq!(store.assets.name_of(&asset).expect("a name"), Some(longest.clone()), "a refused name changes nothing");
    let file = folder.data().join("assets").join(asset.hex() + ".name");
    for damaged in [&b"\xff"[..], b"", longest.repeat(9).as_bytes()] {
        fs::write(&file, damaged).expect("a planted fault");
        assert_eq!(store.assets.name_of(&asset).expect("no error"), None);
    }
    assert_eq!(store.assets.bytes(&asset).expect("whole"), Some(b"room".to_vec()));
}

/// Rules: DOC-5
#[test]
fn a_damaged_asset_is_caught_and_can_be_mended() {
    let folder = Folder::new();
    let store = folder.store();
    let asset = store.assets.put(b"bytes").expect("a file");
    fs::write(folder.data().join("assets").join(asset.hex()), b"bytez").expect("a planted fault");
    assert!(matches!(store.assets.bytes(&asset), Err(StoreError::DamagedAsset(named)) if named == asset));
    assert_eq!(store.assets.put(b"bytes").expect("written again"), asset);
    assert_eq!(store.assets.bytes(&asset).expect("whole"), Some(b"bytes".to_vec()));
}

#[test]
fn leftovers_of_a_killed_upload_are_removed() {
    let folder = Folder::new();
    let store = folder.store();
    let asset = store.assets.put(b"bytes").expect("a file");
    let leftover = folder.data().join("assets/.incoming-abc");
    fs::write(&leftover, b"byt").expect("a planted leftover");
    store.assets.remove_leftovers().expect("removed");
    assert!(!leftover.exists());
    assert_eq!(store.assets.bytes(&asset).expect("whole"), Some(b"bytes".to_vec()));
}
