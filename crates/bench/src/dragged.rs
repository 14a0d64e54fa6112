//! The circular drag of a control point that benchmarks of sessions make.

use glam::DVec3;
use light::{CheckedLight, Light, ParameterOwner, SceneBounds};
use protocol::{Bounds, ClientMessage, Command, Document, PointParameter, State};

use crate::bent::bent_and_spot;
use crate::{BenchError, Client, ServerProcess};

/// Index of the dragged control point. Every BendyLight has a third one.
const DRAGGED_POINT: usize = 2;
/// Radius of the circle as a share of half the diagonal of the scene: a quarter of a unit in `demo:vases`.
const RADIUS_SHARE: f64 = 0.028_513_76;
/// Factors of the radius. The first with which the light does not fold anywhere on the circle is used.
const RADIUS_FACTORS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// Number of positions on the circle of the drag at which the light is checked for folds.
const CHECKED_ANGLES: u32 = 240;

/// A control point and the circle that it is dragged along. The circle begins at the position of the point.
#[derive(Clone, Debug)]
pub(crate) struct DragCircle {
    pub light: u64,
    name: String,
    /// Initial position of the control point, light-local.
    start: DVec3,
    /// Radius of the circle in light-local units.
    radius: f64,
    /// World units per light-local unit.
    scale: f64,
}

impl DragCircle {
    /// Makes the circle for the third control point of the first BendyLight in the client's session.
    pub fn of(client: &Client) -> Result<Self, BenchError> {
        let document = document(client)?;
        let found = document.lights.iter().find_map(|placed| {
            let light = CheckedLight::try_from(placed.light.clone()).ok()?;
            (light.light().owner() == ParameterOwner::Bendy).then_some((placed.id, light))
        });
        let (id, light) = found.ok_or_else(|| BenchError::Refused("its scene has no BendyLight".into()))?;
        Ok(Self::in_light(id, light.light(), reach_of(client.welcome.bounds)))
    }

    fn in_light(id: u64, light: &Light, reach: SceneBounds) -> Self {
        let start = light.points()[DRAGGED_POINT].position;
        let scale = light.transform().scale;
        let of_share = |smaller: f64| Self {
            light: id,
            name: light.name().into(),
            start,
            radius: smaller * RADIUS_SHARE * reach.half_extent.length() / scale,
            scale,
        };
        let [.., least] = RADIUS_FACTORS;
        // If the light folds on every circle, the smallest is used and the server reports the reason.
        RADIUS_FACTORS
            .map(of_share)
            .into_iter()
            .find(|circle| circle.is_fold_free_for(light))
            .unwrap_or(of_share(least))
    }

    /// True if `light` does not fold anywhere on the circle.
    fn is_fold_free_for(&self, light: &Light) -> bool {
        (0..CHECKED_ANGLES).all(|place| {
            let angle = std::f64::consts::TAU * f64::from(place) / f64::from(CHECKED_ANGLES);
            let moved = light.clone().map_points(|index, point| {
                if index == DRAGGED_POINT {
                    point.position = self.at(angle);
                }
            });
            CheckedLight::new(moved).is_ok()
        })
    }

    /// Returns the position of the control point after an angle in radians, light-local.
    fn at(&self, angle: f64) -> DVec3 {
        self.start + self.radius * DVec3::new(angle.sin(), 1.0 - angle.cos(), 0.0)
    }

    /// Returns the command that moves the control point to its position after an angle in radians.
    pub fn command(&self, angle: f64) -> Command {
        let parameter: PointParameter = light::parameters::POSITION.to(self.at(angle)).into();
        Command::SetPoint { light: self.light, point: DRAGGED_POINT, parameter, ignore_pins: false }
    }

    /// Describes the drag in a sentence for reports.
    pub fn what(&self, scene: &str) -> String {
        let Self { name, radius, scale, .. } = self;
        let world = radius * scale;
        format!(
            "control point {DRAGGED_POINT} of `{name}` in {scene}, dragged in a circle of radius {world:.3}, on loopback"
        )
    }
}

/// Ensures that the session `main` has a BendyLight. If it has none, its first light is bent as in the benchmark of
/// frames, and the other lights are removed, as there. Returns true if it changed the session.
pub(crate) fn ensure_bent_light(server: &ServerProcess) -> Result<bool, BenchError> {
    let mut client = Client::connect(&server.address, "main", "bench", None)?;
    let document = document(&client)?.clone();
    let mut lights = Vec::new();
    for placed in document.lights {
        let light = CheckedLight::try_from(placed.light).map_err(|why| BenchError::Refused(why.to_string()))?;
        if light.light().owner() == ParameterOwner::Bendy {
            return Ok(false);
        }
        lights.push((placed.id, light));
    }
    let Some((_, first)) = lights.first() else {
        return Err(BenchError::Refused("its scene has no light".into()));
    };
    let (bent, _) = bent_and_spot(first.light(), reach_of(client.welcome.bounds))?;
    let removed = lights.iter().map(|(id, _)| Command::RemoveLight { light: *id });
    for (number, command) in [Command::AddLight { light: (&bent).into() }].into_iter().chain(removed).enumerate() {
        edit(&mut client, &format!("bench-bend-{number}"), command)?;
    }
    Ok(true)
}

/// Sends an edit and waits for its result.
fn edit(client: &mut Client, op_id: &str, command: Command) -> Result<(), BenchError> {
    let base_seq = client.welcome.seq;
    client.send(&ClientMessage::Edit { op_id: op_id.into(), base_seq, command })?;
    BenchError::check(client.wait_for_edit(|result| result.op_id == op_id)?.outcome.problem())
}

fn document(client: &Client) -> Result<&Document, BenchError> {
    match &client.welcome.state {
        State::Snapshot(document) => Ok(document),
        State::Tail(_) => Err(BenchError::Refused("it gave no document".into())),
    }
}

/// Returns the bounding box of the scene, up to rounding of its corners.
fn reach_of(Bounds { min, max }: Bounds) -> SceneBounds {
    let (min, max) = (DVec3::from_array(min), DVec3::from_array(max));
    SceneBounds { center: min / 2.0 + max / 2.0, half_extent: max / 2.0 - min / 2.0 }
}

#[cfg(test)]
mod tests {
    use light::parameters::{CONE_ANGLE, RANGE, SCALE, TRANSLATION};
    use scene::PosedScene;

    use super::*;

    fn vases() -> (Light, std::sync::Arc<PosedScene>) {
        let loaded = assets::demo("vases").expect("the demo");
        (loaded.contents.lights[0].light().clone(), scene::pose(loaded.scene, 0.0))
    }

    /// The constant `RADIUS_SHARE` is rounded to seven digits.
    #[test]
    fn in_the_vases_the_circle_has_a_radius_of_a_quarter() {
        let (key, posed) = vases();
        let circle = DragCircle::in_light(1, &key, posed.bounds());
        assert!((circle.radius - 0.25).abs() < 0.25 * 1e-6, "{} {}", circle.radius, 0.25 / posed.half_extent.length());
        assert_eq!(circle.at(0.0), circle.start);
        let across = circle.at(std::f64::consts::PI) - circle.start;
        assert!((across - 2.0 * circle.radius * DVec3::Y).length() < 1e-12, "{across}");
    }

    /// The share is one of world units, for any scale of the light.
    #[test]
    fn the_circle_is_the_same_share_of_every_scene() {
        let (key, posed) = vases();
        let circle = DragCircle::in_light(1, &key, posed.bounds());
        let twice = SceneBounds { half_extent: 2.0 * posed.half_extent, ..posed.bounds() };
        let grown = DragCircle::in_light(1, &key.with(SCALE, 4.0), twice);
        assert!((grown.radius * 4.0 - 2.0 * circle.radius).abs() < 1e-12, "{grown:?}");
    }

    #[test]
    fn where_the_light_would_fold_the_circle_is_smaller() {
        let (key, posed) = vases();
        let whole = DragCircle::in_light(1, &key, posed.bounds());
        assert!(whole.is_fold_free_for(&key));
        let tight = key.map_points(|_, point| point.radius *= 1.25);
        assert!(CheckedLight::new(tight.clone()).is_ok());
        assert!(!whole.is_fold_free_for(&tight), "the planted fault is none");
        let found = DragCircle::in_light(1, &tight, posed.bounds());
        assert!(found.radius < whole.radius && found.is_fold_free_for(&tight), "{found:?}");
    }

    /// The box that a client receives equals that of the scene up to rounding, so the session bends the same light as
    /// the frame benchmark.
    #[test]
    fn a_session_bends_the_light_that_frames_are_measured_by() {
        let spot =
            Light::spot().with(TRANSLATION, DVec3::new(1.0, 16.0, 3.0)).with(CONE_ANGLE, 20.0).with(RANGE, Some(9.0));
        let (_, posed) = vases();
        let received = reach_of(Bounds::of(&posed));
        let off = |received: SceneBounds| {
            let bent = |reach| bent_and_spot(&spot, reach).expect("it bends").0;
            let (ours, frames) = (bent(received), bent(posed.bounds()));
            assert_eq!(ours.points().len(), 5, "three segments");
            ours.points()
                .iter()
                .zip(frames.points())
                .map(|(a, b)| (a.position - b.position).length())
                .fold(0.0, f64::max)
        };
        assert!(off(received) < 1e-12, "{}", off(received));
        let planted = SceneBounds { center: received.center + 0.01, ..received };
        assert!(off(planted) > 1e-12, "{}", off(planted));
    }
}
