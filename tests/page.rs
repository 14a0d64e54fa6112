//! The page in a real browser, on a real server.


use std::path::Path;

use bench::{ServerAddress, ServerProcess};
use crate::browser::run_in_browser;
use crate::program::program;

/// The session of a server that was started with a scene.
const MAIN: Option<&str> = Some("main");

/// Drags a control point in one page while a second one watches, undoes it, and compares pixels.
///
/// Rules: SOCK-3, FRAME-1, FRAME-2, FRAME-4, UNDO-1
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_drag_in_one_page_shows_in_both_and_undo_restores_the_pixels() {
    in_a_browser("session.mjs");
}

/// Pictures of a drag may be reduced, are shown as large as ever, say so, and stay full where a person wants it.
///
/// Rules: FRAME-10
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_drag_holds_its_rate_and_says_what_that_costs() {
    in_a_browser("holding.mjs");
}

/// Every panel: lights, parameters, control points, cameras, views, people.
///
/// Rules: SOCK-7, SOCK-8, GEST-1
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn every_control_does_what_it_says() {
    in_a_browser("controls.mjs");
}

/// The view, handles and fields by keys; presses within a second are one record.
///
/// Rules: SOCK-7, GEST-1
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn all_can_be_done_by_keys() {
    in_a_browser("keyboard.mjs");
}

/// One's own exposure and lights seen alone, which nobody else sees; mute and copies, which all do; new lights and formats.
///
/// Rules: SOCK-7, SOCK-12, HTTP-21
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn what_is_ones_own_is_and_lights_come_and_go_dark() {
    in_a_browser("own_view.mjs");
}

/// Defaults come back, what does nothing is hidden, a parameter that the page has never heard of is a field, and without a
/// table the page says so.
///
/// Rules: CMD-1, HTTP-19
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn fields_follow_from_the_table_of_parameters() {
    in_a_browser("parameters.mjs");
}

/// The front page by mouse and by keys: sessions are begun, renamed, duplicated, archived, brought back and deleted; links lead
/// to the session that they name, or here; pictures are drawn of what is in sight, and once.
///
/// Rules: HTTP-24, HTTP-32, HTTP-33, HTTP-34, HTTP-35, HTTP-36
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn the_front_page_lists_sessions_and_does_what_is_done_with_them() {
    in_a_browser("front.mjs");
}

/// Where the address has no token the page asks for it, and says where a wrong one is.
///
/// Rules: HTTP-1
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn the_page_asks_for_a_token_that_its_address_lacks() {
    in_a_browser("sign_in.mjs");
}

/// Bends the demo's light in place, and takes it back.
///
/// Rules: CMD-12
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_light_is_bent_in_place_on_the_page() {
    in_a_browser("bend.mjs");
}

/// Drags a control point past the wall at which its tube folds, back, and with radii that follow.
///
/// Rules: CMD-14, GEST-1
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_control_point_slides_on_the_page() {
    in_a_browser("glide.mjs");
}

/// Asks why pixels are lit, pulls a light by its arrows, lays it on surfaces, aims it, and looks through it.
///
/// Rules: PROBE-1, PROBE-2, PROBE-5, GEST-1, SOCK-7
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn lights_are_directed_in_the_picture() {
    in_a_browser("directing.mjs");
}

/// A shadow, some control points, a pinned place and a highlight by the mouse, a hotspot by keys.
///
/// Rules: CMD-15, DRAG-3, DRAG-5, PROBE-6, GEST-1
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn features_are_dragged_and_pinned_on_the_page() {
    in_a_browser("features.mjs");
}

/// The paper's figures: a shadow is bent while its vase looks as it did, and one vase is lit from elsewhere while the other is not.
///
/// Rules: CMD-15, DRAG-1, DRAG-5, REC-7
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn the_papers_figures_are_made_by_the_mouse() {
    in_a_browser("figures.mjs");
}

/// Bends the spotlight of another maker's scene, in a room that holds all of its control points.
///
/// Rules: CMD-12
#[test]
#[ignore = "needs ../shared/assets, the page and a browser: make page test-packages"]
fn a_light_of_shared_assets_is_bent_in_place_on_the_page() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets/scenes/bedroom.glb");
    assert!(Path::new(file).is_file(), "{file} is missing");
    let loaded = assets::load(Path::new(file)).expect("the scene is sound");
    let (low, high) = scene::world_bounds(&loaded.scene).expect("it has a size");
    let bounds = format!("[{:?}, {:?}]", low.to_array(), high.to_array());
    on_a_server_of(file, |address| run_in_browser("bend.mjs", address, MAIN, Some(&bounds)));
}

/// From an empty folder: a file of another maker's is dropped on the front page, its key is bent, a shadow dragged, the page
/// loaded anew, and the work goes on.
///
/// Rules: HTTP-10, CMD-12, CMD-15
#[test]
#[ignore = "needs ../shared/assets, the page and a browser: make page test-packages"]
fn a_file_of_shared_assets_is_lit_by_the_mouse_from_an_empty_folder() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets/scenes/bedroom.glb");
    assert!(Path::new(file).is_file(), "{file} is missing");
    on_a_server(&[], |address| run_in_browser("journey.mjs", address, None, Some(&format!("{file:?}"))));
}

/// Drops a folder and picks files, which become one file that is sent and loaded; cancels one on its way, and reads why others are
/// refused.
///
/// Rules: HTTP-10, HTTP-11
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn scenes_of_ones_own_are_opened_on_the_page() {
    in_a_browser("open_scene.mjs");
}

/// Chooses nodes of the scene that a light leaves out, in their tree and in the picture, and takes them back.
///
/// Rules: LINK-3, HTTP-20, PROBE-1
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn nodes_are_linked_on_the_page() {
    in_a_browser("links.mjs");
}

/// Long names of lights, cameras and people keep their ends on three screens.
///
/// Rules: CMD-8
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn long_names_lose_their_middle() {
    in_a_browser("names.mjs");
}

/// Removes a light with its pins once that is agreed to, and one thing at once.
///
/// Rules: DOC-6
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn trash_asks_where_more_than_one_thing_goes() {
    in_a_browser("removing.mjs");
}

/// Counts colours of what the page shows where a person's system has its own.
///
/// Rules: SOCK-7
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn the_systems_colours_show_all_that_the_pages_own_do() {
    in_a_browser("forced_colors.mjs");
}

/// Asks the server what is seen where each hint points, closes them, and opens another scene.
///
/// Rules: HTTP-22
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn hints_are_on_the_demo_once() {
    in_a_browser("hints.mjs");
}

/// Says on the page how far out a light's edge lies around its axis.
///
/// Rules: CURVE-1
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_curve_over_an_angle_is_edited_on_the_page() {
    in_a_browser("curve.mjs");
}

/// States that are seldom seen, and planted faults.
///
/// Rules: GEST-4
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn nothing_is_faint_or_nameless_in_any_state() {
    in_a_browser("accessibility.mjs");
}

/// Opens the page a dozen times, with its size or its socket late, and compares its pictures with `render`'s: the whole
/// shot is there each time, and the film gate holds what `render` writes on every shape of stage, of every camera.
///
/// Rules: DOC-3, HTTP-8
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn the_page_shows_the_shot_and_its_gate_is_what_render_writes() {
    in_a_browser("gate.mjs");
}

/// Walks every control on six screens, from a phone to a page at 200 %, and moves view and light with fingers.
///
/// Rules: SOCK-7
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn the_page_fits_every_screen_and_fingers() {
    in_a_browser("layouts.mjs");
}

/// Sends a scene, loads it, and reads its name and its notes on the page, by keyboard and after a reload.
///
/// Rules: HTTP-10, SOCK-11
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_scene_has_its_name_on_the_page_and_says_what_is_not_drawn() {
    in_a_browser("scene.mjs");
}

/// Runs a script on a server of its own, which has the demo.
fn in_a_browser(script: &str) {
    on_a_server_of("demo:vases", |address| run_in_browser(script, address, MAIN, None));
}

fn on_a_server_of(scene: &str, test: impl FnOnce(&ServerAddress)) {
    on_a_server(&["--scene", scene], test);
}

fn on_a_server(arguments: &[&str], test: impl FnOnce(&ServerAddress)) {
    let data = tempfile::tempdir().expect("a folder");
    let server = ServerProcess::start(program(), data.path(), arguments).expect("started");
    server.wait_until_ready().expect("ready");
    test(&server.address);
}

/// The view turns about what is pressed and goes to the pointer, and a reload keeps it; fields reckon, and say what they do not take.
///
/// Rules: SOCK-7, HTTP-22
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn the_view_follows_the_pointer_and_survives_a_reload() {
    in_a_browser("view.mjs");
}
