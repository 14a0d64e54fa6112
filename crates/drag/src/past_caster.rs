//! Control points past the caster of a dragged shadow.

use glam::DVec3;
use light::Tube;

use crate::pins::points_of_node;
use crate::request::{Drag, DragRefusal};
use crate::start::DragStart;

/// Room past the caster that a drag by the control points there takes, as a factor of the way across the light:
/// `0.97 D^2 / 2R` of the arc `D` between caster and shadow and the light's radius `R` is as far as a tube bends.
const ROOM_FACTOR: f64 = 0.97 / 2.0;

/// Intervals in which an arc of the curve is measured.
const ARC_INTERVALS: u32 = 32;

/// Returns the first control point that changes no light path before the end of the caster of a dragged shadow.
pub(crate) fn first_point_past_caster(start: &DragStart, drag: &Drag) -> Result<usize, DragRefusal> {
    let DragStart { occlusion, light, placed, from, to, coords, caster, .. } = start;
    let tube = light.tube().ok_or(DragRefusal::NotBendy)?;
    let caster = caster.ok_or(DragRefusal::NoShadow)?;
    let t_of = |point: DVec3| placed.locate(point, None).map(|coords| coords.t);
    let of_caster = points_of_node(occlusion, &drag.view, caster.node);
    let last = of_caster.into_iter().filter_map(t_of).fold(caster.t, f64::max);
    let to_t = placed.nearest_t(to.position).ok_or(DragRefusal::TooLittleRoom)?;
    let way = to.position - from.position;
    let across = (way - coords.to_light * way.dot(coords.to_light)).length();
    let arc = arc_in_world(tube, last, coords.t);
    let room = ROOM_FACTOR * arc * arc / coords.width;
    // A control point changes its own segment and the two before, of which one has to hold the shadow.
    let first = last.floor() as usize + 3;
    let last_for_shadow = (coords.t.floor() as usize + 2).min(light.light().points().len() - 1);
    let has_room = coords.t > last && to_t > last && room >= across && first <= last_for_shadow;
    has_room.then_some(first).ok_or(DragRefusal::TooLittleRoom)
}

/// Returns the length of a tube's axis between two `t`, in world units.
fn arc_in_world(tube: &Tube<f64>, from: f64, to: f64) -> f64 {
    let at = |part: u32| {
        let (segment, u) = tube.segment_at(from + (to - from) * f64::from(part) / f64::from(ARC_INTERVALS));
        tube.segments[segment].curve.position(u)
    };
    let chords = (0..ARC_INTERVALS).map(|part| at(part).distance(at(part + 1)));
    chords.sum::<f64>() * tube.placement.world_per_tube
}
