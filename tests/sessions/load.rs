//! Many requests at once, and the memory that remains after them.

use std::net::TcpStream;
use std::time::Duration;

use bench::stills;
use serde_json::json;

use crate::program::program;
use crate::sessions::support::{Mirror, Server, begin_request, wait_until};

/// A still of 2048 x 2048 pixels takes a hundred times as long as a frame of this drag. With one sample of a whole
/// still as the smallest piece of work, eight stills left the drag less than a tenth of its frames, with gaps of a
/// whole still. (`bendylights bench session --stills 8` measures this at full size, and the schedule has tests of its
/// own. Other tests share the machine with this one and stop it for tenths of a second, hence the wide margins.)
///
/// Rules: HTTP-8
#[test]
fn a_drag_goes_on_beside_eight_stills() {
    let options = stills::StillsBenchOptions {
        view: [320, 180],
        drag: Duration::from_secs(5),
        stills: 8,
        still: [2048, 2048],
        samples: 1,
        backend: None,
    };
    let report = stills::run(program(), &options).expect("measured");
    println!("{report:#?}");
    let alone = report.alone.iter().map(|pace| pace.frames_per_second).fold(f64::INFINITY, f64::min);
    assert!(report.beside.frames_per_second > 0.5 * alone, "{report:#?}");
    let still_ms = 1e3 * report.all_finished_s / options.stills as f64;
    assert!(report.beside.longest_gap_ms < 0.5 * still_ms, "{report:#?}");
    assert!(report.least_turns > 0.0 && report.finished_early == 0, "{report:#?}");
}

/// Bytes that the renderer holds.
fn kept(server: &Server, kind: &str) -> f64 {
    server.metric("render_bytes", kind)
}

/// Waits until `enough` accepts the bytes that the renderer holds. Returns them.
fn wait_until_kept(server: &Server, kind: &str, enough: impl Fn(f64) -> bool) -> f64 {
    let mut bytes = 0.0;
    wait_until(&format!("the expected bytes of {kind:?}"), || {
        bytes = kept(server, kind);
        enough(bytes)
    });
    bytes
}

/// Resident memory of the server's process.
fn resident_bytes(server: &Server) -> f64 {
    let statm = std::fs::read_to_string(format!("/proc/{}/statm", server.pid())).expect("it runs");
    let pages: f64 = statm.split(' ').nth(1).and_then(|pages| pages.parse().ok()).expect("a number");
    4096.0 * pages
}

fn see(mirror: &mut Mirror, size: [u32; 2]) {
    mirror.open_view_of(size, None);
    mirror.frame(|_| true);
}

/// Rules: HTTP-9
#[test]
fn views_that_close_free_their_memory() {
    let server = Server::start_process();
    // Memory that stays with the scene.
    see(&mut server.connect("first"), [160, 90]);
    wait_until_kept(&server, "views", |bytes| bytes == 0.0);
    let (before, resident_before) = (kept(&server, ""), resident_bytes(&server));
    assert!(before > 0.0 && before < server.metric("render_bytes_budget", ""));

    let mut clients: Vec<Mirror> = (0..4).map(|k| server.connect(&format!("client-{k}"))).collect();
    for client in &mut clients {
        see(client, [1600, 900]);
    }
    // 44 bytes per pixel if the GPU shades. If the processor does, 52 for the surfaces, which fill the picture.
    let a_pixel = kept(&server, "views") / (4.0 * 1600.0 * 900.0);
    assert!([44.0, 52.0].contains(&a_pixel), "{a_pixel} bytes a pixel");
    assert!(kept(&server, "shadow_maps") > 0.0);
    let resident_full = resident_bytes(&server);
    drop(clients);
    wait_until_kept(&server, "", |bytes| bytes <= before);
    // With a software driver it is memory of the process that is freed.
    let grown = resident_full - resident_before;
    let left = resident_bytes(&server) - resident_before;
    assert!(grown < 1e8 || left < 0.5 * grown, "{left} of {grown} bytes stay");
}

/// Rules: HTTP-9
#[test]
fn stills_that_are_given_up_free_their_memory() {
    let server = Server::start_process();
    assert_eq!(server.get("/sessions/main/render?size=64x36").status, 200);
    let before = wait_until_kept(&server, "tiled", |bytes| bytes == 0.0) + kept(&server, "");
    for _ in 0..3 {
        drop(begin_stills(&server));
        wait_until_kept(&server, "", |bytes| bytes <= before);
    }
}

/// Rules: HTTP-27
#[test]
fn a_session_leaves_stills_to_others() {
    let server = Server::start_process();
    let small = |session| server.get(&format!("/sessions/{session}/render?size=64x36"));
    assert_eq!(small("main").status, 200);
    let stills = begin_stills(&server);
    let refused = small("main");
    assert_eq!((refused.status, refused.text().contains("the session has 4 pictures")), (429, true));
    assert_eq!(server.post("/sessions", &json!({"name": "other", "scene": "demo:vases"})).status, 201);
    assert_eq!(small("other").status, 200);
    drop(stills);
}

/// Begins four large stills, on connections that can be closed, and waits until all are drawn: each has 4 bytes per
/// pixel for finished pixels, and a tile.
fn begin_stills(server: &Server) -> [TcpStream; 4] {
    let path = "/sessions/main/render?size=4096x4096&samples=16";
    let stills = std::array::from_fn(|_| begin_request(&server.address, "GET", path, ""));
    wait_until_kept(server, "tiled", |bytes| bytes > 4.0 * 4.0 * 4096.0 * 4096.0);
    stills
}
