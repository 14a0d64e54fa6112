//! The paper's formulas (section 5, eqs 11 to 13), which move a light once and do not check the resulting feature.

use drag::Feature;
use glam::{DQuat, DVec3};
use light::parameters::{ROTATION, TRANSLATION};
use light::{Light, Tube};

use super::stage::TrialScene;
use super::trial::Trial;

/// Rotation about a point in the world, followed by a translation.
#[derive(Clone, Copy, Debug)]
struct Motion {
    pivot_in_world: DVec3,
    rotation: DQuat,
    translation: DVec3,
}

impl Motion {
    fn of(&self, point: DVec3) -> DVec3 {
        self.pivot_in_world + self.rotation * (point - self.pivot_in_world) + self.translation
    }
}

/// Moves the light as the paper does: as a whole, or the chosen control points by the same motion. The result can fold.
/// `None` if a formula has no value.
///
/// The formulas are read as light model, section 7, corrects them: positions in the world, `P_l` the apex of the cone
/// with which the tube begins, parentheses in eq. 12. The paper has no formula for the lit side, so it is eq. 13 with
/// the normal in place of the mirror direction.
pub fn moved(stage: &TrialScene, trial: &Trial) -> Option<Light> {
    let origin = stage.origin();
    let [from, to] = [trial.drag.from, trial.drag.to].map(|pixel| stage.seen(pixel));
    let (from, to) = (from?, to?);
    let (m, m_to) = (from.position + origin, to.position + origin);
    let tube = trial.light.tube()?;
    let apex = apex(tube);
    let motion = match trial.kind.feature {
        Feature::Shadow => {
            let pivot = trial.pivot_in_scene? + origin;
            let apex_to = pivot + (pivot - m_to) * (apex.distance(pivot) / pivot.distance(m));
            Motion { pivot_in_world: apex, rotation: DQuat::IDENTITY, translation: apex_to - apex }
        }
        Feature::Hotspot => {
            let turn = DQuat::from_rotation_arc((m - apex).normalize(), (m_to - apex).normalize());
            Motion { pivot_in_world: apex, rotation: turn, translation: DVec3::ZERO }
        }
        Feature::Highlight | Feature::Diffuse => {
            let has = stage.locate(&trial.light, to.position)?.direction;
            let wanted = if trial.kind.feature == Feature::Diffuse { to.normal } else { to.mirror_direction() };
            Motion { pivot_in_world: m_to, rotation: DQuat::from_rotation_arc(has, wanted), translation: DVec3::ZERO }
        }
    };
    let light = trial.light.light().clone();
    let Some(chosen) = &trial.drag.points else {
        let (translation, rotation) = (light.get(TRANSLATION), light.get(ROTATION));
        return Some(
            light.with(TRANSLATION, motion.of(translation)).with(ROTATION, (motion.rotation * rotation).normalize()),
        );
    };
    let transform = light.transform();
    Some(light.map_points(|index, point| {
        if chosen.contains(&index) {
            let world = motion.of(transform.world_from_local(point.position));
            point.position = transform.rotation.inverse() * (world - transform.translation) / transform.scale;
        }
    }))
}

/// Returns the apex of the cone with which a tube begins, in the world; the source if the tube does not widen.
fn apex(tube: &Tube<f64>) -> DVec3 {
    let first = &tube.segments[0].curve;
    let widening = first.e0 / first.d0.length();
    let back = if widening > 0.0 { first.r0 / widening } else { 0.0 };
    tube.placement.world_from_tube(first.b0 - first.u_hat(0.0) * back)
}
