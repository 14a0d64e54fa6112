//! Tests that the results of drags keep their bits, and that no drag exceeds its limit of steps.

use document::AssetHash;

use super::{CaseSizes, answers, random, search, stages};

/// SHA-256 of 600 results of version 9 of the solver: lights of at most 8 control points with at most 3 pins.
const OF_VERSION_9: &str = "63debb80420235d8959790d12ff58af1d2f48041be3c7466d51b1743fdaee40a";

/// Limit of steps of the searched drags, and the most steps that one uses between two tests of the limit: a row of the
/// largest matrix.
const MOST: u64 = 20_000_000;
const AT_ONCE: u64 = 4_000_000;

/// Rules: DRAG-2, DRAG-7
#[test]
fn small_drags_keep_their_bits() {
    let stages = stages(1, [640, 360]);
    let text = answers(&stages[..1], CaseSizes::SMALL, 600, 20);
    assert_eq!(AssetHash::of(text.as_bytes()).hex(), OF_VERSION_9);
}

/// Rules: DRAG-7
#[test]
fn the_most_expensive_drags_stay_within_their_bound() {
    let stages = stages(4_000, [640, 360]);
    let found = search(&stages, 160, 3, MOST, || {});
    let most = found.last().expect("a drag");
    println!("{most:?}");
    assert!(most.steps <= MOST + AT_ONCE, "{most:?}");
    // Deliberate fault that the check must detect: with a larger limit some drags take many times as many steps.
    let unbounded = random(&stages, 40, 3, 8 * MOST, || {});
    assert!(unbounded.iter().any(|made| made.steps > 2 * MOST), "nothing to bound");
}
