//! Loading of scenes.

use document::{AssetHash, Command, EditError};
use light::MAX_NAME_BYTES;

use crate::support::{ROOM, YARD, bendy, content, done, eye, refused, sample, spot, take_back};

fn load(asset: AssetHash, name: &str) -> Command {
    Command::LoadScene { asset, name: name.into() }
}

/// Rules: DOC-1, DOC-5
#[test]
fn a_scene_replaces_lights_and_cameras() {
    let mut document = sample();
    done(&mut document, &load(ROOM, "room"));
    assert_eq!(document.scene().map(|scene| scene.asset), Some(ROOM));
    let lights: Vec<_> = document.lights().iter().map(|(id, placed)| (id.0, placed.light.light())).collect();
    assert_eq!(lights, [(5, &bendy())], "with numbers of its own");
    let cameras: Vec<_> = document.cameras().iter().map(|(id, camera)| (id.0, camera)).collect();
    assert_eq!(cameras, [(6, &eye())]);

    done(&mut document, &load(YARD, "yard"));
    let lights: Vec<_> = document.lights().iter().map(|(id, placed)| (id.0, placed.light.light())).collect();
    assert_eq!((lights, document.cameras().len()), (vec![(7, &spot())], 0));
    assert_eq!(document.scene().map(|scene| scene.asset), Some(YARD));
}

/// Rules: REC-2
#[test]
fn taking_a_scene_back_brings_the_earlier_lights() {
    let mut document = sample();
    done(&mut document, &load(ROOM, "room"));
    let before = content(&document);
    let changes = done(&mut document, &load(YARD, "yard"));
    take_back(&mut document, &changes);
    assert_eq!(content(&document), before);
    assert_eq!(document.scene().map(|scene| scene.asset), Some(ROOM), "the geometry's name too");
}

/// Rules: CMD-6
#[test]
fn a_scene_that_is_not_here_is_refused() {
    let nowhere = AssetHash([9; 32]);
    let error = refused(&sample(), &load(nowhere, "nowhere"));
    assert_eq!(error, EditError::UnknownAsset(nowhere));
    assert!(error.to_string().contains(&nowhere.hex()));
    let long = "x".repeat(MAX_NAME_BYTES + 1);
    assert!(matches!(refused(&sample(), &load(ROOM, &long)), EditError::TooLong { field: "name", .. }));
}
