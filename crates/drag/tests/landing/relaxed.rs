//! A drag names the constraints that gave way, and those alone.

use drag::{Constraint, DragPin, DragStatus, Feature, PinKind, PinTarget, RadiusMode};

use crate::support::{self, trials};

/// Radii shrink where the answer says so, and nowhere else. The rest of the picture counts less in few drags.
///
/// Rules: DRAG-3
#[test]
fn radii_shrink_where_the_answer_says_so() {
    let (mut landed, mut narrower, mut by_picture) = (0, 0, 0);
    for scene in support::scenes() {
        let of_all = [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse];
        let all = of_all.into_iter().flat_map(|feature| trials(&scene, feature, 12));
        for mut trial in all {
            let all_points = || (1..trial.light.light().points().len()).collect();
            trial.drag.points = Some(trial.drag.points.unwrap_or_else(all_points));
            trial.drag.radii = RadiusMode::Follow;
            let result = scene.run(&trial);
            if result.outcome.status != DragStatus::Landed {
                assert!(!matches!(result.outcome.status, DragStatus::Refused(_)) || result.outcome.relaxed.is_empty());
                continue;
            }
            let radii = |light: &light::Light| light.points().iter().map(|point| point.radius).collect::<Vec<_>>();
            let shrinks = radii(&result.light) != radii(trial.light.light());
            let says = |constraint| result.outcome.relaxed.contains(&constraint);
            assert!(!shrinks || says(Constraint::Radii), "{:?}", result.outcome);
            assert!(!says(Constraint::SoftPins), "there are none: {:?}", result.outcome);
            landed += 1;
            narrower += usize::from(shrinks);
            by_picture += usize::from(says(Constraint::Picture));
        }
    }
    println!("{landed} landed, {narrower} narrower, {by_picture} by less of the picture");
    assert!(landed > 40 && narrower > 0 && by_picture > 0 && 5 * by_picture < landed);
}

/// Soft pins that the answer names do not count: the light is that of the drag without them.
///
/// Rules: DRAG-5
#[test]
fn soft_pins_that_gave_way_are_named() {
    let scene = support::demo();
    let origin = scene.bvh.posed.origin_in_world;
    let (mut gave_way, mut counted) = (0, 0);
    for feature in [Feature::Shadow, Feature::Highlight, Feature::Diffuse] {
        for mut trial in trials(&scene, feature, 24) {
            let free = scene.run(&trial);
            let to = scene.seen(trial.drag.to).expect("a surface").position + origin;
            let at = PinTarget::Point(to);
            trial.pins = vec![DragPin { kind: PinKind::Direction, at, caster: None, is_hard: false }];
            let soft = scene.run(&trial);
            if soft.outcome.status != DragStatus::Landed {
                continue;
            }
            if soft.outcome.relaxed.contains(&Constraint::SoftPins) {
                assert_eq!(soft.light, free.light);
                gave_way += 1;
            } else {
                counted += usize::from(soft.light != free.light);
            }
        }
    }
    println!("{gave_way} drags without their soft pins, {counted} with them");
    assert!(gave_way > 0 && counted > 10);
}
