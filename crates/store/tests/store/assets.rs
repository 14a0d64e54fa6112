//! Assets: named by their bytes, proven by them.

use std::fs;

use protocol::ErrorCode;
use store::StoreError;

use crate::support::Folder;

/// Rules: DOC-5
#[test]
fn an_asset_comes_back_by_its_hash() {
    let folder = Folder::new();
    let store = folder.store();
    let asset = store.put_asset(b"abc").expect("a file");
    // The example of FIPS 180-2, which `printf abc | sha256sum` prints.
    assert_eq!(asset.hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert_eq!(store.put_asset(b"abc").expect("the same again"), asset);
    assert_eq!(store.asset(&asset).expect("a file"), Some(b"abc".to_vec()));
    let empty = store.put_asset(b"").expect("a file");
    assert_eq!(store.asset(&empty).expect("a file"), Some(Vec::new()));
    assert_eq!(store.asset(&document::AssetHash([0; 32])).expect("no error"), None);
    let files = fs::read_dir(folder.data().join("assets")).expect("a folder");
    assert_eq!(files.count(), 2, "nothing but the two");
}

/// Rules: HTTP-10
#[test]
fn an_asset_is_called_what_it_was_last_called() {
    let folder = Folder::new();
    let store = folder.store();
    let asset = store.put_asset(b"room").expect("a file");
    assert_eq!(store.asset_name(&asset).expect("no error"), None);
    let longest = "ü".repeat(128);
    for name in ["Kitchen", "../Küche ☕", &longest] {
        store.name_asset(&asset, name).expect("a file");
        assert_eq!(folder.store().asset_name(&asset).expect("a name").as_deref(), Some(name));
    }
    for name in ["", " room", "room ", "ro\nom", "ro\u{7f}om", &format!("{longest}x")] {
        let refused = store.name_asset(&asset, name).expect_err("no name");
        assert_eq!(refused.code(), ErrorCode::BadName, "{name:?}: {refused}");
    }
    assert_eq!(
        store.asset_name(&asset).expect("a name"),
        Some(longest.clone()),
        "a refused name changes nothing"
    );
    let file = folder.data().join("assets").join(asset.hex() + ".name");
    for damaged in [&b"\xff"[..], b"", longest.repeat(9).as_bytes()] {
        fs::write(&file, damaged).expect("a planted fault");
        assert_eq!(store.asset_name(&asset).expect("no error"), None);
    }
    assert_eq!(store.asset(&asset).expect("whole"), Some(b"room".to_vec()));
}

/// Rules: DOC-5
#[test]
fn a_damaged_asset_is_caught_and_can_be_mended() {
    let folder = Folder::new();
    let store = folder.store();
    let asset = store.put_asset(b"bytes").expect("a file");
    fs::write(folder.data().join("assets").join(asset.hex()), b"bytez").expect("a planted fault");
    assert!(matches!(store.asset(&asset), Err(StoreError::DamagedAsset(named)) if named == asset));
    assert_eq!(store.put_asset(b"bytes").expect("written again"), asset);
    assert_eq!(store.asset(&asset).expect("whole"), Some(b"bytes".to_vec()));
}

#[test]
fn what_a_killed_upload_left_is_removed() {
    let folder = Folder::new();
    let store = folder.store();
    let asset = store.put_asset(b"bytes").expect("a file");
    let leftover = folder.data().join("assets/.incoming-abc");
    fs::write(&leftover, b"byt").expect("a planted leftover");
    store.remove_leftovers().expect("removed");
    assert!(!leftover.exists());
    assert_eq!(store.asset(&asset).expect("whole"), Some(b"bytes".to_vec()));
}
