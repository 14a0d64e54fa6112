//! Edits in pixels.

use protocol::{ClientMessage, Scope};

use crate::sessions::support::{Server, move_point, moved, pixels};

/// Rules: FRAME-1, UNDO-4, HTTP-8
#[test]
fn a_bent_light_shows_and_its_undo_gives_the_same_pixels_back() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    ada.open_view();
    let start = ada.seq;
    let before = ada.settled(start);
    let light = ada.light();
    let bent =
        ada.edited(move_point(light, 3, moved(ada.point(3), [0.0, 0.0, 0.6]))).seq().expect("committed");
    let after = ada.settled(bent);
    let changed = before.iter().zip(&after).filter(|(a, b)| a.abs_diff(**b) > 16).count();
    assert!(changed > 300, "{changed} of {} values changed visibly", before.len());

    let op_id = ada.op_id();
    ada.send(&ClientMessage::Undo { op_id: op_id.clone(), scope: Scope::Mine });
    let undone = ada.result(&op_id).seq().expect("committed");
    assert!(ada.settled(undone) == before, "the same pixels");

    // The streamed picture equals the one over HTTP, of the current and of the earlier state.
    let http = |at: u64| {
        let path = format!("/sessions/main/render?size=160x90&samples=4&at={at}");
        let answer = server.process.get(&path).expect("answered");
        assert_eq!(answer.status, 200, "{}", answer.text());
        pixels(&answer.body)
    };
    assert!(http(start) == before && http(bent) == after && http(undone) == before);
    assert!(http(start) != http(bent), "the comparison sees a bent light");
}
