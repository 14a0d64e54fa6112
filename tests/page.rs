//! The page in a real browser, on a real server.

#[path = "program.rs"]
mod program;

use std::path::Path;
use std::process::Command;

use bench::ServerProcess;

use crate::program::program;

/// Drags a control point in one page while a second one watches, undoes it, and compares pixels.
///
/// Rules: SOCK-3, FRAME-1, FRAME-2, FRAME-4, UNDO-1
#[test]
fn a_drag_in_one_page_shows_in_both_and_undo_restores_the_pixels() {
    in_a_browser("session.mjs");
}

/// Every panel: lights, parameters, control points, cameras, views, people.
///
/// Rules: SOCK-7, SOCK-8, GEST-1
#[test]
fn every_control_does_what_it_says() {
    in_a_browser("controls.mjs");
}

/// The view, handles and fields by keys; presses within a second are one record.
///
/// Rules: SOCK-7, GEST-1
#[test]
fn all_can_be_done_by_keys() {
    in_a_browser("keyboard.mjs");
}

/// States that are seldom seen, and planted faults.
///
/// Rules: GEST-4
#[test]
fn nothing_is_faint_or_nameless_in_any_state() {
    in_a_browser("accessibility.mjs");
}

/// Opens the page a dozen times, with its size or its socket late, and compares its pictures with `render`'s: the whole
/// shot is there each time, and the film gate holds what `render` writes on every shape of stage, of every camera.
///
/// Rules: DOC-3, HTTP-8
#[test]
fn the_page_shows_the_shot_and_its_gate_is_what_render_writes() {
    in_a_browser("gate.mjs");
}

/// Walks every control on six screens, from a phone to a page at 200 %, and moves view and light with fingers.
///
/// Rules: SOCK-7
#[test]
fn the_page_fits_every_screen_and_fingers() {
    in_a_browser("layouts.mjs");
}

/// Sends a scene, loads it, and reads its name and its notes on the page, by keyboard and after a reload.
///
/// Rules: HTTP-10, SOCK-11
#[test]
fn a_scene_has_its_name_on_the_page_and_says_what_is_not_drawn() {
    in_a_browser("scene.mjs");
}

/// Runs a script of the page's browser tests on a server of its own. It fails with a sentence, also where one of its pictures
/// breaks a rule of accessibility.
fn in_a_browser(script: &str) {
    let client = Path::new(env!("CARGO_MANIFEST_DIR")).join("../web-client");
    if !client.join("node_modules/playwright-core").is_dir() || !client.join("dist/index.html").is_file() {
        let must_run = std::env::var("CI").is_ok_and(|ci| ci == "true");
        assert!(!must_run, "the page is not built: `make page`");
        println!("skipped: the page is not built; `make page` builds it");
        return;
    }
    let data = tempfile::tempdir().expect("a folder");
    let server = ServerProcess::start(program(), data.path(), &["--scene", "demo:vases"]).expect("started");
    server.wait_until_ready().expect("ready");
    let pictures = tempfile::tempdir().expect("a folder");
    let address = format!("http://{}/#token={}&session=main", server.address.host, server.address.token);
    let script = client.join("test/browser").join(script);
    let status =
        Command::new("node").arg(script).arg(address).arg(pictures.path()).status().expect("node runs");
    assert!(status.success(), "the page does not do what it should");
}
