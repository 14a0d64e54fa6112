//! Tests that the slow solver, against which others are measured, finds existing solutions and nothing else.

use bench::drag::{EquationError, FEATURES, Trial, TrialKind, TrialScene};
use light::CheckedLight;

use super::relaxed::nearest_coords;
use super::slow::{FoundLight, feasible};

fn demo() -> TrialScene {
    let demo = assets::demo("vases").expect("it is one of the demos");
    TrialScene::new("demo:vases", demo.scene, &demo.contents.cameras, [320, 180])
}

fn trials(stage: &TrialScene, deforms: bool) -> impl Iterator<Item = Trial> + '_ {
    let kinds = FEATURES.map(|feature| TrialKind { feature, deforms, is_large: false });
    kinds.into_iter().flat_map(move |kind| {
        (0..6).filter_map(move |number| Trial::random(stage, kind, Trial::seed(3, &stage.name, kind, number)))
    })
}

/// A light that moves as a whole can nearly always be placed as needed: a translation moves a hotspot, and a rotation a
/// highlight. A reported solution fulfils the drag's equations, and the light before the drag does not.
#[test]
fn a_light_that_moves_as_a_whole_is_feasible() {
    let stage = demo();
    let all: Vec<_> = trials(&stage, false).collect();
    let mut found = 0;
    for trial in &all {
        let Some(FoundLight { light, .. }) = feasible(&stage, trial, &[], 1) else { continue };
        found += 1;
        let is_landed = |light: &CheckedLight| {
            EquationError::at_target(&stage, trial, light).is_some_and(|off| off.is_landed(trial.kind.feature))
        };
        assert!(is_landed(&light), "{:?}", trial.drag);
        assert!(!is_landed(&trial.light), "{:?}", trial.drag);
        assert_eq!(trial.light.light().points(), light.light().points());
    }
    assert!(found * 10 >= all.len() * 9, "{found} of {}", all.len());
}

/// With dragged control points the others stay equal to the bit, and with no point to move nothing is feasible.
#[test]
fn only_what_is_chosen_moves() {
    let stage = demo();
    let mut found = 0;
    for mut trial in trials(&stage, true) {
        if let Some(FoundLight { light, .. }) = feasible(&stage, &trial, &[], 1) {
            found += 1;
            let chosen = trial.drag.points.as_deref().unwrap_or_default();
            let (before, after) = (trial.light.light(), light.light());
            assert_eq!(before.transform(), after.transform());
            for (index, (before, after)) in before.points().iter().zip(after.points()).enumerate() {
                assert!(chosen.contains(&index) || before == after, "control point {index}");
            }
        }
        trial.drag.points = Some(Vec::new());
        assert!(feasible(&stage, &trial, &[], 1).is_none(), "{:?}", trial.drag);
    }
    assert!(found >= 12, "{found}");
}

/// Inside of a tube the search's coordinates are those of the light's `locate`.
#[test]
fn coordinates_inside_are_the_lights_own() {
    let stage = demo();
    for trial in trials(&stage, true) {
        let seen = stage.seen(trial.drag.to).expect("a surface");
        let place = nearest_coords(trial.light.tube().expect("a tube"), seen.position + stage.origin()).expect("near");
        let own = stage.locate(&trial.light, seen.position).expect("inside");
        let off = (place.across.x - own.v).hypot(place.across.y - own.w) + (place.t - own.t).abs();
        assert!(off < 1e-9 && place.direction.distance(own.direction) < 1e-9, "{off:e}");
    }
}
