//! Tests the page in a real browser, on a real server.

use bench::ServerAddress;

use crate::browser::run_in_browser;
use crate::pictures::shared_asset;
use crate::processes::serve;
use crate::sessions::support::DEMO;

/// Session of a server that was started with a scene.
const MAIN: Option<&str> = Some("main");

/// Makes a test of each script, in a browser, on a server of its own with the demo.
macro_rules! page_tests {
    ($($(#[$doc:meta])* $name:ident: $script:literal,)*) => {$(
        $(#[$doc])*
        #[test]
        #[ignore = "needs the page and a browser: make page test-packages"]
        fn $name() {
            on_a_server(DEMO, |address| run_in_browser($script, address, MAIN, None));
        }
    )*};
}

page_tests! {
    /// Drags a control point in one page while a second one watches, undoes the drag, and compares pixels.
    ///
    /// Rules: SOCK-3, FRAME-1, FRAME-2, FRAME-4, UNDO-1
    a_drag_in_one_page_shows_in_both_and_undo_restores_the_pixels: "session.mjs",

    /// Pictures of a drag may be reduced. The page shows them at full size, says that they are reduced, and keeps them
    /// full if the user wants that.
    ///
    /// Rules: FRAME-10
    a_drag_holds_its_rate_and_says_what_that_costs: "holding.mjs",

    /// Every panel: lights, parameters, control points, cameras, views, people.
    ///
    /// Rules: SOCK-7, SOCK-8, GEST-1
    every_control_does_what_it_says: "controls.mjs",

    /// View, handles and fields by keys; key presses within a second are one record.
    ///
    /// Rules: SOCK-7, GEST-1
    all_can_be_done_by_keys: "keyboard.mjs",

    /// Exposure and solo are private to a viewer; mute and copies are not; new lights and formats.
    ///
    /// Rules: SOCK-7, SOCK-12, HTTP-21
    private_settings_stay_private_and_lights_are_muted_and_added: "own_view.mjs",

    /// Defaults can be restored, fields without effect are hidden, an unknown parameter is a field, and the page
    /// reports a missing table.
    ///
    /// Rules: CMD-1, HTTP-19
    fields_follow_from_the_table_of_parameters: "parameters.mjs",

    /// The front page by mouse and by keys: sessions are created, renamed, duplicated, archived, restored and deleted.
    /// Links lead to the session that they name, or to the front page. Pictures are drawn only for visible sessions,
    /// and once.
    ///
    /// Rules: HTTP-24, HTTP-32, HTTP-33, HTTP-34, HTTP-35, HTTP-36
    the_front_page_lists_sessions_and_does_what_is_done_with_them: "front.mjs",

    /// The page asks for the token if the address has none, and reports a wrong one.
    ///
    /// Rules: HTTP-1
    the_page_asks_for_a_token_that_its_address_lacks: "sign_in.mjs",

    /// Bends the demo's light in place, and undoes it.
    ///
    /// Rules: CMD-12
    a_light_is_bent_in_place_on_the_page: "bend.mjs",

    /// Drags a control point past the limit at which its tube folds, back, and with radii that follow.
    ///
    /// Rules: CMD-14, GEST-1
    a_control_point_slides_on_the_page: "glide.mjs",

    /// Probes pixels, moves a light by its arrows, places it on surfaces, aims it, and looks through it.
    ///
    /// Rules: PROBE-1, PROBE-2, PROBE-5, GEST-1, SOCK-7
    lights_are_directed_in_the_picture: "directing.mjs",

    /// Drags a shadow, some control points, a pinned point and a highlight by mouse, and a hotspot by keys.
    ///
    /// Rules: CMD-15, DRAG-3, DRAG-5, PROBE-6, GEST-1
    features_are_dragged_and_pinned_on_the_page: "features.mjs",

    /// The paper's figures: a shadow is bent while its vase looks the same, and one vase is lit from another side while
    /// the other is not.
    ///
    /// Rules: CMD-15, DRAG-1, DRAG-5, REC-7
    the_papers_figures_are_made_by_the_mouse: "figures.mjs",

    /// Drops a folder and selects files, which become one file that is sent and loaded; cancels one upload, and reads
    /// the reasons of refusals.
    ///
    /// Rules: HTTP-10, HTTP-11
    scenes_of_ones_own_are_opened_on_the_page: "open_scene.mjs",

    /// Selects nodes of the scene that a light excludes, in their tree and in the picture, and includes them again.
    ///
    /// Rules: LINK-3, HTTP-20, PROBE-1
    nodes_are_linked_on_the_page: "links.mjs",

    /// Long names of lights, cameras and people keep their ends, on three screen sizes.
    ///
    /// Rules: CMD-8
    long_names_lose_their_middle: "names.mjs",

    /// Removes a light with its pins after a confirmation, and a single thing without one.
    ///
    /// Rules: DOC-6
    trash_asks_where_more_than_one_thing_goes: "removing.mjs",

    /// Counts colors of the page if the system has its own colors.
    ///
    /// Rules: SOCK-7
    the_systems_colours_show_all_that_the_pages_own_do: "forced_colors.mjs",

    /// Asks the server for the surface that each hint points at, closes the hints, and opens another scene.
    ///
    /// Rules: HTTP-22
    hints_are_on_the_demo_once: "hints.mjs",

    /// Sets the distance of a light's edge around its axis on the page.
    ///
    /// Rules: CURVE-1
    a_curve_over_an_angle_is_edited_on_the_page: "curve.mjs",

    /// Rare states, and planted faults.
    ///
    /// Rules: GEST-4
    nothing_is_faint_or_nameless_in_any_state: "accessibility.mjs",

    /// Opens the page a dozen times, with a delayed size or socket, and compares its pictures with those of `render`:
    /// the whole shot is visible each time, and the film gate contains what `render` writes, for every aspect ratio of
    /// the stage and every camera.
    ///
    /// Rules: DOC-3, HTTP-8
    the_page_shows_the_shot_and_its_gate_is_what_render_writes: "gate.mjs",

    /// Visits every control on six screens, from a phone to a page at 200 %, and moves view and light by touch.
    ///
    /// Rules: SOCK-7
    the_page_fits_every_screen_and_fingers: "layouts.mjs",

    /// Uploads a scene, loads it, and reads its name and its notes on the page, by keyboard and after a reload.
    ///
    /// Rules: HTTP-10, SOCK-11
    a_scene_has_its_name_on_the_page_and_says_what_is_not_drawn: "scene.mjs",

    /// The view orbits about the pressed point and zooms to the pointer, and a reload keeps it. Fields calculate, and
    /// report input that they do not accept.
    ///
    /// Rules: SOCK-7, HTTP-22
    the_view_follows_the_pointer_and_survives_a_reload: "view.mjs",
}

/// Bends the spotlight of another author's scene, in a room that contains all of its control points.
///
/// Rules: CMD-12
#[test]
#[ignore = "needs ../shared/assets, the page and a browser: make page test-packages"]
fn a_light_of_shared_assets_is_bent_in_place_on_the_page() {
    let file = shared_asset("scenes/bedroom.glb");
    let loaded = assets::load(&file).expect("the scene is sound");
    let (low, high) = scene::world_bounds(&loaded.scene).expect("it has a size");
    let bounds = format!("[{:?}, {:?}]", low.to_array(), high.to_array());
    on_a_server(&["--scene", &file.display().to_string()], |address| {
        run_in_browser("bend.mjs", address, MAIN, Some(&bounds));
    });
}

/// From an empty folder: drops a file of another author on the front page, bends its key light, drags a shadow, reloads
/// the page, and continues.
///
/// Rules: HTTP-10, CMD-12, CMD-15
#[test]
#[ignore = "needs ../shared/assets, the page and a browser: make page test-packages"]
fn a_file_of_shared_assets_is_lit_by_the_mouse_from_an_empty_folder() {
    let file = shared_asset("scenes/bedroom.glb").display().to_string();
    on_a_server(&[], |address| run_in_browser("journey.mjs", address, None, Some(&format!("{file:?}"))));
}

fn on_a_server(arguments: &[&str], test: impl FnOnce(&ServerAddress)) {
    let data = tempfile::tempdir().expect("a folder");
    test(&serve(data.path(), arguments).address);
}
