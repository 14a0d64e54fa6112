//! Edits in pixels.

use protocol::Scope;

use crate::sessions::support::{Server, ok, pixels};

/// Rules: FRAME-1, UNDO-4, HTTP-8
#[test]
fn a_bent_light_shows_and_its_undo_gives_the_same_pixels_back() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    ada.open_view();
    let start = ada.seq;
    let before = ada.settled(start);
    let bent = ada.shift_point(3, [0.0, 0.0, 0.6]);
    let after = ada.settled(bent);
    let changed = before.iter().zip(&after).filter(|(a, b)| a.abs_diff(**b) > 16).count();
    assert!(changed > 300, "{changed} of {} values changed visibly", before.len());

    let undone = ada.undo(Scope::Mine).seq().expect("committed");
    assert!(ada.settled(undone) == before, "the same pixels");

    // The streamed picture equals the one over HTTP, of the current and of the earlier state.
    let render = |at| server.get(&format!("/sessions/main/render?size=160x90&samples=4&at={at}"));
    let http = |at: u64| pixels(&ok(render(at)).body);
    assert!(http(start) == before && http(bent) == after && http(undone) == before);
    assert!(http(start) != http(bent), "the comparison sees a bent light");
}
