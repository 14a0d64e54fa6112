//! Position of highlights before a drag.

use drag::{DragStatus, Feature, highlight_near};
use glam::DVec2;
use light::CheckedLight;

use crate::support::{TestScene, scenes, trials};

/// Measures the angle between the arriving light and the mirror direction at a pixel, in radians. `None` outside the
/// light.
fn off(scene: &TestScene, light: &CheckedLight, pixel: DVec2) -> Option<f64> {
    let (seen, point) = scene.tube_point(light, pixel)?;
    Some(point.direction.angle_between(seen.mirror_direction()))
}

/// A dragged highlight is found at its new position, from a few pixels beside it.
///
/// Rules: PROBE-6, DRAG-1
#[test]
fn a_highlight_is_found_from_beside_it() {
    let (mut landed, mut found, mut turned_beside) = (0, 0, 0);
    for scene in scenes() {
        for trial in trials(&scene, Feature::Highlight, 40) {
            let result = scene.run(&trial);
            if result.outcome.status != DragStatus::Landed {
                continue;
            }
            landed += 1;
            let light = CheckedLight::new(result.light).expect("it landed");
            let beside = trial.drag.to + DVec2::new(2.0, -1.0);
            let Some(centre) = highlight_near(&scene.bvh, &trial.drag.view, &light, beside) else { continue };
            // Newton's steps end at 1e-9 radians, or at 1e-9 pixels where the direction turns by less than a radian per
            // pixel.
            let off = |pixel| off(&scene, &light, pixel);
            assert!(off(centre).is_none_or(|off| off < 1e-6), "{}: {:?}", scene.name, off(centre));
            turned_beside += usize::from(off(beside).is_none_or(|off| off > 1e-4));
            found += usize::from(centre.distance(trial.drag.to) <= 0.6);
        }
    }
    println!("{landed} landed, {found} were found from beside");
    // Two pixels beside it may be another facet or node, such as a leaf or a spoke. Those do not count.
    assert!(landed >= 20 && 3 * found >= 2 * landed, "{found} of {landed}");
    assert!(10 * turned_beside >= 8 * found, "the planted fault: beside it light does not arrive so");
}
