//! Many pins.

use std::time::Instant;

use drag::{DragPin, DragStatus, NumberedPin, PinKind, PinTarget, drag};
use glam::DVec2;

use crate::support;

/// With 256 pins a step takes about 8 times as long as with 32: their rows have at most as many independent directions
/// as there are unknowns. A solver with a row for each of a pin's three equations takes some 500 times as long.
#[test]
fn many_pins_take_as_long_as_there_are_many() {
    let scene = support::demo();
    let trial = scene.trial_of_the_demo(None);
    let origin = scene.bvh.posed.origin_in_world;
    let at = scene.seen(DVec2::new(150.5, 160.5)).expect("the vase").position + origin;
    for is_hard in [false, true] {
        let pin = DragPin { kind: PinKind::Direction, at: PinTarget::Point(at), caster: None, is_hard };
        let run = |count: usize| {
            let pins = NumberedPin::by_index(vec![pin.clone(); count]);
            let began = Instant::now();
            let result = drag(&scene.bvh, &trial.light, &trial.drag, &pins);
            (began.elapsed().as_secs_f64() / result.outcome.iterations as f64, result)
        };
        let fastest = |count| (0..3).map(|_| run(count).0).fold(f64::INFINITY, f64::min);
        let (few, many) = (fastest(32), fastest(256));
        println!("hard {is_hard}: {few:e} s a step with 32, {many:e} s with 256");
        assert!(many < 24.0 * few, "{few} {many}");
        // Many pins at one point act as one.
        let (one, all) = (run(1).1, run(256).1);
        assert_eq!((one.outcome.status, all.outcome.status), (DragStatus::Landed, DragStatus::Landed), "{all:?}");
        assert_eq!(run(256).1, all);
    }
}
