//! Drags that a limit ends.

use drag::{Drag, DragStatus, Feature};

use crate::support::{self, Trial, trials};

/// A limited drag ends where it can go no farther: of places between its end and the cursor hardly one can be reached.
#[test]
fn limited_drags_end_at_the_last_place_that_lands() {
    let (mut tried, mut reached) = (0, 0);
    for scene in support::scenes() {
        for feature in [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse] {
            for trial in trials(&scene, feature, 24) {
                let outcome = scene.run(&trial).outcome;
                let Drag { from, to, .. } = trial.drag;
                if !matches!(outcome.status, DragStatus::Limited(_)) {
                    continue;
                }
                let share = 1.0 - outcome.residual_px / from.distance(to);
                for part in 1..=5 {
                    let beyond = share + 1.5 / from.distance(to);
                    let to = from.lerp(to, beyond + (1.0 - beyond) * f64::from(part) / 6.0);
                    let drag = Drag { to, ..trial.drag.clone() };
                    tried += 1;
                    reached +=
                        usize::from(scene.run(&Trial { drag, ..trial.clone() }).outcome.status == DragStatus::Landed);
                }
            }
        }
    }
    println!("{reached} of {tried} places beyond a limit can be reached");
    assert!(tried > 50 && 10 * reached <= tried, "{reached} of {tried}");
}
